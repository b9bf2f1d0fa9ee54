//! Correlation pairs test modes with theory modes and writes the comparison table.
//!
//! A [`DofMap`] matches the degrees of freedom, [`pair`] the modes.
//! [`observability`](fn@observability) assesses which modes a test can detect. [`compare`] makes
//! the rows of one theory and several tests. [`measures`](mod@measures) holds correlation measures
//! of shapes and FRFs. [`published`] compares printed results with a model, and the claims of a
//! paper with its tables. This module must not compute modes, and must not print or write results.

mod alignment;
mod alignment_search;
mod alignment_shapes;
mod assignment;
mod candidates;
mod chance;
mod dof_map;
mod dof_names;
mod error;
mod expansion;
mod footnote;
mod global_stiffness_factor;
pub mod measures;
mod mislabelled;
mod modal_contribution;
mod model_roots;
mod nearest;
mod observability;
mod options;
mod pairing;
mod partner;
mod placement;
mod placement_candidates;
pub mod published;
mod reversed_sensors;
mod sensor_set;
mod shape_match;
mod shapes;
mod similarity;
mod subspace;
mod table;
mod table_cell;
mod table_row;

#[cfg(test)]
mod alignment_tests;
#[cfg(test)]
mod observability_tests;
#[cfg(test)]
mod pairing_tests;
#[cfg(test)]
mod placement_tests;
#[cfg(test)]
mod table_tests;
#[cfg(test)]
mod verdict_tests;

pub use alignment::{Alignment, align_known, align_nearest};
pub use alignment_shapes::mean_largest_mac;
pub use assignment::assign;
pub use chance::ChanceLevel;
pub use dof_map::{DofMap, DofPair};
pub use dof_names::{DofNames, LocatedModes, Reading};
pub use error::{CorrelateError, Extents};
pub use expansion::expand_shapes;
pub use footnote::Footnote;
pub(crate) use model_roots::highest_rigid_hz;
pub use observability::{
    MAX_FREQUENCY_STD_OVER_SPACING, MIN_PEAK_OVER_NOISE_DB, NotAssessed, Observability,
    PeakDetectability, RootDamping, observability,
};
pub use options::{ErrorReference, PairOptions};
pub use pairing::{Pairing, pair};
pub use partner::{Basis, Competitor, NearMiss, Pair, PairVerdict, Partner, UnpairedRoot};
pub use placement::{Placement, PlannedRoot, RankedHit, Step, placement};
pub use placement_candidates::Candidates;
pub use sensor_set::{SensorSet, fewest_sensors};
pub use shape_match::{ShapeMatch, mean_ratio};
pub use similarity::{Similarity, fit_similarity};
pub use subspace::{principal_angles_deg, subspace_mac};
pub use table::{ComparisonTable, SummedCell, TestSummary, compare, summary_of_cells};
pub use table_row::{PairedTest, Row, Status, TestCell, TheoryCell};
