//! The functions of a set as outputs × inputs: the side with fewer degrees of freedom drives, the
//! other one carries the shape.
//!
//! A mode leaves `A_of = ψ_o L_i` whichever side is called the response, so that a roving hammer
//! with one sensor is the same problem as one hit with many sensors (ties go to the references).
//! Pairs may be missing.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::frf::Function;
use crate::linalg::{self, ComplexMatrix};

/// Functions by output.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Sides {
    /// Number of inputs.
    pub inputs: usize,
    /// Of each output: its functions as (input, number in the set), inputs ascending.
    pub outputs: Vec<Vec<(usize, usize)>>,
}

impl Sides {
    /// Of the functions of a set.
    pub fn new(functions: &[Function]) -> Self {
        let responses: BTreeSet<&Dof> = functions.iter().map(|f| &f.response).collect();
        let references: BTreeSet<&Dof> = functions.iter().map(|f| &f.reference).collect();
        let turned = responses.len() < references.len();
        let numbers = |dofs: BTreeSet<&Dof>| -> BTreeMap<Dof, usize> {
            dofs.into_iter().cloned().zip(0..).collect()
        };
        let (outer, inner) = if turned {
            (numbers(references), numbers(responses))
        } else {
            (numbers(responses), numbers(references))
        };
        let place = |f: &Function| match turned {
            true => (outer[&f.reference], inner[&f.response]),
            false => (outer[&f.response], inner[&f.reference]),
        };
        let mut outputs = vec![Vec::new(); outer.len()];
        for (number, (output, input)) in functions.iter().map(place).enumerate() {
            outputs[output].push((input, number));
        }
        outputs.iter_mut().for_each(|own| own.sort_unstable());
        Self {
            inputs: inner.len(),
            outputs,
        }
    }

    /// Whether every output has every input.
    pub fn complete(&self) -> bool {
        self.outputs.iter().all(|own| own.len() == self.inputs)
    }

    /// A value per function as outputs × inputs, where every output has every input.
    pub fn matrix(&self, value: impl Fn(usize) -> Complex64) -> ComplexMatrix {
        linalg::complex_matrix(self.outputs.len(), self.inputs, |o, i| {
            value(self.outputs[o][i].1)
        })
    }

    /// The same functions as so many outputs of one input.
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
    fn the_side_with_fewer_degrees_of_freedom_drives() {
        let fixed = ["1:+Z", "2:+Z", "3:+Z"].map(|r| function(r, "1:+Z"));
        let sides = Sides::new(&fixed);
        assert_eq!((sides.inputs, sides.outputs.len()), (1, 3));
        let roving = ["1:+Z", "2:+Z", "3:+Z"].map(|r| function("1:+Z", r));
        assert_eq!(Sides::new(&roving), sides);
        let mut two: Vec<Function> = fixed.to_vec();
        two.extend([function("3:+Z", "2:+Z"), function("1:+Z", "2:+Z")]);
        let sides = Sides::new(&two);
        assert_eq!(sides.outputs[0], [(0, 0), (1, 4)]);
        assert_eq!(sides.outputs[1], [(0, 1)]);
        assert!(!sides.complete() && sides.as_one_input().complete());
        assert_eq!(sides.outputs[2], [(0, 2), (1, 3)]);
        assert_eq!(sides.as_one_input().outputs[4], [(0, 4)]);
    }
}
