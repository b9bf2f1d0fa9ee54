//! Alternatives are other optima of about the same objective, those of the other starts and those
//! that the symmetry of the model gives. A parameter that differs between them is ambiguous.
//!
//! Two parameters whose derivatives of all measured frequencies are equal at the start are images
//! of each other: frequencies alone cannot tell which of them changed. From the best optimum their
//! values are exchanged, all such pairs together and each alone, and the problem is solved from
//! there.

use serde::{Deserialize, Serialize};

use crate::linalg::RealMatrix;
use crate::theory::TheoryModes;

use super::configuration::Part;
use super::model_error::frequency_rows;
use super::model_state::ModelState;
use super::trust_region::{Solution, solve_from};
use super::{Evaluation, UpdateError, UpdateProblem};

/// Largest difference of the objective between alternatives: the posterior density of the worse one
/// is a hundredth, `exp(-9.21/2)`.
///
/// Larger (18.4): 40 of 301 parameters from frequencies alone are ambiguous in place of 17; four of
/// these 23 were wrong, the others right. Smaller (4.6): 13 are, none of them wrong. Test:
/// `verdicts_on_parameters_have_grounds` of the population, as for the limits below.
pub(super) const MAX_OBJECTIVE_DIFFERENCE: f64 = 9.21;
/// Smallest difference of a parameter between alternatives, in posterior deviations: its 95 %
/// interval does not hold the other value.
pub(super) const MIN_DIFFERENCE_STDS: f64 = 1.0;
/// Largest difference between the derivatives of parameters that are images of each other, over
/// the larger of them.
const MAX_IMAGE_DIFFERENCE: f64 = 0.05;
/// Largest number of exchanges that are tried.
const MAX_EXCHANGES: usize = 60;

/// Another optimum of about the same objective.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// Its objective less that of the best optimum.
    pub objective_difference: f64,
    /// Values of the free parameters.
    pub values: Vec<f64>,
    /// What differs most between the two models; `None` where all modes are alike.
    pub separation: Option<Separation>,
}

/// A mode of the model that differs between two optima.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Separation {
    /// Configuration of the model, where there are several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// Number of the mode at the best optimum, from 1.
    pub mode: usize,
    /// Its frequency there, Hz.
    pub hz: f64,
    /// Its frequency at the alternative, Hz.
    pub other_hz: f64,
    /// MAC of its two shapes over all coordinates of the model.
    pub mac: f64,
}

/// The alternatives to an optimum; `ends` are those of the other starts, `stds` the posterior
/// deviations of `z`.
///
/// # Errors
/// As [`solve_from`].
pub(super) fn alternatives(
    problem: &UpdateProblem<'_>,
    best: &Solution,
    ends: &[Vec<f64>],
    stds: &[f64],
) -> Result<Vec<(Alternative, Vec<f64>)>, UpdateError> {
    let differs = |a: &[f64], b: &[f64]| {
        let mut parameters = a.iter().zip(b).zip(stds);
        parameters.any(|((a, b), std)| (a - b).abs() > MIN_DIFFERENCE_STDS * std)
    };
    let mut starts = ends.to_vec();
    starts.extend(exchanged(problem, &best.at.z)?);
    let mut found: Vec<(Alternative, Vec<f64>)> = Vec::new();
    for z in starts {
        let is_known = |found: &[(Alternative, Vec<f64>)], z: &[f64]| {
            let others = found.iter().map(|(_, z)| z.as_slice());
            let mut known = others.chain([best.at.z.as_slice()]);
            known.any(|known| !differs(known, z))
        };
        if is_known(&found, &z) {
            continue;
        }
        let solved = problem.start(&z).and_then(|at| solve_from(problem, at));
        let solution = match solved {
            Ok(solution) => solution,
            Err(UpdateError::Theory(_) | UpdateError::Derivative { .. }) => continue,
            Err(error) => return Err(error),
        };
        let objective_difference = solution.at.objective() - best.at.objective();
        if objective_difference > MAX_OBJECTIVE_DIFFERENCE || is_known(&found, &solution.at.z) {
            continue;
        }
        let free = problem.free.iter().zip(&solution.at.z);
        let alternative = Alternative {
            objective_difference,
            values: free.map(|(free, z)| free.value(*z)).collect(),
            separation: separation(problem, &best.at, &solution.at),
        };
        found.push((alternative, solution.at.z));
    }
    Ok(found)
}

