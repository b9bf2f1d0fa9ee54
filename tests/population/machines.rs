//! Each pair of a model and a test shares one machine, whose stiffnesses are wrong in the model;
//! the true pairing of their modes is known.
//!
//! Three kinds of machine: a square membrane of point masses (double roots by symmetry), a ring of
//! bodies that move along and across it (double roots by rotation), and a frame of point masses in
//! space (none). The springs of the tested machine differ from those of the model; half of the
//! membranes and rings keep their symmetry, so that their roots stay repeated and are measured in a
//! randomly rotated basis.
//!
//! [`Family::Equal`] has equal masses: the thresholds of pairing were set on it.
//! [`Family::HeldOut`] has masses up to five times as heavy as others, and in half of its machines
//! up to three small oscillators, which may carry no sensor.

use std::f64::consts::TAU;

use modalign::dof::Dof;
use modalign::linalg::{SymmetricModes, real_matrix, symmetric_modes};
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use num_complex::Complex64;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Numbers of sensors that are drawn from.
pub const SENSORS: [usize; 5] = [8, 20, 30, 45, 60];
/// Frequencies of one root agree to this part.
const MAX_REPEATED_ROOT_DIFFERENCE: f64 = 1e-9;
/// Largest deviation of the logarithm of a stiffness; frequencies follow at half of it.
const MAX_LOG_SPREAD: f64 = 0.25;
/// Largest logarithm of the common factor of all stiffnesses; frequencies change by half of it.
const MAX_LOG_COMMON: f64 = 0.18;
/// Mass of the heaviest body over that of the lightest.
const MASS_RATIO: f64 = 5.0;
/// Mass of a small oscillator over that of its body.
const OSCILLATOR: std::ops::Range<f64> = 0.005..0.05;
/// Largest error of a frequency.
const MAX_FREQUENCY_ERROR: f64 = 0.1;
/// Deviation of a measured frequency over the frequency, per noise-to-signal ratio of the shapes.
const FREQUENCY_NOISE: f64 = 1e-3;

/// The model root that belongs to a test mode.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Number of the model root with the largest part of the shape.
    pub root: usize,
    /// Part of the shape in the span of this root, weighted by mass over all degrees of freedom.
    pub mac: f64,
}

/// A model and a test of one machine.
pub struct Machine {
    pub sensors: usize,
    /// With unit modal masses, at the sensors.
    pub theory: ModalModel,
    pub test: ModalModel,
    /// Of every test mode.
    pub truth: Vec<Truth>,
}

/// A family of machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Equal,
    HeldOut,
}

impl Family {
    fn seed(self) -> u64 {
        match self {
            Family::Equal => 0x9a12,
            Family::HeldOut => 0x71c4_0000,
        }
    }
}

/// Springs between degrees of freedom, or to the ground.
struct Network {
    masses: Vec<f64>,
    springs: Vec<Spring>,
    /// Bodies of one kind are equal by the machine's symmetry.
    kinds: Vec<usize>,
}

struct Spring {
    /// Coefficients of the elongation.
    row: Vec<(usize, f64)>,
    stiffness: f64,
    /// Springs of one class are equal by the machine's symmetry.
    class: usize,
}

impl Network {
    fn modes(&self, factors: &[f64]) -> SymmetricModes {
        let size = self.masses.len();
        let mut stiffness = real_matrix(size, size, |_, _| 0.0);
        for (spring, factor) in self.springs.iter().zip(factors) {
            for (i, a) in &spring.row {
                for (j, b) in &spring.row {
                    stiffness[(*i, *j)] += factor * spring.stiffness * a * b;
                }
            }
        }
        let mass = |i: usize, j| if i == j { self.masses[i] } else { 0.0 };
        symmetric_modes(&stiffness, &real_matrix(size, size, mass)).unwrap()
    }

    /// Draws one mass for the bodies of each kind.
    fn draw_masses(&mut self, random: &mut ChaCha8Rng) {
        let kinds = self.kinds.iter().max().unwrap() + 1;
        let exponent = || MASS_RATIO.powf(random.random_range(-0.5..0.5));
        let of_kind: Vec<f64> = std::iter::repeat_with(exponent).take(kinds).collect();
        self.masses = self.kinds.iter().map(|kind| of_kind[*kind]).collect();
    }

