//! Modes of test and theory agree by shape where their frequencies differ too much for a pair.

use crate::finding::{Code, Finding, Location, Severity};

use super::global_stiffness_factor::MacTable;

/// Minimum MAC of a test mode with the root that has its shape. Larger, at 0.98: sensors that are a
/// few percent off hide the agreement. Smaller, at 0.8: neighbouring modes of a beam at few points
/// agree. Test `shapes_that_agree_at_other_frequencies_are_named`.
const MIN_MAC: f64 = 0.9;

/// Maximum MAC of that test mode with any other root. Larger, at 0.9: two roots have the shape.
/// Smaller, at 0.3: the neighbouring modes of a beam at five points hide the agreement. Test
/// `shapes_that_two_roots_have_are_not_named`.
const MAX_MAC_OF_OTHERS: f64 = 0.6;

/// Minimum number of different degrees of freedom of such a MAC. Larger, at 9: the points of a
/// short test do not suffice. Smaller, at 3: independent shapes reach 0.9 in one of 20 cases, at
/// five in one of 250. Test `shapes_at_few_points_are_not_named`.
const MIN_DOFS: usize = 5;

/// Minimum number of such modes, of one test mode that one. Larger, at 3: a test of two modes of a
/// model of other dimensions shows nothing. Smaller, at 1: one agreement is by chance. Test
/// `shapes_that_agree_at_other_frequencies_are_named`.
const MIN_MODES: usize = 2;

/// A test mode that has the shape of a root at another frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeMatch {
    /// Frequency of the test mode, Hz.
    pub test_hz: f64,
    /// Index of the elastic root of the theory, from the lowest.
    pub root: usize,
    /// Its frequency, Hz.
    pub root_hz: f64,
    /// MAC of the two.
    pub mac: f64,
}

impl ShapeMatch {
    /// Frequency of the test over that of the theory.
    pub fn ratio(&self) -> f64 {
        self.test_hz / self.root_hz
    }
}

/// The mean ratio of the frequencies of test and theory; `None` without a match.
pub fn mean_ratio(matches: &[ShapeMatch]) -> Option<f64> {
    let logarithms = matches.iter().map(|one| one.ratio().ln());
    let count = matches.len() as f64;
    (!matches.is_empty()).then(|| (logarithms.sum::<f64>() / count).exp())
}

