//! Blocks of a report become HTML elements.

use std::collections::BTreeMap;

use crate::finding::Finding;
use crate::printable::printable;

use super::super::texts::TEXTS;
use super::super::verdict::Verdict;
use super::super::{Align, Block, Cell, Column, Language, Table};

/// Maximum number of columns of a table on a page in portrait format.
const MAX_UPRIGHT_COLUMNS: usize = 9;

/// Blocks as HTML without a page around them.
pub(super) fn fragment(blocks: &[Block], language: Language) -> String {
    let text = |block| block_text(block, language);
    blocks.iter().map(text).collect()
}

/// Text with the characters escaped that HTML reserves in text and attributes, and without control
/// characters.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// HTML of a text, with the parts between backticks as code.
pub(super) fn text_with_code(text: &str) -> String {
    let mut out = String::new();
    for (index, part) in escape(text).split('`').enumerate() {
        match index % 2 {
            0 => out += part,
            _ => out += &format!("<code>{part}</code>"),
        }
    }
    out
}

fn block_text(block: &Block, language: Language) -> String {
    match block {
        Block::Heading(text) => format!("<h2>{}</h2>\n", escape(text)),
        Block::Text(text) => format!("<p>{}</p>\n", escape(text)),
        Block::Table(table) => table_text(&table.without_missing_columns(), language),
        Block::Findings { findings, .. } if findings.is_empty() => String::new(),
        Block::Findings { findings, language } => {
            let item = |finding: &Finding| {
                format!(
                    "<li class=\"{}\"><b>{}</b> {} <code>{}</code></li>\n",
                    finding.severity,
                    language.severity(finding.severity),
                    escape(&language.finding(finding)),
                    finding.code.name()
                )
            };
            let items: String = findings.iter().map(item).collect();
            format!("<ul class=\"findings\">\n{items}</ul>\n")
        }
    }
}

fn class(column: &Column) -> &'static str {
    match column.align {
        Align::Left => "",
        Align::Right => " class=\"n\"",
    }
}

fn table_text(table: &Table, language: Language) -> String {
    let heads = table.columns.iter().map(|column| {
        let text = escape(&column.head).replace('\n', "<br>");
        format!("<th scope=\"col\"{}>{text}</th>", class(column))
    });
    let classes = verdict_classes(language);
    let rows = table.rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns);
        let cells: String = cells
            .map(|(cell, column)| cell_text(cell, column, &classes))
            .collect();
        format!("<tr>{cells}</tr>\n")
    });
    let notes = table
        .footnotes
        .iter()
        .map(|note| format!("<p>{}</p>\n", text_with_code(note)));
    let notes: String = notes.collect();
    let notes = match table.footnotes.len() {
        0 => String::new(),
        1..=3 => format!("<div class=\"notes\">{notes}</div>\n"),
        count => {
            let notes_word = TEXTS.page.notes.in_language(language);
            format!(
                "<details class=\"notes\"><summary>{notes_word} ({count})</summary>\n{notes}</details>\n"
            )
        }
    };
    // On paper a broad table has a page in landscape format.
    let broad = if table.columns.len() > MAX_UPRIGHT_COLUMNS {
        " broad"
    } else {
        ""
    };
    format!(
        "<figure class=\"table{broad}\">\n<figcaption>{}</figcaption>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\">\n<table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table>\n</div>\n{notes}</figure>\n",
        escape(&table.caption),
        heads.collect::<String>(),
        rows.collect::<String>(),
    )
}

fn cell_text(cell: &Cell, column: &Column, classes: &BTreeMap<String, &str>) -> String {
    let shown = cell.display();
    let text = escape(&shown).replace('\n', "<br>");
    match classes
        .get(&shown)
        .filter(|_| matches!(cell, Cell::Text(_)))
    {
        Some(verdict) => format!(
            "<td{}><span class=\"chip {verdict}\">{text}</span></td>",
            class(column)
        ),
        None => format!("<td{}>{text}</td>", class(column)),
    }
}

/// The class of each verdict by its text, in English and as tables translate it: a cell is text, in
/// `report.json`, too.
fn verdict_classes(language: Language) -> BTreeMap<String, &'static str> {
    let english = vec![Block::Table(Table {
        columns: vec![Column::text("verdict")],
        rows: Verdict::ALL
            .iter()
            .map(|verdict| vec![Cell::text(verdict.text())])
            .collect(),
        ..Table::default()
    })];
    let mut classes = BTreeMap::new();
    for block in [language.translated(english.clone()), english].concat() {
        let Block::Table(table) = block else { continue };
        let texts = table.rows.iter().flatten().map(Cell::display);
        classes.extend(texts.zip(Verdict::ALL.iter().map(|verdict| verdict.class())));
    }
    classes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{Code, Location, Severity};

    #[test]
    fn findings_have_severity_and_code() {
        let finding = Finding::new(Severity::Warning, Code::CloseModes, Location::Mode(12.0));
        let block = |findings| Block::Findings {
            findings,
            language: Language::default(),
        };
        let text = fragment(
            &[block(vec![finding]), block(Vec::new())],
            Language::English,
        );
        assert!(
            text.starts_with("<ul class=\"findings\">\n<li class=\"warning\">"),
            "{text}"
        );
        assert!(text.contains("<code>close-modes</code>") && text.matches("<ul").count() == 1);
    }

    #[test]
    fn every_verdict_has_its_class_in_every_language() {
        for language in [Language::English, Language::Chinese] {
            for verdict in Verdict::ALL {
                let table = Block::Table(Table {
                    columns: vec![Column::text("verdict")],
                    rows: vec![vec![Cell::text(verdict.text())]],
                    ..Table::default()
                });
                let text = fragment(&language.translated(vec![table]), language);
                let chip = format!("<span class=\"chip {}\">", verdict.class());
                assert!(text.contains(&chip), "{verdict:?}: {text}");
            }
        }
    }

    #[test]
    fn the_style_has_every_class_of_a_verdict() {
        // A chip without another class is dim.
        let colored = |verdict: &&Verdict| verdict.class() != "dim";
        for verdict in Verdict::ALL.iter().filter(colored) {
            let rule = format!(".chip.{}", verdict.class());
            assert!(include_str!("page.css").contains(&rule), "{rule}");
        }
    }
}
