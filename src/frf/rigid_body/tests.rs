use std::collections::BTreeMap;

use super::mass_line::{MassLine, find_mass_lines};
use super::rows::Rows;
use super::synthetic::{Family, Fault, SuspendedTest, suspended_test};
use super::*;
use crate::frf::FunctionData;

/// The fault that the sensors' geometry shows without noise, with the variances of the noise.
fn fault_without_noise(test: &SuspendedTest) -> Option<SensorFault> {
    let lines = find_mass_lines(&test.set)?.lines;
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

/// Draws of a test: the first 40, or with the environment variable `ALL_DRAWS` all 200.
fn draws(first: u64) -> std::ops::Range<u64> {
    first..first + if has_all_draws() { 200 } else { 40 }
}

fn has_all_draws() -> bool {
    std::env::var_os("ALL_DRAWS").is_some()
}

/// Whether a count may come from draws with this probability: within it where all are drawn, within
/// three deviations of the binomial spread of the first draws.
fn is_at_least(count: usize, of: usize, probability: f64) -> bool {
    let (count, of) = (count as f64, of as f64);
    let spread = match has_all_draws() {
        true => 0.0,
        false => 3.0 * (of * probability * (1.0 - probability)).sqrt(),
    };
    count + spread >= probability * of
}

/// Half of the draws of the customary family, half with other noise and damping.
fn family(seed: u64) -> Family {
    match seed % 2 {
        0 => Family::CUSTOMARY,
        _ => Family::drawn(seed),
    }
}

#[test]
fn sound_sensors_are_not_named() {
    let is_sound = |seed: &u64| {
        let test = suspended_test(*seed, Fault::None, &family(*seed));
        rigid_body(&test.set, &test.placed, None).is_none_or(|body| body.fault.is_none())
    };
    let sound = draws(0).filter(is_sound).count();
    assert!(is_at_least(sound, draws(0).count(), 0.99), "{sound}");
}

#[test]
fn a_wrong_sensor_is_named_and_repaired() {
    for fault in [Fault::Sign, Fault::Gain, Fault::Axis, Fault::Exchange] {
        let (mut shown, mut right, mut named_rightly) = (0, 0, 0);
        for seed in draws(1000) {
            let test = suspended_test(seed, fault, &family(seed));
            let truth = test.repair.as_ref().expect("a fault");
            // What falls by half more than the limit without noise falls by the limit with it.
            let without_noise = fault_without_noise(&test).filter(|fault| fault.fall >= 45.0);
            let is_shown = without_noise.is_some_and(|fault| is_right(&fault.repair, truth));
            let body = rigid_body(&test.set, &test.placed, None);
            let found = body.and_then(|body| body.fault).map(|fault| fault.repair);
            let right_one = found.as_ref().is_some_and(|repair| is_right(repair, truth));
            let is_named = found.is_some_and(|repair| !matches!(repair, Repair::LeftOut(_)));
            shown += usize::from(is_shown);
            right += usize::from(is_shown && right_one);
            named_rightly += usize::from(!is_named || right_one);
        }
        let all = draws(1000).count();
        let text = format!("{fault:?}: {right} of {shown} right, {named_rightly} of {all}");
        println!("{text}");
        assert!(5 * shown >= 2 * all, "{text}");
        assert!(is_at_least(right, shown, 0.95), "{text}");
        assert!(is_at_least(named_rightly, all, 0.98), "{text}");
    }
}

#[test]
fn the_mass_has_its_stated_deviation() {
    let (mut shown, mut near, mut accurate) = (0, 0, 0);
    // Of masses and coordinates of the centre.
    let (mut intervals, mut inside) = (0, 0);
    for seed in draws(2000) {
        let test = suspended_test(seed, Fault::None, &family(seed));
        let body = rigid_body(&test.set, &test.placed, None);
        let Some(inertia) = body.and_then(|body| body.inertia) else {
            continue;
        };
        let mass_error = (inertia.mass_kg - test.mass_kg).abs();
        let centre_error = |axis: usize| (inertia.centre_m[axis] - test.centre_m[axis]).abs();
        shown += 1;
        if inertia.mass_std_kg <= 0.004 * test.mass_kg {
            accurate += 1;
            near += usize::from(mass_error <= 0.01 * test.mass_kg);
        }
        let errors = [
            mass_error,
            centre_error(0),
            centre_error(1),
            centre_error(2),
        ];
        let [x, y, z] = inertia.centre_std_m;
        for (error, std) in errors.into_iter().zip([inertia.mass_std_kg, x, y, z]) {
            intervals += 1;
            inside += usize::from(error <= 1.96 * std);
        }
    }
    let text = format!(
        "{shown} masses, {near} of {accurate} within 1 %, {inside} of {intervals} inside 95 %"
    );
    println!("{text}");
    assert!(5 * shown >= draws(2000).count(), "{text}");
    assert!(
        3 * accurate >= shown && is_at_least(near, accurate, 0.98),
        "{text}"
    );
    assert!(is_at_least(inside, intervals, 0.93), "{text}");
    assert!(is_at_least(intervals - inside, intervals, 0.03), "{text}");
}

/// Error of the mass without noise over the deviation that the noise has.
fn bias_of_mass(seed: u64, family: &Family) -> Option<f64> {
    let test = suspended_test(seed, Fault::None, family);
    let inertia = rigid_body(&test.noise_free, &test.placed, None)?.inertia?;
    Some((inertia.mass_kg - test.mass_kg) / inertia.mass_std_kg)
}

#[test]
fn modes_beside_the_band_do_not_bias_the_mass() {
    let biases: Vec<f64> = (3000..3040)
        .filter_map(|seed| bias_of_mass(seed, &Family::CUSTOMARY))
        .collect();
    let rms = (biases.iter().map(|bias| bias * bias).sum::<f64>() / biases.len() as f64).sqrt();
    assert!(biases.len() >= 10 && rms < 0.3, "{rms}");
}

#[test]
fn a_suspension_without_clear_peaks_does_not_bias_the_mass() {
    for seed in [60_621, 61_444] {
        let bias = bias_of_mass(seed, &Family::drawn(seed));
        assert!(bias.is_none_or(|bias| bias.abs() < 1.0), "{seed}: {bias:?}");
    }
}

#[test]
fn stated_variances_hold_where_the_residual_agrees() {
    let test = suspended_test(5, Fault::None, &Family::CUSTOMARY);
    let with_factor = |factor: f64| -> Vec<f64> {
        let mut set = FrfSet::new(*test.set.axis());
        for (i, function) in test.set.functions().iter().enumerate() {
            let variance = test.set.variance(i).expect("a variance");
            let data = FunctionData {
                values: test.set.values(i).to_vec(),
                coherence: None,
                variance: Some(variance.iter().map(|v| factor * v).collect()),
            };
            set.push(function.clone(), data).expect("each pair once");
        }
        let lines = find_mass_lines(&set).expect("mass lines").lines;
        lines.iter().map(|line| line.variance).collect()
    };
    let stated = with_factor(1.0);
    let lowest = stated.iter().copied().fold(f64::INFINITY, f64::min);
    let alike = stated.iter().filter(|v| **v < 1.0001 * lowest).count();
    assert!(10 * alike >= 9 * stated.len(), "{alike}");
    // Stated as a third, they are found from the residual.
    let restored: f64 = with_factor(1.0 / 3.0).iter().sum::<f64>() / stated.len() as f64;
    assert!((restored / lowest - 1.0).abs() < 0.1, "{restored} {lowest}");
}

#[test]
fn without_positions_or_a_mass_line_there_is_no_body() {
    let test = suspended_test(1, Fault::None, &Family::CUSTOMARY);
    assert_eq!(rigid_body(&test.set, &BTreeMap::new(), None), None);
    let above = Band::new(100.0, 101.0).expect("a band");
    assert_eq!(rigid_body(&test.set, &test.placed, Some(above)), None);
}
