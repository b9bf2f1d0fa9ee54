//! Beams and plates of steel: by finite elements with any ends, and in closed form.

use std::f64::consts::PI;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use modalign::dof::Dof;
use modalign::geometry::{Sensor, Target};
use modalign::theory::{
    BeamDescription, BeamFile, BeamModel, End, ModeOptions, ParameterStatus, SCHEMA, TheoryModes,
    Value, modes,
};

use super::error::PopulationError;
use super::span::{Ends, KeyedSpan, MAX_COUNT, Span};
use super::structure::{DrawnMode, MAX_MODES, Structure, damped, elastic};

const YOUNGS_MODULUS_PA: f64 = 2.1e11;
const DENSITY_KG_PER_M3: f64 = 7850.0;
const POISSONS_RATIO: f64 = 0.3;
const WIDTH_M: f64 = 0.04;
/// Elements of a beam: the twelfth elastic mode is then within 1e-3 of the continuous beam.
const ELEMENTS: usize = 32;
/// Points where a beam or a plate may be hit or measured.
const POINTS: usize = 30;
/// Half-waves of a plate in each direction that are looked at: enough for the lowest [`MAX_MODES`]
/// up to an aspect of 2.
const HALF_WAVES: usize = 9;

/// `kind = "beam"`: a uniform steel beam.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamSpec {
    /// Length, m, uniform.
    pub length_m: Span,
    /// Thickness in the direction of bending, m, log-uniform.
    pub thickness_m: Span,
    /// How the start may be held, each with the same probability.
    pub starts: Vec<End>,
    /// How the end may be held.
    pub ends: Vec<End>,
    /// Damping ratio of each root, log-uniform.
    pub damping_ratio: Span,
}

/// `kind = "nodes"`: a steel beam on two supports with a reference exactly on a node of one of its
/// modes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodesSpec {
    /// Length, m, uniform.
    pub length_m: Span,
    /// Thickness in the direction of bending, m, log-uniform.
    pub thickness_m: Span,
    /// Number of the mode that has the node, from 2.
    pub mode: Span,
    /// Damping ratio of each root, log-uniform.
    pub damping_ratio: Span,
}

/// `kind = "plate"`: a rectangular steel plate, simply supported on all edges.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlateSpec {
    /// Shorter side, m, uniform.
    pub length_m: Span,
    /// Thickness, m, log-uniform.
    pub thickness_m: Span,
    /// Longer side over the shorter one of a plate that is not square, 1 to 2, uniform.
    pub aspect: Span,
    /// Probability of a square plate, whose modes (m, n) and (n, m) are repeated roots.
    pub square_probability: f64,
    /// Damping ratio of each root, log-uniform.
    pub damping_ratio: Span,
}

impl BeamSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        let choices = |list: &[End]| Span::from([list.len() as f64; 2]);
        vec![
            ("length_m", self.length_m, Ends::Positive),
            ("thickness_m", self.thickness_m, Ends::Positive),
            ("damping_ratio", self.damping_ratio, Ends::Share),
            (
                "starts (their number)",
                choices(&self.starts),
                Ends::Whole(1, MAX_COUNT),
            ),
            (
                "ends (their number)",
                choices(&self.ends),
                Ends::Whole(1, MAX_COUNT),
            ),
        ]
    }

    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let length_m = self.length_m.uniform(random);
        let thickness_m = self.thickness_m.log_uniform(random);
        let held = [&self.starts, &self.ends].map(|list| list[random.random_range(0..list.len())]);
        let model = BeamModel::new(file(length_m, thickness_m, held))?;
        let sensors: Vec<Sensor> = (0..POINTS)
            .map(|i| {
                let share = (i as f64 + random.random_range(0.2..0.8)) / POINTS as f64;
                sensor(i, share * length_m)
            })
            .collect();
        let options = ModeOptions {
            count: Some(MAX_MODES + 2),
            ..ModeOptions::default()
        };
        let theory = modes(&model, &[], &sensors, &options)?;
        let shape = |j| at_sensors(&theory, j, &sensors);
        Ok(Structure::real(damped(
            &theory,
            self.damping_ratio,
            shape,
            random,
        )))
    }
}

fn file(length_m: f64, thickness_m: f64, [start, end]: [End; 2]) -> BeamFile {
    BeamFile {
        schema: SCHEMA.to_owned(),
        kind: None,
        title: "drawn beam".to_owned(),
        support: None,
        example_values: false,
        parameters: Vec::new(),
        beams: vec![BeamDescription {
            name: "beam".to_owned(),
            from_m: [0.0; 3],
            to_m: [length_m, 0.0, 0.0],
            ends_status: ParameterStatus::Printed,
            deflection: [0.0, 0.0, 1.0],
            elements: ELEMENTS,
            start,
            end,
            youngs_modulus_pa: Value::Number(YOUNGS_MODULUS_PA),
            density_kg_per_m3: Value::Number(DENSITY_KG_PER_M3),
            area_m2: Value::Number(WIDTH_M * thickness_m),
            second_moment_m4: Value::Number(WIDTH_M * thickness_m.powi(3) / 12.0),
        }],
        point_masses: Vec::new(),
        springs: Vec::new(),
        sensors: serde::de::IgnoredAny,
    }
}

fn sensor(i: usize, at_m: f64) -> Sensor {
    Sensor {
        dof: super::plan::dof(i),
        target: Target::BodyPoint {
            body: "beam".to_owned(),
            at_m: [at_m, 0.0, 0.0],
            direction: [0.0, 0.0, 1.0],
        },
    }
}

