//! Responses over time of nonlinear models, in growing detail, as signals with their statistics.

use super::TheoryError;

/// A model with nonlinear equations of motion beside its matrices.
pub trait Nonlinear: Send + Sync {
    /// The steady response under the excitation of the machine, once for each detail of the model,
    /// from the simplest.
    ///
    /// # Errors
    /// As [`TheoreticalModel::assemble`](super::TheoreticalModel::assemble);
    /// [`TheoryError::NoPeriods`].
    fn response(&self, values: &[f64], span: ResponseSpan) -> Result<TimeResponse, TheoryError>;
}

/// Duration and time step of a computed response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseSpan {
    /// Periods of the excitation before the recorded ones, for the transient to decay.
    pub settling_periods: usize,
    /// Recorded periods; at least 1.
    pub recorded_periods: usize,
    /// Largest step as a fraction of 1 over the highest angular frequency.
    pub step_radians: f64,
}

impl Default for ResponseSpan {
    fn default() -> Self {
        Self {
            settling_periods: 80,
            recorded_periods: 20,
            step_radians: 0.3,
        }
    }
}

impl ResponseSpan {
    /// Checks the span.
    ///
    /// # Errors
    /// [`TheoryError::NoPeriods`].
    pub(super) fn check(&self) -> Result<(), TheoryError> {
        if self.recorded_periods > 0 && self.step_radians > 0.0 {
            return Ok(());
        }
        Err(TheoryError::NoPeriods {
            periods: self.recorded_periods,
            step_radians: self.step_radians,
        })
    }
}

/// A signal over the recorded periods.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseSignal {
    /// Short name.
    pub name: &'static str,
    /// Unit; empty for a pure number.
    pub unit: &'static str,
    /// Description.
    pub meaning: &'static str,
    /// One value per step.
    pub samples: Vec<f64>,
    /// Amplitudes at 1, 2, ... times the frequency of the excitation.
    pub harmonics: Vec<f64>,
}

impl ResponseSignal {
    /// A signal with this many of its harmonics.
    pub(super) fn new(
        (name, unit, meaning): (&'static str, &'static str, &'static str),
        samples: Vec<f64>,
        steps_per_period: usize,
        harmonics: usize,
    ) -> Self {
        let amplitudes = amplitudes(&samples, steps_per_period, harmonics);
        Self {
            name,
            unit,
            meaning,
            samples,
            harmonics: amplitudes,
        }
    }

    /// Mean.
    pub fn mean(&self) -> f64 {
        self.samples.iter().sum::<f64>() / self.samples.len() as f64
    }

    /// Root of the mean square.
    pub fn rms(&self) -> f64 {
        norm(self.samples.iter().copied()) / (self.samples.len() as f64).sqrt()
    }

    /// Standard deviation about the mean.
    pub fn deviation(&self) -> f64 {
        let mean = self.mean();
        norm(self.samples.iter().map(|x| x - mean)) / (self.samples.len() as f64).sqrt()
    }

    /// Largest value.
    pub fn largest(&self) -> f64 {
        self.samples.iter().copied().fold(f64::MIN, f64::max)
    }

    /// Smallest value.
    pub fn least(&self) -> f64 {
        self.samples.iter().copied().fold(f64::MAX, f64::min)
    }

    /// Largest magnitude.
    pub fn magnitude(&self) -> f64 {
        self.largest().max(-self.least())
    }

    /// Number of harmonics above this fraction of the largest.
    pub fn lines_above(&self, part: f64) -> usize {
        let largest = self.harmonics.iter().copied().fold(0.0, f64::max);
        let above = self
            .harmonics
            .iter()
            .filter(|amplitude| **amplitude > part * largest);
        above.count()
    }

    /// Distance from another signal of the same times relative to that one, `|a - b|/|b|`; `None`
    /// unless both have as many samples and the other is not zero.
    pub fn difference(&self, other: &Self) -> Option<f64> {
        let other_norm = norm(other.samples.iter().copied());
        let pairs = self.samples.iter().zip(&other.samples);
        let same = self.samples.len() == other.samples.len() && other_norm > 0.0;
        same.then(|| norm(pairs.map(|(a, b)| a - b)) / other_norm)
    }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|value| value * value).sum::<f64>().sqrt()
}

