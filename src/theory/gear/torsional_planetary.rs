//! The purely torsional 2K-H planetary gear: carrier, ring and sun, and planets between them.
//!
//! Coordinates are displacements along base circles, `u = r theta`, and masses are equivalent ones,
//! `m = I / r^2`. A planet meshes with the ring and with the sun; with α the pressure angle the
//! meshes are compressed by `ur - uc cos α - un` and `us - uc cos α + un`. Each of carrier, ring
//! and sun may have a torsional support.
//!
//! A planet mode leaves carrier, ring and sun still, `lambda = (k_r + k_s)/m_p`, N - 1 of them. In
//! a rotational mode all planets move alike. With one member fixed its two roots above 0 solve a
//! quadratic; where it meets the planet modes and where its roots come nearest are closed
//! forms, too (`torsional_closed_forms`).
//!
//! # Reference
//! Wang et al. (2005), Natural characteristics and mode jumps of planetary gear transmissions (in
//! Chinese), Journal of Vibration Engineering 18(4), 412, equations 1 to 19.

use crate::theory::dual::{Dual, Values};
use crate::theory::rigid::RigidBodies;
use crate::theory::spring_assembly::Machine;
use crate::theory::{Coordinate, Motion, ParameterSpec, ParameterStatus};

use super::torsional_closed_forms::{ClosedForms, Fixed};
use ParameterStatus::{Inferred, Printed};

/// The sets: the machine of table 2, whose carrier has a support, and those with one member fixed.
pub(super) const SET_NAMES: &[&str] = &["table-2", "carrier-fixed", "ring-fixed", "sun-fixed"];

/// The gear with `3 + N` coordinates, or `2 + N` with one member fixed.
///
/// Bodies and coordinates: `carrier` (uc), `ring` (ur), `sun` (us), `planet-1` (u1) ... `planet-N`.
#[derive(Clone, Debug)]
pub struct TorsionalPlanetary {
    pub(super) name: String,
    pub(super) parameters: Vec<ParameterSpec>,
    planets: usize,
    fixed: Option<Fixed>,
    pub(super) bodies: RigidBodies,
}

impl TorsionalPlanetary {
    /// The model of a set: `table-2` with 4 planets; `carrier-fixed`, `ring-fixed` and `sun-fixed`
    /// with 3, the number to which the places of veering belong that the paper prints. `None` for
    /// another name.
    pub fn new(set: &str) -> Option<Self> {
        Self::with_planets(set, if set == SET_NAMES[0] { 4 } else { 3 })
    }

    /// The model of a set with another number of planets.
    pub(super) fn with_planets(set: &str, planets: usize) -> Option<Self> {
        let fixed = match set {
            "table-2" => None,
            "carrier-fixed" => Some(Fixed::Carrier),
            "ring-fixed" => Some(Fixed::Ring),
            "sun-fixed" => Some(Fixed::Sun),
            _ => return None,
        };
        let mut bodies = RigidBodies::default();
        let members = [Fixed::Carrier, Fixed::Ring, Fixed::Sun].into_iter();
        let members = members.filter(|member| Some(*member) != fixed);
        let members = members.map(|member| (member.body().to_owned(), member.coordinate()));
        let all_planets = (1..=planets).map(|n| (format!("planet-{n}"), format!("u{n}")));
        for (body, name) in members.chain(all_planets) {
            bodies.add(body, [0.0; 3], [(name, Motion::Arc, [0.0, 0.0, 1.0])]);
        }
        Some(Self {
            name: format!("torsional planetary gear, {planets} planets, {set}"),
            parameters: parameters(fixed),
            planets,
            fixed,
            bodies,
        })
    }

    pub(super) fn machine(&self, values: &Values<'_>) -> Machine {
        let inertia = |coordinate: &Coordinate| match coordinate.body.as_str() {
            "carrier" => values.get("m_c"),
            "ring" => values.get("m_r"),
            "sun" => values.get("m_s"),
            _ => values.get("m_p"),
        };
        let coordinates = &self.bodies.coordinates;
        let mut all = Machine::new(coordinates, coordinates.iter().map(inertia).collect());
        let cos = values.get("pressure_angle").sin_cos().1;
        for planet in 1..=self.planets {
            let planet = format!("u{planet}");
            for (name, member, sign) in [("k_r", "ur", -1.0), ("k_s", "us", 1.0)] {
                let parts = [
                    (member, Dual::ONE),
                    ("uc", -cos),
                    (planet.as_str(), Dual::constant(sign)),
                ];
                let parts = parts.into_iter();
                let parts = parts.filter_map(|(body, part)| Some((self.index(body)?, part)));
                all.add(name, values.get(name), parts.collect());
            }
        }
        for (name, member) in [("k_cu", "uc"), ("k_ru", "ur"), ("k_su", "us")] {
            if let Some(index) = self.index(member) {
                all.add(name, values.get(name), vec![(index, Dual::ONE)]);
            }
        }
        all
    }

    /// The place of a coordinate; `None` for that of the fixed member.
    fn index(&self, name: &str) -> Option<usize> {
        let mut all = self.bodies.coordinates.iter();
        all.position(|coordinate| coordinate.name == name)
    }

    pub(super) fn values<'a>(&'a self, values: &'a [f64], by: Option<usize>) -> Values<'a> {
        let specs = &self.parameters;
        Values { specs, values, by }
    }

    /// The closed forms of a gear with one member fixed and without supports; `None` for any other.
    pub(super) fn closed_forms(&self, values: &[f64]) -> Option<ClosedForms> {
        let values = self.values(values, None);
        let get = |name: &str| values.get(name).value;
        let supports = ["k_cu", "k_ru", "k_su"];
        let supported = supports.iter().any(|name| get(name) > 0.0);
        Some(ClosedForms {
            fixed: self.fixed.filter(|_| !supported)?,
            planets: self.planets as f64,
            cos: get("pressure_angle").cos(),
            m_c: get("m_c"),
            m_r: get("m_r"),
            m_s: get("m_s"),
            m_p: get("m_p"),
            k_r: get("k_r"),
            k_s: get("k_s"),
        })
    }
}

/// Table 1. With one member fixed no support is left, as in the paper's closed forms.
fn parameters(fixed: Option<Fixed>) -> Vec<ParameterSpec> {
    let spec =
        |name: &str, nominal: f64, unit: &str, (lower, upper): (f64, f64), status| ParameterSpec {
            name: name.to_owned(),
            unit: unit.to_owned(),
            nominal,
            lower: Some(lower),
            upper: Some(upper),
            status,
            whole: false,
        };
    let carrier_support = if fixed.is_none() { 1e9 } else { 0.0 };
    let (mass, mesh, support) = ((0.01, 1e3), (1e5, 1e13), (0.0, 1e13));
    vec![
        spec("m_c", 7.54, "kg", mass, Inferred),
        spec("m_r", 1.50, "kg", mass, Printed),
        spec("m_s", 0.28, "kg", mass, Printed),
        spec("m_p", 5.81, "kg", mass, Printed),
        spec("k_r", 5e8, "N/m", mesh, Printed),
        spec("k_s", 5e8, "N/m", mesh, Printed),
        spec("k_cu", carrier_support, "N/m", support, Printed),
        spec("k_ru", 0.0, "N/m", support, Printed),
        spec("k_su", 0.0, "N/m", support, Printed),
        spec(
            "pressure_angle",
            24.6f64.to_radians(),
            "rad",
            (0.0, 1.5),
            Printed,
        ),
    ]
}
