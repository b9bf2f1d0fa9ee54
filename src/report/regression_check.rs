//! The table of `check` compares results with their limits, row by row.

use crate::printable::counted;
use crate::scene::{LimitCheck, RowVerdict};

use super::verdict::Verdict;
use super::{Block, Cell, Column, Table};

/// The table of all checks, then the values that the baseline has and that are not compared.
pub fn regression_check_blocks(rows: &[RowVerdict], not_compared: &[String]) -> Vec<Block> {
    let mut blocks = vec![regression_check_block(rows)];
    blocks.extend(not_compared_block(not_compared));
    blocks
}

/// Keys of the baseline whose values are not compared.
pub(super) fn not_compared_block(keys: &[String]) -> Option<Block> {
    let text = format!("Not compared with the baseline: {}.", keys.join(", "));
    (!keys.is_empty()).then_some(Block::Text(text))
}

/// A row for each check; the first check of a result has the name of the result and its verdict.
pub(super) fn regression_check_block(rows: &[RowVerdict]) -> Block {
    let missed = rows.iter().filter(|row| !row.is_met()).count();
    let caption = match missed {
        0 => format!("{}, all met", counted(rows.len(), "row")),
        missed => format!("{}, {missed} MISSED", counted(rows.len(), "row")),
    };
    Block::Table(Table {
        caption,
        columns: vec![
            Column::text("row"),
            Column::text("verdict"),
            Column::text("what"),
            Column::number("value"),
            Column::text("allowed"),
            Column::text(""),
        ],
        rows: rows.iter().flat_map(check_rows).collect(),
        footnotes: Vec::new(),
    })
}

fn check_rows(row: &RowVerdict) -> impl Iterator<Item = Vec<Cell>> + '_ {
    row.checks.iter().enumerate().map(|(index, check)| {
        let (name, verdict) = match index {
            0 => (row.row.as_str(), Verdict::of_limit(row.is_met()).text()),
            _ => ("", ""),
        };
        let value = check
            .value
            .map_or(Cell::Missing, |value| Cell::text(four_digits(value)));
        vec![
            Cell::text(name),
            Cell::text(verdict),
            Cell::text(&check.what),
            value,
            Cell::text(limit_text(check)),
            Cell::text(match check.is_met() {
                true => "",
                false => Verdict::Missed.text(),
            }),
        ]
    })
}

fn limit_text(check: &LimitCheck) -> String {
    let relation = if check.upper { "at most" } else { "at least" };
    format!("{relation} {}", four_digits(check.limit))
}

/// A number with four significant digits.
fn four_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}
