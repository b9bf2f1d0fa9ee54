//! A row of the comparison table holds a root of the theory and one cell for each test.

use serde::{Deserialize, Serialize};

use crate::finding::Code;
use crate::frf::FrfSet;
use crate::modal::ModalModel;

use super::{Basis, ChanceLevel, Observability, Pairing};

/// One test of a comparison, already paired with the theory.
#[derive(Clone, Copy, Debug)]
pub struct PairedTest<'a> {
    /// Name, as it heads its columns.
    pub name: &'a str,
    /// Its modes.
    pub model: &'a ModalModel,
    /// Its pairing with the theory of the comparison.
    pub pairing: &'a Pairing,
    /// Its FRFs, whose noise limits the observability; empty when there are none.
    pub frfs: &'a [FrfSet],
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// `f1`, `f2`, ... or `x1`, `x2`, ...
    pub label: String,
    /// The root of the theory; `None` for a test mode without a partner.
    pub theory: Option<TheoryCell>,
    /// For a root a cell of every test, in their order; for an extra mode one cell of its test.
    pub tests: Vec<TestCell>,
}

/// The theory's side of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryCell {
    /// Numbers, from 1, of the modes in the theory's list (rigid-body modes counted); several for a
    /// repeated root.
    pub modes: Vec<usize>,
    /// Their mean frequency, Hz.
    pub hz: f64,
}

/// A test's side of a row. Where several test modes belong to a repeated root, the numbers are
/// means over them, and the error is the largest of them.
#[derive(Clone, Debug, PartialEq)]
pub struct TestCell {
    /// Name of the test.
    pub test: String,
    /// Numbers of its modes, from 1; empty for a missed one.
    pub modes: Vec<usize>,
    /// Frequency, Hz.
    pub hz: Option<f64>,
    /// Standard deviation of the frequency, Hz; for a mean with independent errors of the modes.
    pub hz_std: Option<f64>,
    /// Signed frequency error by the table's reference, percent.
    pub error_percent: Option<f64>,
    /// Signed frequency error, Hz.
    pub error_hz: Option<f64>,
    /// `(test - theory)/std` with the standard deviation of the test's frequency, whatever the
    /// reference of the errors is.
    pub normalised_error: Option<f64>,
    /// Damping ratio, a fraction.
    pub damping_ratio: Option<f64>,
    /// Standard deviation of the damping ratio, as for the frequency.
    pub damping_std: Option<f64>,
    /// MAC; for a repeated root the smallest of its test modes with its subspace.
    pub mac: Option<f64>,
    /// Evidence on which a pair rests; `None` without a partner.
    pub basis: Option<Basis>,
    /// Chance level of the MAC; `None` without a partner, or where the pair rests on frequency
    /// alone.
    pub chance_level: Option<ChanceLevel>,
    /// Whether the MAC of a pair is below its chance level.
    pub uncorrelated: bool,
    /// Principal angles between the test modes and a repeated root, degrees.
    pub angles_deg: Option<Vec<f64>>,
    /// Status of the root in the test.
    pub status: Status,
    /// Findings of the identification that make its modes doubtful.
    pub doubts: Vec<Code>,
    /// Reasons of the status; clauses without a full stop.
    pub reasons: Vec<String>,
    /// Observability of the root by the test; `None` where that is unknown, and for an extra mode.
    pub observability: Option<Observability>,
}

impl TestCell {
    /// Whether the status is certain; that of an unmatched root of unknown observability is not.
    pub fn is_status_certain(&self) -> bool {
        let known = self.observability.as_ref();
        self.status != Status::MissedUnexpected
            || known.and_then(Observability::observable).is_some()
    }
}

/// Status of a theory root in a test, or of a test mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Paired.
    Paired,
    /// Paired, with another partner that fits as well.
    Ambiguous,
    /// Not found; one peak covers it and a paired root.
    MissedExpected,
    /// Not found inside the band, and nothing known excuses it.
    MissedUnexpected,
    /// At nodes of these sensors and hits, or below the noise.
    NotObservable,
    /// Outside the band that the test searched.
    OutsideBand,
    /// A test mode without a partner in the theory.
    Extra,
}
