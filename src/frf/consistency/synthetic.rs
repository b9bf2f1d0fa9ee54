//! Small modal models measured with known faults and noise, for the tests of the checks.

use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::frf::{FrfSet, Function, FunctionData, Residues, synthesise};
use crate::modal::Pole;
use crate::quantity::FrfKind;

/// Five modes of real shapes at eight points of a line along z; 0.5 to 1.2 % damping, 10 lines and
/// more per width.
pub(in crate::frf) struct Beam {
    pub kind: FrfKind,
    pub added_damping_rad_s: f64,
    /// Factor on the frequencies by the number of the mode.
    pub shift: [f64; 5],
}

impl Default for Beam {
    fn default() -> Self {
        Self {
            kind: FrfKind::Accelerance,
            added_damping_rad_s: 0.0,
            shift: [1.0; 5],
        }
    }
}

/// Natural frequency, Hz, and damping ratio.
const MODES: [(f64, f64); 5] = [
    (62.0, 0.012),
    (121.0, 0.008),
    (205.0, 0.006),
    (310.0, 0.006),
    (390.0, 0.005),
];

/// 0 to 500 Hz; half the sampling rate at the last line.
pub(super) const AXIS: FrequencyAxis = FrequencyAxis {
    start_hz: 0.0,
    step_hz: 0.125,
    len: 4001,
};

pub(super) fn dof(text: &str) -> Dof {
    text.parse().expect("a degree of freedom as text")
}

/// Component of a mode at a point from 1: signs as of a free beam with point 1 and point 3 at its
/// ends, no node nearer than 0.3 of the largest.
pub(super) fn component(mode: usize, dof: &Dof) -> f64 {
    let point = dof
        .node()
        .expect("points of the synthetic set have numbers") as usize;
    let size = 0.65 + 0.35 * (2.3 * (point * (mode + 2)) as f64).sin();
    let turned = match point {
        3 => mode % 2 == 1,
        1 => false,
        _ => (point * (mode + 1)) % 3 == 1,
    };
    let sign = if turned { -1.0 } else { 1.0 };
    dof.sign() * sign * size
}

impl Beam {
    /// The functions of some pairs, without noise.
    pub fn set(&self, pairs: &[(&str, &str)]) -> FrfSet {
        let pairs: Vec<(Dof, Dof)> = pairs.iter().map(|(r, f)| (dof(r), dof(f))).collect();
        let modes: Vec<(Pole, Residues)> = (0..MODES.len())
            .map(|mode| self.mode(mode, &pairs))
            .collect();
        let terms: Vec<(Pole, &Residues)> = modes.iter().map(|(p, r)| (*p, r)).collect();
        synthesise(&terms, AXIS, &pairs, self.kind, self.added_damping_rad_s)
            .expect("terms of one length")
    }

    fn mode(&self, mode: usize, pairs: &[(Dof, Dof)]) -> (Pole, Residues) {
        let (hz, zeta) = MODES[mode];
        let pole = Pole::from_frequency(hz * self.shift[mode], zeta);
        let residue = |(r, f): &(Dof, Dof)| {
            component(mode, r) * component(mode, f) / Complex64::new(0.0, 2.0 * pole.lambda.im)
        };
        let residues = pairs.iter().map(|pair| (pair.clone(), residue(pair)));
        (pole, residues.collect())
    }

    /// The function of one pair under the name of another.
    pub fn relabelled(&self, pair: (&str, &str), named: (&str, &str)) -> FrfSet {
        let set = self.set(&[pair]);
        changed(&set, |_, function| {
            function.response = dof(named.0);
            function.reference = dof(named.1);
        })
    }
}

fn changed(set: &FrfSet, change: impl Fn(usize, &mut Function)) -> FrfSet {
    with_values(set, change, |i, k| set.values(i)[k])
}

fn with_values(
    set: &FrfSet,
    change: impl Fn(usize, &mut Function),
    value: impl Fn(usize, usize) -> Complex64,
) -> FrfSet {
    let mut out = FrfSet::new(*set.axis());
    out.added_damping_rad_s = set.added_damping_rad_s;
    out.valid_band = set.valid_band;
    for (i, function) in set.functions().iter().enumerate() {
        let mut function = function.clone();
        change(i, &mut function);
        let data = FunctionData {
            values: (0..set.axis().len).map(|k| value(i, k)).collect(),
            coherence: None,
            variance: set.variance(i).map(<[f64]>::to_vec),
        };
        out.push(function, data).expect("values for every line");
    }
    out
}

/// Function `which` times a factor.
pub(in crate::frf) fn scaled(set: &FrfSet, which: usize, factor: f64) -> FrfSet {
    let of = |i: usize| if i == which { factor } else { 1.0 };
    with_values(set, |_, _| (), |i, k| of(i) * set.values(i)[k])
}

/// All responses later by a time.
pub(super) fn delayed(set: &FrfSet, delay_s: f64) -> FrfSet {
    let turn = |k: usize| Complex64::from_polar(1.0, -set.axis().rad_s(k) * delay_s);
    with_values(set, |_, _| (), |i, k| turn(k) * set.values(i)[k])
}

/// All functions of several sets on one axis.
pub(super) fn joined(sets: &[FrfSet]) -> FrfSet {
    let mut out = FrfSet::new(*sets[0].axis());
    out.added_damping_rad_s = sets[0].added_damping_rad_s;
    for set in sets {
        for (i, function) in set.functions().iter().enumerate() {
            let data = FunctionData {
                values: set.values(i).to_vec(),
                coherence: None,
                variance: set.variance(i).map(<[f64]>::to_vec),
            };
            out.push(function.clone(), data)
                .expect("values for every line");
        }
    }
    out
}

/// Averages behind the stated variance of noisy sets.
pub(super) const AVERAGES: u32 = 5;

/// White complex noise of a signal-to-noise ratio (rms over the band over rms noise), with the
/// variance of each line as five hits know it: the true one times χ² of 8 degrees of freedom
/// over 8.
pub(in crate::frf) fn add_noise(set: &mut FrfSet, snr_db: f64, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).expect("a positive deviation");
    let mut out = FrfSet::new(*set.axis());
    out.added_damping_rad_s = set.added_damping_rad_s;
    for (i, function) in set.functions().iter().enumerate() {
        let power = set.values(i).iter().map(Complex64::norm_sqr).sum::<f64>();
        let variance = power / set.axis().len as f64 * 10f64.powf(-snr_db / 10.0);
        let mut draw = || normal.sample(&mut random);
        let half = (0.5 * variance).sqrt();
        let noisy = |y: &Complex64| y + Complex64::new(half * draw(), half * draw());
        let values = set.values(i).iter().map(noisy).collect();
        let freedom = 2 * (AVERAGES - 1);
        let mut known = || {
            let sum: f64 = (0..freedom)
                .map(|_| normal.sample(&mut random).powi(2))
                .sum();
            variance * sum / f64::from(freedom)
        };
        let variance = Some((0..set.axis().len).map(|_| known()).collect());
        let mut function = function.clone();
        function.averages = Some(AVERAGES);
        let data = FunctionData {
            values,
            coherence: None,
            variance,
        };
        out.push(function, data).expect("values for every line");
    }
    *set = out;
}
