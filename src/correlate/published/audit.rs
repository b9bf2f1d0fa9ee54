//! What a text claims of its tables, recomputed from them.
//!
//! A statement like "the largest relative error, 7.5 %, is at f2" is two claims: the error at f2 is 7.5 %, and no other is
//! larger. They are audited apart, since either can be wrong alone.

use super::roots::RootMatch;
use super::table::{PublishedComparison, RecomputedRow, RecomputedTable, recompute};

/// One claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The claim in words.
    pub text: String,
    /// What it says.
    pub statement: Statement,
    /// Digits after the point of the printed value; the value is confirmed when the recomputed one rounds to it.
    pub decimals: usize,
}

/// What an error is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorUnit {
    /// Hz.
    Hz,
    /// Percent of the table's reference.
    Percent,
}

impl ErrorUnit {
    /// The unit as printed.
    pub fn symbol(self) -> &'static str {
        match self {
            ErrorUnit::Hz => "Hz",
            ErrorUnit::Percent => "%",
        }
    }
}

/// Whose roots are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RootSide {
    /// Those that the publication prints.
    Printed,
    /// Those of the model.
    Model,
}

/// A magnitude of an error, where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorClaim {
    /// What it is measured in.
    pub unit: ErrorUnit,
    /// Name of the test.
    pub test: String,
    /// Label of the row.
    pub row: String,
    /// The magnitude.
    pub value: f64,
}

/// What a claim says.
#[derive(Clone, Debug, PartialEq)]
pub enum Statement {
    /// The largest error of a test is this much, and is at this row.
    LargestError(ErrorClaim),
    /// The error of a test at this row is this much; others may be larger.
    ErrorAt(ErrorClaim),
    /// A test missed these rows and no other.
    Missed {
        /// Name of the test.
        test: String,
        /// Labels of the rows.
        rows: Vec<String>,
    },
    /// There are this many roots of multiplicity 1.
    SingleRoots {
        /// Whose roots.
        side: RootSide,
        /// How many.
        value: f64,
    },
    /// There are this many roots, each counted as often as its multiplicity.
    TotalRoots {
        /// Whose roots.
        side: RootSide,
        /// How many.
        value: f64,
    },
    /// A root has this multiplicity.
    Multiplicity {
        /// Whose root; the model's is the one that matches the printed one.
        side: RootSide,
        /// Label of the printed root.
        row: String,
        /// The multiplicity.
        value: f64,
    },
    /// The theory's frequency of every row is its printed root over 2 pi, rounded.
    TheoryColumn,
}

/// A value, rows, or a value at rows.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Stated {
    /// The value, where it is about one.
    pub value: Option<f64>,
    /// Labels of the rows, where it is about some.
    pub rows: Vec<String>,
}

/// What became of a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The claim in words.
    pub text: String,
    /// Unit of both values; empty for counts.
    pub unit: &'static str,
    /// Digits after the point of the printed value.
    pub decimals: usize,
    /// As printed.
    pub printed: Stated,
    /// As recomputed; `None` where there is nothing to recompute it from.
    pub recomputed: Option<Stated>,
    /// Whether they agree; `None` where nothing could be recomputed.
    pub confirmed: Option<bool>,
}

/// Recomputes every claim from the published rows, or from the model where the claim is about the model.
///
/// One verdict for each claim in their order; [`Statement::TheoryColumn`] has one for the rows that agree and one for each
/// row that does not. Without `roots` a claim about roots has no verdict, nor has one about a row or test that is not there.
pub fn audit(
    table: &PublishedComparison,
    roots: Option<&RootMatch>,
    claims: &[Claim],
) -> Vec<Verdict> {
    let published: Vec<_> = roots.iter().flat_map(|roots| roots.published()).collect();
    let recomputed = recompute(table, &published);
    let of_claim = |claim: &Claim| match &claim.statement {
        Statement::TheoryColumn => theory_column(claim, &recomputed.rows),
        _ => vec![verdict(claim, &recomputed, roots)],
    };
    claims.iter().flat_map(of_claim).collect()
}

/// Whether a value rounds to the printed one; at a tie to either side.
fn rounds_to(value: f64, printed: f64, decimals: usize) -> bool {
    let half_digit = 0.5 * 10f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX));
    let rounding = 4.0 * f64::EPSILON * value.abs().max(printed.abs());
    (value - printed).abs() <= half_digit + rounding
}

fn verdict(claim: &Claim, table: &RecomputedTable, roots: Option<&RootMatch>) -> Verdict {
    let (printed, recomputed) = printed_and_recomputed(&claim.statement, table, roots);
    let agree = |found: &Stated| agree(&printed, found, claim.decimals);
    Verdict {
        text: claim.text.clone(),
        unit: match &claim.statement {
            Statement::LargestError(error) | Statement::ErrorAt(error) => error.unit.symbol(),
            _ => "",
        },
        decimals: claim.decimals,
        confirmed: recomputed.as_ref().map(agree),
        printed,
        recomputed,
    }
}

