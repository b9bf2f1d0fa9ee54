//! A breakdown map shows where methods fail: the share of seeded draws of a small structure in
//! which each method identifies the modes to a stated error, over two factors.
//!
//! | file | content |
//! |---|---|
//! | `plan` | [`BreakdownTable`]: `[breakdown]` of `study.toml` as typed; [`Plan`]: the checked plan |
//! | `factor` | [`Factor`]: quantity that a slice varies; [`Axis`]: its values |
//! | `case` | [`Case`]: three modes on a line of sensors |
//! | `draw` | FRFs with white noise, or a hammer test through [`crate::frf::evaluate_hammer_test`], from the seed of a cell's coordinates |
//! | `failure_mode` | [`StatedError`], and the [`FailureMode`] of a draw that does not meet it |
//! | `wilson` | [`wilson_interval`]: the interval of a counted share |
//! | `grid` | [`Grid`]: cells halved near a contour |
//! | `slice` | [`Slice`]: draws of all cells; [`SliceResult`]: counted successes |
//! | `contour` | lines and places where a share crosses 95 % |
//! | `user_modes` | [`UserMode`]: a user's modes in a slice, and their distance from where a method fails |
//! | `summary` | a slice in words |
//! | `verdict` | [`breakdown_verdict`]: the method to use and where it fails |
//! | `stability` | [`Stability`]: digits lost by order, in f64 and in f32 |
//! | `store` | [`compute`], [`merge`]: finished slices kept by a [`CellStore`] |
//!
//! A contour is valid for this case alone: a map shows in which direction and roughly where a
//! method fails, and gives no limit that holds for every structure.

mod case;
mod contour;
mod draw;
mod error;
mod factor;
mod failure_mode;
mod grid;
mod plan;
mod slice;
#[cfg(test)]
mod slice_tests;
mod stability;
mod store;
mod summary;
mod user_modes;
mod verdict;
mod wilson;

pub use case::Case;
pub use contour::Point;
pub use error::BreakdownError;
pub use factor::{Axis, FACTORS, Factor, Scale};
pub use failure_mode::{FAILURE_MODES, FailureMode, StatedError};
pub use grid::{Field, Grid, Node};
pub use plan::{
    AxisTable, BreakdownTable, CaseTable, Plan, SliceTable, StabilityTable, StatedTable,
};
pub use slice::{
    Cell, MIN_SUCCESS_RATE, MethodTime, Slice, SliceResult, SuccessCount, SuccessRate,
};
pub use stability::{Stability, StabilityCurve, StabilityPlan, StabilityPoint};
pub use store::{BreakdownResults, CellStore, Part, compute, merge};
pub use summary::{SuccessRange, ranges_text, short_number};
pub use user_modes::{Distance, Margin, UserMode, UserModePosition, user_modes};
pub use verdict::breakdown_verdict;
pub use wilson::wilson_interval;
