//! Tests of all multi-mode methods: poles without and with noise, standard deviations, and bands
//! that do not begin at 0 Hz.

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::identify::estimator::IdentifyOptions;
use crate::identify::synthetic::{Measurement, Pair, Structure, close_pair, separated_modes};
use crate::identify::tests::seeds;
use crate::identify::{ESTIMATORS, identify};
use crate::modal::{ModalModel, Mode, Pole};

/// Natural frequency in Hz, damping ratio and shape of a true mode.
type Truth = (f64, f64, Vec<f64>);

fn with_band(method: &str, band: Option<Band>) -> IdentifyOptions {
    IdentifyOptions {
        method: method.to_owned(),
        band,
        ..IdentifyOptions::default()
    }
}

/// Distance of the pole of a mode to the true one, over its magnitude.
fn error(truth: &Truth, mode: &Mode) -> f64 {
    let lambda = Pole::from_frequency(truth.0, truth.1).lambda;
    (mode.pole().unwrap().lambda - lambda).norm() / lambda.norm()
}

/// Each true mode with the identified one of the same rank; as many modes as true ones.
fn pairs<'a>(structure: &'a Structure, model: &'a ModalModel) -> Vec<(&'a Truth, &'a Mode)> {
    let found: Vec<_> = model
        .modes
        .iter()
        .map(|m| (m.frequency_hz, m.damping_ratio, m.frequency_std_hz))
        .collect();
    assert_eq!(
        found.len(),
        structure.modes.len(),
        "{:?} {found:?}",
        structure.modes
    );
    structure.modes.iter().zip(&model.modes).collect()
}

#[test]
fn poles_without_noise_are_exact_within_the_limit_of_the_method() {
    // In the s domain the limit is 1e-8. Impulse responses contain the ringing of the band edges:
    // 1e-5, and no more than the stated standard deviation allows.
    for (method, limit) in [("rfp", 1e-8), ("line", 1e-8), ("ml", 1e-8), ("lsce", 1e-5)] {
        for seed in seeds(6) {
            let (structure, how) = separated_modes(seed);
            let set = structure.measured(&how);
            let model = identify(&set, &with_band(method, None)).unwrap();
            for (truth, mode) in pairs(&structure, &model) {
                let error = error(truth, mode);
                assert!(error < limit, "{method} {seed} {error:e}");
                if method == "lsce" {
                    let std = mode.frequency_std_hz.unwrap() / mode.frequency_hz;
                    assert!(error < 5.0 * std, "{seed} {error:e} {std:e}");
                }
            }
        }
    }
}

#[test]
fn pole_errors_by_noise_are_small_and_match_their_standard_deviations() {
    let mut squares = Vec::new();
    for snr_db in [60.0, 40.0] {
        for (method, limit) in [("line", 3e-3), ("rfp", 5e-3), ("lsce", 3e-2)] {
            for seed in seeds(8) {
                let (structure, how) = separated_modes(seed);
                let set = structure.measured(&Measurement {
                    snr_db: Some(snr_db),
                    ..how
                });
                let model = identify(&set, &with_band(method, None)).unwrap();
                for (truth, mode) in pairs(&structure, &model) {
                    let error = error(truth, mode);
                    assert!(
                        error < limit * truth.1,
                        "{method} {snr_db} {seed} {error:e}"
                    );
                    let off = (mode.frequency_hz - truth.0) / mode.frequency_std_hz.unwrap();
                    squares.push(off * off);
                }
            }
        }
    }
    // 0.455 is the median of a squared normal deviate. A quarter of the draws has some 50 values:
    // the median of their magnitudes has a standard deviation of 0.11 about 0.674, of which three
    // are allowed.
    squares.sort_by(f64::total_cmp);
    let median = squares[squares.len() / 2];
    assert!((0.12..1.01).contains(&median), "{median}");
}

#[test]
fn band_that_begins_above_zero_does_not_shift_frequencies() {
    // Scaling lines by their number instead of their frequency would cause an error of 8 %; adding
    // the shift to a natural frequency 2 %.
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.25,
        len: 2401,
    };
    let structure = Structure {
        modes: vec![
            (100.0, 0.05, vec![1.0, 0.5, -0.7]),
            (250.0, 0.02, vec![0.8, -0.9, 0.6]),
            (400.0, 0.02, vec![-0.5, 0.4, 0.9]),
        ],
    };
    let set = structure.measured(&Measurement::of_sensors(3, axis));
    for method in ["rfp", "lsce", "lscf", "ml"] {
        for lo in [1.0, 40.0, 80.0, 90.0, 95.0] {
            let band = Band::new(lo, 500.0).ok();
            let model = identify(&set, &with_band(method, band)).unwrap();
            for (truth, mode) in pairs(&structure, &model) {
                // Close to the edge the lines hold half of a resonance.
                let limit = if mode.frequency_hz < 1.2 * lo {
                    2e-3
                } else {
                    2e-4
                };
                let off = (mode.frequency_hz / truth.0 - 1.0).abs();
                assert!(off < limit, "{method} {lo} {} {off:e}", truth.0);
            }
        }
    }
}

