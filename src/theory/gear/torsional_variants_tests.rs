//! What the torsional planetary gear would give with other readings of the print, to the
//! reference's digits: supports and masses of table 1, the symbol of the abscissa of figure 3, and
//! where eigenvalues rather than frequencies are nearest.

use std::f64::consts::TAU;

use crate::theory::parameter::override_values;
use crate::theory::{
    ModeOptions, ModelRoot, TheoreticalModel, TorsionalPlanetary, model_roots, modes,
};

fn values(model: &TorsionalPlanetary, changes: &[(&str, f64)]) -> Vec<f64> {
    let changes = changes.iter().map(|(name, v)| ((*name).to_owned(), *v));
    override_values("gear", model.parameters(), &changes.collect()).unwrap()
}

fn roots(model: &TorsionalPlanetary, changes: &[(&str, f64)]) -> Vec<ModelRoot> {
    let values = values(model, changes);
    let solved = modes(model, &values, &[], &ModeOptions::default()).unwrap();
    model_roots(model, &solved)
}

fn quantity(model: &TorsionalPlanetary, changes: &[(&str, f64)], name: &str) -> f64 {
    let all = model.quantities(&values(model, changes)).unwrap();
    all.iter()
        .find(|quantity| quantity.name == name)
        .unwrap()
        .value
        .unwrap()
}

fn carrier_fixed() -> TorsionalPlanetary {
    TorsionalPlanetary::new("carrier-fixed").unwrap()
}

fn printed(value: f64, text: &str) {
    let decimals = text.split('.').nth(1).map_or(0, str::len);
    assert_eq!(format!("{value:.decimals$}"), text);
}

fn scientific(value: f64, text: &str) {
    assert_eq!(format!("{value:.6e}"), text);
}

/// The rotational roots above 0, Hz.
fn rotational(found: &[ModelRoot]) -> Vec<f64> {
    let matching = found.iter().filter(|root| {
        let class = root.class.as_ref();
        class.is_some_and(|class| class.starts_with("rotational"))
    });
    matching.map(|root| root.omega_rad_s / TAU).collect()
}

#[test]
fn other_readings_of_table_1_miss_table_2() {
    let gear = TorsionalPlanetary::new("table-2").unwrap();
    let support = ("k_cu", 0.0);
    for (changes, expected) in [
        // The support of 1e9 N/m on the ring, and on the carrier, with the carrier's printed 4.90
        // kg.
        (
            vec![("m_c", 4.90), support, ("k_ru", 1e9)],
            ["1747.69", "7619.19", "13854.21"],
        ),
        (vec![("m_c", 4.90)], ["1978.04", "6725.00", "13863.26"]),
        // Ring and sun for each other, which table 2 cannot tell from the right order.
        (
            vec![("m_r", 0.28), ("m_s", 1.50)],
            ["1671.43", "6472.35", "13742.19"],
        ),
    ] {
        let found = rotational(&roots(&gear, &changes));
        assert_eq!(found.len(), expected.len(), "{changes:?}");
        for (hz, text) in found.into_iter().zip(expected) {
            printed(hz, text);
        }
    }
    // The carrier that table 2 needs: 4.90 kg and four planets of 0.66 kg.
    let nominal = |name: &str| {
        let parameter = gear.parameters().iter().find(|spec| spec.name == name);
        parameter.unwrap().nominal
    };
    printed(nominal("m_c") - 4.0 * 0.66, "4.90");
    printed(nominal("pressure_angle").cos(), "0.909236");
}

#[test]
fn the_planet_that_gives_the_printed_last_digit_is_the_reference() {
    let gear = TorsionalPlanetary::new("table-2").unwrap();
    // The root goes with 1/sqrt(m_p).
    let mass = 5.81 * (quantity(&gear, &[], "planet_mode") / 2088.00).powi(2);
    printed(mass, "5.810042");
    let found = roots(&gear, &[("m_p", mass)]);
    let planet = found.iter().find(|root| root.modes.len() == 3).unwrap();
    printed(planet.omega_rad_s / TAU, "2088.000000");
}

