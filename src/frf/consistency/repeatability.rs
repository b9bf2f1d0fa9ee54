//! The same pair measured twice: `#2` against the first, or the sensor turned round.

use crate::finding::{Code, Finding};

use super::discrepancy::difference_finding;
use super::mobility::Mobilities;

/// Relative difference of two measurements of one pair: the calibration of one channel, about 5 %,
/// when the second was made with another sensor; the same sensor repeats better.
pub(super) const LIMIT: f64 = 0.05;

/// Every further measurement of a pair against the first one.
pub(super) fn findings(data: &Mobilities) -> Vec<Finding> {
    let pairs = repeats(data).into_iter();
    pairs
        .filter_map(|(a, b)| difference_finding(data, a, b, Code::RepeatsDiffer, LIMIT))
        .collect()
}

/// Every further measurement of a pair with the first one, by their numbers.
pub(super) fn repeats(data: &Mobilities) -> Vec<(usize, usize)> {
    let pairs = data.functions_by_dofs();
    let of = |functions: &Vec<usize>| {
        let first = functions[0];
        functions[1..].iter().map(|other| (first, *other)).collect()
    };
    let pairs: Vec<Vec<(usize, usize)>> = pairs.values().map(of).collect();
    pairs.concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, scaled};

    #[test]
    fn the_deviating_repeated_measurement_is_reported() {
        let pairs = [
            ("2:+Z", "1:+Z"),
            ("2:+Z#2", "1:+Z"),
            ("2:-Z", "1:+Z"),
            ("3:+Z", "1:+Z"),
        ];
        let set = Beam::default().set(&pairs);
        let found = |set: &crate::frf::FrfSet| findings(&Mobilities::new(set).unwrap());
        assert!(found(&set).is_empty());
        assert!(found(&scaled(&set, 1, 1.04)).is_empty());
        let changed = found(&scaled(&set, 1, 1.1));
        assert_eq!(changed.len(), 1);
        assert_eq!(changed[0].location.to_string(), "2:+Z#2|1:+Z");
        let expected = 0.1 * f64::sqrt(2.0 / (1.0 + 1.21));
        assert!((changed[0].value.unwrap() / expected - 1.0).abs() < 0.01);
    }
}
