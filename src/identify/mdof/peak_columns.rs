//! The columns of the stabilization diagram that stand on a peak: one stable pole for each peak.
//!
//! An engineer takes a column of stable poles under a peak of the FRFs as a mode. The residual of
//! the fit plays no part in that, because everything that the FRFs contain and the model does not
//! biases these methods: natural frequencies that differ between FRFs, amplitude dependence,
//! leakage. The noise limits neither this bias nor the residual. It therefore enlarges the standard
//! deviation of such a pole, and is no reason to remove it.
//!
//! Reference: Peeters, Van der Auweraer, Guillaume and Leuridan (2004), The PolyMAX
//! frequency-domain method: a new standard for modal parameter estimation?, Shock and Vibration
//! 11(3-4).

use num_complex::Complex64;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::mdof::pole_tracks::StablePole;

/// Maximum distance of a column from its peak in half-power bandwidths of its pole. Larger: a pole
/// on the flank of a peak is its column. Smaller, 0.5: 3 of 91 modes of amplitude-dependent
/// structures are lost (`column_lies_within_a_bandwidth_of_its_peak`).
const MAX_DISTANCE_BANDWIDTHS: f64 = 1.0;
/// The same in frequency lines, where that is more. Larger, 12: a column that ends at a middle
/// order is preferred to a nearer one (`nearer_column_is_preferred`), as in a recorded hammer test.
/// Smaller, 0: poles narrower than a line lie between lines, and 3 modes of two recordings are
/// lost (`column_narrower_than_a_line_belongs_to_the_nearest_line`).
const MAX_DISTANCE_LINES: f64 = 3.0;

/// The stable pole of each peak, rad/s; `step_rad_s` is the spacing of the lines.
///
/// A pole belongs to its nearest peak. Of several poles of one peak, the column is the one with the
/// largest number of orders times `1 − d/d_max`, where `d` is its distance from the peak.
pub(in crate::identify) fn peak_columns(
    stable_poles: &[StablePole],
    peaks_rad_s: &[f64],
    step_rad_s: f64,
) -> Vec<Complex64> {
    let mut columns: Vec<Option<(f64, Complex64)>> = vec![None; peaks_rad_s.len()];
    for stable in stable_poles {
        let lambda = stable.pole.lambda;
        let distance = |peak: &usize| (lambda.im - peaks_rad_s[*peak]).abs();
        let peaks = 0..peaks_rad_s.len();
        let Some(peak) = peaks.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
            break;
        };
        let bandwidth = 2.0 * lambda.re.abs();
        let max_distance =
            (MAX_DISTANCE_BANDWIDTHS * bandwidth).max(MAX_DISTANCE_LINES * step_rad_s);
        let nearness = 1.0 - distance(&peak) / max_distance;
        let score = stable.orders.len() as f64 * nearness;
        if score > columns[peak].map_or(0.0, |(highest, _)| highest) {
            columns[peak] = Some((score, lambda));
        }
    }
    let columns = columns.into_iter().flatten();
    columns.map(|(_, lambda)| lambda).collect()
}

/// Marks the poles of columns. Of several modes at one pole, the first is marked.
pub(in crate::identify) fn mark_columns(poles: &mut [ModelPole], columns: &[Complex64]) {
    for column in columns {
        if let Some(pole) = poles.iter_mut().find(|pole| pole.lambda == *column) {
            pole.is_peak_column = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::mdof::peak_columns::*;
    use crate::identify::mdof::pole_tracks::{GlobalPole, OrderPoles, stable_poles};

    /// Columns over a number of orders: frequency in lines, decay rate in lines, number of orders.
    fn stable(columns: &[(f64, f64, usize)]) -> Vec<StablePole> {
        let pole = |(line, decay, _): &(f64, f64, usize)| GlobalPole {
            lambda: Complex64::new(-decay, *line),
            participation: vec![Complex64::ONE],
        };
        let table = |order: usize| -> OrderPoles {
            let present = columns.iter().filter(|column| order < column.2);
            (order, present.map(pole).collect())
        };
        let tables: Vec<OrderPoles> = (0..20).map(table).collect();
        stable_poles(&tables, 1.0)
    }

    fn lines(columns: &[(f64, f64, usize)], peaks: &[f64]) -> Vec<f64> {
        let columns = peak_columns(&stable(columns), peaks, 1.0);
        columns.iter().map(|lambda| lambda.im).collect()
    }

    #[test]
    fn column_lies_within_a_bandwidth_of_its_peak() {
        // A bandwidth of 20 lines.
        assert_eq!(lines(&[(114.0, 10.0, 12)], &[100.0]), [114.0]);
        assert!(lines(&[(130.0, 10.0, 12)], &[100.0]).is_empty());
    }

    #[test]
    fn column_narrower_than_a_line_belongs_to_the_nearest_line() {
        assert_eq!(lines(&[(100.5, 0.05, 5)], &[100.0]), [100.5]);
        assert!(lines(&[(104.0, 0.05, 5)], &[100.0]).is_empty());
    }

    #[test]
    fn nearer_column_is_preferred() {
        let columns = [(98.75, 0.5, 8), (99.5, 0.2, 7)];
        assert_eq!(lines(&columns, &[100.0]), [99.5]);
    }

    #[test]
    fn each_peak_has_one_column_and_a_pole_belongs_to_its_nearest_peak() {
        let columns = [(100.0, 8.0, 12), (112.0, 8.0, 5), (120.0, 8.0, 9)];
        assert_eq!(lines(&columns, &[101.0, 119.0]), [100.0, 120.0]);
        assert!(lines(&columns, &[]).is_empty());
    }
}
