//! What a test could see of a root: strength, noise, the Cramér-Rao bound, and what the table makes
//! of it.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::frf::{FrfSet, Function, FunctionData};
use crate::linalg::{least_squares_real, real_matrix};
use crate::modal::{ModalModel, Mode, Pole, Scaling};
use crate::quantity::FrfKind;

use super::pairing_tests::{mode, model};
use super::*;

const ZETA: f64 = 0.01;

/// A mode of a theory: unit modal mass, 1 % damping.
pub(super) fn of_theory(frequency_hz: f64, shape: &[f64]) -> Mode {
    let mut mode = mode(frequency_hz, shape);
    mode.scaling = Scaling::UnitModalMass;
    mode.damping_ratio = Some(ZETA);
    mode
}

fn pairs(text: &[(&str, &str)]) -> Vec<(Dof, Dof)> {
    let dof = |text: &str| text.parse().unwrap();
    text.iter().map(|pair| (dof(pair.0), dof(pair.1))).collect()
}

/// FRFs on lines of `step_hz` up to 1000 Hz with one variance everywhere.
pub(super) fn frfs(
    text: &[(&str, &str)],
    kind: FrfKind,
    variance: Option<f64>,
    step_hz: f64,
) -> Vec<FrfSet> {
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz,
        len: (1000.0 / step_hz) as usize,
    };
    let mut set = FrfSet::new(axis);
    for (response, reference) in pairs(text) {
        let function = Function {
            response,
            reference,
            kind,
            averages: Some(5),
            estimator: None,
            variance_dof: None,
        };
        let data = FunctionData {
            values: vec![Complex64::ZERO; axis.len],
            variance: variance.map(|v| vec![v; axis.len]),
            coherence: None,
        };
        set.push(function, data).unwrap();
    }
    vec![set]
}

pub(super) fn receptances(text: &[(&str, &str)], variance: f64) -> Vec<FrfSet> {
    frfs(text, FrfKind::Receptance, Some(variance), 0.5)
}

fn compared(theory: &ModalModel, test: &ModalModel, frfs: &[FrfSet]) -> ComparisonTable {
    let options = PairOptions::default();
    let pairing = pair(test, theory, &options).unwrap();
    let tests = [PairedTest {
        name: "t",
        model: test,
        pairing: &pairing,
        frfs,
    }];
    compare(theory, &tests, &options).unwrap()
}

fn statuses(table: &ComparisonTable) -> Vec<Status> {
    table.rows.iter().map(|row| row.tests[0].status).collect()
}

fn reason(table: &ComparisonTable, row: usize) -> String {
    table.rows[row].tests[0].reasons.join("; ")
}

/// Three roots; the second stands still at point 2 and moves at 1, 3.
fn three() -> ModalModel {
    model(vec![
        of_theory(100.0, &[1.0, 1.0, 1.0]),
        of_theory(200.0, &[1.0, 0.0, -1.0]),
        of_theory(400.0, &[1.0, -2.0, 1.0]),
    ])
}

/// The first and third root as a test of points 1 to 3 finds them.
fn two_found() -> ModalModel {
    model(vec![
        mode(100.0, &[1.0, 1.0, 1.0]),
        mode(400.0, &[1.0, -2.0, 1.0]),
    ])
}

/// |g|/(2 zeta w^2) squared, for g = 1 at 200 Hz.
fn peak_squared_at_200() -> f64 {
    (2.0 * ZETA * (TAU * 200.0).powi(2)).recip().powi(2)
}

#[test]
fn sensors_on_the_node_of_a_mode_cannot_see_it() {
    let quiet = 1e-9 * peak_squared_at_200();
    let mut theory = three();
    theory.modes[1].shape = mode(0.0, &[1.0, 1e-15, -1.0]).shape;
    let frfs = receptances(&[("2:-Z", "2:+Z")], quiet);
    let table = compared(&theory, &two_found(), &frfs);
    use Status::{NotObservable, Paired};
    assert_eq!(statuses(&table), [Paired, NotObservable, Paired]);
    assert_eq!(
        reason(&table, 1),
        "the test states no band; every sensor or hit stands still in this root"
    );
    let known = table.rows[1].tests[0].observability.as_ref().unwrap();
    assert!(known.at_nodes && (known.pairs, known.pairs_in_theory) == (1, 1));
    let summary = &table.summary[0];
    assert_eq!((summary.missed, summary.not_observable), (0, 1));
    assert!(!table.footnotes.contains(&Footnote::ObservabilityUnknown));
}

