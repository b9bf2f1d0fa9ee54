//! The modal contribution is the fraction of a test shape that a root of the theory explains, when
//! the roots near it explain the shape together.
//!
//! A wrong stiffness mixes shapes, and at a few sensors shapes of different modes are similar, so
//! that the MAC with each single mode counts their common part several times. If the test mode is
//! root r, its shape is `ψ = Σ q_j φ_j`, and by first-order perturbation `q_j/q_r` is at most
//! proportional to `1/|f_j/f_r − f_r/f_j|`: an error common to all roots mixes no shapes.
//! `|q_r|²/Σ|q_j|²` is the contribution of root r. With shapes of unit modal mass it is the
//! fraction of the modal mass, the mass-weighted MAC of the whole machine, which does not depend on
//! the positions of the sensors. A root that hardly moves the sensors would need a large coordinate
//! for the test shape; a near root that moves them explains it with a smaller one. Where masses are
//! not known, shapes have unit length at the sensors.

use num_complex::Complex64;

use crate::linalg::{
    ComplexMatrix, ThinQr, adjoint_product, complex_matrix, solve_lower, solve_lower_adjoint,
};
use crate::modal::ModalModel;

use super::model_roots::Root;
use super::observability::modal_mass_kg;
use super::shapes::Shapes;

/// Standard deviation of a measured value from the sum of the theory's modes, over the root mean
/// square of the shape.
const SHAPE_STD_OVER_RMS: f64 = 0.15;
/// Detuning `|f_j/f_r − f_r/f_j|` above which the allowed coordinate of root j decreases.
const MIN_DETUNING_LIMITED: f64 = 0.1;
/// Detuning from which root j is neglected: its contribution is at most a hundredth there.
const MIN_DETUNING_NEGLECTED: f64 = 1.0;

/// Contribution of a root to a test shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ModalContribution {
    /// Fraction of the shape, 0 to 1.
    pub fraction: f64,
    /// Standard deviation of the fraction.
    pub std: f64,
}

/// The contributions of root `r` to test modes; `None` with fewer than two degrees of freedom in
/// common.
///
/// q minimises `|ψ − Φ q|²/(0.15 ψ_rms)² + Σ |q_j|²/(g_j |ψ|)²` over the roots near r, with `g_j =
/// min(1, 0.1/|f_j/f_r − f_r/f_j|)` and shapes of unit modal mass over the length of r's at the
/// sensors, or of unit length each where a mass is not known. The contribution of root r is
/// `s = |q_r|²/|q|²`, times the fraction `1 − |ψ − Φ q|²/|ψ|²` of the shape that the theory
/// explains; 0 for a root with nodes at all sensors.
///
/// Its standard deviation is that of first order, `2 √(γᴴ C γ)` with `γ_j = (δ_j − s) q_j/|q|²`,
/// δ_j = 1 for the modes of the root and 0 for others, and C the covariance of q, the inverse of
/// half the second derivative of that sum: it is large for few sensors and for similar shapes.
///
/// # Reference
/// O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion process, IMAC 7
/// (coordinates of a measured shape); Fox and Kapoor (1968), AIAA Journal 6, eq. 21 (mixing of
/// first order).
pub(super) fn modal_contributions(
    theory: &ModalModel,
    shapes: &Shapes,
    modes: &[usize],
    r: usize,
    roots: &[Root],
) -> Vec<Option<ModalContribution>> {
    let detuning = |j: &usize| {
        let ratio = theory.modes[*j].frequency_hz / roots[r].hz;
        (ratio - ratio.recip()).abs()
    };
    // The modes of the root come first.
    let others = roots.iter().enumerate().filter(|(other, _)| *other != r);
    let others = others.flat_map(|(_, root)| root.modes.iter().copied());
    let of_r = roots[r].modes.iter().copied();
    let near: Vec<usize> = of_r
        .chain(others.filter(|j| detuning(j) < MIN_DETUNING_NEGLECTED))
        .collect();
    let prior_std: Vec<f64> = near
        .iter()
        .map(|j| (MIN_DETUNING_LIMITED / detuning(j)).min(1.0))
        .collect();
    let of_root = roots[r].modes.len();
    // Test modes with values at the same degrees of freedom share their equations.
    let mut prepared: Vec<(Vec<usize>, Option<ContributionFit>)> = Vec::new();
    let contribution = |&mode: &usize| {
        let dofs = shapes.common_dofs(&[mode], &near);
        let shape = values_at(&shapes.test[mode], &dofs);
        if shape.len() < 2 || squared_length(&shape) <= 0.0 {
            return None;
        }
        let found = prepared.iter().position(|(entry, _)| *entry == dofs);
        let index = found.unwrap_or_else(|| {
            let mut columns: Vec<Vec<Complex64>> = near
                .iter()
                .map(|&j| values_at(&shapes.theory[j], &dofs))
                .collect();
            let moves_sensors = squared_length(&columns[..of_root].concat()) > 0.0;
            let fit = moves_sensors.then(|| {
                scale_columns(theory, &near, of_root, &mut columns);
                ContributionFit::new(columns, of_root, &prior_std)
            });
            prepared.push((dofs, fit));
            prepared.len() - 1
        });
        let none = ModalContribution {
            fraction: 0.0,
            std: 0.0,
        };
        let fit = prepared[index].1.as_ref();
        fit.map_or(Some(none), |fit| fit.contribution(shape))
    };
    modes.iter().map(contribution).collect()
}

