//! Scatter between tests is what the frequencies of one root differ by from test to test of one
//! configuration, beyond their standard deviations: between reassemblies of a machine.
//!
//! With the logarithms `y` of the frequencies of each root in `k` tests, their relative variances
//! `s^2` and weights `w = 1/s^2`, the sum `Q = sum w (y - mean y)^2` has the expectation `nu +
//! tau^2 C` with `nu = sum (k - 1)` and `C = sum (sum w - sum w^2/sum w)` over the roots. The
//! variance `tau^2` of the scatter is `(Q - nu)/C`, and 0 where noise explains `Q`. Without
//! standard deviations it is the pooled variance of `y`. The scatter is taken as independent
//! between roots, as the same fraction of all frequencies, and as that of each configuration.
//!
//! # Reference
//! DerSimonian and Laird (1986), Meta-analysis in clinical trials, Controlled Clinical Trials 7,
//! 177, section 2.

use serde::{Deserialize, Serialize};

use super::evaluate::max_chi_square;
use super::{RootPair, Target};

/// Scatter of the natural frequencies between tests of one configuration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Standard deviation, a fraction of the frequency.
    pub relative_std: f64,
    /// Degrees of freedom that it is estimated from.
    pub degrees_of_freedom: usize,
}

/// A frequency of one test: its logarithm and relative variance.
type Logarithm = (f64, f64);

/// Scatter between the tests of each configuration, of all configurations together; `None` where no
/// root is measured by two tests of a configuration.
pub(super) fn scatter(targets: &[Target], root_pairs: &[RootPair]) -> Option<Scatter> {
    let roots = roots(root_pairs, targets);
    let degrees_of_freedom = roots.iter().map(|root| root.len() - 1).sum();
    (degrees_of_freedom > 0).then(|| Scatter {
        relative_std: variance(&roots).sqrt(),
        degrees_of_freedom,
    })
}

/// The mean frequency of each root of the model in each test.
fn roots(root_pairs: &[RootPair], targets: &[Target]) -> Vec<Vec<Logarithm>> {
    let mut roots: Vec<(&RootPair, Vec<Logarithm>)> = Vec::new();
    for root_pair in root_pairs {
        let count = root_pair.targets.len() as f64;
        let targets = || root_pair.targets.iter().map(|&t| &targets[t]);
        let logarithm = targets().map(|target| target.hz.ln()).sum::<f64>() / count;
        let variances = targets().map(|target| {
            let std = target.hz_std.unwrap_or(0.0) / target.hz;
            std * std
        });
        let one = (logarithm, variances.sum::<f64>() / (count * count));
        let is_same = |other: &RootPair| {
            (other.configuration, &other.modes) == (root_pair.configuration, &root_pair.modes)
        };
        match roots.iter_mut().find(|(other, _)| is_same(other)) {
            Some((_, tests)) => tests.push(one),
            None => roots.push((root_pair, vec![one])),
        }
    }
    roots.into_iter().map(|(_, tests)| tests).collect()
}

/// `tau^2`.
fn variance(roots: &[Vec<Logarithm>]) -> f64 {
    let states_all = roots.iter().flatten().all(|(_, variance)| *variance > 0.0);
    let weight = |variance: f64| if states_all { 1.0 / variance } else { 1.0 };
    let (mut q, mut nu, mut c) = (0.0, 0.0, 0.0);
    for root in roots {
        let sum = |of: &dyn Fn(&Logarithm) -> f64| root.iter().map(of).sum::<f64>();
        let weights = sum(&|one| weight(one.1));
        let mean = sum(&|one| weight(one.1) * one.0) / weights;
        q += sum(&|one| weight(one.1) * (one.0 - mean).powi(2));
        c += weights - sum(&|one| weight(one.1).powi(2)) / weights;
        nu += root.len() as f64 - 1.0;
    }
    if !states_all {
        return q / nu;
    }
    match q > max_chi_square(nu) {
        true => (q - nu) / c,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_without_standard_deviations_is_the_pooled_variance() {
        let roots = [
            vec![(1.0, 0.0), (1.2, 0.0), (1.1, 0.0)],
            vec![(3.0, 0.0), (3.4, 0.0)],
            vec![(5.0, 0.0)],
        ];
        // (0.01 + 0.01 + 0 + 0.04 + 0.04)/3.
        assert!((variance(&roots) - 0.1 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn scatter_is_what_the_standard_deviations_do_not_explain() {
        let roots = |variance: f64| {
            [
                vec![(1.00, variance), (1.02, variance)],
                vec![(2.00, variance), (2.04, variance)],
                vec![(3.00, variance), (2.97, variance)],
            ]
        };
        // Equal weights: the pooled variance less that of a frequency.
        let pooled = (0.0002 + 0.0008 + 0.00045) / 3.0;
        assert!((variance(&roots(1e-5)) - (pooled - 1e-5)).abs() < 1e-12);
        assert!(variance(&roots(4e-4)) <= 0.0);
    }
}
