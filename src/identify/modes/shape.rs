//! Mode shapes follow from residues, `A_rk = ψ_r L_k`, over responses or over references, scaled to
//! unit modal mass where a driving point allows.
//!
//! By reciprocity `A_rk = φ_r φ_k/(2iω_d m)` for a mode with a nearly real shape, so that the
//! residues of one mode are a matrix of rank one over responses × references. The side with more
//! degrees of freedom carries the shape: the responses of a fixed hammer with many sensors, the
//! references of a roving hammer with one sensor (ties go to the responses). The column with most
//! FRFs, the strongest of them, is the first; every other one that shares a degree of freedom with
//! it is scaled to it by its modal scale factor, and the shape is their least-squares mean, also
//! with missing pairs. A column without a shared degree of freedom is left out.
//!
//! Values stay at the degree of freedom *as labelled*: `3:-Z` keeps its key and its sign, whether
//! it labels a sensor or a hit.
//!
//! *Scale.* Where a function's response and reference are the same point and axis (a driving point,
//! signs `s_r s_k` free), `φ_r² = 2iω_d m s_r s_k A_rk` gives unit modal mass with `m = 1 kg`,
//! provided that this square has a phase within 20° of zero, as of a nearly real mode. Without such
//! an FRF, or with another phase, the modal mass is undetermined and the largest component is 1.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::linalg::{complex_matrix, solve_square};
use crate::modal::{ModeShape, Scaling, modal_scale_factor};

/// Maximum phase of a driving-point residue relative to that of a real mode, rad.
const MAX_REAL_MODE_PHASE_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Minimum number of alternations between shape and factors; each reduces the misfit by the square
/// of the noise.
const ALTERNATIONS: usize = 4;

/// Residues by (response, reference).
pub(in crate::identify) type Residues = BTreeMap<(Dof, Dof), Complex64>;

/// A shape with its scale.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct ScaledShape {
    /// The shape.
    pub shape: ModeShape,
    /// How it is scaled.
    pub scaling: Scaling,
    /// Modal mass for that scale, kg.
    pub modal_mass_kg: Option<f64>,
    /// Relative residual of the residues for one shape, where it has several columns.
    pub misfit: Option<f64>,
}

/// The shape of a mode from its residues and its damped frequency, rad/s.
pub(in crate::identify) fn shape_of(residues: &Residues, damped_rad_s: f64) -> ScaledShape {
    let (shape, misfit) = Columns::new(residues).merge();
    match unit_mass_factor(residues, &shape, damped_rad_s) {
        Some(scale) => ScaledShape {
            shape: ModeShape::new(shape.into_iter().map(|(dof, v)| (dof, scale * v))),
            scaling: Scaling::UnitModalMass,
            modal_mass_kg: Some(1.0),
            misfit,
        },
        None => scaled_to_unit_max(shape, misfit),
    }
}

/// A mode of a pole, with its part of the residues.
pub(in crate::identify) struct ShapedTerm {
    pub residues: Residues,
    pub scaled: ScaledShape,
}

impl ShapedTerm {
    /// Factors of the shape by reference: `L_k` of `A_rk = ψ_r L_k`. Of a shape over references
    /// they are `φ_k/(2iω_d)`, where its modal mass is known.
    fn factors(&self, damped_rad_s: f64) -> BTreeMap<&Dof, Complex64> {
        let columns = Columns::new(&self.residues);
        let shape = &self.scaled.shape;
        let values: Column = columns.rows.iter().map(|row| shape.get(row)).collect();
        if !columns.references_carry_shape {
            let of_column = |column: &Column| factor_of(&values, column);
            let factors = columns.by_other.iter();
            return factors
                .filter_map(|entry| Some((entry.0, of_column(&entry.1)?)))
                .collect();
        }
        let has_unit_mass = self.scaled.scaling == Scaling::UnitModalMass;
        let rows = columns.rows.iter().zip(&values).filter(|_| has_unit_mass);
        let factor = |value: Complex64| value / Complex64::new(0.0, 2.0 * damped_rad_s);
        rows.filter_map(|(row, value)| Some((*row, factor((*value)?))))
            .collect()
    }
}

