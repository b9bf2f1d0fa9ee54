//! Noise of a range of lines as the fit weights it: a level per FRF and a profile over the lines.

use std::ops::Range;

use rayon::prelude::*;

use crate::identify::noise::model::NoiseModel;

/// Lines whose sums fit into the nearest cache.
const CACHE_LINES: usize = 1024;

/// Variance of FRF f at line k of the range: `level_f² noise_profile_k²`.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct BandProfile {
    /// Root of the mean variance of each FRF, m/N.
    pub level: Vec<f64>,
    /// Relative profile over the lines of the range; its square has the mean 1.
    pub noise_profile: Vec<f64>,
}

impl BandProfile {
    /// Profile of a range of lines.
    pub fn new(noise: &NoiseModel, lines: Range<usize>) -> Self {
        let functions = noise.by_frf.len();
        let mean: Vec<f64> = (0..functions)
            .into_par_iter()
            .map(|f| noise.mean_variance(f, lines.clone()))
            .collect();
        let mut noise_profile = vec![0.0; lines.len()];
        let pieces = noise_profile.par_chunks_mut(CACHE_LINES).enumerate();
        pieces.for_each(|(number, sums)| {
            let first = lines.start + number * CACHE_LINES;
            for (noise, mean) in noise.by_frf.iter().zip(&mean) {
                let weight = (mean * functions as f64).recip();
                let variances = noise.variances(first..first + sums.len());
                for (sum, v) in sums.iter_mut().zip(variances) {
                    *sum += v * weight;
                }
            }
            sums.iter_mut().for_each(|sum| *sum = sum.sqrt());
        });
        let level = mean.into_iter().map(f64::sqrt).collect();
        Self {
            level,
            noise_profile,
        }
    }
}
