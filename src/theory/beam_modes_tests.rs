//! Beams against the closed forms of the Euler-Bernoulli theory: frequencies, convergence and
//! shapes.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use crate::dof::{Axis, Dof};
use crate::finding::{Code, Location};
use crate::geometry::{Sensor, Target};
use crate::modal::mac;

use super::*;

const LENGTH_M: f64 = 0.9;
const YOUNGS_PA: f64 = 2.06e11;
const SECOND_MOMENT_M4: f64 = 1.7e-9;
const MASS_PER_LENGTH: f64 = 7830.0 * 2.4e-4;

/// Roots beta L of `cos cosh = 1`, Blevins (1979), Formulas for Natural Frequency and Mode Shape,
/// table 8-1.
const FREE_FREE: [f64; 4] = [
    4.730_040_744_862_704,
    7.853_204_624_095_838,
    10.995_607_838_001_671,
    14.137_165_491_257_464,
];
/// Roots beta L of `cos cosh = -1`, the same table.
const CLAMPED_FREE: [f64; 4] = [
    1.875_104_068_711_961,
    4.694_091_132_974_175,
    7.854_757_438_237_613,
    10.995_540_734_875_467,
];

/// A beam of numbers along a slanted axis, named `bar`.
pub(super) fn bar(elements: usize, start: End, end: End) -> BeamFile {
    let number = Value::Number;
    BeamFile {
        kind: None,
        sensors: serde::de::IgnoredAny,
        schema: SCHEMA.to_owned(),
        title: "bar".to_owned(),
        support: None,
        example_values: false,
        parameters: Vec::new(),
        beams: vec![BeamDescription {
            name: "bar".to_owned(),
            from_m: [0.1, 0.2, 0.0],
            to_m: at(LENGTH_M),
            deflection: [0.0, 0.0, 2.0],
            elements,
            start,
            end,
            ends_status: ParameterStatus::Printed,
            youngs_modulus_pa: number(YOUNGS_PA),
            density_kg_per_m3: number(7830.0),
            area_m2: number(2.4e-4),
            second_moment_m4: number(SECOND_MOMENT_M4),
        }],
        point_masses: Vec::new(),
        springs: Vec::new(),
    }
}

/// The point of the bar at `x_m` from its start.
pub(super) fn at(x_m: f64) -> [f64; 3] {
    [0.1 + 0.6 * x_m, 0.2 + 0.8 * x_m, 0.0]
}

/// A sensor across the bar at each position, points numbered from 1.
pub(super) fn sensors(positions_m: &[f64]) -> Vec<Sensor> {
    (1..)
        .zip(positions_m)
        .map(|(number, &x_m): (i32, _)| Sensor {
            dof: Dof::new(&number.to_string(), Axis::Z, false).unwrap(),
            target: Target::BodyPoint {
                body: "bar".to_owned(),
                at_m: at(x_m),
                direction: [0.0, 0.0, 1.0],
            },
        })
        .collect()
}

pub(super) fn modes_of(file: BeamFile, sensors: &[Sensor]) -> TheoryModes {
    let model = BeamModel::new(file).unwrap();
    modes(&model, &[], sensors, &ModeOptions::default()).unwrap()
}

/// `beta L` from a frequency: `omega = beta^2 sqrt(EI / rho A)`.
fn beta_l(frequency_hz: f64) -> f64 {
    let wave_speed = (YOUNGS_PA * SECOND_MOMENT_M4 / MASS_PER_LENGTH).sqrt();
    (TAU * frequency_hz / wave_speed).sqrt() * LENGTH_M
}

fn elastic_hz(result: &TheoryModes) -> Vec<f64> {
    let modes = &result.model.modes[result.rigid..];
    modes.iter().map(|mode| mode.frequency_hz).collect()
}

