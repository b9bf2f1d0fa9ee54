//! The summary tab states the result of a run in numbers and sentences; the findings tab lists the
//! findings with their explanations.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::Value;

use crate::correlate::{Status, TestSummary};
use crate::finding::{Code, Finding, Severity};
use crate::linalg::sort_descending_by;
use crate::scene::Overview;

use super::super::Language;
use super::super::comparison::headline;
use super::super::error_range::{error_range, one_sided_modes};
use super::super::json::RunReport;
use super::super::texts::{TEXTS, Text};
use super::super::verdict::Verdict;
use super::markup::{escape, text_with_code};
use super::numbers::{four_digits, round_to_std, two_digits};
use super::update;

/// Maximum number of findings of one code in the list; the others are counted.
const MAX_LISTED_FINDINGS: usize = 12;
/// Maximum number of modes or parameters that the summary lists; the others are counted.
const MAX_LISTED_ITEMS: usize = 8;

/// Verdict on the stated limits, a card for each test, unmatched modes, and recommended changes.
pub(super) fn summary(report: &RunReport, updated: Option<&Value>, language: Language) -> String {
    let next = report.next.as_deref();
    let next = next.filter(|_| updated.is_none());
    let next = next.map(|next| language.translated_text(next.to_owned()));
    let Some(overview) = &report.figures.overview else {
        let next = next.map_or_else(String::new, |next| {
            format!("<p>{}</p>\n", text_with_code(&next))
        });
        return format!(
            "<p class=\"lead\">{}</p>\n{}{next}",
            escape(TEXTS.page.test_only.in_language(language)),
            limits(report, language)
        );
    };
    // A single card leaves room at its side for unmatched modes and recommendations.
    let alone = if overview.tests.len() == 1 {
        " alone"
    } else {
        ""
    };
    let texts = &TEXTS.page;
    let mut text = limits(report, language);
    text += &format!("<div class=\"first{alone}\">\n<div class=\"cards\">\n");
    for test in &overview.tests {
        let mut figures = report.figures.tests.iter();
        let synthetic =
            figures.any(|test_figures| test_figures.name == test.test && test_figures.synthetic);
        text += &card(test, synthetic, language);
    }
    text += "</div>\n<div class=\"two\">\n";
    text += &format!(
        "<div><h3>{}</h3>\n{}</div>\n",
        texts.unmatched_modes.in_language(language),
        list(&unmatched_modes(overview, language))
    );
    let verdict = updated.and_then(|result| update::verdict_line(result, language));
    let mut advice = advice(overview, updated, language);
    advice.splice(0..0, verdict);
    let warnings = report.findings.iter().flat_map(|(_, findings)| findings);
    let warnings = warnings
        .filter(|finding| finding.severity >= Severity::Warning)
        .count();
    if warnings > 0 {
        let text = &texts.number_of_warnings;
        advice.push(text.filled(language, &[warnings.to_string()]));
    }
    advice.extend(next);
    text += &format!(
        "<div><h3>{}</h3>\n{}</div>\n</div>\n</div>\n<div class=\"drawn\" data-draw=\"errors\"></div>\n",
        advice_head(updated).in_language(language),
        list(&advice)
    );
    text
}

/// Heading of the advice; a failed update recommends no change.
fn advice_head(updated: Option<&Value>) -> &'static Text {
    match updated.is_some_and(update::has_failed) {
        true => &TEXTS.page.update_result,
        false => &TEXTS.page.recommended_changes,
    }
}

