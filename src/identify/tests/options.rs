//! Tests of options, errors and the findings of one mode.

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::finding::{Code, Finding};
use crate::frf::{FrfSet, Function, FunctionData};
use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{IdentifyOptions, MethodOptions};
use crate::identify::synthetic::{Measurement, Structure};
use crate::identify::{ESTIMATORS, identify};
use crate::modal::{ModalModel, PoleSelection, SelectedPole};
use crate::quantity::FrfKind;

const AXIS: FrequencyAxis = FrequencyAxis {
    start_hz: 0.0,
    step_hz: 0.1,
    len: 2001,
};

fn structure(damping: f64) -> Structure {
    Structure {
        modes: vec![
            (60.0, damping, vec![1.0, 0.5, -0.7]),
            (130.0, damping, vec![0.8, -0.9, 0.6]),
        ],
    }
}

fn set(damping: f64) -> FrfSet {
    structure(damping).measured(&Measurement {
        snr_db: Some(60.0),
        ..Measurement::of_sensors(3, AXIS)
    })
}

fn with_band(lo_hz: f64, hi_hz: f64) -> IdentifyOptions {
    IdentifyOptions {
        band: Some(Band { lo_hz, hi_hz }),
        ..IdentifyOptions::default()
    }
}

fn has(model: &ModalModel, code: Code) -> bool {
    model.findings.iter().any(|finding| finding.code == code)
}

#[test]
fn every_estimator_runs_by_its_name_and_finds_both_modes() {
    assert_eq!(ESTIMATORS.len(), 7);
    for name in ESTIMATORS.iter().map(|entry| entry.name).chain(["auto"]) {
        let options = IdentifyOptions {
            method: name.to_owned(),
            ..IdentifyOptions::default()
        };
        let model = identify(&set(0.01), &options).expect("a sound set and legal options");
        let method = model.modes[0].method.as_deref();
        assert_eq!(method, Some(if name == "auto" { "ml" } else { name }));
        assert_eq!((model.modes.len(), model.references.len()), (2, 1));
        assert_eq!(model.band, Band::new(0.1, 200.0).ok());
        assert!(model.added_damping_rad_s.is_none());
        // At 60 dB the errors of these two exceed the noise, which a finding reports.
        let inexact = ["lsce", "lscf"].contains(&name);
        let is_unexpected = |f: &Finding| !(inexact && f.code == Code::ModelMisfit);
        let unexpected: Vec<&Finding> =
            model.findings.iter().filter(|f| is_unexpected(f)).collect();
        assert!(unexpected.is_empty(), "{name} {unexpected:?}");
        assert!(
            model
                .modes
                .iter()
                .all(|mode| mode.mpc.expect("three components have an MPC") > 0.9999)
        );
    }
}

#[test]
fn error_of_an_unknown_method_lists_the_methods() {
    let options = IdentifyOptions {
        method: "prony".to_owned(),
        ..IdentifyOptions::default()
    };
    let text = identify(&set(0.01), &options).unwrap_err().to_string();
    assert!(
        text.contains("`prony`") && text.ends_with("auto peak circle line rfp lsce lscf ml"),
        "{text}"
    );
}

#[test]
fn bands_and_numbers_outside_their_range_are_errors() {
    let set = set(0.01);
    for (lo, hi) in [
        (300.0, 400.0),
        (f64::NAN, 100.0),
        (50.0, 40.0),
        (-5.0, 100.0),
        (-5.0, 250.0),
        (f64::NAN, 250.0),
        (10.0, f64::INFINITY),
    ] {
        let error = identify(&set, &with_band(lo, hi)).unwrap_err();
        assert!(
            matches!(error, IdentifyError::BandOutside { .. }),
            "{error}"
        );
    }
    for (hi, cut) in [(200.04, false), (250.0, true)] {
        let model = identify(&set, &with_band(10.0, hi)).expect("a sound set and legal options");
        assert_eq!((model.modes.len(), has(&model, Code::BandCut)), (2, cut));
        let mut findings = model.findings.iter();
        if let Some(cut_finding) = findings.find(|finding| finding.code == Code::BandCut) {
            assert_eq!(
                (cut_finding.value, cut_finding.limit),
                (Some(hi), Some(200.0))
            );
        }
        let used_band = model.band.expect("the band was stated");
        let expected = if cut { 200.0 } else { hi };
        assert!((used_band.hi_hz - expected).abs() < 1e-9 && (used_band.lo_hz - 10.0).abs() < 1e-9);
    }
    let error = identify(&set, &with_band(60.0, 60.3)).unwrap_err();
    assert_eq!(
        error,
        IdentifyError::TooFewLines {
            got: 4,
            expected: 8
        }
    );
    for estimator in [
        MethodOptions {
            false_alarm_probability: 0.0,
            ..MethodOptions::default()
        },
        MethodOptions {
            max_modes: Some(0),
            ..MethodOptions::default()
        },
    ] {
        let options = IdentifyOptions {
            estimator,
            ..IdentifyOptions::default()
        };
        let error = identify(&set, &options).unwrap_err();
        assert!(
            matches!(error, IdentifyError::OptionOutOfRange { .. }),
            "{error}"
        );
    }
}

