//! Labels of a test that the shapes contradict: two frequencies exchanged, points numbered from the
//! other end.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::dof::Axis;
use crate::finding::{Code, Finding, Location, Severity};

use super::DofMap;
use super::global_stiffness_factor::{MacTable, clear_root};
use super::shapes::Shapes;
use super::subspace::subspace_mac;

/// Largest difference `|ln r|` of exchanged frequencies from those of the model, over the smallest
/// difference as labelled. Larger, at 0.7: two modes that the model has 21 and 30 % off count as
/// exchanged. Smaller, at 0.05: an exchange in a model that is 2 % off is missed. Test
/// `exchanged_frequencies_are_named_and_errors_of_a_model_are_not`.
const MAX_EXCHANGED_RATIO: f64 = 0.4;
/// Smallest mean MAC of the test modes with their best root where the points are numbered in
/// reverse. Larger, at 0.95: noise of a fifth of the largest component hides the order, with a mean
/// of 0.91. Smaller, at 0.8: smooth random shapes at seven points, unrelated to those of the model,
/// pass in 1.5 % of 4,000 cases (0.4 % at 0.9). Test
/// `points_numbered_from_the_other_end_are_named`.
const MIN_REVERSED_MAC: f64 = 0.9;
/// Smallest gain of that mean over the order as labelled. Larger, at 0.4: the four lowest modes of
/// a cantilever, whose mean is 0.64 as labelled, are missed. Smaller, at 0.004: noise of a tenth
/// decides the order of a structure that is nearly symmetric. Test
/// `points_numbered_from_the_other_end_are_named`.
const MIN_MAC_GAIN: f64 = 0.2;
/// Fewest test modes and points of a direction that show an order: two shapes at three points agree
/// by chance.
const MIN_MODES_AND_POINTS: usize = 3;

/// Pairs of test modes whose frequencies belong to each other's shapes: each has the shape of one
/// root alone, which is outside the frequency gate, and the frequency of the root that the other
/// has the shape of. Within the gate the model may have the two roots in the other order.
pub(super) fn exchanged_frequencies(table: &MacTable) -> Vec<Finding> {
    let root: Vec<Option<usize>> = table.mac.iter().map(|row| clear_root(row)).collect();
    let distance =
        |test: usize, root: usize| (table.test_hz[test] / table.roots[root].0).ln().abs();
    let mut findings = Vec::new();
    for i in 0..root.len() {
        for j in i + 1..root.len() {
            let (Some(a), Some(b)) = (root[i], root[j]) else {
                continue;
            };
            let labelled = distance(i, a).min(distance(j, b));
            let exchanged = distance(i, b).max(distance(j, a));
            let is_beyond = labelled > table.gate.ln_1p();
            if a != b && is_beyond && exchanged < MAX_EXCHANGED_RATIO * labelled {
                let location = Location::Mode(table.test_hz[i]);
                let finding = Finding::new(Severity::Warning, Code::FrequenciesExchanged, location);
                findings.push(finding.value(table.test_hz[j], "Hz"));
            }
        }
    }
    findings
}

/// The finding on a test whose shapes agree with the model once the points of each direction are
/// numbered in reverse.
pub(super) fn reversed_order(shapes: &Shapes, map: &DofMap) -> Option<Finding> {
    let order = reversed_places(map);
    let labelled: Vec<usize> = (0..map.pairs.len()).collect();
    if order == labelled || shapes.test.len() < MIN_MODES_AND_POINTS {
        return None;
    }
    let before = mean_largest_mac(shapes, &labelled)?;
    if before > 1.0 - MIN_MAC_GAIN {
        return None;
    }
    let reversed = mean_largest_mac(shapes, &order)?;
    let agrees = reversed >= MIN_REVERSED_MAC && reversed - before >= MIN_MAC_GAIN;
    let finding = Finding::new(Severity::Warning, Code::PointsReversed, Location::Whole);
    agrees.then(|| finding.value(reversed, "").limit(before))
}

/// For each common degree of freedom the one of the same direction at the other end of the list.
fn reversed_places(map: &DofMap) -> Vec<usize> {
    let mut by_axis: BTreeMap<Axis, Vec<usize>> = BTreeMap::new();
    for (place, pair) in map.pairs.iter().enumerate() {
        by_axis.entry(pair.test.axis()).or_default().push(place);
    }
    let mut order: Vec<usize> = (0..map.pairs.len()).collect();
    let long = by_axis
        .values()
        .filter(|places| places.len() > MIN_MODES_AND_POINTS);
    for places in long {
        for (place, other) in places.iter().zip(places.iter().rev()) {
            order[*place] = *other;
        }
    }
    order
}