fn card(test: &TestSummary, synthetic: bool, language: Language) -> String {
    let texts = &TEXTS.page;
    let w = |text: &Text| escape(text.in_language(language));
    let percent =
        |value: Option<f64>| value.map_or_else(|| "—".to_owned(), |v| format!("{:.2} %", v.abs()));
    let partners = test.paired_by_shape + test.paired_by_frequency + test.ambiguous;
    let whole = partners + test.missed + test.not_observable;
    let pairs = texts
        .modes_with_a_partner
        .filled(language, &[partners.to_string(), whole.to_string()]);
    let evidence = language.translated_text(headline(test, false));
    let mac = test
        .min_mac
        .map_or_else(|| "—".to_owned(), |mac| format!("{mac:.3}"));
    let counts = [
        (
            &texts.unmatched_model,
            Verdict::UnmatchedObservable,
            test.missed,
        ),
        (
            &texts.not_observable,
            Verdict::NotObservable,
            test.not_observable,
        ),
        (&texts.ambiguous, Verdict::Ambiguous, test.ambiguous),
        (
            &texts.unmatched_test,
            Verdict::UnmatchedTestMode,
            test.extra,
        ),
    ];
    let counted = counts.iter().filter(|(.., count)| *count > 0);
    let chips: String = counted
        .map(|(name, verdict, count)| {
            let class = verdict.class();
            format!("<span class=\"chip {class}\">{count} {}</span> ", w(name))
        })
        .collect();
    let synthetic = match synthetic {
        true => format!(" <span class=\"chip fair\">{}</span>", w(&texts.synthetic)),
        false => String::new(),
    };
    format!(
        "<div class=\"card\"><h3>{}{synthetic}</h3>\n<p class=\"big\">{}<small>{}</small></p>\n<p>{}</p>\n<p>{}</p>\n<dl><dt>{}</dt><dd>{}</dd><dt>{}</dt><dd>{}</dd></dl>\n<p>{chips}</p></div>\n",
        escape(&test.test),
        percent(test.rms_error_percent),
        w(&texts.rms_frequency_error),
        escape(&pairs),
        escape(&evidence),
        w(&texts.largest),
        percent(test.max_error_percent),
        w(&texts.smallest_mac),
        mac,
    )
}

/// Sentences on the unmatched modes, those that the test should observe first; the modes above the
/// maximum number are counted.
fn unmatched_modes(overview: &Overview, language: Language) -> Vec<String> {
    let texts = &TEXTS.page;
    let mut ranked: Vec<(u8, String)> = Vec::new();
    let mut unseen: BTreeMap<&str, usize> = BTreeMap::new();
    for row in &overview.rows {
        let hz = row
            .theory_hz
            .map_or_else(String::new, |hz| format!("{hz:.1}"));
        for cell in &row.cells {
            let reasons = cell.reasons.join("; ");
            match cell.status {
                Status::NotObservable => *unseen.entry(&cell.test).or_default() += 1,
                Status::MissedExpected | Status::MissedUnexpected => {
                    let (rank, text) = match (cell.status, cell.not_judged) {
                        (Status::MissedExpected, _) => (3, &texts.unmatched_not_excited),
                        (_, true) => (1, &texts.unmatched_observability_unknown),
                        (_, false) => (0, &texts.unmatched_but_observable),
                    };
                    let values = [cell.test.clone(), row.label.clone(), hz.clone(), reasons];
                    ranked.push((rank, text.filled(language, &values)));
                }
                Status::Extra => {
                    let hz = cell.hz.map_or_else(String::new, |hz| format!("{hz:.1}"));
                    let text = &texts.unmatched_test_mode;
                    ranked.push((2, text.filled(language, &[&cell.test, &hz])));
                }
                Status::Paired | Status::Ambiguous | Status::OutsideBand => {}
            }
        }
    }
    ranked.sort_by_key(|(rank, _)| *rank);
    let mut sentences: Vec<String> = ranked.into_iter().map(|(_, text)| text).collect();
    let more = sentences.len().saturating_sub(MAX_LISTED_ITEMS);
    sentences.truncate(MAX_LISTED_ITEMS);
    if more > 0 {
        sentences.push(format!("… + {more}"));
    }
    let unseen = unseen.iter().map(|(test, count)| {
        let text = texts
            .unobservable_model_modes
            .filled(language, &[count.to_string()]);
        format!("{test}: {text}")
    });
    sentences.extend(unseen);
    if sentences.is_empty() {
        sentences.push(texts.no_unmatched_modes.in_language(language).to_owned());
    }
    sentences
}

/// Identified parameters of an update; without one, the sign of the frequency errors and the
/// stiffness factor that removes their mean.
fn advice(overview: &Overview, updated: Option<&Value>, language: Language) -> Vec<String> {
    let parameters = updated.and_then(|result| result["parameters"].as_array());
    if let Some(parameters) = parameters {
        let sentences = identified_changes(parameters, language);
        if !sentences.is_empty() {
            return sentences;
        }
    }
    if let Some(factor) = overview.stiffness_factor {
        let text = match factor < 1.0 {
            true => &TEXTS.page.model_too_stiff,
            false => &TEXTS.page.model_too_soft,
        };
        let bias = text.filled(language, &[format!("{factor:.3}")]);
        return vec![bias];
    }
    if let Some(range) = &overview.error_range {
        return vec![language.translated_text(error_range(range))];
    }
    if let Some(modes) = &overview.one_sided {
        return vec![language.translated_text(one_sided_modes(modes))];
    }
    let errors = overview.rows.iter().flat_map(|row| {
        let cells = row.cells.iter();
        cells.filter_map(move |cell| Some((row, cell, cell.error_percent?)))
    });
    let largest = errors.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
    let text = &TEXTS.page.errors_without_common_sign;
    let largest_error = largest.map(|(row, cell, error)| {
        let mode = format!("{} ({})", row.label, cell.test);
        text.filled(language, &[format!("{error:+.2} %"), mode])
    });
    largest_error.into_iter().collect()
}

