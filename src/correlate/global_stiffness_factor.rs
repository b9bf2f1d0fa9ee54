//! One factor on all stiffnesses that would pair what lies too far apart in frequency.

use crate::finding::{Code, Finding, Place, Severity};

/// Least MAC of a test mode with the root that is its partner whatever their frequencies.
const CLEAR_MAC: f64 = 0.8;
/// By how much that exceeds the MAC with any other root.
const CLEAR_OF_OTHERS: f64 = 0.3;
/// Fewest modes that show a factor: any two have one.
const FEWEST: usize = 3;
/// Part of all test modes that the factor has to pair.
const MOST: f64 = 0.6;

/// Test modes against roots of the theory.
pub(super) struct Unlike<'a> {
    /// Frequencies of the test modes, Hz.
    pub test_hz: &'a [f64],
    /// Frequencies of the roots, Hz, and how many modes share each.
    pub roots: &'a [(f64, usize)],
    /// MAC of every test mode (row) with every root.
    pub mac: &'a [Vec<Option<f64>>],
    /// Largest relative frequency error of a pair.
    pub gate: f64,
}

/// The factor as a finding, for a test of which no more than half of the modes are `paired`.
///
/// Each test mode that is like one root alone, with a MAC of 0.8 or more and 0.3 above all others,
/// gives a ratio of frequencies `r`. Where three of them or more, and six tenths of all test modes,
/// lie within the gate about their median, and the mean itself is beyond it, all stiffnesses times
/// `exp(2 mean ln r)` would bring them together. The spread is the standard deviation of that
/// factor from mode to mode.
pub(super) fn common_factor(own: &Unlike<'_>, paired: usize) -> Option<Finding> {
    let count = own.test_hz.len();
    if 2 * paired > count {
        return None;
    }
    let mut ratios = clear_ratios(own);
    ratios.sort_by(f64::total_cmp);
    let median = *ratios.get(ratios.len() / 2)?;
    ratios.retain(|ratio| ((ratio - median).exp() - 1.0).abs() <= own.gate);
    let kept = ratios.len() as f64;
    if ratios.len() < FEWEST || kept < MOST * count as f64 {
        return None;
    }
    let mean = ratios.iter().sum::<f64>() / kept;
    let squares: f64 = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum();
    let std = (squares / (kept - 1.0)).sqrt();
    let factor = (2.0 * mean).exp();
    let finding = Finding::new(Severity::Warning, Code::CommonFactor, Place::Whole);
    let beyond = (mean.exp() - 1.0).abs() > own.gate;
    beyond.then(|| finding.value(factor, "").limit(2.0 * std * factor))
}

/// `ln(test / theory)` of the frequencies of all test modes that are like one root alone.
fn clear_ratios(own: &Unlike<'_>) -> Vec<f64> {
    let chosen: Vec<Option<usize>> = own.mac.iter().map(|row| clear_root(row)).collect();
    let rows = chosen.iter().zip(own.test_hz);
    let ratio = |(root, hz): (&Option<usize>, &f64)| {
        let root = (*root)?;
        let (root_hz, modes) = own.roots[root];
        let claims = chosen.iter().filter(|other| **other == Some(root)).count();
        (claims <= modes).then(|| (hz / root_hz).ln())
    };
    rows.filter_map(ratio).collect()
}

/// The only root that a test mode is like.
fn clear_root(row: &[Option<f64>]) -> Option<usize> {
    let known = row.iter().enumerate();
    let known = known.filter_map(|(root, mac)| Some((root, (*mac)?)));
    let (root, best) = known.clone().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut others = known.filter(|(other, _)| *other != root);
    let alone = others.all(|(_, mac)| mac <= best - CLEAR_OF_OTHERS);
    (best >= CLEAR_MAC && alone).then_some(root)
}

#[cfg(test)]
mod tests {
    use super::super::pairing_tests::{mode, model, paired, shape};
    use super::*;
    use crate::modal::ModalModel;

    /// Modes 1 to 5 with frequencies that a factor on stiffness and a deviation of each make of
    /// 100, 200, ... Hz.
    fn modes(stiffness: f64, deviations: [f64; 5]) -> ModalModel {
        let all = (1u32..).zip(deviations);
        model(
            all.map(|(number, deviation)| {
                let hz = 100.0 * f64::from(number) * stiffness.sqrt() * (1.0 + deviation);
                mode(hz, &shape(number as usize))
            })
            .collect(),
        )
    }

    fn told(test: &ModalModel, theory: &ModalModel) -> Option<Finding> {
        let findings = paired(test, theory).findings;
        findings
            .into_iter()
            .find(|own| own.code == Code::CommonFactor)
    }

    #[test]
    fn a_model_that_is_much_too_soft_has_its_factor_told() {
        let (test, theory) = (modes(1.0, [0.0; 5]), modes(0.36, [0.0; 5]));
        assert!(paired(&test, &theory).pairs.is_empty());
        let own = told(&test, &theory).expect("the factor is told");
        assert!(
            (own.value.expect("the finding has a value") * 0.36 - 1.0).abs() < 1e-12
                && own.limit.expect("the finding has a limit") < 1e-9
        );
        // Frequencies that scatter by 1 % make 2 % of the factor from mode to mode.
        let deviations = [0.01, -0.01, 0.01, -0.01, 0.0];
        let own = told(&modes(1.0, deviations), &theory).unwrap();
        assert!(
            (own.value.expect("the finding has a value") * 0.36 - 1.0).abs() < 0.01,
            "{own}"
        );
        let spread = own.limit.expect("the finding has a limit")
            / own.value.expect("the finding has a value");
        assert!((spread - 0.02).abs() < 1e-4, "{spread}");
        assert!(own.to_string().contains("(2.778 ± 0.056)"), "{own}");
    }

    #[test]
    fn what_pairs_as_it_is_and_what_no_factor_pairs_has_none() {
        let theory = modes(0.36, [0.0; 5]);
        assert_eq!(told(&modes(0.34, [0.0; 5]), &theory), None);
        // Each mode is off by a factor of its own.
        assert_eq!(
            told(&modes(1.0, [0.0, 0.9, -0.6, 2.0, -0.3]), &theory),
            None
        );
        // Two of five modes have a partner by shape.
        let mut other = modes(1.0, [0.0; 5]);
        for own in &mut other.modes[2..] {
            own.shape = mode(1.0, &[1.0, 0.2, -0.7, 0.4, 0.9, -0.3]).shape;
        }
        assert_eq!(told(&other, &theory), None);
        // Without shapes nothing tells which modes belong together.
        let bare = |stiffness: f64| {
            let mut own = modes(stiffness, [0.0; 5]);
            own.modes
                .iter_mut()
                .for_each(|own| own.shape = mode(1.0, &[]).shape);
            own
        };
        assert_eq!(told(&bare(1.0), &bare(0.36)), None);
    }
}
