//! The first tab in words and numbers, and the findings with their reasons.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::Value;

use crate::correlate::{Status, TestSummary};
use crate::finding::{Code, Finding, Severity};
use crate::scene::Overview;

use super::super::Language;
use super::super::comparison::headline;
use super::super::json::RunReport;
use super::numbers::{short, to_place_of, two_digits};
use super::words::{sentence, word};
use super::{escape, update};

/// Findings of one code that are listed; more are counted.
const LISTED: usize = 12;
/// Roots that are named one by one.
const NAMED: usize = 8;

/// Whether the limits are met, cards of the tests, what was missed, what to change.
pub(super) fn summary(report: &RunReport, updated: Option<&Value>, language: Language) -> String {
    let Some(overview) = &report.figures.overview else {
        return format!(
            "<p class=\"lead\">{}</p>\n{}",
            escape(word(language, "This run compared no test with a model.")),
            limits(report, language)
        );
    };
    // A single card leaves room beside it for what was missed and what to change.
    let alone = if overview.tests.len() == 1 {
        " alone"
    } else {
        ""
    };
    let mut text = limits(report, language);
    text += &format!("<div class=\"first{alone}\">\n<div class=\"cards\">\n");
    for test in &overview.tests {
        let mut figures = report.figures.tests.iter();
        let synthetic = figures.any(|own| own.name == test.test && own.synthetic);
        text += &card(test, synthetic, language);
    }
    text += "</div>\n<div class=\"two\">\n";
    text += &format!(
        "<div><h3>{}</h3>\n{}</div>\n",
        word(language, "What was missed"),
        list(&missed(overview, language))
    );
    let verdict = updated.and_then(|own| update::verdict_line(own, language));
    let mut advice = advice(overview, updated, language);
    advice.splice(0..0, verdict);
    let warnings = report.findings.iter().flat_map(|(_, own)| own);
    let warnings = warnings
        .filter(|own| own.severity >= Severity::Warning)
        .count();
    if warnings > 0 {
        advice.push(sentence(
            language,
            "Warnings among the findings: {}.",
            &[warnings.to_string()],
        ));
    }
    text += &format!(
        "<div><h3>{}</h3>\n{}</div>\n</div>\n</div>\n<div class=\"drawn\" data-draw=\"errors\"></div>\n",
        word(language, advice_head(updated)),
        list(&advice)
    );
    text
}

/// A failed update is no advice.
fn advice_head(updated: Option<&Value>) -> &'static str {
    match updated.is_some_and(update::failed) {
        true => "What the update came to",
        false => "What to change",
    }
}

fn card(test: &TestSummary, synthetic: bool, language: Language) -> String {
    let w = |text| escape(word(language, text));
    let percent =
        |value: Option<f64>| value.map_or_else(|| "—".to_owned(), |v| format!("{:.2} %", v.abs()));
    let partners = test.paired_by_shape + test.paired_by_frequency + test.ambiguous;
    let whole = partners + test.missed + test.not_observable;
    let pairs = sentence(
        language,
        "{} of {} modes of the model in the band have a partner",
        &[partners.to_string(), whole.to_string()],
    );
    let evidence = language.translated_text(headline(test, false));
    let mac = test
        .min_mac
        .map_or_else(|| "—".to_owned(), |mac| format!("{mac:.3}"));
    let counts = [
        ("missed", test.missed),
        ("not observable", test.not_observable),
        ("ambiguous", test.ambiguous),
        ("extra", test.extra),
    ];
    let counted = counts.iter().filter(|(_, count)| *count > 0);
    let chips: String = counted
        .map(|(name, count)| {
            let kind = match *name {
                "not observable" => "dim",
                "ambiguous" => "fair",
                _ => "bad",
            };
            format!("<span class=\"chip {kind}\">{count} {}</span> ", w(name))
        })
        .collect();
    let synthetic = match synthetic {
        true => format!(" <span class=\"chip fair\">{}</span>", w("synthetic")),
        false => String::new(),
    };
    format!(
        "<div class=\"card\"><h3>{}{synthetic}</h3>\n<p class=\"big\">{}<small>{}</small></p>\n<p>{}</p>\n<p>{}</p>\n<dl><dt>{}</dt><dd>{}</dd><dt>{}</dt><dd>{}</dd></dl>\n<p>{chips}</p></div>\n",
        escape(&test.test),
        percent(test.rms_error_percent),
        w("rms frequency error"),
        escape(&pairs),
        escape(&evidence),
        w("largest"),
        percent(test.max_error_percent),
        w("smallest MAC"),
        mac,
    )
}

