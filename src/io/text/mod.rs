//! Text other than universal files: tables of numbers (CSV and its kin) and the exports of two
//! measurement systems.
//!
//! A text is read in blocks; its numbers are parsed straight from the bytes.

mod blocks;
mod columns;
mod dof_text;
mod entries;
mod heading;
mod heading_units;
mod layout;
mod pulse;
mod row;
mod signalcalc;
mod table;
mod write;

#[cfg(test)]
mod layout_tests;
#[cfg(test)]
mod recording_tests;
#[cfg(test)]
mod table_tests;
#[cfg(test)]
mod vendor_tests;
#[cfg(test)]
mod write_tests;

pub use pulse::Pulse;
pub use signalcalc::SignalCalc;
pub use table::Table;
