//! Tests of accuracy on random structures with modes ten half-power bandwidths apart: all modes are
//! found with small errors, and no spurious ones.

use crate::axis::Band;
use crate::finding::Code;
use crate::frf::FrfSet;
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Measurement, Structure, separated_modes, width_hz};
use crate::identify::tests::seeds;
use crate::modal::{ModalModel, Mode};
use crate::quantity::FrfKind;

/// Natural frequency in Hz, damping ratio and shape of a true mode.
type Truth = (f64, f64, Vec<f64>);
/// A true mode with the one found.
type Partners<'a> = (&'a Truth, &'a Mode);

fn identified(set: &FrfSet, method: &str, band: Option<Band>) -> ModalModel {
    let options = IdentifyOptions {
        method: method.to_owned(),
        band,
        ..IdentifyOptions::default()
    };
    identify(set, &options).unwrap()
}

/// Each true mode with the one found within its half-power bandwidth; as many modes as true ones,
/// and no finding of close modes.
fn partners<'a>(truth: &'a [Truth], model: &'a ModalModel) -> Vec<Partners<'a>> {
    assert_eq!(model.modes.len(), truth.len(), "{:?}", model.findings);
    let close = model.findings.iter().find(|f| f.code == Code::CloseModes);
    assert_eq!(close, None);
    let pairs: Vec<_> = truth.iter().zip(&model.modes).collect();
    for (truth, mode) in &pairs {
        assert!((mode.frequency_hz - truth.0).abs() < 0.5 * width_hz(truth));
    }
    pairs
}

fn worst(pairs: &[Partners]) -> (f64, f64) {
    let frequency = |(truth, mode): &Partners| (mode.frequency_hz / truth.0 - 1.0).abs();
    let damping = |(truth, mode): &Partners| (mode.damping_ratio.unwrap() / truth.1 - 1.0).abs();
    (
        pairs.iter().map(frequency).fold(0.0, f64::max),
        pairs.iter().map(damping).fold(0.0, f64::max),
    )
}

