//! The Markdown renderer writes pipe tables.

use super::{Align, Block, Renderer, Table};

/// Renders Markdown.
pub struct Markdown;

impl Renderer for Markdown {
    fn name(&self) -> &'static str {
        "markdown"
    }

    fn extension(&self) -> &'static str {
        "md"
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

fn escape(text: &str) -> String {
    text.replace('\\', "\\\\")
        .replace('|', "\\|")
        .replace('\n', " ")
}

fn block_text(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("## {text}"),
        Block::Text(text) => text.clone(),
        Block::Table(table) => table_text(table),
        Block::Findings { findings, language } => findings
            .iter()
            .map(|finding| {
                format!(
                    "- **{}** {} `{}`",
                    language.severity(finding.severity),
                    escape(&language.finding(finding)),
                    finding.code.name()
                )
            })
            .collect::<Vec<_>>()
            .join("\n"),
    }
}

fn line(fields: impl Iterator<Item = String>) -> String {
    format!("| {} |", fields.collect::<Vec<_>>().join(" | "))
}

fn table_text(table: &Table) -> String {
    let rule = table.columns.iter().map(|column| match column.align {
        Align::Left => "---".to_owned(),
        Align::Right => "---:".to_owned(),
    });
    let mut lines = vec![format!("**{}**", table.caption), String::new()];
    lines.push(line(
        table.columns.iter().map(|column| escape(&column.head)),
    ));
    lines.push(line(rule));
    lines.extend(
        table
            .rows
            .iter()
            .map(|row| line(row.iter().map(|cell| escape(&cell.display())))),
    );
    for note in &table.footnotes {
        lines.push(String::new());
        lines.push(format!("*{}*", escape(note)));
    }
    lines.join("\n")
}
