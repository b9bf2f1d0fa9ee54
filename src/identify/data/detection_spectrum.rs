//! Mode indicator: the power of all FRFs on one axis, in which peaks are searched.
//!
//! `S_k = Σ_f w_f ω_k² |R_fk|²`: a weighted sum of squared *mobilities*. A viscously damped mode is
//! symmetric in mobility (its peak is at the natural frequency, its half-power points at
//! `ω_n(√(1+ζ²) ∓ ζ)`), and neither the stiffness line that dominates a receptance at low
//! frequencies nor the mass line that dominates an accelerance at high ones hides a peak. The
//! weight of an FRF is the inverse of its noise variance (the median over the band) where the data
//! supply the variances, else of its mean square, so that no FRF dominates.

use num_complex::Complex64;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_noise::LineNoise;

/// Weighted power of all FRFs.
pub(in crate::identify) struct DetectionSpectrum {
    /// `S_k` at every line.
    pub power: Vec<f64>,
    /// `w_f` of every FRF.
    pub weights: Vec<f64>,
}

impl DetectionSpectrum {
    /// The indicator of the FRFs of a band; `stated` is the noise of each, where the data supply
    /// it.
    pub fn new(frfs: &BandFrfs, stated: Option<&[LineNoise]>) -> Self {
        let weight = |f: usize| weight(frfs, f, stated.map(|noise| &noise[f]));
        let weights: Vec<f64> = (0..frfs.functions()).map(weight).collect();
        let mut power = vec![0.0; frfs.lines()];
        for (f, weight) in weights.iter().enumerate() {
            let values = frfs.values.all_of(f);
            for ((sum, value), omega) in power.iter_mut().zip(values.iter()).zip(&frfs.omega) {
                *sum += weight * omega * omega * value.norm_sqr();
            }
        }
        Self { power, weights }
    }
}

fn weight(frfs: &BandFrfs, function: usize, noise: Option<&LineNoise>) -> f64 {
    let squared = |k: usize| frfs.omega[k] * frfs.omega[k];
    let scale = if let Some(noise) = noise {
        let mut variances: Vec<f64> = (0..frfs.lines())
            .map(|k| squared(k) * noise.variance(k))
            .collect();
        let middle = variances.len() / 2;
        *variances.select_nth_unstable_by(middle, f64::total_cmp).1
    } else {
        let values = frfs.values.all_of(function);
        let power = |(k, value): (usize, &Complex64)| squared(k) * value.norm_sqr();
        values.iter().enumerate().map(power).sum::<f64>() / frfs.lines() as f64
    };
    if scale > 0.0 { 1.0 / scale } else { 0.0 }
}