/// Both sides of a statement other than [`Statement::TheoryColumn`], which has several of them.
fn printed_and_recomputed(
    statement: &Statement,
    table: &RecomputedTable,
    roots: Option<&RootMatch>,
) -> (Stated, Option<Stated>) {
    match statement {
        Statement::LargestError(error) => (at(error.value, &error.row), largest(table, error)),
        Statement::ErrorAt(error) => (at(error.value, &error.row), error_at(table, error)),
        Statement::Missed { test, rows } => {
            let found = table.tests.iter().find(|own| own.test == *test);
            let missed = found.map(|own| rows_alone(own.missed.clone()));
            (rows_alone(rows.clone()), missed)
        }
        Statement::SingleRoots { side, value } => {
            let single = |m: &[usize]| m.iter().filter(|m| **m == 1).count();
            (count(*value), counted(roots, *side, single))
        }
        Statement::TotalRoots { side, value } => {
            let total = |m: &[usize]| m.iter().sum();
            (count(*value), counted(roots, *side, total))
        }
        Statement::Multiplicity { side, row, value } => {
            let found = multiplicity(roots, *side, row).map(|m| at(m as f64, row));
            (at(*value, row), found)
        }
        Statement::TheoryColumn => (Stated::default(), None),
    }
}

/// Values round to each other and every printed row is among those found; without values the rows are the same.
fn agree(printed: &Stated, found: &Stated, decimals: usize) -> bool {
    if let (Some(value), Some(own)) = (printed.value, found.value) {
        let there = printed.rows.iter().all(|row| found.rows.contains(row));
        return there && rounds_to(own, value, decimals);
    }
    let all_in = |a: &Stated, b: &Stated| a.rows.iter().all(|row| b.rows.contains(row));
    all_in(printed, found) && all_in(found, printed)
}

fn at(value: f64, row: &str) -> Stated {
    Stated {
        value: Some(value),
        rows: vec![row.to_owned()],
    }
}

fn count(value: f64) -> Stated {
    Stated {
        value: Some(value),
        rows: Vec::new(),
    }
}

fn rows_alone(rows: Vec<String>) -> Stated {
    Stated { value: None, rows }
}

fn largest(table: &RecomputedTable, claim: &ErrorClaim) -> Option<Stated> {
    let own = table.tests.iter().find(|own| own.test == claim.test)?;
    let largest = match claim.unit {
        ErrorUnit::Hz => own.largest_hz.clone(),
        ErrorUnit::Percent => own.largest_percent.clone(),
    }?;
    Some(Stated {
        value: Some(largest.value),
        rows: largest.rows,
    })
}

fn error_at(table: &RecomputedTable, claim: &ErrorClaim) -> Option<Stated> {
    let column = table.tests.iter().position(|own| own.test == claim.test)?;
    let row = table.rows.iter().find(|own| own.label == claim.row)?;
    let cell = row.tests[column]?;
    let error = match claim.unit {
        ErrorUnit::Hz => cell.error_hz,
        ErrorUnit::Percent => cell.error_percent,
    };
    Some(at(error.abs(), &claim.row))
}

/// A number made of the multiplicities of one side; `None` where that side has no roots.
fn counted(
    roots: Option<&RootMatch>,
    side: RootSide,
    of: impl Fn(&[usize]) -> usize,
) -> Option<Stated> {
    let roots = roots?;
    let multiplicities: Vec<usize> = match side {
        RootSide::Printed => roots.published().map(|root| root.multiplicity).collect(),
        RootSide::Model => roots.model().map(|root| root.modes.len()).collect(),
    };
    (!multiplicities.is_empty()).then(|| count(of(&multiplicities) as f64))
}

fn multiplicity(roots: Option<&RootMatch>, side: RootSide, label: &str) -> Option<usize> {
    let named = |row: &&super::RootRow| row.published.as_ref().is_some_and(|p| p.label == label);
    let row = roots?.rows.iter().find(named)?;
    match side {
        RootSide::Printed => row.published.as_ref().map(|root| root.multiplicity),
        RootSide::Model => row.model.as_ref().map(|root| root.modes.len()),
    }
}

/// One verdict for the rows whose printed frequency is that of their root, and one for each other row.
fn theory_column(claim: &Claim, rows: &[RecomputedRow]) -> Vec<Verdict> {
    let about = |printed: Stated, recomputed: Option<Stated>, confirmed: Option<bool>| Verdict {
        text: claim.text.clone(),
        unit: "Hz",
        decimals: claim.decimals,
        printed,
        recomputed,
        confirmed,
    };
    let known = rows.iter().filter_map(|row| Some((row, row.root_hz?)));
    let (good, bad): (Vec<_>, Vec<_>) =
        known.partition(|(row, hz)| rounds_to(*hz, row.theory_hz, claim.decimals));
    let mut verdicts = Vec::new();
    if !good.is_empty() {
        let labels = rows_alone(good.iter().map(|(row, _)| row.label.clone()).collect());
        verdicts.push(about(labels.clone(), Some(labels), Some(true)));
    }
    verdicts.extend(bad.into_iter().map(|(row, hz)| {
        about(
            at(row.theory_hz, &row.label),
            Some(at(hz, &row.label)),
            Some(false),
        )
    }));
    if verdicts.is_empty() {
        verdicts.push(about(Stated::default(), None, None));
    }
    verdicts
}
