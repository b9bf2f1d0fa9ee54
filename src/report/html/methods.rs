//! The tab of methods: what the studies beside a run tell of them, and what the script draws of
//! that.

use serde_json::{Map, Value, json};

use super::super::json::{BreakdownFile, RunReport};
use super::super::{Block, Language, breakdown_blocks};
use super::summary::marked;
use super::words::word;
use super::{Beside, escape, fragment};
use crate::study::breakdown::{
    Axis, Bound, Distance, Field, LEVEL, Scale, SliceResult, Stability, StabilityPoint, UserMode,
    UserModePosition, short,
};

const SPEED: &str = "Speed against accuracy";
const BREAKDOWN: &str = "Where methods fail";
const ORDER: &str = "What this scene needs, and what it does not";
const MAP: &str = "Small structures are drawn again and again. Inside its contour a method finds their modes to the stated error in 95 % of the draws; beyond it, it does not. Points are the modes of this run.";
const OTHER_SPEED: &str = "The study in speed-accuracy.json is of another scene or of other data than this run, and is left out; run `modalign study speed-accuracy` again.";
const OTHER_ORDER: &str = "The study in order.json is of another scene or of other data than this run, and is left out; run `modalign study order` again.";
const OTHER_BREAKDOWN: &str = "The study in breakdown.json shows the modes of another scene, or other modes than this run, and is left out; run `modalign study breakdown` again: finished slices are kept.";

/// Share of a frequency by which one that was written twice may differ.
const SAME_MODE: f64 = 1e-6;

/// What the tab says, and what the script draws into it.
#[derive(Default)]
pub(super) struct Methods {
    /// Text, tables and places of figures; empty where no study is there.
    pub content: String,
    /// Data of the figures, by study.
    pub data: Map<String, Value>,
}

/// The tab of a run; a study of another scene is left out with a word.
pub(super) fn methods(report: &RunReport, beside: &Beside, language: Language) -> Methods {
    let mut tab = Methods::default();
    let w = |text: &'static str| escape(word(language, text));
    let note = |text| format!("<p class=\"note\">{}</p>\n", w(text));
    if let Some(own) = &beside.order {
        tab.content += &format!("<h3>{}</h3>\n", w(ORDER));
        tab.content += &match is_of_run(own, report) {
            true => sentences(&own["answers"]) + &tables(own, language),
            false => note(OTHER_ORDER),
        };
    }
    if let Some(own) = &beside.speed_accuracy {
        tab.content += &format!("<h3>{}</h3>\n", w(SPEED));
        if is_of_run(own, report) {
            tab.content += &speed_text(own, language);
            tab.data.insert("speed".to_owned(), speed_data(own));
        } else {
            tab.content += &note(OTHER_SPEED);
        }
    }
    if let Some(own) = &beside.breakdown {
        tab.content += &format!("<h3>{}</h3>\n", w(BREAKDOWN));
        if breakdown_is_of_run(own, report) {
            let tables = language.translated(breakdown_blocks(own));
            tab.content += &format!(
                "<p>{}</p>\n<div class=\"drawn\" data-draw=\"maps\"></div>\n<div class=\"drawn\" data-draw=\"precision\"></div>\n{}",
                w(MAP),
                fragment(&tables, language)
            );
            let data = breakdown_data(own, language);
            tab.data.insert("breakdown".to_owned(), data);
        } else {
            tab.content += &note(OTHER_BREAKDOWN);
        }
    }
    tab
}

fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

/// Whether a study has the title of the run's scene, and each of its tests the name and the data of
/// one of the run's.
fn is_of_run(own: &Value, report: &RunReport) -> bool {
    let same_data = |test: &Value| {
        let name = test["name"].as_str().unwrap_or_default();
        let hashes = items(&test["inputs"]).filter_map(|file| file["sha256"].as_str());
        let known = report.provenance.inputs.iter();
        let known = known.filter_map(|[test, _, hash]| (test == name).then_some(hash.as_str()));
        report.figures.tests.iter().any(|test| test.name == name) && hashes.eq(known)
    };
    own["title"].as_str() == Some(&report.title) && items(&own["tests"]).all(same_data)
}

/// Whether a study shows modes of no scene, or those of the run.
fn breakdown_is_of_run(own: &BreakdownFile, report: &RunReport) -> bool {
    let Some(title) = &own.title else {
        return true;
    };
    let known = |mode: &UserMode| {
        let mut tests = report.figures.tests.iter();
        let of_test = |name: &str| mode.test.is_empty() || mode.test == name;
        let near = |hz: f64| (hz - mode.frequency_hz).abs() <= SAME_MODE * hz;
        tests.any(|test| {
            let mark = test.modes.get(mode.number.saturating_sub(1));
            of_test(&test.name) && mark.is_some_and(|mark| near(mark.hz))
        })
    };
    *title == report.title && own.user_modes.iter().all(known)
}

/// What the study teaches, its figures, its tables.
fn speed_text(own: &Value, language: Language) -> String {
    sentences(&own["lessons"])
        + "<div class=\"drawn\" data-draw=\"speed\"></div>\n"
        + &tables(own, language)
}

fn sentences(own: &Value) -> String {
    let all = items(own).filter_map(Value::as_str);
    all.map(|text| format!("<p class=\"why\">{}</p>\n", marked(text)))
        .collect()
}

