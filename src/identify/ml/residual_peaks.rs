//! The search finds lines where the residual exceeds the noise, and starts a trial pole at each
//! peak.

use num_complex::Complex64;

use crate::linalg;
use crate::modal::mac;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::{ModelPole, is_resonance};
use crate::identify::data::residual::Residual;
use crate::identify::fit::detection_threshold::{noise_norm_quantile, upper_quantile};
use crate::identify::fit::fit_data::FitData;
use crate::linalg::sort_descending_by;

/// Minimum number of segments in the band: sets the maximum segment length.
const MIN_SEGMENTS_PER_BAND: usize = 8;
/// Minimum separation of two segments with a trial pole, in lengths of the longer one.
const MIN_SEGMENT_SEPARATION: usize = 4;

/// Distance from an existing pole, in decay rates, below which a trial pole is at the same pole.
const MATCH_DECAY_RATES: f64 = 0.1;
/// MAC of participation factors above which a trial pole at an existing pole is not new.
const MAX_MAC_NEW_PARTICIPATION: f64 = 0.95;

/// Minimum strength of a mode of a repeated trial pole over that of the strongest mode.
const MIN_RELATIVE_STRENGTH: f64 = 0.1;

/// Segment of frequency lines with residual power above that of noise.
#[derive(Clone, Copy, Debug)]
struct Segment {
    top: usize,
    width: usize,
    /// Power above that of noise, in its standard deviations.
    excess: f64,
}

/// Trial poles at the highest peaks of the smoothed residual power (over the noise of each FRF), at
/// most a given number. Noise reaches such a peak anywhere in the band with less than the
/// false-alarm probability.
pub(in crate::identify) fn residual_peak_poles(
    data: &FitData,
    frf_matrix: &FrfMatrix,
    poles: &[ModelPole],
    residual: &Residual,
    false_alarm_probability: f64,
    most: usize,
) -> Vec<ModelPole> {
    let functions = data.frfs.functions();
    let power = data
        .noise
        .noise_weighted_energy_by_line(&data.frfs, residual);
    let segments = segments(
        &power,
        functions,
        false_alarm_probability,
        data.noise.line_correlation.lines_per_effective_line(),
    );
    let peak = ResidualPeak {
        data,
        frf_matrix,
        residual,
        false_alarm_probability: false_alarm_probability / data.frfs.lines() as f64,
    };
    let trial_pole = |segment: &Segment| peak.trial_pole(segment, poles);
    segments.iter().filter_map(trial_pole).take(most).collect()
}

struct ResidualPeak<'a> {
    data: &'a FitData,
    frf_matrix: &'a FrfMatrix,
    residual: &'a Residual,
    /// False-alarm probability at one frequency line.
    false_alarm_probability: f64,
}

impl ResidualPeak<'_> {
    /// Trial pole for a segment: at the nearest existing pole, with as many modes as noise does not
    /// explain and that pole does not have, or else in the middle of the segment.
    fn trial_pole(&self, segment: &Segment, poles: &[ModelPole]) -> Option<ModelPole> {
        let decay = 0.5 * segment.width.max(2) as f64 * self.data.frfs.step;
        let middle = Complex64::new(-decay, self.data.frfs.omega[segment.top]);
        let distance = |pole: &&ModelPole| (pole.lambda - middle).norm();
        let there = poles
            .iter()
            .filter(|pole| distance(pole) < pole.decay().max(decay));
        let there = there.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let more = there.and_then(|existing| {
            let most = self.remaining_multiplicity(existing.lambda, poles);
            self.pole_at(existing.lambda, most, segment, poles)
        });
        more.or_else(|| self.pole_at(middle, 1, segment, poles))
            .filter(|pole| is_resonance(pole.lambda))
    }

    /// Number of modes that a pole can have in addition to those at existing poles: inputs and
    /// outputs separate no more.
    fn remaining_multiplicity(&self, lambda: Complex64, poles: &[ModelPole]) -> usize {
        let there = poles
            .iter()
            .filter(|existing| is_same_pole(existing, lambda));
        let modes: usize = there.map(ModelPole::multiplicity).sum();
        let most = self.frf_matrix.inputs.min(self.frf_matrix.outputs.len());
        most.saturating_sub(modes)
    }

    /// Trial pole at `lambda` with at most a given number of modes.
    fn pole_at(
        &self,
        lambda: Complex64,
        most: usize,
        segment: &Segment,
        poles: &[ModelPole],
    ) -> Option<ModelPole> {
        let lines = segment.top.saturating_sub(segment.width)
            ..(segment.top + segment.width + 1).min(self.data.frfs.lines());
        let profile = |k: usize| {
            self.data
                .frfs
                .line_shape
                .pole(self.data.frfs.omega[k], lambda)
        };
        let size = lines
            .clone()
            .map(|k| profile(k).norm_sqr())
            .sum::<f64>()
            .sqrt();
        let amplitude = |f: usize| -> Complex64 {
            let matched = |k: usize| self.residual.at(f, k) * profile(k).conj() / size;
            lines.clone().map(matched).sum()
        };
        let amplitudes: Vec<Complex64> = (0..self.data.frfs.functions()).map(amplitude).collect();
        let noise_factor = self
            .data
            .noise
            .line_correlation
            .amplitude_noise_factor(-lambda.re, self.data.frfs.step);
        let limit = noise_factor.sqrt()
            * noise_norm_quantile(self.frf_matrix, self.false_alarm_probability);
        let strengths = linalg::singular_values(&self.frf_matrix.matrix(|f| amplitudes[f]));
        let strengths = strengths.unwrap_or_default();
        let limit = limit.max(MIN_RELATIVE_STRENGTH * strengths.first().copied().unwrap_or(0.0));
        let above = strengths.iter().filter(|s| **s > limit).count();
        let physical = |f: usize| amplitudes[f] * self.data.noise.std(f, segment.top);
        let mut parts = strongest_inputs(self.frf_matrix, above.max(1), physical);
        parts.retain(|part| {
            !poles
                .iter()
                .any(|existing| is_same_participation(existing, lambda, part))
        });
        parts.truncate(most);
        let first = parts.first()?;
        let mut pole = ModelPole::single(lambda, first, self.data.frfs.functions());
        pole.join(parts.split_off(1));
        Some(pole)
    }
}