#[test]
fn bad_sets_are_errors() {
    let empty = FrfSet::new(AXIS);
    let options = IdentifyOptions::default();
    assert_eq!(identify(&empty, &options), Err(IdentifyError::NoFunctions));
    let dof: Dof = "1:+Z".parse().expect("a point and its direction");
    let function = Function {
        response: dof.clone(),
        reference: dof,
        kind: FrfKind::Mobility,
        averages: None,
        estimator: None,
        variance_dof: None,
    };
    let mut values = set(0.01).values(0).to_vec();
    // More lines side by side than are filled in.
    values[700..704].fill(Complex64::new(0.0, f64::NAN));
    let mut broken = FrfSet::new(AXIS);
    let data = FunctionData {
        values,
        ..FunctionData::default()
    };
    broken
        .push(function, data)
        .expect("one value for each line");
    let text = identify(&broken, &options).unwrap_err().to_string();
    assert!(
        text.starts_with("1:+Z|1:+Z at 70 Hz") && text.contains("NaN"),
        "{text}"
    );
}

/// Values of functions i at lines k changed, without variances.
fn changed(set: &FrfSet, change: impl Fn(usize, usize, Complex64) -> Complex64) -> FrfSet {
    let mut result = FrfSet::new(*set.axis());
    for i in 0..set.len() {
        let values = set.values(i).iter().enumerate();
        let data = FunctionData {
            values: values.map(|(k, v)| change(i, k, *v)).collect(),
            ..FunctionData::default()
        };
        result
            .push(set.functions()[i].clone(), data)
            .expect("one value for each line");
    }
    result
}

#[test]
fn lines_without_any_response_have_no_poles_and_hide_none() {
    // As after a high-pass filter: more than the lower quarter of the lines, which has a separate
    // estimate.
    let measured = set(0.01);
    let whole = Band::new(0.1, 200.0).expect("a band");
    let lines = |set: &FrfSet| {
        let data = BandFrfs::new(set, whole).expect("a sound set");
        data.lines()
    };
    let both_ends = changed(&measured, |_, k, v| {
        if (510..1990).contains(&k) { v } else { 0.0 * v }
    });
    assert_eq!(lines(&both_ends), 1480);
    let blank = |lines: usize| changed(&measured, |_, k, v| if k < lines { 0.0 * v } else { v });
    for method in ESTIMATORS.iter().map(|entry| entry.name) {
        let options = IdentifyOptions {
            method: method.to_owned(),
            ..IdentifyOptions::default()
        };
        let model = identify(&blank(510), &options).expect("blank lines are no error");
        assert_eq!(model.modes.len(), 2, "{method}");
        assert!(
            (model.modes[0].frequency_hz - 60.0).abs() < 0.05,
            "{method}"
        );
        let nothing = identify(&blank(AXIS.len), &options).expect("blank lines are no error");
        assert!(nothing.modes.is_empty(), "{method}");
    }
}