#[test]
fn a_hit_on_the_node_hides_the_mode_although_the_sensors_move() {
    let quiet = 1e-9 * peak_squared_at_200();
    let hit_at = |reference| {
        let table = compared(
            &three(),
            &two_found(),
            &receptances(&[("1:+Z", reference), ("3:+Z", reference)], quiet),
        );
        statuses(&table)[1]
    };
    assert_eq!(hit_at("2:+Z"), Status::NotObservable);
    assert_eq!(hit_at("1:+Z"), Status::MissedUnexpected);
}

#[test]
fn residues_of_the_test_name_the_pairs_where_there_are_no_frfs() {
    let mut test = two_found();
    let judged = |test: &ModalModel| observability(&three(), test, &[])[1].clone();
    assert_eq!(judged(&test), None);
    let residue = |text| (pairs(text).remove(0), Complex64::I);
    test.modes[0].residues = [residue(&[("1:+Z", "2:+Z")])].into();
    assert!(judged(&test).unwrap().at_nodes);
    test.modes[1].residues = [residue(&[("1:+Z", "3:+Z#2")])].into();
    let moving = judged(&test).unwrap();
    assert_eq!((moving.at_nodes, moving.pairs), (false, 2));
    assert_eq!(moving.noise, Err(NotAssessed::Variance));
    let table = compared(&three(), &test, &[]);
    assert_eq!(statuses(&table)[1], Status::MissedUnexpected);
    assert!(table.footnotes.contains(&Footnote::ObservabilityUnknown));
    assert!(reason(&table, 1).ends_with("the test has no FRF with a variance there"));
}

#[test]
fn a_peak_is_seen_from_ten_decibels_over_the_noise_in_every_kind() {
    for (kind, order) in [
        (FrfKind::Receptance, 0),
        (FrfKind::Mobility, 1),
        (FrfKind::Accelerance, 2),
    ] {
        let peak = peak_squared_at_200() * (TAU * 200.0).powi(2 * order);
        let at = |db: f64| {
            let variance = Some(peak / 10f64.powf(db / 10.0));
            let sets = frfs(&[("1:+Z", "1:+Z"), ("1:+Z", "2:+Z")], kind, variance, 0.5);
            compared(&three(), &two_found(), &sets)
        };
        // 0.02 dB is 0.2 % of the amplitude: a kind converted with a power of w too many is 60 dB
        // off.
        let (below, above) = (at(9.99), at(10.01));
        assert_eq!(statuses(&below)[1], Status::NotObservable, "{kind:?}");
        assert_eq!(statuses(&above)[1], Status::MissedUnexpected, "{kind:?}");
        let cell = at(3.1);
        assert!(
            reason(&cell, 1).ends_with(
                "from 1:+Z to 1:+Z its peak would stand 3.1 dB over the noise, 10 dB are needed"
            ),
            "{}",
            reason(&cell, 1)
        );
        assert!(!above.footnotes.contains(&Footnote::ObservabilityUnknown));
    }
}

#[test]
fn noise_counts_where_the_peak_is() {
    let mut sets = receptances(&[("1:+Z", "1:+Z")], peak_squared_at_200() / 100.0);
    let judged = |sets: &[FrfSet]| {
        let known = observability(&three(), &two_found(), sets)[1]
            .clone()
            .unwrap();
        known.noise.unwrap().peak_over_noise_db
    };
    assert!((judged(&sets) - 20.0).abs() < 1e-9);
    // The half-power band is 198 to 202 Hz: 9 lines, the mean of which is 10 of 9 with one of them
    // doubled.
    let with_line = |hz: f64, factor: f64| {
        let mut changed = FrfSet::new(*sets[0].axis());
        let mut data = FunctionData {
            values: sets[0].values(0).to_vec(),
            variance: sets[0].variance(0).map(<[f64]>::to_vec),
            coherence: None,
        };
        data.variance.as_mut().unwrap()[(2.0 * hz) as usize] *= factor;
        changed.push(sets[0].functions()[0].clone(), data).unwrap();
        judged(&[changed])
    };
    assert!((with_line(202.5, 2.0) - 20.0).abs() < 1e-9);
    let expected = 20.0 - 10.0 * (10f64 / 9.0).log10();
    assert!((with_line(202.0, 2.0) - expected).abs() < 1e-9);
    assert!((with_line(198.0, 2.0) - expected).abs() < 1e-9);
    // The window's 20 rad/s lower and widen the peak: zeta w is 12.57 rad/s.
    sets[0].added_damping_rad_s = 20.0;
    let delta = ZETA * TAU * 200.0;
    let lower = 20.0 * (delta / (delta + 20.0)).log10();
    assert!((judged(&sets) - 20.0 - lower).abs() < 1e-9);
}