fn at_sensors(theory: &TheoryModes, j: usize, sensors: &[Sensor]) -> Vec<f64> {
    let shape = &theory.model.modes[j].shape;
    let value = |dof: &Dof| shape.get(dof).map_or(0.0, |value| value.re);
    sensors.iter().map(|sensor| value(&sensor.dof)).collect()
}

/// `sin(pi p / q)`, exactly 0 where it is.
fn sin_pi(p: usize, q: usize) -> f64 {
    if p.is_multiple_of(q) {
        return 0.0;
    }
    (PI * (p % (2 * q)) as f64 / q as f64).sin()
}

impl NodesSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        vec![
            ("length_m", self.length_m, Ends::Positive),
            ("thickness_m", self.thickness_m, Ends::Positive),
            ("mode", self.mode, Ends::Whole(2, MAX_COUNT)),
            ("damping_ratio", self.damping_ratio, Ends::Share),
        ]
    }

    /// `omega_j = (j pi / L)^2 sqrt(E I / (rho A))`, `phi_j = sqrt(2 / (rho A L)) sin(j pi x / L)`;
    /// the points divide the length evenly, so that those of the mode's nodes are among them.
    ///
    /// # Reference
    /// Rao (2011), Mechanical Vibrations, 5th ed., section 8.5 (beam simply supported at both
    /// ends).
    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Structure {
        let length_m = self.length_m.uniform(random);
        let thickness_m = self.thickness_m.log_uniform(random);
        let number = self.mode.whole(random);
        let parts = number * (POINTS / number).max(1);
        let kg_per_m = DENSITY_KG_PER_M3 * WIDTH_M * thickness_m;
        let wave = thickness_m * (YOUNGS_MODULUS_PA / DENSITY_KG_PER_M3 / 12.0).sqrt();
        let scale = (2.0 / (kg_per_m * length_m)).sqrt();
        let mode = |j: usize| {
            let omega = (j as f64 * PI / length_m).powi(2) * wave;
            let shape = (1..parts).map(|p| scale * sin_pi(j * p, parts)).collect();
            let ratio = self.damping_ratio.log_uniform(random);
            elastic(omega / (2.0 * PI), ratio, shape)
        };
        let modes = (1..=MAX_MODES).map(mode).collect();
        let node = random.random_range(1..number) * (parts / number);
        Structure {
            reference: Some(node - 1),
            ..Structure::real(modes)
        }
    }
}

impl PlateSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        let probability = Span::from([self.square_probability; 2]);
        vec![
            ("length_m", self.length_m, Ends::Positive),
            ("thickness_m", self.thickness_m, Ends::Positive),
            ("aspect", self.aspect, Ends::Between(1.0, 2.0)),
            ("square_probability", probability, Ends::Between(0.0, 1.0)),
            ("damping_ratio", self.damping_ratio, Ends::Share),
        ]
    }

    /// `omega_mn = pi^2 ((m/a)^2 + (n/b)^2) sqrt(E h^2 / (12 rho (1 - nu^2)))`,
    /// `phi_mn = 2 / sqrt(rho h a b) sin(m pi x / a) sin(n pi y / b)`.
    ///
    /// # Reference
    /// Leissa (1969), Vibration of Plates, NASA SP-160, section 4.1.
    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Structure {
        let a = self.length_m.uniform(random);
        let h = self.thickness_m.log_uniform(random);
        let aspect = self.aspect.uniform(random);
        let square = random.random_bool(self.square_probability);
        let b = if square { a } else { aspect * a };
        let flexural =
            YOUNGS_MODULUS_PA / (12.0 * DENSITY_KG_PER_M3 * (1.0 - POISSONS_RATIO.powi(2)));
        let points: Vec<[f64; 2]> = (0..POINTS)
            .map(|_| {
                [
                    random.random_range(0.04..0.96),
                    random.random_range(0.04..0.96),
                ]
            })
            .collect();
        let scale = 2.0 / (DENSITY_KG_PER_M3 * h * a * b).sqrt();
        let mode = |m: usize, n: usize| {
            let waves = (m as f64 / a).powi(2) + (n as f64 / b).powi(2);
            let at = |p: &[f64; 2]| (m as f64 * PI * p[0]).sin() * (n as f64 * PI * p[1]).sin();
            let shape = points.iter().map(|p| scale * at(p)).collect();
            elastic(0.5 * PI * waves * h * flexural.sqrt(), 0.0, shape)
        };
        let mut modes: Vec<DrawnMode> = (1..=HALF_WAVES)
            .flat_map(|m| (1..=HALF_WAVES).map(move |n| (m, n)))
            .map(|(m, n)| mode(m, n))
            .collect();
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        modes.truncate(MAX_MODES + 2);
        damp_by_root(&mut modes, self.damping_ratio, random);
        Structure::real(modes)
    }
}

/// Roots nearer than this part of their frequency are the same: rounding of a sum of two squares.
const SAME_ROOT: f64 = 1e-12;

/// Draws one ratio for every root of modes in ascending order, and numbers the repeated ones.
fn damp_by_root(modes: &mut [DrawnMode], damping_ratio: Span, random: &mut ChaCha8Rng) {
    let same = |a: &DrawnMode, b: &DrawnMode| {
        b.frequency_hz - a.frequency_hz <= SAME_ROOT * a.frequency_hz
    };
    for (number, root) in (1..).zip(modes.chunk_by_mut(same)) {
        let ratio = damping_ratio.log_uniform(random);
        let (frequency_hz, repeated) = (root[0].frequency_hz, root.len() > 1);
        for mode in root {
            mode.frequency_hz = frequency_hz;
            mode.damping_ratio = Some(ratio);
            mode.group = repeated.then_some(number);
        }
    }
}
