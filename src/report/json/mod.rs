//! The JSON files that others may rely on; a change that breaks a reader raises the number in the
//! schema's name.

mod before_you_leave;
mod comparison;
mod details;
mod hits;
mod measures;
mod modification;
mod placement;
mod response;
mod run;
mod run_check;
mod schema;
mod states;
mod study;
mod sweep;
mod theory;
mod update;

pub use before_you_leave::before_you_leave_value;
pub use comparison::{
    COMPARISON_SCHEMA, ComparisonFile, ExtraResults, JsonError, RowFile, SummaryFile, TestFile,
    TheoryFile, comparison_from_json, comparison_to_json, comparison_with,
};
pub use details::{DETAILS_SCHEMA, details_to_json};
pub use hits::hits_value;
pub use measures::{
    AUTO_MAC_SCHEMA, FRF_CORRELATION_SCHEMA, auto_macs_to_json, frf_correlations_to_json,
};
pub use modification::{MODIFICATION_SCHEMA, modification_to_json};
pub use response::{RESPONSE_SCHEMA, response_to_json};
pub use run::{REPORT_FILE, REPORT_SCHEMA, RunReport, Section, report_from_json, report_to_json};
pub use study::{
    BREAKDOWN_SCHEMA, BreakdownFile, ORDER_SCHEMA, SPEED_ACCURACY_SCHEMA, breakdown_from_json,
    breakdown_to_json, order_from_json, order_to_json, speed_accuracy_from_json,
    speed_accuracy_to_json,
};
pub use sweep::{SWEEP_SCHEMA, sweeps_to_json};
pub use theory::{TheoryResults, with_theory};
pub use update::{
    AssumedFile, ChangeFile, ExplanationFile, FitFile, FitRowFile, IterationFile, LeftOutFile,
    OtherOptimumFile, PredictionFile, StartsFile, UPDATE_SCHEMA, UpdateFile, UpdatedParameterFile,
    update_file, update_from_json, update_to_json,
};