/// Values of a shape at some degrees of freedom.
fn values_at(values: &[Option<Complex64>], dofs: &[usize]) -> Vec<Complex64> {
    dofs.iter().filter_map(|&d| values[d]).collect()
}

/// Scales shapes to unit modal mass over the length of the first `of_root` of them where all masses
/// are known, else to unit length each.
fn scale_columns(
    theory: &ModalModel,
    modes: &[usize],
    of_root: usize,
    columns: &mut [Vec<Complex64>],
) {
    let mass = |j: &usize| modal_mass_kg(&theory.modes[*j]);
    let Some(masses) = modes.iter().map(mass).collect::<Option<Vec<f64>>>() else {
        columns.iter_mut().for_each(|column| to_unit_length(column));
        return;
    };
    for (column, mass) in columns.iter_mut().zip(masses) {
        column.iter_mut().for_each(|value| *value /= mass.sqrt());
    }
    let length = (squared_length(&columns[..of_root].concat()) / of_root as f64).sqrt();
    let values = columns.iter_mut().flatten();
    values.for_each(|value| *value /= length);
}

fn squared_length(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum()
}

fn to_unit_length(column: &mut [Complex64]) {
    let length = squared_length(column).sqrt();
    if length > 0.0 {
        column.iter_mut().for_each(|value| *value /= length);
    }
}

/// Regularised least-squares fit of unit-length shapes by the shapes of near roots.
struct ContributionFit {
    /// Theory shapes; the first `of_root` belong to the root.
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
    /// One for each point: prior standard deviations of the coordinates, and the columns times
    /// their squares.
    Points(Vec<f64>, ComplexMatrix),
}

impl ContributionFit {
    fn new(columns: Vec<Vec<Complex64>>, of_root: usize, prior_std: &[f64]) -> Self {
        let points = columns[0].len();
        let deviation = SHAPE_STD_OVER_RMS / (points as f64).sqrt();
        let (lower, unknowns) = if points < columns.len() {
            equations_of_few_points(&columns, prior_std, deviation)
        } else {
            equations_of_many_points(&columns, prior_std, deviation)
        };
        Self {
            columns,
            of_root,
            lower,
            unknowns,
        }
    }

    /// The contribution of the root to a shape that is not zero; `None` where the equations have no
    /// accurate solution.
    fn contribution(&self, mut shape: Vec<Complex64>) -> Option<ModalContribution> {
        to_unit_length(&mut shape);
        let coordinates = self.coordinates(&shape);
        let total = squared_length(&coordinates);
        if !total.is_finite() {
            return None;
        }
        let fraction = if total > 0.0 {
            squared_length(&coordinates[..self.of_root]) / total
        } else {
            0.0
        };
        let gradient = coordinates.iter().enumerate().map(|(j, q)| {
            let indicator = if j < self.of_root { 1.0 } else { 0.0 };
            q * (indicator - fraction) / total.max(f64::MIN_POSITIVE)
        });
        let std = 2.0 * self.std_along(&gradient.collect::<Vec<_>>());
        let explained = explained_fraction(&shape, &self.columns, &coordinates);
        Some(ModalContribution {
            fraction: fraction * explained,
            std: std * explained,
        })
    }