/// Amplitudes of the harmonics of a signal of whole periods, which are averaged first.
fn amplitudes(samples: &[f64], steps: usize, harmonics: usize) -> Vec<f64> {
    let periods = (samples.len() / steps) as f64;
    let mean = |i: usize| samples.iter().skip(i).step_by(steps).sum::<f64>() / periods;
    let period: Vec<f64> = (0..steps).map(mean).collect();
    let turn = |i: usize| std::f64::consts::TAU * i as f64 / steps as f64;
    let table: Vec<(f64, f64)> = (0..steps).map(|i| turn(i).sin_cos()).collect();
    let amplitude = |k: usize| {
        let (mut sine, mut cosine) = (0.0, 0.0);
        for (i, value) in period.iter().enumerate() {
            let (sin, cos) = table[i * k % steps];
            sine += value * sin;
            cosine += value * cos;
        }
        2.0 / steps as f64 * sine.hypot(cosine)
    };
    (1..=harmonics.min((steps - 1) / 2))
        .map(amplitude)
        .collect()
}

/// The response with one detail of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct DetailResponse {
    /// The effects that the model includes.
    pub detail: &'static str,
    /// Its coordinates.
    pub coordinates: usize,
    /// Evaluations of its equations in one period.
    pub evaluations_per_period: usize,
    /// Additions, multiplications and functions are not counted; a varying angle costs an inverse
    /// cosine, a tangent and an arc tangent more in each mesh.
    pub functions_per_evaluation: usize,
    /// The signals that this detail has.
    pub signals: Vec<ResponseSignal>,
}

impl DetailResponse {
    /// A signal by its name.
    pub fn signal(&self, name: &str) -> Option<&ResponseSignal> {
        self.signals.iter().find(|signal| signal.name == name)
    }
}

/// Responses in growing detail.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeResponse {
    /// Frequency of the excitation, Hz.
    pub excitation_hz: f64,
    /// Periods before the recorded ones, and recorded periods.
    pub span: ResponseSpan,
    /// From the simplest to the most detailed.
    pub details: Vec<DetailResponse>,
}

impl TimeResponse {
    /// The response with a detail, by its name.
    pub fn detail(&self, name: &str) -> Option<&DetailResponse> {
        self.details.iter().find(|response| response.detail == name)
    }

    /// Distance of a signal with one detail from that with another, relative to the latter.
    pub fn difference(&self, signal: &str, detail: &str, from: &str) -> Option<f64> {
        let compared = self.detail(detail)?.signal(signal)?;
        compared.difference(self.detail(from)?.signal(signal)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_and_harmonics_of_a_sum_of_sines_are_recovered() {
        let steps = 64;
        let turn = |i: usize| std::f64::consts::TAU * i as f64 / steps as f64;
        let value = |i: usize| 3.0 + 2.0 * turn(i).sin() - 0.5 * (3.0 * turn(i)).cos();
        let samples: Vec<f64> = (0..3 * steps).map(value).collect();
        let signal = ResponseSignal::new(("x", "m", "a sum"), samples.clone(), steps, 40);
        assert!((signal.mean() - 3.0).abs() < 1e-12);
        assert!((signal.deviation() - (2.0f64 + 0.125).sqrt()).abs() < 1e-12);
        assert!((signal.rms() - (9.0f64 + 2.125).sqrt()).abs() < 1e-12);
        assert_eq!(signal.harmonics.len(), 31);
        for (k, amplitude) in (1..).zip(&signal.harmonics) {
            let expected = [0.0, 2.0, 0.0, 0.5].get(k).copied().unwrap_or(0.0);
            assert!((amplitude - expected).abs() < 1e-12, "{k}: {amplitude}");
        }
        assert_eq!((signal.lines_above(0.1), signal.lines_above(0.3)), (2, 1));
        let doubled = samples.iter().map(|x| 2.0 * x).collect();
        let other = ResponseSignal::new(("x", "m", "twice"), doubled, steps, 3);
        assert!((signal.difference(&other).unwrap() - 0.5).abs() < 1e-12);
        assert!((other.difference(&signal).unwrap() - 1.0).abs() < 1e-12);
        let shorter = ResponseSignal::new(("x", "m", "one"), samples[..steps].to_vec(), steps, 3);
        assert_eq!(signal.difference(&shorter), None);
    }
}
