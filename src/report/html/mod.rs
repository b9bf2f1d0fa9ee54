//! The HTML renderer writes blocks as a page of tables, and the report of a run as one page with
//! its figures.
//!
//! A page is one file: style, script and data are in it, nothing is loaded. Tables, summary and
//! findings are plain HTML that needs no script; the script draws figures from the JSON in the page
//! and hides all tabs but one.

mod methods;
#[cfg(test)]
mod methods_tests;
mod numbers;
mod page;
mod provenance;
mod script_words;
mod summary;
mod update;
mod words;

use serde_json::Value;

use super::json::BreakdownFile;
use super::{Align, Block, Cell, Column, Language, Renderer, Table};

pub use page::report_page;

/// Results of other verbs in the folder of a run, which the page of the run includes.
#[derive(Clone, Debug, Default)]
pub struct CompanionResults {
    /// `update.json`.
    pub updated: Option<Value>,
    /// `speed-accuracy.json`.
    pub speed_accuracy: Option<Value>,
    /// `breakdown.json`.
    pub breakdown: Option<BreakdownFile>,
    /// `order.json`.
    pub order: Option<Value>,
}

/// Renders blocks as a whole page.
pub struct Html;

/// Maximum number of columns of a table on a page in portrait format.
const MAX_UPRIGHT_COLUMNS: usize = 9;

/// The style of every page.
const STYLE: &str = include_str!("page.css");

impl Renderer for Html {
    fn name(&self) -> &'static str {
        "html"
    }

    fn extension(&self) -> &'static str {
        "html"
    }

    fn render(&self, blocks: &[Block]) -> String {
        let title = blocks.iter().find_map(|block| match block {
            Block::Heading(text) => Some(text.as_str()),
            _ => None,
        });
        format!(
            "<!doctype html>\n<html lang=\"en\">\n{}<body>\n<main class=\"plain\">\n{}</main>\n</body>\n</html>\n",
            head(title.unwrap_or("modalign")),
            fragment(blocks, Language::English)
        )
    }
}

/// The head of a page.
fn head(title: &str) -> String {
    format!(
        "<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n",
        escape(title)
    )
}

/// Blocks as HTML without a page around them.
fn fragment(blocks: &[Block], language: Language) -> String {
    let text = |block| block_text(block, language);
    blocks.iter().map(text).collect()
}

/// Text with the characters escaped that HTML reserves in text and attributes.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
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

fn block_text(block: &Block, language: Language) -> String {
    match block {
        Block::Heading(text) => format!("<h2>{}</h2>\n", escape(text)),
        Block::Text(text) => format!("<p>{}</p>\n", escape(text)),
        Block::Table(table) => table_text(table, language),
        Block::Findings { findings, .. } if findings.is_empty() => String::new(),
        Block::Findings { findings, language } => {
            let item = |finding: &crate::finding::Finding| {
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
    let rows = table.rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns);
        let cells: String = cells
            .map(|(cell, column)| cell_text(cell, column))
            .collect();
        format!("<tr>{cells}</tr>\n")
    });
    let notes = table
        .footnotes
        .iter()
        .map(|note| format!("<p>{}</p>\n", summary::text_with_code(note)));
    let notes: String = notes.collect();
    let notes = match table.footnotes.len() {
        0 => String::new(),
        1..=3 => format!("<div class=\"notes\">{notes}</div>\n"),
        count => {
            let notes_word = words::word(language, "Notes");
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

fn cell_text(cell: &Cell, column: &Column) -> String {
    let text = escape(&cell.display()).replace('\n', "<br>");
    match (cell, verdict_class(&cell.display())) {
        (Cell::Text(_), Some(kind)) => {
            format!(
                "<td{}><span class=\"chip {kind}\">{text}</span></td>",
                class(column)
            )
        }
        _ => format!("<td{}>{text}</td>", class(column)),
    }
}

/// Colour of a verdict, in either language; none for other text.
fn verdict_class(text: &str) -> Option<&'static str> {
    Some(match text {
        "paired" | "已配对" | "identified" | "可识别" | "used" | "used (stated)" | "reproduced"
        | "met" | "yes" | "采用" | "采用(指定)" | "已复现" | "满足" => "good",
        "ambiguous"
        | "不明确"
        | "at bound"
        | "位于边界"
        | "unmatched, near a paired mode"
        | "漏检(预期)"
        | "not checkable"
        | "无法核对" => "fair",
        "MISSED"
        | "NOT reproduced"
        | "unmatched model mode, should have been seen"
        | "漏检(非预期)"
        | "unmatched test mode"
        | "多余"
        | "rejected"
        | "rejected (stated)"
        | "missed"
        | "not reproduced"
        | "unmatched, observability unknown"
        | "漏检(未判定)"
        | "剔除"
        | "剔除(指定)"
        | "未复现"
        | "未满足" => "bad",
        "not-observable"
        | "不可观测"
        | "outside-band"
        | "频带外"
        | "not supported by the data"
        | "数据不支持" => "dim",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{Code, Finding, Location, Severity};
    use crate::report::Language;

    #[test]
    fn tables_keep_headings_alignment_and_missing_values() {
        let table = Table {
            caption: "a < b & \"c\"".to_owned(),
            columns: vec![Column::text("mode"), Column::number("f\n(Hz)")],
            rows: vec![
                vec![Cell::text("f1"), Cell::number(Some(12.345), 2)],
                vec![Cell::text("paired"), Cell::Missing],
            ],
            footnotes: vec!["<script> of `ml`".to_owned()],
        };
        let page = Html.render(&[Block::Heading("Ü".to_owned()), Block::Table(table)]);
        for part in [
            "<title>Ü</title>",
            "<figcaption>a &lt; b &amp; &quot;c&quot;</figcaption>",
            "<th scope=\"col\" class=\"n\">f<br>(Hz)</th>",
            "<td class=\"n\">12.35</td>",
            "<td><span class=\"chip good\">paired</span></td><td class=\"n\">—</td>",
            "<p>&lt;script&gt; of <code>ml</code></p>",
        ] {
            assert!(page.contains(part), "{part}\n{page}");
        }
        assert!(!page.contains("<script") && page.ends_with("</html>\n"));
    }

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
}