/// Whether an existing pole has this pole and participation factor.
fn is_same_participation(existing: &ModelPole, lambda: Complex64, part: &[Complex64]) -> bool {
    let same_participation =
        |other: &Vec<Complex64>| mac(other, part) > Some(MAX_MAC_NEW_PARTICIPATION);
    is_same_pole(existing, lambda) && existing.parts.iter().any(same_participation)
}

fn is_same_pole(existing: &ModelPole, lambda: Complex64) -> bool {
    (existing.lambda - lambda).norm() < MATCH_DECAY_RATES * existing.decay()
}

/// Segments of doubling length whose power noise does not explain, the highest first, none near a
/// higher one.
///
/// `effective_ratio`: lines of correlated noise for each independent line.
fn segments(
    power: &[f64],
    functions: usize,
    false_alarm_probability: f64,
    effective_ratio: f64,
) -> Vec<Segment> {
    let lines = power.len();
    let mut sums = vec![0.0; lines + 1];
    for (k, p) in power.iter().enumerate() {
        sums[k + 1] = sums[k] + p;
    }
    let mut found: Vec<Segment> = Vec::new();
    let mut width = 1;
    while width <= lines / MIN_SEGMENTS_PER_BAND {
        let freedom = 2 * functions * width;
        let independent = freedom as f64 / effective_ratio.min(width as f64);
        let limit = freedom as f64 / independent
            * upper_quantile(independent, false_alarm_probability / lines as f64);
        for start in (0..=lines - width).step_by(width.div_ceil(2)) {
            let value = 2.0 * (sums[start + width] - sums[start]);
            if value > limit {
                found.push(Segment {
                    top: start + width / 2,
                    width,
                    excess: (value / freedom as f64 - 1.0) * (0.5 * independent).sqrt(),
                });
            }
        }
        width *= 2;
    }
    sort_descending_by(&mut found, |entry| entry.excess);
    let mut chosen: Vec<Segment> = Vec::new();
    for segment in found {
        let clear = |other: &Segment| {
            let reach = segment.width.max(other.width).max(2);
            segment.top.abs_diff(other.top) > MIN_SEGMENT_SEPARATION * reach
        };
        if chosen.iter().all(clear) {
            chosen.push(segment);
        }
    }
    chosen
}

/// Participation factors of the strongest rank-one terms of an FRF matrix with a value per FRF:
/// right singular vectors over the inputs.
pub(in crate::identify) fn strongest_inputs(
    frf_matrix: &FrfMatrix,
    count: usize,
    value: impl Fn(usize) -> Complex64,
) -> Vec<Vec<Complex64>> {
    let inputs = frf_matrix.inputs;
    let matrix = frf_matrix.matrix(value);
    let svd = linalg::singular_vectors(&matrix);
    let vector = |rank: usize| match &svd {
        // A = U S Vᴴ, so that the row space is that of conj(V).
        Ok(svd) if rank < svd.values.len() => {
            (0..inputs).map(|i| svd.right[(i, rank)].conj()).collect()
        }
        _ => vec![Complex64::ONE; inputs],
    };
    (0..count).map(vector).collect()
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::ml::residual_peaks::*;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    #[test]
    fn a_trial_pole_has_no_more_modes_than_inputs_can_separate() {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.1,
            len: 1500,
        };
        let structure = Structure {
            modes: vec![(100.0, 0.01, vec![1.0, 0.6, -0.5, 0.3])],
        };
        let mut how = Measurement::of_sensors(4, axis);
        for i in 0..4 {
            how.pairs
                .push((how.pairs[i].0.clone(), how.pairs[1].0.clone()));
        }
        let set = structure.measured(&how);
        let data = FitData::guarded(&set, Band::new(80.0, 120.0).unwrap()).unwrap();
        let frf_matrix = FrfMatrix::new(set.functions());
        assert_eq!(frf_matrix.inputs, 2);
        let lambda = Pole::from_frequency(100.0, 0.01).lambda;
        let fitted = ModelPole::single(lambda, &[Complex64::ONE, Complex64::ZERO], set.len());
        // The residual of a fit of one mode has two independent terms far above the noise.
        let residual = linalg::complex_matrix(data.frfs.lines(), set.len(), |k, f| {
            let profile = fitted.decay() / (Complex64::new(0.0, data.frfs.omega[k]) - lambda);
            1e3 * (1.0 + (f * f) as f64).sin() * profile
        });
        let residual = Residual::of_all(&residual);
        let tried = |poles: &[ModelPole]| {
            let found = residual_peak_poles(&data, &frf_matrix, poles, &residual, 1e-3, 4);
            let at_pole = |pole: &&ModelPole| (pole.lambda - lambda).norm() < 1e-9 * lambda.norm();
            found.iter().find(at_pole).map(ModelPole::multiplicity)
        };
        assert_eq!(tried(std::slice::from_ref(&fitted)), Some(1));
        // No trial pole where both modes exist.
        let other = ModelPole::single(lambda, &[Complex64::ZERO, Complex64::ONE], set.len());
        assert_eq!(tried(&[fitted.clone(), other]), None);
    }
}
