//! Tests of the `lscf` method, and of the properties that all methods with model orders share.

use std::collections::BTreeSet;

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::finding::Code;
use crate::frf::FrfSet;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{IdentifyOptions, MethodOptions, PoleStatus};
use crate::identify::synthetic::{Measurement, Structure, separated_modes};
use crate::identify::tests::seeds;
use crate::identify::{ESTIMATORS, identification, identify};
use crate::modal::{ModalModel, Pole};

fn options(method: &str, max_order: Option<usize>) -> IdentifyOptions {
    IdentifyOptions {
        method: method.to_owned(),
        estimator: MethodOptions {
            max_order,
            ..MethodOptions::default()
        },
        ..IdentifyOptions::default()
    }
}

fn with_order() -> impl Iterator<Item = &'static str> {
    ESTIMATORS.iter().filter(|e| e.has_order).map(|e| e.name)
}

/// Distance of each true pole to the identified one of the same rank, over its magnitude; as many
/// modes as true ones.
fn errors(structure: &Structure, model: &ModalModel) -> Vec<f64> {
    assert_eq!(
        model.modes.len(),
        structure.modes.len(),
        "{:?}",
        model.findings
    );
    let pairs = structure.modes.iter().zip(&model.modes);
    let error = pairs.map(|((hz, zeta, _), mode)| {
        let truth = Pole::from_frequency(*hz, *zeta).lambda;
        (mode.pole().unwrap().lambda - truth).norm() / truth.norm()
    });
    error.collect()
}

/// Three sensors, two references, three modes of which two are close, noise of 60 dB.
fn of_two_references() -> (Structure, FrfSet) {
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.05,
        len: 4001,
    };
    let structure = Structure {
        modes: vec![
            (60.0, 0.01, vec![1.0, 0.5, -0.7]),
            (60.5, 0.01, vec![0.4, -0.9, 0.6]),
            (130.0, 0.01, vec![0.8, -0.9, 0.6]),
        ],
    };
    let mut how = Measurement {
        snr_db: Some(60.0),
        ..Measurement::of_sensors(3, axis)
    };
    let second = how.pairs.iter().map(|(r, _)| (r.clone(), dof("2:+Z")));
    how.pairs.extend(second.collect::<Vec<_>>());
    let set = structure.measured(&how);
    (structure, set)
}

fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

