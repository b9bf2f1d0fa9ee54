//! A linear system is defined by its modes and has FRFs with and without noise.
//!
//! `H_oi(s) = s^d Σ_r [ψ_or L_ri/(s − λ_r) + conj.]` at `s = iω`: `λ` poles, `ψ` shapes at the
//! responses, `L` participation at the references, `d` 0, 1, 2 for receptance, mobility,
//! accelerance. A record that ends `T` after the hit truncates the response:
//! `H_oi − Σ_r [λ_r^d e^{(λ_r−s)T} ψ_or L_ri/(s − λ_r) + conj.]`, the transform of the response to
//! a short pulse from the pulse to the end of the record.
//!
//! The side of more degrees of freedom carries the shape of a mode ([`crate::identify`]): a roving
//! hammer with one sensor is stated as its reciprocal, with the hit points as responses.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::frf::{FrfSet, Function, FunctionData};
use crate::modal::Pole;
use crate::quantity::FrfKind;

use super::StudyError;

/// A mode of the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueMode {
    /// λ.
    pub pole: Pole,
    /// `ψ` at the responses.
    pub shape: Vec<Complex64>,
    /// `L` at the references: receptance residues are `ψ L`, m/(N s).
    pub participation: Vec<Complex64>,
}

impl TrueMode {
    /// A mode of unit modal mass (1 kg) with real normal coordinates: `L = φ/(2 i ω_d)` of the
    /// shape `φ` at the references.
    pub fn of_unit_mass(pole: Pole, shape: Vec<Complex64>, at_references: &[Complex64]) -> Self {
        let divisor = Complex64::new(0.0, 2.0 * pole.lambda.im);
        Self {
            pole,
            shape,
            participation: at_references.iter().map(|value| value / divisor).collect(),
        }
    }

    /// Natural frequency, Hz.
    pub fn hz(&self) -> f64 {
        self.pole.natural_frequency_hz()
    }

    /// Half-power bandwidth, Hz.
    pub fn width_hz(&self) -> f64 {
        self.pole.half_power_width_hz()
    }

    /// Receptance residue of a response for a hit at a reference, m/(N s).
    pub fn residue(&self, response: usize, reference: usize) -> Complex64 {
        self.shape[response] * self.participation[reference]
    }
}

/// A system with its frequency lines, band and degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// In ascending frequency, those outside the band included.
    pub modes: Vec<TrueMode>,
    /// Lines of the functions.
    pub axis: FrequencyAxis,
    /// Band that is searched for modes.
    pub band: Band,
    /// Kind of the FRFs.
    pub kind: FrfKind,
    /// Where the response is measured.
    pub responses: Vec<Dof>,
    /// Where the system is hit.
    pub references: Vec<Dof>,
    /// Time from the hit to the end of the record, s; `None` for a record that ends when all has
    /// decayed.
    pub record_end_s: Option<f64>,
}

/// White noise on FRFs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrfNoise {
    /// Rms of a function over the band over the rms noise of a line, dB.
    pub snr_db: f64,
    /// Averages that the stated variances are estimated from, with `2(n − 1)` degrees of freedom;
    /// exact variances without.
    pub averages: Option<u32>,
}

impl System {
    /// Whether a mode lies in the band.
    pub fn inside(&self, mode: &TrueMode) -> bool {
        self.band.contains(mode.hz())
    }

    /// Modal overlap of the band: the sum of the half-power bandwidths over the width of the band.
    pub fn overlap(&self) -> f64 {
        let inside = self.modes.iter().filter(|mode| self.inside(mode));
        inside.map(TrueMode::width_hz).sum::<f64>() / self.band.width_hz()
    }

    /// Response and reference of every function, reference by reference.
    pub fn pairs(&self) -> Vec<(usize, usize)> {
        (0..self.references.len())
            .flat_map(|i| (0..self.responses.len()).map(move |o| (o, i)))
            .collect()
    }

    /// Angular frequencies of the lines of the band, rad/s.
    pub fn omega(&self) -> Vec<f64> {
        let lines = self.axis.lines(&self.band);
        lines.map(|k| TAU * self.axis.hz(k)).collect()
    }

