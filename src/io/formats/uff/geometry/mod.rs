//! Geometry of a universal file: nodes (datasets 15, 781, 2411), coordinate systems (18, 2420),
//! trace lines (82), elements (2412) and groups (2467), from lines to fields and back.
//!
//! `nodes` and `systems` hold what several of these datasets state. Nothing here reads a file: the
//! scanner (`scan`) gives the lines of each dataset.

pub(super) mod dataset_15;
pub(super) mod dataset_18;
pub(super) mod dataset_2411;
pub(super) mod dataset_2412;
pub(super) mod dataset_2420;
pub(super) mod dataset_2467;
pub(super) mod dataset_82;
pub(super) mod nodes;
pub(super) mod systems;
pub(super) mod write;
