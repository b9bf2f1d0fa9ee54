//! Frequency and damping of modes whose eigenvalue or damping is written in another convention.

use std::f64::consts::TAU;
use std::path::Path;

use super::mode_builder::{
    DAMPING, FREQUENCIES_HZ, ModeDataset, Parameters, eigenvalue, mode_file, rows, three,
};
use super::universal_file::{OneFile, Ran, on_file};

fn along_z(mode: usize) -> Vec<(i64, Vec<num_complex::Complex64>)> {
    rows(mode, |_, axis| axis == 2)
}

fn inspected(modes: &[ModeDataset]) -> Ran {
    let file = OneFile::new("m.uff", mode_file(modes));
    on_file("inspect", &file.path(), &["--json"])
}

/// Frequencies and damping ratios of the modes.
fn poles(ran: &Ran) -> Vec<(f64, Option<f64>)> {
    let json = ran.json();
    let modes = json["files"][0]["modes"].as_array().unwrap();
    let pole = |mode: &serde_json::Value| {
        let frequency = mode["frequency_hz"].as_f64().unwrap();
        (frequency, mode["damping_ratio"].as_f64())
    };
    modes.iter().map(pole).collect()
}

fn has_finding(ran: &Ran, code: &str) -> bool {
    let json = ran.json();
    let findings = json["files"][0]["findings"].as_array().unwrap();
    let found = findings.iter().find(|finding| finding["code"] == code);
    found.is_some_and(|finding| finding["severity"] == "warning")
}

const CODES: [&str; 3] = ["decay-rate-sign", "negative-damping", "damping-in-percent"];

/// The frequencies and damping ratios of the modes, within six digits, and one finding of these.
fn has_the_poles(ran: &Ran, code: Option<&str>) {
    let poles = poles(ran);
    assert_eq!(poles.len(), 3, "{ran:?}");
    for (mode, (frequency, damping)) in poles.iter().enumerate() {
        assert!(
            (frequency / FREQUENCIES_HZ[mode] - 1.0).abs() < 2e-5,
            "{poles:?}"
        );
        let damping = damping.unwrap_or_else(|| panic!("{poles:?}"));
        assert!((damping / DAMPING[mode] - 1.0).abs() < 1e-4, "{poles:?}");
    }
    for other in CODES {
        assert_eq!(
            has_finding(ran, other),
            code == Some(other),
            "{other} {ran:?}"
        );
    }
}

/// A complex mode of dataset 55 with the real part of λ times this.
fn signed(mode: usize, sign: f64) -> ModeDataset {
    let mut dataset = ModeDataset::complex(mode, along_z(mode));
    if let Parameters::Dataset55(reals) = &mut dataset.parameters {
        reals[0] *= sign;
    }
    dataset
}

#[test]
fn a_decay_rate_in_place_of_the_real_part_is_turned() {
    has_the_poles(&inspected(&three(|mode| signed(mode, 1.0))), None);
    let all = three(|mode| signed(mode, -1.0));
    has_the_poles(&inspected(&all), Some("decay-rate-sign"));
    let file = OneFile::new("m.uff", mode_file(&all));
    let test = file.path();
    let ran = on_file(
        "correlate",
        Path::new("--test"),
        &[test.to_str().unwrap(), "--json"],
    );
    assert!(
        ran.error.contains("decay-rate-sign") && ran.code == Some(0),
        "{ran:?}"
    );
}

#[test]
fn a_decay_rate_of_dataset_2414_and_of_a_conjugate_is_turned() {
    let of_2414 = three(|mode| {
        let lambda = eigenvalue(mode);
        ModeDataset::complex(mode, along_z(mode))
            .with_2414([0.0; 6], [-lambda.re, lambda.im, 0.0, 0.0, 0.0, 0.0])
    });
    has_the_poles(&inspected(&of_2414), Some("decay-rate-sign"));
    let conjugate = three(|mode| {
        let mut dataset = signed(mode, -1.0);
        if let Parameters::Dataset55(reals) = &mut dataset.parameters {
            reals[1] *= -1.0;
        }
        dataset
    });
    has_the_poles(&inspected(&conjugate), Some("decay-rate-sign"));
}