/// Points with the values of images exchanged, of parameters of one unit.
fn exchanged(problem: &UpdateProblem<'_>, z: &[f64]) -> Result<Vec<Vec<f64>>, UpdateError> {
    let n = problem.free.len();
    let at = problem.start(&vec![0.0; n])?;
    let jacobian = problem.jacobian(&at)?;
    let rows = frequency_rows(problem, &at);
    let column = |j: usize| -> Vec<f64> { rows.iter().map(|&i| jacobian[(i, j)]).collect() };
    let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
    let size = |c: &[f64]| c.iter().map(|x| x * x).sum::<f64>().sqrt();
    let is_image = |i: usize, j: usize| {
        let difference: Vec<f64> = columns[i]
            .iter()
            .zip(&columns[j])
            .map(|(a, b)| a - b)
            .collect();
        let largest = size(&columns[i]).max(size(&columns[j]));
        problem.free[i].unit == problem.free[j].unit
            && largest > 0.0
            && size(&difference) <= MAX_IMAGE_DIFFERENCE * largest
    };
    let pairs: Vec<(usize, usize)> = (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .filter(|&(i, j)| is_image(i, j))
        .collect();
    let exchange = |pairs: &[(usize, usize)]| {
        let mut exchanged = z.to_vec();
        for &(i, j) in pairs {
            let value = |k: usize| problem.free[k].value(z[k]);
            let within = |k: usize, z: f64| {
                let (lower, upper) = problem.free[k].bounds();
                z.clamp(lower, upper)
            };
            exchanged[i] = within(i, problem.free[i].z(value(j)));
            exchanged[j] = within(j, problem.free[j].z(value(i)));
        }
        exchanged
    };
    let mut used = vec![false; n];
    let mut together = Vec::new();
    for &(i, j) in &pairs {
        if !used[i] && !used[j] {
            (used[i], used[j]) = (true, true);
            together.push((i, j));
        }
    }
    let mut all = Vec::new();
    if together.len() > 1 {
        all.push(exchange(&together));
    }
    all.extend(
        pairs
            .iter()
            .take(MAX_EXCHANGES)
            .map(|&pair| exchange(&[pair])),
    );
    Ok(all)
}

/// The mode whose frequency differs most between two points; where all frequencies are alike, the
/// one whose shape does.
fn separation(
    problem: &UpdateProblem<'_>,
    best: &Evaluation,
    other: &Evaluation,
) -> Option<Separation> {
    let hz = |modes: &TheoryModes, k: usize| modes.omega_rad_s[k] / std::f64::consts::TAU;
    let has_several = problem.parts.len() > 1;
    let of_part = |(part, (best, other)): (&Part<'_>, (&ModelState, &ModelState))| {
        let (best, other) = (&best.modes, &other.modes);
        let count = best.omega_rad_s.len().min(other.omega_rad_s.len());
        let separations = (0..count).map(|k| Separation {
            configuration: has_several.then(|| part.name.clone()),
            mode: k + 1,
            hz: hz(best, k),
            other_hz: hz(other, k),
            mac: mac(&best.vectors, &other.vectors, k),
        });
        separations.collect::<Vec<_>>()
    };
    let states = best.states.iter().zip(&other.states);
    let separations = problem.parts.iter().zip(states).flat_map(of_part);
    let separations: Vec<Separation> = separations.filter(|mode| mode.hz > 0.0).collect();
    let by_frequency = |s: &Separation| (s.other_hz / s.hz).ln().abs();
    let by_shape = |s: &Separation| 1.0 - s.mac;
    let largest = |of: &dyn Fn(&Separation) -> f64, least: f64| {
        let mut sorted: Vec<&Separation> = separations.iter().filter(|s| of(s) > least).collect();
        sorted.sort_by(|a, b| of(b).total_cmp(&of(a)));
        sorted.first().map(|s| (*s).clone())
    };
    largest(&by_frequency, 1e-3).or_else(|| largest(&by_shape, 1e-3))
}

fn mac(a: &RealMatrix, b: &RealMatrix, k: usize) -> f64 {
    let sum = |x: &RealMatrix, y: &RealMatrix| -> f64 {
        (0..x.nrows()).map(|i| x[(i, k)] * y[(i, k)]).sum()
    };
    sum(a, b).powi(2) / (sum(a, a) * sum(b, b))
}

#[cfg(test)]
mod tests {
    use super::super::test_models::{between_walls, free, measured, sensors};
    use super::super::{MeasuredModes, ParameterVerdict, UpdateOptions, update};
    use super::*;

    #[test]
    fn the_image_of_a_stiffness_in_a_symmetric_model_is_an_alternative_to_frequencies_alone() {
        // At exact symmetry the gradient has no part that tells the two springs apart.
        let start = [100.0, 60.0, 98.0];
        let model = between_walls(&start);
        let sensors = sensors(&model, &start);
        let result = |with_shapes: bool| {
            let test = measured(&model, &[80.0, 60.0, 125.0], 1e-4, with_shapes);
            let modes = [MeasuredModes::new("t", &test)];
            // The start alone, from which nothing else leads to the image.
            let options = UpdateOptions {
                starts: 1,
                ..UpdateOptions::default()
            };
            let chosen = free(&["k1", "k3"]);
            let new = UpdateProblem::new(&model, &start, &chosen, &modes, &sensors, options);
            update(&new.unwrap()).unwrap()
        };
        let bare = result(false);
        let [other] = &bare.alternatives[..] else {
            panic!("{:?}", bare.alternatives)
        };
        let best: Vec<f64> = bare
            .parameters
            .iter()
            .map(|parameter| parameter.updated)
            .collect();
        for (a, b) in best.iter().zip(other.values.iter().rev()) {
            assert!((a / b - 1.0).abs() < 0.01, "{best:?} {other:?}");
        }
        assert!(other.objective_difference.abs() < 1.0, "{other:?}");
        // Both have the same frequencies: their shapes differ.
        let separation = other.separation.as_ref().unwrap();
        assert!((separation.other_hz / separation.hz - 1.0).abs() < 1e-3 && separation.mac < 0.99);
        let verdicts = |result: &super::super::UpdateResult| -> Vec<ParameterVerdict> {
            result
                .parameters
                .iter()
                .map(|parameter| parameter.verdict)
                .collect()
        };
        assert_eq!(verdicts(&bare), [ParameterVerdict::Ambiguous; 2]);
        let shaped = result(true);
        assert_eq!(verdicts(&shaped), [ParameterVerdict::Identified; 2]);
        assert_eq!(shaped.alternatives, []);
    }
}
