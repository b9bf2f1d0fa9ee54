//! Correlation: which test mode is which theory mode, and the comparison table.
//!
//! A [`DofMap`] ties the degrees of freedom, [`pair`] the modes, [`compare`] makes rows of one theory and several tests.
//! This module must not compute modes, and must not print or write what it finds.

mod assignment;
mod dof_map;
mod error;
mod options;
mod pairing;
mod roots;
mod subspace;
mod table;

#[cfg(test)]
mod pairing_tests;
#[cfg(test)]
mod table_tests;

pub use assignment::assign;
pub use dof_map::{DofMap, DofPair};
pub use error::CorrelateError;
pub use options::{ErrorReference, PairOptions};
pub use pairing::{NearMiss, Pair, Pairing, Partner, Rival, UnpairedRoot, Verdict, pair};
pub use subspace::{principal_angles_deg, subspace_mac};
pub use table::{
    ComparisonTable, Footnote, PairedTest, Row, Status, TestCell, TestSummary, TheoryCell, compare,
};
