//! The JSON files that others may rely on; a change that breaks a reader raises the number in the schema's name.

mod compare;
mod comparison;
mod hits;
mod response;
mod sweep;
mod update;

pub use compare::{DETAILS_SCHEMA, details_to_json};
pub use comparison::{
    COMPARISON_SCHEMA, ComparisonFile, JsonError, RowFile, SummaryFile, TestFile, TheoryFile,
    comparison_from_json, comparison_to_json,
};
pub use hits::hits;
pub use response::{RESPONSE_SCHEMA, response_to_json};
pub use sweep::{SWEEP_SCHEMA, sweeps_to_json};
pub use update::{UPDATE_SCHEMA, update_to_json};