/// What has no partner, one sentence each, what nothing excuses first; many are counted.
fn missed(overview: &Overview, language: Language) -> Vec<String> {
    let mut told: Vec<(u8, String)> = Vec::new();
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
                        (Status::MissedExpected, _) => (
                            3,
                            "{}: model mode {} at {} Hz has no partner, as was expected: {}",
                        ),
                        (_, true) => (
                            1,
                            "{}: model mode {} at {} Hz has no partner; whether the test could see it is not known: {}",
                        ),
                        (_, false) => (
                            0,
                            "{}: model mode {} at {} Hz has no partner although the test should see it: {}",
                        ),
                    };
                    let values = [cell.test.clone(), row.label.clone(), hz.clone(), reasons];
                    told.push((rank, sentence(language, text, &values)));
                }
                Status::Extra => {
                    let hz = cell.hz.map_or_else(String::new, |hz| format!("{hz:.1}"));
                    let text = "{}: test mode at {} Hz has no partner in the model";
                    told.push((2, sentence(language, text, &[cell.test.clone(), hz])));
                }
                Status::Paired | Status::Ambiguous | Status::OutsideBand => {}
            }
        }
    }
    told.sort_by_key(|(rank, _)| *rank);
    let mut told: Vec<String> = told.into_iter().map(|(_, text)| text).collect();
    let more = told.len().saturating_sub(NAMED);
    told.truncate(NAMED);
    if more > 0 {
        told.push(format!("… + {more}"));
    }
    let unseen = unseen.iter().map(|(test, count)| {
        let own = sentence(
            language,
            "roots that these sensors and hits could not see: {}",
            &[count.to_string()],
        );
        format!("{test}: {own}")
    });
    told.extend(unseen);
    if told.is_empty() {
        told.push(word(language, "Nothing inside the band was missed.").to_owned());
    }
    told
}

/// What an update found, else which way the model leans.
fn advice(overview: &Overview, updated: Option<&Value>, language: Language) -> Vec<String> {
    let parameters = updated.and_then(|own| own["parameters"].as_array());
    if let Some(parameters) = parameters {
        let told = changes(parameters, language);
        if !told.is_empty() {
            return told;
        }
    }
    let further = overview.updatable.then(|| {
        let text = "`modalign update` says which parameters the test can tell.";
        word(language, text).to_owned()
    });
    if let Some(factor) = overview.stiffness_factor {
        let text = match factor < 1.0 {
            true => {
                "All paired frequencies of the test lie below the model's: the model is too stiff or too light. One factor {} on all stiffnesses would bring the mean to the test."
            }
            false => {
                "All paired frequencies of the test lie above the model's: the model is too soft or too heavy. One factor {} on all stiffnesses would bring the mean to the test."
            }
        };
        let leaning = sentence(language, text, &[format!("{factor:.3}")]);
        return [leaning].into_iter().chain(further).collect();
    }
    let errors = overview.rows.iter().flat_map(|row| {
        let cells = row.cells.iter();
        cells.filter_map(move |cell| Some((row, cell, cell.error_percent?)))
    });
    let largest = errors.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
    let text = "The errors do not lean clearly to one side, so that no single factor explains them; the largest is {} at {}.";
    let told = largest.map(|(row, cell, error)| {
        let place = format!("{} ({})", row.label, cell.test);
        sentence(language, text, &[format!("{error:+.2} %"), place])
    });
    let further = further.filter(|_| told.is_some());
    told.into_iter().chain(further).collect()
}

