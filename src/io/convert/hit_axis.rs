//! The time axis of one hit, whose channels may start apart by parts of a sample and end apart by a
//! few samples, as recorders of several clocks write them.

use crate::axis::TimeAxis;
use crate::io::{Entry, EntryAxis, IoError};

/// Channels of one hit start and end within this number of samples of each other. Larger: records
/// of a trigger that came a moment later are taken for channels of this hit. Smaller: a recorder
/// whose modules start some samples apart makes no hits
/// (`channels_of_other_records_are_named_with_the_reason`).
const MAX_APART_SAMPLES: f64 = 16.0;
/// Largest relative difference of the time steps.
const MAX_STEP_DIFFERENCE: f64 = 1e-9;

/// Whether two axes can be those of channels of one hit.
pub(super) fn belong_together(one: &EntryAxis, other: &EntryAxis) -> bool {
    let (EntryAxis::Time(one), EntryAxis::Time(other)) = (one, other) else {
        return one == other;
    };
    let apart_s = (one.start_s - other.start_s).abs();
    (one.step_s - other.step_s).abs() <= MAX_STEP_DIFFERENCE * one.step_s
        && apart_s <= MAX_APART_SAMPLES * one.step_s
        && one.len.abs_diff(other.len) as f64 <= MAX_APART_SAMPLES
}

/// The axis of the first channel, as long as the shortest of them.
///
/// # Errors
/// [`IoError::Grouping`] for channels that do not belong together.
pub(super) fn common_axis(
    entries: &[Entry],
    group: &[usize],
    path: &str,
) -> Result<TimeAxis, IoError> {
    let error = |got: String| IoError::Grouping {
        path: path.to_owned(),
        what: "sampling of the channels of one hit",
        got,
        expected: "one spacing, and starts and ends within 16 samples of each other".to_owned(),
    };
    let described = |axis: &TimeAxis| {
        format!(
            "{} samples by {} s from {} s",
            axis.len, axis.step_s, axis.start_s
        )
    };
    let mut axes: Vec<TimeAxis> = Vec::with_capacity(group.len());
    for index in group {
        let EntryAxis::Time(axis) = entries[*index].axis else {
            let axis = match entries[*index].axis {
                EntryAxis::Frequency(_) => "a frequency axis",
                _ => "an uneven axis",
            };
            return Err(error(format!("record {} on {axis}", index + 1)));
        };
        let is_apart =
            |other: &&TimeAxis| !belong_together(&EntryAxis::Time(**other), &EntryAxis::Time(axis));
        if let Some(other) = axes.iter().find(is_apart) {
            return Err(error(format!(
                "{} and {} at record {}",
                described(other),
                described(&axis),
                index + 1
            )));
        }
        axes.push(axis);
    }
    let shortest = axes.iter().map(|axis| axis.len).min();
    let first = axes.first().copied().zip(shortest);
    let common = first.map(|(axis, len)| TimeAxis { len, ..axis });
    common.ok_or_else(|| error("no record".to_owned()))
}
