//! Plates, rings and towers are drawn as a model and a tested structure whose stiffnesses differ by
//! up to 15 %; the test has noise, and missing, reversed and misplaced sensors.
//!
//! The true partners of a test mode follow from its shape at all coordinates.

use std::f64::consts::TAU;

use modalign::dof::Dof;
use modalign::linalg::{SymmetricModes, real_matrix, symmetric_modes};
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use num_complex::Complex64;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Frequencies of one root agree to this fraction.
const MAX_REPEATED_ROOT_DIFFERENCE: f64 = 1e-9;
/// Largest and smallest standard deviation of a stiffness error.
const STIFFNESS_ERRORS: std::ops::RangeInclusive<f64> = 0.01..=0.15;
/// Signal-to-noise ratios of the shapes, dB.
const SNR_DB: std::ops::Range<f64> = 20.0..50.0;
const SENSORS: std::ops::RangeInclusive<usize> = 8..=200;

/// Kinds of structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Plate,
    SquarePlate,
    Ring,
    Tower,
}

pub const KINDS: [Kind; 4] = [Kind::Plate, Kind::SquarePlate, Kind::Ring, Kind::Tower];

/// A weighted sum of coordinates: an elongation, or the reading of a sensor.
type Sum = Vec<(usize, f64)>;

struct Body {
    masses: Vec<f64>,
    springs: Vec<(Sum, f64)>,
    /// Possible sensors.
    readings: Vec<Sum>,
}

/// A test mode and the contributions of the roots of the model to its shape, weighted by mass over
/// all coordinates.
pub struct TrueMode {
    pub contributions: Vec<f64>,
    /// The same at the sensors without any fault: MAC with each root.
    pub clean_macs: Vec<f64>,
}

/// A model and a test of one structure.
pub struct Structure {
    pub kind: Kind,
    pub sensors: usize,
    pub theory: ModalModel,
    pub test: ModalModel,
    /// Of every test mode.
    pub truth: Vec<TrueMode>,
}

/// Bending of a plate of points on a grid, free but for weak springs at its corners.
fn plate(columns: usize, rows: usize) -> Body {
    let at = |i: usize, j: usize| i * rows + j;
    let mut springs = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            if (1..columns - 1).contains(&i) {
                let bent = vec![(at(i - 1, j), 1.0), (at(i, j), -2.0), (at(i + 1, j), 1.0)];
                springs.push((bent, 1.0e5));
            }
            if (1..rows - 1).contains(&j) {
                let bent = vec![(at(i, j - 1), 1.0), (at(i, j), -2.0), (at(i, j + 1), 1.0)];
                springs.push((bent, 1.0e5));
            }
            if i + 1 < columns && j + 1 < rows {
                let twisted = vec![
                    (at(i, j), 1.0),
                    (at(i + 1, j), -1.0),
                    (at(i, j + 1), -1.0),
                    (at(i + 1, j + 1), 1.0),
                ];
                springs.push((twisted, 1.4e5));
            }
        }
    }
    for corner in [
        at(0, 0),
        at(columns - 1, 0),
        at(0, rows - 1),
        at(columns - 1, rows - 1),
    ] {
        springs.push((vec![(corner, 1.0)], 2.0e2));
    }
    let count = columns * rows;
    Body {
        masses: vec![0.05; count],
        springs,
        readings: (0..count).map(|at| vec![(at, 1.0)]).collect(),
    }
}

/// Bodies on a circle that move along and across it; each is held to the ground and to the next.
fn ring(bodies: usize) -> Body {
    let (sin, cos) = (TAU / bodies as f64).sin_cos();
    let mut springs = Vec::new();
    for body in 0..bodies {
        let next = (body + 1) % bodies;
        let (across, along) = (2 * body, 2 * body + 1);
        let (next_across, next_along) = (2 * next, 2 * next + 1);
        springs.push((vec![(across, 1.0)], 8e5));
        springs.push((vec![(along, 1.0)], 2e5));
        let radial = vec![(next_across, cos), (next_along, -sin), (across, -1.0)];
        let tangential = vec![(next_across, sin), (next_along, cos), (along, -1.0)];
        springs.push((radial, 6e6));
        springs.push((tangential, 1.5e7));
    }
    Body {
        masses: vec![1.0; 2 * bodies],
        springs,
        readings: (0..2 * bodies).map(|at| vec![(at, 1.0)]).collect(),
    }
}

