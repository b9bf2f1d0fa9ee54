//! The audit recomputes the claims of a text from its tables.
//!
//! A statement like "the largest relative error, 7.5 %, is at f2" is two claims: the error at f2 is
//! 7.5 %, and no other is larger. They are audited separately.

use crate::theory::{ModelQuantity, ModelRoot, Support};

use super::digits::Digits;
use super::roots::{RootMatch, RootRow, frequency_hz};
use super::table::{PublishedComparison, RecomputedRow, RecomputedTable, recompute};

/// One claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The claim in words.
    pub text: String,
    /// The statement.
    pub statement: Statement,
    /// Digits of the printed value; the value is confirmed when the recomputed one rounds to it.
    pub digits: Digits,
    /// A remark; `None` for most.
    pub remark: Option<String>,
}

/// The claimed relation of a quantity of a model to a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relation {
    /// It is this much.
    Equal(f64),
    /// It is more than this.
    Above(f64),
    /// It is less than this.
    Below(f64),
    /// No figure: the value of the model is given without a verdict.
    Unstated,
}

/// A claim about a quantity of a model other than its roots.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityClaim {
    /// Name of the model; `None` for the one that the publication is compared with.
    pub model: Option<String>,
    /// Name of the quantity.
    pub quantity: String,
    /// The claimed relation.
    pub relation: Relation,
}

/// The quantities of one model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelQuantities {
    /// Name, as claims have it; `None` for the model that the publication is compared with.
    pub model: Option<String>,
    /// Its quantities.
    pub quantities: Vec<ModelQuantity>,
}

/// Values, besides the published tables, that claims are compared with.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence<'a> {
    /// The published roots and those of a model.
    pub roots: Option<&'a RootMatch>,
    /// Quantities of every model that a claim names.
    pub quantities: &'a [ModelQuantities],
    /// Support of the model.
    pub support: Option<Support>,
}

/// Unit of an error.
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

/// The set whose roots are counted.
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
    /// Its unit.
    pub unit: ErrorUnit,
    /// Name of the test.
    pub test: String,
    /// Label of the row.
    pub row: String,
    /// The magnitude.
    pub value: f64,
}

/// The statement of a claim.
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
    /// The frequency of a printed root is that of the model's root, rounded.
    Frequency {
        /// Label of the printed root.
        row: String,
        /// As printed, Hz.
        hz: f64,
    },
    /// A number that a model's theory gives.
    Quantity(QuantityClaim),
    /// The model is held like the structure in the test.
    SameSupport {
        /// Support in the test, as printed.
        test: Support,
    },
    /// No computed value can be compared with it; the remark gives the reason.
    NotCheckable,
}

/// A value, rows, or a value at rows, as printed or as recomputed.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ClaimValue {
    /// The value, where it is about one.
    pub value: Option<f64>,
    /// Labels of the rows, where it is about some.
    pub rows: Vec<String>,
}

/// The verdict on a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimVerdict {
    /// The claim in words.
    pub text: String,
    /// Unit of both values; empty for counts.
    pub unit: &'static str,
    /// Digits of the printed value.
    pub digits: Digits,
    /// `>` or `<` where the printed value is a bound; empty else.
    pub relation: &'static str,
    /// A remark.
    pub remark: Option<String>,
    /// As printed.
    pub printed: ClaimValue,
    /// As recomputed; `None` where there is nothing to recompute it from.
    pub recomputed: Option<ClaimValue>,
    /// Whether they agree; `None` where nothing could be recomputed, or nothing is printed in
    /// figures.
    pub confirmed: Option<bool>,
}

/// Recomputes every claim from the published rows, or from the model where the claim is about the
/// model.
///
/// One verdict for each claim in their order; [`Statement::TheoryColumn`] has one for the rows that
/// agree and one for each row that does not. Without roots a claim about roots has no verdict, nor
/// has one about a row, test or quantity that is not there.
pub fn audit(
    table: &PublishedComparison,
    evidence: &Evidence<'_>,
    claims: &[Claim],
) -> Vec<ClaimVerdict> {
    let published: Vec<_> = evidence
        .roots
        .iter()
        .flat_map(|roots| roots.published())
        .collect();
    let recomputed = recompute(table, &published);
    let of_claim = |claim: &Claim| match &claim.statement {
        Statement::TheoryColumn => theory_column(claim, &recomputed.rows),
        _ => vec![verdict(claim, &recomputed, evidence)],
    };
    claims.iter().flat_map(of_claim).collect()
}

