//! Narrower bands give other poles than the whole band: their shift above the noise adds to the
//! standard deviation of each pole.
//!
//! The standard deviation of a fit takes the residual for noise. A response that depends on the
//! amplitude, a truncated record or a mode outside the model leave a residual that is correlated
//! over lines and FRFs, and their effect on a pole does not fall with the number of values. It
//! shows when the band changes. One Gauss-Newton step of a pole and of all residues on some lines,
//! with the other poles fixed, is
//!
//! ```text
//! δλ = Σ_f Σ_k conj(a_f g_k/l_f) r_fk / Σ_f Σ_k |a_f g_k/l_f|²
//! var Re δλ = var Im δλ = 1 / (2 Σ_f Σ_k |a_f g_k/l_f|²)
//! ```
//!
//! with the residues a, the noise levels l of the FRFs, the residual r over level and profile of
//! the noise, and g the part of `1/(iω − λ)²`, over that profile, that out-of-band terms and the
//! poles around do not explain. The step on a narrower band less that on the fitted lines is the
//! shift of the pole. In noise its variance is the difference of their variances (Hausman 1978,
//! Econometrica 46(6)); where the shift exceeds that, it enters the standard deviation.

use std::ops::Range;

use num_complex::Complex64;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::{OutOfBandBasis, OutOfBandTerms};
use crate::identify::data::residual::{PredictedResponse, Residual};
use crate::identify::fit::block_descent::window;
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::pole_covariance::{FitLines, orthogonal_derivative};
use crate::identify::noise::band_profile::BandProfile;

/// Narrower bands, in parts of the fitted lines below and above the pole: the middle of them, and
/// nearly one side alone. With a mode of a hundredth of the residues in half a bandwidth, fits on
/// these bands differ by up to 7 deviations of noise
/// (`the_deviation_covers_narrower_bands_where_a_mode_is_not_in_the_model`).
const BANDS: [(f64, f64); 5] = [
    (0.5, 0.5),
    (0.25, 0.25),
    (0.125, 0.125),
    (0.1, 1.0),
    (1.0, 0.1),
];
/// Mean square of both parts of a shift over its variance in noise, above which it is not noise. In
/// noise the ratio has an exponential distribution of mean 1: 4,000 shifts reached 9.8. Smaller:
/// modes of linear structures are reported. Larger: shifts of that many standard deviations stay
/// out (`noise_shifts_a_pole_by_its_variance`).
const MIN_SHIFT_RATIO: f64 = 10.0;
/// Minimum variance of a shift over that of the pole: the difference of nearly equal variances is
/// inaccurate.
const MIN_VARIANCE_RATIO: f64 = 0.5;
/// Minimum number of lines of a narrower band: out-of-band terms take a third of them at most.
const MIN_LINES: usize = 6;
/// Decay rates up to which a step is linear: a narrower band whose noise alone moves the pole
/// farther is ignored, and a longer shift is limited to this length.
const MAX_LINEAR_DECAY_RATES: f64 = 1.0;

/// A fit whose poles are compared with those of narrower bands.
pub(in crate::identify) struct NarrowerBands<'a> {
    data: &'a FitData,
    poles: &'a [ModelPole],
    /// Residual on all lines, over the noise.
    residual: Residual,
}

/// A shift of a pole: mean square of both parts, rad²/s², and its variance in noise.
struct Shift {
    mean_square: f64,
    noise_variance: f64,
}

impl<'a> NarrowerBands<'a> {
    pub fn new(data: &'a FitData, poles: &'a [ModelPole], described: &PredictedResponse) -> Self {
        Self {
            data,
            poles,
            residual: described.residual(0..data.frfs.lines()),
        }
    }

    /// Standard deviation of real and imaginary part of a pole, rad/s, from the largest shift that
    /// noise does not explain; 0 where noise explains all shifts.
    pub fn deviation(&self, pole: &ModelPole) -> f64 {
        let shifts = self.shifts(pole).into_iter().flatten();
        let beyond =
            shifts.filter(|shift| shift.mean_square > MIN_SHIFT_RATIO * shift.noise_variance);
        let variance = beyond.map(|shift| shift.mean_square - shift.noise_variance);
        let longest = 0.5 * (MAX_LINEAR_DECAY_RATES * pole.decay()).powi(2);
        variance.fold(0.0, f64::max).min(longest).sqrt()
    }