fn tables(own: &Value, language: Language) -> String {
    let tables = serde_json::from_value::<Vec<Block>>(own["tables"].clone());
    fragment(&language.translated(tables.unwrap_or_default()), language)
}

/// What the figures show of a row.
const ROW: &[&str] = &[
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

/// The same of a row of times.
const TIME: &[&str] = &[
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

fn speed_data(own: &Value) -> Value {
    let rows = |key: &str, fields| -> Vec<Value> {
        items(&own[key]).map(|row| thinned(row, fields)).collect()
    };
    let test = |test: &Value| {
        thinned(
            test,
            &["name", "refined_frequency_std", "refined_damping_std"],
        )
    };
    json!({
        "snr_db": own["compared_at_snr_db"],
        "tests": items(&own["tests"]).map(test).collect::<Vec<_>>(),
        "rows": rows("rows", ROW),
        "times": rows("times", TIME),
    })
}

/// The known ones of these fields, numbers with five digits.
fn thinned(row: &Value, fields: &[&str]) -> Value {
    let field = |name: &&str| match &row[*name] {
        Value::Null => None,
        Value::Number(own) => Some(((*name).to_owned(), json!(rounded(own.as_f64()?, 4)))),
        other => Some(((*name).to_owned(), other.clone())),
    };
    Value::Object(fields.iter().filter_map(field).collect())
}

/// A number with so many digits after the first.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}").parse().unwrap_or(value)
}

fn breakdown_data(own: &BreakdownFile, language: Language) -> Value {
    let slices = own.slices.iter();
    let slices = slices.map(|slice| slice_data(slice, &own.user_modes, language));
    json!({
        "slices": slices.collect::<Vec<_>>(),
        "courses": own.stability.as_ref().map(courses),
    })
}

/// Shares in percent on the finest grid, column by column, contours, and the modes inside; places
/// are shares of the axes.
fn slice_data(result: &SliceResult, own: &[UserMode], language: Language) -> Value {
    let slice = &result.slice;
    let methods = 0..slice.methods.len();
    let fields: Vec<Field> = methods.map(|m| result.field(m, Bound::Counted)).collect();
    let percent = |share: &f64| (100.0 * share).round() as u8;
    let shares = |field: &Field| -> Vec<Vec<u8>> {
        let columns = field.values.iter();
        columns
            .map(|column| column.iter().map(percent).collect())
            .collect()
    };
    let contours = |field: &Field| -> Vec<Vec<[f64; 2]>> {
        let lines = field.contour(LEVEL).into_iter();
        lines
            .map(|line| line.into_iter().map(place).collect())
            .collect()
    };
    let axis = |own: &Axis| {
        json!({
            "label": word(language, own.factor.label(slice.needs_test())),
            "lo": own.lo,
            "hi": own.hi,
            "log": own.scale == Scale::Log,
            "whole": own.factor.is_whole(),
        })
    };
    let points = result.points(own);
    let inside = points.iter().filter(|point| point.inside());
    let inside: Vec<Value> = inside
        .map(|own| point_data(own, result, language))
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

fn place([x, y]: [f64; 2]) -> [f64; 2] {
    [x, y].map(|own| (1e4 * own).round() / 1e4)
}

/// A mode with its distance from the contour of each method, and the method that fails nearest to
/// it.
fn point_data(own: &UserModePosition, result: &SliceResult, language: Language) -> Value {
    let margins = own.margins.iter().map(|margin| {
        let distance = margin.distance.map(|own| distance_text(own, language));
        json!({ "inside": margin.inside, "distance": distance })
    });
    let nearest = own.nearest().map(|(method, _)| method);
    let mut methods = result.slice.methods.iter();
    json!({
        "test": own.mode.test,
        "number": own.mode.number,
        "hz": rounded(own.mode.frequency_hz, 6),
        "place": place(own.place),
        "margins": margins.collect::<Vec<_>>(),
        "nearest": methods.position(|own| Some(own.as_str()) == nearest),
    })
}

/// `0.3 decades of damping`.
fn distance_text(own: Distance, language: Language) -> String {
    let value = short(own.value());
    let factor = own.axis.factor;
    match language {
        Language::English => format!("{value} {}", own.unit()),
        Language::Chinese => {
            let unit = match own.axis.scale {
                Scale::Log => "decades",
                Scale::Linear => factor.unit(),
            };
            let (unit, name) = (word(language, unit), word(language, factor.name()));
            format!("{value} {unit}({name})")
        }
    }
}

fn courses(own: &Stability) -> Value {
    let course = |own: &crate::study::breakdown::StabilityCourse| {
        let column = |value: fn(&StabilityPoint) -> Option<f64>| -> Vec<Option<f64>> {
            let points = own.points.iter();
            points.map(|own| Some(rounded(value(own)?, 2))).collect()
        };
        json!({
            "method": own.method,
            "order": own.points.iter().map(|own| own.order).collect::<Vec<_>>(),
            "digits": column(|own| Some(own.digits_lost())),
            "errors": [
                column(|own| own.error),
                column(|own| own.error_f32_data),
                column(|own| own.error_f32_matrix),
            ],
        })
    };
    own.courses.iter().map(course).collect()
}
