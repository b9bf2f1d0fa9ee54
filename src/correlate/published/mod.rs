//! An audit compares published results with a model and with each other.
//!
//! [`match_roots`] says which printed root is which root of the model; [`recompute`] works out the
//! errors of a printed comparison; [`audit`] recomputes what a text claims of both. Nothing here
//! reads a file, and nothing is taken from a text that the tables of the publication do not
//! confirm.

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