/// The identified parameters; of many, those with the largest changes in standard deviations, with
/// the number of the others.
fn identified_changes(parameters: &[Value], language: Language) -> Vec<String> {
    let identified = parameters.iter();
    let mut identified: Vec<&Value> = identified
        .filter(|parameter| parameter["verdict"] == "identified")
        .collect();
    let further = identified.len().saturating_sub(MAX_LISTED_ITEMS);
    if further > 0 {
        let change_in_stds = |parameter: &Value| {
            let [from, to, std] = ["initial", "updated", "std"].map(|key| parameter[key].as_f64());
            let std = std.filter(|std| *std > 0.0).unwrap_or(f64::INFINITY);
            (to.unwrap_or(0.0) - from.unwrap_or(0.0)).abs() / std
        };
        sort_descending_by(&mut identified, |parameter| change_in_stds(parameter));
        identified.truncate(MAX_LISTED_ITEMS);
    }
    let mut sentences: Vec<String> = identified
        .iter()
        .map(|parameter| change_sentence(parameter, language))
        .collect();
    if further > 0 {
        let text = &TEXTS.page.further_parameters;
        sentences.push(text.filled(language, &[further.to_string()]));
    }
    sentences
}

fn change_sentence(parameter: &Value, language: Language) -> String {
    let std = parameter["std"].as_f64().filter(|std| *std > 0.0);
    let number = |key: &str| {
        parameter[key].as_f64().map_or_else(
            || "—".to_owned(),
            |value| match std {
                Some(std) if key != "std" => round_to_std(value, std),
                Some(std) => two_digits(std),
                None => four_digits(value),
            },
        )
    };
    let text = |key: &str| parameter[key].as_str().unwrap_or_default().to_owned();
    let values = [
        text("name"),
        number("initial"),
        number("updated"),
        number("std"),
        unit_text(&text("unit")),
    ];
    let text = &TEXTS.page.parameter_change;
    text.filled(language, &values).trim_end().to_owned()
}

/// Unit of a number: empty for a dimensionless one; exponents are superscripts.
fn unit_text(unit: &str) -> String {
    match unit {
        "1" | "-" => String::new(),
        _ => unit.replace("m2", "m²").replace("s2", "s²"),
    }
}

fn limits(report: &RunReport, language: Language) -> String {
    if report.limits.is_empty() {
        return String::new();
    }
    let missed = report.limits.iter().filter(|(_, met)| !met);
    let texts = &TEXTS.page;
    let missed: Vec<String> = missed
        .map(|(what, _)| texts.limit_missed.filled(language, &[what]))
        .collect();
    match missed.is_empty() {
        true => {
            let count = report.limits.len().to_string();
            let text = texts.limits_met.filled(language, &[count]);
            format!("<p class=\"verdict good\">{}</p>\n", escape(&text))
        }
        false => format!("<div class=\"verdict bad\">{}</div>\n", list(&missed)),
    }
}

fn list(items: &[String]) -> String {
    let items: String = items
        .iter()
        .map(|item| format!("<li>{}</li>\n", text_with_code(item)))
        .collect();
    format!("<ul>\n{items}</ul>\n")
}

/// All findings by test, the most severe first, grouped by code with its explanation.
pub(super) fn findings(report: &RunReport, language: Language) -> String {
    let mut text = String::new();
    // Findings under the same name are merged; the name of the whole run is empty.
    let mut by_name: Vec<(&str, Vec<Finding>)> = Vec::new();
    for (test, findings) in report
        .findings
        .iter()
        .filter(|(_, findings)| !findings.is_empty())
    {
        match by_name.iter_mut().find(|(name, _)| *name == test.as_str()) {
            Some((_, all)) => all.extend_from_slice(findings),
            None => by_name.push((test, findings.clone())),
        }
    }
    for (test, findings) in &by_name {
        if by_name.len() > 1 {
            let name = if test.is_empty() {
                TEXTS.page.whole_run.in_language(language)
            } else {
                *test
            };
            let _ = writeln!(text, "<h3>{}</h3>", escape(name));
        }
        text += &findings_of_test(findings, language);
    }
    match text.is_empty() {
        true => format!("<p>{}</p>\n", TEXTS.page.no_findings.in_language(language)),
        false => text,
    }
}

