//! A sensor of which all functions are a hundred times those of any other has another unit: its
//! sensitivity is in mV where V is meant, or its scale in mm instead of m.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;

/// Smallest ratio of the level of a response to the largest of the others that is reported. Larger:
/// a sensor in the wrong one of two units a thousand apart, whose point moves a fifth of the
/// liveliest one, is not seen. Smaller: an antenna or a thin panel on a heavy machine is reported
/// (`a_point_that_moves_thirty_times_the_others_is_no_wrong_unit`).
const MIN_RATIO: f64 = 100.0;
/// Responses without which there is nothing to compare with.
const MIN_RESPONSES: usize = 3;

/// A finding for each response whose level is far above that of all others.
pub(super) fn findings(set: &FrfSet) -> Vec<Finding> {
    let mut levels: BTreeMap<Dof, Vec<f64>> = BTreeMap::new();
    for (i, function) in set.functions().iter().enumerate() {
        let level = level(set, i);
        levels
            .entry(function.response.clone())
            .or_default()
            .push(level);
    }
    if levels.len() < MIN_RESPONSES {
        return Vec::new();
    }
    let largest = |levels: &[f64]| levels.iter().copied().fold(0.0, f64::max);
    let of_response: Vec<(Dof, f64)> = levels
        .into_iter()
        .map(|(dof, levels)| (dof, largest(&levels)))
        .collect();
    let mut findings = Vec::new();
    for (place, (dof, level)) in of_response.iter().enumerate() {
        let others = of_response
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != place);
        let next = others.map(|(_, (_, level))| *level).fold(0.0, f64::max);
        if next > 0.0 && *level >= MIN_RATIO * next {
            let location = Location::Function {
                response: Some(dof.clone()),
                reference: None,
            };
            let finding = Finding::new(Severity::Warning, Code::SensorScale, location);
            findings.push(finding.value(level / next, "times").limit(MIN_RATIO));
        }
    }
    findings
}

/// Root mean square of an FRF over its lines, as an accelerance.
fn level(set: &FrfSet, i: usize) -> f64 {
    let (axis, order) = (set.axis(), set.functions()[i].kind.derivative_order());
    let band = set.valid_band.or(axis.band());
    let lines = band.map_or(0..axis.len, |band| axis.lines(&band));
    let count = lines.len().max(1) as f64;
    let square = |k: usize| set.values(i)[k].norm_sqr() * axis.rad_s(k).powi(2 * (2 - order));
    (lines.map(square).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, scaled};

    const PAIRS: [(&str, &str); 4] = [
        ("1:+Z", "1:+Z"),
        ("2:+Z", "1:+Z"),
        ("3:+Z", "1:+Z"),
        ("4:+Z", "1:+Z"),
    ];

    #[test]
    fn a_sensor_a_thousand_times_off_is_named() {
        for function in 0..4 {
            let set = scaled(&Beam::default().set(&PAIRS), function, 1000.0);
            let found = findings(&set);
            assert_eq!(found.len(), 1);
            assert!(found[0].value > Some(300.0));
        }
    }

    #[test]
    fn a_point_that_moves_thirty_times_the_others_is_no_wrong_unit() {
        let set = Beam::default().set(&PAIRS);
        assert_eq!(findings(&set), []);
        assert_eq!(findings(&scaled(&set, 2, 30.0)), []);
        assert_eq!(findings(&scaled(&set, 2, 1e-3)), []);
    }
}
