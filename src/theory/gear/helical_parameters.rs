//! The parameters of the helical planetary gear, each with the source of its value.
//!
//! Printed: the data of the paper's section 4. Inferred: what follows from them. Assumed: what the
//! paper leaves open.

use std::f64::consts::PI;

use crate::theory::{ParameterSpec, ParameterStatus};

use ParameterStatus::{Assumed, Inferred, Printed};

/// The sets: both bearing stiffnesses of the paper, and rigid bearings.
pub(super) const SET_NAMES: &[&str] = &["kb-1.5e8", "kb-1e10", "torsional"];

/// Teeth of sun, planet and ring. The paper prints 82 for the ring, which fits neither the centre
/// distance nor the assembly of four planets, (21 + 82)/4; 83 fits both.
pub(super) const SUN_TEETH: f64 = 21.0;
const PLANET_TEETH: f64 = 31.0;
pub(super) const RING_TEETH: f64 = 83.0;
/// Number of planets.
pub(super) const PLANETS: usize = 4;

/// Normal module, m; helix angle and normal pressure angle, degrees; density of steel, kg/m³.
const NORMAL_MODULE_M: f64 = 3e-3;
const HELIX_DEG: f64 = 15.0;
const NORMAL_PRESSURE_ANGLE_DEG: f64 = 20.0;
const DENSITY_KG_M3: f64 = 7800.0;
/// Face width of all bodies, bore of a planet and radius of the carrier's disc, m: assumed.
const WIDTH_M: f64 = 30e-3;
const PLANET_BORE_RADIUS_M: f64 = 15e-3;
const CARRIER_RADIUS_M: f64 = 100e-3;

/// Mass and moment of inertia of a disc of steel with a bore.
fn disc(radius: f64, bore: f64) -> (f64, f64) {
    let mass = DENSITY_KG_M3 * PI * WIDTH_M * (radius * radius - bore * bore);
    (mass, 0.5 * mass * (radius * radius + bore * bore))
}

/// The parameters of a set.
pub(super) fn parameters(set: &str) -> Vec<ParameterSpec> {
    let helix = HELIX_DEG.to_radians();
    let alpha = (NORMAL_PRESSURE_ANGLE_DEG.to_radians().tan() / helix.cos()).atan();
    let pitch_radius = |teeth: f64| 0.5 * NORMAL_MODULE_M / helix.cos() * teeth;
    let (m_s, j_s) = disc(pitch_radius(SUN_TEETH), 0.0);
    let (m_p, j_p) = disc(pitch_radius(PLANET_TEETH), PLANET_BORE_RADIUS_M);
    let (m_c, j_c) = disc(CARRIER_RADIUS_M, 0.0);
    let bearing = if set == "kb-1e10" { 1e10 } else { 1.5e8 };
    let mut specs = vec![
        positive("m_c", m_c, "kg", Assumed),
        positive("j_c", j_c, "kg m2", Assumed),
        positive("m_s", m_s, "kg", Assumed),
        positive("j_s", j_s, "kg m2", Assumed),
        positive("m_p", m_p, "kg", Assumed),
        positive("j_p", j_p, "kg m2", Assumed),
        positive("k_sp", 4e8, "N/m", Inferred),
        positive("k_rp", 4e8, "N/m", Inferred),
        ParameterSpec {
            lower: Some(0.05),
            upper: Some(1.5),
            ..positive("pressure_angle", alpha, "rad", Inferred)
        },
        positive(
            "base_radius_s",
            pitch_radius(SUN_TEETH) * alpha.cos(),
            "m",
            Inferred,
        ),
        positive(
            "base_radius_p",
            pitch_radius(PLANET_TEETH) * alpha.cos(),
            "m",
            Inferred,
        ),
    ];
    if set != "torsional" {
        let bearings = ["k_c", "k_s", "k_p"];
        specs.extend(bearings.map(|name| ParameterSpec {
            lower: Some(1e4),
            upper: Some(1e14),
            ..positive(name, bearing, "N/m", Printed)
        }));
    }
    specs.extend([
        positive("mesh_min", 3e8, "N/m", Printed),
        positive("mesh_max", 5e8, "N/m", Printed),
        within("mesh_share_sp", 0.37, Assumed),
        within("mesh_share_rp", 0.64, Assumed),
        within("mesh_lead_rp", 0.24, Assumed),
        within("mesh_edge", 0.1, Assumed),
        ParameterSpec {
            lower: Some(0.0),
            ..positive("stiffness_damping", 5e-6, "s", Assumed)
        },
        ParameterSpec {
            lower: Some(0.0),
            ..positive("load", 40.0, "N m", Printed)
        },
        positive("speed", 80.0, "rpm", Printed),
    ]);
    specs
}

/// A parameter above zero, bounded by a hundredth and a hundred times its value.
fn positive(name: &str, nominal: f64, unit: &str, status: ParameterStatus) -> ParameterSpec {
    ParameterSpec {
        name: name.to_owned(),
        unit: unit.to_owned(),
        nominal,
        lower: Some(0.01 * nominal),
        upper: Some(100.0 * nominal),
        status,
        whole: false,
    }
}

/// A part of the mesh period.
fn within(name: &str, nominal: f64, status: ParameterStatus) -> ParameterSpec {
    ParameterSpec {
        lower: Some(0.001),
        upper: Some(0.9),
        ..positive(name, nominal, "1", status)
    }
}
