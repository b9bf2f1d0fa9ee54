//! Tests of the selection of poles by the user.

use crate::finding::Code;
use crate::identify::estimator::{IdentifyOptions, PoleStatus};
use crate::identify::identification;
use crate::identify::mdof::estimator::fit_at_poles;
use crate::identify::run_variation::RunShifts;
use crate::identify::synthetic::{Measurement, Structure, separated_modes};
use crate::modal::{Pole, PoleSelection, SelectedPole};

fn selected(frequency_hz: f64) -> SelectedPole {
    SelectedPole {
        frequency_hz,
        damping_ratio: None,
        order: None,
    }
}

fn options(method: &str, poles: Vec<SelectedPole>) -> IdentifyOptions {
    IdentifyOptions {
        method: method.to_owned(),
        selection: Some(PoleSelection {
            poles,
            tolerance_hz: None,
        }),
        ..IdentifyOptions::default()
    }
}

/// Four modes at 60 dB.
fn measured() -> (Structure, Measurement, crate::frf::FrfSet) {
    let (structure, how) = separated_modes(0);
    let how = Measurement {
        snr_db: Some(60.0),
        ..how
    };
    let set = structure.measured(&how);
    (structure, how, set)
}

#[test]
fn result_has_only_the_selected_modes_with_unbiased_residues() {
    let (structure, how, set) = measured();
    for method in ["peak", "circle", "lscf", "ml"] {
        // In any order, and at some distance from the pole.
        let wanted = [2, 0].map(|j: usize| selected(1.003 * structure.modes[j].0));
        let result = identification(&set, &options(method, wanted.to_vec())).unwrap();
        let modes = &result.model.modes;
        assert_eq!(modes.len(), 2, "{method}");
        for (mode, j) in modes.iter().zip([0, 2]) {
            let (hz, zeta, _) = structure.modes[j];
            assert!(
                (mode.frequency_hz - hz).abs() < 0.01 * hz * zeta,
                "{method}"
            );
            assert_eq!(mode.method.as_deref(), Some(method));
            for pair in &how.pairs {
                let truth = structure.residue(j, pair);
                let error = (mode.residues[pair] - truth).norm() / truth.norm();
                assert!(error < 0.02, "{method} {error}");
            }
        }
    }
}

#[test]
fn selection_without_a_pole_within_the_tolerance_is_reported() {
    let (structure, _, set) = measured();
    let hz = structure.modes[1].0;
    let wanted = vec![selected(hz), selected(1.2 * hz)];
    let result = identification(&set, &options("circle", wanted)).unwrap();
    assert_eq!(result.model.modes.len(), 1);
    let findings = &result.model.findings;
    let missed = findings.iter().find(|f| f.code == Code::SelectionMissed);
    let missed = missed.unwrap();
    assert!((missed.limit.unwrap() - 0.012 * hz).abs() < 1e-9);
    let others = structure.modes.iter().map(|mode| mode.0);
    let distances = others.filter(|other| (other - hz).abs() > 0.01 * hz);
    let nearest = distances.map(|other| (other - 1.2 * hz).abs());
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    assert!((missed.value.unwrap() - nearest).abs() < 0.01 * hz);
}

#[test]
fn pole_of_a_stated_order_is_selected_from_that_order() {
    let (structure, _, set) = measured();
    let free = IdentifyOptions {
        method: "lscf".to_owned(),
        ..IdentifyOptions::default()
    };
    let listed = identification(&set, &free).unwrap();
    let hz = structure.modes[3].0;
    let near = |p: &&crate::identify::estimator::PoleAtOrder| {
        p.status == PoleStatus::Stable && (p.pole.natural_frequency_hz() / hz - 1.0).abs() < 1e-3
    };
    let point = *listed.stabilization.iter().find(near).unwrap();
    let wanted = SelectedPole {
        order: Some(point.order),
        damping_ratio: Some(structure.modes[3].1),
        ..selected(hz)
    };
    let result = identification(&set, &options("lscf", vec![wanted])).unwrap();
    assert_eq!(result.model.modes[0].order, Some(point.order));
    let error_hz = result.model.modes[0].frequency_hz - point.pole.natural_frequency_hz();
    assert!(error_hz.abs() < 1e-9);
    let chosen = |p: &&crate::identify::estimator::PoleAtOrder| p.status == PoleStatus::Selected;
    assert_eq!(result.stabilization.iter().filter(chosen).count(), 1);
    let elsewhere = SelectedPole {
        order: Some(999),
        ..wanted
    };
    let result = identification(&set, &options("lscf", vec![elsewhere])).unwrap();
    assert!(result.model.modes.is_empty());
}