/// Rigid floors on columns: each moves along x and y and turns; a sensor at a corner reads both.
fn tower(storeys: usize, random: &mut ChaCha8Rng) -> Body {
    let radius = 4.0;
    let eccentric = random.random_range(-0.5..0.5);
    let mut springs = Vec::new();
    let mut readings = Vec::new();
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let mut masses = Vec::new();
    for floor in 0..storeys {
        let of = |storey: usize, (y, x): (f64, f64), along_x: bool| -> Sum {
            // Motion of a corner along an axis: x - θ y, or y + θ x.
            match along_x {
                true => vec![(3 * storey, 1.0), (3 * storey + 2, -y)],
                false => vec![(3 * storey + 1, 1.0), (3 * storey + 2, x)],
            }
        };
        for (y, x) in corners {
            let place = (radius * y + eccentric, radius * x - eccentric);
            for (along_x, stiffness) in [(true, 4.0e7), (false, 4.2e7)] {
                let mut drift = of(floor, place, along_x);
                if let Some(below) = floor.checked_sub(1) {
                    let below = of(below, place, along_x);
                    drift.extend(below.into_iter().map(|(at, part)| (at, -part)));
                }
                springs.push((
                    drift,
                    stiffness * (1.0 - 0.5 * floor as f64 / storeys as f64),
                ));
                readings.push(of(floor, (radius * y, radius * x), along_x));
            }
        }
        masses.extend([2.0e4, 2.0e4, 2.0e4 * 0.6 * radius * radius]);
    }
    Body {
        masses,
        springs,
        readings,
    }
}

impl Body {
    fn draw(kind: Kind, random: &mut ChaCha8Rng) -> Self {
        match kind {
            Kind::Plate => plate(random.random_range(12..18), random.random_range(7..12)),
            Kind::SquarePlate => {
                let side = random.random_range(8..15);
                plate(side, side)
            }
            Kind::Ring => ring(random.random_range(24..90)),
            Kind::Tower => {
                let storeys = random.random_range(6..24);
                tower(storeys, random)
            }
        }
    }

    fn modes(&self, factors: impl Iterator<Item = f64>) -> SymmetricModes {
        let size = self.masses.len();
        let mut stiffness = real_matrix(size, size, |_, _| 0.0);
        for ((row, value), factor) in self.springs.iter().zip(factors) {
            for (i, a) in row {
                for (j, b) in row {
                    stiffness[(*i, *j)] += factor * value * a * b;
                }
            }
        }
        let mass = |i: usize, j| if i == j { self.masses[i] } else { 0.0 };
        symmetric_modes(&stiffness, &real_matrix(size, size, mass)).unwrap()
    }

    fn read(&self, sensor: usize, modes: &SymmetricModes, mode: usize) -> f64 {
        let parts = self.readings[sensor].iter();
        parts
            .map(|(at, part)| part * modes.vectors[(*at, mode)])
            .sum()
    }
}

/// Modes of each root above the rigid ones.
fn roots(modes: &SymmetricModes, range: std::ops::Range<usize>) -> Vec<Vec<usize>> {
    let mut roots: Vec<Vec<usize>> = Vec::new();
    for j in range {
        let value = modes.omega_squared[j];
        match roots.last_mut() {
            Some(last)
                if value - modes.omega_squared[last[0]] <= MAX_REPEATED_ROOT_DIFFERENCE * value =>
            {
                last.push(j);
            }
            _ => roots.push(vec![j]),
        }
    }
    roots
}

fn hz(omega_squared: f64) -> f64 {
    omega_squared.sqrt() / TAU
}

fn dof(sensor: usize) -> Dof {
    format!("{}:+Z", sensor + 1).parse().unwrap()
}

impl Structure {
    /// The structure of a number: kinds go round, all else is drawn.
    pub fn draw(number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(0x5eed_0000 + number);
        let kind = KINDS[number as usize % KINDS.len()];
        let body = Body::draw(kind, &mut random);
        // The suspension of a plate has three modes below the elastic ones.
        let first = match kind {
            Kind::Plate | Kind::SquarePlate => 3,
            Kind::Ring | Kind::Tower => 0,
        };
        let wanted = random.random_range(10..=17).min(body.masses.len() / 2);
        let model = body.modes(std::iter::repeat(1.0));
        let spread = random.random_range(STIFFNESS_ERRORS);
        let common = random.random_range(-spread..spread);
        let factors: Vec<f64> = (body.springs.iter())
            .map(|_| {
                let error: f64 = StandardNormal.sample(&mut random);
                (common + spread * error).exp()
            })
            .collect();
        let tested = body.modes(factors.into_iter());
        let most = *SENSORS.end().min(&body.readings.len());
        // As many small tests as large ones.
        let exponent = random.random_range((*SENSORS.start() as f64).ln()..=(most as f64).ln());
        let mut places: Vec<usize> = (0..body.readings.len()).collect();
        places.shuffle(&mut random);
        places.truncate((exponent.exp().round() as usize).clamp(*SENSORS.start(), most));
        let count = (first + 3 * wanted / 2 + 5).min(body.masses.len());
        let groups = roots(&model, first..count);
        let mut measured: Vec<usize> = (first..first + wanted).collect();
        for _ in 0..random.random_range(0..3) {
            measured.remove(random.random_range(0..measured.len()));
        }
        let test = measured_modes(&body, &tested, (&measured, &places), &mut random);
        let truth = measured.iter().map(|mode| TrueMode {
            contributions: contributions(&body, &model, &groups, &tested, *mode),
            clean_macs: clean_macs(&body, &model, &groups, &tested, (*mode, &places)),
        });
        Self {
            kind,
            sensors: places.len(),
            truth: truth.collect(),
            test,
            theory: of_theory(&body, &model, &groups, &places),
        }
    }
}