#[test]
fn one_unstable_mode_among_stable_ones_is_kept_and_reported() {
    let ran = inspected(&three(|mode| {
        signed(mode, if mode == 1 { -1.0 } else { 1.0 })
    }));
    let poles = poles(&ran);
    assert!(
        poles[0].1 > Some(0.0) && poles[2].1 > Some(0.0),
        "{poles:?}"
    );
    assert!((poles[1].1.unwrap() + DAMPING[1]).abs() < 1e-6, "{poles:?}");
    assert!(has_finding(&ran, "negative-damping") && !has_finding(&ran, "decay-rate-sign"));
}

#[test]
fn a_damping_field_beside_the_eigenvalue_decides_the_sign() {
    // One mode of three is written as a decay rate, and its damping field is positive.
    let with_field = |field: f64| {
        three(|mode| {
            let lambda = eigenvalue(mode);
            let re = if mode == 1 { -lambda.re } else { lambda.re };
            let viscous = if mode == 1 { field } else { DAMPING[mode] };
            ModeDataset::complex(mode, along_z(mode)).with_2414(
                [0.0, FREQUENCIES_HZ[mode], 0.0, 0.0, viscous, 0.0],
                [re, lambda.im, 0.0, 0.0, 0.0, 0.0],
            )
        })
    };
    has_the_poles(&inspected(&with_field(DAMPING[1])), Some("decay-rate-sign"));
    has_the_poles(
        &inspected(&with_field(100.0 * DAMPING[1])),
        Some("decay-rate-sign"),
    );
    // Every mode has a positive real part, and the damping fields say that it is meant.
    let unstable = three(|mode| {
        let lambda = eigenvalue(mode);
        ModeDataset::complex(mode, along_z(mode)).with_2414(
            [0.0, FREQUENCIES_HZ[mode], 0.0, 0.0, -DAMPING[mode], 0.0],
            [-lambda.re, lambda.im, 0.0, 0.0, 0.0, 0.0],
        )
    });
    let ran = inspected(&unstable);
    assert!(poles(&ran).iter().all(|pole| pole.1 < Some(0.0)), "{ran:?}");
    assert!(has_finding(&ran, "negative-damping"), "{ran:?}");
}

/// Normal modes of dataset 55 with these viscous and hysteretic damping ratios.
fn damped(ratios: [(f64, f64); 3]) -> Vec<ModeDataset> {
    three(|mode| {
        let (viscous, hysteretic) = ratios[mode];
        ModeDataset {
            parameters: Parameters::Dataset55(vec![FREQUENCIES_HZ[mode], 0.0, viscous, hysteretic]),
            ..ModeDataset::normal(mode, along_z(mode))
        }
    })
}

#[test]
fn damping_in_percent_is_divided_by_a_hundred() {
    let percent = DAMPING.map(|ratio| 100.0 * ratio);
    let code = Some("damping-in-percent");
    has_the_poles(&inspected(&damped(DAMPING.map(|ratio| (ratio, 0.0)))), None);
    has_the_poles(&inspected(&damped(percent.map(|ratio| (ratio, 0.0)))), code);
    has_the_poles(
        &inspected(&damped(percent.map(|ratio| (0.0, 2.0 * ratio)))),
        code,
    );
    let of_2414 = three(|mode| {
        let (hz, viscous) = (FREQUENCIES_HZ[mode], percent[mode]);
        ModeDataset::normal(mode, along_z(mode))
            .with_2414([0.0, hz, 0.0, 0.0, viscous, 0.0], [0.0; 6])
    });
    has_the_poles(&inspected(&of_2414), code);
}

