//! Scenes: a test, a model, the options of every stage, and the chain that runs them.
//!
//! `typed` holds the scene as written, `plan` its meaning, `run` the chain that executes it. A
//! scene computes nothing itself.

mod columns;
mod configuration;
mod configuration_tables;
mod confine;
mod damage;
mod draft;
mod draft_columns;
mod draft_file;
mod draft_unused;
mod error;
mod expected;
mod faults;
mod figures;
mod file_dofs;
mod file_faults;
mod ingest;
mod limits;
mod mass_line;
mod matrices;
#[cfg(test)]
mod matrices_tests;
mod model;
mod model_draft;
mod model_kind;
mod model_name;
mod modes_file;
mod modification;
mod observer;
mod placement;
mod places;
mod plan;
mod published_claims;
mod quantities;
mod recording;
mod reduced;
mod regression_check;
mod result;
mod run;
mod sensor_findings;
mod supports;
mod synth_spec;
mod synth_truth;
mod test_agreement;
mod test_plan;
mod test_result;
mod test_state;
mod toml_faults;
mod toml_text;
mod toml_value;
mod trigger;
mod typed;
mod update;
mod update_findings;
mod update_options;
mod updated_model;

#[cfg(test)]
mod expected_tests;

pub use configuration_tables::BASE_CONFIGURATION;
pub use confine::check_confined;
pub use damage::{damage, lost_part_findings};
pub use draft::{Draft, DraftModel, DraftPlan, draft_scene};
pub use draft_columns::{ColumnHeading, ColumnHeadings, TableContent, column_headings};
pub use draft_file::{DraftFile, StatedUnits};
pub use draft_unused::{Statement, UnusedStatement};
pub use error::{Place, SceneError, TomlFault};
pub use expected::{EXPECTED_SCHEMA, Expected, ExpectedResult, Source, load_expected};
pub use figures::*;
pub use ingest::{IngestOptions, Ingested, ingest_files, open_test};
pub use limits::{
    LimitCheck, LimitedResult, Limits, LimitsUse, ModeLimit, check_comparison, check_modes,
    limits_from_toml, percent,
};
pub use mass_line::{leaving_list, mass_line_findings, test_rigid_body};
pub use model::{LoadedModel, Theory, load_model, sensors, table_model, theory};
pub use model_draft::{ModelDraft, PointLine};
pub use model_kind::{ModelKind, built_in_name_finding, is_built_in_model, model_kind};
pub use model_name::first_root;
pub use modes_file::{LoadedModes, ModesOptions, has_functions_only, is_modes_file, load_modes};
pub use modification::{BeforeChanges, ModifiedScene, StatedBounds, StatedDesign};
pub use observer::Observer;
pub use placement::{PlacedTest, PlacementPlan};
pub use plan::{Scene, force_window, offset};
pub use recording::{SyntheticRecording, hammer_test, load_synth, record};
pub use regression_check::{
    AllowedChange, Change, ChangeLimits, MAX_DAMPING_CHANGE_PERCENT, MAX_FREQUENCY_CHANGE_PERCENT,
    MAX_MAC_CHANGE, Measure, RowVerdict, UncertainValue, check_changes, mode_changes,
    relative_change, std_change,
};
pub use result::SceneResult;
#[cfg(feature = "cli")]
pub(crate) use run::add_file_dofs;
pub use run::{
    Comparison, NamedTest, TestData, compare_tests, identify_sets, indicators_of_sets, run,
    run_observed, test_data,
};
pub use supports::contradicted_support;
pub use synth_spec::{SYNTH_SCHEMA, SynthFile};
pub use test_plan::{FilePlan, TestPlan, TestSource};
pub use test_result::TestResult;
pub use test_state::TestState;
pub use toml_text::{FILL_IN, OpenLine, open_lines, parse, read_text};
pub use typed::{
    ConfigurationTable, ModelTable, ReportTableTable, SCENE_SCHEMA, SceneFile, SensorTable,
    UpdateParameterTable, UpdateTable,
};
pub use update::{ConfigurationUpdate, SceneUpdate, update_scene};
