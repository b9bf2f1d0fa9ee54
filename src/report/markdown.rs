//! The Markdown renderer writes pipe tables.

use crate::printable::printable;

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

/// The text on a line, whose signs are none of Markdown: a title of a file makes no element.
fn escape(text: &str) -> String {
    let text = printable(text);
    let characters: Vec<char> = text.chars().collect();
    let mut escaped = String::with_capacity(text.len());
    for (index, &c) in characters.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| characters[before]);
        let after = characters.get(index + 1).copied();
        let is_in_word = |side: Option<char>| side.is_some_and(char::is_alphanumeric);
        let is_sign = match c {
            '\\' | '`' | '*' | '|' | '~' | '$' => true,
            '_' => !(is_in_word(before) && is_in_word(after)),
            '<' => after.is_some_and(|c| c.is_ascii_alphabetic() || matches!(c, '/' | '!' | '?')),
            '&' => after.is_some_and(|c| c.is_ascii_alphanumeric() || c == '#'),
            ']' => matches!(after, Some('(' | '[' | ':')),
            // Addresses become links without brackets.
            ':' => after == Some('/'),
            '.' => is_www(&characters[..index]),
            '@' => is_in_word(before) && is_in_word(after),
            _ => false,
        };
        if is_sign {
            escaped.push('\\');
        }
        escaped.push(if matches!(c, '\n' | '\t') { ' ' } else { c });
    }
    escaped
}

/// Whether a text ends like the beginning of an address.
fn is_www(before: &[char]) -> bool {
    let last = &before[before.len().saturating_sub(3)..];
    last.len() == 3 && last.iter().all(|c| matches!(c, 'w' | 'W'))
}

/// A line of a paragraph, which begins no heading, quotation, numbered list or block of code.
fn escaped_line(line: &str) -> String {
    let line = escape(line.trim_start());
    let digits = line.len() - line.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (number, rest) = line.split_at(digits);
    let begins_block = match digits {
        0 => rest.starts_with(['#', '>', '-', '+', '=']) && !rest.starts_with("- "),
        _ => [". ", ") "].iter().any(|mark| rest.starts_with(mark)) || matches!(rest, "." | ")"),
    };
    match begins_block {
        true => format!("{number}\\{rest}"),
        false => line,
    }
}

fn block_text(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("## {}", escape(text)),
        Block::Text(text) => text
            .lines()
            .map(escaped_line)
            .collect::<Vec<_>>()
            .join("\n"),
        Block::Table(table) => table_text(&table.without_missing_columns()),
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
    fn no_text_makes_an_element() {
        for (text, expected) in [
            ("|error| of 2*3*4", "\\|error\\| of 2\\*3\\*4"),
            ("a\\b <test> < -1000", "a\\\\b \\<test> < -1000"),
            ("beam `bar` k_5y _x_", "beam \\`bar\\` k_5y \\_x\\_"),
            ("[a](javascript:x) ![i](x)", "[a\\](javascript:x) ![i\\](x)"),
            ("[a]: x, f [Hz]", "[a\\]: x, f [Hz]"),
            (
                "https://x.y www.x.y a@b.c",
                "https\\://x.y www\\.x.y a\\@b.c",
            ),
            ("&lt; R&D & <?x", "\\&lt; R\\&D & \\<?x"),
            ("~~a~~ $x$", "\\~\\~a\\~\\~ \\$x\\$"),
            ("a\nb\u{1b}[2J", "a b\\\\x1b[2J"),
        ] {
            assert_eq!(escape(text), expected);
        }
        for (line, expected) in [
            ("# a", "\\# a"),
            ("    code", "code"),
            ("- a", "- a"),
            ("---", "\\---"),
            ("1. a", "1\\. a"),
            ("12) a", "12\\) a"),
            ("===", "\\==="),
            ("3.5 Hz", "3.5 Hz"),
        ] {
            assert_eq!(escaped_line(line), expected);
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
