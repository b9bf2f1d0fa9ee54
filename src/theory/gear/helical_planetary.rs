//! The helical planetary gear with its ring fixed: carrier, sun and four planets on bearings, in
//! the plane of rotation.
//!
//! Coordinates of the matrices are absolute: `x`, `y` and the rotation of carrier and sun; of each
//! planet its displacement along and across the radius on which it sits, and its rotation. A mesh
//! is compressed along its line of action, which leaves the base circles at the transverse pressure
//! angle α; a planet's bearing stretches between its pin on the carrier and its centre. With rigid
//! bearings (set `torsional`) rotations alone are left, and the planets' masses go with the
//! carrier. The motion over time, with its changing pressure angles, is that of `helical_motion`.
//!
//! # Reference
//! Zhang Jie, Liao Yinghua, Huang Bo (2013), Dynamic modelling and analysis of a helical planetary
//! gear with varying pressure angle (in Chinese), Journal of Sichuan University of Science and
//! Engineering 26, equations 1 to 28. The print has errors in most of them; what is here is derived
//! again, and its natural frequencies are those of a separate derivation.

use std::f64::consts::TAU;

use crate::theory::dual::{Dual, Values};
use crate::theory::rigid::RigidBodies;
use crate::theory::spring_assembly::{Machine, Stretch, minus};
use crate::theory::{Coordinate, Motion, ParameterSpec};

use super::helical_parameters::{PLANETS, SET_NAMES, parameters};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const CENTRE: [Dual; 3] = [Dual::ZERO; 3];

/// The gear with 18 coordinates, or 6 with rigid bearings.
///
/// Bodies: `carrier` (xc, yc, thc), `sun` (xs, ys, ths), `planet-1` (radial_1, tangential_1, th_1)
/// ... `planet-4`.
#[derive(Clone, Debug)]
pub struct HelicalPlanetary {
    pub(super) name: String,
    pub(super) parameters: Vec<ParameterSpec>,
    torsional: bool,
    pub(super) bodies: RigidBodies,
}

/// Angle at which a planet sits, rad.
pub(super) fn planet_angle(planet: usize) -> f64 {
    TAU * planet as f64 / PLANETS as f64
}

impl HelicalPlanetary {
    /// The model with both bearing stiffnesses of the paper (`kb-1.5e8`, `kb-1e10`) or with rigid
    /// bearings (`torsional`); `None` for another name.
    pub fn new(set: &str) -> Option<Self> {
        SET_NAMES.contains(&set).then(|| {
            let torsional = set == "torsional";
            let parameters = parameters(set);
            Self {
                name: format!("helical planetary gear, {set}"),
                bodies: bodies(&parameters, torsional),
                parameters,
                torsional,
            }
        })
    }

    /// Whether the bearings are rigid.
    pub(super) fn is_torsional(&self) -> bool {
        self.torsional
    }

    pub(super) fn values<'a>(&'a self, values: &'a [f64], by: Option<usize>) -> Values<'a> {
        let specs = &self.parameters;
        Values { specs, values, by }
    }

    fn inertia(&self, values: &Values<'_>) -> Vec<Dual> {
        let carried = PLANETS as f64 * values.get("m_p") * square(radius_of_pins(values));
        let of_coordinate = |coordinate: &Coordinate| {
            let body = coordinate.body.split('-').next().unwrap_or_default();
            let letter = &body[..1];
            match (coordinate.motion, body) {
                (Motion::Rotation, "carrier") if self.torsional => values.get("j_c") + carried,
                (Motion::Rotation, _) => values.get(&format!("j_{letter}")),
                _ => values.get(&format!("m_{letter}")),
            }
        };
        self.bodies.coordinates.iter().map(of_coordinate).collect()
    }

