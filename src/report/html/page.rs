//! The page of a run has the summary first, a tab for each kind of result, and the data of its
//! figures as JSON.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::printable::printable_json;

use super::super::Language;
use super::super::json::RunReport;
use super::super::texts::{TEXTS, Text};
use super::markup::{escape, fragment};
use super::{CompanionResults, document_head};
use super::{methods, provenance, summary, update};

/// The script, in the order in which its parts need each other.
pub(super) const SCRIPT: [&str; 12] = [
    include_str!("base.js"),
    include_str!("plot.js"),
    include_str!("frf.js"),
    include_str!("poles.js"),
    include_str!("mac.js"),
    include_str!("circles.js"),
    include_str!("scene3d.js"),
    include_str!("shapes.js"),
    include_str!("bars.js"),
    include_str!("speed.js"),
    include_str!("maps.js"),
    include_str!("page.js"),
];

/// One tab: its identifier, its title, its content, and whether the script draws into it.
struct Tab {
    id: &'static str,
    title: &'static Text,
    content: String,
    drawn: bool,
}

/// The report of a run, with the update and the studies of its folder that belong to the same
/// tests.
pub fn report_page(
    report: &RunReport,
    companions: &CompanionResults,
    language: Language,
) -> String {
    let updated = companions.updated.as_ref();
    let studied = methods::methods(report, companions, language);
    let stale = updated.is_some_and(|result| !update::belongs_to_run(result, &report.figures));
    let updated = updated.filter(|_| !stale);
    let mut tabs: Vec<Tab> = tabs(report, updated, studied.content, language)
        .into_iter()
        .filter(|tab| tab.drawn || !tab.content.is_empty())
        .collect();
    for tab in &mut tabs {
        let before = updated.is_some() && ["comparison", "shapes", "mac"].contains(&tab.id);
        let note = match tab.id {
            "summary" if stale => &TEXTS.page.update_of_another_run,
            "update" => &TEXTS.page.tabs_before_update,
            _ if before => &TEXTS.page.model_before_update,
            _ => continue,
        };
        let note = escape(note.in_language(language));
        tab.content = format!("<p class=\"note\">{note}</p>\n{}", tab.content);
    }
    let code = match language {
        Language::English => "en",
        Language::Chinese => "zh",
    };
    let data = json!({
        "language": code,
        "words": script_words(language),
        "title": report.title,
        "figures": report.figures,
        "update": updated,
        "studies": studied.data,
    });
    // A script element ends at the first `</`, and `<!--` changes its end, even inside a string.
    let data = printable_json(data.to_string()).replace('<', "\\u003c");
    let w = |text: &Text| escape(text.in_language(language));
    let made_by = &TEXTS.page.made_by;
    let script = format!("\n'use strict';\n{}", SCRIPT.concat());
    let mut page = format!(
        "<!doctype html>\n<html lang=\"{code}\">\n{}<body>\n",
        document_head(&report.title, Some(&script))
    );
    page += &format!(
        "<a class=\"skip\" href=\"#content\">{}</a>\n<header>\n<div class=\"top\"><h1>{}</h1>\n<button id=\"theme\" type=\"button\" aria-label=\"{}\">◐</button></div>\n<p class=\"made\">{}</p>\n</header>\n",
        w(&TEXTS.page.skip_to_content),
        escape(&report.title),
        w(&TEXTS.page.light_or_dark),
        escape(&made_by.filled(language, &[&report.provenance.producer]))
    );
    page += &navigation(&tabs, language);
    page += "<main id=\"content\">\n";
    for tab in &tabs {
        page += &format!(
            "<section id=\"{0}\" role=\"tabpanel\" aria-labelledby=\"tab-{0}\" tabindex=\"-1\">\n<h2>{1}</h2>\n{2}",
            tab.id,
            w(tab.title),
            tab.content
        );
        if tab.drawn {
            page += &format!("<div class=\"drawn\" data-draw=\"{}\"></div>\n", tab.id);
        }
        page += "</section>\n";
    }
    page += &format!(
        "</main>\n<noscript><p class=\"made\">{}</p></noscript>\n<script type=\"application/json\" id=\"data\">{data}</script>\n<script>{script}</script>\n</body>\n</html>\n",
        w(&TEXTS.page.figures_need_a_script)
    );
    page
}

/// Translations of the texts of the script by their English text; none for an English page.
fn script_words(language: Language) -> BTreeMap<&'static str, &'static str> {
    let texts = TEXTS.script.iter();
    texts
        .filter(|_| language != Language::English)
        .map(|(_, text)| (text.english, text.in_language(language)))
        .collect()
}

fn navigation(tabs: &[Tab], language: Language) -> String {
    let button = |tab: &Tab| {
        format!(
            "<a id=\"tab-{0}\" role=\"tab\" href=\"#{0}\" aria-controls=\"{0}\">{1}</a>\n",
            tab.id,
            escape(tab.title.in_language(language))
        )
    };
    let buttons: String = tabs.iter().map(button).collect();
    format!("<nav role=\"tablist\">\n{buttons}</nav>\n")
}

