//! The spider reducer HJW-18B: an input shaft whose two eccentrics, half a turn apart, drive two
//! spider gears, which four spider shafts keep from turning; the gears mesh inside the ring gear of
//! the output shaft.
//!
//! All bodies are rigid. z runs along the input shaft towards the input end; `i` counts the phases
//! (spider gears), `j` the spider shafts. Bearings are two equal springs along x and y: the output
//! and spider shafts and one end of the input shaft on the housing, the other end of the input
//! shaft inside the output shaft (`k_i2`), the input shaft in each gear (`k_a`), every spider
//! shaft's eccentric in each gear (`k_p1`, `k_p2`). A mesh is a spring along the line of action
//! `(cos psi_i, sin psi_i)`, `psi_i = pi/2 - alpha + phi_i`, between gear and ring, which touches
//! both base circles.
//!
//! The rotation of the input shaft is held, as in the paper, so that there is no rigid-body mode.
//!
//! # Reference
//! Zhang, Guo and Xie (2015), Elastodynamic modelling and modal analysis of the spider reducer with
//! small tooth number difference (in Chinese), Journal of Vibration and Shock,
//! doi:10.13465/j.cnki.jvs.2015.12.029, equations 1 to 9. Its tables and figures are lost; of its
//! results only 66.2 Hz, 272.6 Hz and an error of 17 % stand in the text.

use std::f64::consts::{PI, TAU};

use crate::theory::dual::{Dual, Values};
use crate::theory::parameter::nominal_values;
use crate::theory::rigid::RigidBodies;
use crate::theory::spring_assembly::{Machine, Stretch, minus};
use crate::theory::{Coordinate, Motion, ParameterSpec};

use super::spider_reducer_parameters::parameters;

/// Number of spider shafts of the machine.
const SHAFTS: usize = 4;

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// The reducer with `15 + 5 m` coordinates: 35 with its 4 spider shafts.
///
/// Bodies: `output` (xo, yo, box, boy, boz), `input` (xi, yi, bix, biy), `shaft-1` ... (xs1, ys1,
/// bsx1, bsy1, bsz1), `gear-1` and `gear-2` (xp1, yp1, theta1). Positions of sensors refer to the
/// nominal geometry, the centre of mass of the output at the origin.
#[derive(Clone, Debug)]
pub struct SpiderReducer {
    pub(super) parameters: Vec<ParameterSpec>,
    shafts: usize,
    pub(super) bodies: RigidBodies,
}

impl SpiderReducer {
    /// The machine of the paper; `None` for another set than `paper`.
    pub fn new(set: &str) -> Option<Self> {
        (set == "paper").then(|| Self::with_shafts(SHAFTS))
    }

    /// The machine with another number of spider shafts.
    pub(super) fn with_shafts(shafts: usize) -> Self {
        let mut model = Self {
            parameters: parameters(),
            shafts,
            bodies: RigidBodies::default(),
        };
        model.bodies = model.bodies();
        model
    }

    fn bodies(&self) -> RigidBodies {
        let values = nominal_values(&self.parameters);
        let values = self.values(&values, None);
        let get = |name: &str| values.get(name).value;
        let mut all = RigidBodies::default();
        let shaft = |name: &str, j: &str| {
            let free = |start: String, motion, axis| (start, motion, axis);
            [
                free(format!("x{name}{j}"), Motion::Translation, X),
                free(format!("y{name}{j}"), Motion::Translation, Y),
                free(format!("b{name}x{j}"), Motion::Rotation, X),
                free(format!("b{name}y{j}"), Motion::Rotation, Y),
                free(format!("b{name}z{j}"), Motion::Rotation, Z),
            ]
        };
        all.add("output".to_owned(), [0.0; 3], shaft("o", ""));
        let input = [0.0, 0.0, get("z_o3") - get("a_2")];
        let held = shaft("i", "").into_iter().take(4);
        all.add("input".to_owned(), input, held);
        for j in 0..self.shafts {
            let [x, y] = self.hole(&values, j).map(|part| part.value);
            let at_m = [x, y, get("z_o4") - get("b_3")];
            let number = (j + 1).to_string();
            all.add(format!("shaft-{number}"), at_m, shaft("s", &number));
        }
        for (i, station) in [(1, "z_o4"), (2, "z_o5")] {
            let [x, y] = self.crank(&values, i).map(|part| part.value);
            let free = [
                (format!("xp{i}"), Motion::Translation, X),
                (format!("yp{i}"), Motion::Translation, Y),
                (format!("theta{i}"), Motion::Rotation, Z),
            ];
            all.add(format!("gear-{i}"), [x, y, get(station)], free);
        }
        all
    }

    /// Centre of the hole for a spider shaft (from 0), seen from the centre of a gear; also the
    /// place of the shaft.
    fn hole(&self, values: &Values<'_>, j: usize) -> [Dual; 2] {
        let (sin, cos) = (TAU * j as f64 / self.shafts as f64).sin_cos();
        let radius = values.get("hole_radius");
        [cos * radius, sin * radius]
    }

