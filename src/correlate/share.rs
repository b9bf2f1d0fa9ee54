//! The part of a test shape that a root of a theory holds, when the roots near it explain the shape together.
//!
//! A stiffness that is wrong mixes shapes, and at a few sensors shapes of different modes look alike, so that the MAC with each mode by
//! itself counts what they have in common several times. If the test mode is root r, its shape is `ψ = Σ q_j φ_j`, and by perturbation of
//! first order q_j is no more than in proportion to `1/|f_j/f_r − f_r/f_j|` beside q_r: an error that all roots share mixes nothing.
//! `|q_r|²/Σ|q_j|²`, shapes of unit length at the sensors, is then what is root r's own.
//!
//! Among roots that look alike, one that hardly moves the sensors is not what the test found. Where modal masses are known, a root that
//! stands 30 dB below the strongest near it is allowed as much less of the shape.

use num_complex::Complex64;

use crate::linalg::{complex_matrix, least_squares, solve_lower, solve_lower_adjoint, thin_qr};
use crate::modal::{ModalModel, Scaling};

use super::pairing::Shapes;
use super::roots::Root;

/// Deviation of a measured value from any sum of the theory's modes, over the root mean square of the shape.
const DEVIATION: f64 = 0.15;
/// `|f_j/f_r − f_r/f_j|` from which on root r holds less and less of another.
const NEAR: f64 = 0.1;
/// The same beyond which nothing is held: what is left of a shape there is a hundredth.
const FAR: f64 = 1.0;
/// Length at the sensors, with unit modal mass, over that of the strongest near it, from which on a root is seen as well as that.
const VISIBLE: f64 = 0.03;

/// Least part of a shape that a mode is allowed, so that what it costs stays finite.
const LEAST_REACH: f64 = 1e-6;

/// The share of a root in a test mode; `None` where they have no two degrees of freedom in common.
///
/// q minimises `|ψ − Φ q|²/(0.15 ψ_rms)² + Σ |q_j|²/(g_j |ψ|)²` over the roots near r, shapes of unit length, with
/// `g_j = v_j min(1, 0.1/|f_j/f_r − f_r/f_j|)` and the visibility `v_j = min(1, |φ_j|/(0.03 |φ|_max))` of mass-normalised shapes, 1 where
/// masses are not known. The share of root r is `|q_r|²/|q|²`, times the part `1 − |ψ − Φ q|²/|ψ|²` of the shape that the theory holds
/// at all.
///
/// # Reference
/// O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion process, IMAC 7 (coordinates of a measured shape);
/// Fox and Kapoor (1968), AIAA Journal 6, eq. 21 (mixing of first order).
pub(super) fn share(
    (theory, shapes): (&ModalModel, &Shapes),
    mode: usize,
    (r, roots): (usize, &[Root]),
) -> Option<f64> {
    let apart = |j: &usize| {
        let ratio = theory.modes[*j].frequency_hz / roots[r].hz;
        (ratio - ratio.recip()).abs()
    };
    // The root's own modes first.
    let others = roots.iter().enumerate().filter(|(other, _)| *other != r);
    let others = others.flat_map(|(_, root)| root.modes.iter().copied());
    let own = roots[r].modes.iter().copied();
    let near: Vec<usize> = own.chain(others.filter(|j| apart(j) < FAR)).collect();
    let [shape, mut columns] = shapes.common(&[mode], &near);
    let shape = &shape[0];
    if shape.len() < 2 || squared(shape) <= 0.0 {
        return None;
    }
    let visible = visible(theory, &near, &columns);
    columns.iter_mut().for_each(|own| to_unit_length(own));
    let reach = near.iter().zip(visible);
    let reach: Vec<f64> = reach.map(|(j, v)| v * (NEAR / apart(j)).min(1.0)).collect();
    let coordinates = coordinates(shape, &columns, &reach);
    let (own, whole) = (
        squared(&coordinates[..roots[r].modes.len()]),
        squared(&coordinates),
    );
    let part = if whole > 0.0 { own / whole } else { 0.0 };
    Some(part * held(shape, &columns, &coordinates))
}

/// How well each mode is seen beside the strongest.
fn visible(theory: &ModalModel, modes: &[usize], columns: &[Vec<Complex64>]) -> Vec<f64> {
    let normalised = |j: &usize| theory.modes[*j].scaling == Scaling::UnitModalMass;
    let lengths: Vec<f64> = columns.iter().map(|own| squared(own).sqrt()).collect();
    let strongest = lengths.iter().copied().fold(0.0, f64::max);
    if !modes.iter().all(normalised) || strongest <= 0.0 {
        return vec![1.0; modes.len()];
    }
    let of = |length: &f64| (length / (VISIBLE * strongest)).min(1.0);
    lengths.iter().map(of).collect()
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
    let reach: Vec<f64> = reach
        .iter()
        .map(|own| own.max(LEAST_REACH) * scale)
        .collect();
    if points < modes {
        return of_few_points(shape, (columns, &reach), deviation);
    }
    let matrix = complex_matrix(points + modes, modes, |k, c| match k.checked_sub(points) {
        None => columns[c][k] / deviation,
        Some(own) if own == c => reach[c].recip().into(),
        Some(_) => Complex64::ZERO,
    });
    let right = complex_matrix(points + modes, 1, |k, _| {
        let value = shape.get(k);
        value.map_or(Complex64::ZERO, |value| value / deviation)
    });
    let solution = least_squares(&matrix, &right);
    (0..modes).map(|c| solution[(c, 0)]).collect()
}

