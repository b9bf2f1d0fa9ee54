//! The cycloid ball planetary transmission: input shaft, centre disc, reduction balls, planet disc, pin balls, output.
//!
//! Everything lies in one plane. Input shaft and centre disc have their centre at O1 = (0, 0), the planet disc at
//! O3 = (0, 2e), the output at O1. A reduction ball touches both discs along a common normal that passes through the pitch
//! point P = (0, -(Z2 - 1) e); it sits on a circle of radius Z2 r0 about (0, e), r0 = e/K the rolling circle. Each
//! ball's four contacts are springs along the normal; only their part in the plane counts, hence cos²β. The pin balls
//! between planet disc and output move along y.
//!
//! The paper's own quirks are kept, because its table 2 has them: the contact force acts on the centre disc with the arm Z3 e
//! of the planet disc ((Z2 - 1) e would be right; at most 0.21 % in a frequency), and the y coordinate of a
//! pin ball is its only one.
//!
//! # Reference
//! Yang, An and Duan (2016), Analysis of free vibration of cycloid ball planetary transmission, China Mechanical
//! Engineering 27(14), 1883, equations 1 to 8; the geometry is not printed there and follows from the pitch point.

use std::f64::consts::TAU;

use crate::geometry::Target;
use crate::theory::parameter::{check_values, nominal_values};
use crate::theory::rigid::{Attachment, RigidBodies, SpringRow};
use crate::theory::{
    Assumption, Coordinate, Motion, ParameterSpec, SystemMatrices, TheoreticalModel, TheoryError,
};

use super::cycloid_ball_parameters::{SET_NAMES, parameters};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// Number of reduction balls Z2 of the machine tested.
const BALLS: usize = 10;
/// Number of pin balls Z4.
const PIN_BALLS: usize = 6;
/// A share of the kinetic energy below which a group of coordinates counts as still: far above rounding.
const STILL: f64 = 1e-12;
/// A share above which one body has the motion for itself.
const ALONE: f64 = 0.99;

/// The transmission with `11 + 2 Z2 + Z4` coordinates: 37 with the 10 reduction balls and 6 pin balls that were tested.
///
/// Bodies: `input` (x0, y0, u0), `centre-disc` (x1, y1, u1), `ball-1` ... (x2_1, y2_1, ...), `planet-disc` (x3, y3, u3),
/// `pin-ball-1` ... (y4_1, ...), `output` (y5, u5). Positions of sensors refer to the nominal geometry.
#[derive(Clone, Debug)]
pub struct CycloidBall {
    name: String,
    parameters: Vec<ParameterSpec>,
    balls: usize,
    /// At the nominal geometry, for sensors.
    bodies: RigidBodies,
}

impl CycloidBall {
    /// The model with a parameter set: `B` (the physical reference), `A` (as printed), `C` or `D` (fitted); `None` for
    /// another name.
    pub fn new(set: &str) -> Option<Self> {
        Self::with_balls(set, BALLS)
    }

    /// The model with another number of reduction balls, Z3 = Z2 + 1 teeth of the planet disc.
    pub(super) fn with_balls(set: &str, balls: usize) -> Option<Self> {
        if !SET_NAMES.contains(&set) {
            return None;
        }
        let mut model = Self {
            name: format!("cycloid ball transmission, set {set}"),
            parameters: parameters(set),
            balls,
            bodies: RigidBodies::default(),
        };
        model.bodies = model.bodies(&nominal_values(&model.parameters));
        Some(model)
    }

    /// The value of a parameter that this file names; not a number, which no matrix passes, for one that is not there.
    fn value(&self, values: &[f64], name: &str) -> f64 {
        let mut named = self.parameters.iter().zip(values);
        named
            .find(|(spec, _)| spec.name == name)
            .map_or(f64::NAN, |(_, value)| *value)
    }

    /// Angle of ball i (from 0) on its circle, and the sine and cosine of its normal Φ3.
    fn ball(&self, values: &[f64], i: usize) -> (f64, [f64; 2]) {
        let theta = self.value(values, "ball_phase") + TAU * i as f64 / self.balls as f64;
        let ratio = self.value(values, "trochoid_ratio");
        let (sin, cos) = theta.sin().atan2(theta.cos() + ratio).sin_cos();
        (theta, [sin, cos])
    }

