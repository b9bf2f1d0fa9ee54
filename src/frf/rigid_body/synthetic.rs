//! Synthetic tests of a body on a soft suspension, with one fault.

use std::collections::BTreeMap;

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::PlacedSensor;
use super::repair::Repair;
use super::rows::Frame;
use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::frf::{FrfSet, Function, FunctionData};
use crate::linalg::{ComplexMatrix, complex_matrix, solve_square};
use crate::quantity::FrfKind;

/// Noise and damping of the tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Family {
    /// Noise of a line over the root mean square of the mass lines.
    pub noise: f64,
    /// Loss factor of the suspension.
    pub suspension_loss: f64,
    /// Damping ratio of the elastic modes.
    pub elastic_damping: f64,
}

impl Family {
    /// One percent of noise, and damping as of slings and of steel with joints.
    pub const CUSTOMARY: Self = Self {
        noise: 0.01,
        suspension_loss: 0.05,
        elastic_damping: 0.01,
    };

    /// Noise from 0.3 to 3 %, loss factors from 0.02 to 0.15, damping ratios from 0.2 to 2 %.
    pub fn drawn(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut between = |lowest: f64, highest: f64| {
            let exponent: f64 = random.random();
            lowest * (highest / lowest).powf(exponent)
        };
        Self {
            noise: between(0.003, 0.03),
            suspension_loss: between(0.02, 0.15),
            elastic_damping: between(0.002, 0.02),
        }
    }
}

pub(super) const UNSCALED: Frame = Frame {
    origin_m: [0.0; 3],
    length_m: 1.0,
};

/// What is wrong with a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fault {
    None,
    Sign,
    Gain,
    Axis,
    Exchange,
}

/// A drawn test.
pub(super) struct SuspendedTest {
    pub set: FrfSet,
    /// The same FRFs and variances without noise.
    pub noise_free: FrfSet,
    /// Mass lines without noise, by response and reference.
    pub exact: BTreeMap<(Dof, Dof), f64>,
    /// As the test's description has them.
    pub placed: BTreeMap<Dof, PlacedSensor>,
    pub mass_kg: f64,
    /// Centre of mass.
    pub centre_m: [f64; 3],
    /// What mends it.
    pub repair: Option<Repair>,
}

/// Everything that is drawn of a body.
pub(super) struct Body {
    mass_kg: f64,
    pub size_m: [f64; 3],
    /// Inertia about the origin, kg, kg m and kg m².
    pub inertia: [[f64; 6]; 6],
    stiffness: [[f64; 6]; 6],
    /// Natural frequency in rad/s and coefficients of the shape.
    elastic: Vec<(f64, [f64; 12])>,
}

impl Body {
    pub fn new(random: &mut ChaCha8Rng) -> Self {
        let mass_kg = random.random_range(5.0..100.0);
        let size_m: [f64; 3] = std::array::from_fn(|_| random.random_range(0.3..0.9));
        let centre: [f64; 3] =
            std::array::from_fn(|axis| size_m[axis] * random.random_range(-0.1..0.1));
        let mut inertia = [[0.0; 6]; 6];
        // A box and a few masses on it.
        let masses: Vec<([f64; 3], f64)> = (0..8)
            .map(|corner| {
                let side = |axis: usize| if corner >> axis & 1 == 1 { 0.35 } else { -0.35 };
                let at = std::array::from_fn(|axis| centre[axis] + size_m[axis] * side(axis));
                (at, mass_kg / 8.0)
            })
            .collect();
        for (at_m, mass) in &masses {
            for axis in 0..3 {
                let mut direction = [0.0; 3];
                direction[axis] = 1.0;
                let row = PlacedSensor {
                    at_m: *at_m,
                    direction,
                }
                .row(&UNSCALED);
                add_square(&mut inertia, &row, *mass);
            }
        }
        let mut stiffness = [[0.0; 6]; 6];
        let vertical =
            mass_kg / 4.0 * (std::f64::consts::TAU * random.random_range(1.5..3.0)).powi(2);
        for corner in 0..4 {
            let side = |axis: usize| if corner >> axis & 1 == 1 { 0.5 } else { -0.5 };
            let at_m = [size_m[0] * side(0), size_m[1] * side(1), 0.5 * size_m[2]];
            for axis in 0..3 {
                let mut direction = [0.0; 3];
                direction[axis] = 1.0;
                let row = PlacedSensor { at_m, direction }.row(&UNSCALED);
                let part = if axis == 2 { 1.0 } else { 0.3 };
                add_square(&mut stiffness, &row, part * vertical);
            }
        }
        let first = random.random_range(90.0..150.0);
        let elastic = (0..6)
            .map(|mode| {
                let hz = first * (1.0 + 0.6 * f64::from(mode) + random.random_range(0.0..0.3));
                let shape = std::array::from_fn(|_| random.sample(StandardNormal));
                (std::f64::consts::TAU * hz, shape)
            })
            .collect();
        Self {
            mass_kg,
            size_m,
            inertia,
            stiffness,
            elastic,
        }
    }

