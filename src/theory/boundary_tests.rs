//! The support of models by their matrices, and their modes without the stiffness to ground.

use crate::linalg::{RealMatrix, SparseMatrix};

use super::beam_modes_tests::{at, bar};
use super::*;

fn support_of(model: &dyn TheoreticalModel) -> ModelSupport {
    model_support(model, &nominal_values(model.parameters())).unwrap()
}

fn released(model: &dyn TheoreticalModel) -> Option<Vec<ReleasedMode>> {
    released_modes(model, &nominal_values(model.parameters())).unwrap()
}

fn spring_at(place: f64, stiffness: f64) -> SpringDescription {
    SpringDescription {
        name: format!("spring at {place}"),
        beam: "bar".to_owned(),
        at_m: at(place),
        stiffness_n_per_m: Some(Value::Number(stiffness)),
        stiffness_nm_per_rad: None,
    }
}

/// Masses of 1 kg along x with springs of 1 kN/m between them; `ground` holds the first.
fn chain(count: usize, ground: Option<f64>) -> LumpedModel {
    let mut text = String::new();
    for i in 1..=count {
        text += &format!(
            "[[body]]\nname = \"{i}\"\nmass_kg = 1.0\nfree = [\"x\"]\n\
             [[point]]\nname = \"p{i}\"\nbody = \"{i}\"\nat_m = [{i}.0, 0.0, 0.0]\n"
        );
    }
    for i in 1..count {
        let next = i + 1;
        text += &format!(
            "[[spring]]\nname = \"{i}\"\nfrom = \"p{i}\"\nto = \"p{next}\"\nstiffness_n_per_m = 1e3\n"
        );
    }
    if let Some(stiffness) = ground {
        text += &format!(
            "[[spring]]\nname = \"ground\"\nfrom = \"p1\"\nto = \"ground\"\n\
             direction = [1.0, 0.0, 0.0]\nstiffness_n_per_m = {stiffness:?}\n"
        );
    }
    LumpedModel::new(toml::from_str(&text).unwrap()).unwrap()
}

#[test]
fn transmissions_are_supported_although_their_mechanisms_move_freely() {
    for name in [
        "cycloid-ball",
        "cycloid-ball/A",
        "torsional-planetary",
        "spider-reducer",
        "helical-planetary",
    ] {
        let support = support_of(built_in(name).unwrap().as_ref());
        assert_eq!(support.stated, Some(Support::Fixed), "{name}");
        assert_eq!(support.derived, Some(Support::Fixed), "{name}");
    }
    // Planets turn on the pins of a carrier, or roll in a ring, that is no body of the model.
    for name in [
        "torsional-planetary/carrier-fixed",
        "helical-planetary/torsional",
    ] {
        let support = support_of(built_in(name).unwrap().as_ref());
        assert_eq!(support.derived, None, "{name}");
    }
}

#[test]
fn free_model_is_suspended_and_a_held_one_is_fixed() {
    let beam = |start, end| BeamModel::new(bar(8, start, end)).unwrap();
    let derived = |model: &dyn TheoreticalModel| support_of(model).derived;
    assert_eq!(
        derived(&beam(End::Free, End::Free)),
        Some(Support::Suspended)
    );
    assert_eq!(
        derived(&beam(End::Clamped, End::Free)),
        Some(Support::Fixed)
    );
    assert_eq!(derived(&chain(3, None)), Some(Support::Suspended));
    let held = support_of(&chain(4, Some(100.0)));
    assert_eq!(held.derived, Some(Support::Fixed));
    // 4 kg on 100 N/m.
    let translation_hz = 5.0 / std::f64::consts::TAU;
    assert!((held.translation_hz.unwrap() - translation_hz).abs() < 1e-12);
    assert_eq!(support_of(&chain(4, None)).translation_hz, Some(0.0));
}