#[test]
fn value_whose_square_is_not_finite_is_an_error_or_left_out_with_a_finding() {
    let measured = set(0.01);
    let huge = changed(&measured, |i, k, v| match (i, k) {
        (2, 700) => Complex64::from(f64::MAX),
        _ => v,
    });
    let text = identify(&huge, &IdentifyOptions::default()).unwrap_err();
    let text = text.to_string();
    assert!(
        text.starts_with("3:+Z|1:+Z at 70 Hz: got 1.797") && text.ends_with("square of the value"),
        "{text}"
    );
    // With a selection of poles the result keeps the finding.
    let selection = PoleSelection {
        poles: vec![SelectedPole {
            frequency_hz: 60.0,
            damping_ratio: None,
            order: None,
        }],
        tolerance_hz: None,
    };
    for (selection, modes) in [(None, 2), (Some(selection), 1)] {
        let options = IdentifyOptions {
            partial: true,
            selection,
            ..IdentifyOptions::default()
        };
        let model = identify(&huge, &options).expect("the other functions are sound");
        assert_eq!(model.modes.len(), modes);
        assert!(has(&model, Code::ValueNotFinite), "{modes}");
    }
}

#[test]
fn mains_hum_far_above_the_modes_hides_none_of_them() {
    let clean = changed(&set(0.01), |_, _, v| v);
    let hum = |k: usize| if [280, 300].contains(&k) { 40.0 } else { 0.0 };
    let highest = |set: &FrfSet| {
        let values = (0..set.len()).flat_map(|i| set.values(i).to_vec());
        values.map(|value| value.norm()).fold(0.0, f64::max)
    };
    let peak = highest(&clean);
    let with = changed(&clean, |i, k, v| {
        v + hum(k) * peak * Complex64::cis(i as f64)
    });
    let model = identify(&with, &IdentifyOptions::default()).expect("a sound set");
    let expected = identify(&clean, &IdentifyOptions::default()).expect("a sound set");
    assert_eq!(model.modes.len(), expected.modes.len());
    for (mode, other) in model.modes.iter().zip(&expected.modes) {
        let error_hz = mode.frequency_hz - other.frequency_hz;
        assert!(error_hz.abs() < 1e-3, "{error_hz}");
    }
    let replaced = model.findings.iter();
    let replaced = replaced.filter(|finding| finding.code == Code::SpikeReplaced);
    let replaced: Vec<_> = replaced.filter_map(|finding| finding.value).collect();
    assert_eq!(replaced, [280, 300].map(|k| with.axis().hz(k)));
    assert!(!has(&expected, Code::SpikeReplaced));
}

#[test]
fn missing_lines_at_the_ends_are_left_out_with_a_finding() {
    let clean = set(0.01);
    let last = clean.axis().len - 3;
    let with = changed(&clean, |_, k, v| if k >= last { v * f64::NAN } else { v });
    let model = identify(&with, &IdentifyOptions::default()).expect("the rest is sound");
    assert_eq!(model.modes.len(), 2);
    let cut = model
        .findings
        .iter()
        .find(|finding| finding.code == Code::BandCut);
    let cut = cut.map(|finding| (finding.value, finding.limit));
    let hz = |k: usize| Some(clean.axis().hz(k));
    assert_eq!(cut, Some((hz(last + 2), hz(last - 1))));
    let with = changed(
        &clean,
        |i, k, v| if k >= last && i > 0 { v * f64::NAN } else { v },
    );
    identify(&with, &IdentifyOptions::default()).expect_err("one function has numbers there");
}

#[test]
fn channel_without_signal_hides_no_mode() {
    let live = set(0.01);
    let with_dead = changed(&live, |i, _, v| if i == 1 { 0.0 * v } else { v });
    for method in ESTIMATORS.iter().map(|entry| entry.name) {
        let options = IdentifyOptions {
            method: method.to_owned(),
            ..IdentifyOptions::default()
        };
        let model = identify(&with_dead, &options).expect("a sound set and legal options");
        assert_eq!(model.modes.len(), 2, "{method}");
        assert!((model.modes[0].frequency_hz - 60.0).abs() < 1e-3);
        let dead = model.modes[0]
            .shape
            .get(&live.functions()[1].response)
            .unwrap();
        assert!(dead.norm() < 1e-12);
    }
}