#[test]
fn without_noise_everything_that_moves_is_seen() {
    let table = compared(
        &three(),
        &two_found(),
        &receptances(&[("1:+Z", "1:+Z")], 0.0),
    );
    assert_eq!(statuses(&table)[1], Status::MissedUnexpected);
    let known = table.rows[1].tests[0].observability.as_ref().unwrap();
    let noise = known.noise.as_ref().unwrap();
    assert!(noise.peak_over_noise_db.is_infinite() && noise.frequency_std_hz <= 0.0);
}

/// The variance of Im lambda in the inverse of the Fisher matrix of (Re A, Im A, Re lambda, Im
/// lambda), summed over the lines of an axis; A in units of |A| and lambda in units of its real
/// part, so that the matrix is well scaled.
fn variance_of_im_lambda(
    a: Complex64,
    lambda: Complex64,
    axis: &FrequencyAxis,
    variance: impl Fn(f64) -> f64,
) -> f64 {
    let mut fisher = [[0.0; 4]; 4];
    for k in 0..axis.len {
        let d = (Complex64::new(0.0, axis.rad_s(k)) - lambda).inv();
        let (of_a, of_lambda) = (a.norm() * d, lambda.re * a * d * d);
        let slopes = [
            of_a,
            Complex64::I * of_a,
            of_lambda,
            Complex64::I * of_lambda,
        ];
        for (row, left) in fisher.iter_mut().zip(slopes) {
            for (entry, right) in row.iter_mut().zip(slopes) {
                *entry += 2.0 * (left.conj() * right).re / variance(axis.rad_s(k));
            }
        }
    }
    let matrix = real_matrix(4, 4, |i, j| fisher[i][j]);
    let column = least_squares_real(&matrix, &[0.0, 0.0, 0.0, 1.0]).unwrap();
    column[3] * lambda.re * lambda.re
}

#[test]
fn the_bound_on_the_frequency_is_that_of_the_fisher_matrix_over_the_lines() {
    let theory = model(vec![of_theory(500.0, &[0.7, 1.0])]);
    let pole = Pole::from_frequency(500.0, ZETA);
    let omega = TAU * 500.0;
    let cases = [(FrfKind::Receptance, 0), (FrfKind::Accelerance, 2)];
    for (kind, order) in cases {
        let variance = 1e-18 * omega.powi(2 * order);
        let sets = frfs(&[("1:+Z", "2:+Z")], kind, Some(variance), 0.625);
        let known = observability(&theory, &model(vec![]), &sets)[0]
            .clone()
            .unwrap();
        let std_hz = known.noise.unwrap().frequency_std_hz;
        let a = Complex64::new(0.0, -0.7 / (2.0 * pole.lambda.im));
        let as_receptance = |w: f64| match order {
            0 => variance,
            _ => variance / w.max(1.0).powi(2 * order),
        };
        let exact = variance_of_im_lambda(a, pole.lambda, sets[0].axis(), as_receptance);
        // Lines end at 0 and 2 w: the information on A, pi/(zeta w), lacks the two ends of 1/x^2,
        // 2/w, and where receptance noise falls as 1/w^4 has the integral of ((1 + u)^4 - 1)/u^2
        // more, 38/3. The bound has as much more information on lambda; the same expansion to
        // second order takes off the square of that and 22 zeta^2 (0 for receptance).
        let (more, second) = if order == 0 {
            (0.0, 0.0)
        } else {
            (38.0 / 3.0, 22.0)
        };
        let first = (more - 2.0) * ZETA / PI;
        let expected = 1.0 + first - first * first - second * ZETA * ZETA;
        let ratio = (TAU * std_hz).powi(2) / exact;
        assert!(
            (ratio - expected).abs() < 2e-4,
            "{kind:?} {ratio} {expected}"
        );
    }
}

