//! The screen of `check`: the missed rows and counts.

use crate::report::Block;
use crate::report::regression_check::{not_compared_block, regression_check_block};
use crate::scene::{LimitCheck, RowVerdict};

use super::sentences::{MAX_NAMED_KINDS, limit, limited_kinds, nearest_limit};
use super::{abridged, counted};

/// The rows with a missed check, how many rows and checks are met, and which values of a baseline
/// are not compared.
pub fn regression_check_screen(
    rows: &[RowVerdict],
    not_compared: &[String],
    width: usize,
) -> Vec<Block> {
    let missed: Vec<RowVerdict> = rows.iter().filter(|row| !row.is_met()).cloned().collect();
    let checks = rows.iter().map(|row| row.checks.len()).sum();
    let counts = format!(
        "{} of {} met, {} in all{}.",
        rows.len() - missed.len(),
        counted(rows.len(), "row"),
        counted(checks, "check"),
        named_checks(rows)
    );
    let mut blocks = Vec::new();
    if !missed.is_empty() {
        blocks.push(regression_check_block(&missed));
    }
    blocks.push(Block::Text(counts));
    blocks.extend(not_compared_block(not_compared));
    abridged(blocks, width)
}

/// The check that is nearest to being missed, where all are met; of counts alone what they count.
fn named_checks(rows: &[RowVerdict]) -> String {
    let of_row = |row: &RowVerdict| {
        let checks = row.checks.iter().cloned();
        let what = |check: &LimitCheck| format!("{}: {}", row.row, check.what);
        let named = checks.map(|check| LimitCheck {
            what: what(&check),
            ..check
        });
        named.collect::<Vec<_>>()
    };
    if !rows.iter().all(RowVerdict::is_met) {
        return String::new();
    }
    let checks: Vec<LimitCheck> = rows.iter().flat_map(of_row).collect();
    match (nearest_limit(&checks), limited_kinds(&checks).as_slice()) {
        (Some(nearest), _) => format!("; nearest {}", limit(nearest)),
        (None, few) if few.len() <= MAX_NAMED_KINDS => format!(": {}", few.join(", ")),
        _ => String::new(),
    }
}
