//! A sign-reversed FRF, in data of several references, makes every single mode look like a repeated
//! pole.
//!
//! The residue matrix of a single mode, responses × references, is of rank one. With the sign of
//! one entry reversed it is of rank two, at all modes; a structure has few repeated poles, seldom
//! half of all. Where reversing one FRF again makes single modes of all double poles, a finding
//! names that FRF. With two references it names only the response, because reversing its whole row
//! changes no rank.

use std::collections::HashMap;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::linalg::{complex_matrix, singular_values};

use crate::identify::estimator::Candidate;

/// Minimum number of double poles, and of responses with all references, for a test of signs.
const MIN_DOUBLE_POLES: usize = 2;
const MIN_RESPONSES: usize = 3;
/// Maximum power beyond the first shape after the reversal, over the power of the residues, and
/// over the same power before.
const MAX_REMAINING_FRACTION: f64 = 0.01;
const MAX_REMAINING_OVER_INITIAL: f64 = 0.1;

/// The finding of an FRF whose reversal makes single modes of all double poles; `None` where these
/// are fewer than half of all poles.
pub(in crate::identify) fn sign_reversed_frf(
    set: &FrfSet,
    candidates: &[Candidate],
) -> Option<Finding> {
    let double = candidates
        .iter()
        .filter(|candidate| candidate.multiplicity == 2);
    let double: Vec<&[Complex64]> = double
        .filter_map(|candidate| candidate.residues.as_deref())
        .collect();
    if double.len() < MIN_DOUBLE_POLES.max(candidates.len().div_ceil(2)) {
        return None;
    }
    let table = FunctionTable::new(set);
    if table.rows.len() < MIN_RESPONSES {
        return None;
    }
    let initial: Option<Vec<f64>> = double
        .iter()
        .map(|residues| table.power_beyond_first_shape(residues, None))
        .collect();
    let initial = initial?;
    let all_single = |function: &usize| {
        let poles = double.iter().zip(&initial);
        poles.into_iter().all(|(residues, initial)| {
            let remaining = table.power_beyond_first_shape(residues, Some(*function));
            remaining.is_some_and(|remaining| {
                remaining < MAX_REMAINING_FRACTION.min(MAX_REMAINING_OVER_INITIAL * initial)
            })
        })
    };
    let all = table.rows.iter().flatten().copied();
    let found: Vec<usize> = all.filter(all_single).collect();
    let first = &set.functions()[*found.first()?];
    let elsewhere = |i: &usize| set.functions()[*i].response != first.response;
    if found.iter().any(elsewhere) {
        return None;
    }
    let location = Location::Function {
        response: Some(first.response.clone()),
        reference: (found.len() == 1).then(|| first.reference.clone()),
    };
    let finding = Finding::new(Severity::Warning, Code::TurnedFunction, location);
    Some(finding.value(double.len() as f64, "roots"))
}

/// Indices of the FRFs by response and reference, of the responses that all references have.
struct FunctionTable {
    rows: Vec<Vec<usize>>,
}

impl FunctionTable {
    fn new(set: &FrfSet) -> Self {
        let references = set.references();
        let functions = set.functions().iter().enumerate();
        let numbers: HashMap<(&Dof, &Dof), usize> = functions
            .map(|(i, function)| ((&function.response, &function.reference), i))
            .collect();
        let row = |response: &Dof| {
            let number = |reference| numbers.get(&(response, reference)).copied();
            references.iter().map(number).collect()
        };
        Self {
            rows: set.responses().iter().filter_map(row).collect(),
        }
    }

    /// Fraction of the power of the residues of a pole beyond their first singular vectors, with
    /// the sign of one FRF reversed.
    fn power_beyond_first_shape(
        &self,
        residues: &[Complex64],
        reversed: Option<usize>,
    ) -> Option<f64> {
        let references = self.rows.first()?.len();
        let matrix = complex_matrix(self.rows.len(), references, |row, column| {
            let function = self.rows[row][column];
            let sign = if reversed == Some(function) {
                -1.0
            } else {
                1.0
            };
            sign * residues[function]
        });
        let powers = singular_values(&matrix).ok()?;
        let powers: Vec<f64> = powers.iter().map(|value| value * value).collect();
        let all: f64 = powers.iter().sum();
        (all > 0.0).then(|| 1.0 - powers.first().copied().unwrap_or(0.0) / all)
    }
}

