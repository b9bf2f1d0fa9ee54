//! Masses, springs, sensors and mistakes in beam models.

use crate::geometry::Target;
use crate::linalg::RealMatrix;

use super::beam_modes_tests::{at, bar, modes_of};
use super::*;

const LENGTH_M: f64 = 0.9;
const BEAM_KG: f64 = 7830.0 * 2.4e-4 * LENGTH_M;

fn mass(at_m: [f64; 3], kg: f64, inertia: Option<f64>) -> PointMassDescription {
    PointMassDescription {
        name: format!("mass at {at_m:?}"),
        beam: "bar".to_owned(),
        at_m,
        mass_kg: Value::Number(kg),
        rotary_inertia_kg_m2: inertia.map(Value::Number),
    }
}

fn spring(at_m: [f64; 3], across: Option<f64>, rotation: Option<f64>) -> SpringDescription {
    SpringDescription {
        name: format!("spring at {at_m:?}"),
        beam: "bar".to_owned(),
        at_m,
        stiffness_n_per_m: across.map(Value::Number),
        stiffness_nm_per_rad: rotation.map(Value::Number),
    }
}

/// The coordinates of the free bar moved by 1 at its start, or turned by 1 about it.
fn rigid_motion(model: &BeamModel, turn: bool) -> Vec<f64> {
    let matrices = model.assemble(&[]).unwrap();
    let value = |c: &Coordinate| match (c.motion, turn) {
        (Motion::Translation, false) | (Motion::Rotation, true) => 1.0,
        (Motion::Rotation, false) | (Motion::Arc, _) => 0.0,
        (Motion::Translation, true) => (c.at_m[0] - 0.1).hypot(c.at_m[1] - 0.2),
    };
    matrices.coordinates.iter().map(value).collect()
}

fn form(matrix: &RealMatrix, a: &[f64], b: &[f64]) -> f64 {
    let n = a.len();
    let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    pairs.map(|(i, j)| a[i] * matrix[(i, j)] * b[j]).sum()
}

#[test]
fn masses_and_springs_between_nodes_act_exactly_on_rigid_motion() {
    let (a, b, kg, inertia, k, torsion) = (0.3141, 0.777, 1.3, 0.02, 4e4, 55.0);
    let mut file = bar(7, End::Free, End::Free);
    file.point_masses.push(mass(at(a), kg, Some(inertia)));
    file.springs.push(spring(at(b), Some(k), Some(torsion)));
    let model = BeamModel::new(file).unwrap();
    let (shift, turn) = (rigid_motion(&model, false), rigid_motion(&model, true));
    let matrices = model.assemble(&[]).unwrap();
    let (m, stiff) = (&matrices.mass, &matrices.stiffness);
    // Cancellation of the bending terms 12 EI/h^3 = 2e6 N/m leaves about 1e-9 in the stiffness.
    for (got, expected) in [
        (form(m, &shift, &shift), BEAM_KG + kg),
        (form(m, &shift, &turn), BEAM_KG * LENGTH_M / 2.0 + kg * a),
        (
            form(m, &turn, &turn),
            BEAM_KG * LENGTH_M.powi(2) / 3.0 + kg * a * a + inertia,
        ),
        (form(stiff, &shift, &shift), k),
        (form(stiff, &shift, &turn), k * b),
        (form(stiff, &turn, &turn), k * b * b + torsion),
    ] {
        assert!((got / expected - 1.0).abs() < 1e-10, "{got} {expected}");
    }
}

#[test]
fn a_stiff_bar_on_two_springs_bounces_and_pitches() {
    let (kg, inertia, k) = (2.0, 0.05, 1000.0);
    let mut file = bar(4, End::Free, End::Free);
    file.beams[0].youngs_modulus_pa = Value::Number(2e16);
    file.point_masses
        .push(mass(at(LENGTH_M / 2.0), kg, Some(inertia)));
    for x in [0.0, LENGTH_M] {
        file.springs.push(spring(at(x), Some(k), None));
    }
    let result = modes_of(file, &[]);
    assert_eq!(result.rigid, 0);
    let bounce = 2.0 * k / (BEAM_KG + kg);
    let pitch = 0.5 * k * LENGTH_M.powi(2) / (BEAM_KG * LENGTH_M.powi(2) / 12.0 + inertia);
    // First bending omega^2 = 500 EI/(rho A L^4) = 1.4e10, so that bending lowers these by about
    // 1e-7.
    for (omega, expected) in result.omega_rad_s.iter().zip([bounce, pitch]) {
        assert!((omega * omega / expected - 1.0).abs() < 1e-6, "{omega}");
    }
}

fn row(target: Target) -> Result<Vec<f64>, TheoryError> {
    BeamModel::new(bar(3, End::Free, End::Free))
        .unwrap()
        .observation_row(&[], &target)
}

fn point(body: &str, at_m: [f64; 3], direction: [f64; 3]) -> Target {
    let body = body.to_owned();
    Target::BodyPoint {
        body,
        at_m,
        direction,
    }
}