/// Mean over the test modes of the largest MAC with a mode of the theory, with the test's values in
/// an order of the degrees of freedom; `None` without a shape.
fn mean_largest_mac(shapes: &Shapes, order: &[usize]) -> Option<f64> {
    let largest = |test: &Vec<Option<Complex64>>| -> Option<f64> {
        let of_theory = |theory: &Vec<Option<Complex64>>| {
            let pairs = order.iter().zip(theory);
            let both = pairs.filter_map(|(place, theory)| Some((test[*place]?, (*theory)?)));
            let (test, theory): (Vec<Complex64>, Vec<Complex64>) = both.unzip();
            subspace_mac(&test, &[theory])
        };
        shapes.theory.iter().filter_map(of_theory).reduce(f64::max)
    };
    let all: Vec<f64> = shapes.test.iter().filter_map(largest).collect();
    (all.len() >= MIN_MODES_AND_POINTS).then(|| all.iter().sum::<f64>() / all.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::super::pairing_tests::{mode, model, paired};
    use super::*;
    use crate::modal::{ModalModel, ModeShape};

    /// Shapes of a cantilever-like row of seven points, at frequencies times factors.
    fn modes(factors: [f64; 4], reversed: bool) -> ModalModel {
        let of_mode = |(number, factor): (usize, f64)| {
            let value = |point: usize| {
                let x = (point + 1) as f64 / 7.0;
                x.powf(0.7) * (std::f64::consts::PI * (number as f64 + 0.5) * x).cos()
                    + 0.02 * ((7 * number + 3 * point) % 5) as f64
            };
            let mut shape: Vec<f64> = (0..7).map(value).collect();
            if reversed {
                shape.reverse();
            }
            mode(100.0 * (number + 1) as f64 * factor, &shape)
        };
        model((0..4).zip(factors).map(of_mode).collect())
    }

    fn codes(test: &ModalModel, theory: &ModalModel) -> Vec<Code> {
        let findings = paired(test, theory).findings.into_iter();
        let codes = findings.map(|finding| finding.code);
        codes
            .filter(|code| [Code::FrequenciesExchanged, Code::PointsReversed].contains(code))
            .collect()
    }

    /// Test modes that have the shapes of the roots in their order.
    fn exchanged(test_hz: &[f64], root_hz: &[f64]) -> Vec<f64> {
        let mac = |i: usize, j: usize| Some(if i == j { 0.99 } else { 0.1 });
        let table = MacTable {
            test_hz: test_hz.to_vec(),
            roots: root_hz.iter().map(|hz| (*hz, 1)).collect(),
            mac: (0..test_hz.len())
                .map(|i| (0..root_hz.len()).map(|j| mac(i, j)).collect())
                .collect(),
            gate: 0.1,
        };
        let findings = exchanged_frequencies(&table).into_iter();
        findings.filter_map(|finding| finding.value).collect()
    }

    #[test]
    fn exchanged_frequencies_are_named_and_errors_of_a_model_are_not() {
        // The value is the frequency of the other mode.
        assert_eq!(exchanged(&[120.0, 100.0], &[102.0, 122.4]), [100.0]);
        assert_eq!(exchanged(&[100.0, 120.0], &[102.0, 122.4]), [0.0; 0]);
        // Errors of a model: a common factor, 30 and 21 %, and two roots in the other order.
        assert_eq!(exchanged(&[100.0, 200.0], &[150.0, 300.0]), [0.0; 0]);
        assert_eq!(exchanged(&[100.0, 150.0], &[130.0, 118.0]), [0.0; 0]);
        assert_eq!(exchanged(&[100.0, 104.0], &[106.0, 98.0]), [0.0; 0]);
        let theory = modes([1.02, 0.98, 1.02, 1.0], false);
        let labels = modes([1.0, 1.5, 2.0 / 3.0, 1.0], false);
        assert_eq!(codes(&labels, &theory), [Code::FrequenciesExchanged]);
    }

    #[test]
    fn points_numbered_from_the_other_end_are_named() {
        let theory = modes([1.0; 4], false);
        let found = |test: &ModalModel| {
            let mut findings = paired(test, &theory).findings.into_iter();
            let finding = findings.find(|finding| finding.code == Code::PointsReversed)?;
            finding.value.zip(finding.limit)
        };
        let (value, limit) = found(&modes([1.0; 4], true)).expect("the order is named");
        assert!((value - 1.0).abs() < 1e-12, "{value}");
        assert!((0.6..0.7).contains(&limit), "{limit}");
        assert_eq!(found(&modes([1.0; 4], false)), None);
        // Noise of a fifth of the largest component.
        let mut noisy = modes([1.0; 4], true);
        for (n, mode) in noisy.modes.iter_mut().enumerate() {
            let error = |p: usize| 0.2 * (((5 * n + 3 * (6 - p)) % 7) as f64 / 3.0 - 1.0);
            let values = mode.shape.iter().enumerate();
            mode.shape = ModeShape::new(values.map(|(p, (dof, v))| (dof.clone(), v + error(p))));
        }
        let (value, _) = found(&noisy).expect("the order is named");
        assert!((0.9..0.95).contains(&value), "{value}");
        // Two modes at seven points show no order.
        let mut two = modes([1.0; 4], true);
        two.modes.truncate(2);
        assert_eq!(found(&two), None);
    }
}