    /// The shift over each of [`BANDS`]; `None` where a band has too few lines, or too much noise.
    fn shifts(&self, pole: &ModelPole) -> [Option<Shift>; BANDS.len()] {
        let fit = PoleFit::new(self, pole);
        let background = OutOfBandBasis::new(
            &self.data.frfs.omega,
            &fit.lines,
            self.data.out_of_band_terms(),
        );
        let fitted = fit.step(fit.lines.clone(), background);
        let variance = pole.quality.pole_std.powi(2);
        let correlated_over_white = variance / pole.quality.pole_bound.powi(2);
        let max_variance = (MAX_LINEAR_DECAY_RATES * pole.decay()).powi(2);
        BANDS.map(|(below, above)| {
            let (fitted, band) = (fitted?, fit.band(below, above));
            if band.len() < MIN_LINES {
                return None;
            }
            let omega = &self.data.frfs.omega[band.clone()];
            let background =
                OutOfBandBasis::new(omega, &(0..omega.len()), &OutOfBandTerms::Anywhere);
            let narrower = fit.step(band, background)?;
            let difference = (narrower.variance - fitted.variance) * correlated_over_white;
            let noise_variance = difference.max(MIN_VARIANCE_RATIO * variance);
            (noise_variance < max_variance).then_some(Shift {
                mean_square: 0.5 * (narrower.value - fitted.value).norm_sqr(),
                noise_variance,
            })
        })
    }
}

/// The residual on the lines of a pole, in the direction of its residues.
struct PoleFit<'a> {
    model: &'a NarrowerBands<'a>,
    pole: &'a ModelPole,
    lines: Range<usize>,
    /// Profile of the noise over these lines.
    noise_profile: Vec<f64>,
    /// `Σ_f conj(a_f) r_fk / l_f` of each line.
    projected: Vec<Complex64>,
    /// `Σ_f |a_f/l_f|²`.
    weight: f64,
}

/// A step of a pole, rad/s, and the variance of each of its parts in white noise.
#[derive(Clone, Copy)]
struct Step {
    value: Complex64,
    variance: f64,
}

impl<'a> PoleFit<'a> {
    fn new(model: &'a NarrowerBands<'a>, pole: &'a ModelPole) -> Self {
        let data = model.data;
        let lines = window(&data.frfs, std::iter::once(pole));
        let BandProfile {
            level,
            noise_profile,
        } = BandProfile::new(&data.noise, lines.clone());
        let mut projected = vec![Complex64::ZERO; lines.len()];
        for (f, (a, level)) in pole.residues.iter().zip(&level).enumerate() {
            let residual = model.residual.of(f, lines.clone());
            let stds = data.noise.by_frf[f].stds(lines.clone());
            let values = residual.zip(stds).zip(&noise_profile);
            for (sum, ((r, std), noise_profile)) in projected.iter_mut().zip(values) {
                *sum += a.conj() / level * r * (std / (level * noise_profile));
            }
        }
        let weights = pole.residues.iter().zip(&level);
        Self {
            model,
            pole,
            lines,
            noise_profile,
            projected,
            weight: weights.map(|(a, level)| (a / level).norm_sqr()).sum(),
        }
    }

    /// Lines of a band, by its parts below and above the pole.
    fn band(&self, below: f64, above: f64) -> Range<usize> {
        let pole_line = self.model.data.frfs.line_of(self.pole.lambda);
        let below = below * (pole_line - self.lines.start) as f64;
        let above = above * (self.lines.end - 1 - pole_line) as f64;
        pole_line - below.round() as usize..pole_line + above.round() as usize + 1
    }