    /// Centre of an eccentric of phase 1 or 2, seen from its shaft's axis.
    fn crank(&self, values: &Values<'_>, i: usize) -> [Dual; 2] {
        let (sin, cos) = crank_angle(values, i).sin_cos();
        let e = values.get("eccentricity");
        [e * cos, e * sin]
    }

    fn inertia(&self, values: &Values<'_>) -> Vec<Dual> {
        let of_coordinate = |coordinate: &Coordinate| {
            let body = coordinate.body.as_bytes()[0];
            let letter = match body {
                b'g' => 'p',
                other => char::from(other),
            };
            match (coordinate.motion, coordinate.axis == Z) {
                (Motion::Rotation, true) => values.get(&format!("j_{letter}z")),
                (Motion::Rotation, false) => values.get(&format!("j_{letter}x")),
                _ => values.get(&format!("m_{letter}")),
            }
        };
        self.bodies.coordinates.iter().map(of_coordinate).collect()
    }

    pub(super) fn machine(&self, values: &Values<'_>) -> Machine {
        let mut all = Machine::new(&self.bodies.coordinates, self.inertia(values));
        for axis in [X, Y] {
            let axis = axis.map(Dual::constant);
            let on_axis = |body: &str, station: &str, machine: &Machine| {
                machine.point(body, along(values.get(station)), axis)
            };
            for (name, body, station) in [
                ("k_o1", "output", "z_o1"),
                ("k_o2", "output", "z_o2"),
                ("k_i1", "input", "a_1"),
            ] {
                let held = on_axis(body, station, &all);
                all.add(name, values.get(name), held);
            }
            let inside = minus(
                on_axis("input", "a_2", &all),
                on_axis("output", "z_o3", &all),
            );
            all.add("k_i2", values.get("k_i2"), inside);
            for (gear, station) in [("gear-1", "a_3"), ("gear-2", "a_4")] {
                let centre = all.point(gear, [Dual::ZERO; 3], axis);
                let bearing = minus(centre, on_axis("input", station, &all));
                all.add("k_a", values.get("k_a"), bearing);
            }
            for j in 0..self.shafts {
                self.add_shaft(values, j, axis, &mut all);
            }
        }
        for i in [1, 2] {
            let stretch = self.mesh_stretch(values, i, &all);
            all.add("k_m", values.get("k_m"), stretch);
        }
        all
    }

    /// Housing bearings of a spider shaft, and those of its eccentrics in the gears, along one
    /// axis.
    fn add_shaft(&self, values: &Values<'_>, j: usize, axis: [Dual; 3], all: &mut Machine) {
        let body = format!("shaft-{}", j + 1);
        for (name, station) in [("k_s1", "b_1"), ("k_s2", "b_2")] {
            let held = all.point(&body, along(values.get(station)), axis);
            all.add(name, values.get(name), held);
        }
        for (i, name, gear, station) in [(1, "k_p1", "gear-1", "b_3"), (2, "k_p2", "gear-2", "b_4")]
        {
            let [x, y] = self.hole(values, j);
            let hole = all.point(gear, [x, y, Dual::ZERO], axis);
            let [x, y] = self.crank(values, i);
            let eccentric = all.point(&body, [x, y, values.get(station)], axis);
            all.add(name, values.get(name), minus(hole, eccentric));
        }
    }

    /// Compression of the mesh of one phase. The line of action touches the base circles at their
    /// radius times `(sin psi, -cos psi)` from the centres.
    fn mesh_stretch(&self, values: &Values<'_>, i: usize, machine: &Machine) -> Stretch {
        let quarter = Dual::constant(0.5 * PI);
        let psi = quarter - values.get("pressure_angle") + crank_angle(values, i);
        let (sin, cos) = psi.sin_cos();
        let action = [cos, sin, Dual::ZERO];
        let foot = |radius: Dual, z: Dual| [radius * sin, -(radius * cos), z];
        let on_gear = foot(values.get("gear_base_radius"), Dual::ZERO);
        let station = values.get(["z_o4", "z_o5"][i - 1]);
        let on_ring = foot(values.get("ring_base_radius"), station);
        let gear = machine.point(&format!("gear-{i}"), on_gear, action);
        minus(gear, machine.point("output", on_ring, action))
    }

    pub(super) fn values<'a>(&'a self, values: &'a [f64], by: Option<usize>) -> Values<'a> {
        let specs = &self.parameters;
        Values { specs, values, by }
    }
}

/// The crank angle of phase 1 or 2.
fn crank_angle(values: &Values<'_>, i: usize) -> Dual {
    values.get("crank_angle") + Dual::constant(PI * (i - 1) as f64)
}

/// The arm to a station on the axis.
fn along(station: Dual) -> [Dual; 3] {
    [Dual::ZERO, Dual::ZERO, station]
}
