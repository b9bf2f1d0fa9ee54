//! The methods tab shows the studies in the folder of a run: their text, their tables, and the data
//! of their figures.

use serde_json::{Map, Value, json};

use super::super::json::{BreakdownFile, RunReport};
use super::super::texts::{TEXTS, Text, translate};
use super::super::{Block, Language, breakdown_blocks};
use super::CompanionResults;
use super::markup::{escape, fragment, text_with_code};
use crate::study::breakdown::{
    Axis, Distance, Field, MIN_SUCCESS_RATE, Scale, SliceResult, Stability, StabilityPoint,
    SuccessRate, UserMode, UserModePosition, short_number,
};

/// Maximum relative difference of two written values of one frequency.
const FREQUENCY_TOLERANCE: f64 = 1e-6;

/// Content of the tab, and the data that the script draws.
#[derive(Default)]
pub(super) struct MethodsTab {
    /// Text, tables and containers of the figures; empty without a study.
    pub content: String,
    /// Data of the figures, by study.
    pub data: Map<String, Value>,
}

/// The methods tab of a run; a note replaces a study of another scene.
pub(super) fn methods(
    report: &RunReport,
    companions: &CompanionResults,
    language: Language,
) -> MethodsTab {
    let mut tab = MethodsTab::default();
    let texts = &TEXTS.page;
    let w = |text: &Text| escape(text.in_language(language));
    let note = |text| format!("<p class=\"note\">{}</p>\n", w(text));
    if let Some(study) = &companions.order {
        tab.content += &format!("<h3>{}</h3>\n", w(&texts.order_study));
        tab.content += &match study_belongs_to_run(study, report) {
            true => {
                sentences(&study["verdict"])
                    + &sentences(&study["answers"])
                    + &tables(study, language)
            }
            false => note(&texts.order_of_another_run),
        };
    }
    if let Some(study) = &companions.speed_accuracy {
        tab.content += &format!("<h3>{}</h3>\n", w(&texts.speed_study));
        if study_belongs_to_run(study, report) {
            tab.content += &speed_text(study, language);
            tab.data.insert("speed".to_owned(), speed_data(study));
        } else {
            tab.content += &note(&texts.speed_of_another_run);
        }
    }
    if let Some(study) = &companions.breakdown {
        tab.content += &format!("<h3>{}</h3>\n", w(&texts.breakdown_study));
        if breakdown_belongs_to_run(study, report) {
            let tables = language.translated(breakdown_blocks(study));
            tab.content += &format!(
                "<p>{}</p>\n<div class=\"drawn\" data-draw=\"maps\"></div>\n<div class=\"drawn\" data-draw=\"precision\"></div>\n{}",
                w(&texts.map_text),
                fragment(&tables, language)
            );
            let data = breakdown_data(study, language);
            tab.data.insert("breakdown".to_owned(), data);
        } else {
            tab.content += &note(&texts.breakdown_of_another_run);
        }
    }
    tab
}

fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

/// Whether a study has the title of the run's scene, and each of its tests has the name and the
/// data of a test of the run.
fn study_belongs_to_run(study: &Value, report: &RunReport) -> bool {
    let same_data = |test: &Value| {
        let name = test["name"].as_str().unwrap_or_default();
        let hashes = items(&test["inputs"]).filter_map(|file| file["sha256"].as_str());
        let run_hashes = report.provenance.inputs.iter();
        let run_hashes =
            run_hashes.filter_map(|[test, _, hash]| (test == name).then_some(hash.as_str()));
        report.figures.tests.iter().any(|test| test.name == name) && hashes.eq(run_hashes)
    };
    study["title"].as_str() == Some(&report.title) && items(&study["tests"]).all(same_data)
}

