//! Maxwell's reciprocity: response at i to a force at j is response at j to a force at i.

use crate::finding::{Code, Finding};

use super::discrepancy::difference_finding;
use super::mobility::Mobilities;

/// Relative difference of two reciprocal functions: hammer and accelerometer are each calibrated to
/// about 5 %, and two positions have two pairs of them at worst.
pub(super) const LIMIT: f64 = 0.1;

/// `H_ij` against `H_ji` for every pair of which both are there, directions turned; the first
/// measurement of each.
pub(super) fn findings(data: &Mobilities) -> Vec<Finding> {
    let pairs = reciprocal(data).into_iter();
    pairs
        .filter_map(|(a, b)| difference_finding(data, a, b, Code::NotReciprocal, LIMIT))
        .collect()
}

/// Pairs of functions that should be one by reciprocity, by their numbers.
pub(super) fn reciprocal(data: &Mobilities) -> Vec<(usize, usize)> {
    let pairs = data.functions_by_dofs();
    let upper = pairs.iter().filter(|((i, j), _)| i < j);
    upper
        .filter_map(|((i, j), upper_frfs)| {
            let lower_frfs = pairs.get(&(j.clone(), i.clone()))?;
            Some((upper_frfs[0], lower_frfs[0]))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, add_noise, scaled};

    fn found(set: &crate::frf::FrfSet) -> Vec<f64> {
        let found = findings(&Mobilities::new(set).unwrap());
        found.iter().filter_map(|f| f.value).collect()
    }

    #[test]
    fn reciprocal_frfs_agree_for_any_dof_signs() {
        let set = Beam::default().set(&[("1:+Z", "2:-Z"), ("2:+Z", "1:+Z"), ("3:+Z", "1:+Z")]);
        assert!(found(&set).is_empty());
    }

    #[test]
    fn a_gain_and_a_sign_have_their_value() {
        let set = Beam::default().set(&[("1:+Z", "2:+Z"), ("2:+Z", "1:+Z")]);
        for ratio in [1.2, 0.7, -1.0] {
            let values = found(&scaled(&set, 1, ratio));
            let expected = (1.0 - ratio).abs() * f64::sqrt(2.0 / (1.0 + ratio * ratio));
            // The roughness of values without stated variance is taken off as noise: less than 1 %
            // here.
            assert!(
                (values[0] / expected - 1.0).abs() < 0.01,
                "{values:?} {expected}"
            );
        }
        assert!(found(&scaled(&set, 1, 1.05)).is_empty());
    }

    #[test]
    fn a_difference_is_measured_through_noise() {
        let set = Beam::default().set(&[("1:+Z", "2:+Z"), ("2:+Z", "1:+Z")]);
        let mut set = scaled(&set, 1, 1.3);
        add_noise(&mut set, 10.0, 4);
        let values = found(&set);
        let expected = 0.3 * f64::sqrt(2.0 / (1.0 + 1.69));
        assert!((values[0] - expected).abs() < 0.03, "{values:?} {expected}");
    }

    #[test]
    fn frfs_between_other_points_are_not_reciprocal() {
        let mut set = Beam::default().set(&[("1:+Z", "2:+Z")]);
        let other = Beam::default().relabelled(("3:+Z", "1:+Z"), ("2:+Z", "1:+Z"));
        let data = crate::frf::FunctionData {
            values: other.values(0).to_vec(),
            ..Default::default()
        };
        set.push(other.functions()[0].clone(), data).unwrap();
        assert!(found(&set)[0] > 0.5);
    }
}