/// The finite-element frequency lies above the exact one by `(beta h)^4 / 1440` to leading order,
/// within one per cent of it here; 1e-10 is the rounding of the lowest eigenvalues.
fn assert_roots(start: End, end: End, roots: &[f64]) {
    let elements = 40;
    let got = elastic_hz(&modes_of(bar(elements, start, end), &[]));
    for (hz, root) in got.iter().zip(roots) {
        let error = (beta_l(*hz) / root).powi(2) - 1.0;
        let leading = (root / elements as f64).powi(4) / 1440.0;
        assert!(
            (error - leading).abs() < 0.01 * leading + 1e-10,
            "{start:?} {end:?} {root}: {error:e} against {leading:e}"
        );
    }
}

#[test]
fn frequencies_are_the_textbook_roots_plus_the_known_discretisation_error() {
    let pinned: [f64; 4] = std::array::from_fn(|i| (i + 1) as f64 * PI);
    assert_roots(End::Pinned, End::Pinned, &pinned);
    assert_roots(End::Free, End::Free, &FREE_FREE);
    assert_roots(End::Clamped, End::Clamped, &FREE_FREE);
    assert_roots(End::Clamped, End::Free, &CLAMPED_FREE);
    assert_roots(End::Free, End::Clamped, &CLAMPED_FREE);
}

#[test]
fn the_first_free_frequency_is_within_a_millionth_with_forty_elements() {
    let hz = elastic_hz(&modes_of(bar(40, End::Free, End::Free), &[]))[0];
    let error = (beta_l(hz) / FREE_FREE[0]).powi(2) - 1.0;
    assert!(error.abs() < 1e-6, "{error:e}");
}

#[test]
fn halving_the_elements_divides_the_error_by_sixteen() {
    let error = |elements| {
        let hz = elastic_hz(&modes_of(bar(elements, End::Free, End::Free), &[]))[2];
        (beta_l(hz) / FREE_FREE[2]).powi(2) - 1.0
    };
    let order = (error(12) / error(24)).log2();
    assert!((order - 4.0).abs() < 0.1, "{order}");
}

