//! The screen of `check`: the missed rows and counts.

use crate::report::{Block, regression_check_block};
use crate::scene::RowVerdict;

use super::{abridged, counted};

/// The rows with a missed check, then how many rows and checks are met.
pub fn regression_check_screen(rows: &[RowVerdict], width: usize) -> Vec<Block> {
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
    abridged(blocks, width)
}
