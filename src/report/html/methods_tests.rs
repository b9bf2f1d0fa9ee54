//! The methods tab shows the studies of a run and omits those of another scene.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::CompanionResults;
use super::methods::{MethodsTab, factor_text, methods};
use crate::report::Language;
use crate::report::json::{BREAKDOWN_SCHEMA, BreakdownFile, REPORT_SCHEMA, RunReport};
use crate::scene::{Figures, ModeMark, Provenance, TestFigures};
use crate::study::breakdown::{
    Axis, Case, Cell, Factor, Scale, Slice, SliceResult, StatedError, SuccessCount, UserMode,
};

/// A run with one test of one mode.
fn run() -> RunReport {
    let mode = ModeMark {
        hz: 412.3,
        hz_std: None,
        damping_ratio: Some(0.09),
        damping_std: None,
        mpc: None,
    };
    RunReport {
        schema: REPORT_SCHEMA.to_owned(),
        title: "wing".to_owned(),
        sections: Vec::new(),
        findings: Vec::new(),
        limits: Vec::new(),
        next: None,
        figures: Figures {
            tests: vec![TestFigures {
                name: "hammer".to_owned(),
                modes: vec![mode],
                ..TestFigures::default()
            }],
            ..Figures::default()
        },
        provenance: Provenance {
            inputs: vec![["hammer", "hits.uff", "0a1b"].map(str::to_owned)],
            ..Provenance::default()
        },
    }
}

/// A slice of four corners: the first method fails in all draws at the low end of its first axis,
/// the second one nowhere.
fn breakdown() -> BreakdownFile {
    let axis = |factor, lo, hi, scale| Axis {
        factor,
        lo,
        hi,
        count: 2,
        scale,
    };
    let (x, y) = (
        axis(Factor::Damping, 0.001, 0.1, Scale::Log),
        axis(Factor::Noise, 10.0, 70.0, Scale::Linear),
    );
    let count = |good| {
        Some(SuccessCount {
            draws: 10,
            good,
            failures: vec![0; 10],
        })
    };
    let cell = |node: (usize, usize)| Cell {
        node,
        x: x.at(node.0 as f64),
        y: y.at(node.1 as f64),
        counts: vec![count(10 * node.0 as u32), count(10)],
    };
    // 0.98 of the first axis: 0.03 of its two decades beyond the contour at 0.95.
    let damping = 0.001 * 100.0_f64.powf(0.98);
    let values = [(Factor::Damping, damping), (Factor::Noise, 40.0)];
    BreakdownFile {
        schema: BREAKDOWN_SCHEMA.to_owned(),
        title: Some("wing".to_owned()),
        slices: vec![SliceResult {
            slice: Slice {
                name: "noise-damping".to_owned(),
                x,
                y,
                case: Case::default(),
                methods: vec!["circle".to_owned(), "ml".to_owned()],
                stated: StatedError::default(),
                draws: 10,
                refine: 0,
                seed: 1,
            },
            cells: [(0, 0), (0, 1), (1, 0), (1, 1)].map(cell).into(),
        }],
        user_modes: vec![UserMode {
            test: String::new(),
            number: 1,
            frequency_hz: 412.3,
            values: BTreeMap::from(values),
        }],
        stability: None,
    }
}

fn speed() -> Value {
    json!({
        "title": "wing",
        "compared_at_snr_db": 50.0,
        "tests": [{"name": "hammer", "inputs": [{"path": "hits.uff", "sha256": "0a1b"}]}],
        "rows": [{"test": "hammer", "data": "data", "method": "ml", "runs": 1.0, "frequency_rms": 1.0 / 3.0, "order": null}],
        "times": [],
        "lessons": ["hammer: a < b."],
        "tables": [],
    })
}

fn methods_tab(companions: &CompanionResults) -> MethodsTab {
    methods(&run(), companions, Language::English)
}

