//! The comparison table: rows, statuses, statistics and footnotes.

use crate::axis::Band;
use crate::modal::ModalModel;

use super::pairing_tests::{mode, model, shape};
use super::*;

/// A rigid-body mode, four elastic modes and a repeated root of two.
fn theory() -> ModalModel {
    let mut modes = vec![mode(0.0, &[1.0; 6])];
    modes
        .extend([(50.0, 1), (100.0, 2), (200.0, 3), (800.0, 4)].map(|(hz, n)| mode(hz, &shape(n))));
    modes.extend([mode(1000.0, &shape(1)), mode(1000.0, &shape(2))]);
    modes[5].group = Some(1);
    modes[6].group = Some(1);
    model(modes)
}

/// Misses the 100 Hz mode, has an extra at 150 Hz, is banded below 700 Hz.
fn hammer() -> ModalModel {
    let mut test = model(vec![
        mode(51.0, &shape(1)),
        mode(150.0, &shape(5)),
        mode(196.0, &shape(3)),
    ]);
    test.modes[0].frequency_std_hz = Some(0.1);
    test.modes[0].damping_ratio = Some(0.01);
    test.band = Some(Band::new(10.0, 700.0).unwrap());
    test
}

/// Without a band; sees the repeated root twice and an extra mode at 30 Hz.
fn shaker() -> ModalModel {
    let mut test = model(vec![
        mode(30.0, &shape(5)),
        mode(990.0, &shape(1)),
        mode(1020.0, &shape(2)),
    ]);
    for (mode, std) in test.modes.iter_mut().zip([1.0, 3.0, 4.0]) {
        mode.frequency_std_hz = Some(std);
        mode.damping_ratio = Some(0.01 * std);
    }
    test
}

/// One test, called `t`, before a theory.
fn table_of(theory: &ModalModel, test: &ModalModel) -> ComparisonTable {
    let options = PairOptions::default();
    let pairing = pair(test, theory, &options).expect("sound models");
    let tests = [PairedTest {
        name: "t",
        model: test,
        pairing: &pairing,
        frfs: &[],
    }];
    compare(theory, &tests, &options).expect("sound models")
}

fn table(error_reference: ErrorReference) -> ComparisonTable {
    let options = PairOptions {
        error_reference,
        ..PairOptions::default()
    };
    let (theory, hammer, shaker) = (theory(), hammer(), shaker());
    let pairings = [&hammer, &shaker].map(|test| pair(test, &theory, &options).unwrap());
    let tests = [
        PairedTest {
            name: "hammer",
            model: &hammer,
            pairing: &pairings[0],
            frfs: &[],
        },
        PairedTest {
            name: "shaker",
            model: &shaker,
            pairing: &pairings[1],
            frfs: &[],
        },
    ];
    compare(&theory, &tests, &options).unwrap()
}

fn close(got: Option<f64>, expected: f64) -> bool {
    got.is_some_and(|got| (got - expected).abs() < 1e-9)
}

#[test]
fn rows_are_the_roots_by_frequency_and_then_the_extra_modes() {
    let table = table(ErrorReference::Theory);
    let row = |row: &Row| {
        let theory = row.theory.as_ref().map_or(Vec::new(), |t| t.modes.clone());
        let status: Vec<Status> = row.tests.iter().map(|cell| cell.status).collect();
        (row.label.clone(), theory, status)
    };
    use Status::{Extra, MissedUnexpected, OutsideBand, Paired};
    let expected = [
        ("f1", vec![2], vec![Paired, MissedUnexpected]),
        ("f2", vec![3], vec![MissedUnexpected, MissedUnexpected]),
        ("f3", vec![4], vec![Paired, MissedUnexpected]),
        ("f4", vec![5], vec![OutsideBand, MissedUnexpected]),
        ("f5", vec![6, 7], vec![OutsideBand, Paired]),
        ("x1", vec![], vec![Extra]),
        ("x2", vec![], vec![Extra]),
    ]
    .map(|(label, modes, status)| (label.to_owned(), modes, status));
    assert_eq!(table.rows.iter().map(row).collect::<Vec<_>>(), expected);
    assert_eq!(
        (
            table.rows[5].tests[0].test.as_str(),
            table.rows[5].tests[0].hz
        ),
        ("shaker", Some(30.0))
    );
    assert_eq!(table.rows[6].tests[0].modes, [2]);
}