fn tabs(
    report: &RunReport,
    updated: Option<&Value>,
    studied: String,
    language: Language,
) -> Vec<Tab> {
    let figures = &report.figures;
    let any = |has: fn(&crate::scene::TestFigures) -> bool| figures.tests.iter().any(has);
    let section = |id: &str| {
        let matching = report.sections.iter().filter(|section| section.id == id);
        let blocks = matching
            .flat_map(|section| section.blocks.clone())
            .collect();
        fragment(&language.translated(blocks), language)
    };
    let texts = &TEXTS.page;
    let tab = |id, title, content, drawn| Tab {
        id,
        title,
        content,
        drawn,
    };
    // The summary of a run without a comparison shows the published results, or else the modes.
    let (mut published, mut modes) = (section("published"), section("modes"));
    let compared = figures.overview.is_some();
    let instead = match (compared, published.is_empty()) {
        (true, _) => String::new(),
        (false, false) => std::mem::take(&mut published),
        (false, true) => std::mem::take(&mut modes),
    };
    vec![
        tab(
            "summary",
            &texts.summary,
            summary::summary(report, updated, language) + &instead,
            false,
        ),
        tab(
            "comparison",
            &texts.comparison,
            section("comparison"),
            false,
        ),
        tab(
            "shapes",
            &texts.mode_shapes,
            String::new(),
            any(|t| t.shapes.is_some()) || figures.theory.is_some(),
        ),
        tab("mac", &texts.mac, String::new(), any(|t| t.mac.is_some())),
        tab("frf", &texts.frfs, String::new(), any(|t| t.frfs.is_some())),
        tab(
            "poles",
            &texts.stabilization_diagram,
            String::new(),
            any(|t| t.stabilization.is_some()),
        ),
        tab(
            "circles",
            &texts.circle_fits,
            String::new(),
            any(|t| !t.circles.is_empty()),
        ),
        tab("modes", &texts.modes, modes, false),
        tab(
            "energies",
            &texts.energies,
            section("energies"),
            // A figure of the distribution needs more than one component.
            figures
                .energies
                .iter()
                .any(|root| root.kinetic.len() > 1 || root.strain.len() > 1),
        ),
        tab(
            "update",
            &texts.update,
            updated.map_or_else(String::new, |result| {
                let verdict = update::verdict_paragraph(result, language);
                verdict
                    + &update::tables(result, language)
                    + &update::identifiability_tables(result, language)
            }),
            updated.is_some(),
        ),
        tab("published", &texts.published_results, published, false),
        tab("methods", &texts.methods, studied, false),
        tab("hits", &texts.hits, section("hits"), false),
        tab(
            "findings",
            &texts.findings,
            summary::findings(report, language),
            false,
        ),
        tab(
            "provenance",
            &texts.provenance,
            provenance::provenance(report, language),
            false,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::json::{REPORT_SCHEMA, Section};
    use crate::report::{Block, Column, Table};
    use crate::scene::{Figures, Provenance, TestFigures};

    fn report() -> RunReport {
        RunReport {
            schema: REPORT_SCHEMA.to_owned(),
            title: "a </script><script>alert(1)</script>".to_owned(),
            sections: vec![Section {
                id: "comparison".to_owned(),
                blocks: vec![Block::Table(Table {
                    caption: "Summary".to_owned(),
                    columns: vec![Column::text("mode")],
                    ..Table::default()
                })],
            }],
            findings: Vec::new(),
            limits: Vec::new(),
            next: None,
            figures: Figures {
                tests: vec![TestFigures {
                    name: "</SCRIPT>".to_owned(),
                    ..TestFigures::default()
                }],
                ..Figures::default()
            },
            provenance: Provenance::default(),
        }
    }

    #[test]
    fn names_with_script_tags_are_escaped() {
        let page = report_page(&report(), &CompanionResults::default(), Language::English);
        assert_eq!(page.matches("<script").count(), 2, "data and code");
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(!page.to_lowercase().contains("\"</script>"));
        assert!(page.contains("a &lt;/script&gt;&lt;script&gt;alert(1)"));
    }

    #[test]
    fn a_page_loads_no_resource_and_omits_empty_tabs() {
        let page = report_page(&report(), &CompanionResults::default(), Language::English);
        for door in ["http://", "https://", "src=", "@import", "url("] {
            let used = page.replace("http://www.w3.org/", "").replace("url(#", "");
            assert!(!used.contains(door), "{door}");
        }
        assert!(page.contains("id=\"tab-comparison\"") && !page.contains("id=\"tab-frf\""));
    }

    #[test]
    fn a_chinese_page_has_chinese_tabs_and_heads() {
        let page = report_page(&report(), &CompanionResults::default(), Language::Chinese);
        assert!(page.contains("<html lang=\"zh\">"));
        assert!(page.contains(">对比</a>") && page.contains("<th scope=\"col\">阶次</th>"));
    }

    #[test]
    fn every_word_of_the_script_is_translated() {
        let script = SCRIPT.concat();
        let used = script.split("T('").skip(1);
        let used: Vec<_> = used.map(|part| part.split("')").next().unwrap()).collect();
        assert!(used.len() > 40, "{}", used.len());
        let words = script_words(Language::Chinese);
        for text in used {
            assert!(words.contains_key(text), "{text}");
        }
        for english in words.keys() {
            let is_used = script.contains(&format!("'{english}'"));
            assert!(is_used, "{english} is not used");
        }
        assert!(script_words(Language::English).is_empty());
    }
}