#[test]
fn no_method_fails_on_a_band_of_few_lines() {
    // Eight lines are the minimum; the band is the whole axis, so that there are no guard lines.
    // The impulse responses of fewer than 65 lines are too short for lsce, which then has no poles.
    for lines in [8, 12, 24, 64, 65] {
        let axis = FrequencyAxis {
            start_hz: 55.0,
            step_hz: 10.0 / lines as f64,
            len: lines,
        };
        let structure = Structure {
            modes: vec![(60.0, 0.02, vec![1.0, 0.5, -0.7])],
        };
        let mut how = Measurement {
            snr_db: Some(60.0),
            ..Measurement::of_sensors(3, axis)
        };
        for references in 1..=2 {
            if references == 2 {
                let second = how.pairs.iter().map(|(r, _)| r.clone());
                let dof: crate::dof::Dof = "2:+Z".parse().unwrap();
                let second: Vec<_> = second.map(|r| (r, dof.clone())).collect();
                how.pairs.extend(second);
            }
            let set = structure.measured(&how);
            for name in ESTIMATORS.iter().map(|entry| entry.name) {
                let model = identify(&set, &with_band(name, None)).unwrap();
                assert!(model.modes.len() < 2, "{name} {lines} {references}");
                let short = name == "lsce" && lines < 65;
                assert!(!short || model.modes.is_empty(), "{lines}");
            }
        }
    }
}

/// Sum of the squared errors of shape components over their standard deviations, without a common
/// factor, and its expected value.
fn shape_errors(structure: &Structure, model: &ModalModel) -> (f64, f64) {
    let (mut sum, mut numbers) = (0.0, 0.0);
    for ((_, _, shape), mode) in pairs(structure, model) {
        let stds = mode.shape_std.as_ref().unwrap();
        let value = |dof: &Dof| shape[dof.node().unwrap() as usize - 1];
        let (mut product, mut square) = (Complex64::ZERO, 0.0);
        for (dof, found) in mode.shape.iter() {
            let weight = stds[dof].powi(-2);
            product += weight * value(dof) * found;
            square += weight * value(dof).powi(2);
        }
        let factor = product / square;
        for (dof, found) in mode.shape.iter() {
            let error = found - factor * value(dof);
            sum += error.norm_sqr() / (2.0 * stds[dof].powi(2));
        }
        numbers += (mode.shape.len() - 1) as f64;
    }
    (sum, numbers)
}

fn assert_shape_errors(tests: impl Iterator<Item = (Structure, Measurement)>) {
    let (mut sum, mut numbers) = (0.0, 0.0);
    for (structure, how) in tests {
        let snr_db = Some(40.0);
        let set = structure.measured(&Measurement { snr_db, ..how });
        let model = identify(&set, &with_band("ml", None)).unwrap();
        let errors = shape_errors(&structure, &model);
        (sum, numbers) = (sum + errors.0, numbers + errors.1);
    }
    let ratio: f64 = sum / numbers;
    let spread = 4.0 / numbers.sqrt();
    assert!((ratio - 1.0).abs() < spread, "{ratio} of {numbers}");
}

#[test]
fn shape_standard_deviations_match_the_errors() {
    assert_shape_errors(seeds(20).map(separated_modes));
}

/// Two modes are separated by little more than the sum of their bandwidths and excited at two
/// points; the noise differs between sensors.
#[test]
fn shape_standard_deviations_include_errors_of_poles_and_participation() {
    let pair = Pair {
        spacing_widths: 2.2,
        difference: None,
        ratio: 1.0,
        lines_per_width: (5.5, 12.0),
    };
    assert_shape_errors(seeds(40).map(|seed| {
        let (structure, mut how) = close_pair(seed, pair);
        let second: Dof = "2:+Z".parse().unwrap();
        let again: Vec<(Dof, Dof)> = how
            .pairs
            .iter()
            .map(|pair| (pair.0.clone(), second.clone()))
            .collect();
        how.pairs.extend(again);
        (structure, how)
    }));
}
