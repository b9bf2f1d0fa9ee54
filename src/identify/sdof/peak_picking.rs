//! Peak-picking estimates frequency from the top of a resonance and damping from its half-power
//! points.
//!
//! The top and the half-power points are those of a parabola through the inverse of the power
//! ([`half_power`]), which is exact for one pole.
//!
//! The estimate is made on the weighted sum over FRFs; the scatter of the estimates from single
//! FRFs gives its standard deviation. (Averaging the estimates from single FRFs by peak energy has
//! the same accuracy, but must leave out FRFs near a node, which have no peak.)
//!
//! Reference: Ewins (2000), Modal Testing, 2nd ed., section 4.2.

use std::ops::Range;

use num_complex::Complex64;

use crate::identify::data::half_power::{HalfPower, half_power};
use crate::identify::fit::residues::one_pole;
use crate::identify::sdof::single_mode_method::{
    Isolated, MIN_RESIDUE_SIDE_LINES, RESIDUE_HALF_WINDOW_BANDWIDTHS, SingleModeFit,
    SingleModeMethod,
};
use crate::identify::sdof::weighted_mean::weighted_mean;

/// Alternations between the constants and the pole; each at least halves the remaining error.
const ALTERNATIONS: usize = 10;

/// Peak-picking with half-power damping.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::identify) struct PeakPicking;

fn highest(power: &[f64]) -> Option<usize> {
    (0..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]))
}

/// Power of some FRFs over their noise variance, without the constants under the resonance, which
/// come from a least-squares fit of the pole with constant and slope.
fn power_of(isolated: &Isolated, functions: Range<usize>, lambda: Complex64) -> Vec<f64> {
    let values = &isolated.values[functions.clone()];
    let fit = one_pole(isolated.omega, values, lambda, 3);
    let mut sum = vec![0.0; isolated.omega.len()];
    for (i, (values, variance)) in values.iter().zip(&isolated.variance[functions]).enumerate() {
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += (value - fit[(1, i)]).norm_sqr() / variance;
        }
    }
    sum
}

/// Peak of the summed power of some FRFs, with its height. The fit alternates between the constants
/// and the pole.
fn fit_functions(isolated: &Isolated, functions: Range<usize>) -> Option<(f64, HalfPower)> {
    let mut lambda = isolated.lambda;
    let mut result = None;
    for _ in 0..ALTERNATIONS {
        let power = power_of(isolated, functions.clone(), lambda);
        let top = highest(&power)?;
        let fit = half_power(isolated.omega, &power, top)?;
        lambda = Complex64::new(-fit.decay_rad_s(), fit.omega_rad_s);
        result = Some((power[top], fit));
    }
    result
}

impl SingleModeMethod for PeakPicking {
    fn name(&self) -> &'static str {
        "peak"
    }

    fn window(&self) -> (f64, usize) {
        (RESIDUE_HALF_WINDOW_BANDWIDTHS, MIN_RESIDUE_SIDE_LINES)
    }

    fn fit(&self, isolated: &Isolated) -> Option<SingleModeFit> {
        let count = isolated.values.len();
        let (_, fit) = fit_functions(isolated, 0..count)?;
        let fits = (0..count).filter_map(|f| fit_functions(isolated, f..f + 1));
        let fits: Vec<(f64, HalfPower)> = fits.collect();
        let std = |value: fn(&HalfPower) -> f64| {
            let pairs: Vec<(f64, f64)> = fits.iter().map(|(w, fit)| (*w, value(fit))).collect();
            weighted_mean(&pairs).and_then(|mean| mean.std)
        };
        Some(SingleModeFit {
            lambda: Complex64::new(-fit.decay_rad_s(), fit.omega_rad_s),
            omega_std_rad_s: std(|fit| fit.omega_rad_s),
            decay_std_rad_s: std(HalfPower::decay_rad_s),
            spread: None,
            one_sided: fit.one_sided(),
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::sdof::peak_picking::*;
    use crate::identify::synthetic::white_noise;

    #[test]
    fn summed_power_is_as_accurate_as_the_mean_over_frfs() {
        let lambda = Complex64::new(-2.0, 500.0);
        let omega: Vec<f64> = (0..61).map(|k| 490.0 + k as f64 / 3.0).collect();
        let residues = [1.0, -0.8, 0.6, 0.5, -0.3, 0.1];
        let (mut sum_errors, mut mean_errors) = (0.0, 0.0);
        for seed in 0..100 {
            let values = |(f, a): (usize, &f64)| {
                let noise = white_noise(61, 1e-6, 50 * seed + f as u64);
                let value = |(w, z): (&f64, &Complex64)| a / (Complex64::new(0.0, *w) - lambda) + z;
                omega.iter().zip(&noise).map(value).collect()
            };
            let isolated = Isolated {
                omega: &omega,
                values: residues.iter().enumerate().map(values).collect(),
                variance: vec![1e-6; 6],
                lambda,
            };
            let estimates: Vec<(f64, f64)> = (0..6)
                .filter_map(|f| fit_functions(&isolated, f..f + 1))
                .map(|(power, estimates)| (power, estimates.omega_rad_s))
                .collect();
            let mean = weighted_mean(&estimates).unwrap().mean;
            mean_errors += (mean - 500.0).powi(2);
            sum_errors += (PeakPicking.fit(&isolated).unwrap().lambda.im - 500.0).powi(2);
        }
        let ratio = f64::sqrt(sum_errors / mean_errors);
        assert!((0.8..1.1).contains(&ratio), "{ratio}");
    }
}
