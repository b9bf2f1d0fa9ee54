use std::collections::BTreeMap;

use num_complex::Complex64;

use super::mass_line::{MassLine, find_mass_lines};
use super::rows::Rows;
use super::synthetic::{Family, Fault, SuspendedTest, suspended_test};
use super::synthetic_bodies::spring_mounted_bodies;
use super::*;
use crate::frf::{Function, FunctionData};
use crate::modal::Mode;

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
        let body = rigid_body(&test.set, &test.placed);
        body.is_none_or(|body| body.fault.is_none() && body.is_rigid())
    };
    let sound = draws(0).filter(is_sound).count();
    assert!(is_at_least(sound, draws(0).count(), 0.99), "{sound}");
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn a_wrong_sensor_is_named_and_repaired() {
    for fault in [Fault::Sign, Fault::Gain, Fault::Axis, Fault::Exchange] {
        let (mut shown, mut right, mut named_rightly) = (0, 0, 0);
        for seed in draws(1000) {
            let test = suspended_test(seed, fault, &family(seed));
            let truth = test.repair.as_ref().expect("a fault");
            // What falls by half more than the limit without noise falls by the limit with it.
            let without_noise = fault_without_noise(&test).filter(|fault| fault.fall >= 45.0);
            let is_shown = without_noise.is_some_and(|fault| is_right(&fault.repair, truth));
            let body = rigid_body(&test.set, &test.placed);
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

/// The FRFs with other values, from the function, the angular frequency and the value.
fn changed(set: &FrfSet, value: impl Fn(&Function, f64, Complex64) -> Complex64) -> FrfSet {
    let axis = *set.axis();
    let mut changed = FrfSet::new(axis);
    for (i, function) in set.functions().iter().enumerate() {
        let values = set.values(i).iter().enumerate();
        let data = FunctionData {
            values: values
                .map(|(line, of_line)| value(function, axis.rad_s(line), *of_line))
                .collect(),
            coherence: None,
            variance: set.variance(i).map(<[f64]>::to_vec),
        };
        changed
            .push(function.clone(), data)
            .expect("each pair once");
    }
    changed
}

/// The FRFs with these sensors' signs reversed.
fn reversed(set: &FrfSet, sensors: &[Dof]) -> FrfSet {
    changed(set, |function, _, value| {
        match sensors.contains(&function.response) {
            true => -value,
            false => value,
        }
    })
}

#[test]
fn several_wrong_sensors_are_no_rigid_body() {
    for count in [2, 3] {
        let (mut all, mut rigid, mut wrongly_named) = (0, 0, 0);
        for seed in draws(7000) {
            let test = suspended_test(seed, Fault::None, &family(seed));
            let sensors: Vec<Dof> = test.set.responses().into_iter().take(count).collect();
            let set = reversed(&test.set, &sensors);
            let Some(body) = rigid_body(&set, &test.placed) else {
                continue;
            };
            // The reversal of a sensor near a node is not seen, and the others are one fault.
            let is_right = |repair: &Repair| match repair {
                Repair::Sign(dof) | Repair::LeftOut(dof) => sensors.contains(dof),
                _ => false,
            };
            let repair = body.fault.as_ref().map(|fault| &fault.repair);
            assert!(body.is_rigid() || (repair.is_none() && body.inertia.is_err()));
            all += 1;
            rigid += usize::from(body.is_rigid() && repair.is_none());
            wrongly_named += usize::from(repair.is_some_and(|repair| !is_right(repair)));
        }
        let text = format!("{count} reversed: {rigid} rigid, {wrongly_named} named of {all}");
        println!("{text}");
        assert!(2 * all >= draws(7000).count(), "{text}");
        assert!(is_at_least(all - rigid, all, 0.98), "{text}");
        assert!(is_at_least(all - wrongly_named, all, 0.95), "{text}");
    }
}

#[test]
fn the_mass_has_its_stated_deviation() {
    let (mut shown, mut near, mut accurate) = (0, 0, 0);
    // Of masses and coordinates of the centre.
    let (mut intervals, mut inside) = (0, 0);
    for seed in draws(2000) {
        let test = suspended_test(seed, Fault::None, &family(seed));
        let body = rigid_body(&test.set, &test.placed);
        let Some(inertia) = body.and_then(|body| body.inertia.ok()) else {
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
    let inertia = rigid_body(&test.noise_free, &test.placed)?.inertia.ok()?;
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
    assert_eq!(rigid_body(&test.set, &BTreeMap::new()), None);
    // A structure on the ground with one mode.
    let natural = std::f64::consts::TAU * 100.0;
    let grounded = changed(&test.set, |_, omega, _| {
        let stiff = natural * natural - omega * omega;
        -omega * omega / Complex64::new(stiff, 0.02 * natural * omega)
    });
    assert!(mass_line::peaks_hz(&grounded).is_some_and(|peaks| peaks.len() == 1));
    assert_eq!(rigid_body(&grounded, &test.placed), None);
}

/// A set whose FRFs are the accelerance of a free mass with modes at these frequencies.
fn with_modes(modes_hz: &[f64]) -> FrfSet {
    let set = suspended_test(1, Fault::None, &Family::CUSTOMARY).set;
    changed(&set, |_, omega, _| {
        let [lowest, others @ ..] = modes_hz else {
            return Complex64::from(1.0);
        };
        let ratio = |hz: &f64| omega / (std::f64::consts::TAU * hz);
        let square = ratio(lowest).powi(2);
        let hung = square / Complex64::new(square - 1.0, -0.05 * ratio(lowest));
        let mode = |hz: &f64| {
            let square = ratio(hz).powi(2);
            square / Complex64::new(1.0 - square, 0.05 * ratio(hz))
        };
        hung + others.iter().map(mode).sum::<Complex64>()
    })
}

#[test]
fn a_band_between_modes_of_the_suspension_is_no_mass_line() {
    let found = neighbouring_peaks(&with_modes(&[4.0, 40.0]), None);
    assert_eq!((found.below_hz, found.above_hz), (None, None));
    let found = neighbouring_peaks(&with_modes(&[5.0, 100.0]), None);
    assert_eq!((found.below_hz, found.above_hz), (Some(5.0), Some(100.0)));
}

#[test]
fn noise_above_the_valid_band_hides_no_peak_and_has_none() {
    let quiet = with_modes(&[2.0, 40.0]);
    let end = std::f64::consts::TAU * 50.0;
    let mut noisy = changed(&quiet, |_, omega, value| match omega > end {
        // Far above the peaks, with peaks between.
        true => Complex64::from(1e3 * (2.0 + (7.0 * omega).sin())),
        false => value,
    });
    assert!(neighbouring_peaks(&noisy, None).above_hz != Some(40.0));
    noisy.valid_band = Some(Band::new(0.5, 49.0).expect("a band"));
    let found = neighbouring_peaks(&noisy, None);
    assert_eq!((found.below_hz, found.above_hz), (Some(2.0), Some(40.0)));
    assert_eq!(
        mass_line::peaks_hz(&noisy).map(|peaks| peaks.len()),
        Some(2)
    );
}

#[test]
fn peaks_beside_the_mass_line_are_found() {
    let set = suspended_test(1, Fault::None, &Family::CUSTOMARY).set;
    let found = neighbouring_peaks(&set, None);
    let (below_hz, above_hz) = (found.below_hz.unwrap(), found.above_hz.unwrap());
    assert!(below_hz < 6.0 && above_hz > 85.0, "{found:?}");
    // Stated with two digits, rounded down.
    let stated = neighbouring_peaks(&set, Some(0.95 * below_hz));
    assert_eq!((stated.below_hz, stated.above_hz), (None, Some(above_hz)));
    // A stiff suspension near the first elastic mode.
    let stiff = neighbouring_peaks(&set, Some(above_hz / 1.5));
    assert_eq!(stiff.above_hz, Some(above_hz));
}

#[test]
fn sound_sensors_of_bodies_are_not_named() {
    let is_sound = |seed: &u64| {
        let machine = spring_mounted_bodies(*seed, Fault::None, None);
        let mut bodies = machine.placed.iter();
        bodies.all(|placed| {
            let found = rigid_in_modes(&machine.modes, placed);
            found.is_none_or(|body| body.fault.is_none())
        })
    };
    let sound = draws(4000).filter(is_sound).count();
    assert!(is_at_least(sound, draws(4000).count(), 0.99), "{sound}");
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn a_wrong_sensor_of_a_body_is_named_and_repaired() {
    for fault in [Fault::Sign, Fault::Gain, Fault::Axis, Fault::Exchange] {
        let (mut shown, mut right, mut named_rightly) = (0, 0, 0);
        for seed in draws(5000) {
            let machine = spring_mounted_bodies(seed, fault, None);
            let truth = machine.repair.as_ref().expect("a fault");
            let found =
                |modes: &[Mode], body: usize| rigid_in_modes(modes, &machine.placed[body])?.fault;
            let without_noise = found(&machine.noise_free, machine.wrong_body);
            let without_noise = without_noise.filter(|fault| fault.fall >= 45.0);
            let is_shown = without_noise.is_some_and(|fault| is_right(&fault.repair, truth));
            let named: Vec<Repair> = (0..machine.placed.len())
                .filter_map(|body| found(&machine.modes, body))
                .map(|fault| fault.repair)
                .collect();
            let is_right = |repair: &Repair| is_right(repair, truth);
            shown += usize::from(is_shown);
            right += usize::from(is_shown && named.iter().any(is_right));
            named_rightly += usize::from(named.iter().all(is_right));
        }
        let all = draws(5000).count();
        let text = format!("{fault:?}: {right} of {shown} right, {named_rightly} of {all}");
        println!("bodies {text}");
        assert!(4 * shown >= all, "{text}");
        assert!(is_at_least(right, shown, 0.95), "{text}");
        assert!(is_at_least(named_rightly, all, 0.98), "{text}");
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn a_body_that_bends_has_no_sensor_named() {
    let named = |bending_from: usize| {
        let is_named = |seed: &u64| {
            let machine = spring_mounted_bodies(*seed, Fault::None, Some(bending_from));
            let found = rigid_in_modes(&machine.modes, &machine.placed[0]);
            found.is_some_and(|body| body.fault.is_some())
        };
        (6000..6200).filter(is_named).count()
    };
    // Near its first mode, and where no mode is below it.
    let (near, above) = (named(3), named(0) + named(1));
    assert!(near <= 2 && near + above <= 10, "{near} {above}");
}

#[test]
fn modes_of_rigid_bodies_are_all_used() {
    let (mut all, mut used) = (0, 0);
    for seed in draws(4000) {
        let machine = spring_mounted_bodies(seed, Fault::None, None);
        for placed in &machine.placed {
            let Some(found) = rigid_in_modes(&machine.modes, placed) else {
                continue;
            };
            all += 1;
            used += usize::from(found.modes == machine.modes.len());
        }
    }
    println!("modes {used} of {all}");
    assert!(is_at_least(used, all, 0.98), "{used} of {all}");
}