#[test]
fn a_map_has_contours_detection_rates_and_distances_of_user_modes() {
    let companions = |study| CompanionResults {
        breakdown: Some(study),
        ..CompanionResults::default()
    };
    let tab = methods_tab(&companions(breakdown()));
    let slice = &tab.data["breakdown"]["slices"][0];
    assert_eq!(slice["shares"][0], json!([[0, 0], [100, 100]]));
    assert_eq!(slice["contours"][1], json!([]));
    let line = slice["contours"][0][0]
        .as_array()
        .expect("a line of points");
    assert!(line.len() == 2 && line.iter().all(|point| point[0] == 0.95));
    let point = &slice["points"][0];
    assert_eq!(point["place"], json!([0.98, 0.5]));
    let margins = json!([
        {"inside": true, "distance": "0.06 decades of damping"},
        {"inside": true, "distance": null}
    ]);
    assert_eq!(
        (&point["margins"], &point["nearest"]),
        (&margins, &json!(0))
    );
    assert!(
        tab.content.contains("data-draw=\"maps\"") && tab.content.contains("mode 1 (412.3 Hz)")
    );
    let chinese = methods(&run(), &companions(breakdown()), Language::Chinese);
    let slice = &chinese.data["breakdown"]["slices"][0];
    assert_eq!(slice["x"]["label"], "阻尼比 (-)");
    let distance = &slice["points"][0]["margins"][0]["distance"];
    assert_eq!(distance, "0.06 个数量级(阻尼比)");
}

#[test]
fn words_for_every_factor_and_unit_are_chinese_too() {
    use crate::study::breakdown::FACTORS;
    for factor in FACTORS {
        let labels = [false, true].map(|in_test| factor.label(in_test));
        let unit = factor.unit();
        for text in labels
            .into_iter()
            .chain([factor.name()])
            .chain((!["", "dB"].contains(&unit)).then_some(unit))
        {
            assert!(!factor_text(text, Language::Chinese).is_ascii(), "{text}");
        }
    }
}

#[test]
fn maps_of_another_scene_or_of_other_modes_are_replaced_by_a_note() {
    let with = |change: fn(&mut BreakdownFile)| {
        let mut study = breakdown();
        change(&mut study);
        let companions = CompanionResults {
            breakdown: Some(study),
            ..CompanionResults::default()
        };
        let tab = methods_tab(&companions);
        let left_out = tab.content.contains("modes of another scene");
        assert_eq!(left_out, tab.data.is_empty());
        left_out
    };
    assert!(!with(|_| ()));
    assert!(!with(|study| (
        study.title,
        study.user_modes[0].frequency_hz
    ) = (None, 1.0)));
    assert!(with(|study| study.title = Some("another".to_owned())));
    assert!(with(|study| study.user_modes[0].frequency_hz *= 1.001));
    assert!(with(|study| study.user_modes[0].number = 2));
    assert!(with(|study| study.user_modes[0].test = "shaker".to_owned()));
}

#[test]
fn a_study_of_other_data_is_replaced_by_a_note() {
    let with = |pointer: &str, value: &str| {
        let mut accuracy = speed();
        *accuracy.pointer_mut(pointer).expect("field of the study") = json!(value);
        methods_tab(&CompanionResults {
            speed_accuracy: Some(accuracy),
            ..CompanionResults::default()
        })
    };
    let tab = with("/title", "wing");
    let row = json!({"test": "hammer", "data": "data", "method": "ml", "frequency_rms": 0.33333});
    assert_eq!(tab.data["speed"]["rows"], json!([row]));
    assert!(
        tab.content.contains("hammer: a &lt; b.") && tab.content.contains("data-draw=\"speed\"")
    );
    for (pointer, value) in [
        ("/title", "another"),
        ("/tests/0/name", "shaker"),
        ("/tests/0/inputs/0/sha256", "ffff"),
    ] {
        let tab = with(pointer, value);
        assert!(
            tab.data.is_empty() && tab.content.contains("is left out"),
            "{pointer}"
        );
    }
    assert!(methods_tab(&CompanionResults::default()).content.is_empty());
}

#[test]
fn the_scene_study_precedes_the_method_studies() {
    let mut study = json!({
        "schema": "modalign-order/1",
        "title": "wing",
        "tests": [{"name": "hammer", "inputs": speed()["tests"][0]["inputs"]}],
        "answers": ["hammer: 2 roots < 3."],
        "tables": [],
    });
    let tab = |order: &Value| {
        methods_tab(&CompanionResults {
            order: Some(order.clone()),
            speed_accuracy: Some(speed()),
            ..CompanionResults::default()
        })
    };
    let content = tab(&study).content;
    let needs = content
        .find("hammer: 2 roots &lt; 3.")
        .expect("answer of the scene study");
    assert!(needs < content.find("data-draw=\"speed\"").expect("a chart"));
    study["title"] = json!("another");
    let content = tab(&study).content;
    assert!(content.contains("order.json is of another scene") && !content.contains("2 roots"));
}
