//! Mean natural frequency over measurement runs, where it differs between them by more than noise.
//!
//! A fit of all FRFs weights each run by the energy of its response. What is stated is the mean
//! over the runs. One Gauss-Newton step of the pole from the FRFs of run r alone is
//!
//! ```text
//! δ_r = Σ_f Σ_k conj(a_f g_k/l_f) r_fk / Σ_f Σ_k |a_f g_k/l_f|²,   f in run r
//! v_r = 1 / (2 Σ_f Σ_k |a_f g_k/l_f|²)
//! ```
//!
//! with the residues a, the noise levels l of the FRFs, the residual r over the profile of the
//! noise, and g the part of `1/(iω − λ)²`, over that profile, that out-of-band terms and the poles
//! around do not explain. The variance τ² between runs follows from `Σ (δ_r − m)²/(v_r + τ²) = n −
//! 1` with `m = Σ w_r δ_r`, `w_r ∝ 1/(v_r + τ²)` (Paule and Mandel 1982, Journal of Research of the
//! NBS 87). The standard deviation of m is `(Σ 1/(v_r + τ²))^(−1/2)`, times the ratio of Student's
//! and the normal quantile, as τ² has n − 1 degrees of freedom. The variances v_r are multiplied by
//! the chi-square of the decay rates, where that is above one for each degree of freedom; the
//! standard deviation of the mean decay rate is `(Σ 1/v_r)^(−1/2)` of them.

use num_complex::Complex64;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandBasis;
use crate::identify::data::residual::{PredictedResponse, Residual};
use crate::identify::fit::block_descent::window;
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::pole_covariance::{FitLines, orthogonal_derivative};
use crate::identify::noise::band_profile::BandProfile;

/// Minimum number of runs: of fewer the scatter is unknown.
const MIN_RUNS: usize = 3;
/// Separation from the nearest pole, in sums of half-power bandwidths, below which the steps of the
/// runs are those of both poles (`close_pairs_are_not_merged`).
const MIN_SEPARATION: f64 = 1.0;
/// Response of a run, as energy over the noise and over that of the strongest run, below which its
/// step is that of its misfit.
const MIN_RELATIVE_WEIGHT: f64 = 1e-3;
/// Probability of noise beyond the limit of the test for a scatter between runs.
const FALSE_ALARM_PROBABILITY: f64 = 1e-3;
/// Upper quantile of a 95 % interval.
const QUANTILE: f64 = 0.975;
/// Bisections of τ².
const BISECTIONS: usize = 60;

/// Fit of all FRFs, from which the runs may differ.
pub(in crate::identify) struct RunMeans<'a> {
    data: &'a FitData,
    poles: &'a [ModelPole],
    runs: &'a [Vec<usize>],
    /// Residual on all lines, over the noise.
    residual: Residual,
}

/// Mean of a frequency over runs, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct RunMean {
    /// Mean less the frequency of the fit.
    pub shift: f64,
    /// Standard deviation of that mean.
    pub std: f64,
    /// Standard deviation between runs.
    pub scatter: f64,
    /// Standard deviation of the mean decay rate, from its scatter between runs.
    pub decay_std: f64,
}

impl<'a> RunMeans<'a> {
    /// Runs of a fit; `None` for too few.
    pub fn new(
        data: &'a FitData,
        poles: &'a [ModelPole],
        described: &PredictedResponse,
        runs: &'a [Vec<usize>],
    ) -> Option<Self> {
        (runs.len() >= MIN_RUNS).then(|| Self {
            data,
            poles,
            runs,
            residual: described.residual(0..data.frfs.lines()),
        })
    }

    /// The mean of a pole over the runs, whose `known_shifts` have been corrected in the data;
    /// `None` where noise explains the scatter.
    pub fn of(&self, pole: &ModelPole, known_shifts: Option<&[Complex64]>) -> Option<RunMean> {
        let is_other = |other: &&ModelPole| !other.is_companion && other.lambda != pole.lambda;
        let mut others = self.poles.iter().filter(is_other);
        if others.any(|other| pole.separation(other) < MIN_SEPARATION) {
            return None;
        }
        let steps = self.steps(pole)?;
        mean_over_runs(&total_shifts(&steps, known_shifts))
    }