    /// The functions without noise, in the order of [`Self::pairs`].
    ///
    /// # Errors
    /// [`StudyError::Set`] when a degree of freedom is there twice.
    pub fn exact(&self) -> Result<FrfSet, StudyError> {
        let mut set = FrfSet::new(self.axis);
        for (response, reference) in self.pairs() {
            let value = |k| self.value(response, reference, self.axis.rad_s(k));
            let values = (0..self.axis.len).map(value);
            let data = FunctionData {
                values: values.collect(),
                ..FunctionData::default()
            };
            set.push(self.function(response, reference), data)?;
        }
        Ok(set)
    }

    fn function(&self, response: usize, reference: usize) -> Function {
        Function {
            response: self.responses[response].clone(),
            reference: self.references[reference].clone(),
            kind: self.kind,
            averages: None,
            estimator: None,
            variance_dof: None,
        }
    }

    fn value(&self, response: usize, reference: usize, omega: f64) -> Complex64 {
        let s = Complex64::new(0.0, omega);
        let order = self.kind.derivative_order();
        let terms = self.modes.iter().map(|mode| {
            let (a, lambda) = (mode.residue(response, reference), mode.pole.lambda);
            (a / (s - lambda), a.conj() / (s - lambda.conj()), lambda)
        });
        let Some(end_s) = self.record_end_s else {
            return terms.map(|(term, conj, _)| term + conj).sum::<Complex64>() * s.powi(order);
        };
        let whole = s.powi(order);
        let kept = |lambda: Complex64| whole - lambda.powi(order) * ((lambda - s) * end_s).exp();
        terms
            .map(|(term, conj, lambda)| term * kept(lambda) + conj * kept(lambda.conj()))
            .sum()
    }

    /// True variance `E|H − E H|²` of a line of each function of [`Self::exact`]: its mean square
    /// over the band over the signal-to-noise ratio.
    pub fn variances(&self, exact: &FrfSet, snr_db: f64) -> Vec<f64> {
        let lines = self.axis.lines(&self.band);
        let share = 10f64.powf(-snr_db / 10.0) / lines.len() as f64;
        let power = |i| -> f64 {
            let values = exact.values(i)[lines.clone()].iter();
            values.map(Complex64::norm_sqr).sum()
        };
        (0..exact.len()).map(|i| share * power(i)).collect()
    }

    /// The functions with noise and stated variances.
    ///
    /// # Errors
    /// As [`Self::exact`]; [`StudyError::Value`] for fewer than two averages.
    pub fn noisy(&self, noise: &FrfNoise, random: &mut ChaCha8Rng) -> Result<FrfSet, StudyError> {
        let exact = self.exact()?;
        let variances = self.variances(&exact, noise.snr_db);
        with_noise(&exact, &variances, noise.averages, random)
    }
}

/// FRFs with white noise of these variances added; the stated variances are exact, or estimated
/// from a number of averages.
///
/// # Errors
/// [`StudyError::Value`] for fewer than two averages.
pub fn with_noise(
    exact: &FrfSet,
    variances: &[f64],
    averages: Option<u32>,
    random: &mut ChaCha8Rng,
) -> Result<FrfSet, StudyError> {
    let freedom = averages.map(|n| 2.0 * (f64::from(n) - 1.0));
    let chi = freedom.map(ChiSquared::new).transpose();
    let chi = chi.map_err(|_| StudyError::Value {
        key: "averages".to_owned(),
        got: averages.map_or(String::new(), |n| n.to_string()),
        expected: "2 or more".to_owned(),
    })?;
    let mut set = FrfSet::new(*exact.axis());
    for (i, variance) in variances.iter().enumerate() {
        let values = exact.values(i).iter();
        let values = values.map(|h| h + white(random, *variance)).collect();
        let mut stated = || match (chi, freedom) {
            (Some(chi), Some(freedom)) => variance * chi.sample(random) / freedom,
            _ => *variance,
        };
        let stated = (0..exact.axis().len).map(|_| stated()).collect();
        let function = Function {
            averages,
            variance_dof: freedom,
            ..exact.functions()[i].clone()
        };
        let data = FunctionData {
            values,
            coherence: None,
            variance: Some(stated),
        };
        set.push(function, data)?;
    }
    Ok(set)
}