fn verdict(claim: &Claim, table: &RecomputedTable, evidence: &Evidence<'_>) -> ClaimVerdict {
    let computed = match &claim.statement {
        Statement::Quantity(quantity) => evidence.quantity(quantity),
        _ => None,
    };
    let (printed, recomputed) = match &claim.statement {
        Statement::Quantity(stated) => {
            let found = computed.and_then(|quantity| quantity.value);
            (stated.relation.stated(), found.map(value_alone))
        }
        Statement::SameSupport { test } => {
            let named = |support: Support| rows_alone(vec![support.name().to_owned()]);
            (named(*test), evidence.support.map(named))
        }
        other => printed_and_recomputed(other, table, evidence.roots),
    };
    let (unit, relation) = match &claim.statement {
        Statement::LargestError(error) | Statement::ErrorAt(error) => (error.unit.symbol(), ""),
        Statement::Frequency { .. } => ("Hz", ""),
        Statement::Quantity(quantity) => (
            computed.map_or("", |computed| computed.unit),
            quantity.relation.sign(),
        ),
        _ => ("", ""),
    };
    let agree = |found: &ClaimValue| match &claim.statement {
        Statement::Quantity(quantity) => quantity.relation.holds(found.value?, claim.digits),
        _ => Some(agree(&printed, found, claim.digits)),
    };
    ClaimVerdict {
        text: claim.text.clone(),
        unit,
        digits: claim.digits,
        relation,
        remark: claim.remark.clone(),
        confirmed: recomputed.as_ref().and_then(agree),
        printed,
        recomputed,
    }
}

impl Relation {
    fn stated(self) -> ClaimValue {
        match self {
            Relation::Equal(value) | Relation::Above(value) | Relation::Below(value) => {
                value_alone(value)
            }
            Relation::Unstated => ClaimValue::default(),
        }
    }

    fn sign(self) -> &'static str {
        match self {
            Relation::Above(_) => ">",
            Relation::Below(_) => "<",
            Relation::Equal(_) | Relation::Unstated => "",
        }
    }

    fn holds(self, value: f64, digits: Digits) -> Option<bool> {
        match self {
            Relation::Equal(printed) => Some(digits.round_to(value, printed)),
            Relation::Above(bound) => Some(value > bound),
            Relation::Below(bound) => Some(value < bound),
            Relation::Unstated => None,
        }
    }
}

impl<'a> Evidence<'a> {
    fn quantity(&self, claim: &QuantityClaim) -> Option<&'a ModelQuantity> {
        let mut models = self.quantities.iter();
        let found = models.find(|model| model.model == claim.model)?;
        found.quantities.iter().find(|q| q.name == claim.quantity)
    }
}

/// Both sides of a statement other than [`Statement::TheoryColumn`], which has several of them.
fn printed_and_recomputed(
    statement: &Statement,
    table: &RecomputedTable,
    roots: Option<&RootMatch>,
) -> (ClaimValue, Option<ClaimValue>) {
    match statement {
        Statement::LargestError(error) => (at(error.value, &error.row), largest(table, error)),
        Statement::ErrorAt(error) => (at(error.value, &error.row), error_at(table, error)),
        Statement::Missed { test, rows } => {
            let found = table.tests.iter().find(|column| column.test == *test);
            let missed = found.map(|column| rows_alone(column.missed.clone()));
            (rows_alone(rows.clone()), missed)
        }
        Statement::SingleRoots { side, value } => {
            let single = |m: &[usize]| m.iter().filter(|m| **m == 1).count();
            (value_alone(*value), counted(roots, *side, single))
        }
        Statement::TotalRoots { side, value } => {
            let total = |m: &[usize]| m.iter().sum();
            (value_alone(*value), counted(roots, *side, total))
        }
        Statement::Multiplicity { side, row, value } => {
            let found = multiplicity(roots, *side, row).map(|m| at(m as f64, row));
            (at(*value, row), found)
        }
        Statement::Frequency { row, hz } => {
            let found = model_root(roots, row).map(|root| at(frequency_hz(root.omega_rad_s), row));
            (at(*hz, row), found)
        }
        Statement::TheoryColumn
        | Statement::Quantity(_)
        | Statement::SameSupport { .. }
        | Statement::NotCheckable => (ClaimValue::default(), None),
    }
}