/// Values of responses of other quantities in the scale of the shapes of a pole, by mode, from
/// their residues: least squares of `A_rk = Σ_j ψ_rj L_jk` over the references k. Responses with
/// fewer references than modes have none.
pub(in crate::identify) fn other_components(
    terms: &[ShapedTerm],
    others: &Residues,
    damped_rad_s: f64,
) -> Vec<ModeShape> {
    let factors: Vec<BTreeMap<&Dof, Complex64>> = terms
        .iter()
        .map(|term| term.factors(damped_rad_s))
        .collect();
    let mut by_response: BTreeMap<&Dof, Vec<(&Dof, Complex64)>> = BTreeMap::new();
    for ((response, reference), residue) in others {
        let of_response = by_response.entry(response).or_default();
        of_response.push((reference, *residue));
    }
    let solved = by_response.into_iter().filter_map(|(response, residues)| {
        let row = |reference: &Dof| -> Option<Vec<Complex64>> {
            let factors = factors.iter();
            factors
                .map(|of_term| of_term.get(reference).copied())
                .collect()
        };
        let known = residues
            .iter()
            .filter_map(|(reference, residue)| Some((row(reference)?, *residue)));
        let known: Vec<(Vec<Complex64>, Complex64)> = known.collect();
        let normal = complex_matrix(terms.len(), terms.len(), |a, b| {
            known.iter().map(|(row, _)| row[a].conj() * row[b]).sum()
        });
        let right = complex_matrix(terms.len(), 1, |a, _| {
            known
                .iter()
                .map(|(row, residue)| row[a].conj() * residue)
                .sum()
        });
        let is_determined = known.len() >= terms.len();
        let components = solve_square(&normal, &right)
            .ok()
            .filter(|_| is_determined)?;
        Some((response, components))
    });
    let solved: Vec<_> = solved.collect();
    let of_term = |term: usize| {
        let components = solved.iter();
        ModeShape::new(components.map(|(response, c)| ((*response).clone(), c[(term, 0)])))
    };
    (0..terms.len()).map(of_term).collect()
}

/// The shape of a mode from residues whose driving points do not determine its modal mass.
pub(in crate::identify) fn unit_max_shape_of(residues: &Residues) -> ScaledShape {
    let (shape, misfit) = Columns::new(residues).merge();
    scaled_to_unit_max(shape, misfit)
}

fn scaled_to_unit_max(shape: BTreeMap<Dof, Complex64>, misfit: Option<f64>) -> ScaledShape {
    ScaledShape {
        shape: ModeShape::new(shape).unit_max(),
        scaling: Scaling::UnitMax,
        modal_mass_kg: None,
        misfit,
    }
}

/// Sign of `φ_r φ_k` where response and reference are the same point and axis; `None` where they
/// are not.
pub(in crate::identify) fn driving_point_sign(response: &Dof, reference: &Dof) -> Option<f64> {
    let same = response.point() == reference.point() && response.axis() == reference.axis();
    same.then(|| response.sign() * reference.sign())
}

/// Whether a squared shape component has the phase of a real mode.
pub(in crate::identify) fn has_real_mode_phase(square: Complex64) -> bool {
    square.norm() > 0.0 && square.arg().abs() <= MAX_REAL_MODE_PHASE_RAD
}

/// Standard deviation of each component of a shape, in its scale, from those of the residues: the
/// smallest over the columns. `None` where a component has none.
pub(in crate::identify) fn shape_stds(
    stds: &BTreeMap<(&Dof, &Dof), f64>,
    residues: &Residues,
    shape: &ModeShape,
) -> Option<BTreeMap<Dof, f64>> {
    let columns = Columns::new(residues);
    let values: Column = columns.rows.iter().map(|row| shape.get(row)).collect();
    let mut best: Vec<Option<f64>> = vec![None; columns.rows.len()];
    for (other, column) in &columns.by_other {
        let Some(factor) = factor_of(&values, column).filter(|factor| factor.norm() > 0.0) else {
            continue;
        };
        for ((row, value), best) in columns.rows.iter().zip(column).zip(&mut best) {
            if value.is_none() {
                continue;
            }
            let pair = match columns.references_carry_shape {
                true => (*other, *row),
                false => (*row, *other),
            };
            let std = stds.get(&pair)? / factor.norm();
            *best = Some(best.map_or(std, |least| least.min(std)));
        }
    }
    let of_shape = columns.rows.iter().zip(&best).zip(&values);
    let component_stds: BTreeMap<Dof, f64> = of_shape
        .filter(|(_, value)| value.is_some())
        .filter_map(|((row, std), _)| Some(((*row).clone(), (*std)?)))
        .collect();
    (component_stds.len() == shape.len()).then_some(component_stds)
}

/// The residue matrix as columns along the longer side.
struct Columns<'a> {
    /// Whether the references carry the shape.
    references_carry_shape: bool,
    /// Degrees of freedom of the longer side, in order.
    rows: Vec<&'a Dof>,
    /// Columns by degree of freedom of the other side, in order.
    by_other: Vec<(&'a Dof, Column)>,
}

