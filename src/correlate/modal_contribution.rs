//! The modal contribution is the fraction of a test shape that a root of the theory explains, when
//! the roots near it explain the shape together.
//!
//! A stiffness that is wrong mixes shapes, and at a few sensors shapes of different modes look
//! alike, so that the MAC with each single mode counts their common part several times.
//! If the test mode is root r, its shape is `ψ = Σ q_j φ_j`, and by perturbation of first order q_j
//! is no more than in proportion to `1/|f_j/f_r − f_r/f_j|` beside q_r: an error that all roots
//! share mixes nothing. `|q_r|²/Σ|q_j|²` is then the contribution of root r. With shapes of unit
//! modal mass that is the part of the modal mass, the mass-weighted MAC of the whole machine: where
//! the sensors stand does not change it, and a root that hardly moves them needs so much of itself
//! to look like the test shape that one beside it, which moves them, takes the shape. Where masses
//! are not known, shapes have unit length at the sensors.

use num_complex::Complex64;

use crate::linalg::{
    ComplexMatrix, ThinQr, adjoint_product, complex_matrix, solve_lower, solve_lower_adjoint,
};
use crate::modal::ModalModel;

use super::model_roots::Root;
use super::observability::modal_mass_kg;
use super::shapes::Shapes;

/// Deviation of a measured value from any sum of the theory's modes, over the root mean square of
/// the shape.
const DEVIATION: f64 = 0.15;
/// Minimum `|f_j/f_r − f_r/f_j|` at which the allowed contribution of root j to root r decreases.
const NEAR: f64 = 0.1;
/// Minimum `|f_j/f_r − f_r/f_j|` at which the contribution is neglected: it is a hundredth there.
const FAR: f64 = 1.0;

/// The part of a test shape that a root holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ModalContribution {
    /// From 0 to 1.
    pub part: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// The shares of a root in test modes; `None` where they have no two degrees of freedom in common.
///
/// q minimises `|ψ − Φ q|²/(0.15 ψ_rms)² + Σ |q_j|²/(g_j |ψ|)²` over the roots near r, with `g_j =
/// min(1, 0.1/|f_j/f_r − f_r/f_j|)` and shapes of unit modal mass over the length of r's at the
/// sensors, or of unit length each where a mass is not known. The share of root r is
/// `s = |q_r|²/|q|²`, times the part `1 − |ψ − Φ q|²/|ψ|²` of the shape that the theory holds at
/// all; 0 of a root that leaves the sensors still.
///
/// Its deviation is that of first order, `2 √(γᴴ C γ)` with `γ_j = (δ_j − s) q_j/|q|²`, δ_j = 1 for
/// the modes of the root and 0 for others, and C the covariance of q, the inverse of half the
/// second derivative of that sum: few sensors, or shapes that look alike there, make it large.
///
/// # Reference
/// O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion process, IMAC 7
/// (coordinates of a measured shape); Fox and Kapoor (1968), AIAA Journal 6, eq. 21 (mixing of
/// first order).
pub(super) fn shares(
    theory: &ModalModel,
    shapes: &Shapes,
    modes: &[usize],
    r: usize,
    roots: &[Root],
) -> Vec<Option<ModalContribution>> {
    let apart = |j: &usize| {
        let ratio = theory.modes[*j].frequency_hz / roots[r].hz;
        (ratio - ratio.recip()).abs()
    };
    // The modes of the root come first.
    let others = roots.iter().enumerate().filter(|(other, _)| *other != r);
    let others = others.flat_map(|(_, root)| root.modes.iter().copied());
    let of_r = roots[r].modes.iter().copied();
    let near: Vec<usize> = of_r.chain(others.filter(|j| apart(j) < FAR)).collect();
    let reach: Vec<f64> = near.iter().map(|j| (NEAR / apart(j)).min(1.0)).collect();
    let of_root = roots[r].modes.len();
    // Modes that are read at the same places share their equations.
    let mut prepared: Vec<(Vec<usize>, Option<Explanation>)> = Vec::new();
    let share = |&mode: &usize| {
        let places = shapes.places(&[mode], &near);
        let shape = at(&shapes.test[mode], &places);
        if shape.len() < 2 || squared(&shape) <= 0.0 {
            return None;
        }
        let known = prepared.iter().position(|(entry, _)| *entry == places);
        let known = known.unwrap_or_else(|| {
            let mut columns: Vec<Vec<Complex64>> = near
                .iter()
                .map(|&j| at(&shapes.theory[j], &places))
                .collect();
            let moves = squared(&columns[..of_root].concat()) > 0.0;
            let explanation = moves.then(|| {
                scale(theory, &near, of_root, &mut columns);
                Explanation::new(columns, of_root, &reach)
            });
            prepared.push((places, explanation));
            prepared.len() - 1
        });
        let still = ModalContribution {
            part: 0.0,
            std: 0.0,
        };
        let explanation = prepared[known].1.as_ref();
        explanation.map_or(Some(still), |explanation| explanation.share(shape))
    };
    modes.iter().map(share).collect()
}