/// Whether the modes of a study are those of the run; true for a study without a scene.
fn breakdown_belongs_to_run(study: &BreakdownFile, report: &RunReport) -> bool {
    let Some(title) = &study.title else {
        return true;
    };
    let in_run = |mode: &UserMode| {
        let mut tests = report.figures.tests.iter();
        let of_test = |name: &str| mode.test.is_empty() || mode.test == name;
        let near = |hz: f64| (hz - mode.frequency_hz).abs() <= FREQUENCY_TOLERANCE * hz;
        tests.any(|test| {
            let mark = test.modes.get(mode.number.saturating_sub(1));
            of_test(&test.name) && mark.is_some_and(|mark| near(mark.hz))
        })
    };
    *title == report.title && study.user_modes.iter().all(in_run)
}

/// Verdicts and recommendations of the study, its figures, its tables.
fn speed_text(study: &Value, language: Language) -> String {
    sentences(&study["verdict"])
        + &sentences(&study["lessons"])
        + "<div class=\"drawn\" data-draw=\"speed\"></div>\n"
        + &tables(study, language)
}

fn sentences(texts: &Value) -> String {
    let all = items(texts).filter_map(Value::as_str);
    all.map(|text| format!("<p class=\"why\">{}</p>\n", text_with_code(text)))
        .collect()
}

fn tables(study: &Value, language: Language) -> String {
    let tables = serde_json::from_str::<Vec<Block>>(&study["tables"].to_string());
    fragment(&language.translated(tables.unwrap_or_default()), language)
}

/// Fields of a row that the figures show.
const SPEED_ROW_FIELDS: &[&str] = &[
    "test",
    "data",
    "estimator",
    "step_hz",
    "snr_db",
    "method",
    "order",
    "observable",
    "found",
    "spurious",
    "frequency_rms",
    "damping_rms",
    "shape_rms",
    "frequency_over_bound",
    "damping_over_bound",
    "frequency_bound_rms",
    "damping_bound_rms",
    "refined",
];

/// Fields of a row of times that the figures show.
const SPEED_TIME_FIELDS: &[&str] = &[
    "test",
    "data",
    "estimator",
    "step_hz",
    "method",
    "order",
    "cpu_s",
    "spread_s",
    "peak_bytes",
    "on_front",
];

fn speed_data(study: &Value) -> Value {
    let rows = |key: &str, fields| -> Vec<Value> {
        items(&study[key])
            .map(|row| select_fields(row, fields))
            .collect()
    };
    let test = |test: &Value| {
        select_fields(
            test,
            &["name", "refined_frequency_std", "refined_damping_std"],
        )
    };
    json!({
        "snr_db": study["compared_at_snr_db"],
        "tests": items(&study["tests"]).map(test).collect::<Vec<_>>(),
        "rows": rows("rows", SPEED_ROW_FIELDS),
        "times": rows("times", SPEED_TIME_FIELDS),
    })
}

/// The fields of this list that a row has; numbers have five digits.
fn select_fields(row: &Value, fields: &[&str]) -> Value {
    let field = |name: &&str| match &row[*name] {
        Value::Null => None,
        Value::Number(number) => Some(((*name).to_owned(), json!(rounded(number.as_f64()?, 4)))),
        other => Some(((*name).to_owned(), other.clone())),
    };
    Value::Object(fields.iter().filter_map(field).collect())
}

/// A number with `digits` digits after the first.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}").parse().unwrap_or(value)
}

fn breakdown_data(study: &BreakdownFile, language: Language) -> Value {
    let slices = study.slices.iter();
    let slices = slices.map(|slice| slice_data(slice, &study.user_modes, language));
    json!({
        "slices": slices.collect::<Vec<_>>(),
        "courses": study.stability.as_ref().map(stability_data),
    })
}

