//! The modes that a SEREP reduction keeps are selected by their independence at the sensors.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::ModalModel;

use super::super::model_roots::elastic_modes;
use super::super::shapes::without_rounding;

/// Minimum length of a shape outside the modes kept before, over the largest reading of a kept
/// mode. At 1/100 an error of 1 % at the sensors becomes as large as the shape.
const MIN_INDEPENDENT_LENGTH_FRACTION: f64 = 0.01;

/// Indices of the modes that a SEREP reduction to these sensors keeps, ascending: those that are
/// `paired`, and of the other modes above 0 Hz the lowest, as many as there are sensors.
///
/// A mode whose reading is nearly a sum of those kept before (the independent part is shorter than
/// a hundredth of the largest reading of a kept mode) is independent_length out, so that the
/// condition number of the readings stays near 100 or below. The paired modes alone would project
/// the errors of a test shape out before its orthogonality is computed.
///
/// `dofs` are the sensors as the theory names them; a mode without a value at one of them is
/// independent_length out.
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., sections 5.2.8 and 5.5.7 (the diagonal
/// of R as an estimate of the condition number).
pub fn serep_modes(theory: &ModalModel, dofs: &[Dof], paired: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = elastic_modes(theory);
    let hz = |j: usize| theory.modes[j].frequency_hz;
    order.sort_by(|&a, &b| {
        let later = |j: usize| !paired.contains(&j);
        later(a).cmp(&later(b)).then(hz(a).total_cmp(&hz(b)))
    });
    let readings = |&j: &usize| {
        let shape = &theory.modes[j].shape;
        let values: Option<Vec<_>> = dofs.iter().map(|dof| shape.get(dof).map(Some)).collect();
        Some((j, values?))
    };
    let (order, values): (Vec<usize>, Vec<_>) = order.iter().filter_map(readings).unzip();
    let (mut kept, mut basis) = (paired.to_vec(), Vec::<Vec<Complex64>>::new());
    let mut largest: f64 = 0.0;
    for (j, values) in order.into_iter().zip(without_rounding(values)) {
        let reading: Vec<Complex64> = values.into_iter().flatten().collect();
        let known = paired.contains(&j);
        if !known && kept.len() >= dofs.len() {
            break;
        }
        let residual = orthogonalised(&reading, &basis);
        let (reading_length, independent_length) = (length(&reading), length(&residual));
        if !known
            && independent_length < MIN_INDEPENDENT_LENGTH_FRACTION * largest.max(reading_length)
        {
            continue;
        }
        if !known {
            kept.push(j);
        }
        largest = largest.max(reading_length);
        if independent_length > 0.0 {
            basis.push(
                residual
                    .iter()
                    .map(|value| value / independent_length)
                    .collect(),
            );
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// The residual of a vector after orthogonalisation to an orthonormal basis, twice.
fn orthogonalised(vector: &[Complex64], basis: &[Vec<Complex64>]) -> Vec<Complex64> {
    let mut residual = vector.to_vec();
    for direction in basis.iter().chain(basis) {
        let along: Complex64 = direction
            .iter()
            .zip(&residual)
            .map(|(d, r)| d.conj() * r)
            .sum();
        let both = residual.iter_mut().zip(direction);
        both.for_each(|(r, d)| *r -= along * d);
    }
    residual
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

    #[test]
    fn the_lowest_modes_that_the_sensors_tell_apart_are_kept() {
        assert_eq!(serep_modes(&theory(), &sensors(3), &[]), [1, 4, 5]);
        assert_eq!(serep_modes(&theory(), &sensors(4), &[]), [1, 2, 4, 5]);
        assert_eq!(serep_modes(&theory(), &sensors(1), &[]), [1]);
    }

    #[test]
    fn paired_modes_are_kept_whatever_they_are() {
        assert_eq!(serep_modes(&theory(), &sensors(4), &[6, 1]), [1, 2, 4, 6]);
        assert_eq!(serep_modes(&theory(), &sensors(3), &[2, 1]), [1, 2, 4]);
        assert_eq!(serep_modes(&theory(), &sensors(1), &[1, 4]), [1, 4]);
    }

    #[test]
    fn a_mode_without_a_value_at_a_sensor_is_passed_over() {
        let mut theory = theory();
        let two = theory.modes[1].shape.iter().take(2);
        let two: Vec<_> = two.map(|(dof, v)| (dof.clone(), v)).collect();
        theory.modes[1].shape = crate::modal::ModeShape::new(two);
        assert_eq!(serep_modes(&theory, &sensors(3), &[]), [2, 4, 5]);
    }
}
