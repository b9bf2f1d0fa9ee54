//! The modes that a SEREP reduction keeps are selected by the condition number of their readings.

use num_complex::Complex64;
use serde::Serialize;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::{complex_matrix, singular_values};
use crate::modal::ModalModel;

use super::super::model_roots::elastic_modes;
use super::super::shapes::without_rounding;

/// Maximum condition number of the readings of the modes that a reduction keeps. Larger, at 30: an
/// error of 6 % of a shape (MAC 0.996) lowers its cross-orthogonality to 0.8, and at 5,000 to less
/// than 0.4. Smaller, at 4: half of the modes that the sensors separate are lost. Test
/// `errors_of_shapes_hardly_lower_the_cross_orthogonality`.
const MAX_CONDITION_NUMBER: f64 = 10.0;

/// Modes that a SEREP reduction keeps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SerepModes {
    /// Their indices, ascending.
    #[serde(skip)]
    pub kept: Vec<usize>,
    /// Indices of the paired modes that the sensors do not separate from those kept, ascending.
    #[serde(skip)]
    pub paired_left_out: Vec<usize>,
    /// Condition number of the readings of the kept modes, each over its length; 0 of none.
    pub condition_number: f64,
    /// Maximum condition number.
    pub max_condition_number: f64,
}

impl SerepModes {
    /// The paired modes that are left out, as a finding.
    pub fn finding(&self) -> Option<Finding> {
        let count = self.paired_left_out.len();
        let finding = Finding::new(
            Severity::Warning,
            Code::ReductionModesLeftOut,
            Location::Whole,
        );
        let finding = finding.value(count as f64, "").detail(format!(
            "{} modes kept, condition number {:.1}, at most {:.0}",
            self.kept.len(),
            self.condition_number,
            self.max_condition_number
        ));
        (count > 0).then_some(finding)
    }
}

