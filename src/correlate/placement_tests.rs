//! Points to add to a test: nodes, repeated roots, points that help only together, and what no
//! point can see.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::axis::Band;
use crate::dof::Dof;
use crate::modal::ModalModel;

use crate::quantity::FrfKind;

use super::observability_tests::{frfs, of_theory, receptances};
use super::pairing_tests::model;
use super::*;

fn dofs(text: &[&str]) -> Vec<Dof> {
    text.iter()
        .map(|name| name.parse().expect("a name of a degree of freedom"))
        .collect()
}

/// Noise far below the peak of a root of strength 1 at 200 Hz, which is 3e-5 m/N.
const QUIET: f64 = 1e-22;

fn placed(theory: &ModalModel, test: &[(&str, &str)], points: &[&str]) -> Placement {
    let candidates = Candidates {
        hits: dofs(points),
        sensors: dofs(points),
    };
    let band = Band::new(10.0, 900.0).expect("10 is below 900");
    let frfs = receptances(test, QUIET);
    placement(
        theory,
        &ModalModel::default(),
        &frfs,
        Some(band),
        &candidates,
    )
    .unwrap()
}

/// Points of every step: hit, sensor.
fn steps(placement: &Placement) -> Vec<(Option<String>, Option<String>)> {
    let text = |dof: &Option<Dof>| dof.as_ref().map(Dof::to_string);
    let steps = placement.steps.iter();
    steps
        .map(|step| (text(&step.hit), text(&step.sensor)))
        .collect()
}

fn hit(dof: &str) -> (Option<String>, Option<String>) {
    (Some(dof.to_owned()), None)
}

#[test]
fn a_hit_beside_the_node_shows_what_one_on_it_does_not() {
    let theory = model(vec![
        of_theory(100.0, &[1.0, 1.0, 1.0]),
        of_theory(200.0, &[1.0, 0.0, -0.5]),
        of_theory(400.0, &[1.0, -2.0, 1.0]),
    ]);
    let plan = placed(&theory, &[("1:+Z", "2:+Z")], &["1:+Z", "2:+Z", "3:+Z"]);
    assert_eq!(steps(&plan), [hit("1:+Z")]);
    assert_eq!(plan.steps[0].shown, [(1, 1)]);
    let seen: Vec<_> = plan
        .roots
        .iter()
        .map(|target| (target.seen, target.planned))
        .collect();
    assert_eq!(seen, [(1, 1), (0, 1), (1, 1)]);
    // Strength 1 at the driving point, 1 % damping.
    let omega = std::f64::consts::TAU * 200.0;
    let peak = 1.0 / (2.0 * 0.01 * omega * omega);
    let db = plan.roots[1]
        .peak_over_noise_db
        .expect("the noise is known");
    assert!(
        (db - 10.0 * (peak * peak / QUIET).log10()).abs() < 1e-9,
        "{db}"
    );
    // Alone, hits at 1 and 3 show all three; of the two, 1 moves more.
    let ranked: Vec<_> = plan
        .ranking
        .iter()
        .map(|point| (point.dof.to_string(), point.shown))
        .collect();
    let expected =
        [("1:+Z", 3), ("3:+Z", 3), ("2:+Z", 2)].map(|(dof, shown)| (dof.to_owned(), shown));
    assert_eq!(ranked, expected);
}

#[test]
fn a_repeated_root_needs_as_many_hits_as_it_has_modes() {
    let mut pair = [
        of_theory(200.0, &[1.0, 0.5, 0.0, FRAC_1_SQRT_2]),
        of_theory(200.0, &[0.0, 0.0, 1.0, FRAC_1_SQRT_2]),
    ];
    pair.iter_mut().for_each(|mode| mode.group = Some(1));
    let theory = model(pair.to_vec());
    let test = [("1:+Z", "1:+Z"), ("3:+Z", "1:+Z")];
    // A hit at 2 moves what one at 1 moves; at 4 half of the other mode, at 3 all of it.
    let plan = placed(&theory, &test, &["2:+Z", "4:+Z", "3:+Z"]);
    assert_eq!(steps(&plan), [hit("3:+Z")]);
    assert_eq!((plan.roots[0].seen, plan.roots[0].planned), (1, 2));
    let without = placed(&theory, &test, &["2:+Z"]);
    assert_eq!(steps(&without), []);
    assert_eq!(without.roots[0].planned, 1);
}

#[test]
fn a_hit_and_a_sensor_are_added_together_where_neither_helps_alone() {
    let theory = model(vec![
        of_theory(100.0, &[1.0, 0.0, 0.0]),
        of_theory(200.0, &[0.0, 1.0, 0.2]),
    ]);
    let plan = placed(&theory, &[("1:+Z", "1:+Z")], &["1:+Z", "2:+Z", "3:+Z"]);
    let both = (Some("2:+Z".to_owned()), Some("2:+Z".to_owned()));
    assert_eq!(steps(&plan), [both]);
}

