//! Text other than universal files: tables of numbers (CSV and its kin) and the exports of two
//! measurement systems.
//!
//! A text is read in blocks ([`encoding::TextBlocks`]); its numbers are parsed straight from the
//! bytes. Samples are kept in a [`MemorySource`](crate::io::MemorySource).

mod columns;
mod complex;
mod dialect;
mod dof_text;
mod encoding;
mod entries;
mod fields;
mod header_syntax;
mod header_units;
mod pulse;
mod signalcalc;
mod table;
mod write;

#[cfg(test)]
mod dialect_tests;
#[cfg(test)]
mod recording_tests;
#[cfg(test)]
mod table_tests;
#[cfg(test)]
mod vendor_tests;
#[cfg(test)]
mod write_tests;

pub(in crate::io::formats) use dof_text::printed_dof;
pub(in crate::io::formats) use entries::{axis_of, report_uneven_axis};
pub(in crate::io::formats) use header_syntax::{Abscissa, StatedUnit};
pub(in crate::io::formats) use signalcalc::ratio_unit;

pub use pulse::Pulse;
pub use signalcalc::SignalCalc;
pub use table::Table;