/// Values at some places, where there are any.
fn at(values: &[Option<Complex64>], places: &[usize]) -> Vec<Complex64> {
    places.iter().filter_map(|&d| values[d]).collect()
}

/// Shapes of unit modal mass, over the length of the first `first` of them, where all masses are
/// known; else of unit length each.
fn scale(theory: &ModalModel, modes: &[usize], first: usize, columns: &mut [Vec<Complex64>]) {
    let mass = |j: &usize| modal_mass_kg(&theory.modes[*j]);
    let Some(masses) = modes.iter().map(mass).collect::<Option<Vec<f64>>>() else {
        columns.iter_mut().for_each(|column| to_unit_length(column));
        return;
    };
    for (column, mass) in columns.iter_mut().zip(masses) {
        column.iter_mut().for_each(|value| *value /= mass.sqrt());
    }
    let length = (squared(&columns[..first].concat()) / first as f64).sqrt();
    let values = columns.iter_mut().flatten();
    values.for_each(|value| *value /= length);
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

/// The equations that explain shapes of unit length by columns, of which the first belong to
/// the root.
struct Explanation {
    columns: Vec<Vec<Complex64>>,
    of_root: usize,
    /// Triangle of the stacked equations: with as many points as modes or more its product is the
    /// inverse of the covariance of q; with fewer, the covariance of the shape.
    lower: ComplexMatrix,
    unknowns: Unknowns,
}

enum Unknowns {
    /// One for each mode: `Qᴴ` of `[Φ/d; G⁻¹]` is the adjoint of this one's rows of the points,
    /// over d.
    Modes(ComplexMatrix),
    /// One for each point: allowed deviations, and the columns times their squares.
    Points(Vec<f64>, ComplexMatrix),
}

impl Explanation {
    fn new(columns: Vec<Vec<Complex64>>, of_root: usize, reach: &[f64]) -> Self {
        let points = columns[0].len();
        let deviation = DEVIATION / (points as f64).sqrt();
        let (lower, unknowns) = if points < columns.len() {
            of_few_points(&columns, reach, deviation)
        } else {
            of_many_points(&columns, reach, deviation)
        };
        Self {
            columns,
            of_root,
            lower,
            unknowns,
        }
    }

    /// The share of the root in a shape that is not zero; none where the equations have no accurate
    /// solution.
    fn share(&self, mut shape: Vec<Complex64>) -> Option<ModalContribution> {
        to_unit_length(&mut shape);
        let coordinates = self.coordinates(&shape);
        let whole = squared(&coordinates);
        if !whole.is_finite() {
            return None;
        }
        let part = if whole > 0.0 {
            squared(&coordinates[..self.of_root]) / whole
        } else {
            0.0
        };
        let gradient = coordinates.iter().enumerate().map(|(j, q)| {
            let indicator = if j < self.of_root { 1.0 } else { 0.0 };
            q * (indicator - part) / whole.max(f64::MIN_POSITIVE)
        });
        let std = 2.0 * self.deviation_along(&gradient.collect::<Vec<_>>());
        let held = held(&shape, &self.columns, &coordinates);
        Some(ModalContribution {
            part: part * held,
            std: std * held,
        })
    }

    /// q of a shape.
    fn coordinates(&self, shape: &[Complex64]) -> Vec<Complex64> {
        let right = complex_matrix(shape.len(), 1, |k, _| shape[k]);
        let solution = match &self.unknowns {
            Unknowns::Modes(upper) => {
                solve_lower_adjoint(&self.lower, &adjoint_product(upper, right.as_ref()))
            }
            Unknowns::Points(_, weighted) => {
                let weights = solve_lower_adjoint(&self.lower, &solve_lower(&self.lower, &right));
                adjoint_product(weighted, weights.as_ref())
            }
        };
        (0..self.columns.len()).map(|c| solution[(c, 0)]).collect()
    }

    /// `√(γᴴ C γ)` with the covariance C of q.
    fn deviation_along(&self, gradient: &[Complex64]) -> f64 {
        let along = complex_matrix(gradient.len(), 1, |j, _| gradient[j]);
        let solved = |right: &ComplexMatrix| {
            let solution = solve_lower(&self.lower, right);
            let square = |k: usize| solution[(k, 0)].norm_sqr();
            (0..solution.nrows()).map(square).sum::<f64>()
        };
        let Unknowns::Points(reach, weighted) = &self.unknowns else {
            return solved(&along).sqrt();
        };
        // C = G² − G²Φᴴ(ΦG²Φᴴ + d²)⁻¹ΦG².
        let allowed = gradient.iter().zip(reach);
        let allowed: f64 = allowed
            .map(|(coordinate, reach)| (coordinate * reach).norm_sqr())
            .sum();
        (allowed - solved(&(weighted * &along))).max(0.0).sqrt()
    }
}

fn of_many_points(
    columns: &[Vec<Complex64>],
    reach: &[f64],
    deviation: f64,
) -> (ComplexMatrix, Unknowns) {
    let (points, modes) = (columns[0].len(), columns.len());
    let matrix = complex_matrix(points + modes, modes, |k, c| match k.checked_sub(points) {
        None => columns[c][k] / deviation,
        Some(pinned) if pinned == c => reach[c].recip().into(),
        Some(_) => Complex64::ZERO,
    });
    let qr = ThinQr::or_not_a_number(&matrix);
    let lower = complex_matrix(modes, modes, |i, j| qr.r[(j, i)].conj());
    let upper = complex_matrix(points, modes, |p, c| qr.q[(p, c)] / deviation);
    (lower, Unknowns::Modes(upper))
}

/// The same with unknowns for the points: `q = G²Φᴴ(ΦG²Φᴴ + d²)⁻¹ψ` from the triangle of `[(ΦG)ᴴ;
/// d]`.
fn of_few_points(
    columns: &[Vec<Complex64>],
    reach: &[f64],
    deviation: f64,
) -> (ComplexMatrix, Unknowns) {
    let (points, modes) = (columns[0].len(), columns.len());
    let stacked = complex_matrix(modes + points, points, |k, p| match k.checked_sub(modes) {
        None => columns[k][p].conj() * reach[k],
        Some(pinned) if pinned == p => deviation.into(),
        Some(_) => Complex64::ZERO,
    });
    let lower = complex_matrix(points, points, {
        let upper = ThinQr::or_not_a_number(&stacked).r;
        move |i, j| upper[(j, i)].conj()
    });
    let weighted = complex_matrix(points, modes, |p, c| columns[c][p] * reach[c].powi(2));
    (lower, Unknowns::Points(reach.to_vec(), weighted))
}

/// The part of a shape of unit length that a sum of columns is.
fn held(shape: &[Complex64], columns: &[Vec<Complex64>], coordinates: &[Complex64]) -> f64 {
    let left = |(k, value): (usize, &Complex64)| {
        let terms = columns.iter().zip(coordinates);
        let sum: Complex64 = terms.map(|(column, q)| column[k] * q).sum();
        (value - sum).norm_sqr()
    };
    let left: f64 = shape.iter().enumerate().map(left).sum();
    (1.0 - left).max(0.0)
}

#[cfg(test)]
mod tests {
    use crate::correlate::model_roots::elastic_roots;
    use crate::correlate::pairing_tests::{mode, model, shape};
    use crate::correlate::{DofMap, PairOptions};
    use crate::modal::{ModeShape, Scaling};

    use super::*;

    /// Shares of all roots in the only test mode.
    fn shares_of(shape: &[f64], theory: &ModalModel) -> Vec<Option<f64>> {
        let test = model(vec![mode(100.0, shape)]);
        let map = DofMap::of_models(&test, theory);
        let shapes = Shapes::new(&test, theory, &map, &PairOptions::default()).unwrap();
        let roots = elastic_roots(theory);
        let of = |r| shares(theory, &shapes, &[0], r, &roots)[0].map(|share| share.part);
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
    fn near_roots_of_one_shape_contribute_half_each_and_far_ones_all() {
        let twins = model(vec![mode(100.0, &shape(1)), mode(102.0, &shape(1))]);
        let found = shares_of(&shape(1), &twins);
        assert!(
            found
                .iter()
                .all(|share| (share.unwrap() - 0.5).abs() < 0.01),
            "{found:?}"
        );
        // g = 0.1/0.833 = 0.12 for the other; coordinates of one shape go with g², shares with g⁴.
        let apart = model(vec![mode(100.0, &shape(1)), mode(150.0, &shape(1))]);
        let found = shares_of(&shape(1), &apart);
        assert!(
            found.iter().all(|share| share.unwrap() > 0.999),
            "{found:?}"
        );
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
        // To equal the test shape alone it would need a thousand times the amplitude of the
        // other.
        assert!(
            found[0].unwrap() < 1e-4 && found[1].unwrap() > 0.99,
            "{found:?}"
        );
    }

    #[test]
    fn the_share_is_that_of_modal_mass_wherever_the_sensors_are() {
        // The second root moves the sensors a third as much as the first: 0.8 and 0.6 of the masses
        // look like 0.8 and 0.2.
        let third: Vec<f64> = shape(2).iter().map(|v| v / 3.0).collect();
        let test = sum(0.8, 0.2);
        let mut theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &third)]);
        for mode in &mut theory.modes {
            mode.scaling = Scaling::Unknown;
            mode.modal_mass_kg = Some(4.0);
            mode.shape = mode.shape.scaled(2.0.into());
        }
        let found = shares_of(&test, &theory);
        assert!((found[0].unwrap() - 0.64).abs() < 0.02, "{found:?}");
        assert!((found[1].unwrap() - 0.36).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn a_share_is_less_sure_where_few_sensors_tell_shapes_apart() {
        let full = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let few = |model: &ModalModel| {
            let mut model = model.clone();
            for mode in &mut model.modes {
                mode.shape = ModeShape::new(mode.shape.iter().take(2).map(|(d, v)| (d.clone(), v)));
            }
            model
        };
        let std = |theory: &ModalModel| {
            let test = model(vec![mode(100.0, &sum(0.8, 0.6))]);
            let map = DofMap::of_models(&test, theory);
            let shapes = Shapes::new(&test, theory, &map, &PairOptions::default()).unwrap();
            let roots = elastic_roots(theory);
            shares(theory, &shapes, &[0], 0, &roots)[0].unwrap().std
        };
        // Both coordinates are known to d = 0.15/sqrt(6) of the shape, and 2|gamma| = 2 * 0.8 *
        // 0.6.
        let expected = 0.96 * 0.15 / 6f64.sqrt();
        assert!(
            (std(&full) - expected).abs() < 0.01 * expected,
            "{}",
            std(&full)
        );
        assert!(std(&few(&full)) > 2.0 * expected);
    }

    #[test]
    fn the_deviation_is_that_of_the_inverse_for_few_points_and_for_many() {
        // One point and two modes, as unknowns for points; the same with a second point that says
        // nothing, as unknowns for modes.
        let columns = |points: usize| -> Vec<Vec<Complex64>> {
            let column = |c: usize| {
                (0..points).map(move |p| {
                    if p == 0 {
                        (c as f64 + 1.0).into()
                    } else {
                        Complex64::ZERO
                    }
                })
            };
            (0..2).map(|c| column(c).collect()).collect()
        };
        let gradient = [Complex64::new(0.3, 0.1), Complex64::new(-0.2, 0.4)];
        let of = |points: usize| {
            Explanation::new(columns(points), 1, &[0.5, 0.8])
                .deviation_along(&gradient)
                .powi(2)
        };
        // C = (ΦᵀΦ/d² + G⁻²)⁻¹ by hand.
        let by_hand = |d: f64| {
            let (a, b, c) = (
                1.0 / (d * d) + 4.0,
                2.0 / (d * d),
                4.0 / (d * d) + 1.0 / 0.64,
            );
            let [x, y] = gradient;
            let cross = (x.conj() * y).re;
            (c * x.norm_sqr() - 2.0 * b * cross + a * y.norm_sqr()) / (a * c - b * b)
        };
        assert!(
            (of(1) - by_hand(0.15)).abs() < 1e-12,
            "{} {}",
            of(1),
            by_hand(0.15)
        );
        let many = by_hand(0.15 / 2f64.sqrt());
        assert!((of(2) - many).abs() < 1e-12, "{} {many}", of(2));
    }

    #[test]
    fn a_root_that_leaves_the_sensors_still_has_no_share() {
        let theory = model(vec![mode(100.0, &[0.0; 6]), mode(104.0, &shape(2))]);
        assert_eq!(shares_of(&shape(2), &theory)[0], Some(0.0));
    }

    #[test]
    fn unknowns_for_points_give_what_unknowns_for_modes_do() {
        let columns: Vec<Vec<Complex64>> = (0..9)
            .map(|c| (0..6).map(|k| Complex64::cis((c * k + c) as f64)).collect())
            .collect();
        let test: Vec<Complex64> = (0..6).map(|k| Complex64::cis((k * k) as f64)).collect();
        let reach: Vec<f64> = (1..10).map(|c| 1.0 / f64::from(c)).collect();
        let found = Explanation::new(columns.clone(), 1, &reach).coordinates(&test);
        // The residual of the normal equations.
        let d = DEVIATION / 6f64.sqrt();
        for (c, column) in columns.iter().enumerate() {
            let fitted = |k: usize| {
                columns
                    .iter()
                    .zip(&found)
                    .map(|(column, q)| column[k] * q)
                    .sum::<Complex64>()
            };
            let rest: Complex64 = (0..6)
                .map(|k| column[k].conj() * (test[k] - fitted(k)))
                .sum();
            let penalty = found[c] * d * d / reach[c].powi(2);
            assert!((rest - penalty).norm() < 1e-10, "{c}");
        }
    }

    #[test]
    fn a_shape_that_no_root_holds_has_no_share() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let found = shares_of(&shape(4), &theory);
        assert!(found.iter().all(|share| share.unwrap() < 1e-9), "{found:?}");
        assert_eq!(shares_of(&[], &theory), [None, None]);
    }
}
