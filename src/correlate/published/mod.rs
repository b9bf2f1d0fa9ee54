//! An audit compares published results with a model and with each other.
//!
//! [`match_roots`] assigns printed roots to roots of the model; [`recompute`] computes the errors
//! of a printed comparison; [`audit`] recomputes the claims of the text about both.

mod audit;
mod digits;
mod roots;
mod table;

#[cfg(test)]
mod audit_tests;
#[cfg(test)]
mod roots_tests;

pub use audit::{
    Claim, ClaimValue, ClaimVerdict, ErrorClaim, ErrorUnit, Evidence, ModelQuantities,
    QuantityClaim, Relation, RootSide, Statement, audit,
};
pub use digits::Digits;
pub use roots::{
    ErrorSummary, MatchOptions, PublishedRoot, RootMatch, RootRow, frequency_hz, match_roots,
};
pub use table::{
    ErrorCell, Largest, PublishedComparison, PublishedRow, RecomputedRow, RecomputedTable,
    TestErrors, recompute,
};
