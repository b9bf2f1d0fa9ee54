//! Footnotes explain the comparison table.

use std::fmt;

use crate::finding::Code;

use super::chance::MIN_DOFS_OF_SHAPE;
use super::table_row::{PairedTest, Row, Status, TestCell};
use super::{Basis, ChanceLevel, ErrorReference};

/// A sentence under the table.
#[derive(Clone, Debug, PartialEq)]
pub enum Footnote {
    /// Reference of the relative errors.
    Error(ErrorReference),
    /// MAC of test shapes as identified.
    ComplexShapesAsTheyAre,
    /// MAC with the subspace of a repeated root.
    RepeatedRoots,
    /// Rigid-body modes of the theory, which have no row.
    RigidBodyModesLeftOut {
        /// How many.
        count: usize,
        /// The highest frequency of one, Hz.
        highest_hz: f64,
    },
    /// A test, by name, with modes that are paired by frequency alone.
    FrequencyAlone(String),
    /// Chance levels of the pairs of a test.
    ChanceLevel {
        /// The test.
        test: String,
        /// Lowest and highest level.
        mac: [f64; 2],
        /// Smallest and largest number of degrees of freedom in common.
        dofs: [usize; 2],
        /// Smallest and largest number of roots within the frequency gate.
        roots: [usize; 2],
        /// Smallest and largest probability that an independent shape reaches its level.
        significance: [f64; 2],
    },
    /// The observability of some missed roots is unknown.
    ObservabilityUnknown,
    /// A damping ratio of a test, by name, that replaces the missing one of the theory.
    DampingOfTest {
        /// The test.
        test: String,
        /// Median damping ratio of its modes.
        ratio: f64,
    },
    /// A test, by name, whose recording is synthetic.
    Synthetic(String),
}

impl Footnote {
    /// Its test; `None` for a sentence about the whole table.
    pub fn test(&self) -> Option<&str> {
        match self {
            Footnote::FrequencyAlone(test)
            | Footnote::Synthetic(test)
            | Footnote::ChanceLevel { test, .. }
            | Footnote::DampingOfTest { test, .. } => Some(test),
            _ => None,
        }
    }
}

impl fmt::Display for Footnote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Footnote::Error(ErrorReference::Theory) => {
                f.write_str("Error = (test - theory)/theory.")
            }
            Footnote::Error(ErrorReference::Test) => f.write_str("Error = (theory - test)/test."),
            Footnote::ComplexShapesAsTheyAre => {
                f.write_str("MAC of the complex test shapes as identified.")
            }
            Footnote::RepeatedRoots => f.write_str(
                "A row of several theory modes is a repeated root; its MAC is that with their subspace.",
            ),
            Footnote::RigidBodyModesLeftOut { count, highest_hz } if *highest_hz > 0.0 => write!(
                f,
                "Rigid-body modes of the theory have no row: {count}, at {highest_hz:.2e} Hz or less, below a thousandth of the next root."
            ),
            Footnote::RigidBodyModesLeftOut { count, .. } => {
                write!(f, "Rigid-body modes of the theory at 0 Hz have no row: {count}.")
            }
            Footnote::FrequencyAlone(test) => write!(
                f,
                "{test}: paired by frequency alone where fewer than {MIN_DOFS_OF_SHAPE} different DOFs are in common."
            ),
            Footnote::ChanceLevel {
                test,
                mac,
                dofs,
                roots,
                significance,
            } => write!(
                f,
                "{test}: chance level for independent shapes: MAC {} ({} DOFs; roots in reach: {}), reached in {} of 100 cases. A pair by shape reaches it; real, smooth shapes correlate more.",
                range(mac.map(|level| format!("{level:.3}"))),
                range(dofs.map(|n| n.to_string())),
                range(roots.map(|n| n.to_string())),
                range(significance.map(|part| format!("{:.0}", 100.0 * part)))
            ),
            Footnote::Synthetic(test) => write!(
                f,
                "{test}: a synthetic recording, computed from a stated truth, not measured."
            ),
            Footnote::ObservabilityUnknown => {
                f.write_str("The observability of an unmatched mode is unknown where its reason says so; its verdict is only that it is unmatched.")
            }
            Footnote::DampingOfTest { test, ratio } => write!(
                f,
                "{test}: the model has no damping; observability was assessed with the median damping ratio of the test, {:.3} %.",
                100.0 * ratio
            ),
        }
    }
}

