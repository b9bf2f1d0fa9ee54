//! FRF sets of known poles and shapes for the tests of this stage, with seeded white noise.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::fourier::ComplexPlan;
use crate::frf::{FrfSet, Function, FunctionData};
use crate::modal::Pole;
use crate::quantity::FrfKind;

/// Complex noise of variance E|z|².
pub(super) fn white_noise(len: usize, variance: f64, seed: u64) -> Vec<Complex64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || {
        let value: f64 = StandardNormal.sample(&mut random);
        value * (0.5 * variance).sqrt()
    };
    (0..len).map(|_| Complex64::new(draw(), draw())).collect()
}

/// Spectrum of white noise under a window `e^(−at)`; `at_end` is aT at the end of the record.
pub(super) fn windowed_noise(lines: usize, at_end: f64, seed: u64) -> Vec<Complex64> {
    let plan = ComplexPlan::inverse(lines);
    let window = |t: usize| (-at_end * t as f64 / lines as f64).exp();
    let white = white_noise(lines, 1.0, seed).into_iter().enumerate();
    let mut samples: Vec<Complex64> = white.map(|(t, v)| v * window(t)).collect();
    plan.run(&mut samples, &mut plan.scratch());
    // The plan's sign is that of an inverse; a spectrum has the other one.
    samples.reverse();
    samples
}

/// A structure of unit modal masses: natural frequency in Hz, damping ratio, values along the
/// positive axis of points 1, 2, ...
#[derive(Clone, Debug)]
pub(super) struct Structure {
    pub modes: Vec<(f64, f64, Vec<f64>)>,
}

/// Measurement of a structure: FRFs, kind and noise.
#[derive(Clone, Debug)]
pub(super) struct Measurement {
    pub axis: FrequencyAxis,
    pub kind: FrfKind,
    pub pairs: Vec<(Dof, Dof)>,
    /// Signal-to-noise ratio of each FRF over the axis, dB; none without it.
    pub snr_db: Option<f64>,
    pub variance_given: bool,
    pub added_damping_rad_s: f64,
    pub seed: u64,
}

impl Measurement {
    /// Accelerances of `n` sensors `1:+Z` to `n:+Z` for an excitation at `1:+Z`.
    pub fn of_sensors(n: usize, axis: FrequencyAxis) -> Self {
        let dof = |p: usize| format!("{p}:+Z").parse().unwrap();
        Self {
            axis,
            kind: FrfKind::Accelerance,
            pairs: (1..=n).map(|p| (dof(p), dof(1))).collect(),
            snr_db: None,
            variance_given: true,
            added_damping_rad_s: 0.0,
            seed: 1,
        }
    }
}

impl Structure {
    fn component(shape: &[f64], dof: &Dof) -> f64 {
        dof.sign() * shape[dof.node().unwrap() as usize - 1]
    }

    /// Receptance residue of a mode at a pair, `φ_r φ_k/(2iω_d)`.
    pub fn residue(&self, mode: usize, pair: &(Dof, Dof)) -> Complex64 {
        let (hz, zeta, shape) = &self.modes[mode];
        let damped = Pole::from_frequency(*hz, *zeta).lambda.im;
        let product = Self::component(shape, &pair.0) * Self::component(shape, &pair.1);
        product / Complex64::new(0.0, 2.0 * damped)
    }

    pub fn value(&self, pair: &(Dof, Dof), s: Complex64, order: i32) -> Complex64 {
        let term = |j: usize| {
            let lambda = Pole::from_frequency(self.modes[j].0, self.modes[j].1).lambda;
            let a = self.residue(j, pair);
            a / (s - lambda) + a.conj() / (s - lambda.conj())
        };
        (0..self.modes.len()).map(term).sum::<Complex64>() * s.powi(order)
    }

