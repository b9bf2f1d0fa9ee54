use std::collections::BTreeMap;

use super::mass_line::{MassLine, find_band, mass_lines};
use super::rows::Rows;
use super::synthetic::{Fault, SuspendedTest, suspended_test};
use super::*;

/// The fault that the sensors' geometry shows without noise, with the variances of the noise.
fn fault_without_noise(test: &SuspendedTest) -> Option<SensorFault> {
    let band = find_band(&test.set)?;
    let lines = mass_lines(&test.set, band)?;
    let exact = test.set.functions().iter().zip(lines);
    let exact = exact.map(|(function, line)| MassLine {
        value: test.exact[&(function.response.clone(), function.reference.clone())],
        ..line
    });
    let rows = Rows::new(&test.set, &test.placed, &exact.collect::<Vec<_>>())?;
    sensor_faults::find(&rows)
}

fn is_right(found: &Repair, truth: &Repair) -> bool {
    match (found, truth) {
        (
            Repair::Gain { dof, gain, std },
            Repair::Gain {
                dof: of,
                gain: truth,
                ..
            },
        ) => dof == of && (gain - truth).abs() <= 3.5 * std,
        _ => found == truth,
    }
}

/// The first of these draws; all with the environment variable `ALL_DRAWS`.
fn draws(first: u64) -> std::ops::Range<u64> {
    let has_all = std::env::var_os("ALL_DRAWS").is_some();
    first..first + if has_all { 200 } else { 40 }
}

#[test]
fn sound_sensors_are_not_named() {
    let named = |seed: &u64| {
        let test = suspended_test(*seed, Fault::None);
        rigid_body(&test.set, &test.placed, None).is_some_and(|body| body.fault.is_some())
    };
    let named = draws(0).filter(named).count();
    assert!(100 * named <= draws(0).count(), "{named}");
}

#[test]
fn a_wrong_sensor_is_named_and_repaired() {
    for fault in [Fault::Sign, Fault::Gain, Fault::Axis, Fault::Exchange] {
        let (mut shown, mut right, mut wrong) = (0, 0, 0);
        for seed in draws(1000) {
            let test = suspended_test(seed, fault);
            let truth = test.repair.as_ref().expect("a fault");
            // What falls by half more than the limit without noise falls by the limit with it.
            let without_noise = fault_without_noise(&test).filter(|fault| fault.fall >= 45.0);
            let is_shown = without_noise.is_some_and(|fault| is_right(&fault.repair, truth));
            let Some(body) = rigid_body(&test.set, &test.placed, None) else {
                continue;
            };
            let found = body.fault.map(|fault| fault.repair);
            let right_one = found.as_ref().is_some_and(|repair| is_right(repair, truth));
            let is_named = found.is_some_and(|repair| !matches!(repair, Repair::LeftOut(_)));
            shown += usize::from(is_shown);
            right += usize::from(is_shown && right_one);
            wrong += usize::from(is_named && !right_one);
        }
        let text = format!("{fault:?}: {right} of {shown} right, {wrong} wrong");
        assert!(
            5 * shown >= 2 * draws(0).count() && 20 * right >= 19 * shown,
            "{text}"
        );
        assert!(20 * wrong <= draws(0).count(), "{text}");
    }
}

#[test]
fn the_mass_has_its_stated_deviation() {
    let (mut shown, mut near, mut inside) = (0, 0, 0);
    for seed in draws(2000) {
        let test = suspended_test(seed, Fault::None);
        let body = rigid_body(&test.set, &test.placed, None);
        if let Some(inertia) = body.and_then(|body| body.inertia) {
            shown += 1;
            let error = (inertia.mass_kg - test.mass_kg).abs();
            inside += usize::from(error <= 1.96 * inertia.mass_std_kg);
            near += usize::from(error <= 0.01 * test.mass_kg);
        }
    }
    let text = format!("{shown} masses, {near} within 1 %, {inside} inside 95 %");
    // 95 % of 40 draws with three deviations of their binomial spread.
    assert!(
        5 * shown >= draws(0).count() && 20 * near >= 19 * shown,
        "{text}"
    );
    assert!(20 * inside >= 17 * shown, "{text}");
}

#[test]
fn without_positions_or_a_mass_line_there_is_no_body() {
    let test = suspended_test(1, Fault::None);
    assert_eq!(rigid_body(&test.set, &BTreeMap::new(), None), None);
    let above = Band::new(100.0, 101.0).expect("a band");
    assert_eq!(rigid_body(&test.set, &test.placed, Some(above)), None);
}