/// Complex noise of variance E|z|².
fn white(random: &mut ChaCha8Rng, variance: f64) -> Complex64 {
    let mut part = || -> f64 { StandardNormal.sample(random) };
    Complex64::new(part(), part()) * (0.5 * variance).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    fn system() -> System {
        let mode = |hz: f64, shape: [f64; 2]| {
            let shape = shape.map(Complex64::from).to_vec();
            let at_references = [shape[0]];
            TrueMode::of_unit_mass(Pole::from_frequency(hz, 0.02), shape, &at_references)
        };
        let dof = |text: &str| text.parse().unwrap();
        System {
            modes: vec![mode(20.0, [1.0, 0.5]), mode(35.0, [0.7, -1.0])],
            axis: FrequencyAxis {
                start_hz: 10.0,
                step_hz: 0.5,
                len: 81,
            },
            band: Band::new(10.0, 50.0).unwrap(),
            kind: FrfKind::Accelerance,
            responses: vec![dof("1:+Z"), dof("2:+Z")],
            references: vec![dof("1:+Z")],
            record_end_s: None,
        }
    }

    /// The FRF is the transform of the impulse response up to the end of the record.
    #[test]
    fn frf_of_a_truncated_record_is_the_transform_of_its_response() {
        let (end_s, omega) = (0.4, TAU * 23.0);
        let whole = system();
        let ended = System {
            record_end_s: Some(end_s),
            ..whole.clone()
        };
        let s = Complex64::new(0.0, omega);
        let after = |t: f64| -> Complex64 {
            let terms = whole.modes.iter().map(|mode| {
                let (a, lambda) = (mode.residue(1, 0), mode.pole.lambda);
                2.0 * (a * lambda.powi(2) * (lambda * t).exp()).re
            });
            terms.sum::<f64>() * (-s * t).exp()
        };
        // Until e^-40; trapezia of 20 us, whose error is under a millionth at 50 Hz.
        let (step, count) = (2e-5, 1_000_000);
        let inner: Complex64 = (1..count).map(|k| after(end_s + step * f64::from(k))).sum();
        let tail = step * (inner + 0.5 * after(end_s));
        let missing = whole.value(1, 0, omega) - ended.value(1, 0, omega);
        assert!(
            (missing - tail).norm() < 1e-5 * tail.norm(),
            "{missing} {tail}"
        );
        let long = System {
            record_end_s: Some(100.0),
            ..whole.clone()
        };
        let values = [&whole, &long].map(|system| system.value(1, 0, omega));
        assert!((values[0] - values[1]).norm() < 1e-12 * values[0].norm());
    }

    #[test]
    fn noise_has_the_stated_ratio_and_variance() {
        let system = system();
        let noise = FrfNoise {
            snr_db: 40.0,
            averages: Some(9),
        };
        let exact = system.exact().unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let (mut power, mut stated) = (0.0, 0.0);
        let draws = 200;
        for _ in 0..draws {
            let set = system.noisy(&noise, &mut random).unwrap();
            let pairs = set.values(1).iter().zip(exact.values(1));
            power += pairs.map(|(a, b)| (a - b).norm_sqr()).sum::<f64>();
            stated += set.variance(1).unwrap().iter().sum::<f64>();
        }
        let square: f64 = exact.values(1).iter().map(Complex64::norm_sqr).sum();
        let expected = 1e-4 * square * f64::from(draws);
        // 16,200 exponential values: five deviations are 4 %; the stated ones have 16 degrees of
        // freedom each, 1.4 %.
        assert!(
            (power / expected - 1.0).abs() < 0.04,
            "{}",
            power / expected
        );
        assert!(
            (stated / expected - 1.0).abs() < 0.014,
            "{}",
            stated / expected
        );
        let one = FrfNoise {
            averages: Some(1),
            ..noise
        };
        let error = system.noisy(&one, &mut random).unwrap_err().to_string();
        assert_eq!(error, "averages: got 1, expected 2 or more");
    }
}
