use super::*;
use crate::correlate::ErrorReference;
use crate::theory::{ModelQuantity, ModelRoot, Support};

fn row(label: &str, root: Option<&str>, theory_hz: f64, tests: &[(&str, f64)]) -> PublishedRow {
    let cell = |(name, hz): &(&str, f64)| ((*name).to_owned(), *hz);
    PublishedRow {
        label: label.to_owned(),
        root: root.map(str::to_owned),
        theory_hz,
        tests: tests.iter().map(cell).collect(),
    }
}

/// Errors of a: -10 Hz (-10 %) at f1, +15 Hz (+7.5 %) at f2; of b: none at f1, -8 Hz (-4 %) at f2.
fn table() -> PublishedComparison {
    PublishedComparison {
        tests: vec!["a".to_owned(), "b".to_owned()],
        error_reference: ErrorReference::Theory,
        row: vec![
            row("f1", Some("w1"), 100.0, &[("a", 90.0)]),
            row("f2", Some("w2"), 200.0, &[("a", 215.0), ("b", 192.0)]),
            row("f3", None, 400.0, &[]),
        ],
    }
}

/// w1 = 2 pi 100.4 single, w2 = 2 pi 200.6 double; the model has both, each single, and a third.
fn roots() -> RootMatch {
    let tau = std::f64::consts::TAU;
    let printed =
        [("w1", 100.4, 1), ("w2", 200.6, 2)].map(|(label, hz, multiplicity)| PublishedRoot {
            label: label.to_owned(),
            omega_rad_s: tau * hz,
            printed_hz: None,
            multiplicity,
            class: None,
            calibrated: false,
        });
    let model = [100.0, 200.0, 300.0].map(|hz| ModelRoot {
        modes: vec![0],
        omega_rad_s: tau * hz,
        kinetic_energy: Vec::new(),
        strain_energy: Vec::new(),
        class: None,
    });
    match_roots(&model, &printed, &MatchOptions::default())
}

fn evidence(roots: &RootMatch) -> Evidence<'_> {
    Evidence {
        roots: Some(roots),
        quantities: &[],
        support: Some(Support::Fixed),
    }
}

fn judge(statement: Statement, decimals: usize) -> Vec<ClaimVerdict> {
    let claim = Claim {
        text: "as claimed".to_owned(),
        statement,
        digits: Digits::Decimals(decimals),
        remark: None,
    };
    audit(&table(), &evidence(&roots()), &[claim])
}

fn confirmed(statement: Statement, decimals: usize) -> Option<bool> {
    let verdicts = judge(statement, decimals);
    assert_eq!(verdicts.len(), 1);
    verdicts[0].confirmed
}

fn largest(unit: ErrorUnit, test: &str, row: &str, value: f64) -> Statement {
    let (test, row) = (test.to_owned(), row.to_owned());
    Statement::LargestError(ErrorClaim {
        unit,
        test,
        row,
        value,
    })
}

fn error_at(unit: ErrorUnit, test: &str, row: &str, value: f64) -> Statement {
    let (test, row) = (test.to_owned(), row.to_owned());
    Statement::ErrorAt(ErrorClaim {
        unit,
        test,
        row,
        value,
    })
}

fn missed(test: &str, rows: &[&str]) -> Statement {
    Statement::Missed {
        test: test.to_owned(),
        rows: rows.iter().map(|row| (*row).to_owned()).collect(),
    }
}

#[test]
fn a_largest_error_needs_its_value_and_its_row() {
    use ErrorUnit::{Hz, Percent};
    assert_eq!(confirmed(largest(Hz, "a", "f2", 15.0), 0), Some(true));
    assert_eq!(confirmed(largest(Hz, "a", "f2", 14.0), 0), Some(false));
    assert_eq!(confirmed(largest(Hz, "a", "f1", 15.0), 0), Some(false));
    assert_eq!(confirmed(largest(Percent, "a", "f1", 10.0), 0), Some(true));
    // 7.5 % at f2 is right, and is not the largest.
    let at_f2 = &judge(largest(Percent, "a", "f2", 7.5), 1)[0];
    assert_eq!(at_f2.confirmed, Some(false));
    let found = at_f2
        .recomputed
        .clone()
        .expect("a claim that can be recomputed");
    assert!(
        (found.value.expect("a value of the claim") - 10.0).abs() < 1e-12 && found.rows == ["f1"]
    );
    assert_eq!(confirmed(error_at(Percent, "a", "f2", 7.5), 1), Some(true));
}