    /// Hangs a small mass on a degree of freedom; its natural frequency, with the machine fixed, is
    /// among the lowest of the machine.
    fn hang_oscillator(&mut self, random: &mut ChaCha8Rng) {
        let modes = self.modes(&vec![1.0; self.springs.len()]);
        let omega_squared = modes.omega_squared[random.random_range(1..12)];
        let at = random.random_range(0..self.kinds.len());
        let mass = random.random_range(OSCILLATOR) * self.masses[at];
        let oscillator = self.masses.len();
        self.masses.push(mass);
        let classes = self.springs.iter().map(|spring| spring.class).max();
        self.springs.push(Spring {
            row: vec![(oscillator, 1.0), (at, -1.0)],
            stiffness: mass * omega_squared,
            class: classes.unwrap() + 1,
        });
    }

    /// Factors of all stiffnesses: a common one, one of a class, and, where symmetry is lost, one
    /// of the individual spring.
    fn factors(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let (common, spread) = (
            random.random_range(-MAX_LOG_COMMON..MAX_LOG_COMMON),
            MAX_LOG_SPREAD * random.random::<f64>(),
        );
        let individual = if random.random_bool(0.5) { spread } else { 0.0 };
        let classes = self
            .springs
            .iter()
            .map(|spring| spring.class)
            .max()
            .unwrap_or(0)
            + 1;
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let of_class: Vec<f64> = (0..classes).map(|_| spread * normal()).collect();
        let of_spring =
            |spring: &Spring| (common + of_class[spring.class] + individual * normal()).exp();
        self.springs.iter().map(of_spring).collect()
    }
}

/// Masses on a square grid, held by springs to their neighbours and to the frame around; bands of
/// rows are classes, each with its band of columns.
fn membrane() -> Network {
    const SIDE: usize = 8;
    let mut springs = Vec::new();
    for line in 0..SIDE {
        for gap in 0..=SIDE {
            for along_rows in [true, false] {
                let of = |step: usize| {
                    if along_rows {
                        SIDE * line + step
                    } else {
                        SIDE * step + line
                    }
                };
                let before = gap.checked_sub(1).map(|step| (of(step), 1.0));
                let after = (gap < SIDE).then(|| (of(gap), -1.0));
                springs.push(Spring {
                    row: before.into_iter().chain(after).collect(),
                    stiffness: 4e6,
                    class: gap.min(SIDE - gap),
                });
            }
        }
    }
    // The symmetry of a square.
    let kind = |body: usize| {
        let from_edge = |at: usize| at.min(SIDE - 1 - at);
        let (a, b) = (from_edge(body / SIDE), from_edge(body % SIDE));
        SIDE * a.min(b) + a.max(b)
    };
    Network {
        masses: vec![1.0; SIDE * SIDE],
        springs,
        kinds: (0..SIDE * SIDE).map(kind).collect(),
    }
}

/// Bodies on a circle that move along it and across; each is held to the ground and to the next.
fn ring() -> Network {
    const BODIES: usize = 32;
    let (sin, cos) = (TAU / BODIES as f64).sin_cos();
    let mut springs = Vec::new();
    for body in 0..BODIES {
        let next = (body + 1) % BODIES;
        let (across, along) = (2 * body, 2 * body + 1);
        let (next_across, next_along) = (2 * next, 2 * next + 1);
        let rows = [
            (vec![(across, 1.0)], 1e6),
            (vec![(along, 1.0)], 3e5),
            // The motion of the next along the axes of this.
            (
                vec![(next_across, cos), (next_along, -sin), (across, -1.0)],
                6e6,
            ),
            (
                vec![(next_across, sin), (next_along, cos), (along, -1.0)],
                1.2e7,
            ),
        ];
        for (class, (row, stiffness)) in rows.into_iter().enumerate() {
            springs.push(Spring {
                row,
                stiffness,
                class,
            });
        }
    }
    // Every fourth body is of one kind.
    Network {
        masses: vec![1.0; 2 * BODIES],
        springs,
        kinds: (0..2 * BODIES).map(|body| body / 2 % 4).collect(),
    }
}