    /// Modal coordinates q of a shape.
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
    fn std_along(&self, gradient: &[Complex64]) -> f64 {
        let along = complex_matrix(gradient.len(), 1, |j, _| gradient[j]);
        let solved = |right: &ComplexMatrix| {
            let solution = solve_lower(&self.lower, right);
            let square = |k: usize| solution[(k, 0)].norm_sqr();
            (0..solution.nrows()).map(square).sum::<f64>()
        };
        let Unknowns::Points(prior_std, weighted) = &self.unknowns else {
            return solved(&along).sqrt();
        };
        // C = G² − G²Φᴴ(ΦG²Φᴴ + d²)⁻¹ΦG².
        let allowed = gradient.iter().zip(prior_std);
        let allowed: f64 = allowed
            .map(|(coordinate, prior_std)| (coordinate * prior_std).norm_sqr())
            .sum();
        (allowed - solved(&(weighted * &along))).max(0.0).sqrt()
    }
}

fn equations_of_many_points(
    columns: &[Vec<Complex64>],
    prior_std: &[f64],
    deviation: f64,
) -> (ComplexMatrix, Unknowns) {
    let (points, modes) = (columns[0].len(), columns.len());
    let matrix = complex_matrix(points + modes, modes, |k, c| match k.checked_sub(points) {
        None => columns[c][k] / deviation,
        Some(pinned) if pinned == c => prior_std[c].recip().into(),
        Some(_) => Complex64::ZERO,
    });
    let qr = ThinQr::or_not_a_number(&matrix);
    let lower = complex_matrix(modes, modes, |i, j| qr.r[(j, i)].conj());
    let upper = complex_matrix(points, modes, |p, c| qr.q[(p, c)] / deviation);
    (lower, Unknowns::Modes(upper))
}

/// The equations with an unknown for each point: `q = G²Φᴴ(ΦG²Φᴴ + d²)⁻¹ψ` from the triangle of
/// `[(ΦG)ᴴ; d]`.
fn equations_of_few_points(
    columns: &[Vec<Complex64>],
    prior_std: &[f64],
    deviation: f64,
) -> (ComplexMatrix, Unknowns) {
    let (points, modes) = (columns[0].len(), columns.len());
    let stacked = complex_matrix(modes + points, points, |k, p| match k.checked_sub(modes) {
        None => columns[k][p].conj() * prior_std[k],
        Some(pinned) if pinned == p => deviation.into(),
        Some(_) => Complex64::ZERO,
    });
    let lower = complex_matrix(points, points, {
        let upper = ThinQr::or_not_a_number(&stacked).r;
        move |i, j| upper[(j, i)].conj()
    });
    let weighted = complex_matrix(points, modes, |p, c| columns[c][p] * prior_std[c].powi(2));
    (lower, Unknowns::Points(prior_std.to_vec(), weighted))
}

/// Fraction of the squared length of a unit shape that the sum of columns explains.
fn explained_fraction(
    shape: &[Complex64],
    columns: &[Vec<Complex64>],
    coordinates: &[Complex64],
) -> f64 {
    let residual = |(k, value): (usize, &Complex64)| {
        let terms = columns.iter().zip(coordinates);
        let sum: Complex64 = terms.map(|(column, q)| column[k] * q).sum();
        (value - sum).norm_sqr()
    };
    let residual: f64 = shape.iter().enumerate().map(residual).sum();
    (1.0 - residual).max(0.0)
}

#[cfg(test)]
mod tests {
    use crate::correlate::model_roots::elastic_roots;
    use crate::correlate::pairing_tests::{mode, model, shape};
    use crate::correlate::{DofMap, PairOptions};
    use crate::modal::{ModeShape, Scaling};

    use super::*;

    /// Contributions of all roots to the only test mode.
    fn contributions_to(shape: &[f64], theory: &ModalModel) -> Vec<Option<f64>> {
        let test = model(vec![mode(100.0, shape)]);
        let map = DofMap::of_models(&test, theory);
        let shapes = Shapes::new(&test, theory, &map, &PairOptions::default()).unwrap();
        let roots = elastic_roots(theory);
        let of = |r| {
            modal_contributions(theory, &shapes, &[0], r, &roots)[0].map(|found| found.fraction)
        };
        (0..roots.len()).map(of).collect()
    }

