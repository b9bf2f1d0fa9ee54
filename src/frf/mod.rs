//! Frequency response functions: estimation from hits, coherence and variance, conversion and
//! synthesis.
//!
//! | type or function | what |
//! |---|---|
//! | [`FrfSet`] | functions on one axis with coherence and variance |
//! | [`estimate_recording`] | hits to a set, read as they are needed; [`estimate()`] those in memory: H1, H2, Hv (Bendat and Piersol 2010; Rocklin, Crowley and Vold 1985) |
//! | [`evaluate_hammer_test`] | a whole test: quality of the hits, window, FRFs |
//! | [`evaluate_test`] | the same for any excitation |
//! | `shaker_test` | random and sine excitation: averages over blocks (Welch 1967) |
//! | [`rigid_body`] | mass line, inertia and sensors of a structure on a soft suspension |
//! | [`truncation_bounds`] | how wrong H is because the record ends, from the record itself |
//! | `force_levels` | whether poles depend on the force, from single hits of different levels |
//! | `drift` | whether resonances changed until a point was hit again |
//! | [`before_you_leave`] | what to repeat before the structure is gone |
//! | [`usable_band`] | where the force excites and the anti-alias filter is open |
//! | [`convert`] | receptance, mobility and accelerance into each other |
//! | [`check_set`] | signs, reciprocity, repeats, delays, frequencies that move from run to run |
//! | `exported` | conventions of programs that export FRFs: two-sided, conjugate, stepped sine |
//! | [`synthesise`] | poles and residues to a set |
//!
//! Values are SI in the kind that the function states. It identifies no mode and reads no file.

mod before_you_leave;
mod coherence;
mod consistency;
mod convert;
mod drift;
mod error;
mod estimate;
mod evaluate;
mod exported;
mod few_responses;
mod force;
mod force_levels;
mod frf_estimation;
mod hammer_options;
mod hammer_test;
mod hit_report;
mod local_pole;
mod measurement_runs;
mod options;
mod peaks;
mod preconditions;
pub mod rigid_body;
mod selection;
mod set;
mod shaker_test;
mod spectra_sums;
mod synthesis;
mod truncation;
mod usable_band;
mod variance;
mod window;

#[cfg(test)]
mod decay_tests;
#[cfg(test)]
mod estimate_tests;
#[cfg(test)]
mod hammer_tests;
#[cfg(test)]
mod recording_tests;

pub use before_you_leave::hit_again::{
    Cause, HitAgain, MIN_GOOD_HITS, PointCheck, Reason, ResonanceDeviation,
};
pub use before_you_leave::linearity::Linearity;
pub use before_you_leave::mass_line::{MassLineCheck, SupportCheck};
pub use before_you_leave::{BeforeYouLeave, CheckItem, before_you_leave};
pub(crate) use coherence::variance_from_coherence;
pub(crate) use consistency::check_functions;
pub use consistency::check_set;
pub use consistency::pair_figures::{DrivingPoints, PairFigures};
pub use consistency::visits::{Change, Drift, ResonanceDrift};
pub use convert::convert;
pub use error::FrfError;
pub use estimate::{Estimated, estimate, estimate_recording, truncation_bounds, usable_band};
pub use evaluate::evaluate_test;
pub(crate) use exported::even_lines::EvenLines;
pub(crate) use exported::usable_set;
pub use hammer_options::{Excitation, HammerOptions, ResponseWindow};
pub use hammer_test::{HammerTestResult, evaluate_hammer_test};
pub use hit_report::HitReport;
pub(crate) use measurement_runs::{measurement_runs, shifted_run};
pub use options::EstimateOptions;
pub use selection::Selection;
pub use set::{Estimator, FrfSet, Function, FunctionData, SetError};
pub use synthesis::{Residues, modal_terms, synthesise};
pub use truncation::{TRUNCATION_LIMIT, Truncation};
pub use usable_band::excited_part;
pub use window::Window;