    /// Step of the pole in each run, rad/s, with the variance of each of its parts in the noise;
    /// `None` for a run with little response.
    fn steps(&self, pole: &ModelPole) -> Option<Vec<Option<(Complex64, f64)>>> {
        let frfs = &self.data.frfs;
        let lines = window(frfs, std::iter::once(pole));
        let BandProfile {
            level,
            noise_profile,
        } = BandProfile::new(&self.data.noise, lines.clone());
        let fit = FitLines {
            lines: lines.clone(),
            noise_profile: &noise_profile,
            background: OutOfBandBasis::new(&frfs.omega, &lines, self.data.out_of_band_terms()),
        };
        let derivative = orthogonal_derivative(frfs, self.poles, pole, &fit)?;
        let energy: f64 = derivative.iter().map(Complex64::norm_sqr).sum();
        // The derivative is of (d/(iω − λ))² with the decay rate d.
        let scale = pole.decay().powi(2);
        let correlated_over_white = (pole.quality.pole_std / pole.quality.pole_bound).powi(2);
        let weight = |run: &Vec<usize>| -> f64 {
            let ratios = run
                .iter()
                .map(|f| (pole.residues[*f] / level[*f]).norm_sqr());
            ratios.sum()
        };
        let largest = self.runs.iter().map(weight).fold(0.0, f64::max);
        let step = |run: &Vec<usize>| {
            let (mut along, mut weight) = (Complex64::ZERO, 0.0);
            for &f in run {
                let factor = pole.residues[f].conj() / level[f];
                let residual = self.residual.of(f, lines.clone());
                let stds = self.data.noise.by_frf[f].stds(lines.clone());
                let values = residual.zip(stds).zip(&noise_profile);
                for (((r, std), profile), g) in values.zip(&derivative) {
                    along += g.conj() * factor * r * (std / (level[f] * profile));
                }
                weight += factor.norm_sqr();
            }
            let step = along * scale / (weight * energy);
            let variance = 0.5 * scale * scale / (weight * energy) * correlated_over_white;
            let is_determined = variance > 0.0 && weight > MIN_RELATIVE_WEIGHT * largest;
            (step.is_finite() && is_determined).then_some((step, variance))
        };
        Some(self.runs.iter().map(step).collect())
    }
}

/// Step of each run that has one, with the shift of the same run that is corrected in the data.
fn total_shifts(
    steps: &[Option<(Complex64, f64)>],
    known_shifts: Option<&[Complex64]>,
) -> Vec<(Complex64, f64)> {
    let known = |run: usize| known_shifts.map_or(Complex64::ZERO, |shifts| shifts[run]);
    let total = |(run, step): (usize, &Option<(Complex64, f64)>)| {
        let (step, variance) = (*step)?;
        Some((step + known(run), variance))
    };
    steps.iter().enumerate().filter_map(total).collect()
}

/// The mean of the frequencies of shifts, with the variances of their parts; `None` where these
/// explain the scatter. What makes the decay rates scatter (misfit) does so with the frequencies.
pub(super) fn mean_over_runs(shifts: &[(Complex64, f64)]) -> Option<RunMean> {
    let count = shifts.len();
    if count < MIN_RUNS {
        return None;
    }
    let freedom = (count - 1) as f64;
    let misfit = decay_chi_square(shifts).max(1.0);
    let decay_std = (misfit / information(shifts)).sqrt();
    let shifts: Vec<(f64, f64)> = shifts
        .iter()
        .map(|(shift, v)| (shift.im, misfit * v))
        .collect();
    let weights = |between: f64| -> Vec<f64> {
        let weights: Vec<f64> = shifts.iter().map(|(_, v)| (v + between).recip()).collect();
        let sum: f64 = weights.iter().sum();
        weights.into_iter().map(|weight| weight / sum).collect()
    };
    let mean = |weights: &[f64]| -> f64 {
        shifts
            .iter()
            .zip(weights)
            .map(|((shift, _), weight)| shift * weight)
            .sum()
    };
    let chi_square = |between: f64| -> f64 {
        let mean = mean(&weights(between));
        let terms = shifts
            .iter()
            .map(|(shift, v)| (shift - mean).powi(2) / (v + between));
        terms.sum()
    };
    let limit = ChiSquared::new(freedom)
        .ok()?
        .inverse_cdf(1.0 - FALSE_ALARM_PROBABILITY);
    let before = chi_square(0.0);
    if before.is_nan() || before <= limit {
        return None;
    }
    let plain = mean(&vec![(count as f64).recip(); count]);
    let (mut low, mut high) = (0.0, 0.0f64);
    for (shift, _) in &shifts {
        high += (shift - plain).powi(2);
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if chi_square(middle) > freedom {
            low = middle;
        } else {
            high = middle;
        }
    }
    let weights = weights(high);
    let of_mean: f64 = shifts.iter().map(|(_, v)| (v + high).recip()).sum();
    let student = StudentsT::new(0.0, 1.0, freedom)
        .ok()?
        .inverse_cdf(QUANTILE);
    let normal = Normal::standard().inverse_cdf(QUANTILE);
    Some(RunMean {
        shift: mean(&weights),
        std: student / normal / of_mean.sqrt(),
        scatter: high.sqrt(),
        decay_std,
    })
}

