//! The screen of `frf`: hits used and rejected by reason, FRFs, and their coherence in the band.

use std::collections::{BTreeMap, BTreeSet};

use crate::axis::Band;
use crate::frf::{BeforeYouLeave, Estimator, FrfSet, HitReport};
use crate::report::frf::{hits_block, median};
use crate::report::table::significant;
use crate::report::{Block, Cell, before_you_leave_screen};
use crate::signal::{Check, Outcome};

use super::abridged::cut_rows;
use super::{MAC_DECIMALS, abridged, counted};

/// Rows of rejected hits: more leave no room for the section below.
const MAX_REJECTED_ROWS: usize = 8;

/// Counts of hits and FRFs, the coherence in the usable band, the rejected hits, and what to repeat
/// before the structure is gone.
pub fn hits_screen(
    hits: &[HitReport],
    set: &FrfSet,
    usable: Band,
    list: &BeforeYouLeave,
    width: usize,
) -> Vec<Block> {
    let sentences = [
        hit_sentence(hits, 1),
        frf_sentence(set, usable),
        coherence_sentence(set, usable),
    ];
    let mut blocks = vec![Block::Text(sentences.join("\n"))];
    let rejected: Vec<HitReport> = hits.iter().filter(|hit| !hit.used).cloned().collect();
    if !rejected.is_empty() {
        let mut block = hits_block("Rejected hits", &rejected);
        if let Block::Table(table) = block {
            block = Block::Table(cut_rows(table, MAX_REJECTED_ROWS));
        }
        blocks.push(block);
    }
    let mut blocks = abridged(blocks, width);
    blocks.push(before_you_leave_screen(list));
    blocks
}

/// How many hits of so many tests were used, and how many were rejected for each reason.
pub(super) fn hit_sentence(hits: &[HitReport], tests: usize) -> String {
    let hits_of = match tests {
        0 | 1 => "Hits".to_owned(),
        _ => format!("Hits of {tests} tests"),
    };
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for hit in hits.iter().filter(|hit| !hit.used) {
        let rejecting = |check: &&Check| check.outcome == Outcome::Rejected;
        let first = hit.checks.iter().find(rejecting);
        let reason = match (hit.stated, first) {
            (true, _) => "stated",
            (false, Some(check)) => check.rule.name(),
            (false, None) => "other",
        };
        *reasons.entry(reason).or_default() += 1;
    }
    let rejected: usize = reasons.values().sum();
    let used = hits.len() - rejected;
    let reasons: Vec<String> = reasons
        .iter()
        .map(|(name, n)| format!("{name} {n}"))
        .collect();
    match rejected {
        // Blocks of continuous excitation, whose averages the FRFs state.
        0 if hits.is_empty() => "Hits: none, excitation by a shaker.".to_owned(),
        0 => format!("{hits_of}: all {used} used."),
        _ => format!(
            "{hits_of}: {used} of {} used; rejected: {}.",
            hits.len(),
            reasons.join(", ")
        ),
    }
}

fn frf_sentence(set: &FrfSet, usable: Band) -> String {
    let functions = set.functions();
    let responses: BTreeSet<_> = functions.iter().map(|f| &f.response).collect();
    let references: BTreeSet<_> = functions.iter().map(|f| &f.reference).collect();
    let kinds: BTreeSet<String> = functions.iter().map(|f| f.kind.to_string()).collect();
    let estimators = functions
        .iter()
        .filter_map(|f| f.estimator.map(Estimator::name));
    let estimators: BTreeSet<&str> = estimators.collect();
    let averages = functions.iter().filter_map(|f| f.averages);
    let averages = match (averages.clone().min(), averages.max()) {
        (Some(least), Some(most)) if least == most => {
            format!(", {}", counted(most as usize, "average"))
        }
        (Some(least), Some(most)) => format!(", {least} to {most} averages"),
        _ => String::new(),
    };
    let words: Vec<&str> = kinds.iter().map(String::as_str).chain(estimators).collect();
    format!(
        "FRFs: {} ({} by {}), {}{averages}; {} by {} Hz; usable band {:.1} to {:.1} Hz.",
        set.len(),
        counted(responses.len(), "response"),
        counted(references.len(), "excitation point"),
        words.join(", "),
        counted(set.axis().len, "line"),
        significant(set.axis().step_hz, 6),
        usable.lo_hz,
        usable.hi_hz
    )
}

fn coherence_sentence(set: &FrfSet, usable: Band) -> String {
    let lines = set.axis().lines(&usable);
    let of_function = |index: usize| {
        let coherence = set.coherence(index)?;
        Some((index, median(&coherence[lines.clone()])?))
    };
    let all = (0..set.len()).filter_map(of_function);
    let lowest = all.clone().min_by(|(_, a), (_, b)| a.total_cmp(b));
    let highest = all.map(|(_, median)| median).max_by(f64::total_cmp);
    let Some(((index, lowest), highest)) = lowest.zip(highest) else {
        let why = match (0..set.len()).any(|index| set.coherence(index).is_some()) {
            true => "no line is in the usable band",
            false => "it takes two averages or more",
        };
        return format!("Coherence: none, {why}.");
    };
    let function = &set.functions()[index];
    let text = |coherence: f64| Cell::mac(Some(coherence), MAC_DECIMALS).display();
    if set.len() == 1 {
        return format!("Coherence in that band, median: {}.", text(lowest));
    }
    format!(
        "Coherence in that band, median of each FRF: {} to {}, lowest at {}/{}.",
        text(lowest),
        text(highest),
        function.response,
        function.reference
    )
}
