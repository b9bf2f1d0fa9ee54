//! The parameters of the spider reducer HJW-18B, each with the source of its value.
//!
//! Printed: the bearing and mesh stiffnesses, teeth, module and working pressure angle. Inferred:
//! eccentricity and base radii, from these with a cutter of 20 degrees. Assumed: every mass, moment
//! of inertia and station, from a plain steel machine of this size, since the paper prints none;
//! two of them make the first and the ninth root the printed ones.

use crate::theory::{ParameterSpec, ParameterStatus};

use ParameterStatus::{Assumed, Inferred, Printed};

/// Teeth of the spider gears.
pub(super) const GEAR_TEETH: f64 = 192.0;
/// Teeth of the ring gear.
pub(super) const RING_TEETH: f64 = 196.0;
/// Module, m.
const MODULE_M: f64 = 1.5e-3;
/// Working pressure angle, degrees.
const WORKING_DEG: f64 = 25.0;
/// Pressure angle of the cutter, degrees.
const CUTTER_DEG: f64 = 20.0;

/// Printed stiffnesses, N/m.
const STIFFNESSES: [(&str, f64); 10] = [
    ("k_o1", 30e6),
    ("k_o2", 40e6),
    ("k_i1", 10e6),
    ("k_i2", 20e6),
    ("k_a", 30e6),
    ("k_s1", 30e6),
    ("k_s2", 30e6),
    ("k_p1", 30e6),
    ("k_p2", 30e6),
    ("k_m", 300e6),
];

/// Assumed masses and moments of inertia: output, input, one spider shaft, one spider gear. `j_sz`
/// is the first of the two that are calibrated.
const INERTIAS: [(&str, f64, &str); 10] = [
    ("m_o", 66.0, "kg"),
    ("j_ox", 1.52, "kg m2"),
    ("j_oz", 0.897, "kg m2"),
    ("m_i", 7.1, "kg"),
    ("j_ix", 0.075, "kg m2"),
    ("m_s", 1.21, "kg"),
    ("j_sx", 0.0030, "kg m2"),
    ("j_sz", 1.7205e-4, "kg m2"),
    ("m_p", 14.7, "kg"),
    ("j_pz", 0.178, "kg m2"),
];

/// Assumed stations along the axis from each body's centre of mass, m, with the paper's names but
/// z1 ... z5 of the output shaft, which are `z_o1` ... `z_o5`. `z_o2` is the second of the two that
/// are calibrated.
const STATIONS: [(&str, f64); 13] = [
    ("z_o1", -0.0005),
    ("z_o2", -0.1209),
    ("z_o3", 0.0275),
    ("z_o4", 0.145),
    ("z_o5", 0.090),
    ("a_1", 0.093),
    ("a_2", -0.167),
    ("a_3", -0.0495),
    ("a_4", -0.1045),
    ("b_1", 0.072),
    ("b_2", -0.072),
    ("b_3", 0.0275),
    ("b_4", -0.0275),
];

/// All parameters.
pub(super) fn parameters() -> Vec<ParameterSpec> {
    let spec =
        |name: &str, nominal: f64, unit: &str, [lower, upper]: [f64; 2], status| ParameterSpec {
            name: name.to_owned(),
            unit: unit.to_owned(),
            nominal,
            lower: Some(lower),
            upper: Some(upper),
            status,
            whole: false,
        };
    let around = |nominal: f64| [0.1 * nominal, 10.0 * nominal];
    let mut all = Vec::new();
    all.extend(STIFFNESSES.map(|(name, k)| spec(name, k, "N/m", around(k), Printed)));
    all.extend(
        INERTIAS.map(|(name, nominal, unit)| spec(name, nominal, unit, around(nominal), Assumed)),
    );
    all.extend(STATIONS.map(|(name, nominal)| spec(name, nominal, "m", [-0.5, 0.5], Assumed)));
    let ratio = CUTTER_DEG.to_radians().cos() / WORKING_DEG.to_radians().cos();
    let eccentricity = 0.5 * MODULE_M * (RING_TEETH - GEAR_TEETH) * ratio;
    let base = |teeth: f64| 0.5 * MODULE_M * teeth * CUTTER_DEG.to_radians().cos();
    for (name, nominal) in [
        ("eccentricity", eccentricity),
        ("ring_base_radius", base(RING_TEETH)),
        ("gear_base_radius", base(GEAR_TEETH)),
    ] {
        all.push(spec(name, nominal, "m", around(nominal), Inferred));
    }
    let working = WORKING_DEG.to_radians();
    all.push(spec("pressure_angle", working, "rad", [0.1, 1.0], Printed));
    all.push(spec("hole_radius", 0.092, "m", around(0.092), Assumed));
    // The paper gives its results at this angle; no frequency depends on it.
    let turn = [-std::f64::consts::TAU, std::f64::consts::TAU];
    all.push(spec("crank_angle", 0.0, "rad", turn, Printed));
    all
}
