//! A person's choice of poles.

use super::synthetic::{Measurement, Structure, separated_modes};
use super::{IdentifyOptions, PoleStatus, identification};
use crate::finding::Code;
use crate::modal::{PoleSelection, SelectedPole};

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
fn chosen_modes_alone_come_with_residues_of_their_own() {
    let (structure, how, set) = measured();
    for method in ["peak", "circle", "lscf", "ml"] {
        // In any order, and somewhat beside the pole.
        let wanted = [2, 0].map(|j: usize| selected(1.003 * structure.modes[j].0));
        let own = identification(&set, &options(method, wanted.to_vec())).unwrap();
        let modes = &own.model.modes;
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
                let off = (mode.residues[pair] - truth).norm() / truth.norm();
                assert!(off < 0.02, "{method} {off}");
            }
        }
    }
}

#[test]
fn a_choice_that_no_pole_meets_is_told() {
    let (structure, _, set) = measured();
    let hz = structure.modes[1].0;
    let wanted = vec![selected(hz), selected(1.2 * hz)];
    let own = identification(&set, &options("circle", wanted)).unwrap();
    assert_eq!(own.model.modes.len(), 1);
    let findings = &own.model.findings;
    let told = findings.iter().find(|f| f.code == Code::SelectionMissed);
    let told = told.unwrap();
    assert!((told.limit.unwrap() - 0.012 * hz).abs() < 1e-9);
    let others = structure.modes.iter().map(|mode| mode.0);
    let distances = others.filter(|other| (other - hz).abs() > 0.01 * hz);
    let nearest = distances.map(|other| (other - 1.2 * hz).abs());
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    assert!((told.value.unwrap() - nearest).abs() < 0.01 * hz);
}

#[test]
fn a_pole_of_one_order_is_taken_from_that_order() {
    let (structure, _, set) = measured();
    let free = IdentifyOptions {
        method: "lscf".to_owned(),
        ..IdentifyOptions::default()
    };
    let listed = identification(&set, &free).unwrap();
    let hz = structure.modes[3].0;
    let near = |p: &&super::PoleAtOrder| {
        p.status == PoleStatus::Stable && (p.pole.natural_frequency_hz() / hz - 1.0).abs() < 1e-3
    };
    let point = *listed.stabilization.iter().find(near).unwrap();
    let wanted = SelectedPole {
        order: Some(point.order),
        damping_ratio: Some(structure.modes[3].1),
        ..selected(hz)
    };
    let own = identification(&set, &options("lscf", vec![wanted])).unwrap();
    assert_eq!(own.model.modes[0].order, Some(point.order));
    let off = own.model.modes[0].frequency_hz - point.pole.natural_frequency_hz();
    assert!(off.abs() < 1e-9);
    let chosen = |p: &&super::PoleAtOrder| p.status == PoleStatus::Chosen;
    assert_eq!(own.stabilization.iter().filter(chosen).count(), 1);
    let elsewhere = SelectedPole {
        order: Some(999),
        ..wanted
    };
    let own = identification(&set, &options("lscf", vec![elsewhere])).unwrap();
    assert!(own.model.modes.is_empty());
}
