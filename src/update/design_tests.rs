//! Designs reach their targets at the least cost that other searches find.

use crate::theory::{ModeOptions, built_in, modes, nominal_values};

use super::*;
use crate::axis::Band;

fn found(names: &[&str], goals: &[(usize, Goal)]) -> (Vec<FreeParameter>, Design) {
    let model = built_in("torsional-planetary").unwrap();
    let values = nominal_values(model.parameters());
    let choice = |name: &&str| ParameterChoice {
        name: (*name).to_owned(),
        ..ParameterChoice::default()
    };
    let choices: Vec<ParameterChoice> = names.iter().map(choice).collect();
    let free = design_parameters(model.as_ref(), &values, &choices, 1.0).unwrap();
    let targets: Vec<FrequencyTarget> = goals
        .iter()
        .map(|&(root, goal)| FrequencyTarget { root, goal })
        .collect();
    let design = design(model.as_ref(), &values, &free, &targets, None).unwrap();
    (free, design)
}

fn hz(values: &[f64], place: usize) -> f64 {
    let model = built_in("torsional-planetary").unwrap();
    let solved = modes(model.as_ref(), values, &[], &ModeOptions::default()).unwrap();
    solved.omega_rad_s[place] / std::f64::consts::TAU
}

#[test]
fn a_design_meets_its_target_exactly_at_the_least_cost_of_a_grid() {
    let (free, design) = found(&["k_r", "k_cu"], &[(1, Goal::Above(1800.0))]);
    let proposal = &design.combined;
    assert!(proposal.is_met);
    assert!((hz(&proposal.values, 1) / 1800.0 - 1.0).abs() < 1e-9);
    // Along the boundary: for each k_r the least k_cu by bisection.
    let mut best = f64::INFINITY;
    let model = built_in("torsional-planetary").unwrap();
    for step in -40..=40 {
        let r = f64::from(step) * 0.01;
        let at = |c: f64| {
            let mut values = nominal_values(model.parameters());
            values[free[0].index] *= r.exp();
            values[free[1].index] *= c.exp();
            hz(&values, 1) - 1800.0
        };
        let (mut low, mut high) = (-2f64.ln(), 2f64.ln());
        if at(high) < 0.0 {
            continue;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if at(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        best = best.min(r * r + high * high);
    }
    assert!(
        proposal.cost <= best * 1.0001 && proposal.cost > 0.98 * best,
        "{best}"
    );
}

#[test]
fn a_target_out_of_reach_ends_at_the_bounds_that_come_nearest() {
    let (free, design) = found(&["k_r", "k_s", "k_cu"], &[(1, Goal::Above(2800.0))]);
    let proposal = &design.combined;
    assert!(!proposal.is_met);
    for (parameter, value) in free.iter().zip(&proposal.free_values) {
        assert!(
            (value / parameter.upper - 1.0).abs() < 1e-6,
            "{}",
            parameter.name
        );
    }
    let expected = 1.0 - hz(&proposal.values, 1) / 2800.0;
    assert!((proposal.violation - expected).abs() < 1e-9);
    assert!(design.single.iter().all(|(_, proposal)| !proposal.is_met));
}

#[test]
fn targets_hold_together_and_the_cheaper_side_of_a_band_is_taken() {
    let band = Band::new(1600.0, 1690.0).unwrap();
    let goals = [(1, Goal::Outside(band)), (2, Goal::Equal(2100.0))];
    let (_, design) = found(&["k_r", "k_s", "k_cu"], &goals);
    let proposal = &design.combined;
    assert!(proposal.is_met);
    assert!(hz(&proposal.values, 1) >= 1690.0 * (1.0 - 1e-9));
    assert!((hz(&proposal.values, 2) / 2100.0 - 1.0).abs() < 1e-9);
}

#[test]
fn a_target_that_the_model_meets_costs_nothing() {
    let (free, design) = found(&["k_r", "k_cu"], &[(1, Goal::Below(1700.0))]);
    assert!(design.combined.is_met && design.combined.cost.abs() < 1e-20);
    let values = free.iter().zip(&design.combined.free_values);
    assert!(
        values
            .into_iter()
            .all(|(p, value)| (p.initial - value).abs() < 1e-6)
    );
}

#[test]
fn a_parameter_stays_within_its_stated_bounds() {
    let model = built_in("torsional-planetary").unwrap();
    let values = nominal_values(model.parameters());
    let choice = |name: &str, upper| ParameterChoice {
        name: name.to_owned(),
        upper,
        ..ParameterChoice::default()
    };
    let choices = [choice("k_cu", Some(1.05e9)), choice("k_r", Some(2e9))];
    let free = design_parameters(model.as_ref(), &values, &choices, 1.0).unwrap();
    let target = FrequencyTarget {
        root: 1,
        goal: Goal::Above(1715.0),
    };
    let design = design(model.as_ref(), &values, &free, &[target], None).unwrap();
    let proposal = &design.combined;
    assert!(proposal.is_met, "{proposal:?}");
    assert!((proposal.free_values[0] / 1.05e9 - 1.0).abs() < 1e-9);
    assert!(proposal.free_values[1] > 5e8 && proposal.free_values[1] <= 2e9);
}
