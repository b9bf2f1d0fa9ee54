//! Of several hammers at a structure one hits; the channels of the others record nothing.

use std::collections::{BTreeMap, BTreeSet};

use crate::io::{Block, FunctionType, HitFile, HitGrouping, IoError};
use crate::quantity::Quantity;

/// Largest peak of an idle hammer over that of the one that hits. Larger: of two shakers that both
/// excite, the weaker is left out and the FRFs are wrong. Smaller: cross-talk of cables, some
/// percent, makes an idle hammer a second excitation (`an_idle_hammer_is_left_out`).
const MAX_IDLE_PEAK: f64 = 0.05;

/// The force records of idle hammers of a file.
///
/// Forces of one version and load case belong to one hit; where no version is stated, forces that
/// follow each other do, and with each file a hit all of them.
///
/// # Errors
/// As [`crate::io::Source::read`].
pub(super) fn idle_forces(
    file: &mut HitFile,
    grouping: HitGrouping,
) -> Result<BTreeSet<usize>, IoError> {
    let mut idle = BTreeSet::new();
    for forces in competing_forces(file, grouping) {
        let mut peaks = Vec::with_capacity(forces.len());
        for &index in &forces {
            peaks.push(peak(file, index)?);
        }
        let largest = peaks.iter().copied().fold(0.0, f64::max);
        let is_idle = |peak: &f64| *peak <= MAX_IDLE_PEAK * largest;
        let numbered = forces.iter().zip(&peaks);
        idle.extend(
            numbered
                .filter(|(_, peak)| is_idle(peak))
                .map(|(index, _)| *index),
        );
    }
    Ok(idle)
}

/// Groups of two force records and more of which one hits.
fn competing_forces(file: &HitFile, grouping: HitGrouping) -> Vec<Vec<usize>> {
    let entries = &file.source.catalog().entries;
    let records = entries.iter().enumerate();
    let times: Vec<usize> = records
        .filter(|(_, entry)| entry.function_type == FunctionType::Time)
        .map(|(index, _)| index)
        .collect();
    let is_force = |index: &usize| entries[*index].quantity == Some(Quantity::Force);
    let mut by_hit: BTreeMap<(i64, i64, usize), Vec<usize>> = BTreeMap::new();
    let numbers = |index: &usize| {
        let identification = &entries[*index].identification;
        (identification.version, identification.load_case)
    };
    let is_numbered = times
        .iter()
        .any(|index| numbers(index) != numbers(&times[0]));
    let mut run = 0;
    for (place, index) in times.iter().enumerate() {
        let follows_response = place > 0 && !is_force(&times[place - 1]);
        run += usize::from(is_force(index) && follows_response);
        if is_force(index) {
            let (version, load_case) = numbers(index);
            let key = match (grouping, is_numbered) {
                (HitGrouping::Files, _) => (0, 0, 0),
                (_, true) => (version, load_case, 0),
                (_, false) => (0, 0, run),
            };
            by_hit.entry(key).or_default().push(*index);
        }
    }
    by_hit
        .into_values()
        .filter(|forces| forces.len() > 1)
        .collect()
}

/// Largest distance of a record from its mean, in SI where its unit is known.
fn peak(file: &mut HitFile, index: usize) -> Result<f64, IoError> {
    let entry = &file.source.catalog().entries[index];
    let (len, to_si) = (entry.len(), entry.to_si.unwrap_or(1.0));
    let mut block = Block::F64(Vec::new());
    file.source.read(index, 0..len, &mut block)?;
    let values: Vec<f64> = match block {
        Block::F32(values) => values.into_iter().map(f64::from).collect(),
        Block::F64(values) => values,
        Block::Complex(_) => return Ok(f64::INFINITY),
    };
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let distances = values.iter().map(|value| (value - mean).abs());
    Ok(to_si.abs() * distances.fold(0.0, f64::max))
}