fn findings_of_test(findings: &[Finding], language: Language) -> String {
    let mut by_code: BTreeMap<(std::cmp::Reverse<Severity>, Code), Vec<String>> = BTreeMap::new();
    for finding in findings {
        let key = (std::cmp::Reverse(finding.severity), finding.code);
        let entries = by_code.entry(key).or_default();
        // The heading of the list has the sentence of the code.
        let finding_text = language.finding(finding);
        let (place, numbers) = finding_text
            .split_once(language.sentence(finding.code))
            .unwrap_or((&finding_text, ""));
        let place = place.trim_end_matches([':', ' ', '\u{ff1a}']);
        let entry = format!("{place} {}", numbers.trim()).trim().to_owned();
        if !entries.contains(&entry) {
            entries.push(entry);
        }
    }
    let mut text = String::from("<div class=\"codes\">\n");
    for ((std::cmp::Reverse(severity), code), entries) in by_code {
        let open = match severity {
            Severity::Info => "",
            Severity::Warning | Severity::Error => " open",
        };
        let items: String = entries
            .iter()
            .take(MAX_LISTED_FINDINGS)
            .map(|entry| format!("<li>{}</li>\n", escape(entry)))
            .collect();
        let more = entries.len().saturating_sub(MAX_LISTED_FINDINGS);
        let more = match more {
            0 => String::new(),
            _ => format!(
                "<p>+ {more} {}</p>\n",
                TEXTS.page.more_of_this_code.in_language(language)
            ),
        };
        text += &format!(
            "<details class=\"{severity}\"{}><summary><span class=\"chip {severity}\">{}</span> {} <code>{}</code> <span class=\"count\">× {}</span></summary>\n<p class=\"why\">{}</p>\n<ul>{items}</ul>\n{more}</details>\n",
            open,
            language.severity(severity),
            escape(language.sentence(code)),
            code.name(),
            entries.len(),
            text_with_code(language.explanation(code)),
        );
    }
    text + "</div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_lists_the_identified_parameters_of_an_update() {
        let overview = Overview {
            tests: Vec::new(),
            of_theory: true,
            rows: Vec::new(),
            stiffness_factor: Some(0.96),
            error_range: None,
            one_sided: None,
        };
        let sentences = advice(&overview, None, Language::English);
        assert_eq!(sentences.len(), 1);
        assert!(
            sentences[0].contains("too stiff") && sentences[0].contains("0.960"),
            "{sentences:?}"
        );
        let updated: Value = serde_json::from_str(
            r#"{"parameters": [{"name": "mount", "unit": "N/m", "initial": 2e6, "updated": 1.5e6, "std": 1e4, "verdict": "identified"}, {"name": "gap", "verdict": "at bound"}]}"#,
        )
        .unwrap();
        let sentences = advice(&overview, Some(&updated), Language::English);
        assert_eq!(sentences, ["mount: 2.000e6 → 1.500e6 ± 1.0e4 N/m"]);
    }

    #[test]
    fn of_many_parameters_the_largest_changes_in_standard_deviations_are_listed() {
        let parameter = |k: usize| serde_json::json!({"name": format!("p{k}"), "unit": "1", "initial": 1.0, "updated": 1.0 + 0.1 * k as f64, "std": 0.1, "verdict": "identified"});
        let many: Vec<Value> = (0..MAX_LISTED_ITEMS + 3).map(parameter).collect();
        let sentences = identified_changes(&many, Language::English);
        assert_eq!(sentences.len(), MAX_LISTED_ITEMS + 1);
        assert_eq!(sentences[0], "p10: 1.00 → 2.00 ± 0.10", "no unit");
        assert!(
            sentences[MAX_LISTED_ITEMS].starts_with("3 further"),
            "{sentences:?}"
        );
        assert_eq!(identified_changes(&many[..3], Language::English).len(), 3);
        assert_eq!(unit_text("kg m2"), "kg m²");
    }

    #[test]
    fn a_failed_update_recommends_no_change() {
        let failed: Value = serde_json::from_str(r#"{"fits": false}"#).unwrap();
        let head = |updated| advice_head(updated).in_language(Language::English);
        assert_eq!(head(Some(&failed)), "Update result");
        let fits: Value = serde_json::from_str(r#"{"fits": true}"#).unwrap();
        assert_eq!(head(Some(&fits)), "Recommended changes");
        assert_eq!(head(None), "Recommended changes");
    }
}
