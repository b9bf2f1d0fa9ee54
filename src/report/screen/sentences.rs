//! Sentences of a screen: limits, synthetic recordings, assumptions, published results and the
//! points to measure next.

use std::collections::BTreeSet;

use crate::correlate::published::ClaimVerdict;
use crate::correlate::{ComparisonTable, Row, Status, TestCell, TestSummary};
use crate::finding::{Code, Finding, Location, Severity};
use crate::report::Cell;
use crate::report::error_range::{error_range, lean, one_sided_modes};
use crate::report::placement::label;
use crate::report::published::claim_values;
use crate::report::table::significant;
use crate::scene::{
    CommonError, ExpectedResult, LimitCheck, PlacedTest, TestResult, Theory,
    common_error as scene_error,
};
use crate::theory::{Assumption, ParameterStatus};

use crate::printable::listed;

use super::counted;
use super::modes::{peak_frequencies, peaks_sentence};

/// Maximum number of missed limits that a sentence names.
const MAX_NAMED_LIMITS: usize = 4;
/// Maximum number of steps of a recommendation that a sentence names.
const MAX_NAMED_STEPS: usize = 1;

/// Whether the limits of a scene are met, and the missed ones, or the one that is nearest to being
/// missed, with their values.
pub(super) fn limits(checks: &[LimitCheck]) -> String {
    let missed: Vec<&LimitCheck> = checks.iter().filter(|check| !check.is_met()).collect();
    if checks.is_empty() {
        return "Limits of the scene: none stated.".to_owned();
    }
    if missed.is_empty() {
        let all = checks.len();
        let kinds = limited_kinds(checks);
        let on = match kinds.as_slice() {
            few if few.len() <= MAX_NAMED_KINDS => format!(", on {}", few.join(", ")),
            _ => String::new(),
        };
        let judges_errors = kinds
            .iter()
            .any(|kind| kind.contains("error") || kind.contains("MAC"));
        let none = match judges_errors {
            true => "",
            false => "; none is on errors or MAC",
        };
        let nearest = nearest_limit(checks).map_or_else(String::new, |nearest| {
            let (place, what) = nearest.what.split_once(": ").unwrap_or(("", &nearest.what));
            let what = match place {
                "" => what.to_owned(),
                place => format!("{what} of {place}"),
            };
            format!("; nearest: {what}, {}", value_and_limit(nearest))
        });
        return format!("Limits of the scene: {all} of {all} met{on}{none}{nearest}.");
    }
    let named = missed
        .iter()
        .take(MAX_NAMED_LIMITS)
        .map(|check| limit(check));
    let further = missed.len().saturating_sub(MAX_NAMED_LIMITS);
    let further = (further > 0).then(|| format!("{further} more"));
    let named: Vec<String> = named.chain(further).collect();
    format!(
        "Limits of the scene: {} of {} MISSED ({}).",
        missed.len(),
        checks.len(),
        named.join("; ")
    )
}

/// Maximum number of kinds of limits that a sentence names.
pub(super) const MAX_NAMED_KINDS: usize = 3;

