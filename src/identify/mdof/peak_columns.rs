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

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::peak_detection::DetectedPeaks;
use crate::identify::mdof::pole_tracks::StablePole;

/// Maximum distance of a column from its peak: half-power bandwidths of its pole or frequency
/// lines, whichever is larger.
const MAX_DISTANCE_BANDWIDTHS: f64 = 1.0;
const MAX_DISTANCE_LINES: f64 = 3.0;

/// The stable pole of each peak, rad/s.
///
/// A pole belongs to its nearest peak. Of several poles of one peak, the column is the pole with the
/// largest number of orders times `1 − d/d_max`, where `d` is its distance from the peak.
pub(in crate::identify) fn peak_columns(
    stable_poles: &[StablePole],
    found: &DetectedPeaks,
    frfs: &BandFrfs,
) -> Vec<Complex64> {
    let peaks = found.of_any_direction().into_iter();
    let peaks: Vec<f64> = peaks.map(|peak| frfs.omega[peak.line]).collect();
    let mut columns: Vec<Option<(f64, Complex64)>> = vec![None; peaks.len()];
    for stable in stable_poles {
        let lambda = stable.pole.lambda;
        let distance = |peak: &usize| (lambda.im - peaks[*peak]).abs();
        let nearest = (0..peaks.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(peak) = nearest else { break };
        let bandwidth = 2.0 * lambda.re.abs();
        let max_distance =
            (MAX_DISTANCE_BANDWIDTHS * bandwidth).max(MAX_DISTANCE_LINES * frfs.step);
        let nearness = 1.0 - distance(&peak) / max_distance;
        let score = stable.orders.len() as f64 * nearness;
        if score > columns[peak].map_or(0.0, |(highest, _)| highest) {
            columns[peak] = Some((score, lambda));
        }
    }
    columns
        .into_iter()
        .flatten()
        .map(|(_, lambda)| lambda)
        .collect()
}

/// Marks the poles of columns. Of several modes at one pole, the first is marked.
pub(in crate::identify) fn mark_columns(poles: &mut [ModelPole], columns: &[Complex64]) {
    for column in columns {
        if let Some(pole) = poles.iter_mut().find(|pole| pole.lambda == *column) {
            pole.is_peak_column = true;
        }
    }
}
