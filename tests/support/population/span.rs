//! Ranges of drawn numbers, and how they are drawn and checked.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use super::error::PopulationError;

/// A range `[lo, hi]` from which a number is drawn; both ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(from = "[f64; 2]")]
pub struct Span {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

impl From<[f64; 2]> for Span {
    fn from([lo, hi]: [f64; 2]) -> Self {
        Self { lo, hi }
    }
}

impl Span {
    /// Uniform.
    pub(super) fn uniform(&self, random: &mut ChaCha8Rng) -> f64 {
        random.random_range(self.lo..=self.hi)
    }

    /// Log-uniform: its logarithm is uniform.
    pub(super) fn log_uniform(&self, random: &mut ChaCha8Rng) -> f64 {
        let drawn = random.random_range(self.lo.ln()..=self.hi.ln()).exp();
        drawn.clamp(self.lo, self.hi)
    }

    /// A whole number, each with the same probability.
    pub(super) fn whole(&self, random: &mut ChaCha8Rng) -> usize {
        random.random_range(self.lo as usize..=self.hi as usize)
    }
}

/// The requirement on the ends of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ends {
    /// Finite.
    Finite,
    /// Finite and above 0.
    Positive,
    /// Above 0 and at most 1.
    Share,
    /// From the first to the second, both allowed.
    Between(f64, f64),
    /// Whole numbers from the first to the second, both allowed.
    Whole(usize, usize),
}

/// Largest number of masses, elements or points of a structure: matrices are dense.
pub(super) const MAX_COUNT: usize = 500;
/// Largest magnitude of a number that may have any sign: decibels, degrees.
const MAX_MAGNITUDE: f64 = 1000.0;

/// A range with its key and what it must be.
pub(super) type KeyedSpan = (&'static str, Span, Ends);

impl Ends {
    fn is_met_by(self, span: Span) -> bool {
        let Span { lo, hi } = span;
        let ordered = lo.is_finite() && hi.is_finite() && lo <= hi;
        ordered
            && match self {
                Ends::Finite => lo.abs().max(hi.abs()) <= MAX_MAGNITUDE,
                Ends::Positive => lo > 0.0,
                Ends::Share => lo > 0.0 && hi <= 1.0,
                Ends::Between(least, most) => lo >= least && hi <= most,
                Ends::Whole(least, most) => {
                    let whole = |v: f64| v.fract().abs() <= 0.0;
                    whole(lo) && whole(hi) && lo >= least as f64 && hi <= most as f64
                }
            }
    }

    fn expected(self) -> String {
        let what = match self {
            Ends::Finite => format!("two numbers up to {MAX_MAGNITUDE} either way"),
            Ends::Positive => "two finite numbers above 0".to_owned(),
            Ends::Share => "two numbers above 0 and up to 1".to_owned(),
            Ends::Between(least, most) => format!("two numbers from {least} to {most}"),
            Ends::Whole(least, most) => format!("two whole numbers from {least} to {most}"),
        };
        what + ", the lower first"
    }
}

/// Checks the ranges of one part of a population.
///
/// # Errors
/// [`PopulationError::Range`] for the first that does not hold.
pub(super) fn check(part: &str, stated: &[KeyedSpan]) -> Result<(), PopulationError> {
    match stated.iter().find(|(_, span, ends)| !ends.is_met_by(*span)) {
        None => Ok(()),
        Some((key, span, ends)) => Err(PopulationError::Range {
            part: part.to_owned(),
            key,
            got_lo: span.lo,
            got_hi: span.hi,
            expected: ends.expected(),
        }),
    }
}