fn of_theory(
    body: &Body,
    model: &SymmetricModes,
    groups: &[Vec<usize>],
    places: &[usize],
) -> ModalModel {
    let mut theory = ModalModel::default();
    for (group, root) in groups.iter().enumerate() {
        for j in root {
            let shape = places
                .iter()
                .map(|p| (dof(*p), body.read(*p, model, *j).into()));
            let shape = ModeShape::new(shape);
            let hz = hz(model.omega_squared[*j]);
            let mut mode = Mode::new(hz, None, shape, Scaling::UnitModalMass);
            mode.group = Some(group as u32);
            theory.modes.push(mode);
        }
    }
    theory
}

/// Modes as measured: noise, up to a tenth of the sensors missing, some of them reversed
/// and some exchanged.
fn measured_modes(
    body: &Body,
    tested: &SymmetricModes,
    (measured, places): (&[usize], &[usize]),
    random: &mut ChaCha8Rng,
) -> ModalModel {
    let count = places.len();
    // Of eight sensors one may be reversed or two exchanged, of more both.
    let few = count < 16;
    let missing = random.random_range(0..=if few { 0 } else { count / 10 });
    let reversed = random.random_range(0..=if few { 1 } else { (count / 20).max(2) });
    let pairs = match few {
        true => usize::from(random.random_bool(0.2)),
        false => random.random_range(0..=2),
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.shuffle(random);
    let kept = &order[missing..];
    // The first sensors are exchanged in pairs, the last ones reversed.
    let source = |sensor: usize| {
        let place = kept.iter().position(|other| *other == sensor);
        match place.filter(|place| *place < 2 * pairs) {
            Some(place) => kept[place ^ 1],
            None => sensor,
        }
    };
    let turned = &kept[kept.len() - reversed..];
    let ratio = 10f64.powf(-random.random_range(SNR_DB) / 20.0);
    let mut modes = Vec::new();
    for mode in measured {
        let values: Vec<f64> = places
            .iter()
            .map(|p| body.read(*p, tested, *mode))
            .collect();
        let square: f64 = values.iter().map(|value| value * value).sum();
        let deviation = ratio * (square / count as f64 / 2.0).sqrt();
        let mut noise = || -> f64 { StandardNormal.sample(random) };
        let mut shape = Vec::new();
        for sensor in kept {
            let sign = if turned.contains(sensor) { -1.0 } else { 1.0 };
            let value = Complex64::new(sign * values[source(*sensor)], 0.0);
            let error = Complex64::new(deviation * noise(), deviation * noise());
            shape.push((dof(places[*sensor]), value + error));
        }
        let hz = hz(tested.omega_squared[*mode]);
        let std_hz = 1e-3 * ratio * hz;
        let hz = hz + std_hz * noise();
        let mut found = Mode::new(hz, Some(0.01), ModeShape::new(shape), Scaling::Unknown);
        found.frequency_std_hz = Some(std_hz);
        modes.push(found);
    }
    ModalModel {
        modes,
        ..ModalModel::default()
    }
}

fn contributions(
    body: &Body,
    model: &SymmetricModes,
    groups: &[Vec<usize>],
    tested: &SymmetricModes,
    mode: usize,
) -> Vec<f64> {
    let product = |j: usize| -> f64 {
        let terms = body.masses.iter().enumerate();
        let terms = terms.map(|(i, mass)| mass * model.vectors[(i, j)] * tested.vectors[(i, mode)]);
        terms.sum::<f64>().powi(2)
    };
    let of_root = |root: &Vec<usize>| root.iter().map(|j| product(*j)).sum();
    groups.iter().map(of_root).collect()
}

fn clean_macs(
    body: &Body,
    model: &SymmetricModes,
    groups: &[Vec<usize>],
    tested: &SymmetricModes,
    (mode, places): (usize, &[usize]),
) -> Vec<f64> {
    let values = |modes: &SymmetricModes, mode: usize| -> Vec<Complex64> {
        places
            .iter()
            .map(|p| body.read(*p, modes, mode).into())
            .collect()
    };
    let shape = values(tested, mode);
    let of_root = |root: &Vec<usize>| {
        let span: Vec<Vec<Complex64>> = root.iter().map(|j| values(model, *j)).collect();
        modalign::correlate::subspace_mac(&shape, &span).unwrap_or(0.0)
    };
    groups.iter().map(of_root).collect()
}
