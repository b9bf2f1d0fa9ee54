//! The parameters of the cycloid ball transmission, in four sets, each with the source of its
//! value.
//!
//! Printed: section 2.1 and table 1 of the paper. Inferred: what reproduces its table 2. Assumed:
//! what nothing fixes.

use crate::theory::{ParameterSpec, ParameterStatus};

use ParameterStatus::{Assumed, Inferred, Printed};

/// The sets by name, the physical reference first.
///
/// A: everything as printed. B: m3 = 36.4 g for the printed 96.4 g, and a geometry that a machine
/// could have. C: K, e and Rw fitted to table 2. D: k03y fitted as well. C and D are fits, not
/// data: they need a rolling-circle radius of 1.4 mm.
pub(super) const SET_NAMES: &[&str] = &["B", "A", "C", "D"];

/// Angular frequencies that table 2 prints for the torque balls alone and for the reduction balls
/// alone, rad/s. They depend on one contact angle each, which the paper does not print, and give
/// it.
const PIN_BALL_OMEGA_RAD_S: f64 = 33_679.0;
const BALL_OMEGA_RAD_S: f64 = 49_176.0;

/// Printed stiffnesses: name, value, unit.
const STIFFNESSES: [(&str, f64, &str); 16] = [
    ("k_a", 8.15e6, "N/m"),
    ("k_b", 8.73e6, "N/m"),
    ("k_c", 7.90e6, "N/m"),
    ("k_d", 7.90e6, "N/m"),
    ("k_da", 7.90e6, "N/m"),
    ("k_db", 1.90e6, "N/m"),
    ("k_dc", 1.90e6, "N/m"),
    ("k_dd", 7.90e6, "N/m"),
    ("k_01x", 6e7, "N/m"),
    ("k_01y", 6e7, "N/m"),
    ("k_1x", 6e7, "N/m"),
    ("k_1y", 6e7, "N/m"),
    ("k_5y", 6e7, "N/m"),
    ("k_03x", 7e7, "N/m"),
    ("k_03y", 7e7, "N/m"),
    ("k_1u", 6e5, "N m/rad"),
];

/// Printed masses and moments of inertia of table 1, except m3: name, value, unit.
const INERTIAS: [(&str, f64, &str); 9] = [
    ("m_0", 66.4e-3, "kg"),
    ("m_1", 127e-3, "kg"),
    ("m_2", 7.64e-3, "kg"),
    ("m_4", 8.6e-3, "kg"),
    ("m_5", 111e-3, "kg"),
    ("j_0", 1.20e-6, "kg m2"),
    ("j_1", 30.0e-6, "kg m2"),
    ("j_3", 10.6e-6, "kg m2"),
    ("j_5", 10.8e-6, "kg m2"),
];

/// Values in which the sets differ.
struct Differences {
    planet_mass_kg: (f64, ParameterStatus),
    trochoid_ratio: (f64, ParameterStatus),
    half_eccentricity_m: f64,
    pin_circle_radius_m: f64,
    k_03y: (f64, ParameterStatus),
}

fn differences(set: &str) -> Differences {
    let natural = Differences {
        planet_mass_kg: (36.4e-3, Inferred),
        trochoid_ratio: (0.3, Assumed),
        half_eccentricity_m: 1.2e-3,
        pin_circle_radius_m: 50e-3,
        k_03y: (7e7, Printed),
    };
    match set {
        "A" => Differences {
            planet_mass_kg: (96.4e-3, Printed),
            ..natural
        },
        "C" => Differences {
            trochoid_ratio: (0.8499, Inferred),
            half_eccentricity_m: 1.199e-3,
            pin_circle_radius_m: 50.06e-3,
            ..natural
        },
        "D" => Differences {
            trochoid_ratio: (0.8655, Inferred),
            half_eccentricity_m: 1.2034e-3,
            pin_circle_radius_m: 50.08e-3,
            k_03y: (6.239e7, Inferred),
            ..natural
        },
        _ => natural,
    }
}

/// The parameters of a set.
pub(super) fn parameters(set: &str) -> Vec<ParameterSpec> {
    let set_values = differences(set);
    let printed = STIFFNESSES.iter().chain(&INERTIAS);
    let mut specs: Vec<ParameterSpec> = printed
        .map(|&(name, value, unit)| positive(name, value, unit, Printed))
        .collect();
    let nominal = |name: &str| {
        let mut all = STIFFNESSES.iter().chain(&INERTIAS);
        all.find(|(parameter, _, _)| *parameter == name)
            .map_or(f64::NAN, |(_, value, _)| *value)
    };
    let contact = nominal("k_a") + nominal("k_b") + nominal("k_c") + nominal("k_d");
    let pin_contact = nominal("k_da") + nominal("k_db") + nominal("k_dc") + nominal("k_dd");
    let cos2_beta = BALL_OMEGA_RAD_S.powi(2) * nominal("m_2") / contact;
    let cos2_pin = PIN_BALL_OMEGA_RAD_S.powi(2) * nominal("m_4") / pin_contact;
    if let Some(k_03y) = specs.iter_mut().find(|spec| spec.name == "k_03y") {
        *k_03y = positive("k_03y", set_values.k_03y.0, "N/m", set_values.k_03y.1);
    }
    specs.extend([
        positive(
            "m_3",
            set_values.planet_mass_kg.0,
            "kg",
            set_values.planet_mass_kg.1,
        ),
        fraction("cos2_beta", cos2_beta, Inferred),
        fraction("cos2_beta_1", cos2_pin, Inferred),
        fraction("cos2_beta_2", cos2_pin, Inferred),
        fraction(
            "trochoid_ratio",
            set_values.trochoid_ratio.0,
            set_values.trochoid_ratio.1,
        ),
        positive(
            "half_eccentricity",
            set_values.half_eccentricity_m,
            "m",
            Inferred,
        ),
        positive(
            "pin_circle_radius",
            set_values.pin_circle_radius_m,
            "m",
            Inferred,
        ),
        angle("ball_phase"),
        angle("pin_phase"),
        ball_count(),
    ]);
    specs
}

/// A parameter above zero, bounded by a tenth and ten times its value.
fn positive(name: &str, nominal: f64, unit: &str, status: ParameterStatus) -> ParameterSpec {
    ParameterSpec {
        name: name.to_owned(),
        unit: unit.to_owned(),
        nominal,
        lower: Some(0.1 * nominal),
        upper: Some(10.0 * nominal),
        status,
        whole: false,
    }
}

fn fraction(name: &str, nominal: f64, status: ParameterStatus) -> ParameterSpec {
    ParameterSpec {
        lower: Some(0.01),
        upper: Some(0.99),
        ..positive(name, nominal, "1", status)
    }
}

/// Number Z2 of reduction balls, table 1; the planet disc has Z3 = Z2 + 1 teeth.
fn ball_count() -> ParameterSpec {
    ParameterSpec {
        lower: Some(4.0),
        upper: Some(40.0),
        whole: true,
        ..positive("ball_count", 10.0, "1", Printed)
    }
}

/// An angle that nothing fixes, 0 by assumption.
fn angle(name: &str) -> ParameterSpec {
    ParameterSpec {
        lower: Some(-std::f64::consts::PI),
        upper: Some(std::f64::consts::PI),
        ..positive(name, 0.0, "rad", Assumed)
    }
}