/// Values round to each other and every printed row is among those found; without values the rows
/// are the same.
fn agree(printed: &ClaimValue, found: &ClaimValue, digits: Digits) -> bool {
    if let (Some(value), Some(value_found)) = (printed.value, found.value) {
        let there = printed.rows.iter().all(|row| found.rows.contains(row));
        return there && digits.round_to(value_found, value);
    }
    let all_in = |a: &ClaimValue, b: &ClaimValue| a.rows.iter().all(|row| b.rows.contains(row));
    all_in(printed, found) && all_in(found, printed)
}

fn at(value: f64, row: &str) -> ClaimValue {
    ClaimValue {
        value: Some(value),
        rows: vec![row.to_owned()],
    }
}

fn value_alone(value: f64) -> ClaimValue {
    ClaimValue {
        value: Some(value),
        rows: Vec::new(),
    }
}

fn rows_alone(rows: Vec<String>) -> ClaimValue {
    ClaimValue { value: None, rows }
}

fn largest(table: &RecomputedTable, claim: &ErrorClaim) -> Option<ClaimValue> {
    let column = table
        .tests
        .iter()
        .find(|column| column.test == claim.test)?;
    let largest = match claim.unit {
        ErrorUnit::Hz => column.largest_hz.clone(),
        ErrorUnit::Percent => column.largest_percent.clone(),
    }?;
    Some(ClaimValue {
        value: Some(largest.value),
        rows: largest.rows,
    })
}

fn error_at(table: &RecomputedTable, claim: &ErrorClaim) -> Option<ClaimValue> {
    let column = table
        .tests
        .iter()
        .position(|column| column.test == claim.test)?;
    let row = table.rows.iter().find(|row| row.label == claim.row)?;
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
) -> Option<ClaimValue> {
    let roots = roots?;
    let multiplicities: Vec<usize> = match side {
        RootSide::Printed => roots.published().map(|root| root.multiplicity).collect(),
        RootSide::Model => roots.model().map(|root| root.modes.len()).collect(),
    };
    (!multiplicities.is_empty()).then(|| value_alone(of(&multiplicities) as f64))
}

fn multiplicity(roots: Option<&RootMatch>, side: RootSide, label: &str) -> Option<usize> {
    match side {
        RootSide::Printed => row_of(roots, label)?
            .published
            .as_ref()
            .map(|root| root.multiplicity),
        RootSide::Model => model_root(roots, label).map(|root| root.modes.len()),
    }
}

fn row_of<'a>(roots: Option<&'a RootMatch>, label: &str) -> Option<&'a RootRow> {
    let named = |row: &&RootRow| row.published.as_ref().is_some_and(|p| p.label == label);
    roots?.rows.iter().find(named)
}

/// The root of the model that matches a printed one.
fn model_root<'a>(roots: Option<&'a RootMatch>, label: &str) -> Option<&'a ModelRoot> {
    row_of(roots, label)?.model.as_ref()
}

/// One verdict for the rows whose printed frequency is that of their root, and one for each other
/// row.
fn theory_column(claim: &Claim, rows: &[RecomputedRow]) -> Vec<ClaimVerdict> {
    let about = |printed: ClaimValue, recomputed: Option<ClaimValue>, confirmed: Option<bool>| {
        ClaimVerdict {
            text: claim.text.clone(),
            unit: "Hz",
            digits: claim.digits,
            relation: "",
            remark: claim.remark.clone(),
            printed,
            recomputed,
            confirmed,
        }
    };
    let known = rows.iter().filter_map(|row| Some((row, row.root_hz?)));
    let (good, bad): (Vec<_>, Vec<_>) =
        known.partition(|(row, hz)| claim.digits.round_to(*hz, row.theory_hz));
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
        verdicts.push(about(ClaimValue::default(), None, None));
    }
    verdicts
}