#[test]
fn rows_that_share_the_largest_error_are_all_where_it_is() {
    let mut table = table();
    table.row[0].tests.insert("a".to_owned(), 115.0);
    let claim = |row: &str| Claim {
        text: String::new(),
        statement: largest(ErrorUnit::Hz, "a", row, 15.0),
        digits: Digits::Decimals(0),
        remark: None,
    };
    let verdicts = audit(
        &table,
        &Evidence::default(),
        &[claim("f1"), claim("f2"), claim("f3")],
    );
    let all: Vec<_> = verdicts.iter().map(|verdict| verdict.confirmed).collect();
    assert_eq!(all, [Some(true), Some(true), Some(false)]);
}

#[test]
fn an_error_at_a_row_is_a_magnitude_that_rounds_to_the_print() {
    use ErrorUnit::{Hz, Percent};
    assert_eq!(confirmed(error_at(Hz, "b", "f2", 8.0), 0), Some(true));
    assert_eq!(confirmed(error_at(Hz, "b", "f2", 8.1), 1), Some(false));
    assert_eq!(confirmed(error_at(Percent, "b", "f2", 4.4), 0), Some(true));
    assert_eq!(confirmed(error_at(Percent, "b", "f2", 4.6), 0), Some(false));
    // A tie rounds to either side.
    assert_eq!(confirmed(error_at(Percent, "a", "f2", 8.0), 0), Some(true));
    assert_eq!(confirmed(error_at(Percent, "a", "f2", 7.0), 0), Some(true));
    assert_eq!(confirmed(error_at(Hz, "b", "f1", 8.0), 0), None, "missed");
}

#[test]
fn the_rows_missed_are_these_in_any_order_and_no_other() {
    assert_eq!(confirmed(missed("b", &["f3", "f1"]), 0), Some(true));
    assert_eq!(confirmed(missed("b", &["f1"]), 0), Some(false));
    assert_eq!(confirmed(missed("a", &["f1", "f3"]), 0), Some(false));
    assert_eq!(confirmed(missed("c", &[]), 0), None, "no such test");
}

#[test]
fn roots_are_counted_in_the_print_and_in_the_model() {
    use RootSide::{Model, Printed};
    for (side, single, total, second) in [(Printed, 1.0, 3.0, 2.0), (Model, 3.0, 3.0, 1.0)] {
        for (add, verdict) in [(0.0, Some(true)), (1.0, Some(false))] {
            let value = single + add;
            assert_eq!(
                confirmed(Statement::SingleRoots { side, value }, 0),
                verdict
            );
            let value = total + add;
            assert_eq!(confirmed(Statement::TotalRoots { side, value }, 0), verdict);
            let (row, value) = ("w2".to_owned(), second + add);
            let multiplicity = Statement::Multiplicity { side, row, value };
            assert_eq!(confirmed(multiplicity, 0), verdict);
        }
    }
}

#[test]
fn the_theory_column_is_confirmed_or_refuted_by_rounding() {
    // 100.4 rounds to 100, 200.6 does not round to 200; f3 names no root.
    let verdicts = judge(Statement::TheoryColumn, 0);
    let confirmed: Vec<_> = verdicts
        .iter()
        .map(|v| {
            (
                v.confirmed,
                v.recomputed
                    .clone()
                    .expect("a claim that can be recomputed")
                    .rows,
            )
        })
        .collect();
    let label = |name: &str| vec![name.to_owned()];
    assert_eq!(
        confirmed,
        [(Some(true), label("f1")), (Some(false), label("f2"))]
    );
    let recomputed = verdicts[1]
        .recomputed
        .as_ref()
        .expect("a claim that can be recomputed")
        .value
        .expect("a value of the claim");
    assert!((recomputed - 200.6).abs() < 1e-9);
    assert_eq!(
        judge(Statement::TheoryColumn, 1).len(),
        2,
        "neither has a digit more"
    );
}

#[test]
fn without_roots_a_claim_about_roots_has_no_verdict() {
    let side = RootSide::Printed;
    for statement in [
        Statement::SingleRoots { side, value: 0.0 },
        Statement::TotalRoots { side, value: 0.0 },
        Statement::TheoryColumn,
    ] {
        let claim = Claim {
            text: String::new(),
            statement,
            digits: Digits::Decimals(0),
            remark: None,
        };
        let verdicts = audit(&table(), &Evidence::default(), &[claim]);
        assert_eq!(verdicts.len(), 1);
        assert_eq!(
            (verdicts[0].confirmed, &verdicts[0].recomputed),
            (None, &None)
        );
    }
}

