//! Synthetic modes of three rigid bodies on springs, with one wrong sensor.

use std::collections::BTreeMap;

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::PlacedSensor;
use super::repair::Repair;
use super::synthetic::{Body, Fault, UNSCALED};
use crate::dof::Dof;
use crate::linalg::{RealMatrix, real_matrix, symmetric_modes};
use crate::modal::{Mode, ModeShape, Scaling};

const BODIES: usize = 3;

/// The lowest modes of a drawn machine.
pub(super) struct SpringMountedBodies {
    pub modes: Vec<Mode>,
    /// The same modes and deviations without noise.
    pub noise_free: Vec<Mode>,
    /// The sensors of each body, as the test's description has them.
    pub placed: Vec<BTreeMap<Dof, PlacedSensor>>,
    /// The body with the wrong sensor.
    pub wrong_body: usize,
    /// What mends it.
    pub repair: Option<Repair>,
}

/// A spring at a point, between bodies or to ground.
struct Spring {
    row: Vec<f64>,
    stiffness: f64,
}

fn springs(random: &mut ChaCha8Rng, bodies: &[Body]) -> Vec<Spring> {
    let mut springs = Vec::new();
    let mut between = |random: &mut ChaCha8Rng, one: usize, other: Option<usize>| {
        for _ in 0..6 {
            let mut row = vec![0.0; 6 * BODIES];
            let at = bodies[one].sensor(random);
            for (a, value) in at.row(&UNSCALED).into_iter().enumerate() {
                row[6 * one + a] = value;
            }
            if let Some(other) = other {
                let end = PlacedSensor {
                    direction: at.direction,
                    ..bodies[other].sensor(random)
                };
                for (a, value) in end.row(&UNSCALED).into_iter().enumerate() {
                    row[6 * other + a] = -value;
                }
            }
            let stiffness = 10f64.powf(random.random_range(5.0..6.5));
            springs.push(Spring { row, stiffness });
        }
    };
    for body in 0..BODIES {
        between(random, body, None);
        between(random, body, Some((body + 1) % BODIES));
    }
    springs
}

/// Frequencies in Hz and motions of the bodies, one per column.
struct Motions {
    all_hz: Vec<f64>,
    vectors: RealMatrix,
}

fn motions(bodies: &[Body], springs: &[Spring]) -> Motions {
    let size = 6 * BODIES;
    let mass = real_matrix(size, size, |a, b| match a / 6 == b / 6 {
        true => bodies[a / 6].inertia[a % 6][b % 6],
        false => 0.0,
    });
    let stiffness = real_matrix(size, size, |a, b| {
        let of_springs = springs.iter();
        of_springs
            .map(|spring| spring.stiffness * spring.row[a] * spring.row[b])
            .sum()
    });
    let modes = symmetric_modes(&stiffness, &mass).expect("three bodies");
    let hz = |squared: &f64| squared.sqrt() / std::f64::consts::TAU;
    Motions {
        all_hz: modes.omega_squared.iter().map(hz).collect(),
        vectors: modes.vectors,
    }
}

