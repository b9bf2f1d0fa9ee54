//! The screen of `check`: the missed rows and counts.

use crate::report::Block;
use crate::report::regression_check::{not_compared_block, regression_check_block};
use crate::scene::RowVerdict;

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
        "{} of {} met, {} in all.",
        rows.len() - missed.len(),
        counted(rows.len(), "row"),
        counted(checks, "check")
    );
    let mut blocks = Vec::new();
    if !missed.is_empty() {
        blocks.push(regression_check_block(&missed));
    }
    blocks.push(Block::Text(counts));
    blocks.extend(not_compared_block(not_compared));
    abridged(blocks, width)
}