/// The test modes with the shape of one root alone, whose ratios of frequency differ from their
/// median by no more than the frequency gate; none unless there are enough of them. Of the roots
/// the lowest count, as many as there are degrees of freedom: these do not tell a higher one from
/// them.
pub(super) fn shape_matches(table: &MacTable, distinct_dofs: usize) -> Vec<ShapeMatch> {
    if distinct_dofs < MIN_DOFS {
        return Vec::new();
    }
    let rows = table.mac.iter().zip(&table.test_hz);
    let found = rows.filter_map(|(row, test_hz)| {
        let (root, mac) = only_root(&row[..row.len().min(distinct_dofs)])?;
        let (root_hz, _) = table.roots[root];
        Some(ShapeMatch {
            test_hz: *test_hz,
            root,
            root_hz,
            mac,
        })
    });
    let mut found: Vec<ShapeMatch> = found.collect();
    let claims: Vec<usize> = found.iter().map(|one| one.root).collect();
    let is_alone = |one: &ShapeMatch| {
        let count = claims.iter().filter(|root| **root == one.root).count();
        count <= table.roots[one.root].1
    };
    found.retain(is_alone);
    let mut ratios: Vec<f64> = found.iter().map(ShapeMatch::ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let Some(median) = ratios.get(ratios.len() / 2).copied() else {
        return Vec::new();
    };
    found.retain(|one| (one.ratio() / median - 1.0).abs() <= table.gate);
    if found.len() < MIN_MODES.min(table.test_hz.len()) {
        found.clear();
    }
    found
}

/// The only root that has the shape of a test mode, with the MAC.
fn only_root(row: &[Option<f64>]) -> Option<(usize, f64)> {
    let known = row.iter().enumerate();
    let known = known.filter_map(|(root, mac)| Some((root, (*mac)?)));
    let (root, mac) = known.clone().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut others = known.filter(|(other, _)| *other != root);
    let is_only = others.all(|(_, mac)| mac <= MAX_MAC_OF_OTHERS);
    (mac >= MIN_MAC && is_only).then_some((root, mac))
}

/// The finding on shapes that agree where no mode is paired.
pub(super) fn shapes_agree_finding(matches: &[ShapeMatch]) -> Option<Finding> {
    let ratio = mean_ratio(matches)?;
    let named = |one: &ShapeMatch| {
        format!(
            "{:.2} Hz as {:.2} Hz of the model (MAC {:.3})",
            one.test_hz, one.root_hz, one.mac
        )
    };
    let mut named: Vec<String> = matches.iter().map(named).collect();
    let further = named.len().saturating_sub(MAX_NAMED);
    named.truncate(MAX_NAMED);
    named.extend((further > 0).then(|| format!("{further} more")));
    let finding = Finding::new(Severity::Warning, Code::ShapesAgree, Location::Whole);
    Some(finding.value(ratio, "").detail(named.join(", ")))
}

/// Maximum number of modes that a detail names.
const MAX_NAMED: usize = 1;

#[cfg(test)]
mod tests {
    use super::super::pairing_tests::{mode, model, paired, shape};
    use super::*;
    use crate::modal::ModalModel;

    fn modes(factor: f64, points: usize) -> ModalModel {
        let of = |number: usize| mode(100.0 * factor * number as f64, &shape(number)[..points]);
        model([1, 2, 4].map(of).to_vec())
    }

    #[test]
    fn shapes_that_agree_at_other_frequencies_are_named() {
        let pairing = paired(&modes(2.5, 6), &modes(1.0, 6));
        assert!(pairing.pairs.is_empty());
        let found = &pairing.by_shape_alone;
        assert_eq!(
            found.iter().map(|one| one.root).collect::<Vec<_>>(),
            [0, 1, 2]
        );
        assert!((mean_ratio(found).unwrap() - 2.5).abs() < 1e-9);
        let mut findings = pairing.findings.iter();
        let finding = findings.find(|finding| finding.code == Code::ShapesAgree);
        let detail = finding.unwrap().detail.as_deref().unwrap();
        assert!(
            detail.starts_with("250.00 Hz as 100.00 Hz of the model (MAC 1.000), 2 more"),
            "{detail}"
        );
        // One of several is no evidence; the only one is.
        let mut one = modes(2.5, 6);
        one.modes.truncate(1);
        assert_eq!(paired(&one, &modes(1.0, 6)).by_shape_alone.len(), 1);
        one.modes
            .push(mode(400.0, &[1.0, 0.2, -0.7, 0.4, 0.9, -0.3]));
        assert!(paired(&one, &modes(1.0, 6)).by_shape_alone.is_empty());
        // Ratios of the frequencies that differ show no common cause.
        let mut apart = modes(2.5, 6);
        apart.modes.truncate(2);
        apart.modes[1].frequency_hz = 1500.0;
        assert!(paired(&apart, &modes(1.0, 6)).by_shape_alone.is_empty());
    }

    #[test]
    fn paired_modes_name_no_other_shapes() {
        assert!(
            paired(&modes(1.05, 6), &modes(1.0, 6))
                .by_shape_alone
                .is_empty()
        );
    }

    #[test]
    fn shapes_that_two_roots_have_are_not_named() {
        let mut theory = modes(1.0, 6);
        assert_eq!(paired(&modes(2.5, 6), &theory).by_shape_alone.len(), 3);
        let both = shape(1).into_iter().zip(shape(2));
        let mixed: Vec<f64> = both.map(|(one, other)| one + 0.4 * other).collect();
        theory.modes[1].shape = mode(1.0, &mixed).shape;
        assert!(paired(&modes(2.5, 6), &theory).by_shape_alone.is_empty());
    }

    #[test]
    fn shapes_at_few_points_are_not_named() {
        assert!(
            paired(&modes(2.5, 4), &modes(1.0, 4))
                .by_shape_alone
                .is_empty()
        );
    }
}