#[test]
fn stated_references_select_frfs_and_must_exist() {
    let mut how = Measurement::of_sensors(3, AXIS);
    let second = how.pairs.iter().map(|(r, _)| {
        (
            r.clone(),
            "2:+Z".parse().expect("a point and its direction"),
        )
    });
    how.pairs.extend(second.collect::<Vec<_>>());
    let set = structure(0.01).measured(&how);
    let chosen: Vec<Dof> = vec!["2:+Z".parse().expect("a point and its direction")];
    let options = |references| IdentifyOptions {
        references: Some(references),
        ..IdentifyOptions::default()
    };
    let model = identify(&set, &options(chosen.clone())).unwrap();
    assert_eq!(model.references, chosen);
    assert_eq!(model.modes[0].residues.len(), 3);
    let unknown = identify(
        &set,
        &options(vec!["9:+X".parse().expect("a point and its direction")]),
    )
    .unwrap_err();
    assert!(unknown.to_string().ends_with("1:+Z 2:+Z"), "{unknown}");
}

#[test]
fn the_strongest_modes_are_kept() {
    let estimator = MethodOptions {
        max_modes: Some(1),
        ..MethodOptions::default()
    };
    let options = IdentifyOptions {
        estimator,
        ..IdentifyOptions::default()
    };
    let model = identify(&set(0.01), &options).expect("a sound set and legal options");
    assert_eq!(model.modes.len(), 1);
}

#[test]
fn short_record_is_reported() {
    // Time constants: 2π f ζ T = 2π · 60 · 0.01 · T = 3.77 T, and 8.17 T for the second mode.
    let mut set = set(0.01);
    for (duration, expected) in [(0.7, 2), (1.0, 1), (1.7, 0)] {
        set.record_duration_s = Some(duration);
        let model =
            identify(&set, &IdentifyOptions::default()).expect("a sound set and legal options");
        let short_records = model
            .findings
            .iter()
            .filter(|f| f.code == Code::FewTimeConstants);
        assert_eq!(short_records.count(), expected, "{duration}");
    }
}

#[test]
fn mode_near_an_edge_of_the_band_is_reported() {
    let set = set(0.01);
    // Half-power width 1.2 Hz.
    for (lo, near) in [(58.0, false), (59.0, true), (59.7, true)] {
        for method in ["peak", "circle"] {
            let options = IdentifyOptions {
                method: method.to_owned(),
                ..with_band(lo, 100.0)
            };
            let model = identify(&set, &options).expect("a sound set and legal options");
            assert_eq!(
                has(&model, Code::NearBandEdge),
                near,
                "{method} {lo} {:?}",
                model.findings
            );
            let hidden = method == "peak" && lo > 59.5;
            assert_eq!(has(&model, Code::HalfPowerMissing), hidden, "{method} {lo}");
            assert!((model.modes[0].frequency_hz - 60.0).abs() < 0.06);
        }
    }
}

#[test]
fn negative_damping_is_rejected_with_a_finding() {
    let model =
        identify(&set(-0.01), &IdentifyOptions::default()).expect("a sound set and legal options");
    assert!(model.modes.is_empty() && has(&model, Code::PeakDropped));
}

#[test]
fn damping_below_that_of_the_window_is_undetermined() {
    let mut set = set(0.01);
    // The stated damping of the window exceeds that of the data.
    set.added_damping_rad_s = 6.0;
    let model = identify(&set, &IdentifyOptions::default()).expect("a sound set and legal options");
    assert_eq!(model.modes[0].damping_ratio, None);
    assert!(has(&model, Code::DampingNotPositive));
    assert!(model.modes[1].damping_ratio.is_some());
}

#[test]
fn hidden_second_mode_is_reported_by_the_damping_spread() {
    let spread = |second: f64| {
        let shape = vec![second, 0.8 * second, -second];
        let pair = Structure {
            modes: vec![(60.0, 0.01, vec![1.0, 0.5, -0.7]), (61.0, 0.01, shape)],
        };
        let set = pair.measured(&Measurement::of_sensors(3, AXIS));
        let options = IdentifyOptions {
            method: "circle".to_owned(),
            ..IdentifyOptions::default()
        };
        identify(&set, &options).expect("a sound set and legal options")
    };
    let model = spread(0.7);
    assert!(has(&model, Code::DampingSpread) && has(&model, Code::CloseModes));
    assert!(!has(&spread(0.0), Code::DampingSpread));
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let set = set(0.02);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            identify(&set, &IdentifyOptions::default()).expect("a sound set and legal options")
        })
    };
    assert_eq!(run(1), run(4));
}