/// A pole of the listing of `lscf` near a mode, of its order.
fn listed(
    set: &crate::frf::FrfSet,
    choose: impl Fn(&crate::identify::estimator::PoleAtOrder) -> bool,
) -> Vec<crate::identify::estimator::PoleAtOrder> {
    let free = IdentifyOptions {
        method: "lscf".to_owned(),
        ..IdentifyOptions::default()
    };
    let result = identification(set, &free).unwrap();
    result.stabilization.into_iter().filter(choose).collect()
}

fn named(point: &crate::identify::estimator::PoleAtOrder, order: Option<usize>) -> SelectedPole {
    SelectedPole {
        frequency_hz: point.pole.natural_frequency_hz(),
        damping_ratio: Some(point.pole.damping_ratio()),
        order,
    }
}

#[test]
fn poles_of_one_mode_at_two_orders_are_both_selected_only_where_the_orders_are_stated() {
    let (structure, _, set) = measured();
    let hz = structure.modes[3].0;
    let is_stable = |p: &crate::identify::estimator::PoleAtOrder| {
        p.status == PoleStatus::Stable && (p.pole.natural_frequency_hz() / hz - 1.0).abs() < 1e-3
    };
    let points = listed(&set, is_stable);
    let both = [&points[0], points.last().unwrap()];
    assert_ne!(both[0].pole, both[1].pole);
    let free = both.map(|point| named(point, None)).to_vec();
    let result = identification(&set, &options("lscf", free)).unwrap();
    assert_eq!(result.model.modes.len(), 1);
    let missed = |f: &&crate::finding::Finding| f.code == Code::SelectionMissed;
    assert_eq!(result.model.findings.iter().filter(missed).count(), 1);
    // Two poles that cannot be separated are both kept, at their frequencies.
    let exact = both.map(|point| named(point, Some(point.order))).to_vec();
    let result = identification(&set, &options("lscf", exact)).unwrap();
    assert_eq!(result.model.modes.len(), 2);
    for point in both {
        let has_frequency = |mode: &crate::modal::Mode| {
            (mode.frequency_hz - point.pole.natural_frequency_hz()).abs() < 1e-9
        };
        assert!(result.model.modes.iter().any(has_frequency));
    }
}

#[test]
fn every_selected_pole_gives_a_mode_or_a_finding() {
    let (structure, mut how, _) = measured();
    // The upper mode lies outside the band, on its guard lines.
    let hz = structure.modes[2].0;
    let band = crate::axis::Band::new(0.7 * structure.modes[1].0, 0.99 * hz).ok();
    for second in [false, true] {
        if second {
            let pairs = how.pairs.clone().into_iter();
            how.pairs
                .extend(pairs.map(|(r, _)| (r, "2:+Z".parse().unwrap())));
        }
        let set = structure.measured(&how);
        let mut options = options("lscf", Vec::new());
        options.band = band;
        options.selection = None;
        let all = identification(&set, &options).unwrap().stabilization;
        let is_near_edge = |p: &&crate::identify::estimator::PoleAtOrder| {
            (p.pole.natural_frequency_hz() / hz - 1.0).abs() < 1e-3
        };
        let outside = all.iter().find(is_near_edge).unwrap();
        let inside = selected(structure.modes[1].0);
        options.selection = Some(PoleSelection {
            poles: vec![inside, named(outside, Some(outside.order))],
            tolerance_hz: None,
        });
        let result = identification(&set, &options).unwrap();
        assert_eq!(result.model.modes.len(), 1);
        let missed = result.model.findings.iter();
        let missed = missed.filter(|f| f.code == Code::SelectionMissed).count();
        assert_eq!(missed, 1, "{second}");
    }
}

#[test]
fn fixed_poles_are_all_kept() {
    let (structure, mut how, _) = measured();
    let true_pole = |mode: &(f64, f64, Vec<f64>)| Pole::from_frequency(mode.0, mode.1).lambda;
    let mut poles: Vec<_> = structure.modes.iter().map(true_pole).collect();
    // One that cannot be separated from the first, and one where there is only noise.
    poles.push(poles[0] - 0.05 * poles[0].re);
    let between = 0.5 * (structure.modes[0].0 + structure.modes[1].0);
    poles.push(Pole::from_frequency(between, structure.modes[0].1).lambda);
    for second in [false, true] {
        if second {
            let pairs = how.pairs.clone().into_iter();
            how.pairs
                .extend(pairs.map(|(r, _)| (r, "2:+Z".parse().unwrap())));
        }
        let set = structure.measured(&how);
        let band = crate::identify::data::band_frfs::whole_band(&set).unwrap();
        let table = fit_at_poles(&set, band, &poles, RunShifts::default()).unwrap();
        for pole in &poles {
            let kept = table.candidates.iter();
            let kept = kept.filter(|candidate| candidate.pole.lambda == *pole);
            assert_eq!(kept.count(), 1, "{second} {pole}");
        }
    }
}