    fn bodies(&self, values: &[f64]) -> RigidBodies {
        let e = self.value(values, "half_eccentricity");
        let radius = self.balls as f64 * e / self.value(values, "trochoid_ratio");
        let mut all = Builder::default();
        all.body("input", [0.0; 3], &[("x0", X), ("y0", Y), ("u0", Z)]);
        all.body("centre-disc", [0.0; 3], &[("x1", X), ("y1", Y), ("u1", Z)]);
        for i in 0..self.balls {
            let (theta, _) = self.ball(values, i);
            let at_m = [-radius * theta.sin(), e + radius * theta.cos(), 0.0];
            let n = i + 1;
            let names = [format!("x2_{n}"), format!("y2_{n}")];
            all.body(
                &format!("ball-{n}"),
                at_m,
                &[(&names[0], X), (&names[1], Y)],
            );
        }
        let planet = [0.0, 2.0 * e, 0.0];
        all.body("planet-disc", planet, &[("x3", X), ("y3", Y), ("u3", Z)]);
        for j in 0..PIN_BALLS {
            let [x, y] = self.pin(values, j);
            // Half way between its grooves in the planet disc and in the output.
            let (at_m, name) = ([x, y + e, 0.0], format!("y4_{}", j + 1));
            all.body(&format!("pin-ball-{}", j + 1), at_m, &[(&name, Y)]);
        }
        all.body("output", [0.0; 3], &[("y5", Y), ("u5", Z)]);
        all.bodies
    }

    /// Position of pin ball j (from 0) on its circle: the angle φ counts from y.
    fn pin(&self, values: &[f64], j: usize) -> [f64; 2] {
        let phi = self.value(values, "pin_phase") + TAU * j as f64 / PIN_BALLS as f64;
        let radius = self.value(values, "pin_circle_radius");
        [radius * phi.sin(), radius * phi.cos()]
    }

    fn inertia(&self, values: &[f64], coordinates: &[Coordinate]) -> Vec<f64> {
        let of_coordinate = |coordinate: &Coordinate| {
            let (letter, part) = coordinate.name.split_at(1);
            let part = &part[..1];
            match letter {
                "u" => self.value(values, &format!("j_{part}")),
                _ => self.value(values, &format!("m_{part}")),
            }
        };
        coordinates.iter().map(of_coordinate).collect()
    }

    fn springs(&self, values: &[f64], bodies: &RigidBodies) -> Result<Vec<SpringRow>, TheoryError> {
        let value = |name: &str| self.value(values, name);
        let e = value("half_eccentricity");
        let mut all = Springs {
            bodies,
            rows: Vec::new(),
        };
        let (o1, o3) = ([0.0; 3], [0.0, 2.0 * e, 0.0]);
        for (axis, letter) in [(X, "x"), (Y, "y")] {
            let k = |name: &str| value(&format!("{name}{letter}"));
            all.stretch(k("k_01"), (at("centre-disc", o1), at("input", o1)), axis)?;
            all.stretch(k("k_03"), (at("planet-disc", o3), at("input", o3)), axis)?;
            all.stretch(k("k_1"), (GROUND, at("centre-disc", o1)), axis)?;
        }
        all.stretch(value("k_5y"), (GROUND, at("output", o1)), Y)?;
        let twist = bodies.twist_row("k_1u", (GROUND, at("centre-disc", o1)), Z)?;
        all.rows.push(SpringRow {
            row: twist,
            stiffness: value("k_1u"),
        });
        self.add_balls(values, &mut all)?;
        self.add_pin_balls(values, &mut all)?;
        Ok(all.rows)
    }

    /// The contacts A, B with the planet disc and C, D with the centre disc. They act along the normal through the pitch
    /// point, so that its foot there gives the arm Z3 e sin Φ3.
    fn add_balls(&self, values: &[f64], all: &mut Springs<'_>) -> Result<(), TheoryError> {
        let e = self.value(values, "half_eccentricity");
        let arm = (self.balls + 1) as f64 * e;
        let on_planet = at("planet-disc", [0.0, 2.0 * e - arm, 0.0]);
        let on_centre = at("centre-disc", [0.0, -arm, 0.0]);
        let cos2 = self.value(values, "cos2_beta");
        for i in 0..self.balls {
            let (_, [sin, cos]) = self.ball(values, i);
            let name = format!("ball-{}", i + 1);
            let ball = at(&name, [0.0; 3]);
            for (contact, disc) in [
                ("k_a", on_planet),
                ("k_b", on_planet),
                ("k_c", on_centre),
                ("k_d", on_centre),
            ] {
                let k = cos2 * self.value(values, contact);
                all.stretch(k, (ball, disc), [sin, -cos, 0.0])?;
            }
        }
        Ok(())
    }

