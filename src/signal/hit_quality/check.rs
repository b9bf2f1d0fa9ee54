//! A check states the value, the limit and the outcome of one rule on one channel of a hit.

use crate::dof::Dof;

/// The rules of the checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// A second contact of the hammer.
    DoubleHit,
    /// Clipped samples.
    Overload,
    /// Peak force against the median of the series.
    Level,
    /// A channel that is not quiet before the hit.
    PreTrigger,
    /// A response that has not decayed at the end of the record.
    Decay,
    /// The force spectrum falls too far inside the band.
    RollOff,
    /// A channel without signal.
    Dead,
    /// A force pulse of negative sign.
    Sign,
    /// Offset and drift of a channel.
    Drift,
    /// An FRF unlike that of the other hits.
    InconsistentHit,
}

impl Rule {
    /// The name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Rule::DoubleHit => "double-hit",
            Rule::Overload => "overload",
            Rule::Level => "level",
            Rule::PreTrigger => "pre-trigger",
            Rule::Decay => "decay",
            Rule::RollOff => "roll-off",
            Rule::Dead => "dead",
            Rule::Sign => "sign",
            Rule::Drift => "drift",
            Rule::InconsistentHit => "odd-one-out",
        }
    }
}

/// The outcome of a rule for a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Within the limit.
    Passed,
    /// Worth knowing; the hit is kept.
    Noted,
    /// The hit, or the channel that the check names, should not be used.
    Rejected,
    /// The noise, or too few samples or hits, hides what the limit asks for.
    NotDecidable,
}

impl Outcome {
    /// The name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Passed => "passed",
            Outcome::Noted => "noted",
            Outcome::Rejected => "rejected",
            Outcome::NotDecidable => "not-decidable",
        }
    }
}

/// One rule applied to one channel of one hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Which rule.
    pub rule: Rule,
    /// The response; `None` for the force.
    pub dof: Option<Dof>,
    /// The measured value; `None` where there is nothing to measure it from.
    pub value: Option<f64>,
    /// The limit of the value.
    pub limit: Option<f64>,
    /// Unit of value and limit, empty for a plain number.
    pub unit: &'static str,
    /// The outcome.
    pub outcome: Outcome,
    /// Double hit: onset to onset, s (negative: before the pulse). Roll-off: where the spectrum
    /// passes the limit, Hz.
    pub at: Option<f64>,
    /// Double hit: `ratio sqrt(Σp²) / σ` of the contact found, or of one of the limit's ratio where
    /// none was found.
    pub detectability: Option<f64>,
}

impl Check {
    /// A check without numbers.
    pub fn new(rule: Rule, outcome: Outcome) -> Self {
        Self {
            rule,
            dof: None,
            value: None,
            limit: None,
            unit: "",
            outcome,
            at: None,
            detectability: None,
        }
    }

    pub(super) fn value(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        (self.value, self.limit, self.unit) = (Some(value), Some(limit), unit);
        self
    }
}

/// Passed up to the limit, else the stated outcome.
pub(super) fn compare_with_limit(value: f64, limit: f64, otherwise: Outcome) -> Outcome {
    if value <= limit {
        Outcome::Passed
    } else {
        otherwise
    }
}
