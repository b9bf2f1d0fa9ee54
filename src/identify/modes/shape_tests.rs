//! Tests of mode shapes: over responses or references, several columns, signs, and modal mass.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::identify::modes::shape::{ScaledShape, shape_of};
use crate::identify::synthetic::Structure;
use crate::modal::Scaling;

const SHAPE: [f64; 4] = [0.5, -1.2, 0.8, 0.3];

fn structure() -> Structure {
    Structure {
        modes: vec![(80.0, 0.01, SHAPE.to_vec())],
    }
}

fn dof(text: &str) -> Dof {
    text.parse().expect("a point and its direction")
}

fn damped_rad_s() -> f64 {
    crate::modal::Pole::from_frequency(80.0, 0.01).lambda.im
}

/// The shape from the exact residues of some pairs, each residue multiplied by a factor.
fn shape(pairs: &[(&str, &str)], factor: Complex64) -> ScaledShape {
    let pairs = pairs
        .iter()
        .map(|(response, reference)| (dof(response), dof(reference)));
    let residue = |pair: (Dof, Dof)| {
        let value = structure().residue(0, &pair) * factor;
        (pair, value)
    };
    shape_of(&pairs.map(residue).collect(), damped_rad_s())
}

fn assert_values(scaled: &ScaledShape, expected: &[(&str, f64)]) {
    assert_eq!(scaled.shape.len(), expected.len());
    for (name, value) in expected {
        let found = scaled
            .shape
            .get(&dof(name))
            .expect("every point is in the shape");
        assert!((found - value).norm() < 1e-12, "{name} {found}");
    }
}

#[test]
fn driving_point_gives_unit_modal_mass() {
    let scaled = shape(
        &[("1:+Z", "1:+Z"), ("2:+Z", "1:+Z"), ("3:+Z", "1:+Z")],
        Complex64::ONE,
    );
    assert_eq!(
        (scaled.scaling, scaled.modal_mass_kg),
        (Scaling::UnitModalMass, Some(1.0))
    );
    // The largest component is turned to the positive side.
    assert_values(&scaled, &[("1:+Z", -0.5), ("2:+Z", 1.2), ("3:+Z", -0.8)]);
}

#[test]
fn sensors_against_the_axis_keep_their_labels_and_signs() {
    let scaled = shape(
        &[("1:-Z", "1:+Z"), ("2:+Z", "1:+Z"), ("3:-Z", "1:+Z")],
        Complex64::ONE,
    );
    assert_eq!(scaled.scaling, Scaling::UnitModalMass);
    assert_values(&scaled, &[("1:-Z", 0.5), ("2:+Z", 1.2), ("3:-Z", 0.8)]);
}

#[test]
fn roving_hammer_gives_the_shape_at_the_excitation_points() {
    let pairs = [
        ("4:-Z", "1:+Z"),
        ("4:-Z", "2:+Z"),
        ("4:-Z", "3:+Z"),
        ("4:-Z", "4:+Z"),
    ];
    let scaled = shape(&pairs, Complex64::ONE);
    assert_eq!(scaled.scaling, Scaling::UnitModalMass);
    assert_values(
        &scaled,
        &[
            ("1:+Z", -0.5),
            ("2:+Z", 1.2),
            ("3:+Z", -0.8),
            ("4:+Z", -0.3),
        ],
    );
}

#[test]
fn without_a_driving_point_the_largest_component_is_one() {
    let scaled = shape(
        &[("1:+Z", "4:+Z"), ("2:+Z", "4:+Z"), ("3:+Z", "4:+Z")],
        Complex64::ONE,
    );
    assert_eq!(
        (scaled.scaling, scaled.modal_mass_kg),
        (Scaling::UnitMax, None)
    );
    assert_values(
        &scaled,
        &[("1:+Z", -0.5 / 1.2), ("2:+Z", 1.0), ("3:+Z", -0.8 / 1.2)],
    );
}

#[test]
fn driving_point_without_the_phase_of_a_real_mode_gives_no_mass() {
    let pairs = [("1:+Z", "1:+Z"), ("2:+Z", "1:+Z")];
    for (degrees, expected) in [
        (19.0, Scaling::UnitModalMass),
        (-19.0, Scaling::UnitModalMass),
        (21.0, Scaling::UnitMax),
        (-21.0, Scaling::UnitMax),
        (180.0, Scaling::UnitMax),
    ] {
        let scaled = shape(&pairs, Complex64::cis(f64::to_radians(degrees)));
        assert_eq!(scaled.scaling, expected, "{degrees}");
    }
}

#[test]
fn columns_with_missing_pairs_become_one_shape() {
    let pairs = [
        ("1:+Z", "1:+Z"),
        ("2:+Z", "1:+Z"),
        ("2:+Z", "3:-Z"),
        ("3:+Z", "3:-Z"),
        ("4:+Z", "3:-Z"),
    ];
    let scaled = shape(&pairs, Complex64::ONE);
    assert!(scaled.misfit.expect("more pairs than factors") < 1e-12);
    assert_values(
        &scaled,
        &[
            ("1:+Z", -0.5),
            ("2:+Z", 1.2),
            ("3:+Z", -0.8),
            ("4:+Z", -0.3),
        ],
    );
}

#[test]
fn two_shapes_at_one_frequency_have_a_large_misfit() {
    let other = Structure {
        modes: vec![(80.0, 0.01, vec![0.9, 0.7, -0.4, 1.0])],
    };
    let names = ["1:+Z", "2:+Z", "3:+Z", "4:+Z"];
    let pairs = names
        .iter()
        .flat_map(|r| ["1:+Z", "2:+Z"].map(|k| (dof(r), dof(k))));
    let residue = |pair: (Dof, Dof)| {
        let value = structure().residue(0, &pair) + other.residue(0, &pair);
        (pair, value)
    };
    let scaled = shape_of(&pairs.map(residue).collect(), damped_rad_s());
    assert!(
        scaled.misfit.expect("more pairs than factors") > 0.25,
        "{:?}",
        scaled.misfit
    );
}

#[test]
fn complex_columns_with_a_missing_pair_have_one_shape_without_misfit() {
    let value = |k: usize, turn: f64| Complex64::from_polar(1.0 + 0.3 * k as f64, turn * k as f64);
    let (shape, factor) = (|r: usize| value(r, 0.7), |k: usize| value(k, 1.9));
    let point = |k: usize| dof(&format!("{}:+Z", 1 + k));
    let pairs = (0..5).flat_map(|r| (0..3).map(move |k| (r, k)));
    let residues = pairs
        .filter(|pair| *pair != (4, 1))
        .map(|(r, k)| ((point(r), point(10 + k)), shape(r) * factor(k)));
    let scaled = shape_of(&residues.collect(), damped_rad_s());
    let largest = scaled
        .shape
        .get(&point(4))
        .expect("every point is in the shape");
    for r in 0..5 {
        let ratio = scaled
            .shape
            .get(&point(r))
            .expect("every point is in the shape")
            / largest;
        assert!((ratio - shape(r) / shape(4)).norm() < 1e-12, "{r}: {ratio}");
    }
    assert!(
        scaled.misfit.expect("more pairs than factors") < 1e-12,
        "{:?}",
        scaled.misfit
    );
}