/// `(lambda_5 - lambda_2)^2` of the rotational roots with the carrier fixed.
fn squared_gap(changes: &[(&str, f64)]) -> f64 {
    let found = rotational(&roots(&carrier_fixed(), changes));
    let [lower, upper] = found[..] else {
        panic!("{found:?}");
    };
    let lambda = |hz: f64| (TAU * hz).powi(2);
    (lambda(upper) - lambda(lower)).powi(2)
}

/// Where a function that is a quadratic is least, from three of its values about `at`.
fn vertex(at: f64, quadratic: impl Fn(f64) -> f64) -> f64 {
    let step = 0.1 * at;
    let [less, middle, more] = [at - step, at, at + step].map(quadratic);
    at + 0.5 * step * (less - more) / (less - 2.0 * middle + more)
}

#[test]
fn eigenvalues_are_nearest_where_the_reference_has_them_and_not_where_frequencies_are() {
    // Sum and product of the eigenvalues are linear in k_r and in 1/m_s, their squared distance
    // s² - 4p a quadratic.
    let mesh = vertex(2.5e9, |k_r| squared_gap(&[("k_r", k_r)]));
    scientific(mesh, "2.499664e9");
    scientific(squared_gap(&[("k_r", mesh)]).sqrt(), "3.850811e8");
    let sun = 1.0 / vertex(1.0 / 1.4, |inverse| squared_gap(&[("m_s", 1.0 / inverse)]));
    printed(sun, "1.500000");
    // The discriminant f2² - 4 f1 f3 of equation 5 is the same times f1² = (m_r m_s m_p)²; it is a
    // quadratic in m_s.
    let discriminant = |m_s: f64| (1.5 * m_s * 5.81).powi(2) * squared_gap(&[("m_s", m_s)]);
    printed(vertex(1.4, discriminant), "1.456842");
    // Equation 7 makes it least over k_s: at the printed k_s for its k_r.
    let gear = carrier_fixed();
    let criterion = quantity(&gear, &[], "veering_k_r");
    let over_sun_mesh = |k_s: f64| squared_gap(&[("k_r", criterion), ("k_s", k_s)]);
    printed(1e-8 * vertex(4e8, over_sun_mesh), "5.000000");
    // How far equation 7 is from the place where the frequencies are nearest.
    for (criterion, nearest, percent) in [
        ("veering_k_r", "nearest_k_r", "0.4"),
        ("veering_m_s", "nearest_m_s", "2.1"),
    ] {
        let [criterion, nearest] = [criterion, nearest].map(|name| quantity(&gear, &[], name));
        printed(100.0 * (criterion / nearest - 1.0), percent);
    }
}

#[test]
fn the_printed_symbol_of_figure_3_gives_other_places() {
    // Figure 3 prints k_sn under its abscissa. Equations 7 and 8 are a ratio k_r/k_s; with k_r kept
    // at 5e8 N/m they give a k_s that the paper does not print.
    let gear = carrier_fixed();
    for (name, text) in [
        ("veering_k_r", "9.951288e7"),
        ("crossing_k_r_lower", "5.801957e9"),
        ("crossing_k_r_upper", "8.043263e6"),
    ] {
        let ratio = quantity(&gear, &[], name) / 5e8;
        let k_s = 5e8 / ratio;
        scientific(k_s, text);
        assert!((quantity(&gear, &[("k_s", k_s)], name) / 5e8 - 1.0).abs() < 1e-12);
    }
    // There the matrices have one root of three modes: the lower rotational one is a planet root.
    for name in ["crossing_k_r_lower", "crossing_k_r_upper"] {
        let k_s = 5e8 / (quantity(&gear, &[], name) / 5e8);
        let found = roots(&gear, &[("k_s", k_s)]);
        let triple = found.iter().find(|root| root.modes.len() == 3).unwrap();
        let planet = ((5e8 + k_s) / 5.81).sqrt();
        assert!((triple.omega_rad_s / planet - 1.0).abs() < 1e-9, "{name}");
    }
}
