//! Entries of catalogues become hits, FRF sets and a modal model, with what a scene states about
//! them.
//!
//! A hit is a force and its responses; the header of a time record, its order in the file or a
//! scene says to which hit it belongs. An FRF set is the FRFs on one frequency axis with their
//! coherence or variance. Damage of a part of a file stops only a result that needs this part.
//!
//! Nothing here knows a file format or opens a path.

mod coherence;
mod common_window;
mod entry_quantity;
mod frf_sets;
mod hit_axis;
mod hit_file;
mod hit_grouping;
mod hits;
mod idle_forces;
mod modal_model;
pub(in crate::io) mod needed_parts;

#[cfg(test)]
mod frf_sets_tests;
#[cfg(test)]
mod hits_tests;

pub use frf_sets::frf_sets;
pub use hit_file::{ChannelOverride, HitFile, HitGrouping, StatedFrfUnit, check_stated_points};
pub use hits::{FileRecording, HitSet, group_hits};
pub use modal_model::modal_model_of;
pub use needed_parts::{Need, check_damage};
