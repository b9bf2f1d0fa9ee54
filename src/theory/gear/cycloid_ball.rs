//! The cycloid ball planetary transmission: input shaft, centre disc, reduction balls, planet disc,
//! pin balls, output.
//!
//! Everything lies in one plane. Input shaft and centre disc have their centre at O1 = (0, 0), the
//! planet disc at O3 = (0, 2e), the output at O1. A reduction ball touches both discs along a
//! common normal that passes through the pitch point P = (0, -(Z2 - 1) e); it sits on a circle of
//! radius Z2 r0 about (0, e), r0 = e/K the rolling circle. Each ball's four contacts are springs
//! along the normal; only their part in the plane counts, hence cos²β. The pin balls between planet
//! disc and output move along y.
//!
//! The quirks of the paper are kept, because its table 2 has them: the contact force acts on the
//! centre disc with the arm Z3 e of the planet disc ((Z2 - 1) e would be right; at most 0.21 % in a
//! frequency), and the y coordinate of a pin ball is its only one.
//!
//! # Reference
//! Yang, An and Duan (2016), Analysis of free vibration of cycloid ball planetary transmission,
//! China Mechanical Engineering 27(14), 1883, equations 1 to 8; the geometry is not printed there
//! and follows from the pitch point.

use std::f64::consts::TAU;

use crate::theory::dual::{Dual, Values};
use crate::theory::parameter::nominal_values;
use crate::theory::rigid::RigidBodies;
use crate::theory::spring_assembly::{Machine, minus};
use crate::theory::{Coordinate, Motion, ParameterSpec};

use super::cycloid_ball_parameters::{SET_NAMES, parameters};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
/// The arm of a body's centre.
const CENTRE: [Dual; 3] = [Dual::ZERO; 3];

/// The parameter with the number of reduction balls Z2.
pub(super) const BALLS: &str = "ball_count";
/// Number of pin balls Z4.
pub(super) const PIN_BALLS: usize = 6;

/// The transmission with `11 + 2 Z2 + Z4` coordinates: 37 with the 10 reduction balls
/// (`ball_count`) and 6 pin balls that were tested.
///
/// Bodies: `input` (x0, y0, u0), `centre-disc` (x1, y1, u1), `ball-1` ... (x2_1, y2_1, ...),
/// `planet-disc` (x3, y3, u3), `pin-ball-1` ... (y4_1, ...), `output` (y5, u5). Positions of
/// sensors refer to the nominal geometry.
#[derive(Clone, Debug)]
pub struct CycloidBall {
    pub(super) name: String,
    pub(super) parameters: Vec<ParameterSpec>,
}

impl CycloidBall {
    /// The model with a parameter set: `B` (the physical reference), `A` (as printed), `C` or `D`
    /// (fitted); `None` for another name.
    pub fn new(set: &str) -> Option<Self> {
        SET_NAMES.contains(&set).then(|| Self {
            name: format!("cycloid ball transmission, set {set}"),
            parameters: parameters(set),
        })
    }

    pub(super) fn values<'a>(&'a self, values: &'a [f64], by: Option<usize>) -> Values<'a> {
        let specs = &self.parameters;
        Values { specs, values, by }
    }

    /// Angle of ball i (from 0) on its circle, and the sine and cosine of its normal Φ3.
    fn ball(&self, values: &Values<'_>, i: usize) -> (Dual, [Dual; 2]) {
        let turn = Dual::constant(TAU * i as f64 / values.get(BALLS).value);
        let theta = values.get("ball_phase") + turn;
        let (sin, cos) = theta.sin_cos();
        let cos = cos + values.get("trochoid_ratio");
        let length = (sin * sin + cos * cos).sqrt();
        (theta, [sin / length, cos / length])
    }

    /// The bodies of the machine with so many reduction balls at its nominal geometry.
    pub(super) fn bodies(&self, balls: f64) -> RigidBodies {
        let mut values = nominal_values(&self.parameters);
        let counts = self.parameters.iter().zip(&mut values);
        counts
            .filter(|(spec, _)| spec.name == BALLS)
            .for_each(|(_, value)| *value = balls);
        let values = &self.values(&values, None);
        let e = values.get("half_eccentricity").value;
        let radius = balls * e / values.get("trochoid_ratio").value;
        let mut all = RigidBodies::default();
        let [input, disc, planet, output] =
            ["input", "centre-disc", "planet-disc", "output"].map(str::to_owned);
        all.add(input, [0.0; 3], free([("x0", X), ("y0", Y), ("u0", Z)]));
        all.add(disc, [0.0; 3], free([("x1", X), ("y1", Y), ("u1", Z)]));
        for i in 0..balls as usize {
            let theta = self.ball(values, i).0.value;
            let at_m = [-radius * theta.sin(), e + radius * theta.cos(), 0.0];
            let n = i + 1;
            let names = [format!("x2_{n}"), format!("y2_{n}")];
            let moves = free([(&names[0], X), (&names[1], Y)]);
            all.add(format!("ball-{n}"), at_m, moves);
        }
        let at_m = [0.0, 2.0 * e, 0.0];
        all.add(planet, at_m, free([("x3", X), ("y3", Y), ("u3", Z)]));
        for j in 0..PIN_BALLS {
            let [x, y] = self.pin(values, j).map(|part| part.value);
            // Half way between its grooves in the planet disc and in the output.
            let (at_m, name) = ([x, y + e, 0.0], format!("y4_{}", j + 1));
            all.add(format!("pin-ball-{}", j + 1), at_m, free([(&name, Y)]));
        }
        all.add(output, [0.0; 3], free([("y5", Y), ("u5", Z)]));
        all
    }

