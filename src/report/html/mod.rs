//! The HTML renderer writes blocks as a page of tables, and the report of a run as one page with
//! its figures.
//!
//! A page is one file: style, script and data are in it, nothing is loaded. Tables, summary and
//! findings are plain HTML that needs no script; the script draws figures from the JSON in the page
//! and hides all tabs but one.

mod markup;
mod methods;
#[cfg(test)]
mod methods_tests;
mod numbers;
mod page;
mod provenance;
mod summary;
mod update;

use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::json::BreakdownFile;
use super::{Block, Language, Renderer};

use markup::{escape, fragment};

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
            document_head(title.unwrap_or("modalign"), None),
            fragment(blocks, Language::English)
        )
    }
}

/// The `head` element of a page whose only script is this one, if it has one. The browser runs no
/// other: text of a file that would get past the escapes does nothing.
fn document_head(title: &str, script: Option<&str>) -> String {
    let scripts = script.map_or("'none'".to_owned(), |script| {
        let hash = BASE64_STANDARD.encode(Sha256::digest(script));
        format!("'sha256-{hash}'")
    });
    format!(
        "<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n",
        escape(title)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Cell, Column, Table};

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
}