    fn sum(a: f64, b: f64) -> Vec<f64> {
        let both = shape(1).into_iter().zip(shape(2));
        both.map(|(x, y)| a * x + b * y).collect()
    }

    #[test]
    fn roots_contribute_to_a_mixed_shape_as_it_was_mixed() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let found = contributions_to(&sum(0.8, 0.6), &theory);
        // Six points hold each coordinate to 0.15/sqrt(6).
        assert!((found[0].unwrap() - 0.64).abs() < 0.01, "{found:?}");
        assert!((found[1].unwrap() - 0.36).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn near_roots_of_one_shape_contribute_half_each_and_far_ones_all() {
        let twins = model(vec![mode(100.0, &shape(1)), mode(102.0, &shape(1))]);
        let found = contributions_to(&shape(1), &twins);
        assert!(
            found.iter().all(|one| (one.unwrap() - 0.5).abs() < 0.01),
            "{found:?}"
        );
        // g = 0.1/0.833 = 0.12 for the other; coordinates of one shape go with g²,
        // contributions with g⁴.
        let apart = model(vec![mode(100.0, &shape(1)), mode(150.0, &shape(1))]);
        let found = contributions_to(&shape(1), &apart);
        assert!(found.iter().all(|one| one.unwrap() > 0.999), "{found:?}");
    }

    #[test]
    fn a_root_that_hardly_moves_the_sensors_contributes_less_than_one_that_does() {
        let faint: Vec<f64> = shape(1).iter().map(|v| 1e-3 * v).collect();
        let mut theory = model(vec![mode(100.0, &faint), mode(104.0, &shape(1))]);
        let unknown = contributions_to(&shape(1), &theory);
        assert!((unknown[0].unwrap() - 0.5).abs() < 0.01, "{unknown:?}");
        let masses = theory.modes.iter_mut();
        masses.for_each(|mode| mode.scaling = Scaling::UnitModalMass);
        let found = contributions_to(&shape(1), &theory);
        // To equal the test shape alone it would need a thousand times the amplitude of the
        // other.
        assert!(
            found[0].unwrap() < 1e-4 && found[1].unwrap() > 0.99,
            "{found:?}"
        );
    }

    #[test]
    fn the_contribution_is_that_of_modal_mass_wherever_the_sensors_are() {
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
        let found = contributions_to(&test, &theory);
        assert!((found[0].unwrap() - 0.64).abs() < 0.02, "{found:?}");
        assert!((found[1].unwrap() - 0.36).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn a_contribution_is_less_certain_where_few_sensors_separate_the_shapes() {
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
            modal_contributions(theory, &shapes, &[0], 0, &roots)[0]
                .unwrap()
                .std
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
            ContributionFit::new(columns(points), 1, &[0.5, 0.8])
                .std_along(&gradient)
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
    fn a_root_with_nodes_at_all_sensors_has_no_contribution() {
        let theory = model(vec![mode(100.0, &[0.0; 6]), mode(104.0, &shape(2))]);
        assert_eq!(contributions_to(&shape(2), &theory)[0], Some(0.0));
    }

    #[test]
    fn unknowns_for_points_give_what_unknowns_for_modes_do() {
        let columns: Vec<Vec<Complex64>> = (0..9)
            .map(|c| (0..6).map(|k| Complex64::cis((c * k + c) as f64)).collect())
            .collect();
        let test: Vec<Complex64> = (0..6).map(|k| Complex64::cis((k * k) as f64)).collect();
        let prior_std: Vec<f64> = (1..10).map(|c| 1.0 / f64::from(c)).collect();
        let found = ContributionFit::new(columns.clone(), 1, &prior_std).coordinates(&test);
        // The residual of the normal equations.
        let d = SHAPE_STD_OVER_RMS / 6f64.sqrt();
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
            let penalty = found[c] * d * d / prior_std[c].powi(2);
            assert!((rest - penalty).norm() < 1e-10, "{c}");
        }
    }

    #[test]
    fn a_shape_that_no_root_explains_has_no_contribution() {
        let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
        let found = contributions_to(&shape(4), &theory);
        assert!(found.iter().all(|one| one.unwrap() < 1e-9), "{found:?}");
        assert_eq!(contributions_to(&[], &theory), [None, None]);
    }
}