#[test]
fn pairs_add_their_information_on_the_frequency() {
    let theory = model(vec![of_theory(500.0, &[1.0, 1.0, 0.5])]);
    let std_hz = |text: &[(&str, &str)]| {
        let sets = receptances(text, 1e-18);
        let known = observability(&theory, &model(vec![]), &sets)[0]
            .clone()
            .unwrap();
        known.noise.unwrap().frequency_std_hz
    };
    let one = std_hz(&[("1:+Z", "1:+Z")]);
    let more = std_hz(&[("1:+Z", "1:+Z"), ("2:+Z", "1:+Z"), ("3:+Z", "1:+Z")]);
    assert!((more / one - 2.25f64.sqrt().recip()).abs() < 1e-12);
    let delta = ZETA * TAU * 500.0;
    let peak_squared = (2.0 * delta * TAU * 500.0).recip().powi(2);
    let by_hand = (2.0 * 1e-18 * TAU * 0.5 * delta / (PI * peak_squared)).sqrt() / TAU;
    assert!((one / by_hand - 1.0).abs() < 1e-12);
}

/// A root `widths` half-power bandwidths (4 Hz) above the one at 200 Hz, which the test has.
fn neighbour(widths: f64, frfs: &[FrfSet]) -> ComparisonTable {
    let theory = model(vec![
        of_theory(200.0, &[1.0, 1.0, 1.0]),
        of_theory(200.0 + 4.0 * widths, &[1.0, 0.0, -1.0]),
        of_theory(400.0, &[1.0, -2.0, 1.0]),
    ]);
    let mut test = two_found();
    test.modes[0].frequency_hz = 200.1;
    compared(&theory, &test, frfs)
}

#[test]
fn one_peak_excuses_a_root_that_a_paired_one_covers() {
    let quiet = receptances(&[("1:+Z", "1:+Z")], 1e-6 * peak_squared_at_200());
    let near = neighbour(0.3, &quiet);
    use Status::{MissedExpected, MissedUnexpected, NotObservable, Paired};
    assert_eq!(statuses(&near), [Paired, MissedExpected, Paired]);
    assert!(
        reason(&near, 1).ends_with(
            "one peak covers it and the paired root at 200.00 Hz, 0.30 half-power bandwidths away"
        ),
        "{}",
        reason(&near, 1)
    );
    assert_eq!(near.summary[0].missed, 1);
    assert_eq!(statuses(&neighbour(1.1, &quiet))[1], MissedUnexpected);
    // 12 dB with a line each 2 Hz: sqrt(2 * 2 * 2.01/(pi * 15.85)) = 0.40 Hz, a quarter of 1.2 Hz
    // is 0.3 Hz.
    let variance = Some(peak_squared_at_200() / 10f64.powf(1.2));
    let coarse = frfs(&[("1:+Z", "1:+Z")], FrfKind::Receptance, variance, 2.0);
    let table = neighbour(0.3, &coarse);
    assert_eq!(statuses(&table)[1], NotObservable);
    assert!(
        reason(&table, 1).contains("its frequency could be known to 0.40"),
        "{}",
        reason(&table, 1)
    );
    assert_eq!(statuses(&neighbour(0.45, &coarse))[1], MissedExpected);
}

/// A repeated root at 200 Hz whose two modes are turned against each other by an angle.
fn repeated(angle: f64, at_3: [f64; 2]) -> ModalModel {
    let (c, s) = (angle.cos(), angle.sin());
    let (u, v) = ([1.0, 0.0, at_3[0]], [0.0, 1.0, at_3[1]]);
    let turned = |a: f64, b: f64| [0, 1, 2].map(|p| a * u[p] + b * v[p]);
    let mut modes = vec![
        of_theory(100.0, &[1.0, 1.0, 1.0]),
        of_theory(200.0, &turned(c, s)),
        of_theory(200.0, &turned(-s, c)),
    ];
    modes[1].group = Some(1);
    modes[2].group = Some(1);
    model(modes)
}

#[test]
fn a_repeated_root_is_seen_alike_in_every_basis() {
    let sets = receptances(&[("3:+Z", "1:+Z"), ("3:+Z", "2:+Z")], 1e-14);
    let decibels = |angle| {
        let known = observability(&repeated(angle, [0.8, 0.3]), &model(vec![]), &sets);
        known[1].clone().unwrap().noise.unwrap().peak_over_noise_db
    };
    assert!((decibels(0.0) - decibels(1.1)).abs() < 1e-9);
    // Point 1 moves in one mode and point 2 in the other: together they see nothing, in any basis.
    let apart = receptances(&[("1:+Z", "2:+Z")], 1e-14);
    for angle in [0.0, 1.1] {
        let known = observability(&repeated(angle, [0.8, 0.3]), &model(vec![]), &apart);
        assert!(known[1].as_ref().unwrap().at_nodes, "{known:?}");
    }
}