/// The kinds of the limited quantities, without their tests and units.
pub(super) fn limited_kinds(checks: &[LimitCheck]) -> Vec<&str> {
    let mut kinds: Vec<&str> = Vec::new();
    for check in checks {
        let what = check.what.rsplit(": ").next().unwrap_or_default();
        let kind = match what.split(" (").next().unwrap_or_default() {
            "extra modes" => "unmatched test modes",
            kind => kind,
        };
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    kinds
}

/// The limit of a ratio or an error that is nearest to being missed; counts are none.
pub(super) fn nearest_limit(checks: &[LimitCheck]) -> Option<&LimitCheck> {
    let distance = |check: &&LimitCheck| (check.value.unwrap_or(f64::NAN) / check.limit).ln().abs();
    let is_count = |check: &LimitCheck| {
        check.limit.fract() <= 0.0 && check.value.is_none_or(|value| value.fract() <= 0.0)
    };
    let comparable = checks
        .iter()
        .filter(|check| distance(check).is_finite() && !is_count(check));
    comparable.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// A limit with its value.
pub(super) fn limit(check: &LimitCheck) -> String {
    format!("{} {}", check.what, value_and_limit(check))
}

/// Characters of a stated limit, of which a computed one has more.
const MAX_LIMIT_CHARACTERS: usize = 10;

fn value_and_limit(check: &LimitCheck) -> String {
    let exact = check.limit.to_string();
    let is_computed = exact.len() > MAX_LIMIT_CHARACTERS;
    let limit = match is_computed {
        true => significant(check.limit, 4),
        false => exact,
    };
    let value = check.value.map_or("none".to_owned(), |value| {
        // Rounded, a missed limit could read as met.
        let rounded = significant(value, 4);
        if rounded == limit {
            value.to_string()
        } else {
            rounded
        }
    });
    let relation = if check.upper { "at most" } else { "at least" };
    format!("{value} ({relation} {limit})")
}

/// Maximum number of assumed parameters that a sentence names.
const MAX_NAMED_PARAMETERS: usize = 4;
/// Maximum number of tests whose peaks a sentence names.
const MAX_NAMED_TESTS: usize = 2;
/// Maximum number of unmatched modes that a sentence names.
const MAX_NAMED_MODES: usize = 4;

/// Pairs in numbers, and the modes that a test should have shown.
pub(super) fn pairs(table: &ComparisonTable) -> String {
    let is_missed =
        |cell: &TestCell| cell.status == Status::MissedUnexpected && cell.is_status_certain();
    let missed = named_rows(table, is_missed).map(|named| format!("; unmatched: {named}"));
    let missed = missed.unwrap_or_default();
    let sum = |count: fn(&TestSummary) -> usize| table.summary.iter().map(count).sum::<usize>();
    let in_band = sum(|s| s.paired + s.ambiguous + s.missed + s.not_observable);
    let paired = sum(|s| s.paired);
    let (by_shape, by_frequency) = (sum(|s| s.paired_by_shape), sum(|s| s.paired_by_frequency));
    let several = table.summary.len() > 1;
    let extra = match sum(|s| s.extra) {
        0 => String::new(),
        count => format!("; test modes without partner: {count}"),
    };
    let of_model = match several {
        true => {
            let in_a_band = |row: &&Row| {
                let mut tests = row.tests.iter();
                row.theory.is_some() && tests.any(|cell| cell.status != Status::OutsideBand)
            };
            let (modes, tests) = (
                table.rows.iter().filter(in_a_band).count(),
                table.summary.len(),
            );
            format!("{in_band} ({modes} model modes in {tests} tests)")
        }
        false => format!("{in_band} model modes"),
    };
    let others = [
        (sum(|s| s.ambiguous), "ambiguous"),
        (sum(|s| s.not_observable), "not observable"),
    ];
    let others = others.iter().filter(|(count, _)| *count > 0);
    let others: String = others
        .map(|(count, what)| format!(", {count} {what}"))
        .collect();
    format!(
        "Pairs: {paired} of {of_model}, {by_shape} by shape, {by_frequency} by frequency{others}{missed}{extra}."
    )
}

/// Whether a cell is of a kind of mode without partner.
type IsOfKind = fn(&TestCell) -> bool;

/// The modes of the model, called `modes`, that the points of the tests do not see, and those that
/// they should have seen; `None` where each mode in the band of a test has a partner.
pub(super) fn unseen_modes(modes: &str, table: &ComparisonTable) -> Option<String> {
    let kinds: [(&str, IsOfKind); 3] = [
        ("not observable at the points", |cell| {
            cell.status == Status::NotObservable
        }),
        ("unmatched", |cell| {
            cell.status == Status::MissedUnexpected && cell.is_status_certain()
        }),
        ("unmatched, observability unknown", |cell| {
            cell.status == Status::MissedUnexpected && !cell.is_status_certain()
        }),
    ];
    let of_kind = |(what, applies): &(&str, IsOfKind)| {
        Some(format!("{what}: {}", named_rows(table, *applies)?))
    };
    let all: Vec<String> = kinds.iter().filter_map(of_kind).collect();
    (!all.is_empty()).then(|| format!("{modes} without partner: {}.", all.join("; ")))
}

/// The rows with a cell to which this applies, the first of many, with their tests where there are
/// several; `None` without any.
fn named_rows(table: &ComparisonTable, applies: fn(&TestCell) -> bool) -> Option<String> {
    let several = table.summary.len() > 1;
    let named = |row: &Row| {
        let cells = row.tests.iter().filter(|cell| applies(cell));
        let tests: Vec<&str> = cells.map(|cell| cell.test.as_str()).collect();
        match (tests.is_empty(), several) {
            (true, _) => None,
            (false, true) => Some(format!("{} ({})", row.label, listed(&tests))),
            (false, false) => Some(row.label.clone()),
        }
    };
    let mut names: Vec<String> = table.rows.iter().filter_map(named).collect();
    let further = names.len().saturating_sub(MAX_NAMED_MODES);
    names.truncate(MAX_NAMED_MODES);
    names.extend((further > 0).then(|| format!("{further} more")));
    (!names.is_empty()).then(|| names.join(", "))
}

/// The tests whose recordings are synthetic, and the models that they were computed from; `None`
/// without any.
pub(super) fn synthetic<'a>(tests: impl Iterator<Item = &'a TestResult> + Clone) -> Option<String> {
    let count = tests.clone().count();
    let synthetic = tests.filter(|test| test.is_synthetic());
    let names: Vec<&str> = synthetic.clone().map(|test| test.name.as_str()).collect();
    let findings = synthetic.flat_map(|test| &test.modes.findings);
    let findings = findings.filter(|finding| finding.code == Code::Synthetic);
    let details: Vec<&str> = findings
        .filter_map(|finding| finding.detail.as_deref())
        .collect();
    let models = details.iter().filter_map(|detail| detail.split(':').next());
    let models: BTreeSet<&str> = models.collect();
    let changes = match details.iter().any(|detail| detail.contains(':')) {
        true => " with changes (--full)",
        false => "",
    };
    let models: Vec<&str> = models.into_iter().collect();
    let sources = format!("{}{changes}", models.join(" and "));
    match names.len() {
        0 => None,
        all if all == count => Some(format!(
            "The recordings are synthetic, not measured: computed from {sources}."
        )),
        _ => Some(format!(
            "Synthetic recordings, not measured: {}; computed from {sources}.",
            listed(&names)
        )),
    }
}

/// A line for each warning that puts the verdict of a comparison in question, with the tests that
/// it is about and the factor that it is about.
pub(super) fn verdict_warnings(findings: &[(String, Vec<Finding>)]) -> Vec<String> {
    let of_code = |code: &Code| {
        let warned = findings.iter().filter_map(|(test, findings)| {
            let mut of_test = findings.iter();
            let is_warning =
                |finding: &&Finding| finding.code == *code && finding.severity > Severity::Info;
            Some((test.as_str(), of_test.find(is_warning)?))
        });
        let warned: Vec<(&str, &Finding)> = warned.collect();
        let factor = |finding: &Finding| {
            let numbers = finding
                .numbers_text()
                .filter(|_| OF_A_FACTOR.contains(code));
            numbers.map_or_else(String::new, |numbers| format!(" ({numbers})"))
        };
        let places = match warned.as_slice() {
            [("", finding)] => factor(finding),
            _ => {
                let names: Vec<&str> = warned.iter().map(|(test, _)| *test).collect();
                let factors: Vec<String> = warned.iter().map(|(_, one)| factor(one)).collect();
                match names.iter().all(|name| name.is_empty()) {
                    true => String::new(),
                    false => format!(": {}{}", listed(&names), factors.concat()),
                }
            }
        };
        let sentence = code.sentence().trim_end_matches('.');
        (!warned.is_empty()).then(|| format!("Warning: {sentence}{places}."))
    };
    Code::ON_THE_VERDICT.iter().filter_map(of_code).collect()
}

/// The codes on the verdict whose sentence is about a factor, the value.
const OF_A_FACTOR: [Code; 2] = [Code::CommonFactor, Code::ShapesAgree];

/// A line on the sensors and hits at which the model does not move.
pub(super) fn unmoved_sensors(theory: &Theory) -> Option<String> {
    let findings = theory.modes.findings.iter();
    let unmoved = findings.filter(|finding| finding.code == Code::SensorUnmoved);
    let mut names: Vec<String> = unmoved
        .map(|finding| match &finding.location {
            Location::Function {
                response: Some(dof),
                ..
            }
            | Location::Function {
                reference: Some(dof),
                ..
            } => dof.to_string(),
            location => location.to_string(),
        })
        .collect();
    let count = names.len();
    let further = count.saturating_sub(MAX_NAMED_MODES);
    names.truncate(MAX_NAMED_MODES);
    names.extend((further > 0).then(|| format!("{further} more")));
    (count > 0).then(|| {
        format!(
            "Warning: The model does not move at {}: {}.",
            counted(count, "sensor or hit").replace("sensor or hits", "sensors or hits"),
            names.join(", ")
        )
    })
}

/// How the model is off where its pairs are off to one side: the factor on all stiffnesses that
/// removes the mean error, or how the errors differ; `None` where they have no common sign.
pub(super) fn common_error(table: &ComparisonTable) -> Option<String> {
    match scene_error(table)? {
        CommonError::Factor(factor) => Some(format!(
            "The model is too {}: one factor {factor:.3} on all stiffnesses removes the mean error.",
            lean(factor < 1.0)
        )),
        CommonError::Range(range) => Some(error_range(&range)),
        CommonError::OneSided(modes) => Some(one_sided_modes(&modes)),
    }
}

/// The peaks of the tests' FRFs at which no mode was accepted.
pub(super) fn peaks_without_mode(tests: &[TestResult]) -> Option<String> {
    let of_test = |test: &TestResult| {
        let peaks = peak_frequencies(&test.modes)?;
        Some(match tests.len() {
            1 => peaks,
            _ => format!("{}: {peaks}", test.name),
        })
    };
    let mut all: Vec<String> = tests.iter().filter_map(of_test).collect();
    let further = all.len().saturating_sub(MAX_NAMED_TESTS);
    all.truncate(MAX_NAMED_TESTS);
    all.extend((further > 0).then(|| format!("in {} (--full)", counted(further, "further test"))));
    (!all.is_empty()).then(|| peaks_sentence(&all.join("; ")))
}

/// What the model assumes beyond printed or measured values; `None` where it assumes nothing.
pub(super) fn assumptions(theory: &Theory) -> Option<String> {
    let parameters = theory.parameters.iter();
    let assumed = parameters.filter(|(spec, _)| spec.status == ParameterStatus::Assumed);
    let assumed: Vec<&str> = assumed.map(|(spec, _)| spec.name.as_str()).collect();
    let (guesses, statements): (Vec<&Assumption>, Vec<&Assumption>) = theory
        .assumptions
        .iter()
        .partition(|assumption| assumption.is_guess);
    let guesses = guesses.iter();
    let guesses = guesses.map(|guess| format!("{} of {}", guess.statement, guess.about));
    let mut parts: Vec<String> = guesses.collect();
    if !statements.is_empty() {
        parts.push(counted(statements.len(), "statement"));
    }
    if !assumed.is_empty() {
        let parameters = counted(assumed.len(), "parameter");
        let further = assumed.len().saturating_sub(MAX_NAMED_PARAMETERS);
        let further = (further > 0).then(|| format!("{further} more"));
        let named = assumed.into_iter().take(MAX_NAMED_PARAMETERS);
        let named: Vec<String> = named.map(str::to_owned).chain(further).collect();
        parts.push(format!("{parameters} ({})", named.join(", ")));
    }
    let last = parts.pop()?;
    let text = match parts.is_empty() {
        true => last,
        false => format!("{} and {last}", parts.join(", ")),
    };
    Some(format!("Assumed in the model: {text}."))
}

/// Published results against the model and one another.
pub(super) fn published(expected: &ExpectedResult) -> Vec<String> {
    let roots = expected
        .roots
        .as_ref()
        .and_then(|roots| roots.simple.as_ref());
    let roots = roots.map(|errors| {
        format!(
            "Published frequencies: {} of the model against the publication, rms error {:.3} %, largest {} % at {}.",
            counted(errors.count, "single root"),
            errors.rms_percent,
            Cell::signed(Some(errors.largest_percent), 3).display(),
            errors.largest_at
        )
    });
    let count = |confirmed: Option<bool>| {
        let claims = expected.verdicts.iter();
        claims
            .filter(|claim: &&ClaimVerdict| claim.confirmed == confirmed)
            .count()
    };
    let claims = (!expected.verdicts.is_empty()).then(|| {
        format!(
            "Published statements: {} reproduced, {} not reproduced, {} not checkable.",
            count(Some(true)),
            count(Some(false)),
            count(None)
        )
    });
    roots.into_iter().chain(claims).collect()
}

/// The published statements that were not reproduced, a line of this width for each, with the value
/// as printed and as recomputed; of more than `most` the first, and the number of the others. A
/// single one is in a line with that number.
pub(super) fn not_reproduced(expected: &ExpectedResult, width: usize, most: usize) -> Vec<String> {
    let claims = expected.verdicts.iter();
    let failed: Vec<&ClaimVerdict> = claims
        .filter(|claim| claim.confirmed == Some(false))
        .collect();
    let text = |claim: &ClaimVerdict, around: usize| {
        let [printed, recomputed] = claim_values(claim).map(|cell| cell.display());
        let values = format!(": printed {printed}, here {recomputed}");
        let room = width.saturating_sub(values.chars().count() + around);
        format!("{}{values}", shortened(&claim.text, room))
    };
    if let (1, [first, others @ ..]) = (most, failed.as_slice()) {
        let head = "Not reproduced: ";
        let further = match others.len() {
            0 => ".".to_owned(),
            further => format!("; {further} more (--full)."),
        };
        let around = head.chars().count() + further.chars().count();
        return vec![format!("{head}{}{further}", text(first, around))];
    }
    let shown = match failed.len() > most {
        true => most.saturating_sub(1),
        false => failed.len(),
    };
    let line = |claim: &&ClaimVerdict| format!("- {}", text(claim, "- ".len()));
    let further = failed.len() - shown;
    let lines = failed.iter().take(shown).map(line);
    let further = (further > 0).then(|| {
        let further = counted(further, "further statement");
        format!("- {further}: --full")
    });
    let lines: Vec<String> = lines.chain(further).collect();
    let head = (!lines.is_empty()).then(|| "Not reproduced:".to_owned());
    head.into_iter().chain(lines).collect()
}

/// A text cut between words.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let kept: String = text.chars().take(most.saturating_sub(2)).collect();
    let end = kept.rfind(' ').unwrap_or(kept.len());
    format!("{} …", kept[..end].trim_end_matches([',', ':', ';', ' ']))
}

/// The points that a test may have in addition, or why they are unknown; `None` where none makes a
/// further mode observable.
pub(super) fn next_points(placed: &PlacedTest, table: Option<&ComparisonTable>) -> Option<String> {
    let placement = match &placed.placement {
        Ok(placement) => placement,
        Err(why) => {
            return Some(format!(
                "Further points of {}: unknown, {why}.",
                placed.test
            ));
        }
    };
    let steps = placement.steps.iter().take(MAX_NAMED_STEPS).map(|step| {
        let hit = step
            .hit
            .as_ref()
            .map(|dof| format!("excitation point {dof}"));
        let sensor = step.sensor.as_ref().map(|dof| format!("sensor {dof}"));
        let points: Vec<String> = hit.into_iter().chain(sensor).collect();
        let shown = step.shown.iter();
        let modes = shown.map(|(root, _)| label(&placement.roots[*root], table));
        let modes: Vec<String> = modes.collect();
        format!(
            "To observe {} in {}: {}.",
            modes.join(", "),
            listed(&[placed.test.as_str()]),
            points.join(" and ")
        )
    });
    let steps: Vec<String> = steps.collect();
    (!steps.is_empty()).then(|| steps.join("\n"))
}