#[test]
fn errors_relative_to_the_test_have_its_sign_and_denominator() {
    let table = PublishedComparison {
        error_reference: ErrorReference::Test,
        ..table()
    };
    let recomputed = recompute(&table, &[]);
    let cell = recomputed.rows[1].tests[1].expect("an error of the second test");
    assert!((cell.error_hz - 8.0).abs() < 1e-12);
    assert!((cell.error_percent - 100.0 * 8.0 / 192.0).abs() < 1e-12);
    assert_eq!(recomputed.tests[1].missed, ["f1", "f3"]);
    let mean = recomputed.tests[0]
        .mean_percent
        .expect("errors of the first test");
    assert!((mean - 50.0 * (10.0 / 90.0 + 15.0 / 215.0)).abs() < 1e-12);
}

#[test]
fn a_frequency_is_compared_with_the_matching_root_of_the_model() {
    let claim = |row: &str, hz: f64| Statement::Frequency {
        row: row.to_owned(),
        hz,
    };
    // The model has w1 at 100 Hz, w2 at 200 Hz.
    assert_eq!(confirmed(claim("w1", 100.4), 0), Some(true));
    assert_eq!(confirmed(claim("w1", 100.4), 1), Some(false));
    assert_eq!(confirmed(claim("w3", 100.4), 0), None, "no such root");
    let verdict = &judge(claim("w2", 200.6), 1)[0];
    assert_eq!(verdict.unit, "Hz");
    let found = verdict
        .recomputed
        .as_ref()
        .expect("a claim that can be recomputed");
    assert!((found.value.expect("a value of the claim") - 200.0).abs() < 1e-9);
}

#[test]
fn quantities_are_found_by_model_and_name_and_compared_with_value_or_bound() {
    let quantity = |value| ModelQuantity::new("place", value, "N/m", "where it is");
    let of = |model: Option<&str>, value| ModelQuantities {
        model: model.map(str::to_owned),
        quantities: vec![quantity(value)],
    };
    let all = [
        of(None, 1.0),
        of(Some("other"), 2.512238e9),
        of(Some("none"), f64::NAN),
    ];
    let judged = |model: Option<&str>, name: &str, relation| {
        let claim = Claim {
            text: "c".to_owned(),
            statement: Statement::Quantity(QuantityClaim {
                model: model.map(str::to_owned),
                quantity: name.to_owned(),
                relation,
            }),
            digits: Digits::Significant(4),
            remark: Some("seen".to_owned()),
        };
        let evidence = Evidence {
            roots: None,
            quantities: &all,
            support: None,
        };
        audit(&PublishedComparison::default(), &evidence, &[claim]).remove(0)
    };
    let other = Some("other");
    assert_eq!(
        judged(other, "place", Relation::Equal(2.512e9)).confirmed,
        Some(true)
    );
    assert_eq!(
        judged(other, "place", Relation::Equal(2.511e9)).confirmed,
        Some(false)
    );
    assert_eq!(
        judged(None, "place", Relation::Above(0.5)).confirmed,
        Some(true)
    );
    assert_eq!(
        judged(None, "place", Relation::Below(0.5)).confirmed,
        Some(false)
    );
    assert_eq!(judged(None, "other", Relation::Below(0.5)).confirmed, None);
    assert_eq!(
        judged(Some("none"), "place", Relation::Above(0.0)).confirmed,
        None
    );
    let unstated = judged(None, "place", Relation::Unstated);
    assert_eq!((unstated.confirmed, unstated.unit), (None, "N/m"));
    assert_eq!(
        unstated
            .recomputed
            .expect("a claim that can be recomputed")
            .value,
        Some(1.0)
    );
    let bound = judged(None, "place", Relation::Above(0.5));
    assert_eq!(
        (bound.relation, bound.remark.as_deref()),
        (">", Some("seen"))
    );
}

#[test]
fn support_of_the_test_is_compared_with_that_of_the_model() {
    let same = |test| confirmed(Statement::SameSupport { test }, 0);
    assert_eq!(same(Support::Suspended), Some(false));
    assert_eq!(same(Support::Fixed), Some(true));
    let claim = Claim {
        text: "hung".to_owned(),
        statement: Statement::SameSupport {
            test: Support::Suspended,
        },
        digits: Digits::Decimals(0),
        remark: None,
    };
    let unknown = audit(&table(), &Evidence::default(), &[claim]).remove(0);
    assert_eq!((unknown.confirmed, unknown.recomputed), (None, None));
    assert_eq!(unknown.printed.rows, ["suspended"]);
}

#[test]
fn a_claim_without_a_computed_value_has_no_verdict() {
    let verdict = &judge(Statement::NotCheckable, 0)[0];
    assert_eq!(
        (verdict.confirmed, verdict.recomputed.clone()),
        (None, None)
    );
}
