//! Consistency checks of a set of FRFs find errors of the test: signs at driving points,
//! reciprocity, repeated measurements, delays between channels, and natural frequencies that shift
//! between measurement runs.
//!
//! | check | holds for | reference |
//! |---|---|---|
//! | [`driving_point`] | a passive structure: `Re Y ≥ 0` where force and response meet | Ewins (2000), Modal Testing, section 3.7 |
//! | [`reciprocity`] | a linear structure: `H_ij = H_ji` | Maxwell and Betti; Ewins (2000), section 2.8 |
//! | [`repeatability`] | the same pair measured twice | — |
//! | [`channel_delay`] | real modes: residues of one phase | — |
//! | [`sensor_scale`] | points of one structure: levels within a hundred times each other | — |
//! | [`mass_loading`] | one structure in all runs: one pole | Ewins (2000), section 3.6 (mass loading) |
//! | [`force_level`] | a linear structure: one pole whatever the force | Worden and Tomlinson (2001), section 3.2 |
//!
//! [`pair_figures`] and [`visits`] give the figures of such checks where they pass, too, and
//! [`resonances`] coherence and standard deviation of functions at their resonances.
//!
//! Every check works on functions of motion, as mobilities `Y = s^d H` at `s = iω + a`, turned to
//! the positive axes. A check says nothing where the data cannot carry it. It fits single
//! resonances to compare functions; it lists no modes.

mod channel_delay;
mod discrepancy;
mod driving_point;
pub(super) mod force_level;
mod mass_loading;
mod mobility;
pub(super) mod pair_figures;
mod reciprocity;
mod repeatability;
pub(super) mod resonances;
mod sensor_scale;
pub(super) mod visits;

#[cfg(test)]
mod false_alarm_tests;
#[cfg(test)]
pub(super) mod synthetic;

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};

use super::FrfSet;
use discrepancy::gross_difference_finding;
use mobility::Mobilities;

/// Consistency of FRFs of unknown origin: signs at driving points, reciprocity, repeated
/// measurements, and functions that are 0 throughout.
///
/// Files often state no band and no variances, and the axis may extend beyond the range of force
/// and sensor: functions are compared at their clear resonances alone, and only gross differences
/// are reported: a sign, another point, a gain of a third.
pub(crate) fn check_functions(set: &FrfSet) -> Vec<Finding> {
    let is_dead = |i: &usize| set.values(*i).iter().all(|value| *value == Complex64::ZERO);
    let (dead, live): (Vec<usize>, Vec<usize>) = (0..set.len()).partition(is_dead);
    let location = |i: usize| Location::Function {
        response: Some(set.functions()[i].response.clone()),
        reference: Some(set.functions()[i].reference.clone()),
    };
    let live = set.part(&live);
    let live = live.motions();
    let mut findings: Vec<Finding> = sensor_scale::findings(&live);
    if let Some(data) = Mobilities::new(&live) {
        let signs = driving_point::findings(&data).into_iter();
        findings.extend(signs.filter(|finding| finding.value > Some(MAX_WRONG_SIGN_FRACTION)));
        for (pairs, code) in [
            (reciprocity::reciprocal(&data), Code::NotReciprocal),
            (repeatability::repeats(&data), Code::RepeatsDiffer),
        ] {
            let pairs = pairs.into_iter();
            findings.extend(pairs.filter_map(|(a, b)| gross_difference_finding(&data, a, b, code)));
        }
    }
    let dead = dead.into_iter();
    findings.extend(dead.map(|i| Finding::new(Severity::Warning, Code::DeadChannel, location(i))));
    findings
}

/// Largest fraction of driving-point peaks with the wrong sign that FRFs of unknown origin may
/// have.
const MAX_WRONG_SIGN_FRACTION: f64 = 0.5;

/// All checks of a set, in the valid band (the whole axis when the set does not know it).
///
/// The set itself is not changed. Nothing comes back for a set of less than the lines that one
/// resonance needs.
pub fn check_set(set: &FrfSet) -> Vec<Finding> {
    let set = &set.motions();
    let Some(data) = Mobilities::new(set) else {
        return Vec::new();
    };
    let checks = [
        driving_point::findings,
        reciprocity::findings,
        repeatability::findings,
        channel_delay::findings,
        mass_loading::findings,
    ];
    let mut findings: Vec<Finding> = checks.iter().flat_map(|check| check(&data)).collect();
    findings.extend(sensor_scale::findings(set));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use synthetic::{Beam, scaled};

    #[test]
    fn functions_of_unknown_origin_are_compared_with_each_other() {
        let pairs = [
            ("1:+Z", "1:+Z"),
            ("2:+Z", "1:+Z"),
            ("1:+Z", "2:+Z"),
            ("2:+Z#2", "1:+Z"),
        ];
        let sound = Beam::default().set(&pairs);
        assert_eq!(check_functions(&sound), []);
        for (function, ratio, expected) in [
            (0, -1.0, vec![Code::DrivingPointSign]),
            (2, -1.0, vec![Code::NotReciprocal]),
            (2, 1.5, vec![Code::NotReciprocal]),
            (3, -1.0, vec![Code::RepeatsDiffer]),
            (0, 0.0, vec![Code::DeadChannel]),
            (2, 0.0, vec![Code::DeadChannel]),
            (3, 1.1, vec![]),
        ] {
            let found = check_functions(&scaled(&sound, function, ratio));
            let codes: Vec<Code> = found.iter().map(|finding| finding.code).collect();
            assert_eq!(codes, expected, "{function} {ratio}");
        }
    }

    #[test]
    fn mains_and_noise_at_low_frequencies_are_no_difference_of_functions() {
        let pairs = [("1:+Z", "2:+Z"), ("2:+Z", "1:+Z"), ("2:+Z#2", "1:+Z")];
        let mut set = Beam::default().set(&pairs);
        for i in 0..set.len() {
            let peak = set.values(i).iter().map(|v| v.norm()).fold(0.0, f64::max);
            let values = set.values_mut(i);
            values[200] += 40.0 * peak * Complex64::cis(i as f64);
            for (k, value) in values.iter_mut().enumerate().take(40).skip(1) {
                *value += 5.0 * peak / (k * k) as f64 * Complex64::cis((i * k) as f64);
            }
        }
        assert_eq!(check_functions(&set), []);
    }
}
