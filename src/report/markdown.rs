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

/// The text on a line, whose signs are none of Markdown. Words between backticks remain code.
fn escape(text: &str) -> String {
    let has_code = text.matches('`').count().is_multiple_of(2);
    let mut is_code = false;
    let mut escaped = String::with_capacity(text.len());
    let mut characters = text.chars().peekable();
    while let Some(c) = characters.next() {
        let begins_tag = |next: &char| next.is_ascii_alphabetic() || matches!(next, '/' | '!');
        let is_sign = match c {
            // Tables read this sign in code, too.
            '|' => true,
            _ if is_code => false,
            '\\' | '*' => true,
            '`' => !has_code,
            '<' => characters.peek().is_some_and(begins_tag),
            _ => false,
        };
        is_code ^= c == '`' && has_code;
        if is_sign {
            escaped.push('\\');
        }
        escaped.push(if c == '\n' { ' ' } else { c });
    }
    escaped
}

fn block_text(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("## {}", escape(text)),
        Block::Text(text) => text.lines().map(escape).collect::<Vec<_>>().join("\n"),
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
    let mut lines = match table.caption.is_empty() {
        true => Vec::new(),
        false => vec![format!("**{}**", escape(&table.caption)), String::new()],
    };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Cell, Column};

    #[test]
    fn signs_of_markdown_are_escaped_outside_code() {
        for (text, expected) in [
            ("|error| of 2*3*4", "\\|error\\| of 2\\*3\\*4"),
            ("a\\b <test> < -1000", "a\\\\b \\<test> < -1000"),
            ("beam `a*b|c`", "beam `a*b\\|c`"),
            ("one ` alone", "one \\` alone"),
            ("a\nb", "a b"),
        ] {
            assert_eq!(escape(text), expected);
        }
    }

    #[test]
    fn captions_and_paragraphs_are_escaped() {
        let table = Table {
            caption: "Test *2*".to_owned(),
            columns: vec![Column::text("mode")],
            rows: vec![vec![Cell::text("f1")]],
            ..Table::default()
        };
        let uncaptioned = Table {
            caption: String::new(),
            ..table.clone()
        };
        let text = Markdown.render(&[
            Block::Text("one * two\nthree".to_owned()),
            Block::Table(table),
            Block::Table(uncaptioned),
        ]);
        assert!(text.starts_with("one \\* two\nthree\n"), "{text}");
        assert!(text.contains("**Test \\*2\\***"), "{text}");
        assert!(!text.contains("****"), "{text}");
    }
}
