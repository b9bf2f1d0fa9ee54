//! Close modes that respond in separate runs: modes of parts of a structure, or one mode that
//! shifted between runs. The FRFs do not distinguish these cases. All directions at one point are
//! one run here: bending in two planes is no such case.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::frf::{Function, measurement_runs};

use crate::identify::data::model_pole::ModelPole;

/// Maximum separation of two modes that may be one, half-power bandwidths.
const MAX_SEPARATION_BANDWIDTHS: f64 = 2.0;
/// Maximum fraction of the power of both modes that the other mode may have in a run.
const MAX_OTHER_POWER_FRACTION: f64 = 0.05;
/// Minimum power of a run over the largest; runs below it are ignored.
const MIN_POWER_FRACTION: f64 = 0.01;
/// Minimum number of runs of each mode: two modes of fewer runs may look so by chance.
const MIN_RUNS_PER_MODE: usize = 2;

/// The FRFs of each point of the roving sensor or hammer, all directions together.
pub(in crate::identify) fn by_point(functions: &[Function]) -> Vec<Vec<usize>> {
    let (runs, roving_sensor) = measurement_runs(functions);
    let mut points: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for f in runs.into_iter().flatten() {
        let dof = match roving_sensor {
            true => &functions[f].response,
            false => &functions[f].reference,
        };
        points.entry(dof.point()).or_default().push(f);
    }
    points.into_values().collect()
}

/// Poles with such a partner, and the distance to the nearest one in half-power bandwidths.
pub(in crate::identify) fn run_partners(
    poles: &[&ModelPole],
    runs: &[Vec<usize>],
) -> Vec<(Complex64, f64)> {
    let of = |mode: &&ModelPole| {
        let partner = |other: &&ModelPole| {
            let width = 0.5 * (mode.width() + other.width());
            let distance = (mode.lambda.im - other.lambda.im).abs() / width;
            let near = distance > 0.0 && distance < MAX_SEPARATION_BANDWIDTHS;
            (near && respond_separately(mode, other, runs)).then_some(distance)
        };
        let nearest = poles.iter().filter_map(partner).min_by(f64::total_cmp);
        nearest.map(|distance| (mode.lambda, distance))
    };
    poles.iter().filter_map(of).collect()
}

/// Whether only one of two poles responds in every run, and each does in the minimum number of
/// runs.
fn respond_separately(a: &ModelPole, b: &ModelPole, runs: &[Vec<usize>]) -> bool {
    let power = |pole: &ModelPole, run: &[usize]| -> f64 {
        run.iter().map(|f| pole.residues[*f].norm_sqr()).sum()
    };
    let both = |run: &Vec<usize>| (power(a, run), power(b, run));
    let powers: Vec<(f64, f64)> = runs.iter().map(both).collect();
    let largest = powers.iter().map(|(a, b)| a + b).fold(0.0, f64::max);
    let (mut of_a, mut of_b) = (0, 0);
    for (a, b) in powers {
        if a + b < MIN_POWER_FRACTION * largest {
            continue;
        }
        of_a += usize::from(b < MAX_OTHER_POWER_FRACTION * (a + b));
        of_b += usize::from(a < MAX_OTHER_POWER_FRACTION * (a + b));
        if a.min(b) >= MAX_OTHER_POWER_FRACTION * (a + b) {
            return false;
        }
    }
    of_a.min(of_b) >= MIN_RUNS_PER_MODE
}

#[cfg(test)]
mod tests {
    use crate::identify::run_variation::separate_responses::*;
    use crate::quantity::FrfKind;

    #[test]
    fn only_modes_that_respond_in_separate_runs_are_partners() {
        let pole = |hz: f64, residues: [f64; 6]| {
            let mut pole = ModelPole::single(Complex64::new(-1.0, hz), &[Complex64::ONE], 6);
            pole.residues = residues.map(Complex64::from).to_vec();
            pole
        };
        let runs: Vec<Vec<usize>> = (0..6).map(|run| vec![run]).collect();
        let first = pole(100.0, [1.0, 2.0, 1.5, 0.1, 0.0, 0.02]);
        // The last run has little of both.
        let second = pole(103.0, [0.1, 0.0, 0.2, 1.0, 0.8, 0.02]);
        let everywhere = pole(101.0, [1.0; 6]);
        let far = pole(108.0, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        let partners = run_partners(&[&first, &everywhere, &second, &far], &runs);
        assert_eq!(partners, [(first.lambda, 1.5), (second.lambda, 1.5)]);
        // Directions at one point are no separate runs.
        let function = |response: &str| Function {
            response: response.parse().unwrap(),
            reference: "9:+Z".parse().unwrap(),
            kind: FrfKind::Receptance,
            averages: None,
            estimator: None,
            variance_dof: None,
        };
        let functions = ["1:+X", "1:+Y", "2:+X", "2:+Y", "3:+X", "3:+Y"].map(function);
        let points = by_point(&functions);
        assert_eq!(points, [[0, 1], [2, 3], [4, 5]]);
        let in_x = pole(100.0, [1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
        let in_y = pole(101.0, [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
        assert!(run_partners(&[&in_x, &in_y], &points).is_empty());
        // A response in one run alone may be chance.
        let alone = pole(103.0, [0.1, 0.0, 0.2, 0.0, 0.8, 0.0]);
        assert!(run_partners(&[&first, &alone], &runs).is_empty());
    }
}