#[test]
fn a_sensor_reads_the_projection_of_its_point_and_direction() {
    let straight = row(point("bar", at(0.4), [0.0, 0.0, 3.0])).unwrap();
    let mut lifted = at(0.4);
    lifted[2] += 0.05;
    assert_eq!(
        row(point("bar", lifted, [0.0, 0.0, 1.0])).unwrap(),
        straight
    );
    let slanted = row(point("bar", at(0.4), [1.0, 0.0, -1.0])).unwrap();
    for (a, b) in slanted.iter().zip(&straight) {
        assert!((a + b / 2f64.sqrt()).abs() < 1e-15);
    }
    assert!(
        row(point("bar", at(0.4), [1.0, 0.0, 0.0]))
            .unwrap()
            .iter()
            .all(|v| *v == 0.0)
    );
    let coordinate = row(Target::Coordinate("bar.theta2".to_owned())).unwrap();
    assert_eq!(coordinate, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
}

#[test]
fn a_sensor_that_cannot_be_is_refused() {
    let up = [0.0, 0.0, 1.0];
    assert!(matches!(
        row(point("baar", at(0.4), up)),
        Err(TheoryError::UnknownBody { nearest: Some(name), .. }) if name == "bar"
    ));
    for x in [-1e-3, LENGTH_M + 1e-3, f64::NAN] {
        let error = row(point("bar", at(x), up));
        assert!(
            matches!(error, Err(TheoryError::PointOutside { length_m, .. }) if (length_m - LENGTH_M).abs() < 1e-15)
        );
    }
    assert!(row(point("bar", at(LENGTH_M + 1e-12), up)).is_ok());
    for direction in [[0.0; 3], [f64::NAN, 0.0, 1.0]] {
        let error = row(point("bar", at(0.4), direction));
        assert!(matches!(error, Err(TheoryError::ZeroDirection { .. })));
    }
    assert!(matches!(
        row(Target::Coordinate("bar.w4".to_owned())),
        Err(TheoryError::UnknownCoordinate { count: 8, .. })
    ));
}

#[test]
fn an_impossible_model_is_refused_with_its_part() {
    let build = |change: fn(&mut BeamFile)| {
        let mut file = bar(3, End::Free, End::Free);
        change(&mut file);
        BeamModel::new(file).unwrap_err()
    };
    let part_of = |change: fn(&mut BeamFile)| match build(change) {
        TheoryError::PropertyOutOfRange { part, property, .. } => format!("{part} {property}"),
        other => other.to_string(),
    };
    assert!(matches!(
        build(|f| f.schema.push('x')),
        TheoryError::Schema { .. }
    ));
    assert!(matches!(
        build(|f| f.beams.push(f.beams[0].clone())),
        TheoryError::Duplicate { .. }
    ));
    assert!(matches!(
        build(|f| f.beams[0].deflection = [0.6, 0.8, 0.1]),
        TheoryError::DeflectionNotAcross { .. }
    ));
    assert!(matches!(
        build(|f| f.springs.push(spring(at(0.1), None, None))),
        TheoryError::NoStiffness { .. }
    ));
    assert!(matches!(
        build(|f| f.point_masses.push(mass(at(1.0), 1.0, None))),
        TheoryError::PointOutside { .. }
    ));
    assert_eq!(part_of(|f| f.beams[0].elements = 0), "beam `bar` elements");
    assert_eq!(
        part_of(|f| f.beams[0].to_m = at(0.0)),
        "beam `bar` length in m"
    );
    assert_eq!(
        part_of(|f| f.beams[0].area_m2 = Value::Number(0.0)),
        "beam `bar` area_m2"
    );
    assert!(part_of(|f| f.point_masses.push(mass(at(0.5), -1.0, None))).ends_with(" mass_kg"));
    assert!(
        part_of(|f| f.springs.push(spring(at(0.5), None, Some(f64::NAN))))
            .ends_with(" stiffness_nm_per_rad")
    );
}

#[test]
fn a_parameter_moves_the_matrices_that_name_it() {
    let mut file = bar(3, End::Clamped, End::Free);
    file.parameters.push(ParameterSpec {
        name: "modulus".to_owned(),
        unit: "Pa".to_owned(),
        nominal: 2e11,
        lower: Some(1e11),
        upper: Some(3e11),
        status: ParameterStatus::Assumed,
        whole: false,
    });
    file.beams[0].youngs_modulus_pa = Value::Parameter("modulus".to_owned());
    let model = BeamModel::new(file).unwrap();
    let omega = |value| {
        let result = modes(&model, &[value], &[], &ModeOptions::default()).unwrap();
        assert_eq!(
            result.model.findings.len(),
            1,
            "the assumed parameter is said"
        );
        result.omega_rad_s[0]
    };
    assert!((omega(2.42e11) / omega(2e11) - 1.1).abs() < 1e-9);
    assert!(matches!(
        model.assemble(&[4e11]),
        Err(TheoryError::OutOfBounds { .. })
    ));
    assert!(matches!(
        model.assemble(&[]),
        Err(TheoryError::ValueCount { .. })
    ));
}
