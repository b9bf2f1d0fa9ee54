use proptest::prelude::*;

use super::*;
use crate::theory::ModelRoot;

fn model(roots: &[(f64, usize)]) -> Vec<ModelRoot> {
    let root = |(omega_rad_s, multiplicity): &(f64, usize)| ModelRoot {
        modes: (0..*multiplicity).collect(),
        omega_rad_s: *omega_rad_s,
        kinetic_energy: Vec::new(),
        strain_energy: Vec::new(),
        class: None,
    };
    roots.iter().map(root).collect()
}

fn published(roots: &[(f64, usize)]) -> Vec<PublishedRoot> {
    let root = |(i, (omega_rad_s, multiplicity)): (usize, &(f64, usize))| PublishedRoot {
        label: format!("w{}", i + 1),
        omega_rad_s: *omega_rad_s,
        printed_hz: None,
        multiplicity: *multiplicity,
        class: None,
        calibrated: false,
    };
    roots.iter().enumerate().map(root).collect()
}

fn singles(roots: &[f64]) -> Vec<(f64, usize)> {
    roots.iter().map(|omega| (*omega, 1)).collect()
}

/// (model, published) of every row, 0 where there is none.
fn pairs(result: &RootMatch) -> Vec<(f64, f64)> {
    let of = |row: &RootRow| {
        (
            row.model.as_ref().map_or(-1.0, |root| root.omega_rad_s),
            row.published.as_ref().map_or(-1.0, |root| root.omega_rad_s),
        )
    };
    result.rows.iter().map(of).collect()
}

fn matched(model_roots: &[f64], printed: &[f64]) -> Vec<(f64, f64)> {
    let (computed, printed) = (model(&singles(model_roots)), published(&singles(printed)));
    pairs(&match_roots(&computed, &printed, &MatchOptions::default()))
}

#[test]
fn a_root_that_is_missing_on_one_side_does_not_shift_the_others() {
    let printed = [100.0, 103.0, 110.0, 120.0];
    assert_eq!(
        matched(&[100.5, 110.5, 120.5], &printed),
        [
            (100.5, 100.0),
            (-1.0, 103.0),
            (110.5, 110.0),
            (120.5, 120.0)
        ]
    );
    assert_eq!(
        matched(&[100.5, 103.5, 106.0, 110.5, 120.5], &printed),
        [
            (100.5, 100.0),
            (103.5, 103.0),
            (106.0, -1.0),
            (110.5, 110.0),
            (120.5, 120.0)
        ]
    );
}

#[test]
fn a_list_in_another_order_gives_the_same_rows() {
    let ascending = matched(&[90.0, 100.0, 110.0], &[91.0, 101.0, 111.0]);
    assert_eq!(
        matched(&[110.0, 90.0, 100.0], &[101.0, 111.0, 91.0]),
        ascending
    );
}

#[test]
fn roots_that_are_all_a_little_low_are_paired_in_order() {
    // Every way of pairing these has the same sum of distances; one of them crosses.
    assert_eq!(
        matched(&[99.0, 100.0, 101.0], &[100.0, 101.0, 102.0]),
        [(99.0, 100.0), (100.0, 101.0), (101.0, 102.0)]
    );
}

#[test]
fn zero_goes_with_zero_alone_and_has_no_error() {
    let computed = model(&[(0.0, 2), (50.0, 1)]);
    let printed = published(&[(0.0, 2), (0.001, 1)]);
    let result = match_roots(&computed, &printed, &MatchOptions::default());
    assert_eq!(pairs(&result), [(0.0, 0.0), (-1.0, 0.001), (50.0, -1.0)]);
    assert_eq!(result.rows[0].error_percent, None);
    assert_eq!((result.simple, result.elastic), (None, None));
}

#[test]
fn roots_further_apart_than_the_gate_stay_alone() {
    let (computed, printed) = (model(&[(106.0, 1)]), published(&[(100.0, 1)]));
    for (gate, rows) in [(0.05, 2), (0.059, 2), (0.061, 1)] {
        let options = MatchOptions {
            max_frequency_error: gate,
        };
        assert_eq!(
            match_roots(&computed, &printed, &options).rows.len(),
            rows,
            "{gate}"
        );
    }
}

#[test]
fn different_multiplicities_are_reported_and_are_no_single_roots() {
    let computed = model(&[(100.0, 3), (202.0, 1), (297.0, 2)]);
    let printed = published(&[(100.0, 2), (200.0, 1), (300.0, 1)]);
    let result = match_roots(&computed, &printed, &MatchOptions::default());
    let same: Vec<_> = result.rows.iter().map(RootRow::same_multiplicity).collect();
    assert_eq!(same, [Some(false), Some(true), Some(false)]);
    let simple = result.simple.unwrap();
    assert_eq!((simple.count, simple.largest_at.as_str()), (1, "w2"));
    assert!((simple.rms_percent - 1.0).abs() < 1e-12);
    assert_eq!(result.elastic.unwrap().count, 3);
}

#[test]
fn errors_are_relative_to_the_print_and_the_largest_keeps_its_sign() {
    let computed = model(&singles(&[103.0, 196.0]));
    let result = match_roots(
        &computed,
        &published(&singles(&[100.0, 200.0])),
        &MatchOptions::default(),
    );
    let summary = result.simple.unwrap();
    assert!((result.rows[1].error_percent.unwrap() + 2.0).abs() < 1e-12);
    assert!((summary.rms_percent - 6.5f64.sqrt()).abs() < 1e-12);
    assert!((summary.largest_percent - 3.0).abs() < 1e-12);
    assert_eq!(summary.largest_at, "w1");
    let low = match_roots(
        &computed,
        &published(&singles(&[102.0, 200.0])),
        &MatchOptions::default(),
    );
    assert!((low.simple.unwrap().largest_percent + 2.0).abs() < 1e-12);
}

#[test]
fn no_roots_on_either_side_is_an_answer() {
    let none = match_roots(&[], &[], &MatchOptions::default());
    assert_eq!(none, RootMatch::default());
    let printed = published(&singles(&[1.0, 2.0]));
    assert_eq!(
        match_roots(&[], &printed, &MatchOptions::default())
            .rows
            .len(),
        2
    );
}

proptest! {
    #[test]
    fn every_root_of_both_sides_is_in_one_row_and_rows_ascend_on_both(
        computed in proptest::collection::vec(0.0..300.0f64, 0..9),
        printed in proptest::collection::vec(0.0..300.0f64, 0..9),
    ) {
        let result = match_roots(&model(&singles(&computed)), &published(&singles(&printed)), &MatchOptions::default());
        prop_assert_eq!(result.model().count(), computed.len());
        prop_assert_eq!(result.published().count(), printed.len());
        let both: Vec<_> = result.rows.iter().filter(|row| row.model.is_some() && row.published.is_some()).collect();
        let omega = |row: &&RootRow| row.model.as_ref().unwrap().omega_rad_s;
        prop_assert!(both.windows(2).all(|pair| omega(&pair[0]) <= omega(&pair[1])));
        prop_assert!(both.iter().all(|row| row.error_percent.is_none_or(|error| error.abs() < 5.0 + 1e-9)));
    }
}
