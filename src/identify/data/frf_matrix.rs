//! FRF matrix of a set: outputs × inputs, with the smaller dimension as inputs; the outputs carry
//! the mode shape.
//!
//! A residue is `A_oi = ψ_o L_i` with either dimension as response, so that a roving hammer with
//! one sensor is the same problem as one excitation point with many sensors (for equal dimensions
//! the references are the inputs). FRFs may be missing.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::frf::Function;
use crate::linalg::{self, ComplexMatrix};

/// FRFs by output.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct FrfMatrix {
    /// Number of inputs.
    pub inputs: usize,
    /// FRFs of each output as (input, number in the set), inputs ascending.
    pub outputs: Vec<Vec<(usize, usize)>>,
}

impl FrfMatrix {
    /// FRF matrix of the FRFs of a set.
    pub fn new(functions: &[Function]) -> Self {
        let responses: BTreeSet<&Dof> = functions.iter().map(|f| &f.response).collect();
        let references: BTreeSet<&Dof> = functions.iter().map(|f| &f.reference).collect();
        let inputs_are_responses = responses.len() < references.len();
        let numbers = |dofs: BTreeSet<&Dof>| -> BTreeMap<Dof, usize> {
            dofs.into_iter().cloned().zip(0..).collect()
        };
        let (outer, inner) = if inputs_are_responses {
            (numbers(references), numbers(responses))
        } else {
            (numbers(responses), numbers(references))
        };
        let indices = |f: &Function| match inputs_are_responses {
            true => (outer[&f.reference], inner[&f.response]),
            false => (outer[&f.response], inner[&f.reference]),
        };
        let mut outputs = vec![Vec::new(); outer.len()];
        for (number, (output, input)) in functions.iter().map(indices).enumerate() {
            outputs[output].push((input, number));
        }
        outputs.iter_mut().for_each(|frfs| frfs.sort_unstable());
        Self {
            inputs: inner.len(),
            outputs,
        }
    }

    /// Whether the matrix is complete: every output has every input.
    pub fn is_complete(&self) -> bool {
        self.outputs.iter().all(|frfs| frfs.len() == self.inputs)
    }

    /// One value per FRF as a matrix of outputs × inputs; the FRF matrix must be complete.
    pub fn matrix(&self, value: impl Fn(usize) -> Complex64) -> ComplexMatrix {
        linalg::complex_matrix(self.outputs.len(), self.inputs, |o, i| {
            value(self.outputs[o][i].1)
        })
    }

    /// The same FRFs as outputs of one input.
    pub fn as_one_input(&self) -> Self {
        let functions: usize = self.outputs.iter().map(Vec::len).sum();
        Self {
            inputs: 1,
            outputs: (0..functions).map(|number| vec![(0, number)]).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::data::frf_matrix::*;
    use crate::quantity::FrfKind;

    fn function(response: &str, reference: &str) -> Function {
        Function {
            response: response.parse().unwrap(),
            reference: reference.parse().unwrap(),
            kind: FrfKind::Receptance,
            averages: None,
            estimator: None,
            variance_dof: None,
        }
    }

    #[test]
    fn the_smaller_dimension_of_the_frf_matrix_is_the_inputs() {
        let fixed = ["1:+Z", "2:+Z", "3:+Z"].map(|r| function(r, "1:+Z"));
        let frf_matrix = FrfMatrix::new(&fixed);
        assert_eq!((frf_matrix.inputs, frf_matrix.outputs.len()), (1, 3));
        let roving = ["1:+Z", "2:+Z", "3:+Z"].map(|r| function("1:+Z", r));
        assert_eq!(FrfMatrix::new(&roving), frf_matrix);
        let mut two: Vec<Function> = fixed.to_vec();
        two.extend([function("3:+Z", "2:+Z"), function("1:+Z", "2:+Z")]);
        let frf_matrix = FrfMatrix::new(&two);
        assert_eq!(frf_matrix.outputs[0], [(0, 0), (1, 4)]);
        assert_eq!(frf_matrix.outputs[1], [(0, 1)]);
        assert!(!frf_matrix.is_complete() && frf_matrix.as_one_input().is_complete());
        assert_eq!(frf_matrix.outputs[2], [(0, 2), (1, 3)]);
        assert_eq!(frf_matrix.as_one_input().outputs[4], [(0, 4)]);
    }
}
