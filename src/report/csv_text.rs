//! The CSV renderer writes every table with its heads; numbers have full precision, missing fields
//! are empty.

use super::{Block, Renderer, Table};

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

fn table_text(table: &Table) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let heads = std::iter::once(
        table
            .columns
            .iter()
            .map(|column| column.head.replace('\n', " "))
            .collect::<Vec<_>>(),
    );
    let rows = table
        .rows
        .iter()
        .map(|row| row.iter().map(|cell| cell.exact()).collect::<Vec<_>>());
    for record in heads.chain(rows) {
        writer
            .write_record(&record)
            .expect("a vector takes every byte, and rows are as long as the head");
    }
    let bytes = writer.into_inner().expect("a vector takes every byte");
    String::from_utf8(bytes).expect("fields are text")
}
