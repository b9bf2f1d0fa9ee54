//! Tests of whole identifications: accuracy, methods, options, failures.

mod accuracy;
mod beam;
mod failed_decompositions;
mod high_snr;
mod hump;
mod methods;
mod ml;
mod noise_free_hits;
mod options;
mod peak_columns;
mod rank;
mod stepped_sine;

use std::ops::Range;

/// Seeds of a slow test: the first quarter of `all`, rounded up; all of them with the environment
/// variable `ALL_DRAWS`.
pub(in crate::identify) fn seeds(all: u64) -> Range<u64> {
    let has_all = std::env::var_os("ALL_DRAWS").is_some();
    0..all.div_ceil(if has_all { 1 } else { 4 })
}