/// Points in a box, each on springs to its nearest neighbours and on weak ones to the ground;
/// classes are drawn.
fn frame(random: &mut ChaCha8Rng) -> Network {
    const POINTS: usize = 24;
    const NEIGHBOURS: usize = 9;
    const CLASSES: usize = 8;
    let mut point = || {
        [
            random.random_range(0.0..2.0),
            random.random(),
            random.random(),
        ]
    };
    let points: Vec<[f64; 3]> = (0..POINTS).map(|_| point()).collect();
    let mut springs = Vec::new();
    for (n, from) in points.iter().enumerate() {
        let to = |m: usize| [0, 1, 2].map(|axis| points[m][axis] - from[axis]);
        let length = |m: usize| to(m).iter().map(|v| v * v).sum::<f64>().sqrt();
        let mut others: Vec<usize> = (0..POINTS).filter(|m| *m != n).collect();
        others.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        for &m in &others[..NEIGHBOURS] {
            let along = to(m).map(|v| v / length(m));
            let ends = |axis: usize| [(3 * m + axis, along[axis]), (3 * n + axis, -along[axis])];
            springs.push(Spring {
                row: (0..3).flat_map(ends).collect(),
                stiffness: 2e6 / length(m),
                class: random.random_range(0..CLASSES),
            });
        }
        for axis in 0..3 {
            springs.push(Spring {
                row: vec![(3 * n + axis, 1.0)],
                stiffness: 1e5,
                class: random.random_range(0..CLASSES),
            });
        }
    }
    Network {
        masses: vec![1.0; 3 * POINTS],
        springs,
        kinds: (0..3 * POINTS).map(|coordinate| coordinate / 3).collect(),
    }
}

impl Machine {
    /// The machine of a number: the kind and the sensors go round, all else is drawn.
    pub fn draw(family: Family, number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(family.seed() + number);
        let mut network = match number % 3 {
            0 => membrane(),
            1 => ring(),
            _ => frame(&mut random),
        };
        if family == Family::HeldOut {
            network.draw_masses(&mut random);
            let count = random.random_range(-2i32..=3).max(0);
            (0..count).for_each(|_| network.hang_oscillator(&mut random));
        }
        let size = network.masses.len();
        let theory = network.modes(&vec![1.0; network.springs.len()]);
        let wanted = random.random_range(8..=25);
        let truth = loop {
            let truth = network.modes(&network.factors(&mut random));
            let error = |j: usize| (truth.omega_squared[j] / theory.omega_squared[j]).sqrt() - 1.0;
            if (0..wanted).all(|j| error(j).abs() <= MAX_FREQUENCY_ERROR) {
                break truth;
            }
        };
        let sensors = SENSORS[(number / 3) as usize % SENSORS.len()];
        let mut places: Vec<usize> = (0..size).collect();
        places.shuffle(&mut random);
        places.truncate(sensors);
        places.sort_unstable();
        let snr_db = random.random_range(20.0..60.0);
        let measured = Measured::new(&truth, wanted, &mut random);
        let modes = measured.modes((&places, snr_db), &mut random);
        // A test lists what it found by frequency.
        let mut found: Vec<_> = modes
            .into_iter()
            .zip(measured.belongings(&theory, &network.masses))
            .collect();
        found.sort_by(|a, b| a.0.frequency_hz.total_cmp(&b.0.frequency_hz));
        let (modes, truth) = found.into_iter().unzip();
        Self {
            sensors,
            truth,
            test: ModalModel {
                modes,
                ..ModalModel::default()
            },
            // A model knows some modes beyond the band of the test.
            theory: of_theory(&theory, &places, (3 * wanted / 2 + 5).min(size)),
        }
    }
}

/// Numbers of the modes of each root.
fn roots(modes: &SymmetricModes, count: usize) -> Vec<Vec<usize>> {
    let mut roots: Vec<Vec<usize>> = Vec::new();
    for j in 0..count {
        let eigenvalue = modes.omega_squared[j];
        match roots.last_mut() {
            Some(last)
                if eigenvalue - modes.omega_squared[last[0]]
                    <= MAX_REPEATED_ROOT_DIFFERENCE * eigenvalue =>
            {
                last.push(j)
            }
            _ => roots.push(vec![j]),
        }
    }
    roots
}

