//! Mode indicator: the power of all FRFs on one axis, in which peaks are searched.
//!
//! `S_k = Σ_f w_f ω_k² |R_fk|²`: a weighted sum of squared *mobilities*. A viscously damped mode is
//! symmetric in mobility (its peak is at the natural frequency, its half-power points at
//! `ω_n(√(1+ζ²) ∓ ζ)`), and neither the stiffness line that dominates a receptance at low
//! frequencies nor the mass line that dominates an accelerance at high ones hides a peak. The
//! weight of an FRF is the inverse of its noise variance (the median over the band) where the data
//! supply the variances, else of its mean square, so that no FRF dominates.

use crate::identify::data::band_frfs::BandFrfs;

/// Weighted power of all FRFs.
pub(in crate::identify) struct DetectionSpectrum {
    /// `S_k` at every line.
    pub power: Vec<f64>,
    /// `w_f` of every FRF.
    pub weights: Vec<f64>,
}

impl DetectionSpectrum {
    /// The indicator of a set of receptances.
    pub fn new(data: &BandFrfs) -> Self {
        let weights: Vec<f64> = (0..data.functions()).map(|f| weight(data, f)).collect();
        let mut power = vec![0.0; data.lines()];
        for (values, weight) in data.values.iter().zip(&weights) {
            for ((sum, value), omega) in power.iter_mut().zip(values).zip(&data.omega) {
                *sum += weight * omega * omega * value.norm_sqr();
            }
        }
        Self { power, weights }
    }
}

fn weight(data: &BandFrfs, function: usize) -> f64 {
    let squared = |k: usize| data.omega[k] * data.omega[k];
    let scale = if data.variance_measured() {
        let mut variances: Vec<f64> = (0..data.lines())
            .map(|k| squared(k) * data.variance[function][k])
            .collect();
        let middle = variances.len() / 2;
        *variances.select_nth_unstable_by(middle, f64::total_cmp).1
    } else {
        let power = |k: usize| squared(k) * data.values[function][k].norm_sqr();
        (0..data.lines()).map(power).sum::<f64>() / data.lines() as f64
    };
    if scale > 0.0 { 1.0 / scale } else { 0.0 }
}
