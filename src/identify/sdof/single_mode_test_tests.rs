//! Tests of the single-mode tests: two modes under one peak are resolved or reported as close
//! modes.

use crate::finding::{Code, Location};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Measurement, Pair, close_pair, width_hz};
use crate::identify::tests::seeds;
use crate::modal::ModalModel;

/// Whether a finding reports the pair near 200 Hz as close modes.
fn is_reported_close(model: &ModalModel, reach_hz: f64) -> bool {
    model.findings.iter().any(|finding| {
        let near = matches!(finding.location, Location::Mode(hz) if (hz - 200.0).abs() < reach_hz);
        finding.code == Code::CloseModes && near
    })
}

/// Whether both modes were found within a quarter of the half-power width, and nothing else near.
fn is_resolved(model: &ModalModel, truth: &[(f64, f64, Vec<f64>)]) -> bool {
    let width = width_hz(&truth[0]);
    let near = model
        .modes
        .iter()
        .filter(|m| (m.frequency_hz - 200.0).abs() < 4.0 * width);
    let found: Vec<f64> = near.map(|m| m.frequency_hz).collect();
    let hit =
        |(found, truth): (&f64, &(f64, f64, Vec<f64>))| (found - truth.0).abs() < 0.25 * width;
    found.len() == 2 && found.iter().zip(truth).all(hit)
}

fn assert_reported_or_resolved(
    lines_per_width: (f64, f64),
    decibels: &[Option<f64>],
    seeds: std::ops::Range<u64>,
) {
    let kinds = [
        (None, 1.0),
        (None, 0.5),
        (Some(0.2), 1.0),
        (Some(0.0), 1.0),
        (Some(0.0), 0.5),
    ];
    for (difference, ratio) in kinds {
        for spacing_widths in [0.3, 0.5, 1.0, 2.0] {
            let pair = Pair {
                spacing_widths,
                difference,
                ratio,
                lines_per_width,
            };
            for (seed, snr_db) in seeds
                .clone()
                .flat_map(|s| decibels.iter().map(move |db| (s, *db)))
            {
                let (structure, how) = close_pair(seed, pair);
                let set = structure.measured(&Measurement { snr_db, ..how });
                for method in ["peak", "circle"] {
                    let options = IdentifyOptions {
                        method: method.to_owned(),
                        ..IdentifyOptions::default()
                    };
                    let model = identify(&set, &options)
                        .unwrap_or_else(|e| panic!("{method} {seed} {snr_db:?} {pair:?} {e}"));
                    let reach = 4.0 * width_hz(&structure.modes[0]);
                    assert!(
                        is_reported_close(&model, reach) || is_resolved(&model, &structure.modes),
                        "{method} {seed} {snr_db:?} {pair:?}: {:?}",
                        model
                            .modes
                            .iter()
                            .map(|m| m.frequency_hz)
                            .collect::<Vec<_>>()
                    );
                }
            }
        }
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn close_pairs_of_any_shapes_are_reported_or_resolved() {
    assert_reported_or_resolved((6.0, 15.0), &[None, Some(60.0), Some(40.0)], seeds(4));
}

#[test]
fn close_pairs_with_few_lines_are_reported_or_resolved() {
    assert_reported_or_resolved((1.5, 4.0), &[Some(60.0), Some(40.0)], seeds(4));
}

#[test]
fn pair_four_or_more_bandwidths_apart_is_resolved_without_a_finding() {
    for spacing_widths in [4.0, 6.0] {
        for seed in 0..6 {
            let pair = Pair {
                spacing_widths,
                difference: None,
                ratio: 1.0,
                lines_per_width: (6.0, 15.0),
            };
            let (structure, how) = close_pair(seed, pair);
            let set = structure.measured(&Measurement {
                snr_db: Some(60.0),
                ..how
            });
            let model = identify(&set, &IdentifyOptions::default()).unwrap();
            let reach = 8.0 * width_hz(&structure.modes[0]);
            assert!(
                !is_reported_close(&model, reach),
                "{seed} {:?}",
                model.findings
            );
            for (mode, truth) in model.modes.iter().zip(&structure.modes) {
                let error = (mode.frequency_hz - truth.0) / width_hz(truth);
                assert!(error.abs() < 2e-3, "{seed} {spacing_widths} {error}");
                assert!((mode.damping_ratio.unwrap() / truth.1 - 1.0).abs() < 1e-2);
            }
        }
    }
}

#[test]
fn resolved_pair_nearer_than_three_bandwidths_is_reported_with_its_separation() {
    let pair = Pair {
        spacing_widths: 2.5,
        difference: None,
        ratio: 1.0,
        lines_per_width: (6.0, 15.0),
    };
    let (structure, how) = close_pair(1, pair);
    let options = IdentifyOptions {
        method: "circle".to_owned(),
        ..IdentifyOptions::default()
    };
    let model = identify(&structure.measured(&how), &options).unwrap();
    let close = model.findings.iter().filter(|f| f.code == Code::CloseModes);
    let distances: Vec<(f64, f64)> = close
        .map(|finding| (finding.value.unwrap(), finding.limit.unwrap()))
        .collect();
    assert_eq!(distances.len(), 2);
    assert!((distances[0].0 - 2.5).abs() < 0.01 && (distances[0].1 - 3.0).abs() < 1e-12);
    assert!(is_resolved(&model, &structure.modes));
}