#[test]
fn cells_hold_the_numbers_of_their_modes_and_nothing_else() {
    let table = table(ErrorReference::Theory);
    let cell = &table.rows[0].tests[0];
    assert_eq!(
        (cell.modes.as_slice(), cell.hz, cell.hz_std),
        (&[1][..], Some(51.0), Some(0.1))
    );
    assert!(close(cell.error_percent, 2.0) && close(cell.error_hz, 1.0) && close(cell.mac, 1.0));
    assert_eq!((cell.damping_ratio, cell.damping_std), (Some(0.01), None));
    assert!(cell.angles_deg.is_none() && cell.reasons.is_empty());
    let missed = &table.rows[1].tests[0];
    assert!(missed.modes.is_empty() && missed.hz.is_none() && missed.mac.is_none());
    let why = "not judged: the test has no pairs of response and hit at which the model has shapes";
    assert_eq!(missed.reasons, [why]);
    assert!(!missed.is_status_certain());
    assert!(table.rows[3].tests[0].reasons[0].contains("10 to 700 Hz"));
    assert_eq!(table.rows[3].tests[1].reasons[0], "the test states no band");
}

#[test]
fn a_split_root_has_the_mean_of_its_test_modes_and_the_worst_of_their_errors() {
    let table = table(ErrorReference::Theory);
    let cell = &table.rows[4].tests[1];
    assert_eq!(cell.modes, [2, 3]);
    assert!(close(cell.hz, 1005.0) && close(cell.error_percent, 2.0));
    assert!(close(cell.error_hz, 20.0));
    assert!(cell.reasons[0].contains("split in the test, from 990.00 to 1020.00 Hz"));
    assert!(close(cell.hz_std, 2.5), "sqrt(9 + 16)/2");
    assert!(close(cell.damping_ratio, 0.035));
    assert_eq!(cell.angles_deg.as_ref().map(Vec::len), Some(2));
    assert!(table.footnotes.contains(&Footnote::RepeatedRoots));
}

#[test]
fn half_a_repeated_root_is_said() {
    let (theory, mut test) = (theory(), shaker());
    test.modes.pop();
    let table = table_of(&theory, &test);
    let reasons = &table.rows[4].tests[0].reasons;
    assert_eq!(*reasons, ["1 of the 2 modes of a repeated root"]);
}

#[test]
fn one_mode_twice_at_a_repeated_root_is_no_sure_pair() {
    let (theory, mut test) = (theory(), shaker());
    test.modes[2] = mode(1020.0, &shape(1));
    let table = table_of(&theory, &test);
    let cell = &table.rows[4].tests[0];
    assert_eq!(
        (cell.status, cell.modes.as_slice()),
        (Status::Ambiguous, &[2, 3][..])
    );
    assert!(
        cell.reasons[0].contains("they span 0 %"),
        "{:?}",
        cell.reasons
    );
}

#[test]
fn the_test_as_reference_turns_sign_and_denominator() {
    let table = table(ErrorReference::Test);
    let cell = &table.rows[2].tests[0];
    assert!(close(cell.error_percent, 100.0 * 4.0 / 196.0) && close(cell.error_hz, 4.0));
    assert_eq!(
        table.footnotes[0].to_string(),
        "Error = (theory - test)/test."
    );
}

#[test]
fn the_summary_counts_and_averages_what_the_rows_show() {
    let table = table(ErrorReference::Theory);
    let hammer = &table.summary[0];
    let counts = (
        hammer.paired,
        hammer.ambiguous,
        hammer.missed,
        hammer.outside_band,
        hammer.extra,
    );
    assert_eq!(counts, (2, 0, 1, 2, 1));
    assert!(close(hammer.max_error_percent, 2.0) && close(hammer.mean_error_percent, 2.0));
    assert!(close(hammer.rms_error_percent, 2.0) && close(hammer.min_mac, 1.0));
    assert_eq!((hammer.dofs_used, table.dofs_used), (6, 6));
    assert!(table.footnotes.contains(&Footnote::RigidBodyModesLeftOut {
        count: 1,
        highest_hz: 0.0
    }));
    assert!(table.footnotes.contains(&Footnote::ObservabilityUnknown));
}

