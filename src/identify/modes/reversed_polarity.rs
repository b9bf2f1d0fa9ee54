//! A function of the wrong sign: it turns every mode that several references see into two.
//!
//! The residues of a single mode, responses × references, are of rank one. With one entry turned
//! they are of rank two, and so they are at all modes; a structure has some repeated roots, seldom
//! half of all. Where turning one function back makes single modes of all of them, that function is
//! named; of two references the response alone, for its whole row turned changes no rank.

use std::collections::HashMap;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;
use crate::linalg::{complex_matrix, singular_values};

use crate::identify::estimator::Candidate;

/// Fewest double roots, and responses of all references, that tell a sign.
const FEWEST_ROOTS: usize = 2;
const FEWEST_RESPONSES: usize = 3;
/// What turning back leaves beside one shape is no more than this share of the residues' power, and
/// of what was there before.
const LEFT: f64 = 0.01;
const OF_BEFORE: f64 = 0.1;

/// The finding of a function that, turned, makes single modes of all double ones; nothing where
/// these are not half of all roots.
pub(in crate::identify) fn turned_function(
    set: &FrfSet,
    candidates: &[Candidate],
) -> Option<Finding> {
    let double = candidates.iter().filter(|own| own.multiplicity == 2);
    let double: Vec<&[Complex64]> = double.filter_map(|own| own.residues.as_deref()).collect();
    if double.len() < FEWEST_ROOTS.max(candidates.len().div_ceil(2)) {
        return None;
    }
    let block = Block::new(set);
    if block.rows.len() < FEWEST_RESPONSES {
        return None;
    }
    let before: Option<Vec<f64>> = double.iter().map(|own| block.beside(own, None)).collect();
    let before = before?;
    let all_single = |function: &usize| {
        let roots = double.iter().zip(&before);
        roots.into_iter().all(|(residues, before)| {
            let after = block.beside(residues, Some(*function));
            after.is_some_and(|after| after < LEFT.min(OF_BEFORE * before))
        })
    };
    let all = block.rows.iter().flatten().copied();
    let found: Vec<usize> = all.filter(all_single).collect();
    let first = &set.functions()[*found.first()?];
    let elsewhere = |i: &usize| set.functions()[*i].response != first.response;
    if found.iter().any(elsewhere) {
        return None;
    }
    let place = Place::Function {
        response: Some(first.response.clone()),
        reference: (found.len() == 1).then(|| first.reference.clone()),
    };
    let finding = Finding::new(Severity::Warning, Code::TurnedFunction, place);
    Some(finding.value(double.len() as f64, "roots"))
}

/// Numbers of the functions by response and reference, of the responses that all references have.
struct Block {
    rows: Vec<Vec<usize>>,
}

impl Block {
    fn new(set: &FrfSet) -> Self {
        let references = set.references();
        let functions = set.functions().iter().enumerate();
        let numbers: HashMap<(&Dof, &Dof), usize> = functions
            .map(|(i, own)| ((&own.response, &own.reference), i))
            .collect();
        let row = |response: &Dof| {
            let number = |reference| numbers.get(&(response, reference)).copied();
            references.iter().map(number).collect()
        };
        Self {
            rows: set.responses().iter().filter_map(row).collect(),
        }
    }

    /// Share of the power of a root's residues beside their first singular vectors, one function
    /// turned.
    fn beside(&self, residues: &[Complex64], turned: Option<usize>) -> Option<f64> {
        let references = self.rows.first()?.len();
        let matrix = complex_matrix(self.rows.len(), references, |row, column| {
            let function = self.rows[row][column];
            let sign = if turned == Some(function) { -1.0 } else { 1.0 };
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

    /// Functions of four responses to hits at so many points, without values.
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

    /// A double root of these two shapes, with the sign of one function turned.
    fn root(shapes: [[f64; 4]; 2], references: usize, turned: Option<usize>) -> Candidate {
        let residue = |function: usize| {
            let (response, reference) = (function / references, function % references);
            let own = shapes
                .iter()
                .map(|shape| shape[response] * shape[reference]);
            let sign = if turned == Some(function) { -1.0 } else { 1.0 };
            Complex64::new(1e-9, sign * own.sum::<f64>())
        };
        Candidate {
            order: None,
            pole: Pole {
                lambda: Complex64::new(-1.0, 100.0),
            },
            participation: None,
            residues: Some((0..4 * references).map(residue).collect()),
            residue_stds: None,
            multiplicity: 2,
            frequency_std_hz: None,
            damping_std: None,
            frequency_damping_correlation: None,
            frequency_bias_hz: None,
            damping_bias: None,
            quality: None,
        }
    }

    const ONE: [f64; 4] = [1.0, 0.7, -0.4, 0.5];
    const OTHER: [f64; 4] = [0.8, -0.6, 0.9, 0.3];
    const NONE: [f64; 4] = [0.0; 4];

    #[test]
    fn the_function_that_doubles_every_mode_is_named() {
        for references in [2, 3] {
            let set = set(references);
            for turned in 0..4 * references {
                let root = |shape| root([shape, NONE], references, Some(turned));
                let told = turned_function(&set, &[ONE, OTHER].map(root));
                let told = told.expect("both roots are double by one sign");
                let function = &set.functions()[turned];
                let expected = Place::Function {
                    response: Some(function.response.clone()),
                    reference: (references > 2).then(|| function.reference.clone()),
                };
                assert_eq!((told.place, told.value), (expected, Some(2.0)));
            }
        }
    }

    #[test]
    fn true_repeated_roots_and_few_double_ones_name_none() {
        let set = set(2);
        let third = [0.2, 0.9, 0.6, -0.7];
        let repeated = [[ONE, OTHER], [OTHER, third]].map(|shapes| root(shapes, 2, None));
        assert_eq!(turned_function(&set, &repeated), None);
        let doubled = |shape| root([shape, NONE], 2, Some(3));
        assert_eq!(turned_function(&set, &[doubled(ONE)]), None);
        let mut single = doubled(third);
        single.multiplicity = 1;
        let mut roots = vec![doubled(ONE), doubled(OTHER)];
        roots.extend(vec![single; 3]);
        assert_eq!(turned_function(&set, &roots), None);
        // One of the double ones is a repeated root by itself.
        let mixed = [doubled(ONE), root([OTHER, third], 2, None)];
        assert_eq!(turned_function(&set, &mixed), None);
    }
}