    /// Position of pin ball j (from 0) on its circle: the angle φ counts from y.
    fn pin(&self, values: &Values<'_>, j: usize) -> [Dual; 2] {
        let turn = Dual::constant(TAU * j as f64 / PIN_BALLS as f64);
        let (sin, cos) = (values.get("pin_phase") + turn).sin_cos();
        let radius = values.get("pin_circle_radius");
        [radius * sin, radius * cos]
    }

    fn inertia(coordinates: &[Coordinate], values: &Values<'_>) -> Vec<Dual> {
        let of_coordinate = |coordinate: &Coordinate| {
            let (letter, part) = coordinate.name.split_at(1);
            let part = &part[..1];
            match letter {
                "u" => values.get(&format!("j_{part}")),
                _ => values.get(&format!("m_{part}")),
            }
        };
        coordinates.iter().map(of_coordinate).collect()
    }

    pub(super) fn machine(&self, values: &Values<'_>) -> Machine {
        let coordinates = self.bodies(values.get(BALLS).value).coordinates;
        let mut all = Machine::new(&coordinates, Self::inertia(&coordinates, values));
        let shift = [
            Dual::ZERO,
            2.0 * values.get("half_eccentricity"),
            Dual::ZERO,
        ];
        for (axis, [k_01, k_03, k_1]) in [
            (X, ["k_01x", "k_03x", "k_1x"]),
            (Y, ["k_01y", "k_03y", "k_1y"]),
        ] {
            let axis = axis.map(Dual::constant);
            let centre = |body: &str, machine: &Machine| machine.point(body, CENTRE, axis);
            let (disc, planet) = (centre("centre-disc", &all), centre("planet-disc", &all));
            let input = all.point("input", shift, axis);
            let held = minus(disc.clone(), centre("input", &all));
            all.add(k_01, values.get(k_01), held);
            all.add(k_03, values.get(k_03), minus(planet, input));
            all.add(k_1, values.get(k_1), disc);
        }
        let output = all.point("output", CENTRE, Y.map(Dual::constant));
        all.add("k_5y", values.get("k_5y"), output);
        let twist = all.rotation("centre-disc", Z.map(Dual::constant));
        all.add("k_1u", values.get("k_1u"), twist);
        self.add_balls(values, &mut all);
        self.add_pin_balls(values, &mut all);
        all
    }

    /// The contacts A, B with the planet disc and C, D with the centre disc. They act along the
    /// normal through the pitch point, so that its foot there gives the arm Z3 e sin Φ3.
    fn add_balls(&self, values: &Values<'_>, all: &mut Machine) {
        let balls = values.get(BALLS).value;
        let arm = (balls + 1.0) * values.get("half_eccentricity");
        let arm = [Dual::ZERO, -arm, Dual::ZERO];
        let cos2 = values.get("cos2_beta");
        for i in 0..balls as usize {
            let (_, [sin, cos]) = self.ball(values, i);
            let normal = [sin, -cos, Dual::ZERO];
            let ball = all.point(&format!("ball-{}", i + 1), CENTRE, normal);
            for (contact, disc) in [
                ("k_a", "planet-disc"),
                ("k_b", "planet-disc"),
                ("k_c", "centre-disc"),
                ("k_d", "centre-disc"),
            ] {
                let stretch = minus(ball.clone(), all.point(disc, arm, normal));
                all.add(contact, cos2 * values.get(contact), stretch);
            }
        }
    }

    /// The contacts A, B with the planet disc and C, D with the output, along y.
    fn add_pin_balls(&self, values: &Values<'_>, all: &mut Machine) {
        let y = Y.map(Dual::constant);
        for j in 0..PIN_BALLS {
            let [to_x, to_y] = self.pin(values, j);
            let ball = all.point(&format!("pin-ball-{}", j + 1), CENTRE, y);
            for (contact, cos2, disc) in [
                ("k_da", "cos2_beta_1", "planet-disc"),
                ("k_db", "cos2_beta_2", "planet-disc"),
                ("k_dd", "cos2_beta_1", "output"),
                ("k_dc", "cos2_beta_2", "output"),
            ] {
                let groove = all.point(disc, [to_x, to_y, Dual::ZERO], y);
                let stiffness = values.get(cos2) * values.get(contact);
                all.add(contact, stiffness, minus(ball.clone(), groove));
            }
        }
    }
}

/// Freedoms along x and y are displacements, about z a rotation.
fn free<const N: usize>(all: [(&str, [f64; 3]); N]) -> [(String, Motion, [f64; 3]); N] {
    all.map(|(name, axis)| {
        let motion = if axis == Z {
            Motion::Rotation
        } else {
            Motion::Translation
        };
        (name.to_owned(), motion, axis)
    })
}
