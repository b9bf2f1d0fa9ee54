//! The global stiffness factor would pair modes of similar shape that differ too much in frequency.

use crate::finding::{Code, Finding, Location, Severity};

/// Minimum MAC of a test mode with a root that is its partner at any frequency.
const CLEAR_MAC: f64 = 0.8;
/// Minimum difference of that MAC to the MAC with any other root.
const CLEAR_OF_OTHERS: f64 = 0.3;
/// Minimum number of test modes that show a common factor: any two modes do.
const MIN_TEST_MODES: usize = 3;
/// Minimum fraction of all test modes that the factor has to pair.
const MIN_FRACTION_OF_TEST_MODES: f64 = 0.6;

/// Factors on all stiffnesses of a model with one wrong unit, what may have been written, and the
/// largest ratio to the factor.
///
/// N/mm, MPa and GPa for N/m and Pa make a model too soft, g for kg too heavy; t for kg makes it
/// too light. A frequency in rad/s that is read as Hz is 2π times as high.
const UNIT_FACTORS: [(f64, &str, f64); 6] = [
    (
        1e3,
        "about 1000: stiffnesses in N/mm, moduli in kPa or masses in g?",
        MAX_RATIO_TO_UNIT_FACTOR,
    ),
    (1e6, "about 1e6: moduli in MPa?", MAX_RATIO_TO_UNIT_FACTOR),
    (1e9, "about 1e9: moduli in GPa?", MAX_RATIO_TO_UNIT_FACTOR),
    (
        1e-3,
        "about 1/1000: masses in t, or densities in g/cm³?",
        MAX_RATIO_TO_UNIT_FACTOR,
    ),
    (
        RAD_PER_CYCLE_SQUARED,
        "about (2 pi)^2: frequencies of the test in rad/s?",
        MAX_RATIO_TO_RAD,
    ),
    (
        1.0 / RAD_PER_CYCLE_SQUARED,
        "about 1/(2 pi)^2: frequencies of the model in rad/s?",
        MAX_RATIO_TO_RAD,
    ),
];
const RAD_PER_CYCLE_SQUARED: f64 = std::f64::consts::TAU * std::f64::consts::TAU;
/// Largest ratio of a factor to one of these: other errors of the model that come with it.
///
/// Smaller (1.1): a model with a wrong unit that is 20 % too stiff besides is not recognised.
/// Larger (4): a factor of 300 is a wrong unit. Test: `a_factor_of_a_wrong_unit_is_recognised`.
const MAX_RATIO_TO_UNIT_FACTOR: f64 = 1.5;

/// The same for frequencies in rad/s, 15 %: a factor of 30 to 50 has other causes more often. Test:
/// the same.
const MAX_RATIO_TO_RAD: f64 = 1.15;

/// What unit may be wrong, of a factor on all stiffnesses.
fn wrong_unit(factor: f64) -> Option<&'static str> {
    let mut units = UNIT_FACTORS.iter();
    let near = units.find(|(unit, _, most)| (factor / unit).ln().abs() <= most.ln());
    near.map(|(_, text, _)| *text)
}

/// Test modes (rows) against roots of the theory (columns).
pub(super) struct MacTable {
    /// Frequencies of the test modes, Hz.
    pub test_hz: Vec<f64>,
    /// Frequencies of the roots, Hz, and how many modes share each.
    pub roots: Vec<(f64, usize)>,
    /// MAC of every test mode (row) with every root.
    pub mac: Vec<Vec<Option<f64>>>,
    /// Largest relative frequency error of a pair.
    pub gate: f64,
}

/// The factor as a finding, for a test of which no more than half of the modes are `paired`.
///
/// Each test mode with a MAC of 0.8 or more with one root, 0.3 above all others, gives a ratio of
/// frequencies `r`. Where three of them or more, and six tenths of all test modes, lie within the
/// gate about their median, and the mean lies beyond it, the factor on all stiffnesses is
/// `exp(2 mean ln r)`. Its standard deviation is that from mode to mode.
pub(super) fn global_stiffness_factor(table: &MacTable, paired: usize) -> Option<Finding> {
    let count = table.test_hz.len();
    if 2 * paired > count {
        return None;
    }
    let mut ratios = clear_ratios(table);
    ratios.sort_by(f64::total_cmp);
    let median = *ratios.get(ratios.len() / 2)?;
    ratios.retain(|ratio| ((ratio - median).exp() - 1.0).abs() <= table.gate);
    let kept = ratios.len() as f64;
    if ratios.len() < MIN_TEST_MODES || kept < MIN_FRACTION_OF_TEST_MODES * count as f64 {
        return None;
    }
    let mean = ratios.iter().sum::<f64>() / kept;
    let squares: f64 = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum();
    let std = (squares / (kept - 1.0)).sqrt();
    let factor = (2.0 * mean).exp();
    if (mean.exp() - 1.0).abs() <= table.gate {
        return None;
    }
    let finding = Finding::new(Severity::Warning, Code::CommonFactor, Location::Whole);
    let finding = finding.value(factor, "").limit(2.0 * std * factor);
    Some(match wrong_unit(factor) {
        Some(unit) => finding.detail(unit),
        None => finding,
    })
}