    /// A step on some of the lines; `None` where they are too few.
    fn step(&self, lines: Range<usize>, background: OutOfBandBasis) -> Option<Step> {
        let at = lines.start - self.lines.start..lines.end - self.lines.start;
        let NarrowerBands { data, poles, .. } = self.model;
        let fit = FitLines {
            lines,
            noise_profile: &self.noise_profile[at.clone()],
            background,
        };
        let derivative = orthogonal_derivative(&data.frfs, poles, self.pole, &fit)?;
        let energy: f64 = derivative.iter().map(Complex64::norm_sqr).sum();
        let terms = derivative.iter().zip(&self.projected[at]);
        let along: Complex64 = terms.map(|(g, r)| g.conj() * r).sum();
        // The derivative is of (d/(iω − λ))² with the decay rate d.
        let scale = self.pole.decay().powi(2);
        let step = Step {
            value: along * scale / (self.weight * energy),
            variance: 0.5 * scale.powi(2) / (self.weight * energy),
        };
        (step.value.is_finite() && step.variance.is_finite()).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::finding::{Code, Finding};
    use crate::frf::{FrfSet, Function, FunctionData};
    use crate::identify::data::frf_matrix::FrfMatrix;
    use crate::identify::estimator::{IdentifyOptions, MethodOptions};
    use crate::identify::fit::block_descent::Convergence;
    use crate::identify::fit::pole_covariance::add_noise_model_uncertainty;
    use crate::identify::identify;
    use crate::identify::pole_model::PoleModel;
    use crate::identify::pole_model::narrower_bands::*;
    use crate::identify::synthetic::white_noise;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    /// Error of the force over the force.
    const FORCE_NOISE: f64 = 3e-3;
    const WHOLE_HZ: [f64; 2] = [60.0, 150.0];
    const AXIS: FrequencyAxis = FrequencyAxis {
        start_hz: 60.0,
        step_hz: 0.2,
        len: 451,
    };

    /// Modes at 90 and 120 Hz over six sensors, and one near the second with a given fraction of
    /// its residues.
    fn structure(second_contribution: f64) -> Structure {
        let shape = |a: f64, size: f64| (1..=6).map(|p| size * (a * f64::from(p)).cos()).collect();
        Structure {
            modes: vec![
                (90.0, 0.005, shape(0.3, 1.0)),
                (120.0, 0.008, shape(0.7, 1.0)),
                (121.0, 0.008, shape(0.9, second_contribution.sqrt())),
            ],
        }
    }

    #[derive(Clone, Copy, Debug)]
    enum Noise {
        None,
        /// 60 dB below the FRFs.
        Even,
        /// 50 dB below every value, common to all FRFs as an error of the force is, and noise of
        /// the responses at 80 dB.
        OfForce,
    }

    /// FRFs of the structure with noise, and with its variance.
    fn measured(second_contribution: f64, noise: Noise, seed: u64) -> FrfSet {
        let how = Measurement {
            snr_db: match noise {
                Noise::None => None,
                Noise::Even => Some(60.0),
                Noise::OfForce => Some(80.0),
            },
            seed,
            ..Measurement::of_sensors(6, AXIS)
        };
        let set = structure(second_contribution).measured(&how);
        let Noise::OfForce = noise else {
            return set;
        };
        let error = white_noise(AXIS.len, FORCE_NOISE.powi(2), 500 + seed);
        let mut noisy = FrfSet::new(AXIS);
        for (i, function) in set.functions().iter().enumerate() {
            let values = set.values(i);
            let power = values.iter().map(Complex64::norm_sqr).sum::<f64>() / AXIS.len as f64;
            let with_error = values.iter().zip(&error).map(|(h, e)| h * (1.0 + e));
            let variance = values
                .iter()
                .map(|h| FORCE_NOISE.powi(2) * h.norm_sqr() + 1e-8 * power);
            let data = FunctionData {
                values: with_error.collect(),
                coherence: None,
                variance: Some(variance.collect()),
            };
            let function = Function {
                averages: Some(10),
                variance_dof: Some(18.0),
                ..function.clone()
            };
            noisy.push(function, data).unwrap();
        }
        noisy
    }

    /// A fit of the first two modes alone on a band; of the second alone where that begins above
    /// the first.
    fn fitted(
        second_contribution: f64,
        (noise, seed): (Noise, u64),
        band_hz: [f64; 2],
    ) -> PoleModel {
        let set = measured(second_contribution, noise, seed);
        let band = Band::new(band_hz[0], band_hz[1]).unwrap();
        let data = FitData::guarded(&set, band).unwrap();
        let mut fit = PoleModel::new(
            data,
            FrfMatrix::new(set.functions()),
            MethodOptions::default(),
        );
        let one = [Complex64::ONE];
        let modes = if band_hz[0] < 90.0 { 0..2 } else { 1..2 };
        fit.poles = modes
            .map(|mode| ModelPole::single(truth(mode), &one, 6))
            .collect();
        fit.refine(Convergence::Fine);
        add_noise_model_uncertainty(&fit.data, &mut fit.poles);
        fit
    }

    fn truth(mode: usize) -> Complex64 {
        let (hz, zeta, _) = structure(0.0).modes[mode].clone();
        Pole::from_frequency(hz, zeta).lambda
    }

    #[test]
    fn noise_shifts_a_pole_by_its_variance() {
        for noise in [Noise::Even, Noise::OfForce] {
            let mut ratios = vec![Vec::new(); BANDS.len()];
            for seed in 0..60 {
                let fit = fitted(0.0, (noise, seed), WHOLE_HZ);
                let described = fit.data.predict(&fit.poles);
                let bands = NarrowerBands::new(&fit.data, &fit.poles, &described);
                for pole in &fit.poles {
                    assert!(bands.deviation(pole) <= 0.0, "{noise:?} {seed}");
                    let shifts = bands.shifts(pole).into_iter();
                    for (ratios, shift) in ratios.iter_mut().zip(shifts) {
                        let shift = shift.expect("enough lines");
                        ratios.push(shift.mean_square / shift.noise_variance);
                    }
                }
            }
            for (ratios, band) in ratios.iter().zip(BANDS) {
                // Exponential of mean 1: 0.09 is the standard deviation of the mean of 120.
                let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
                assert!((0.65..1.35).contains(&mean), "{noise:?} {band:?}: {mean}");
            }
        }
    }

    /// A fit with its second pole shifted by `error`, and with the residues of that pole.
    fn moved(noise: Noise, error: impl Fn(&ModelPole) -> Complex64) -> PoleModel {
        let mut fit = fitted(0.0, (noise, 7), WHOLE_HZ);
        let error = error(&fit.poles[1]);
        fit.poles[1].lambda += error;
        fit.refine(Convergence::Residues);
        add_noise_model_uncertainty(&fit.data, &mut fit.poles);
        fit
    }

    #[test]
    fn a_step_leads_back_to_the_pole() {
        let error = |pole: &ModelPole| Complex64::new(1e-3, -2e-3) * pole.decay();
        let fit = moved(Noise::None, error);
        let described = fit.data.predict(&fit.poles);
        let bands = NarrowerBands::new(&fit.data, &fit.poles, &described);
        let (pole, error) = (&fit.poles[1], error(&fit.poles[1]));
        let pole_fit = PoleFit::new(&bands, pole);
        for (below, above) in BANDS {
            let band = pole_fit.band(below, above);
            let omega = &fit.data.frfs.omega[band.clone()];
            let background =
                OutOfBandBasis::new(omega, &(0..omega.len()), &OutOfBandTerms::Anywhere);
            let step = pole_fit.step(band, background).expect("enough lines");
            let left = (step.value + error).norm() / error.norm();
            assert!(left < 0.05, "{below} {above}: {left}");
        }
    }

    #[test]
    fn a_fixed_pole_off_its_maximum_has_no_deviation_by_narrower_bands() {
        let fit = moved(Noise::Even, |pole| (10.0 * pole.quality.pole_std).into());
        let described = fit.data.predict(&fit.poles);
        let bands = NarrowerBands::new(&fit.data, &fit.poles, &described);
        assert!(bands.deviation(&fit.poles[1]) <= 0.0);
    }

    #[test]
    fn the_deviation_covers_narrower_bands_where_a_mode_is_not_in_the_model() {
        const NARROWER_HZ: [[f64; 2]; 5] = [
            [115.0, 125.0],
            [118.0, 122.0],
            [119.0, 150.0],
            [60.0, 121.0],
            [60.0, 130.0],
        ];
        for (second_contribution, seed) in [(0.0, 0), (0.003, 1), (0.01, 2), (0.03, 3), (0.1, 4)] {
            let fit = fitted(second_contribution, (Noise::Even, seed), WHOLE_HZ);
            let described = fit.data.predict(&fit.poles);
            let pole = &fit.poles[1];
            let bands = NarrowerBands::new(&fit.data, &fit.poles, &described);
            let deviation = bands.deviation(pole);
            let by_noise = pole.quality.pole_std;
            assert_eq!(
                deviation > 2.0 * by_noise,
                second_contribution >= 0.01,
                "{second_contribution}"
            );
            let mut shifts = Vec::new();
            for band in NARROWER_HZ {
                let other = fitted(second_contribution, (Noise::Even, seed), band);
                let other = other.poles.last().expect("the second mode");
                let shift = (other.lambda - pole.lambda).norm() / 2f64.sqrt();
                let by_noise = by_noise.hypot(other.quality.pole_std);
                let with_bands = shift / by_noise.hypot(deviation);
                assert!(
                    with_bands < 3.0,
                    "{second_contribution} {band:?}: {with_bands}"
                );
                shifts.push((shift, shift / by_noise));
            }
            let longest = shifts
                .iter()
                .fold(0.0, |longest: f64, shift| longest.max(shift.0));
            assert!(
                deviation < 2.0 * longest,
                "{second_contribution}: {deviation} {longest}"
            );
            // Noise alone does not explain them.
            let unexplained = shifts.iter().filter(|shift| shift.1 > 5.0).count();
            assert_eq!(
                unexplained >= 3,
                second_contribution >= 0.01,
                "{second_contribution}: {unexplained}"
            );
        }
    }

    /// The FRFs with a disturbance of a given fraction of the largest value at 121.2 to 121.4 Hz.
    fn disturbed(ratio: f64) -> FrfSet {
        let set = measured(0.0, Noise::Even, 1);
        let mut disturbed = FrfSet::new(AXIS);
        for (i, function) in set.functions().iter().enumerate() {
            let mut values = set.values(i).to_vec();
            let largest = values.iter().map(|h| h.norm()).fold(0.0, f64::max);
            for value in &mut values[306..308] {
                *value += ratio * largest;
            }
            let data = FunctionData {
                values,
                ..FunctionData::default()
            };
            disturbed.push(function.clone(), data).unwrap();
        }
        disturbed
    }

    #[test]
    fn a_mode_beside_a_disturbance_is_reported_where_its_damping_becomes_uncertain() {
        for (ratio, std_hz, percent) in [
            (0.0, 0.0..1e-4, None),
            (0.03, 0.01..0.08, None),
            (0.3, 0.1..0.6, Some(15.0..60.0)),
        ] {
            let model = identify(&disturbed(ratio), &IdentifyOptions::default()).unwrap();
            assert_eq!(model.modes.len(), 2, "{ratio}");
            let mode = &model.modes[1];
            let std = mode.frequency_std_hz.unwrap();
            assert!(std_hz.contains(&std), "{ratio}: {std}");
            assert!((mode.frequency_hz - 120.0).abs() < 3.0 * std, "{ratio}");
            let of_bands = |finding: &&Finding| finding.code == Code::BandDependent;
            let value = model
                .findings
                .iter()
                .find(of_bands)
                .map(|finding| finding.value);
            match percent {
                Some(percent) => assert!(percent.contains(&value.unwrap().unwrap())),
                None => assert_eq!(value, None, "{ratio}"),
            }
        }
    }
}