/// Values by row, where there are any.
type Column = Vec<Option<Complex64>>;

impl<'a> Columns<'a> {
    fn new(residues: &'a Residues) -> Self {
        let mut responses: Vec<&Dof> = residues.keys().map(|(response, _)| response).collect();
        // Pairs are in the order of their responses.
        responses.dedup();
        let references: BTreeSet<&Dof> = residues.keys().map(|(_, reference)| reference).collect();
        let references: Vec<&Dof> = references.into_iter().collect();
        let references_carry_shape = references.len() > responses.len();
        let (rows, others) = if references_carry_shape {
            (references, responses)
        } else {
            (responses, references)
        };
        let nothing = vec![None; rows.len()];
        let mut by_other: Vec<(&Dof, Column)> = others
            .into_iter()
            .map(|other| (other, nothing.clone()))
            .collect();
        for ((response, reference), value) in residues {
            let (row, other) = if references_carry_shape {
                (reference, response)
            } else {
                (response, reference)
            };
            let row = rows.binary_search(&row);
            let other = by_other.binary_search_by(|(dof, _)| (*dof).cmp(other));
            if let (Ok(row), Ok(other)) = (row, other) {
                by_other[other].1[row] = Some(*value);
            }
        }
        Self {
            references_carry_shape,
            rows,
            by_other,
        }
    }

    /// Least-squares shape of all columns that share degrees of freedom, and its relative residual.
    fn merge(&self) -> (BTreeMap<Dof, Complex64>, Option<f64>) {
        let mut order: Vec<&Column> = self.by_other.iter().map(|(_, column)| column).collect();
        let length = |column: &Column| column.iter().flatten().count();
        let power =
            |column: &Column| -> f64 { column.iter().flatten().map(Complex64::norm_sqr).sum() };
        order.sort_by(|a, b| {
            let longer = length(b).cmp(&length(a));
            longer.then(power(b).total_cmp(&power(a)))
        });
        let mut shape = order
            .first()
            .map_or_else(Column::new, |column| (*column).clone());
        let mut factors = vec![None; order.len()];
        for _ in 0..ALTERNATIONS.max(order.len()) {
            for (factor, column) in factors.iter_mut().zip(&order) {
                *factor = factor_of(&shape, column).or(*factor);
            }
            shape = mean_shape(&order, &factors);
        }
        let misfit = misfit(&order, &factors, &shape);
        let components = self.rows.iter().zip(shape);
        let components = components.filter_map(|(dof, value)| Some(((*dof).clone(), value?)));
        (components.collect(), misfit)
    }
}

/// Factor from the shape to a column, from the degrees of freedom that both have.
fn factor_of(shape: &Column, column: &Column) -> Option<Complex64> {
    let common = shape
        .iter()
        .zip(column)
        .filter_map(|(a, b)| Some(((*a)?, (*b)?)));
    let (shape_values, column_values): (Vec<Complex64>, Vec<Complex64>) = common.unzip();
    modal_scale_factor(&shape_values, &column_values)
}

/// `ψ_r = Σ_k conj(L_k) A_rk / Σ_k |L_k|²` over the columns that have the row.
fn mean_shape(columns: &[&Column], factors: &[Option<Complex64>]) -> Column {
    let rows = columns.first().map_or(0, |column| column.len());
    let mut sums = vec![(Complex64::ZERO, 0.0); rows];
    for (column, factor) in columns.iter().zip(factors) {
        let Some(factor) = factor else { continue };
        for (sum, value) in sums.iter_mut().zip(*column) {
            if let Some(value) = value {
                sum.0 += factor.conj() * value;
                sum.1 += factor.norm_sqr();
            }
        }
    }
    let mean = |(sum, weight): (Complex64, f64)| (weight > 0.0).then(|| sum / weight);
    sums.into_iter().map(mean).collect()
}

fn misfit(columns: &[&Column], factors: &[Option<Complex64>], shape: &Column) -> Option<f64> {
    let (mut unexplained, mut all) = (0.0, 0.0);
    for (column, factor) in columns.iter().zip(factors) {
        let Some(factor) = factor else { continue };
        for (value, shape) in column.iter().zip(shape) {
            let Some(value) = value else { continue };
            unexplained += (value - factor * (*shape)?).norm_sqr();
            all += value.norm_sqr();
        }
    }
    (columns.len() >= 2 && all > 0.0).then(|| (unexplained / all).sqrt())
}

