//! Studies compare the speed and accuracy of all methods, map where they fail, and find the needs
//! of a scene.
//!
//! | file | content |
//! |---|---|
//! | `breakdown` | where every method fails, over two factors |
//! | `system` | [`System`]: a linear system known by its modes, with its FRFs, their noise and ends of records |
//! | `bound` | [`pole_bounds`]: the Cramér-Rao bound of poles |
//! | `score` | [`Judge`]: which modes of a truth are observable, found, missed, and which are spurious |
//! | `method` | [`Method`]: every estimator, with orders |
//! | `order` | [`order()`]: as few modes, as low an order, as simple a method, theory and parameter set as a scene bears |
//! | `meter` | [`Meter`]: processor time and memory, supplied by the caller |
//! | `seed` | [`cell_random`]: random numbers from the coordinates of a cell |
//! | `spec` | [`StudyFile`]: `study.toml` as typed |
//! | `detection_counts` | [`DetectionCounts`]: errors of found modes, summed over identifications |
//! | `wording` | counts and lists in sentences |
//! | `twin` | [`System::twin`]: the system of a test's modes |
//! | `speed_accuracy` | [`speed_accuracy()`]: every method on a scene's tests and on their twins |
//!
//! A study reads no clock and no file, and draws from stated seeds alone; work runs in the caller's
//! pool and gives the same numbers for any number of threads.

mod bound;
pub mod breakdown;
mod detection_counts;
mod error;
mod meter;
mod method;
mod order;
mod score;
mod seed;
mod spec;
mod speed_accuracy;
mod system;
mod twin;
mod wording;

pub use bound::{NoisyLines, PoleBound, pole_bounds};
pub use detection_counts::DetectionCounts;
pub use error::StudyError;
pub use meter::{Cost, Meter};
pub use method::Method;
pub use order::{
    LowestOrder, ModeNeeds, OrderOptions, ParameterNeeds, SceneNeeds, SingleMode, TestNeeds,
    TheoryNeeds, TriedOrder, method_sentences, needs_of_model, order, summarise_needs,
};
pub use score::{
    Detectability, DetectionVerdict, Judge, detectability, mode_bounds, shape_at_responses,
};
pub use seed::cell_random;
pub use spec::{STUDY_SCHEMA, StudyFile, parse_study};
pub use speed_accuracy::{
    Condition, DataRow, FrontPoint, SpeedAccuracy, SpeedAccuracyOptions, SpeedLimits, TestStudy,
    Timing, TwinCost, TwinRow, method_verdicts, pareto_front, recommendations, speed_accuracy,
};
pub use system::{FrfNoise, System, TrueMode, with_noise};
