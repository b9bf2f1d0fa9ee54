//! The CSV renderer writes every table with its heads; numbers have full precision, missing fields
//! are empty.

use crate::printable::printable_line;

use super::{Block, Cell, Renderer, Table};

/// Renders the tables of a report as CSV, without headings, paragraphs, footnotes and findings.
pub struct CsvText;

impl Renderer for CsvText {
    fn name(&self) -> &'static str {
        "csv"
    }

    fn extension(&self) -> &'static str {
        "csv"
    }

    fn render(&self, blocks: &[Block]) -> String {
        let tables = blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table_text(table)),
            _ => None,
        });
        tables.collect::<Vec<_>>().join("\n")
    }
}

fn cell_field(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => field(text.clone()),
        number => number.exact(),
    }
}

/// A text that no spreadsheet program takes for a formula: with an apostrophe before signs that
/// begin one, and control characters shown.
fn field(text: String) -> String {
    let begins_formula = text
        .trim_start()
        .starts_with(['=', '+', '-', '@', '＝', '＋', '－', '＠']);
    // A printed number is no formula.
    let is_formula = begins_formula && text.trim().parse::<f64>().is_err();
    let text = printable_line(&text);
    match is_formula {
        true => format!("'{text}"),
        false => text.into_owned(),
    }
}

fn table_text(table: &Table) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let heads = std::iter::once(
        table
            .columns
            .iter()
            .map(|column| field(column.head.replace('\n', " ")))
            .collect::<Vec<_>>(),
    );
    let rows = table
        .rows
        .iter()
        .map(|row| row.iter().map(cell_field).collect::<Vec<_>>());
    for record in heads.chain(rows) {
        writer
            .write_record(&record)
            .expect("a vector takes every byte, and rows are as long as the head");
    }
    let bytes = writer.into_inner().expect("a vector takes every byte");
    String::from_utf8(bytes).expect("fields are text")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_field_is_a_formula() {
        for (text, expected) in [
            ("=HYPERLINK(\"http://x\")", "'=HYPERLINK(\"http://x\")"),
            ("+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"),
            ("-1+1", "'-1+1"),
            ("@SUM(A1)", "'@SUM(A1)"),
            (" \t=1", "' \\t=1"),
            ("-12.5", "-12.5"),
            ("+3e-4", "+3e-4"),
            ("a=b", "a=b"),
            ("two\nlines", "two\\nlines"),
        ] {
            assert_eq!(field(text.to_owned()), expected);
        }
    }
}