    /// First moments over the mass; the moment about z drives along y by x, and so on.
    fn centre_m(&self) -> [f64; 3] {
        let moment = |force: usize, about: usize| self.inertia[force][3 + about] / self.mass_kg;
        [moment(1, 2), moment(2, 0), moment(0, 1)]
    }

    /// A random point of the surface, along a random axis.
    pub fn sensor(&self, random: &mut ChaCha8Rng) -> PlacedSensor {
        let mut at_m: [f64; 3] =
            std::array::from_fn(|axis| self.size_m[axis] * random.random_range(-0.5..0.5));
        let face = random.random_range(0..3);
        at_m[face] = self.size_m[face] * if random.random() { 0.5 } else { -0.5 };
        let mut direction = [0.0; 3];
        direction[random.random_range(0..3)] = if random.random() { 1.0 } else { -1.0 };
        PlacedSensor { at_m, direction }
    }

    /// Component of an elastic shape, its root mean square one over the root of the mass.
    fn component(&self, shape: &[f64; 12], sensor: &PlacedSensor) -> f64 {
        let along = |axis: usize| {
            let c = &shape[4 * axis..];
            let [x, y, z] = std::array::from_fn(|i| 2.0 * sensor.at_m[i] / self.size_m[i]);
            c[0] * x * y + c[1] * y * z + c[2] * x * x + c[3] * z * z
        };
        let sum: f64 = (0..3)
            .map(|axis| sensor.direction[axis] * along(axis))
            .sum();
        sum / self.mass_kg.sqrt()
    }

    /// The motion of the body by a hit, divided by -ω²: receptances.
    fn receptances(&self, omega: f64, loss: f64, hits: &[PlacedSensor]) -> ComplexMatrix {
        let dynamic = complex_matrix(6, 6, |a, b| {
            Complex64::new(1.0, loss) * self.stiffness[a][b] - omega * omega * self.inertia[a][b]
        });
        let force = complex_matrix(6, hits.len(), |a, hit| hits[hit].row(&UNSCALED)[a].into());
        solve_square(&dynamic, &force).expect("a body on springs")
    }
}

fn add_square(matrix: &mut [[f64; 6]; 6], row: &[f64; 6], factor: f64) {
    for (a, line) in matrix.iter_mut().enumerate() {
        for (b, value) in line.iter_mut().enumerate() {
            *value += factor * row[a] * row[b];
        }
    }
}