#[test]
fn poles_without_noise_are_exact_at_five_and_more_orders_per_mode() {
    for seed in 0..6 {
        let (structure, how) = separated_modes(seed);
        let set = structure.measured(&how);
        let count = structure.modes.len();
        for order in [None, Some(5 * count), Some(12 * count)] {
            let model = identify(&set, &options("lscf", order)).unwrap();
            let worst = errors(&structure, &model).into_iter().fold(0.0, f64::max);
            assert!(worst < 1e-6, "{seed} {order:?} {worst:e}");
        }
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn pole_errors_match_their_standard_deviations_and_stay_near_the_bound() {
    // The circle fit has 1 % of the damping and 1 % of the decay rate in frequency at 30 dB; a
    // method may have twice that.
    let mut squares = Vec::new();
    for (snr_db, limit) in [(60.0, 3e-3), (40.0, 6e-3), (30.0, 2e-2)] {
        for seed in seeds(16) {
            let (structure, how) = separated_modes(seed);
            let set = structure.measured(&Measurement {
                snr_db: Some(snr_db),
                ..how
            });
            let model = identify(&set, &options("lscf", None)).unwrap();
            let worst = errors(&structure, &model);
            for ((error, (hz, zeta, _)), mode) in
                worst.iter().zip(&structure.modes).zip(&model.modes)
            {
                assert!(*error < limit * zeta, "{snr_db} {seed} {error:e}");
                let off = (mode.frequency_hz - hz) / mode.frequency_std_hz.unwrap();
                squares.push(off * off);
            }
        }
    }
    // 0.455 is the median of a squared normal deviate. A quarter of the draws has some 54 values:
    // the median of their magnitudes has a standard deviation of 0.11 about 0.674, of which three
    // are allowed.
    squares.sort_by(f64::total_cmp);
    let median = squares[squares.len() / 2];
    assert!((0.12..1.01).contains(&median), "{median}");
}

#[test]
fn two_references_separate_close_modes() {
    let (structure, set) = of_two_references();
    for method in with_order() {
        let result = identification(&set, &options(method, None)).unwrap();
        let worst = errors(&structure, &result.model);
        assert!(worst.iter().all(|e| *e < 2e-5), "{method} {worst:?}");
        for ((_, _, shape), mode) in structure.modes.iter().zip(&result.model.modes) {
            let sign = (mode.shape.get(&dof("1:+Z")).unwrap().re * shape[0]).signum();
            for (point, truth) in (1..).zip(shape) {
                let value = sign * mode.shape.get(&dof(&format!("{point}:+Z"))).unwrap().re;
                assert!(
                    (value - truth).abs() < 2e-3,
                    "{method} {point} {value} {truth}"
                );
            }
        }
    }
}

#[test]
fn orders_stay_below_the_stated_one_and_each_mode_has_its_selected_pole() {
    let (structure, how) = separated_modes(2);
    let set = structure.measured(&Measurement {
        snr_db: Some(50.0),
        ..how
    });
    for method in with_order() {
        let result = identification(&set, &options(method, Some(18))).unwrap();
        let poles = &result.stabilization;
        assert!(poles.iter().all(|point| point.order <= 18), "{method}");
        assert_eq!(result.model.modes.len(), structure.modes.len(), "{method}");
        for mode in &result.model.modes {
            // Maximum likelihood moves its modes away from the poles that they were made of.
            let decay_hz = mode.frequency_hz * mode.damping_ratio.unwrap();
            let near = if method == "ml" { 0.5 * decay_hz } else { 1e-9 };
            let selected = poles.iter().filter(|point| {
                point.status == PoleStatus::Selected
                    && Some(point.order) == mode.order
                    && (point.pole.natural_frequency_hz() - mode.frequency_hz).abs() < near
            });
            assert_eq!(selected.count(), 1, "{method} {:?}", mode.frequency_hz);
        }
        let chosen = poles.iter().filter(|p| p.status == PoleStatus::Selected);
        assert_eq!(chosen.count(), result.model.modes.len(), "{method}");
        assert!(poles.iter().any(|p| p.status == PoleStatus::Stable));
    }
}

#[test]
fn order_for_a_method_without_orders_is_an_error() {
    let (structure, how) = separated_modes(2);
    let set = structure.measured(&how);
    let error = identify(&set, &options("circle", Some(20))).unwrap_err();
    assert!(matches!(error, IdentifyError::NoOrder { .. }));
    assert!(error.to_string().contains("lscf ml"), "{error}");
}

#[test]
fn orders_out_of_range_are_errors_and_order_four_has_poles_of_three_orders() {
    let (structure, how) = separated_modes(2);
    let set = structure.measured(&how);
    for method in with_order() {
        for order in (0..4).chain([501, 1_000_000_000]) {
            let error = identify(&set, &options(method, Some(order))).unwrap_err();
            let text = error.to_string();
            let names_order =
                text.contains(&format!("order = {order}")) && text.contains("4 to 500");
            assert!(names_order && text.contains("three orders"), "{text}");
        }
        let result = identification(&set, &options(method, Some(4))).unwrap();
        let orders: BTreeSet<usize> = result.stabilization.iter().map(|p| p.order).collect();
        assert!(orders.len() >= 3, "{method} {orders:?}");
    }
}

#[test]
fn pure_noise_gives_no_mode() {
    let (structure, mut how) = separated_modes(1);
    how.axis.len = how.axis.len.min(3000);
    let silent = Structure {
        modes: vec![(1e6, 0.5, structure.modes[0].2.clone())],
    };
    for seed in 0..4 {
        let set = silent.measured(&Measurement {
            snr_db: Some(-60.0),
            seed,
            ..how.clone()
        });
        for method in with_order() {
            let model = identify(&set, &options(method, None)).unwrap();
            assert!(model.modes.is_empty(), "{method} {:?}", model.modes);
        }
    }
}

#[test]
fn peak_without_a_mode_is_reported_where_the_order_is_too_low() {
    // Four poles cannot be five modes.
    let (structure, how) = separated_modes(2);
    let set = structure.measured(&Measurement {
        snr_db: Some(60.0),
        ..how
    });
    let model = identify(&set, &options("lscf", Some(4))).unwrap();
    let peak_findings = model
        .findings
        .iter()
        .filter(|f| f.code == Code::PeakWithoutMode);
    assert!(peak_findings.count() + model.modes.len() >= structure.modes.len());
    assert!(model.modes.len() < structure.modes.len());
}

#[test]
fn poles_are_estimated_per_frf_where_those_of_all_references_leave_a_residual() {
    let (_, set) = of_two_references();
    let one_reference = IdentifyOptions {
        references: Some(vec![dof("1:+Z")]),
        ..options("ml", None)
    };
    let orders = |result: &crate::identify::Identification| -> Vec<usize> {
        result.stabilization.iter().map(|p| p.order).collect()
    };
    let falls = |orders: &[usize]| {
        let falls = orders.windows(2).filter(|pair| pair[1] < pair[0]);
        falls.map(|pair| pair[0]).collect::<Vec<_>>()
    };
    // The polynomials of two inputs have half the order for as many poles, and explain these data.
    let result = identification(&set, &options("ml", None)).unwrap();
    let single = identification(&set, &one_reference).unwrap();
    let top = orders(&single).into_iter().max().unwrap();
    assert_eq!(orders(&result).into_iter().max(), Some(top / 2));
    assert!(falls(&orders(&result)).is_empty());
    for mode in &result.model.modes {
        let chosen = result.stabilization.iter().filter(|point| {
            point.status == PoleStatus::Selected && Some(point.order) == mode.order
        });
        assert!(chosen.count() > 0, "{}", mode.frequency_hz);
    }
    // Orders that are too low for these modes: their poles come first, then those of one input.
    let few = identification(&set, &options("ml", Some(4))).unwrap();
    assert_eq!(falls(&orders(&few)), [4]);
}

#[test]
fn windows_with_as_many_peaks_as_the_order_have_poles_of_three_orders() {
    // Six half-power widths apart: each window of rational fraction polynomials holds all four
    // peaks.
    let shapes = [
        [1.0, 0.5, -0.7],
        [0.8, -0.9, 0.6],
        [0.5, 0.9, 0.4],
        [-0.7, 0.6, 0.8],
    ];
    let mode = |(j, shape): (usize, &[f64; 3])| (100.0 + 6.0 * j as f64, 0.005, shape.to_vec());
    let structure = Structure {
        modes: shapes.iter().enumerate().map(mode).collect(),
    };
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.1,
        len: 2001,
    };
    let set = structure.measured(&Measurement {
        snr_db: Some(60.0),
        ..Measurement::of_sensors(3, axis)
    });
    let result = identification(&set, &options("rfp", Some(4))).unwrap();
    let orders: BTreeSet<usize> = result.stabilization.iter().map(|p| p.order).collect();
    assert_eq!(orders.into_iter().collect::<Vec<_>>(), [2, 3, 4]);
}