/// The matrices of a free bar with entries of nine digits, and a bearing at its first node.
fn rounded_bar(bearing_over_entry: f64) -> ExternalModel {
    let matrices = BeamModel::new(bar(20, End::Free, End::Free)).unwrap();
    let matrices = matrices.assemble(&[]).unwrap();
    let size = matrices.coordinates.len();
    let rounded = |of: &RealMatrix, i, j| format!("{:.8e}", of[(i, j)]).parse::<f64>().unwrap();
    let places = || (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
    let entries = |of: &RealMatrix| -> Vec<(usize, usize, f64)> {
        let entries = places().map(|(i, j)| (i, j, rounded(of, i, j)));
        entries.filter(|(_, _, value)| value.abs() > 0.0).collect()
    };
    let mut stiffness = entries(&matrices.stiffness);
    stiffness.push((0, 0, bearing_over_entry * matrices.stiffness[(0, 0)]));
    let matrix = |entries: &[_]| Some(SparseMatrix::from_entries(size, entries).unwrap());
    let dof = |(i, coordinate): (usize, &Coordinate)| match coordinate.motion {
        Motion::Translation => format!("{i}:+Z").parse().unwrap(),
        _ => format!("{i}:+RY").parse().unwrap(),
    };
    ExternalModel::new(ExternalMatrices {
        title: "bar".to_owned(),
        dofs: matrices.coordinates.iter().enumerate().map(dof).collect(),
        fixed: MatrixSet {
            mass: matrix(&entries(&matrices.mass)),
            damping: None,
            stiffness: matrix(&stiffness),
        },
        ..ExternalMatrices::default()
    })
    .unwrap()
}

#[test]
fn rounded_matrices_are_free_and_a_soft_bearing_is_a_support() {
    assert_eq!(
        support_of(&rounded_bar(0.0)).derived,
        Some(Support::Suspended)
    );
    let held = rounded_bar(1e-5);
    assert_eq!(support_of(&held).derived, Some(Support::Fixed));
    // Nothing tells which part of the entries is the bearing.
    assert_eq!(released(&held), None);
}

#[test]
fn matrices_without_directions_do_not_show_their_support() {
    let model = ExternalModel::new(ExternalMatrices {
        title: "torsion".to_owned(),
        dofs: vec!["1:+S".parse().unwrap()],
        fixed: MatrixSet {
            mass: Some(SparseMatrix::from_entries(1, &[(0, 0, 1.0)]).unwrap()),
            damping: None,
            stiffness: Some(SparseMatrix::from_entries(1, &[(0, 0, 1.0)]).unwrap()),
        },
        support: Some(Support::Mounted),
        ..ExternalMatrices::default()
    });
    let support = support_of(&model.unwrap());
    assert_eq!(support.derived, None);
    assert_eq!(support.support(), Some(Support::Mounted));
}

#[test]
fn released_bar_has_the_frequencies_of_the_free_bar() {
    let free = BeamModel::new(bar(12, End::Free, End::Free)).unwrap();
    let free_hz: Vec<f64> = modes(&free, &[], &[], &ModeOptions::default())
        .unwrap()
        .omega_rad_s
        .iter()
        .map(|omega| omega / std::f64::consts::TAU)
        .collect();
    let mut file = bar(12, End::Free, End::Free);
    file.springs = vec![spring_at(0.2, 2e4), spring_at(0.7, 2e4)];
    let modes = released(&BeamModel::new(file).unwrap()).unwrap();
    // Bounce and pitch on the springs become rigid-body modes, bending stays bending.
    for (mode, expected) in modes.iter().zip(&free_hz) {
        let got = mode.free_hz.unwrap();
        assert!(
            (got - expected).abs() <= 1e-9 * expected,
            "{mode:?} {expected}"
        );
        assert!(mode.held_hz >= got, "{mode:?}");
    }
    let clamped = BeamModel::new(bar(12, End::Clamped, End::Free)).unwrap();
    assert_eq!(released(&clamped), None);
}

#[test]
fn mode_without_counterpart_is_left_open() {
    // The first mass of four moves alone on a stiff spring: without it no root has half of that.
    let modes = released(&chain(4, Some(1e9))).unwrap();
    assert_eq!(modes.len(), 4);
    assert_eq!(modes[3].free_hz, None);
    assert!(modes[0].free_hz.is_some());
}