    pub(super) fn machine(&self, values: &Values<'_>) -> Machine {
        let mut all = Machine::new(&self.bodies.coordinates, self.inertia(values));
        if !self.torsional {
            self.add_bearings(values, &mut all);
        }
        let (sin, cos) = values.get("pressure_angle").sin_cos();
        let turn = Z.map(Dual::constant);
        let radius = |name: &str| values.get(name);
        for planet in 0..PLANETS {
            let planet_name = format!("planet-{}", planet + 1);
            let [radial, tangential] = directions(planet);
            // The lines of action: from the sun outwards, and from the ring inwards.
            let along = |sign: f64| -> [Dual; 3] {
                std::array::from_fn(|i| sign * radial[i] * sin + tangential[i] * cos)
            };
            let rolled = |body: &str, radius: Dual| scaled(all.rotation(body, turn), radius);
            let of_planet = rolled(&planet_name, radius("base_radius_p"));
            let of_sun = rolled("sun", radius("base_radius_s"));
            let [sun_mesh, ring_mesh] = if self.torsional {
                // Planets go with their pins, by R_c cos α per unit of the carrier's rotation along
                // both lines.
                let pins = rolled("carrier", radius_of_pins(values) * cos);
                [
                    minus(sum(of_sun, of_planet.clone()), pins.clone()),
                    minus(Stretch::new(), sum(pins, of_planet)),
                ]
            } else {
                let from_sun = minus(
                    all.point("sun", CENTRE, along(1.0)),
                    all.point(&planet_name, CENTRE, along(1.0)),
                );
                let to_ring = minus(Stretch::new(), all.point(&planet_name, CENTRE, along(-1.0)));
                [
                    sum(from_sun, sum(of_sun, of_planet.clone())),
                    minus(to_ring, of_planet),
                ]
            };
            all.add("k_sp", values.get("k_sp"), sun_mesh);
            all.add("k_rp", values.get("k_rp"), ring_mesh);
        }
        all
    }

    fn add_bearings(&self, values: &Values<'_>, all: &mut Machine) {
        for axis in [X, Y].map(|axis| axis.map(Dual::constant)) {
            for (name, body) in [("k_c", "carrier"), ("k_s", "sun")] {
                let stretch = all.point(body, CENTRE, axis);
                all.add(name, values.get(name), stretch);
            }
        }
        let pins = radius_of_pins(values);
        for planet in 0..PLANETS {
            let planet_name = format!("planet-{}", planet + 1);
            let [radial, _] = directions(planet);
            for direction in directions(planet) {
                let pin = all.point("carrier", radial.map(|part| pins * part), direction);
                let stretch = minus(all.point(&planet_name, CENTRE, direction), pin);
                all.add("k_p", values.get("k_p"), stretch);
            }
        }
    }
}

/// Radius of the circle of the pins, where the meshes have no play: the same by sun and ring.
fn radius_of_pins(values: &Values<'_>) -> Dual {
    let cos = values.get("pressure_angle").sin_cos().1;
    (values.get("base_radius_s") + values.get("base_radius_p")) / cos
}

/// Unit vectors along and across the radius of a planet.
fn directions(planet: usize) -> [[Dual; 3]; 2] {
    let (sin, cos) = planet_angle(planet).sin_cos();
    [[cos, sin, 0.0], [-sin, cos, 0.0]].map(|axis| axis.map(Dual::constant))
}

fn square(number: Dual) -> Dual {
    number * number
}

fn scaled(stretch: Stretch, factor: Dual) -> Stretch {
    let all = stretch.into_iter();
    all.map(|(index, part)| (index, part * factor)).collect()
}

fn sum(first: Stretch, second: Stretch) -> Stretch {
    first.into_iter().chain(second).collect()
}

fn bodies(parameters: &[ParameterSpec], torsional: bool) -> RigidBodies {
    let nominal: Vec<f64> = parameters.iter().map(|spec| spec.nominal).collect();
    let values = Values {
        specs: parameters,
        values: &nominal,
        by: None,
    };
    let pins = radius_of_pins(&values).value;
    let mut all = RigidBodies::default();
    let mut add = |body: String, at_m: [f64; 3], moves: [(String, [f64; 3]); 2], turns: String| {
        let moves = moves.into_iter().filter(|_| !torsional);
        let moves = moves.map(|(name, axis)| (name, Motion::Translation, axis));
        all.add(body, at_m, moves.chain([(turns, Motion::Rotation, Z)]));
    };
    for (body, letter) in [("carrier", "c"), ("sun", "s")] {
        let moves = [(format!("x{letter}"), X), (format!("y{letter}"), Y)];
        add(body.to_owned(), [0.0; 3], moves, format!("th{letter}"));
    }
    for planet in 0..PLANETS {
        let n = planet + 1;
        let [radial, tangential] = directions(planet).map(|axis| axis.map(|part| part.value));
        let moves = [
            (format!("radial_{n}"), radial),
            (format!("tangential_{n}"), tangential),
        ];
        let at_m = radial.map(|part| pins * part);
        add(format!("planet-{n}"), at_m, moves, format!("th_{n}"));
    }
    all
}
