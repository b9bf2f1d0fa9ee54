//! Sources that are no opened file: results in memory, and several sources merged into one.
//!
//! Writers take FRF sets, hits and modes as they take an opened file. Nothing here knows a file
//! format or opens a path.

mod from_frfs;
mod from_hits;
mod from_modes;
mod in_memory;
mod merged;

pub use from_frfs::{FrfSource, frf_source};
pub use from_hits::hit_source;
pub use from_modes::modes_source;
pub use in_memory::MemorySource;
pub use merged::Merged;