/// The parameters that the test identified; of many those that moved most by their deviations, the
/// others counted.
fn changes(parameters: &[Value], language: Language) -> Vec<String> {
    let known = parameters.iter();
    let mut known: Vec<&Value> = known.filter(|own| own["verdict"] == "identified").collect();
    let further = known.len().saturating_sub(NAMED);
    if further > 0 {
        let moved = |own: &Value| {
            let [from, to, std] = ["initial", "updated", "std"].map(|key| own[key].as_f64());
            let std = std.filter(|std| *std > 0.0).unwrap_or(f64::INFINITY);
            (to.unwrap_or(0.0) - from.unwrap_or(0.0)).abs() / std
        };
        known.sort_by(|a, b| moved(b).total_cmp(&moved(a)));
        known.truncate(NAMED);
    }
    let mut told: Vec<String> = known.iter().map(|own| changed(own, language)).collect();
    if further > 0 {
        let text = "{} further parameters that moved less by their deviations: tab Update.";
        told.push(sentence(language, text, &[further.to_string()]));
    }
    told
}

fn changed(own: &Value, language: Language) -> String {
    let std = own["std"].as_f64().filter(|std| *std > 0.0);
    let number = |key: &str| {
        own[key].as_f64().map_or_else(
            || "—".to_owned(),
            |value| match std {
                Some(std) if key != "std" => to_place_of(value, std),
                Some(std) => two_digits(std),
                None => short(value),
            },
        )
    };
    let text = |key: &str| own[key].as_str().unwrap_or_default().to_owned();
    let values = [
        text("name"),
        number("initial"),
        number("updated"),
        number("std"),
        unit_told(&text("unit")),
    ];
    sentence(language, "{}: {} → {} ± {} {}", &values)
        .trim_end()
        .to_owned()
}

/// A unit behind a number: nothing for a pure number, a raised exponent.
fn unit_told(unit: &str) -> String {
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
    let missed: Vec<String> = missed
        .map(|(what, _)| sentence(language, "Limit missed: {}", std::slice::from_ref(what)))
        .collect();
    match missed.is_empty() {
        true => {
            let count = report.limits.len().to_string();
            let text = sentence(language, "All {} stated limits are met.", &[count]);
            format!("<p class=\"verdict good\">{}</p>\n", escape(&text))
        }
        false => format!("<div class=\"verdict bad\">{}</div>\n", list(&missed)),
    }
}

fn list(items: &[String]) -> String {
    let items: String = items
        .iter()
        .map(|item| format!("<li>{}</li>\n", marked(item)))
        .collect();
    format!("<ul>\n{items}</ul>\n")
}

/// Text in which what stands between backticks is code.
pub(super) fn marked(text: &str) -> String {
    let mut out = String::new();
    for (index, part) in escape(text).split('`').enumerate() {
        match index % 2 {
            0 => out += part,
            _ => out += &format!("<code>{part}</code>"),
        }
    }
    out
}

/// All findings by test, worst first, those of one code together with its explanation.
pub(super) fn findings(report: &RunReport, language: Language) -> String {
    let mut text = String::new();
    // Those of a single test and those of the whole run have one name.
    let mut by_name: Vec<(&str, Vec<Finding>)> = Vec::new();
    for (test, own) in report.findings.iter().filter(|(_, own)| !own.is_empty()) {
        match by_name.iter_mut().find(|(name, _)| *name == test.as_str()) {
            Some((_, all)) => all.extend_from_slice(own),
            None => by_name.push((test, own.clone())),
        }
    }
    for (test, findings) in &by_name {
        if by_name.len() > 1 {
            let name = if test.is_empty() {
                word(language, "whole run")
            } else {
                *test
            };
            let _ = writeln!(text, "<h3>{}</h3>", escape(name));
        }
        text += &of_test(findings, language);
    }
    match text.is_empty() {
        true => format!(
            "<p>{}</p>\n",
            word(language, "Nothing was found that needs saying.")
        ),
        false => text,
    }
}