/// A range as text; one number where both ends are equal.
fn range([low, high]: [String; 2]) -> String {
    if low == high {
        low
    } else {
        format!("{low} to {high}")
    }
}

/// The note on the chance levels of a test; `None` where all pairs rest on frequency alone.
fn chance_levels(test: &PairedTest<'_>) -> Option<Footnote> {
    let partners = test.pairing.pairs.iter().flat_map(|pair| &pair.partners);
    let levels: Vec<ChanceLevel> = partners
        .filter_map(|partner| partner.chance_level)
        .collect();
    let counts = |of: fn(&ChanceLevel) -> usize| {
        let all = || levels.iter().map(of);
        Some([all().min()?, all().max()?])
    };
    let values = |of: fn(&ChanceLevel) -> f64| {
        let all = || levels.iter().map(of);
        Some([all().reduce(f64::min)?, all().reduce(f64::max)?])
    };
    Some(Footnote::ChanceLevel {
        test: test.name.to_owned(),
        mac: values(|level| level.mac)?,
        dofs: counts(|level| level.dofs)?,
        roots: counts(|level| level.roots)?,
        significance: values(|level| level.significance)?,
    })
}

/// Footnotes of a table of these rows.
pub(super) fn footnotes(
    tests: &[PairedTest<'_>],
    rows: &[Row],
    reference: ErrorReference,
) -> Vec<Footnote> {
    let cells = || rows.iter().flat_map(|row| &row.tests);
    let repeated = |row: &&Row| row.theory.as_ref().is_some_and(|t| t.modes.len() > 1);
    let mut notes = vec![Footnote::Error(reference)];
    if cells().any(|cell| cell.mac.is_some()) {
        notes.push(Footnote::ComplexShapesAsTheyAre);
    }
    if rows
        .iter()
        .filter(repeated)
        .flat_map(|row| &row.tests)
        .any(|cell| cell.mac.is_some())
    {
        notes.push(Footnote::RepeatedRoots);
    }
    let first = tests.first().map(|test| test.pairing);
    notes.extend(
        first
            .filter(|pairing| pairing.rigid_theory > 0)
            .map(|pairing| Footnote::RigidBodyModesLeftOut {
                count: pairing.rigid_theory,
                highest_hz: pairing.highest_rigid_hz,
            }),
    );
    for test in tests {
        let partners = test.pairing.pairs.iter().flat_map(|pair| &pair.partners);
        notes.extend(chance_levels(test));
        if partners
            .into_iter()
            .any(|partner| partner.basis == Basis::Frequency)
        {
            notes.push(Footnote::FrequencyAlone(test.name.to_owned()));
        }
        let mut findings = test.model.findings.iter();
        if findings.any(|finding| finding.code == Code::Synthetic) {
            notes.push(Footnote::Synthetic(test.name.to_owned()));
        }
    }
    if cells().any(|cell| !cell.is_status_certain()) {
        notes.push(Footnote::ObservabilityUnknown);
    }
    for test in tests {
        let column = cells().filter(|cell| cell.test == test.name);
        let ratio = column.filter_map(test_damping).next();
        notes.extend(ratio.map(|ratio| Footnote::DampingOfTest {
            test: test.name.to_owned(),
            ratio,
        }));
    }
    notes
}

/// The test's damping ratio, where the observability of a missed root depends on it.
fn test_damping(cell: &TestCell) -> Option<f64> {
    let known = cell.observability.as_ref()?;
    let damping = known.damping.filter(|damping| damping.from_test)?;
    let by_damping = match cell.status {
        Status::MissedExpected => true,
        Status::NotObservable | Status::MissedUnexpected => !known.at_nodes && known.noise.is_ok(),
        _ => false,
    };
    by_damping.then_some(damping.ratio)
}