fn hz(omega_squared: f64) -> f64 {
    omega_squared.sqrt() / TAU
}

fn dof(place: usize) -> Dof {
    format!("{}:+Z", place + 1).parse().unwrap()
}

fn of_theory(modes: &SymmetricModes, places: &[usize], count: usize) -> ModalModel {
    let mut model = ModalModel::default();
    for (group, root) in roots(modes, count).into_iter().enumerate() {
        for j in root {
            let shape = places
                .iter()
                .map(|p| (dof(*p), modes.vectors[(*p, j)].into()));
            let mut mode = Mode::new(
                hz(modes.omega_squared[j]),
                None,
                ModeShape::new(shape),
                Scaling::UnitModalMass,
            );
            mode.group = Some(group as u32);
            model.modes.push(mode);
        }
    }
    model
}

/// Modes that a test found, over all degrees of freedom.
struct Measured {
    hz: Vec<f64>,
    vectors: Vec<Vec<f64>>,
}

impl Measured {
    /// The lowest modes in a basis turned at random within each root, up to three of them missed.
    fn new(modes: &SymmetricModes, count: usize, random: &mut ChaCha8Rng) -> Self {
        let size = modes.vectors.nrows();
        let column = |j: usize| {
            (0..size)
                .map(|i| modes.vectors[(i, j)])
                .collect::<Vec<f64>>()
        };
        let (mut all_hz, mut vectors) = (Vec::new(), Vec::new());
        for root in roots(modes, count) {
            let mut columns: Vec<Vec<f64>> = root.iter().map(|j| column(*j)).collect();
            if let [a, b] = columns.as_mut_slice() {
                let (sin, cos) = random.random_range(0.0..TAU).sin_cos();
                for (x, y) in a.iter_mut().zip(b) {
                    (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
                }
            }
            all_hz.extend(root.iter().map(|j| hz(modes.omega_squared[*j])));
            vectors.extend(columns);
        }
        for _ in 0..random.random_range(0..=3) {
            let missed = random.random_range(0..all_hz.len());
            all_hz.remove(missed);
            vectors.remove(missed);
        }
        Self {
            hz: all_hz,
            vectors,
        }
    }

    /// The root that holds most of each mode.
    fn belongings(&self, theory: &SymmetricModes, masses: &[f64]) -> Vec<Truth> {
        let roots = roots(theory, theory.omega_squared.len());
        let part = |shape: &[f64], j: usize| {
            let sum: f64 = shape
                .iter()
                .enumerate()
                .map(|(i, v)| v * masses[i] * theory.vectors[(i, j)])
                .sum();
            sum * sum
        };
        let of = |shape: &Vec<f64>| {
            let held = |root: &Vec<usize>| root.iter().map(|j| part(shape, *j)).sum::<f64>();
            let all = roots.iter().map(held).enumerate();
            let (root, mac) = all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            Truth { root, mac }
        };
        self.vectors.iter().map(of).collect()
    }

    /// As measured: shapes at the sensors with noise, frequencies with theirs.
    fn modes(&self, (places, snr_db): (&[usize], f64), random: &mut ChaCha8Rng) -> Vec<Mode> {
        let ratio = 10f64.powf(-snr_db / 20.0);
        let mut modes = Vec::new();
        for (hz, vector) in self.hz.iter().zip(&self.vectors) {
            let square: f64 = places.iter().map(|p| vector[*p] * vector[*p]).sum();
            let deviation = ratio * (square / places.len() as f64 / 2.0).sqrt();
            let mut noise = || {
                let part: f64 = StandardNormal.sample(random);
                deviation * part
            };
            let shape: Vec<_> = places
                .iter()
                .map(|p| (dof(*p), Complex64::new(vector[*p] + noise(), noise())))
                .collect();
            let error: f64 = StandardNormal.sample(random);
            let std_hz = FREQUENCY_NOISE * ratio * hz;
            let mut mode = Mode::new(
                hz + std_hz * error,
                Some(0.01),
                ModeShape::new(shape),
                Scaling::Unknown,
            );
            mode.frequency_std_hz = Some(std_hz);
            modes.push(mode);
        }
        modes
    }
}
