//! Plain text with aligned columns, for a terminal.

use comfy_table::{CellAlignment, ContentArrangement, presets};

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
        Block::Findings(findings) => findings
            .iter()
            .map(|finding| format!("{}: {finding} [{}]", finding.severity, finding.code.name()))
            .collect::<Vec<_>>()
            .join("\n"),
    }
}

fn table_text(table: &Table) -> String {
    let mut grid = comfy_table::Table::new();
    grid.load_preset(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Disabled);
    grid.set_header(table.columns.iter().map(|column| &column.head));
    for row in &table.rows {
        grid.add_row(row.iter().map(|cell| cell.display()));
    }
    for (index, column) in table.columns.iter().enumerate() {
        if let (Align::Right, Some(place)) = (column.align, grid.column_mut(index)) {
            place.set_cell_alignment(CellAlignment::Right);
        }
    }
    let lines: Vec<String> = grid
        .lines()
        .map(|line| line.trim_end().to_owned())
        .collect();
    let width = lines
        .iter()
        .map(|line| line.chars().count())
        .max()
        .unwrap_or(0);
    let rule = "-".repeat(width);
    let mut text = format!("{}\n{rule}\n", table.caption);
    let head_lines = |column: &Column| column.head.lines().count();
    let head = table.columns.iter().map(head_lines).max().unwrap_or(1);
    for (number, line) in (1..).zip(&lines) {
        text += line;
        text += "\n";
        if number == head {
            text += &format!("{rule}\n");
        }
    }
    text += &rule;
    for note in &table.footnotes {
        text += &format!("\n{note}");
    }
    text
}