    /// The measured set.
    pub fn measured(&self, how: &Measurement) -> FrfSet {
        let mut set = FrfSet::new(how.axis);
        set.added_damping_rad_s = how.added_damping_rad_s;
        for (i, pair) in how.pairs.iter().enumerate() {
            let s = |k: usize| Complex64::new(how.added_damping_rad_s, how.axis.rad_s(k));
            let order = how.kind.derivative_order();
            let mut values: Vec<Complex64> = (0..how.axis.len)
                .map(|k| self.value(pair, s(k), order))
                .collect();
            let power = values.iter().map(Complex64::norm_sqr).sum::<f64>() / values.len() as f64;
            let variance = how.snr_db.map(|db| power * 10f64.powf(-db / 10.0));
            if let Some(variance) = variance {
                let noise = white_noise(values.len(), variance, how.seed * 1000 + i as u64);
                values.iter_mut().zip(noise).for_each(|(v, z)| *v += z);
            }
            let data = FunctionData {
                values,
                coherence: None,
                variance: variance
                    .filter(|_| how.variance_given)
                    .map(|v| vec![v; how.axis.len]),
            };
            let function = Function {
                response: pair.0.clone(),
                reference: pair.1.clone(),
                kind: how.kind,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            set.push(function, data).unwrap();
        }
        set
    }
}

impl Structure {
    /// The measured set with a mass in kg at a point in each FRF, counted from 0: a response o, hit
    /// at i, is `α_oi − α_op s² m α_pi/(1 + s² m α_pp)`.
    pub fn measured_under_masses(
        &self,
        how: &Measurement,
        mass_of_frf: impl Fn(usize) -> (usize, f64),
    ) -> FrfSet {
        let measured = self.measured(how);
        let mut set = FrfSet::new(how.axis);
        let order = how.kind.derivative_order();
        for (f, (sensor, hit)) in how.pairs.iter().enumerate() {
            let (point, mass_kg) = mass_of_frf(f);
            let loaded: Dof = format!("{}:+Z", point + 1).parse().unwrap();
            let change = |k: usize| {
                let s = Complex64::new(0.0, how.axis.rad_s(k));
                let receptance = |a: &Dof, b: &Dof| self.value(&(a.clone(), b.clone()), s, 0);
                let inertia = s * s * mass_kg;
                let both = receptance(sensor, &loaded) * inertia * receptance(&loaded, hit);
                -s.powi(order) * both / (1.0 + inertia * receptance(&loaded, &loaded))
            };
            let values = measured.values(f).iter().enumerate();
            let data = FunctionData {
                values: values.map(|(k, value)| value + change(k)).collect(),
                coherence: None,
                variance: measured.variance(f).map(<[f64]>::to_vec),
            };
            set.push(measured.functions()[f].clone(), data).unwrap();
        }
        set
    }
}

/// A shape component between 0.3 and 1, of either sign: no sensor is near a node.
fn component(random: &mut ChaCha8Rng) -> f64 {
    let size: f64 = random.random_range(0.3..1.0);
    if random.random_bool(0.5) { size } else { -size }
}

/// Three to six modes of 0.2 to 3 % damping, separated by at least ten half-power bandwidths of the
/// wider one, at five to twelve sensors; 5.5 to 12 lines across the narrowest resonance.
pub(super) fn separated_modes(seed: u64) -> (Structure, Measurement) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let sensors = random.random_range(5..=12);
    let mut hz: f64 = random.random_range(40.0..120.0);
    let mut modes: Vec<(f64, f64, Vec<f64>)> = Vec::new();
    for _ in 0..random.random_range(3..=6) {
        let zeta = 10f64.powf(random.random_range(-2.7..-1.52));
        if let Some(last) = modes.last() {
            let below = last.0 * (1.0 + 20.0 * last.1);
            let above = last.0 / (1.0 - 20.0 * zeta).max(0.3);
            hz = below.max(above) * random.random_range(1.01..1.5);
        }
        let shape = (0..sensors).map(|_| component(&mut random)).collect();
        modes.push((hz, zeta, shape));
    }
    let narrowest = modes.iter().map(width_hz).fold(f64::MAX, f64::min);
    let step_hz = narrowest / random.random_range(5.5..12.0);
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz,
        len: (1.3 * hz / step_hz) as usize,
    };
    let how = Measurement {
        seed,
        ..Measurement::of_sensors(sensors, axis)
    };
    (Structure { modes }, how)
}

/// Half-power bandwidth 2ζf of a mode, Hz.
pub(super) fn width_hz(mode: &(f64, f64, Vec<f64>)) -> f64 {
    2.0 * mode.0 * mode.1
}

/// Difference of two close modes: the second shape is the first plus `difference` times a random
/// one (any shape without it), times `ratio`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub spacing_widths: f64,
    pub difference: Option<f64>,
    pub ratio: f64,
    pub lines_per_width: (f64, f64),
}

/// A close pair from 200 Hz and a distant third mode.
pub(super) fn close_pair(seed: u64, pair: Pair) -> (Structure, Measurement) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let sensors = random.random_range(5..=12);
    let zeta = 10f64.powf(random.random_range(-2.7..-1.52));
    let mut shape = || -> Vec<f64> { (0..sensors).map(|_| component(&mut random)).collect() };
    let (first, other, distant) = (shape(), shape(), shape());
    let second = first.iter().zip(&other).enumerate().map(|(i, (a, b))| {
        let value = match pair.difference {
            Some(_) if i == 0 => *a,
            Some(difference) => a + difference * b,
            None => *b,
        };
        pair.ratio * value
    });
    let width = 400.0 * zeta;
    let modes = vec![
        (200.0, zeta, first.clone()),
        (200.0 + pair.spacing_widths * width, zeta, second.collect()),
        (360.0 + 20.0 * width, zeta, distant),
    ];
    let (minimum, maximum) = pair.lines_per_width;
    let step_hz = width / random.random_range(minimum..maximum);
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz,
        len: ((480.0 + 30.0 * width) / step_hz) as usize,
    };
    let how = Measurement {
        seed,
        ..Measurement::of_sensors(sensors, axis)
    };
    (Structure { modes }, how)
}