#[test]
fn damping_that_may_be_either_is_kept_and_reported() {
    let ran = inspected(&damped([(0.01, 0.0), (0.02, 0.0), (1.2, 0.0)]));
    assert_eq!(poles(&ran)[2].1, Some(1.2));
    assert!(has_finding(&ran, "damping-implausible"), "{ran:?}");
    let ran = inspected(&damped([(0.5, 0.0), (0.3, 0.0), (0.8, 0.0)]));
    assert_eq!(poles(&ran)[0].1, Some(0.5));
    assert!(has_finding(&ran, "damping-implausible"), "{ran:?}");
    // A soft mount beside the modes of a structure is plausible.
    let ran = inspected(&damped([(0.35, 0.0), (0.02, 0.0), (0.01, 0.0)]));
    assert!(!ran.out.contains("damping-i"), "{ran:?}");
}

/// Dataset 2414 with these records 12 and 13.
fn of_2414(analysis: i64, general: [f64; 6], eigenvalue: [f64; 6], mode: usize) -> ModeDataset {
    let dataset = match analysis {
        2 => ModeDataset::normal(mode, along_z(mode)),
        _ => ModeDataset::complex(mode, along_z(mode)),
    };
    dataset.with_2414(general, eigenvalue)
}

#[test]
fn a_frequency_of_zero_is_replaced_by_that_of_the_eigenvalue() {
    let squared = three(|mode| {
        let eigenvalue = (TAU * FREQUENCIES_HZ[mode]).powi(2);
        of_2414(
            2,
            [0.0, 0.0, eigenvalue, 1.0, DAMPING[mode], 0.0],
            [0.0; 6],
            mode,
        )
    });
    has_the_poles(&inspected(&squared), None);
    let of_lambda = three(|mode| {
        let lambda = eigenvalue(mode);
        of_2414(
            2,
            [0.0; 6],
            [lambda.re, lambda.im, 0.0, 0.0, 0.0, 0.0],
            mode,
        )
    });
    has_the_poles(&inspected(&of_lambda), None);
    let of_fields = three(|mode| {
        let (hz, zeta) = (FREQUENCIES_HZ[mode], DAMPING[mode]);
        of_2414(3, [0.0, hz, 0.0, 0.0, zeta, 0.0], [0.0; 6], mode)
    });
    has_the_poles(&inspected(&of_fields), None);
}

#[test]
fn a_mode_without_frequency_and_eigenvalue_is_damage() {
    for analysis in [2, 3] {
        let modes = three(|mode| of_2414(analysis, [0.0; 6], [0.0; 6], mode));
        let file = OneFile::new("m.uff", mode_file(&modes));
        let ran = on_file("inspect", &file.path(), &["--json"]);
        assert_eq!(ran.code, Some(1), "{ran:?}");
        let damage = ran.json()["files"][0]["damage"].to_string();
        assert!(
            damage.contains("m.uff:2:") && damage.contains("frequency"),
            "{damage}"
        );
        let file = file.path();
        let arguments = [file.to_str().unwrap()];
        let ran = on_file("correlate", Path::new("--test"), &arguments);
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(ran.error.contains("export"), "{ran:?}");
    }
    let zero = |mode| ModeDataset {
        parameters: Parameters::Dataset55(vec![0.0; 4]),
        ..ModeDataset::normal(mode, along_z(mode))
    };
    assert_eq!(inspected(&three(zero)).code, Some(1));
}

#[test]
fn rigid_body_modes_at_zero_hertz_beside_others_are_kept() {
    let free = three(|mode| {
        let hz = if mode == 0 { 0.0 } else { FREQUENCIES_HZ[mode] };
        let eigenvalue = (TAU * hz).powi(2) - if mode == 0 { 1e-5 } else { 0.0 };
        of_2414(2, [0.0, 0.0, eigenvalue, 1.0, 0.0, 0.0], [0.0; 6], mode)
    });
    let ran = inspected(&free);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(poles(&ran)[0], (0.0, None), "{ran:?}");
    assert!((poles(&ran)[1].0 - 55.0).abs() < 1e-3, "{ran:?}");
}