#[test]
fn a_root_that_no_point_shows_is_reported_with_its_reason() {
    let theory = model(vec![
        of_theory(100.0, &[1.0, 1.0, 0.0]),
        of_theory(200.0, &[0.0, 0.0, 1.0]),
        of_theory(400.0, &[1.0, 1e-8, 0.0]),
    ]);
    let plan = placed(&theory, &[("2:+Z", "2:+Z")], &["2:+Z"]);
    assert!(plan.steps.is_empty());
    let roots: Vec<_> = plan
        .roots
        .iter()
        .map(|target| (target.planned, target.at_nodes))
        .collect();
    assert_eq!(roots[0], (1, [false, false]));
    assert_eq!(roots[1], (0, [true, true]));
    // It moves, but a strength of 1e-16 does not rise over the noise.
    assert_eq!(roots[2], (0, [false, false]));
    assert!(
        plan.roots[2]
            .peak_over_noise_db
            .expect("the noise is known")
            < -150.0
    );
}

#[test]
fn unmeasured_pairs_are_not_detected() {
    // Root 2 moves at 1 and at 3, but 1 was only hit for the sensor at 2, and 3 only carried one
    // for the hit at 2.
    let theory = model(vec![
        of_theory(100.0, &[1.0, 1.0, 1.0]),
        of_theory(200.0, &[1.0, 0.0, -0.5]),
    ]);
    let test = [("2:+Z", "1:+Z"), ("3:+Z", "2:+Z")];
    let plan = placed(&theory, &test, &["1:+Z", "2:+Z", "3:+Z"]);
    assert_eq!(plan.roots[1].seen, 0);
    assert_eq!(plan.roots[1].planned, 1);
    assert_eq!(plan.steps.len(), 1);
}

#[test]
fn each_response_is_compared_with_the_noise_of_its_quantity() {
    let theory = model(vec![of_theory(200.0, &[1.0, 1.0])]);
    let db = |kind: FrfKind, variance: f64| {
        let frfs = [
            receptances(&[("1:+Z", "1:+Z")], 1.0),
            frfs(&[("2:+Z", "1:+Z")], kind, Some(variance), 0.5),
        ];
        let candidates = Candidates {
            hits: Vec::new(),
            sensors: Vec::new(),
        };
        let test = ModalModel::default();
        let plan = placement(&theory, &test, &frfs.concat(), None, &candidates)
            .expect("the theory has modes");
        plan.roots[0]
            .peak_over_noise_db
            .expect("the noise is known")
    };
    let omega = std::f64::consts::TAU * 200.0;
    let same = db(FrfKind::Receptance, QUIET);
    assert!((db(FrfKind::Mobility, QUIET * omega * omega) - same).abs() < 1e-9);
    assert!((db(FrfKind::Accelerance, QUIET * omega.powi(4)) - same).abs() < 1e-9);
}

#[test]
fn signs_of_sensors_make_no_other_points() {
    let theory = model(vec![of_theory(200.0, &[1.0, 0.5])]);
    let plan = placed(&theory, &[("1:-Z", "1:-Z")], &["1:+Z"]);
    assert_eq!((plan.steps.len(), plan.roots[0].seen), (0, 1));
    assert_eq!(plan.ranking.len(), 1);
}

#[test]
fn independence_is_the_part_of_a_row_that_no_other_point_has() {
    // Points 1 and 2 say the same, point 3 something else: 1/2, 1/2 and 1.
    let theory = model(vec![
        of_theory(100.0, &[1.0, 1.0, 0.0]),
        of_theory(200.0, &[1.0, 1.0, 1.0]),
    ]);
    let plan = placed(&theory, &[("1:+Z", "1:+Z")], &["1:+Z", "2:+Z", "3:+Z"]);
    for point in &plan.ranking {
        let expected = if point.dof.to_string() == "3:+Z" {
            1.0
        } else {
            0.5
        };
        assert!(
            (point.independence.expect("roots are in the band") - expected).abs() < 1e-12,
            "{point:?}"
        );
    }
}

#[test]
fn without_masses_damping_or_noise_nothing_is_planned() {
    let theory = model(vec![of_theory(100.0, &[1.0, 1.0])]);
    let candidates = Candidates {
        hits: dofs(&["1:+Z"]),
        sensors: Vec::new(),
    };
    let band = Band::new(10.0, 900.0).expect("10 is below 900");
    let frfs = receptances(&[("1:+Z", "1:+Z")], QUIET);
    let planned = |theory: &ModalModel, frfs: &[crate::frf::FrfSet]| {
        placement(
            theory,
            &ModalModel::default(),
            frfs,
            Some(band),
            &candidates,
        )
    };
    assert_eq!(planned(&theory, &[]), Err(NotAssessed::Variance));
    let mut other = theory.clone();
    other.modes[0].damping_ratio = None;
    assert_eq!(planned(&other, &frfs), Err(NotAssessed::DampingRatio));
    let mut other = theory;
    other.modes[0].scaling = crate::modal::Scaling::Unknown;
    assert_eq!(planned(&other, &frfs), Err(NotAssessed::ModalMass));
}