/// A test of this family with 8 to 40 sensors and this fault.
pub(super) fn suspended_test(seed: u64, fault: Fault, family: &Family) -> SuspendedTest {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let body = Body::new(&mut random);
    let count = random.random_range(8..=40);
    let hits: Vec<PlacedSensor> = (0..random.random_range(1..=4))
        .map(|_| body.sensor(&mut random))
        .collect();
    let sensors: Vec<PlacedSensor> = (0..count).map(|_| body.sensor(&mut random)).collect();
    let dof = |number: usize| -> Dof { format!("{number}:+Z").parse().expect("a DOF") };
    let sensor_dof = |sensor: usize| dof(100 + sensor);
    let (wrong, other) = (
        random.random_range(0..count),
        random.random_range(0..count - 1),
    );
    let other = if other >= wrong { other + 1 } else { other };
    let gain = match random.random() {
        true => random.random_range(1.03..1.3),
        false => random.random_range(0.7..0.97),
    };
    let mut actual = sensors.clone();
    let mut repair = None;
    let mut factor = vec![1.0; count];
    let wrong_dof = sensor_dof(wrong);
    match fault {
        Fault::None => {}
        Fault::Sign => {
            factor[wrong] = -1.0;
            repair = Some(Repair::Sign(wrong_dof));
        }
        Fault::Gain => {
            factor[wrong] = gain;
            repair = Some(Repair::Gain {
                dof: wrong_dof,
                gain,
                std: 0.0,
            });
        }
        Fault::Axis => {
            let [x, y, z] = sensors[wrong].direction;
            actual[wrong].direction = [y, z, x];
            repair = Some(Repair::Direction {
                dof: wrong_dof,
                direction: [y, z, x],
            });
        }
        Fault::Exchange => {
            actual.swap(wrong, other);
            let (first, second) = (wrong.min(other), wrong.max(other));
            repair = Some(Repair::Exchanged(sensor_dof(first), sensor_dof(second)));
        }
    }
    let axis = FrequencyAxis {
        start_hz: 0.5,
        step_hz: 0.5,
        len: 420,
    };
    let mut values = vec![Vec::with_capacity(axis.len); count * hits.len()];
    for k in 0..axis.len {
        let omega = axis.rad_s(k);
        let motions = body.receptances(omega, family.suspension_loss, &hits);
        for (sensor, placed) in actual.iter().enumerate() {
            let row = placed.row(&UNSCALED);
            for (hit, at) in hits.iter().enumerate() {
                let rigid: Complex64 = (0..6).map(|a| row[a] * motions[(a, hit)]).sum();
                let modes = body.elastic.iter().map(|(natural, shape)| {
                    let product = body.component(shape, placed) * body.component(shape, at);
                    let stiff = natural * natural - omega * omega;
                    product / Complex64::new(stiff, 2.0 * family.elastic_damping * natural * omega)
                });
                let receptance = rigid + modes.sum::<Complex64>();
                let value = -omega * omega * factor[sensor] * receptance;
                values[sensor * hits.len() + hit].push(value);
            }
        }
    }
    let mut exact = BTreeMap::new();
    let mut placed = BTreeMap::new();
    let free = Body {
        stiffness: [[0.0; 6]; 6],
        ..Body::new(&mut ChaCha8Rng::seed_from_u64(seed))
    };
    let rigid = free.receptances(1.0, 0.0, &hits);
    for (hit, at) in hits.iter().enumerate() {
        placed.insert(dof(1 + hit), *at);
        for (sensor, actual) in actual.iter().enumerate() {
            let row = actual.row(&UNSCALED);
            let value: f64 = (0..6).map(|a| -row[a] * rigid[(a, hit)].re).sum();
            exact.insert((sensor_dof(sensor), dof(1 + hit)), factor[sensor] * value);
        }
    }
    placed.extend(
        sensors
            .iter()
            .enumerate()
            .map(|(sensor, at)| (sensor_dof(sensor), *at)),
    );
    let rms = (exact.values().map(|v| v * v).sum::<f64>() / exact.len() as f64).sqrt();
    let (mut set, mut noise_free) = (FrfSet::new(axis), FrfSet::new(axis));
    for sensor in 0..count {
        for hit in 0..hits.len() {
            let clean = &values[sensor * hits.len() + hit];
            let noise = clean.iter().map(|value| {
                let mut part = || family.noise * rms * random.sample::<f64, _>(StandardNormal);
                value + Complex64::new(part(), part())
            });
            let function = Function {
                response: sensor_dof(sensor),
                reference: dof(1 + hit),
                kind: FrfKind::Accelerance,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let data = |values: Vec<Complex64>| FunctionData {
                values,
                coherence: None,
                variance: Some(vec![2.0 * (family.noise * rms).powi(2); axis.len]),
            };
            let noisy = data(noise.collect());
            set.push(function.clone(), noisy).expect("each pair once");
            let clean = data(clean.clone());
            noise_free.push(function, clean).expect("each pair once");
        }
    }
    SuspendedTest {
        set,
        noise_free,
        exact,
        placed,
        mass_kg: body.mass_kg,
        centre_m: body.centre_m(),
        repair,
    }
}