/// The lowest 3 to 8 modes of three bodies with 5 to 14 sensors each, noise of 0.3 to 2 % of the
/// shape, phases of a damped machine, and this fault of one sensor. Body 0 bends in the modes from
/// `bending_from` on, as it does near its first mode.
pub(super) fn spring_mounted_bodies(
    seed: u64,
    fault: Fault,
    bending_from: Option<usize>,
) -> SpringMountedBodies {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let bodies: Vec<Body> = (0..BODIES).map(|_| Body::new(&mut random)).collect();
    let springs = springs(&mut random, &bodies);
    let motions = motions(&bodies, &springs);
    let dof = |body: usize, sensor: usize| -> Dof {
        let number = 100 * (body + 1) + sensor;
        format!("{number}:+Z").parse().expect("a DOF")
    };
    let sensors: Vec<Vec<PlacedSensor>> = bodies
        .iter()
        .map(|body| {
            let count = random.random_range(5..=14);
            (0..count).map(|_| body.sensor(&mut random)).collect()
        })
        .collect();
    let wrong_body = random.random_range(0..BODIES);
    let count = sensors[wrong_body].len();
    let wrong = random.random_range(0..count);
    let other = (wrong + random.random_range(1..count)) % count;
    let gain = match random.random() {
        true => random.random_range(1.03..1.3),
        false => random.random_range(0.7..0.97),
    };
    let mut actual = sensors.clone();
    let mut factor = 1.0;
    let wrong_dof = dof(wrong_body, wrong);
    let of_body = &mut actual[wrong_body];
    let repair = match fault {
        Fault::None => None,
        Fault::Sign => {
            factor = -1.0;
            Some(Repair::Sign(wrong_dof))
        }
        Fault::Gain => {
            factor = gain;
            let (dof, std) = (wrong_dof, 0.0);
            Some(Repair::Gain { dof, gain, std })
        }
        Fault::Axis => {
            let [x, y, z] = of_body[wrong].direction;
            let (dof, direction) = (wrong_dof, [y, z, x]);
            of_body[wrong].direction = direction;
            Some(Repair::Direction { dof, direction })
        }
        Fault::Exchange => {
            of_body.swap(wrong, other);
            let (first, second) = (wrong.min(other), wrong.max(other));
            Some(Repair::Exchanged(
                dof(wrong_body, first),
                dof(wrong_body, second),
            ))
        }
    };
    let noise = 0.003 * (0.02 / 0.003_f64).powf(random.random());
    let (mut modes, mut noise_free) = (Vec::new(), Vec::new());
    for mode in 0..random.random_range(3..=8) {
        let phase = Complex64::from_polar(1.0, random.random_range(-0.3..0.3));
        let mut values: Vec<(Dof, Complex64)> = Vec::new();
        for (body, of_body) in actual.iter().enumerate() {
            for (sensor, placed) in of_body.iter().enumerate() {
                let row = placed.row(&UNSCALED);
                let rigid: f64 = (0..6)
                    .map(|a| row[a] * motions.vectors[(6 * body + a, mode)])
                    .sum();
                let is_bent = body == 0 && bending_from.is_some_and(|first| mode >= first);
                let along = 2.0 * placed.at_m[0] / bodies[body].size_m[0];
                let bent = if is_bent { 0.3 * along * along } else { 0.0 };
                let is_wrong = (body, sensor) == (wrong_body, wrong);
                let factor = if is_wrong { factor } else { 1.0 };
                let bent = bent * motions.vectors[(6 * body + 2, mode)];
                // A damped machine has complex modes: its bodies are not in phase.
                let lag = Complex64::from_polar(1.0, 0.1 * body as f64);
                values.push((dof(body, sensor), phase * lag * factor * (rigid + bent)));
            }
        }
        let largest = values
            .iter()
            .map(|(_, value)| value.norm())
            .fold(0.0, f64::max);
        let std = noise * largest;
        let made = |values: Vec<(Dof, Complex64)>| {
            let stds = values.iter().map(|(dof, _)| (dof.clone(), std)).collect();
            let shape = ModeShape::new(values);
            Mode {
                shape_std: Some(stds),
                ..Mode::new(motions.all_hz[mode], None, shape, Scaling::Unknown)
            }
        };
        noise_free.push(made(values.clone()));
        for (_, value) in &mut values {
            let mut part = || std * random.sample::<f64, _>(StandardNormal);
            *value += Complex64::new(part(), part());
        }
        modes.push(made(values));
    }
    let placed = sensors.iter().enumerate().map(|(body, of_body)| {
        let of_body = of_body.iter().enumerate();
        of_body
            .map(|(sensor, at)| (dof(body, sensor), *at))
            .collect()
    });
    SpringMountedBodies {
        modes,
        noise_free,
        placed: placed.collect(),
        wrong_body,
        repair,
    }
}