/// `Σ 1/v` of the runs.
fn information(shifts: &[(Complex64, f64)]) -> f64 {
    shifts.iter().map(|(_, v)| v.recip()).sum()
}

/// Chi-square of the decay rates of the runs about their mean, for each degree of freedom.
fn decay_chi_square(shifts: &[(Complex64, f64)]) -> f64 {
    let decay = shifts.iter().map(|(shift, v)| shift.re / v).sum::<f64>() / information(shifts);
    let squares = shifts
        .iter()
        .map(|(shift, v)| (shift.re - decay).powi(2) / v);
    squares.sum::<f64>() / (shifts.len() - 1) as f64
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use crate::identify::run_variation::run_means::*;

    #[test]
    fn the_95_percent_interval_of_the_mean_holds_in_95_percent() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
        for runs in [5, 12] {
            let (mut holding, mut count) = (0, 0);
            for _ in 0..1000 {
                // Runs of very different noise, and a scatter of several of their deviations.
                let shift = |std: f64, decay: f64, shift: f64, noise: f64| {
                    (Complex64::new(std * decay, shift + std * noise), std * std)
                };
                let shifts: Vec<(Complex64, f64)> = (0..runs)
                    .map(|_| shift(0.02 * normal().abs().exp(), normal(), normal(), normal()))
                    .collect();
                let Some(found) = mean_over_runs(&shifts) else {
                    continue;
                };
                count += 1;
                holding += i32::from(found.shift.abs() < 1.96 * found.std);
            }
            let share = f64::from(holding) / f64::from(count);
            // Three standard deviations of the share: 0.021.
            assert!(
                count > 970 && (0.93..0.975).contains(&share),
                "{runs} runs: {share}"
            );
        }
    }

    #[test]
    fn the_known_shift_of_a_run_is_added_to_its_step() {
        let at = |im: f64| Complex64::new(0.0, im);
        let steps = [Some((at(1.0), 0.1)), None, Some((at(2.0), 0.3))];
        let known = [10.0, 20.0, 40.0].map(at);
        let shifts = total_shifts(&steps, Some(&known));
        assert_eq!(shifts, [(at(11.0), 0.1), (at(42.0), 0.3)]);
        assert_eq!(total_shifts(&steps, None), [(at(1.0), 0.1), (at(2.0), 0.3)]);
    }

    #[test]
    fn noise_is_no_scatter_between_runs() {
        let mut random = ChaCha8Rng::seed_from_u64(10);
        let mut found = 0;
        for _ in 0..2000 {
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let shifts: Vec<(Complex64, f64)> = (0..8)
                .map(|_| (Complex64::new(normal(), normal()), 1.0))
                .collect();
            found += usize::from(mean_over_runs(&shifts).is_some());
        }
        assert!(found <= 8, "{found}");
    }

    #[test]
    fn misfit_that_moves_decay_rates_as_well_is_no_scatter_between_runs() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut found = 0;
        for _ in 0..500 {
            let mut normal = || -> f64 {
                let value: f64 = StandardNormal.sample(&mut random);
                10.0 * value
            };
            let shifts: Vec<(Complex64, f64)> = (0..12)
                .map(|_| (Complex64::new(normal(), normal()), 1.0))
                .collect();
            found += usize::from(mean_over_runs(&shifts).is_some());
        }
        assert!(found <= 25, "{found}");
    }
}