#[test]
fn frequency_and_damping_at_sixty_decibels_are_far_within_the_target() {
    // The target is 5e-4 in frequency for all and 3 % in damping for the circle fit.
    for (method, damping_limit) in [("peak", 5e-3), ("circle", 1e-3), ("line", 1e-3)] {
        let mut squares = Vec::new();
        for seed in seeds(24) {
            let (structure, how) = separated_modes(seed);
            let set = structure.measured(&Measurement {
                snr_db: Some(60.0),
                ..how
            });
            let model = identified(&set, method, None);
            let pairs = partners(&structure.modes, &model);
            let (frequency, damping) = worst(&pairs);
            assert!(
                frequency < 3e-5 && damping < damping_limit,
                "{method} {seed} {frequency:e} {damping:e}"
            );
            squares.extend(pairs.iter().filter_map(|(truth, mode)| {
                let std = mode.frequency_std_hz?;
                Some(((mode.frequency_hz - truth.0) / std).powi(2))
            }));
        }
        // The median of a squared normal deviate is 0.455; a scatter of 5 to 12 functions widens it
        // a little.
        squares.sort_by(f64::total_cmp);
        let median = squares[squares.len() / 2];
        assert!(
            squares.len() > 20 && (0.25..0.85).contains(&median),
            "{method} {median}"
        );
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn separated_modes_are_never_reported_close_and_noise_is_never_a_mode() {
    for (snr_db, variance_given) in [
        (None, true),
        (Some(80.0), true),
        (Some(40.0), false),
        (Some(30.0), true),
    ] {
        // With seed 296 a ripple of 1e-6 at the top of a peak was once detected as a second peak.
        let rippled = snr_db.is_none().then_some(296);
        for seed in seeds(4).map(|draw| 20 + draw).chain(rippled) {
            let (structure, how) = separated_modes(seed);
            let set = structure.measured(&Measurement {
                snr_db,
                variance_given,
                ..how
            });
            for method in ["peak", "circle", "line"] {
                let model = identified(&set, method, None);
                let (frequency, damping) = worst(&partners(&structure.modes, &model));
                assert!(
                    frequency < 5e-4 && damping < 0.06,
                    "{method} {seed} {frequency:e} {damping:e}"
                );
                if snr_db.is_none() {
                    assert!(
                        frequency < 1e-5 && damping < 3e-5,
                        "{method} {seed} {frequency:e} {damping:e}"
                    );
                }
            }
        }
    }
}

/// The band between the outer modes of a structure, two half-power widths or more clear of them.
fn inner_band(modes: &[(f64, f64, Vec<f64>)]) -> Band {
    let (first, second) = (&modes[0], &modes[1]);
    let (last, before) = (&modes[modes.len() - 1], &modes[modes.len() - 2]);
    let lo = (second.0 - 9.0 * width_hz(second)).max(first.0 + 2.0 * width_hz(first));
    let hi = (last.0 - 2.0 * width_hz(last)).max(before.0 + 5.0 * width_hz(before));
    Band::new(lo, hi).unwrap()
}

#[test]
fn modes_outside_the_band_bias_the_result_little_and_cause_no_finding() {
    for (snr_db, method, limits) in [
        (None, "peak", (1e-4, 1e-2)),
        (None, "circle", (1e-5, 1.5e-2)),
        (Some(60.0), "peak", (1e-4, 1e-2)),
        (Some(60.0), "circle", (1e-5, 1.5e-2)),
    ] {
        for seed in 100..106 {
            let (structure, how) = separated_modes(seed);
            let set = structure.measured(&Measurement { snr_db, ..how });
            let model = identified(&set, method, Some(inner_band(&structure.modes)));
            let inner = &structure.modes[1..structure.modes.len() - 1];
            let (frequency, damping) = worst(&partners(inner, &model));
            assert!(
                frequency < limits.0 && damping < limits.1,
                "{method} {seed} {frequency:e} {damping:e}"
            );
        }
    }
}

#[test]
fn every_frf_kind_gives_the_same_modes_without_the_damping_of_the_window() {
    let (structure, how) = separated_modes(3);
    let narrowest = structure
        .modes
        .iter()
        .map(width_hz)
        .fold(f64::MAX, f64::min);
    for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
        let added = std::f64::consts::PI * narrowest;
        let set = structure.measured(&Measurement {
            kind,
            added_damping_rad_s: added,
            ..how.clone()
        });
        let model = identified(&set, "circle", None);
        assert_eq!(model.added_damping_rad_s, Some(added));
        for (j, (truth, mode)) in partners(&structure.modes, &model).into_iter().enumerate() {
            assert!((mode.frequency_hz / truth.0 - 1.0).abs() < 1e-9);
            assert!((mode.damping_ratio.unwrap() / truth.1 - 1.0).abs() < 1e-7);
            for pair in &how.pairs {
                let residue = structure.residue(j, pair);
                assert!((mode.residues[pair] - residue).norm() < 1e-5 * residue.norm());
            }
        }
    }
}

#[test]
fn resonance_of_few_lines_is_reported_and_fitted() {
    let (structure, mut how) = separated_modes(5);
    how.axis.step_hz *= 4.0;
    how.axis.len /= 4;
    how.snr_db = Some(60.0);
    let set = structure.measured(&how);
    for method in ["peak", "circle"] {
        let model = identified(&set, method, None);
        let (frequency, damping) = worst(&partners(&structure.modes, &model));
        assert!(frequency < 3e-5 && damping < 5e-3);
        let narrow = |mode: &&(f64, f64, Vec<f64>)| width_hz(mode) < 5.0 * how.axis.step_hz;
        let expected = structure.modes.iter().filter(narrow).count();
        let few_lines = model
            .findings
            .iter()
            .filter(|f| f.code == Code::FewLines)
            .count();
        assert!(
            expected > 0 && few_lines == expected,
            "{few_lines} of {expected}"
        );
    }
}

#[test]
fn pure_noise_gives_no_mode_and_no_finding() {
    let (structure, how) = separated_modes(1);
    let silent = Structure {
        modes: vec![(1e6, 0.5, structure.modes[0].2.clone())],
    };
    for seed in 0..20 {
        for variance_given in [true, false] {
            let mut noise = how.clone();
            noise.axis.len = noise.axis.len.min(4000);
            let set = silent.measured(&Measurement {
                snr_db: Some(-60.0),
                seed,
                variance_given,
                ..noise
            });
            let model = identified(&set, "circle", None);
            assert!(
                model.modes.is_empty() && model.findings.is_empty(),
                "{:?}",
                model.findings
            );
        }
    }
}