/// `ln(test / theory)` of the frequencies of all test modes that correlate with one root only.
fn clear_ratios(table: &MacTable) -> Vec<f64> {
    let chosen: Vec<Option<usize>> = table.mac.iter().map(|row| clear_root(row)).collect();
    let rows = chosen.iter().zip(&table.test_hz);
    let ratio = |(root, hz): (&Option<usize>, &f64)| {
        let root = (*root)?;
        let (root_hz, modes) = table.roots[root];
        let claims = chosen.iter().filter(|other| **other == Some(root)).count();
        (claims <= modes).then(|| (hz / root_hz).ln())
    };
    rows.filter_map(ratio).collect()
}

/// The only root that a test mode correlates with.
pub(super) fn clear_root(row: &[Option<f64>]) -> Option<usize> {
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

    fn reported_factor(test: &ModalModel, theory: &ModalModel) -> Option<Finding> {
        let findings = paired(test, theory).findings;
        findings
            .into_iter()
            .find(|finding| finding.code == Code::CommonFactor)
    }

    #[test]
    fn stiffness_factor_of_a_much_too_soft_model_is_reported() {
        let (test, theory) = (modes(1.0, [0.0; 5]), modes(0.36, [0.0; 5]));
        assert!(paired(&test, &theory).pairs.is_empty());
        let exact = reported_factor(&test, &theory).expect("a factor is reported");
        assert!(
            (exact.value.expect("the finding has a value") * 0.36 - 1.0).abs() < 1e-12
                && exact.limit.expect("the finding has a limit") < 1e-9
        );
        // Frequencies that scatter by 1 % make 2 % of the factor from mode to mode.
        let deviations = [0.01, -0.01, 0.01, -0.01, 0.0];
        let finding = reported_factor(&modes(1.0, deviations), &theory).unwrap();
        assert!(
            (finding.value.expect("the finding has a value") * 0.36 - 1.0).abs() < 0.01,
            "{finding}"
        );
        let spread = finding.limit.expect("the finding has a limit")
            / finding.value.expect("the finding has a value");
        assert!((spread - 0.02).abs() < 1e-4, "{spread}");
        assert!(finding.to_string().contains("(2.778 ± 0.056)"), "{finding}");
    }

    #[test]
    fn a_factor_of_a_wrong_unit_is_recognised() {
        let detail = |stiffness: f64| {
            let found = reported_factor(&modes(1.0, [0.0; 5]), &modes(stiffness, [0.0; 5]));
            found.expect("a factor is reported").detail
        };
        let tau = std::f64::consts::TAU;
        for (stiffness, part) in [
            (1e-3, "N/mm"),
            (1.2e-3, "N/mm"),
            (0.8e-6, "MPa"),
            (1e-9, "GPa"),
            (1e3, "in t"),
            (tau.powi(-2), "test in rad/s"),
            (tau.powi(2), "model in rad/s"),
        ] {
            let found = detail(stiffness).unwrap_or_default();
            assert!(found.contains(part), "{stiffness}: {found}");
        }
        for stiffness in [0.36, 1.0 / 300.0, 100.0, 1.0 / 30.0] {
            assert_eq!(detail(stiffness), None, "{stiffness}");
        }
    }

    #[test]
    fn no_factor_is_reported_for_paired_modes_or_without_a_common_ratio() {
        let theory = modes(0.36, [0.0; 5]);
        assert_eq!(reported_factor(&modes(0.34, [0.0; 5]), &theory), None);
        // The factors of the modes differ.
        assert_eq!(
            reported_factor(&modes(1.0, [0.0, 0.9, -0.6, 2.0, -0.3]), &theory),
            None
        );
        // Two of five modes have a partner by shape.
        let mut other = modes(1.0, [0.0; 5]);
        for changed in &mut other.modes[2..] {
            changed.shape = mode(1.0, &[1.0, 0.2, -0.7, 0.4, 0.9, -0.3]).shape;
        }
        assert_eq!(reported_factor(&other, &theory), None);
        // Without shapes the modes cannot be assigned.
        let bare = |stiffness: f64| {
            let mut set = modes(stiffness, [0.0; 5]);
            set.modes
                .iter_mut()
                .for_each(|set| set.shape = mode(1.0, &[]).shape);
            set
        };
        assert_eq!(reported_factor(&bare(1.0), &bare(0.36)), None);
    }
}