fn of_test(findings: &[Finding], language: Language) -> String {
    let mut by_code: BTreeMap<(std::cmp::Reverse<Severity>, Code), Vec<String>> = BTreeMap::new();
    for finding in findings {
        let key = (std::cmp::Reverse(finding.severity), finding.code);
        let told = by_code.entry(key).or_default();
        // The sentence of the code stands above them all.
        let told_whole = language.finding(finding);
        let (place, numbers) = told_whole
            .split_once(language.sentence(finding.code))
            .unwrap_or((&told_whole, ""));
        let place = place.trim_end_matches([':', ' ', '\u{ff1a}']);
        let own = format!("{place} {}", numbers.trim()).trim().to_owned();
        if !told.contains(&own) {
            told.push(own);
        }
    }
    let mut text = String::from("<div class=\"codes\">\n");
    for ((severity, code), told) in by_code {
        let severity = match severity.0 {
            Severity::Info => "info",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        let items: String = told
            .iter()
            .take(LISTED)
            .map(|own| format!("<li>{}</li>\n", escape(own)))
            .collect();
        let more = told.len().saturating_sub(LISTED);
        let more = match more {
            0 => String::new(),
            _ => format!("<p>+ {more} {}</p>\n", word(language, "more of this code")),
        };
        text += &format!(
            "<details class=\"{severity}\"{}><summary><span class=\"chip {severity}\">{}</span> {} <code>{}</code> <span class=\"count\">× {}</span></summary>\n<p class=\"why\">{}</p>\n<ul>{items}</ul>\n{more}</details>\n",
            if severity == "info" { "" } else { " open" },
            word(language, severity),
            escape(language.sentence(code)),
            code.name(),
            told.len(),
            marked(language.explanation(code)),
        );
    }
    text + "</div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_update_is_the_advice_where_there_is_one() {
        let overview = Overview {
            tests: Vec::new(),
            of_theory: true,
            rows: Vec::new(),
            stiffness_factor: Some(0.96),
            updatable: true,
        };
        let fixed = Overview {
            updatable: false,
            ..overview.clone()
        };
        assert_eq!(advice(&fixed, None, Language::English).len(), 1);
        let told = advice(&overview, None, Language::English);
        assert!(told[1].contains("`modalign update`"), "{told:?}");
        assert!(
            told[0].contains("too stiff") && told[0].contains("0.960"),
            "{told:?}"
        );
        let updated: Value = serde_json::from_str(
            r#"{"parameters": [{"name": "mount", "unit": "N/m", "initial": 2e6, "updated": 1.5e6, "std": 1e4, "verdict": "identified"}, {"name": "gap", "verdict": "at bound"}]}"#,
        )
        .unwrap();
        let told = advice(&overview, Some(&updated), Language::English);
        assert_eq!(told, ["mount: 2.000e6 → 1.500e6 ± 1.0e4 N/m"]);
    }

    #[test]
    fn of_many_parameters_those_that_moved_most_are_told() {
        let parameter = |k: usize| serde_json::json!({"name": format!("p{k}"), "unit": "1", "initial": 1.0, "updated": 1.0 + 0.1 * k as f64, "std": 0.1, "verdict": "identified"});
        let many: Vec<Value> = (0..NAMED + 3).map(parameter).collect();
        let told = changes(&many, Language::English);
        assert_eq!(told.len(), NAMED + 1);
        assert_eq!(told[0], "p10: 1.00 → 2.00 ± 0.10", "no unit");
        assert!(told[NAMED].starts_with("3 further"), "{told:?}");
        assert_eq!(changes(&many[..3], Language::English).len(), 3);
        assert_eq!(unit_told("kg m2"), "kg m²");
    }

    #[test]
    fn a_failed_update_is_no_advice() {
        let failed: Value = serde_json::from_str(r#"{"fits": false}"#).unwrap();
        assert_eq!(advice_head(Some(&failed)), "What the update came to");
        let fits: Value = serde_json::from_str(r#"{"fits": true}"#).unwrap();
        assert_eq!(advice_head(Some(&fits)), "What to change");
        assert_eq!(advice_head(None), "What to change");
    }
}