#[test]
fn a_repeated_root_that_is_zero_at_the_sensors_is_not_observable() {
    let test = model(vec![mode(100.0, &[1.0, 1.0, 1.0])]);
    let sets = receptances(&[("3:+Z", "3:+Z")], 0.0);
    let table = compared(&repeated(0.4, [0.0, 0.0]), &test, &sets);
    assert_eq!(statuses(&table), [Status::Paired, Status::NotObservable]);
    assert!(
        table.rows[1].tests[0]
            .observability
            .as_ref()
            .unwrap()
            .at_nodes
    );
}

#[test]
fn a_rigid_body_mode_shows_that_the_points_do_not_stand_still_by_themselves() {
    // Of an only root nothing but its rigid-body modes tells a node from a small shape.
    let theory = model(vec![
        of_theory(0.0, &[1.0, 1.0]),
        of_theory(100.0, &[1e-15, 1.0]),
    ]);
    let sets = receptances(&[("1:+Z", "1:+Z")], 0.0);
    let known = observability(&theory, &model(vec![]), &sets);
    assert!(known.len() == 1 && known[0].as_ref().unwrap().at_nodes);
}

#[test]
fn a_shape_unknown_at_some_pairs_is_no_reason_for_an_unmatched_mode() {
    let judged = |text: &[(&str, &str)]| {
        let table = compared(&three(), &two_found(), &receptances(text, 1e-30));
        (statuses(&table)[1], reason(&table, 1))
    };
    let (status, why) = judged(&[("2:+Z", "2:+Z"), ("9:+X", "2:+Z")]);
    assert_eq!(status, Status::MissedUnexpected);
    assert!(
        why.ends_with("not every pair of the test could be judged"),
        "{why}"
    );
    let (status, why) = judged(&[("9:+X", "2:+Z")]);
    assert_eq!(status, Status::MissedUnexpected);
    assert!(why.contains("not judged: the test has no pairs"), "{why}");
}

#[test]
fn the_median_damping_of_the_test_stands_in_and_is_said() {
    let mut theory = three();
    theory.modes.iter_mut().for_each(|m| m.damping_ratio = None);
    let mut test = two_found();
    let sets = receptances(&[("1:+Z", "1:+Z")], 1e-30);
    let undamped = compared(&theory, &test, &sets);
    assert!(reason(&undamped, 1).ends_with("no damping ratio is known"));
    assert!(undamped.footnotes.contains(&Footnote::ObservabilityUnknown));
    test.modes[0].damping_ratio = Some(0.02);
    test.modes[1].damping_ratio = Some(0.03);
    let table = compared(&theory, &test, &sets);
    let note = Footnote::DampingOfTest {
        test: "t".to_owned(),
        ratio: 0.025,
    };
    assert!(table.footnotes.contains(&note), "{:?}", table.footnotes);
    assert!(note.to_string().contains("2.500 %"));
    assert!(!table.footnotes.contains(&Footnote::ObservabilityUnknown));
    let table = compared(&three(), &test, &sets);
    assert!(
        !table
            .footnotes
            .iter()
            .any(|note| matches!(note, Footnote::DampingOfTest { .. }))
    );
}

#[test]
fn without_modal_masses_only_standing_still_is_judged() {
    let mut theory = three();
    theory
        .modes
        .iter_mut()
        .for_each(|m| m.scaling = Scaling::UnitMax);
    let judged = |text: &[(&str, &str)]| {
        observability(&theory, &two_found(), &receptances(text, 1e30))[1]
            .clone()
            .unwrap()
    };
    let moving = judged(&[("1:+Z", "1:+Z")]);
    assert_eq!(
        (moving.observable(), moving.noise),
        (None, Err(NotAssessed::ModalMass))
    );
    assert_eq!(judged(&[("2:+Z", "1:+Z")]).observable(), Some(false));
}

#[test]
fn a_pair_without_a_shape_where_the_model_leaves_the_frfs_still_contradicts_the_model() {
    let test = model(vec![mode(201.0, &[]), mode(100.0, &[1.0, 1.0, 1.0])]);
    let table = compared(&three(), &test, &receptances(&[("2:+Z", "2:+Z")], 1e-30));
    let cell = &table.rows[1].tests[0];
    assert_eq!((cell.status, cell.mac), (Status::Paired, None));
    assert!(
        reason(&table, 1).contains("rests on frequency alone and contradicts the model"),
        "{}",
        reason(&table, 1)
    );
    let alone = Footnote::FrequencyAlone("t".to_owned());
    assert!(table.footnotes.contains(&alone));
}
