//! The terminal renderer writes plain text with aligned columns.

use unicode_width::UnicodeWidthStr;

use super::{Align, Block, Column, Renderer, Table};

/// Renders for a terminal, without colour.
pub struct Terminal;

impl Renderer for Terminal {
    fn name(&self) -> &'static str {
        "terminal"
    }

    fn extension(&self) -> &'static str {
        "txt"
    }

    fn render(&self, blocks: &[Block]) -> String {
        let parts: Vec<String> = blocks
            .iter()
            .map(block_text)
            .filter(|text| !text.is_empty())
            .collect();
        parts.join("\n\n") + "\n"
    }
}

fn block_text(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("{text}\n{}", "=".repeat(text.chars().count())),
        Block::Text(text) => text.clone(),
        Block::Table(table) => table_text(table),
        Block::Findings { findings, language } => findings
            .iter()
            .map(|finding| {
                let severity = language.severity(finding.severity);
                let sentence = language.finding(finding);
                format!("{severity}: {sentence} [{}]", finding.code.name())
            })
            .collect::<Vec<_>>()
            .join("\n"),
    }
}

fn table_text(table: &Table) -> String {
    let head: Vec<&str> = table.columns.iter().map(|c| c.head.as_str()).collect();
    let rows: Vec<Vec<String>> = table
        .rows
        .iter()
        .map(|row| row.iter().map(|cell| cell.display()).collect())
        .collect();
    let widths = widths(&head, &rows);
    let mut lines = Vec::new();
    push_row(&mut lines, &head, &table.columns, &widths);
    let head_lines = lines.len();
    for row in &rows {
        push_row(&mut lines, row, &table.columns, &widths);
    }
    let width = lines.iter().map(|line| line.width()).max().unwrap_or(0);
    let rule = "-".repeat(width);
    lines.insert(head_lines, rule.clone());
    let mut text = format!("{}\n{rule}\n{}\n{rule}", table.caption, lines.join("\n"));
    for note in &table.footnotes {
        text += &format!("\n{note}");
    }
    text
}

/// Width of each column on a screen.
fn widths(head: &[&str], rows: &[Vec<String>]) -> Vec<usize> {
    let widest = |text: &str| text.lines().map(UnicodeWidthStr::width).max().unwrap_or(0);
    let mut widths: Vec<usize> = head.iter().map(|text| widest(text)).collect();
    for row in rows {
        for (width, text) in widths.iter_mut().zip(row) {
            *width = (*width).max(widest(text));
        }
    }
    widths
}

/// Adds the lines of one row, whose cells may have several.
fn push_row<T: AsRef<str>>(
    lines: &mut Vec<String>,
    cells: &[T],
    columns: &[Column],
    widths: &[usize],
) {
    let count = cells.iter().map(|cell| cell.as_ref().lines().count());
    for number in 0..count.max().unwrap_or(0).max(1) {
        let mut line = String::new();
        for ((cell, column), width) in cells.iter().zip(columns).zip(widths) {
            let text = cell.as_ref().lines().nth(number).unwrap_or_default();
            let missing = " ".repeat(width - text.width());
            line += " ";
            match column.align {
                Align::Right => line.extend([&missing, text]),
                Align::Left => line.extend([text, &missing]),
            }
            line += " ";
        }
        line.truncate(line.trim_end().len());
        lines.push(line);
    }
}