/// `1 + cos cosh + mu lambda (cos sinh - sin cosh) = 0`, mu = tip mass over beam mass.
fn tip_mass_root(mu: f64, mut low: f64, mut high: f64) -> f64 {
    let f = |l: f64| {
        let (sin, cos, sinh, cosh) = (l.sin(), l.cos(), l.sinh(), l.cosh());
        1.0 + cos * cosh + mu * l * (cos * sinh - sin * cosh)
    };
    assert!(f(low) * f(high) < 0.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(low) * f(middle) <= 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn a_tip_mass_gives_the_roots_of_its_characteristic_equation() {
    let mu = 0.37;
    let tip_kg = mu * MASS_PER_LENGTH * LENGTH_M;
    let mut file = bar(40, End::Clamped, End::Free);
    file.point_masses.push(PointMassDescription {
        name: "tip".to_owned(),
        beam: "bar".to_owned(),
        at_m: at(LENGTH_M),
        mass_kg: Value::Number(tip_kg),
        rotary_inertia_kg_m2: None,
    });
    let result = modes_of(file, &sensors(&[LENGTH_M]));
    let brackets = [(1.0, 1.87), (3.93, 4.69), (7.07, 7.85)];
    for (mode, bracket) in result.model.modes.iter().zip(brackets) {
        let root = tip_mass_root(mu, bracket.0, bracket.1);
        let error = (beta_l(mode.frequency_hz) / root).powi(2) - 1.0;
        // Only the beam is discretised: its part of the kinetic energy is what the tip leaves of
        // the unit modal mass.
        let (_, tip) = mode.shape.largest().unwrap();
        let leading = (1.0 - tip_kg * tip.re * tip.re) * (root / 40.0).powi(4) / 1440.0;
        assert!(
            (error - leading).abs() < 0.01 * leading + 1e-10,
            "{root}: {error:e} against {leading:e}"
        );
    }
}

fn free_free_shape(root: f64, x: f64) -> f64 {
    let sigma = (root.cosh() - root.cos()) / (root.sinh() - root.sin());
    let z = root * x;
    z.cosh() + z.cos() - sigma * (z.sinh() + z.sin())
}

fn clamped_free_shape(root: f64, x: f64) -> f64 {
    let sigma = (root.cosh() + root.cos()) / (root.sinh() + root.sin());
    let z = root * x;
    z.cosh() - z.cos() - sigma * (z.sinh() - z.sin())
}

#[test]
fn shapes_between_nodes_are_the_analytic_ones() {
    // 17 positions, most of them inside elements; the analytic shapes have a mean square of 1 over
    // the length.
    let positions: Vec<f64> = (0..17).map(|i| LENGTH_M * f64::from(i) / 16.0).collect();
    type Shape = fn(f64, f64) -> f64;
    let cases: [(End, [f64; 4], Shape); 2] = [
        (End::Free, FREE_FREE, free_free_shape),
        (End::Clamped, CLAMPED_FREE, clamped_free_shape),
    ];
    for (start, roots, shape) in cases {
        let result = modes_of(bar(45, start, End::Free), &sensors(&positions));
        for (mode, root) in result.model.modes[result.rigid..].iter().zip(roots) {
            let got: Vec<Complex64> = mode.shape.iter().map(|(_, value)| value).collect();
            let unit_mass = 1.0 / (MASS_PER_LENGTH * LENGTH_M).sqrt();
            let exact = positions
                .iter()
                .map(|x| unit_mass * shape(root, x / LENGTH_M));
            let exact: Vec<Complex64> = exact.map(Complex64::from).collect();
            assert!(mac(&got, &exact).unwrap() > 1.0 - 1e-9);
            let tip = got[16].re.abs() / exact[16].re.abs();
            assert!((tip - 1.0).abs() < 2e-5, "unit modal mass: {tip}");
        }
    }
}

/// Element numbers of a refinement; above 64 elements a model has more coordinates than divide and
/// conquer begins with.
const REFINEMENT: [usize; 9] = [10, 20, 40, 65, 80, 100, 150, 250, 500];

/// Lowest elastic frequencies with the relative bound of each by rounding of the stiffness,
/// `eps |phi|^T |K| |phi| / (2 omega^2)`.
fn with_rounding(file: BeamFile, count: usize) -> (TheoryModes, Vec<(f64, f64)>) {
    let model = BeamModel::new(file).unwrap();
    let k = model.assemble(&[]).unwrap().stiffness;
    let result = modes(&model, &[], &[], &ModeOptions::default()).unwrap();
    let bound = |j: usize| {
        let phi = |i: usize| result.vectors[(i, j)].abs();
        let entries = (0..k.nrows()).flat_map(|i| (0..k.ncols()).map(move |c| (i, c)));
        let sum: f64 = entries
            .map(|(i, c)| phi(i) * k[(i, c)].abs() * phi(c))
            .sum();
        0.5 * f64::EPSILON * sum / result.omega_rad_s[j].powi(2)
    };
    let elastic = result.rigid..result.rigid + count;
    let rows = elastic.map(|j| (result.model.modes[j].frequency_hz, bound(j)));
    let rows = rows.collect();
    (result, rows)
}

/// Root of `cos cosh = sign`, next to `(j + 1/2) pi`.
fn characteristic_root(j: usize, sign: f64) -> f64 {
    let mut x = (j as f64 + 0.5) * PI;
    for _ in 0..50 {
        let (f, slope) = (
            x.cos() - sign / x.cosh(),
            sign * x.tanh() / x.cosh() - x.sin(),
        );
        x -= f / slope;
    }
    x
}

#[test]
fn refined_bars_follow_the_error_of_their_elements_down_to_rounding() {
    for elements in REFINEMENT {
        for (start, rigid, sign) in [(End::Free, 2, 1.0), (End::Clamped, 0, -1.0)] {
            let (result, rows) = with_rounding(bar(elements, start, End::Free), 10);
            assert_eq!(result.rigid, rigid, "{elements} elements");
            let rigid = &result.model.modes[..rigid];
            assert!(
                rigid
                    .iter()
                    .all(|mode| mode.frequency_hz.abs() < f64::MIN_POSITIVE)
            );
            for (j, (hz, bound)) in rows.into_iter().enumerate() {
                // The first root of cos cosh = -1 lies above pi / 2, that of cos cosh = 1 above 3
                // pi / 2.
                let number = if start == End::Free { j + 1 } else { j };
                let root = characteristic_root(number, sign);
                let width = root / elements as f64;
                let (error, leading) = ((beta_l(hz) / root).powi(2) - 1.0, width.powi(4) / 1440.0);
                // Terms of higher order: 14 % where an element is a radian of the wave.
                let higher = 0.2 * width.powi(2) * leading;
                assert!(
                    (error - leading).abs() <= higher + bound.max(1e-8),
                    "{elements} elements, {start:?}, mode {j}: {error:e} against {leading:e}, rounding {bound:e}"
                );
            }
        }
    }
}

/// First root in b of a function that is negative at once above 0.
fn first_root(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-9, 1.2);
    assert!(f(low) < 0.0 && f(high) > 0.0);
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if f(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn soft_suspensions_are_exact_down_to_rounding_and_not_rigid_body_modes() {
    let (bending, mass) = (YOUNGS_PA * SECOND_MOMENT_M4, MASS_PER_LENGTH * LENGTH_M);
    for suspended_hz in [0.1, 2.0] {
        let stiffness = 0.5 * mass * (TAU * suspended_hz).powi(2);
        // Half the bar, `b = beta L / 2`, with EI w''' = k w and w'' = 0 at its end: w = cosh b
        // cos + cos b cosh moves up and down, w = sinh b sin + sin b sinh rocks.
        let cube = |b: f64| bending * (2.0 * b / LENGTH_M).powi(3);
        let heave = first_root(|b| cube(b) * (b.tan() + b.tanh()) - 2.0 * stiffness);
        let rocking = first_root(|b| cube(b) * (1.0 / b.tanh() - 1.0 / b.tan()) - 2.0 * stiffness);
        for elements in REFINEMENT {
            let mut file = bar(elements, End::Free, End::Free);
            for (name, x_m) in [("left", 0.0), ("right", LENGTH_M)] {
                file.springs.push(SpringDescription {
                    name: name.to_owned(),
                    beam: "bar".to_owned(),
                    at_m: at(x_m),
                    stiffness_n_per_m: Some(Value::Number(stiffness)),
                    stiffness_nm_per_rad: None,
                });
            }
            let (result, rows) = with_rounding(file, 4);
            assert_eq!(result.rigid, 0, "{elements} elements, {suspended_hz} Hz");
            for (j, b) in [heave, rocking].into_iter().enumerate() {
                let omega = (2.0 * b / LENGTH_M).powi(2) * (bending / MASS_PER_LENGTH).sqrt();
                let (hz, bound) = rows[j];
                let error = TAU * hz / omega - 1.0;
                // The bar bends a little under its inertia, and that follows the elements: 60 Hz is
                // its first bending mode.
                let bent = 2e-4 * (suspended_hz / 60.0).powi(2) * (10.0 / elements as f64).powi(4);
                assert!(
                    error.abs() <= bound.max(1e-9) + bent,
                    "{elements} elements, {suspended_hz} Hz: {error:e}, rounding {bound:e}"
                );
            }
            let warned = result.model.findings.iter();
            let warned: Vec<_> = warned
                .filter(|finding| finding.code == Code::StiffnessRounding)
                .collect();
            // The finding is at the mode of the largest bound; the others above the limit are in
            // its detail.
            let above: Vec<_> = rows.iter().filter(|(_, bound)| *bound > 1e-6).collect();
            assert_eq!(warned.len(), usize::from(!above.is_empty()));
            let largest = above.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            if let (Some(finding), Some((hz, bound))) = (warned.first(), largest) {
                assert_eq!(finding.location, Location::Mode(*hz), "{elements} elements");
                let value = finding.value.expect("the bound");
                assert!((value / bound - 1.0).abs() < 1e-6, "{value} {bound}");
                let detail = finding.detail.as_deref().unwrap_or_default();
                let others = above.iter().filter(|peak| peak.0.to_bits() != hz.to_bits());
                for (hz, _) in others {
                    assert!(detail.contains(&format!(" at {hz:.4} Hz")), "{detail}");
                }
            }
        }
    }
}
