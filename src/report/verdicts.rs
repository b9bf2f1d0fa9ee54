//! The table of `check` compares results with their limits, row by row.

use crate::scene::{LimitCheck, RowVerdict};

use super::block::{Block, Cell, Column, Table};
use super::verdict::Verdict;

/// A line for each check under the name of its row, with the verdict on the row in its first line.
pub fn verdicts_block(rows: &[RowVerdict]) -> Block {
    let missed = rows.iter().filter(|row| !row.is_met()).count();
    let caption = match missed {
        0 => format!("{} rows, all met", rows.len()),
        missed => format!("{} rows, {missed} MISSED", rows.len()),
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
        rows: rows.iter().flat_map(lines).collect(),
        footnotes: Vec::new(),
    })
}

fn lines(row: &RowVerdict) -> impl Iterator<Item = Vec<Cell>> + '_ {
    row.checks.iter().enumerate().map(|(index, check)| {
        let (name, verdict) = match index {
            0 => (row.row.as_str(), Verdict::of_limit(row.is_met()).text()),
            _ => ("", ""),
        };
        let value = check
            .value
            .map_or(Cell::Missing, |value| Cell::text(number(value)));
        vec![
            Cell::text(name),
            Cell::text(verdict),
            Cell::text(&check.what),
            value,
            Cell::text(allowed(check)),
            Cell::text(match check.is_met() {
                true => "",
                false => Verdict::Missed.text(),
            }),
        ]
    })
}

fn allowed(check: &LimitCheck) -> String {
    let relation = if check.upper { "at most" } else { "at least" };
    format!("{relation} {}", number(check.limit))
}

/// Four significant digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}