/// Modes that a SEREP reduction to these sensors keeps: those that are `paired`, and of the other
/// modes above 0 Hz the lowest, as long as the condition number of their readings is at most 10.
///
/// The condition number is the factor by which an error of a shape at the sensors becomes larger in
/// the combination of the kept modes. The paired modes alone would project the errors of a test
/// shape out before its orthogonality is computed.
///
/// `dofs` are the sensors as the theory names them; a mode without a value at one of them is left
/// out.
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., section 5.5.7 (condition of least
/// squares).
pub fn serep_modes(theory: &ModalModel, dofs: &[Dof], paired: &[usize]) -> SerepModes {
    let mut order: Vec<usize> = elastic_modes(theory);
    let hz = |j: usize| theory.modes[j].frequency_hz;
    order.sort_by(|&a, &b| {
        let later = |j: usize| !paired.contains(&j);
        later(a).cmp(&later(b)).then(hz(a).total_cmp(&hz(b)))
    });
    well_conditioned(theory, dofs, paired, &order)
}

/// The paired modes that a SEREP expansion from these sensors keeps, as [`serep_modes`].
pub fn expansion_modes(theory: &ModalModel, dofs: &[Dof], paired: &[usize]) -> SerepModes {
    let mut order = paired.to_vec();
    order.sort_by(|&a, &b| {
        let hz = |j: usize| theory.modes[j].frequency_hz;
        hz(a).total_cmp(&hz(b))
    });
    well_conditioned(theory, dofs, paired, &order)
}

/// Of modes in an order, each that keeps the condition number within its maximum.
fn well_conditioned(
    theory: &ModalModel,
    dofs: &[Dof],
    paired: &[usize],
    order: &[usize],
) -> SerepModes {
    let readings = |&j: &usize| {
        let shape = &theory.modes[j].shape;
        let values: Option<Vec<_>> = dofs.iter().map(|dof| shape.get(dof).map(Some)).collect();
        Some((j, values?))
    };
    let (order, values): (Vec<usize>, Vec<_>) = order.iter().filter_map(readings).unzip();
    let rows = without_rounding(values).into_iter();
    let rows: Vec<Vec<Complex64>> = rows
        .map(|row| row.into_iter().flatten().collect())
        .collect();
    let is_paired = |at: usize| paired.contains(&order[at]);
    let longest = |of: &dyn Fn(usize) -> bool| {
        let lengths = (0..rows.len())
            .filter(|at| of(*at))
            .map(|at| length(&rows[at]));
        lengths.fold(0.0, f64::max)
    };
    let reference = match (0..order.len()).any(is_paired) {
        true => longest(&is_paired),
        false => longest(&|_| true),
    };
    // A mode that hardly moves the sensors is as badly determined as one that they do not separate.
    let unit = |at: usize| {
        let least = if is_paired(at) { 0.0 } else { reference };
        let scale = length(&rows[at]).max(least).max(f64::MIN_POSITIVE);
        rows[at].iter().map(|value| value / scale).collect()
    };
    let columns: Vec<Vec<Complex64>> = (0..order.len()).map(unit).collect();
    let mut kept = Vec::new();
    extend(&mut kept, &(0..columns.len()).collect::<Vec<_>>(), &columns);
    let condition_number = match kept.is_empty() {
        true => 0.0,
        false => condition_number(&kept, &columns),
    };
    let mut kept: Vec<usize> = kept.into_iter().map(|at| order[at]).collect();
    kept.sort_unstable();
    let mut paired_left_out = paired.to_vec();
    paired_left_out.retain(|j| !kept.contains(j));
    paired_left_out.sort_unstable();
    SerepModes {
        kept,
        paired_left_out,
        condition_number,
        max_condition_number: MAX_CONDITION_NUMBER,
    }
}

/// Adds each column of a block that keeps the condition number within its maximum, in order: the
/// whole block, else its halves. The condition number only rises with further columns.
fn extend(kept: &mut Vec<usize>, block: &[usize], columns: &[Vec<Complex64>]) {
    let rows = columns.first().map_or(0, Vec::len);
    if block.is_empty() || kept.len() >= rows {
        return;
    }
    let all = [kept.as_slice(), block].concat();
    if all.len() <= rows && condition_number(&all, columns) <= MAX_CONDITION_NUMBER {
        *kept = all;
    } else if block.len() > 1 {
        let (first, second) = block.split_at(block.len() / 2);
        extend(kept, first, columns);
        extend(kept, second, columns);
    }
}

/// Largest over smallest singular value of some columns; infinite where they are dependent.
fn condition_number(chosen: &[usize], columns: &[Vec<Complex64>]) -> f64 {
    let rows = columns.first().map_or(0, Vec::len);
    let matrix = complex_matrix(rows, chosen.len(), |i, j| columns[chosen[j]][i]);
    let values = singular_values(&matrix).unwrap_or_default();
    match (values.first(), values.last()) {
        (Some(largest), Some(smallest)) if *smallest > 0.0 => largest / smallest,
        _ => f64::INFINITY,
    }
}

fn length(vector: &[Complex64]) -> f64 {
    vector.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::models::{dof, model};
    use super::*;

    fn theory() -> ModalModel {
        model(&[
            (0.0, &[1.0, 1.0, 1.0, 1.0]),
            (10.0, &[1.0, 0.0, 0.0, 1.0]),
            // Only 0.5 % of this mode is not of the one before, at the first three sensors.
            (20.0, &[1.0, 0.005, 0.0, -1.0]),
            // No sensor sees this one.
            (30.0, &[0.0, 0.0, 0.0, 0.0]),
            (40.0, &[0.0, 0.0, 1.0, 0.0]),
            (50.0, &[0.0, 1.0, 1.0, 0.0]),
            (60.0, &[0.0, 1.0, 2.0, 0.0]),
        ])
    }

    fn sensors(count: usize) -> Vec<Dof> {
        (1..=count).map(dof).collect()
    }

    fn kept(theory: &ModalModel, count: usize, paired: &[usize]) -> Vec<usize> {
        serep_modes(theory, &sensors(count), paired).kept
    }

    #[test]
    fn the_lowest_modes_that_the_sensors_separate_are_kept() {
        assert_eq!(kept(&theory(), 3, &[]), [1, 4, 5]);
        assert_eq!(kept(&theory(), 4, &[]), [1, 2, 4, 5]);
        assert_eq!(kept(&theory(), 1, &[]), [1]);
    }

    #[test]
    fn paired_modes_come_first_and_those_that_the_sensors_do_not_separate_are_reported() {
        assert_eq!(kept(&theory(), 4, &[6, 1]), [1, 2, 4, 6]);
        let found = serep_modes(&theory(), &sensors(3), &[2, 1]);
        assert_eq!(
            (found.kept, found.paired_left_out),
            (vec![1, 4, 5], vec![2])
        );
        let found = expansion_modes(&theory(), &sensors(3), &[2, 1]);
        assert_eq!(found.kept, [1]);
        let finding = found.finding().unwrap();
        assert_eq!(
            (finding.code, finding.value),
            (Code::ReductionModesLeftOut, Some(1.0))
        );
        let both = expansion_modes(&theory(), &sensors(4), &[1, 2]);
        assert_eq!((both.kept.as_slice(), both.finding()), (&[1, 2][..], None));
        assert!(both.condition_number < 1.1, "{both:?}");
    }

    #[test]
    fn a_mode_without_a_value_at_a_sensor_is_passed_over() {
        let mut theory = theory();
        let two = theory.modes[1].shape.iter().take(2);
        let two: Vec<_> = two.map(|(dof, v)| (dof.clone(), v)).collect();
        theory.modes[1].shape = crate::modal::ModeShape::new(two);
        assert_eq!(kept(&theory, 3, &[]), [2, 4, 5]);
    }
}
