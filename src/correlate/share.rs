//! The part of a test shape that each root of a theory holds, when all roots explain the shape together.
//!
//! A stiffness that is wrong mixes shapes, and at a few sensors shapes of different modes look alike, so that the MAC with each mode by
//! itself counts what they have in common several times. With the coordinates q of `ψ = Σ q_j φ_j`, shapes of unit length at the
//! sensors, `|q_r|²/Σ|q_j|²` is what the MAC with root r is at right angles. What the sensors do not tell apart is decided by
//! perturbation of first order: a mode at `f` holds one at `f_j` no more than in proportion to `1/|f_j/f − f/f_j|`. Lengths by modal mass
//! would make it the MAC over all degrees of freedom, but where a mode hardly moves the sensors, a little noise would then be much of it.

use num_complex::Complex64;

use crate::linalg::{complex_matrix, least_squares};
use crate::modal::ModalModel;

use super::pairing::Shapes;
use super::roots::Root;

/// Deviation of a measured value from any sum of the theory's modes, over the root mean square of the shape.
const DEVIATION: f64 = 0.15;
/// `|f_j/f − f/f_j|` from which on a mode holds less and less of another.
const NEAR: f64 = 0.1;
/// Factor of frequency beyond which modes are left out.
const FAR: f64 = 3.0;

/// The share of every root in a test mode; `None` where modes near it have no shape in common with it.
///
/// q minimises `|ψ − Φ q|²/(0.15 ψ_rms)² + Σ |q_j|²/(g_j |ψ|)²`, `g_j = min(1, 0.1/|f_j/f − f/f_j|)`; the share of root r is
/// `|q_r|²/|q|²`, times the part `1 − |ψ − Φ q|²/|ψ|²` of the shape that the theory holds at all.
///
/// # Reference
/// O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion process, IMAC 7 (coordinates of a measured shape);
/// Fox and Kapoor (1968), AIAA Journal 6, eq. 21 (mixing of first order).
pub(super) fn shares(
    (test, theory): (&ModalModel, &ModalModel),
    shapes: &Shapes,
    (mode, roots): (usize, &[Root]),
) -> Vec<Option<f64>> {
    let hz = test.modes[mode].frequency_hz;
    let apart = |j: usize| {
        let ratio = theory.modes[j].frequency_hz / hz;
        (ratio - ratio.recip()).abs()
    };
    let reached = |root: &&Root| (hz / FAR..=hz * FAR).contains(&root.hz);
    let near: Vec<usize> = roots
        .iter()
        .filter(reached)
        .flat_map(|root| root.modes.iter().copied())
        .collect();
    let [shape, mut columns] = shapes.common(&[mode], &near);
    let shape = &shape[0];
    if shape.len() < 2 || squared(shape) <= 0.0 || near.is_empty() {
        return vec![None; roots.len()];
    }
    columns.iter_mut().for_each(|own| to_unit_length(own));
    let reach: Vec<f64> = near.iter().map(|j| (NEAR / apart(*j)).min(1.0)).collect();
    let coordinates = coordinates(shape, &columns, &reach);
    let held = held(shape, &columns, &coordinates);
    let of = |j: &usize| {
        let at = near.iter().position(|own| own == j)?;
        Some(coordinates[at].norm_sqr())
    };
    let whole = squared(&coordinates);
    let share = |root: &Root| {
        let own: Option<f64> = root.modes.iter().map(of).sum();
        own.filter(|_| whole > 0.0).map(|own| held * own / whole)
    };
    roots.iter().map(share).collect()
}

fn squared(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum()
}

fn to_unit_length(column: &mut [Complex64]) {
    let length = squared(column).sqrt();
    if length > 0.0 {
        column.iter_mut().for_each(|value| *value /= length);
    }
}

/// q of a shape, with the least deviations that each is allowed.
fn coordinates(shape: &[Complex64], columns: &[Vec<Complex64>], reach: &[f64]) -> Vec<Complex64> {
    let (points, modes) = (shape.len(), columns.len());
    let scale = squared(shape).sqrt();
    let deviation = DEVIATION * scale / (points as f64).sqrt();
    let matrix = complex_matrix(points + modes, modes, |k, c| match k.checked_sub(points) {
        None => columns[c][k] / deviation,
        Some(own) if own == c => (reach[c] * scale).recip().into(),
        Some(_) => Complex64::ZERO,
    });
    let right = complex_matrix(points + modes, 1, |k, _| {
        shape
            .get(k)
            .map_or(Complex64::ZERO, |value| value / deviation)
    });
    let solution = least_squares(&matrix, &right);
    (0..modes).map(|c| solution[(c, 0)]).collect()
}

/// The part of a shape that a sum of columns is.
fn held(shape: &[Complex64], columns: &[Vec<Complex64>], coordinates: &[Complex64]) -> f64 {
    let left = |(k, value): (usize, &Complex64)| {
        let terms = columns.iter().zip(coordinates);
        let sum: Complex64 = terms.map(|(column, q)| column[k] * q).sum();
        (value - sum).norm_sqr()
    };
    let left: f64 = shape.iter().enumerate().map(left).sum();
    (1.0 - left / squared(shape)).max(0.0)
}

#[cfg(test)]
mod tests {
    use crate::correlate::pairing_tests::{mode, model, shape};
    use crate::correlate::roots::elastic_roots;
    use crate::correlate::{DofMap, PairOptions};

    use super::*;

    fn shares_of(test: &ModalModel, theory: &ModalModel) -> Vec<Option<f64>> {
        let map = DofMap::of_models(test, theory);
        let shapes = Shapes::new(test, theory, &map, &PairOptions::default()).unwrap();
        shares((test, theory), &shapes, (0, &elastic_roots(theory)))
    }

    fn sum(a: f64, b: f64) -> Vec<f64> {
        let both = shape(1).into_iter().zip(shape(2));
        both.map(|(x, y)| a * x + b * y).collect()
    }

    #[test]
    fn a_mixed_shape_is_shared_out_as_it_was_mixed() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let test = model(vec![mode(102.0, &sum(0.8, 0.6))]);
        let found = shares_of(&test, &theory);
        // Six points hold each coordinate to 0.15/sqrt(6).
        assert!((found[0].unwrap() - 0.64).abs() < 0.01, "{found:?}");
        assert!((found[1].unwrap() - 0.36).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn what_sensors_cannot_tell_apart_goes_to_the_nearer_root() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(200.0, &shape(1))]);
        let found = shares_of(&model(vec![mode(101.0, &shape(1))]), &theory);
        // g = 1 and 0.1/(1.98 - 0.505) = 0.068; coordinates of one shape go with g².
        assert!(found[0].unwrap() > 0.99, "{found:?}");
        let twins = model(vec![mode(100.0, &shape(1)), mode(102.0, &shape(1))]);
        let found = shares_of(&model(vec![mode(101.0, &shape(1))]), &twins);
        assert!((found[0].unwrap() - 0.5).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_shape_that_no_root_holds_has_no_share() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let found = shares_of(&model(vec![mode(100.0, &shape(4))]), &theory);
        assert!(found.iter().all(|own| own.unwrap() < 1e-9), "{found:?}");
        let without = shares_of(&model(vec![mode(100.0, &[])]), &theory);
        assert_eq!(without, [None, None]);
    }
}