/// Factor from the shape to unit modal mass: the least-squares `κ` of `κ² ψ_r² = 2iω_d s_r s_k
/// A_rk` over all driving points, the largest component turned to a positive real part. `None`
/// without one or with a phase that is not that of a real mode.
fn unit_mass_factor(
    residues: &Residues,
    shape: &BTreeMap<Dof, Complex64>,
    damped_rad_s: f64,
) -> Option<Complex64> {
    let (mut product, mut square, mut total) = (Complex64::ZERO, 0.0, Complex64::ZERO);
    for ((response, reference), residue) in residues {
        let Some(sign) = driving_point_sign(response, reference) else {
            continue;
        };
        let Some(component) = shape.get(response).or_else(|| shape.get(reference)) else {
            continue;
        };
        let phi_squared = Complex64::new(0.0, 2.0 * damped_rad_s * sign) * residue;
        product += (component * component).conj() * phi_squared;
        square += component.norm_sqr().powi(2);
        total += phi_squared;
    }
    if square <= 0.0 || !has_real_mode_phase(total) {
        return None;
    }
    let scale = (product / square).sqrt();
    let largest = ModeShape::new(shape.clone())
        .largest()
        .map(|(_, v)| scale * v)?;
    Some(if largest.re < 0.0 { -scale } else { scale })
}

#[cfg(test)]
mod other_quantity_tests {
    use super::*;

    const DAMPED_RAD_S: f64 = 120.0;

    fn dof(text: &str) -> Dof {
        text.parse().unwrap()
    }

    /// Residues `φ_r φ_k/(2iω_d)` of a shape of unit modal mass.
    fn residues(responses: &[(&str, f64)], references: &[(&str, f64)]) -> Residues {
        let pairs = responses.iter().flat_map(|response| {
            references
                .iter()
                .map(move |reference| (response, reference))
        });
        let residue = Complex64::new(0.0, 2.0 * DAMPED_RAD_S).inv();
        pairs
            .map(|((r, of_r), (k, of_k))| ((dof(r), dof(k)), residue * of_r * of_k))
            .collect()
    }

    fn term(residues: Residues) -> ShapedTerm {
        let scaled = shape_of(&residues, DAMPED_RAD_S);
        ShapedTerm { residues, scaled }
    }

    fn assert_values(found: &[ModeShape], expected: &[f64]) {
        for (shape, expected) in found.iter().zip(expected) {
            let value = shape.get(&dof("9:+S")).unwrap();
            assert!((value / expected - 1.0).norm() < 1e-9, "{value} {expected}");
        }
    }

    #[test]
    fn a_pressure_has_the_scale_of_a_shape_over_the_points_of_a_roving_hammer() {
        let hits = [("1:+Z", 0.5), ("2:+Z", -0.8), ("3:+Z", 0.3)];
        let motion = term(residues(&[("1:+Z", 0.5)], &hits));
        assert_eq!(motion.scaled.scaling, Scaling::UnitModalMass);
        let pressure = residues(&[("9:+S", 7.0)], &hits);
        // The largest component of a shape is positive.
        let sign = motion.scaled.shape.get(&dof("1:+Z")).unwrap().re.signum();
        let found = other_components(&[motion], &pressure, DAMPED_RAD_S);
        assert_values(&found, &[7.0 * sign]);
    }

    #[test]
    fn a_pressure_has_a_value_in_each_mode_of_a_repeated_root() {
        let sensors = |values: [f64; 3]| {
            let names = ["1:+Z", "2:+Z", "3:+Z"];
            std::array::from_fn::<_, 3, _>(|i| (names[i], values[i]))
        };
        let (first, second) = (sensors([0.5, -0.8, 0.3]), sensors([0.4, 0.6, 0.7]));
        let terms = [first, second].map(|shape| term(residues(&shape, &shape[..2])));
        let mut pressure = residues(&[("9:+S", 7.0)], &first[..2]);
        for (pair, value) in residues(&[("9:+S", -2.0)], &second[..2]) {
            *pressure.get_mut(&pair).unwrap() += value;
        }
        let signs = terms.each_ref().map(|term| {
            let first = term.scaled.shape.get(&dof("1:+Z")).unwrap();
            first.re.signum()
        });
        let found = other_components(&terms, &pressure, DAMPED_RAD_S);
        assert_values(&found, &[7.0 * signs[0], -2.0 * signs[1]]);
        // One reference does not separate two modes.
        pressure.retain(|(_, reference), _| *reference == dof("1:+Z"));
        let found = other_components(&terms, &pressure, DAMPED_RAD_S);
        assert!(found.iter().all(ModeShape::is_empty));
    }
}