#[cfg(test)]
mod tests {
    use crate::axis::FrequencyAxis;
    use crate::frf::{Function, FunctionData};
    use crate::identify::modes::reversed_polarity::*;
    use crate::modal::Pole;
    use crate::quantity::FrfKind;

    /// FRFs of four responses to hits at a number of points, without values.
    fn set(references: usize) -> FrfSet {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 1.0,
            len: 1,
        };
        let mut set = FrfSet::new(axis);
        for response in 1..=4 {
            for reference in 1..=references {
                let dof = |point: usize| format!("{point}:+Z").parse().expect("a point");
                let function = Function {
                    response: dof(response),
                    reference: dof(reference),
                    kind: FrfKind::Receptance,
                    averages: None,
                    estimator: None,
                    variance_dof: None,
                };
                let data = FunctionData {
                    values: vec![Complex64::ONE],
                    ..FunctionData::default()
                };
                set.push(function, data).expect("functions that differ");
            }
        }
        set
    }

    /// A double pole of these two shapes, with the sign of one FRF reversed.
    fn root(shapes: [[f64; 4]; 2], references: usize, reversed: Option<usize>) -> Candidate {
        let residue = |function: usize| {
            let (response, reference) = (function / references, function % references);
            let products = shapes
                .iter()
                .map(|shape| shape[response] * shape[reference]);
            let sign = if reversed == Some(function) {
                -1.0
            } else {
                1.0
            };
            Complex64::new(1e-9, sign * products.sum::<f64>())
        };
        Candidate {
            residues: Some((0..4 * references).map(residue).collect()),
            multiplicity: 2,
            ..Candidate::new(Pole {
                lambda: Complex64::new(-1.0, 100.0),
            })
        }
    }

    const ONE: [f64; 4] = [1.0, 0.7, -0.4, 0.5];
    const OTHER: [f64; 4] = [0.8, -0.6, 0.9, 0.3];
    const NONE: [f64; 4] = [0.0; 4];

    #[test]
    fn sign_reversed_frf_is_reported() {
        for references in [2, 3] {
            let set = set(references);
            for reversed in 0..4 * references {
                let root = |shape| root([shape, NONE], references, Some(reversed));
                let finding = sign_reversed_frf(&set, &[ONE, OTHER].map(root));
                let finding = finding.expect("both roots are double by one sign");
                let function = &set.functions()[reversed];
                let expected = Location::Function {
                    response: Some(function.response.clone()),
                    reference: (references > 2).then(|| function.reference.clone()),
                };
                assert_eq!((finding.location, finding.value), (expected, Some(2.0)));
            }
        }
    }

    #[test]
    fn true_repeated_poles_and_few_double_poles_report_no_sign_reversal() {
        let set = set(2);
        let third = [0.2, 0.9, 0.6, -0.7];
        let repeated = [[ONE, OTHER], [OTHER, third]].map(|shapes| root(shapes, 2, None));
        assert_eq!(sign_reversed_frf(&set, &repeated), None);
        let doubled = |shape| root([shape, NONE], 2, Some(3));
        assert_eq!(sign_reversed_frf(&set, &[doubled(ONE)]), None);
        let mut single = doubled(third);
        single.multiplicity = 1;
        let mut roots = vec![doubled(ONE), doubled(OTHER)];
        roots.extend(vec![single; 3]);
        assert_eq!(sign_reversed_frf(&set, &roots), None);
        // One of the double poles is a true repeated pole.
        let mixed = [doubled(ONE), root([OTHER, third], 2, None)];
        assert_eq!(sign_reversed_frf(&set, &mixed), None);
    }
}