/// Detection rates in percent on the finest grid by columns, contours, and the modes inside the
/// map; locations are fractions of the axes.
fn slice_data(result: &SliceResult, user_modes: &[UserMode], language: Language) -> Value {
    let slice = &result.slice;
    let methods = 0..slice.methods.len();
    let fields: Vec<Field> = methods
        .map(|m| result.field(m, SuccessRate::Counted))
        .collect();
    let percent = |share: &f64| (100.0 * share).round() as u8;
    let shares = |field: &Field| -> Vec<Vec<u8>> {
        let columns = field.values.iter();
        columns
            .map(|column| column.iter().map(percent).collect())
            .collect()
    };
    let contours = |field: &Field| -> Vec<Vec<[f64; 2]>> {
        let lines = field.contour(MIN_SUCCESS_RATE).into_iter();
        lines
            .map(|line| line.into_iter().map(round_location).collect())
            .collect()
    };
    let axis = |axis: &Axis| {
        json!({
            "label": factor_text(axis.factor.label(slice.needs_test()), language),
            "lo": axis.lo,
            "hi": axis.hi,
            "log": axis.scale == Scale::Log,
            "whole": axis.factor.is_whole(),
        })
    };
    let points = result.locate_modes(user_modes);
    let inside = points.iter().filter(|point| point.is_inside());
    let inside: Vec<Value> = inside
        .map(|point| point_data(point, result, language))
        .collect();
    json!({
        "name": slice.name,
        "draws": slice.draws,
        "x": axis(&slice.x),
        "y": axis(&slice.y),
        "methods": slice.methods,
        "shares": fields.iter().map(shares).collect::<Vec<_>>(),
        "contours": fields.iter().map(contours).collect::<Vec<_>>(),
        "outside": points.len() - inside.len(),
        "points": inside,
    })
}

fn round_location([x, y]: [f64; 2]) -> [f64; 2] {
    [x, y].map(|fraction| (1e4 * fraction).round() / 1e4)
}

/// A mode with its distance from the failure boundary of each method, and the method with the
/// nearest one.
fn point_data(position: &UserModePosition, result: &SliceResult, language: Language) -> Value {
    let margins = position.margins.iter().map(|margin| {
        let distance = margin
            .distance
            .map(|distance| distance_text(distance, language));
        json!({ "inside": margin.inside, "distance": distance })
    });
    let nearest = position.nearest().map(|(method, _)| method);
    let mut methods = result.slice.methods.iter();
    json!({
        "test": position.mode.test,
        "number": position.mode.number,
        "hz": rounded(position.mode.frequency_hz, 6),
        "place": round_location(position.place),
        "margins": margins.collect::<Vec<_>>(),
        "nearest": methods.position(|name| Some(name.as_str()) == nearest),
    })
}

/// Name, unit or axis of a factor in a language.
pub(super) fn factor_text(english: &str, language: Language) -> &str {
    translate(TEXTS.factors, language, english)
}

/// `0.3 decades of damping`.
fn distance_text(distance: Distance, language: Language) -> String {
    let value = short_number(distance.value());
    let factor = distance.axis.factor;
    match language {
        Language::English => format!("{value} {}", distance.unit()),
        Language::Chinese => {
            let unit = match distance.axis.scale {
                Scale::Log => "decades",
                Scale::Linear => factor.unit(),
            };
            let (unit, name) = (
                factor_text(unit, language),
                factor_text(factor.name(), language),
            );
            format!("{value} {unit}({name})")
        }
    }
}

fn stability_data(stability: &Stability) -> Value {
    let course_data = |result: &crate::study::breakdown::StabilityCurve| {
        let column = |value: fn(&StabilityPoint) -> Option<f64>| -> Vec<Option<f64>> {
            let points = result.points.iter();
            points
                .map(|point| Some(rounded(value(point)?, 2)))
                .collect()
        };
        json!({
            "method": result.method,
            "order": result.points.iter().map(|point| point.order).collect::<Vec<_>>(),
            "digits": column(|point| Some(point.digits_lost())),
            "errors": [
                column(|point| point.error),
                column(|point| point.error_f32_data),
                column(|point| point.error_f32_matrix),
            ],
        })
    };
    stability.curves.iter().map(course_data).collect()
}
