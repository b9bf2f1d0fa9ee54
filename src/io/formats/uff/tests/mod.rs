//! Universal files built from bytes, and files of measurement systems.

mod damage;
pub(super) mod file_builder;
mod functions;
mod geometry;
mod geometry_round_trip;
mod joined;
mod layouts;
mod modes;
mod mutation;
mod recorded_geometry;
mod recordings;
mod round_trip;
mod write;