    /// The contacts A, B with the planet disc and C, D with the output, along y.
    fn add_pin_balls(&self, values: &[f64], all: &mut Springs<'_>) -> Result<(), TheoryError> {
        let e = self.value(values, "half_eccentricity");
        let cos2_1 = self.value(values, "cos2_beta_1");
        let cos2_2 = self.value(values, "cos2_beta_2");
        for j in 0..PIN_BALLS {
            let [x, y] = self.pin(values, j);
            let name = format!("pin-ball-{}", j + 1);
            let ball = at(&name, [0.0; 3]);
            let on_planet = at("planet-disc", [x, y + 2.0 * e, 0.0]);
            let on_output = at("output", [x, y, 0.0]);
            for (contact, cos2, disc) in [
                ("k_da", cos2_1, on_planet),
                ("k_db", cos2_2, on_planet),
                ("k_dd", cos2_1, on_output),
                ("k_dc", cos2_2, on_output),
            ] {
                all.stretch(cos2 * self.value(values, contact), (ball, disc), Y)?;
            }
        }
        Ok(())
    }
}

impl TheoreticalModel for CycloidBall {
    fn name(&self) -> &str {
        &self.name
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        check_values(&self.name, &self.parameters, values)?;
        let bodies = self.bodies(values);
        let springs = self.springs(values, &bodies)?;
        let inertia = self.inertia(values, &bodies.coordinates);
        Ok(bodies.matrices(&inertia, &springs))
    }

    fn observation_row(&self, target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.bodies.observation_row(target)
    }

    fn mode_class(&self, omega_rad_s: f64, shares: &[f64]) -> Option<&'static str> {
        let share = |of: &dyn Fn(&Coordinate) -> bool| -> f64 {
            let all = self.bodies.coordinates.iter().zip(shares);
            all.filter(|(coordinate, _)| of(coordinate))
                .map(|(_, share)| share)
                .sum()
        };
        let on = |body: &'static str| move |c: &Coordinate| c.body.starts_with(body);
        let along = |name: &'static str| move |c: &Coordinate| c.name == name;
        if omega_rad_s <= 0.0 {
            return Some("free motion");
        }
        if share(&on("ball-")) > 1.0 - STILL {
            return Some("output still: reduction balls");
        }
        if share(&on("pin-ball-")) > 1.0 - STILL {
            return Some("output still: pin balls");
        }
        if share(&along("u1")) > ALONE {
            return Some("x and torsion, output nearly still: centre disc turns");
        }
        let turning = share(&|c: &Coordinate| c.motion == Motion::Rotation);
        Some(match (share(&along("y5")) > STILL, turning > STILL) {
            (true, false) => "translation in y, nothing turns",
            (false, true) => "x and torsion, output turns",
            _ => "coupled",
        })
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "plane motion, rigid bodies on massless springs, no gyroscopic terms, no damping",
            "geometry inferred from the pitch point, ball circle of radius Z2 e/K; the paper does not print it",
            "the contact force's arm on the centre disc is that of the planet disc, as in the paper ((Z2 - 1) e would be right)",
        ];
        let assumption = |statement| Assumption {
            about: self.name.clone(),
            statement,
        };
        statements.into_iter().map(assumption).collect()
    }
}

const GROUND: Attachment<'static> = Attachment {
    body: None,
    at_m: [0.0; 3],
};

fn at(body: &str, at_m: [f64; 3]) -> Attachment<'_> {
    Attachment {
        body: Some(body),
        at_m,
    }
}

/// Bodies as they are added, in the order of the paper's vector of coordinates.
#[derive(Default)]
struct Builder {
    bodies: RigidBodies,
}

impl Builder {
    /// Freedoms along x and y are displacements, about z a rotation.
    fn body(&mut self, name: &str, at_m: [f64; 3], free: &[(&str, [f64; 3])]) {
        self.bodies.names.push(name.to_owned());
        let coordinate = |(coordinate, axis): &(&str, [f64; 3])| Coordinate {
            name: (*coordinate).to_owned(),
            body: name.to_owned(),
            motion: if *axis == Z {
                Motion::Rotation
            } else {
                Motion::Translation
            },
            axis: *axis,
            at_m,
        };
        let coordinates = free.iter().map(coordinate);
        self.bodies.coordinates.extend(coordinates);
    }
}

/// Springs as they are added.
struct Springs<'a> {
    bodies: &'a RigidBodies,
    rows: Vec<SpringRow>,
}

impl Springs<'_> {
    fn stretch(
        &mut self,
        stiffness: f64,
        ends: (Attachment<'_>, Attachment<'_>),
        direction: [f64; 3],
    ) -> Result<(), TheoryError> {
        let row = self.bodies.stretch_row("spring", ends, direction)?;
        self.rows.push(SpringRow { row, stiffness });
        Ok(())
    }
}
