//! Values of FRFs by function, reference by reference as [`System::pairs`], and line.

use std::f64::consts::TAU;

use modalign::frf::{FrfSet, Function, FunctionData};
use modalign::modal::Pole;
use modalign::study::System;
use num_complex::Complex64;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

use super::Measured;
use super::structure::Structure;

/// Signal-to-noise ratio of every FRF, dB: rms over the band over rms noise of a line.
const SNR_DB: (f64, f64) = (45.0, 75.0);
/// Averages of stated variances.
const AVERAGES: (u32, u32) = (4, 16);

pub type Values = Vec<Vec<Complex64>>;

/// Receptance of a structure with these poles between two points.
pub fn receptance(
    structure: &Structure,
    poles: &[Pole],
    points: [usize; 2],
    s: Complex64,
) -> Complex64 {
    let modes = poles.iter().zip(&structure.shapes);
    let terms = modes.map(|(pole, shape)| {
        let residue =
            shape[points[0]] * shape[points[1]] / Complex64::new(0.0, 2.0 * pole.lambda.im);
        residue / (s - pole.lambda) + residue.conj() / (s - pole.lambda.conj())
    });
    terms.sum()
}

/// Values of all FRFs; `value` gives the receptance of a response and a reference at a line.
pub fn values(structure: &Structure, value: impl Fn([usize; 2], Complex64) -> Complex64) -> Values {
    let order = structure.kind.derivative_order();
    let lines = 0..structure.axis.len;
    let function = |points: [usize; 2]| -> Vec<Complex64> {
        let s = lines
            .clone()
            .map(|k| Complex64::new(0.0, structure.axis.rad_s(k)));
        s.map(|s| s.powi(order) * value(points, s)).collect()
    };
    let references = 0..structure.references;
    let pairs = references.flat_map(|i| (0..structure.responses()).map(move |o| [o, i]));
    pairs.map(function).collect()
}

/// White noise of the variances of a drawn signal-to-noise ratio is added; half of the sets state
/// estimated variances.
pub fn with_white_noise(values: Values, truth: System, random: &mut ChaCha8Rng) -> Measured {
    let stated = random.random_bool(0.5);
    with_noise(values, truth, random, stated, |random, len| {
        (0..len).map(|_| white(random)).collect()
    })
}

/// Noise of unit variance per line from `noise` is added at a drawn level.
pub fn with_noise(
    mut values: Values,
    truth: System,
    random: &mut ChaCha8Rng,
    stated: bool,
    noise: impl Fn(&mut ChaCha8Rng, usize) -> Vec<Complex64>,
) -> Measured {
    let share = 10f64.powf(-random.random_range(SNR_DB.0..SNR_DB.1) / 10.0);
    let variances: Vec<f64> = values
        .iter()
        .map(|values| share * mean_square(values))
        .collect();
    let largest = variances.iter().copied().fold(0.0, f64::max);
    // A channel without a signal has noise as well.
    let variances: Vec<f64> = variances.iter().map(|v| v.max(1e-6 * largest)).collect();
    for (values, variance) in values.iter_mut().zip(&variances) {
        let noise = noise(random, values.len());
        for (value, z) in values.iter_mut().zip(noise) {
            *value += z * variance.sqrt();
        }
    }
    let averages = stated.then(|| random.random_range(AVERAGES.0..=AVERAGES.1));
    let set = frf_set(
        &truth,
        values,
        averages.map(|n| (n, &variances[..])),
        random,
    );
    Measured {
        set,
        truth,
        variances,
        is_damping_known: true,
    }
}

/// The set of these values, with estimates of variances from a number of averages.
pub fn frf_set(
    truth: &System,
    values: Values,
    variances: Option<(u32, &[f64])>,
    random: &mut ChaCha8Rng,
) -> FrfSet {
    let mut set = FrfSet::new(truth.axis);
    for (index, (values, (o, i))) in values.into_iter().zip(truth.pairs()).enumerate() {
        let freedom = variances.map(|(averages, _)| 2.0 * f64::from(averages - 1));
        let mut estimate = |variance: f64| {
            let freedom = freedom.unwrap();
            variance * ChiSquared::new(freedom).unwrap().sample(random) / freedom
        };
        let stated =
            variances.map(|(_, all)| values.iter().map(|_| estimate(all[index])).collect());
        let function = Function {
            response: truth.responses[o].clone(),
            reference: truth.references[i].clone(),
            kind: truth.kind,
            averages: variances.map(|(averages, _)| averages),
            estimator: None,
            variance_dof: freedom,
        };
        let data = FunctionData {
            values,
            coherence: None,
            variance: stated,
        };
        set.push(function, data).unwrap();
    }
    set
}

pub fn mean_square(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum::<f64>() / values.len() as f64
}

/// Complex normal number of unit variance.
pub fn white(random: &mut ChaCha8Rng) -> Complex64 {
    let mut part = || -> f64 { StandardNormal.sample(random) };
    Complex64::new(part(), part()) * 0.5f64.sqrt()
}

/// Noise of lines, the transform of white noise in time that a window scales; `share` of the
/// record holds samples, zeros follow. Unit variance per line.
pub fn windowed_noise(
    random: &mut ChaCha8Rng,
    lines: usize,
    share: f64,
    window: impl Fn(f64) -> f64,
) -> Vec<Complex64> {
    let samples = (share * lines as f64).round() as usize;
    let weights: Vec<f64> = (0..samples)
        .map(|n| window(n as f64 / lines as f64))
        .collect();
    let power: f64 = weights.iter().map(|w| w * w).sum();
    let time: Vec<Complex64> = weights
        .iter()
        .map(|w| white(random) * (w / power.sqrt()))
        .collect();
    let transform = |k: usize| -> Complex64 {
        let turn = Complex64::from_polar(1.0, -TAU * k as f64 / lines as f64);
        // Horner's rule from the last sample.
        time.iter()
            .rev()
            .fold(Complex64::ZERO, |sum, value| sum * turn + value)
    };
    (0..lines).map(transform).collect()
}