/// The same with unknowns for the points: `q = G²Φᴴ(ΦG²Φᴴ + d²)⁻¹ψ` from the triangle of `[(ΦG)ᴴ; d]`.
fn of_few_points(
    shape: &[Complex64],
    (columns, reach): (&[Vec<Complex64>], &[f64]),
    deviation: f64,
) -> Vec<Complex64> {
    let (points, modes) = (shape.len(), columns.len());
    let stacked = complex_matrix(modes + points, points, |k, p| match k.checked_sub(modes) {
        None => columns[k][p].conj() * reach[k],
        Some(own) if own == p => deviation.into(),
        Some(_) => Complex64::ZERO,
    });
    let lower = complex_matrix(points, points, {
        let upper = thin_qr(&stacked).r;
        move |i, j| upper[(j, i)].conj()
    });
    let right = complex_matrix(points, 1, |k, _| shape[k]);
    let weights = solve_lower_adjoint(&lower, &solve_lower(&lower, &right));
    let of = |(column, reach): (&Vec<Complex64>, &f64)| {
        let products = column.iter().enumerate();
        let sum: Complex64 = products
            .map(|(k, value)| value.conj() * weights[(k, 0)])
            .sum();
        reach * reach * sum
    };
    columns.iter().zip(reach).map(of).collect()
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

    /// Shares of all roots in the only test mode.
    fn shares_of(shape: &[f64], theory: &ModalModel) -> Vec<Option<f64>> {
        let test = model(vec![mode(100.0, shape)]);
        let map = DofMap::of_models(&test, theory);
        let shapes = Shapes::new(&test, theory, &map, &PairOptions::default()).unwrap();
        let roots = elastic_roots(theory);
        let of = |r| share((theory, &shapes), 0, (r, &roots));
        (0..roots.len()).map(of).collect()
    }

    fn sum(a: f64, b: f64) -> Vec<f64> {
        let both = shape(1).into_iter().zip(shape(2));
        both.map(|(x, y)| a * x + b * y).collect()
    }

    #[test]
    fn a_mixed_shape_is_shared_out_as_it_was_mixed() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let found = shares_of(&sum(0.8, 0.6), &theory);
        // Six points hold each coordinate to 0.15/sqrt(6).
        assert!((found[0].unwrap() - 0.64).abs() < 0.01, "{found:?}");
        assert!((found[1].unwrap() - 0.36).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn near_roots_of_one_shape_have_half_of_it_and_far_ones_their_own() {
        let twins = model(vec![mode(100.0, &shape(1)), mode(102.0, &shape(1))]);
        let found = shares_of(&shape(1), &twins);
        assert!(
            found.iter().all(|own| (own.unwrap() - 0.5).abs() < 0.01),
            "{found:?}"
        );
        // g = 0.1/0.833 = 0.12 for the other; coordinates of one shape go with g², shares with g⁴.
        let apart = model(vec![mode(100.0, &shape(1)), mode(150.0, &shape(1))]);
        let found = shares_of(&shape(1), &apart);
        assert!(found.iter().all(|own| own.unwrap() > 0.999), "{found:?}");
    }

    #[test]
    fn a_root_that_hardly_moves_the_sensors_leaves_a_shape_to_one_that_does() {
        let faint: Vec<f64> = shape(1).iter().map(|v| 1e-3 * v).collect();
        let mut theory = model(vec![mode(100.0, &faint), mode(104.0, &shape(1))]);
        let unknown = shares_of(&shape(1), &theory);
        assert!((unknown[0].unwrap() - 0.5).abs() < 0.01, "{unknown:?}");
        let masses = theory.modes.iter_mut();
        masses.for_each(|mode| mode.scaling = Scaling::UnitModalMass);
        let found = shares_of(&shape(1), &theory);
        // v = 1/30: shares with its fourth power.
        assert!(
            found[0].unwrap() < 1e-4 && found[1].unwrap() > 0.99,
            "{found:?}"
        );
    }

    #[test]
    fn unknowns_for_points_give_what_unknowns_for_modes_do() {
        let columns: Vec<Vec<Complex64>> = (0..9)
            .map(|c| (0..6).map(|k| Complex64::cis((c * k + c) as f64)).collect())
            .collect();
        let test: Vec<Complex64> = (0..6).map(|k| Complex64::cis((k * k) as f64)).collect();
        let reach: Vec<f64> = (1..10).map(|c| 1.0 / f64::from(c)).collect();
        let found = coordinates(&test, &columns, &reach);
        // What is left over of the normal equations.
        let (d, scale) = (DEVIATION, 6f64.sqrt());
        for (c, column) in columns.iter().enumerate() {
            let fitted = |k: usize| {
                columns
                    .iter()
                    .zip(&found)
                    .map(|(own, q)| own[k] * q)
                    .sum::<Complex64>()
            };
            let rest: Complex64 = (0..6)
                .map(|k| column[k].conj() * (test[k] - fitted(k)))
                .sum();
            let penalty = found[c] * d * d / (reach[c] * scale).powi(2);
            assert!((rest - penalty).norm() < 1e-10, "{c}");
        }
    }

    #[test]
    fn a_shape_that_no_root_holds_has_no_share() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let found = shares_of(&shape(4), &theory);
        assert!(found.iter().all(|own| own.unwrap() < 1e-9), "{found:?}");
        assert_eq!(shares_of(&[], &theory), [None, None]);
    }
}