#[test]
fn ambiguous_pairs_are_counted_beside_the_paired_ones() {
    let theory = model(vec![
        mode(100.0, &shape(1)),
        mode(300.0, &shape(2)),
        mode(900.0, &shape(4)[..2]),
    ]);
    // The first has two test modes that fit as well, the second one, the third two degrees of
    // freedom.
    let test = model(vec![
        mode(100.2, &shape(1)),
        mode(100.4, &shape(1)),
        mode(301.0, &shape(2)),
        mode(903.0, &shape(4)[..2]),
    ]);
    let summary = table_of(&theory, &test).summary.remove(0);
    let counts = (
        summary.paired,
        summary.paired_by_shape,
        summary.paired_by_frequency,
        summary.ambiguous,
    );
    assert_eq!(counts, (2, 1, 1, 1));
}

#[test]
fn root_mean_square_and_mean_differ_where_the_errors_do() {
    let theory = model(vec![mode(100.0, &[]), mode(200.0, &[])]);
    let test = model(vec![mode(101.0, &[]), mode(186.0, &[])]);
    let table = table_of(&theory, &test);
    let summary = &table.summary[0];
    assert!(close(summary.max_error_percent, 7.0) && close(summary.mean_error_percent, 4.0));
    assert!(close(summary.rms_error_percent, 5.0), "sqrt((1 + 49)/2)");
    assert_eq!((summary.min_mac, table.dofs_used), (None, 0));
    assert!(
        table
            .footnotes
            .contains(&Footnote::FrequencyAlone("t".to_owned()))
    );
}

#[test]
fn doubts_and_refusals_have_their_reason() {
    let theory = model(vec![mode(100.0, &shape(1)), mode(300.0, &shape(2))]);
    let twins = [100.2, 100.4].map(|hz| mode(hz, &shape(1)));
    let test = model([twins.to_vec(), vec![mode(301.0, &shape(3))]].concat());
    let table = table_of(&theory, &test);
    let cell = &table.rows[0].tests[0];
    let summary = &table.summary[0];
    assert_eq!(
        (cell.status, summary.ambiguous, summary.uncorrelated),
        (Status::Ambiguous, 1, 0)
    );
    assert_eq!(
        cell.reasons,
        ["test mode 2 at 100.40 Hz fits as well (cost by frequency error and MAC +0.001)"]
    );
    assert_eq!(
        table.rows[1].tests[0].reasons[0],
        "test mode 3 at 301.00 Hz has a MAC of 0.000, below 0.5"
    );
}

#[test]
fn a_foreign_pairing_and_a_repeated_name_are_refused() {
    let (theory, test, options) = (theory(), hammer(), PairOptions::default());
    let pairing = pair(&test, &theory, &options).unwrap();
    let entry = PairedTest {
        name: "t",
        model: &test,
        pairing: &pairing,
        frfs: &[],
    };
    assert!(matches!(
        compare(&theory, &[entry, entry], &options),
        Err(CorrelateError::DuplicateTest { name }) if name == "t"
    ));
    let other = shaker().modes.into_iter().take(2).collect();
    let other = PairedTest {
        model: &model(other),
        ..entry
    };
    let error = compare(&theory, &[other], &options).unwrap_err();
    assert!(matches!(
        error,
        CorrelateError::OtherPairing {
            got_test: 3,
            expected_test: 2,
            ..
        }
    ));
}

#[test]
fn statuses_are_written_as_in_the_comparison_file() {
    let text = serde_json::to_string(&[Status::MissedUnexpected, Status::OutsideBand]).unwrap();
    assert_eq!(text, r#"["missed-unexpected","outside-band"]"#);
}
