//! The chance level is the MAC that independent shapes reach at these sensors.
//!
//! A test shape that is independent of the theory has no direction among `n` degrees of freedom.
//! Its MAC with the subspace of a root of multiplicity `m` is then distributed as `Beta(β m/2, β (n
//! − m)/2)`: `β = 1` of real shapes, 2 of complex ones without a common phase, `β = 2/(1 + c²)`
//! with `c = |ψᵀψ|/ψᴴψ` between them (equal mean and variance).
//!
//! Frequency and shape together: of `k` roots within the frequency gate the one of rank `r` in
//! distance has the significance `α (k + 1)/(k r (r + 1))`. The sum over all of them is `α` for any
//! frequencies, and the nearest root needs the lowest MAC.

use num_complex::Complex64;
use statrs::distribution::{Beta, ContinuousCDF};

/// Significance level of a pair by shape: the probability that an independent test shape reaches
/// the chance level with any root within the frequency gate. Larger: at 0.03 more than 1 % of the
/// random shapes on five sensors pair (`random_shapes_do_not_pair_by_shape`). Smaller: at 0.005 six
/// sensors lose 27 instead of 22 % of the close modes of a frame with stiffnesses that are 20 %
/// wrong (`correlated_shapes_pair_by_shape` draws the structures).
const SIGNIFICANCE: f64 = 0.01;

/// The same where most other modes of the test reach the level of [`SIGNIFICANCE`], so that test
/// and theory are of one machine. Larger: a stray mode among them is paired more often than 1 in 20
/// (`stray_shape_among_correlated_ones_rarely_pairs`). Smaller: at 0.01 frames lose 6 of 231 right
/// pairs (`correlated_shapes_pair_by_shape`), and of machines with unequal masses 8.3 % of the
/// clear modes are ambiguous where the population `pairing` allows 8 %.
const SIGNIFICANCE_AMONG_CORRELATED: f64 = 0.05;

/// Minimum number of common degrees of freedom for a pair by shape; those that move alike in every
/// mode of the theory are one. Larger: a pair of exact shapes
/// at three sensors, 1 in 100 by chance, counts as one by frequency. Smaller: at two the level is
/// 0.9998, and no measured pair reaches it.
pub(super) const MIN_DOFS_OF_SHAPE: usize = 3;

/// The MAC that a pair has to reach: independent shapes do so with any root within the frequency
/// gate in 1 of 100 cases, or in 5 where most other modes of the test are correlated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChanceLevel {
    /// The level.
    pub mac: f64,
    /// Number of common degrees of freedom, those that move alike in every mode of the theory once.
    pub dofs: usize,
    /// Effective number of degrees of freedom; smaller where some hardly move in any mode.
    pub effective_dofs: f64,
    /// Roots of the theory within the frequency gate of the test mode.
    pub roots: usize,
    /// Rank of the root among them by its distance in frequency, from 1.
    pub rank: usize,
    /// Probability that an independent shape reaches the level of any of them.
    pub significance: f64,
}

/// Quantities besides the shapes that determine the chance level of a pair.
pub(super) struct ChanceSetting {
    /// Number of common degrees of freedom, those that move alike in every mode once.
    pub dofs: usize,
    /// Effective degrees of freedom over their number.
    pub effective_fraction: f64,
    /// Roots within the frequency gate.
    pub roots: usize,
    /// Rank of the root among them by the distance in frequency, from 1.
    pub rank: usize,
    /// Whether most other modes of the test reach their levels.
    pub others_correlate: bool,
}

impl ChanceLevel {
    /// The level of a pair, of the test shape and the shapes of the root at the common degrees of
    /// freedom.
    ///
    /// # Reference
    /// Muirhead (1982), Aspects of Multivariate Statistical Theory, theorem 1.5.7 (squared cosine
    /// of a random direction).
    pub(super) fn new(
        test: &[Complex64],
        root: &[Vec<Complex64>],
        setting: &ChanceSetting,
    ) -> Self {
        let dofs = setting.dofs;
        let effective_dofs = setting.effective_fraction * dofs as f64;
        let multiplicity = root.len() as f64;
        let of_root = root.iter().map(|shape| components(shape));
        let beta = components(test).max(of_root.fold(2.0, f64::min));
        let (inside, outside) = (
            0.5 * beta * multiplicity,
            0.5 * beta * (effective_dofs - multiplicity),
        );
        let (k, r) = (setting.roots.max(1) as f64, setting.rank.max(1) as f64);
        let significance = match setting.others_correlate {
            true => SIGNIFICANCE_AMONG_CORRELATED,
            false => SIGNIFICANCE,
        };
        let reached = significance * (k + 1.0) / (k * r * (r + 1.0));
        // Without a degree of freedom more than the root has modes, every shape is one of the root.
        let level = match Beta::new(inside, outside) {
            Ok(distribution) if outside > 0.0 => distribution.inverse_cdf(1.0 - reached),
            _ => 1.0,
        };
        Self {
            mac: level,
            dofs,
            effective_dofs,
            roots: setting.roots,
            rank: setting.rank,
            significance,
        }
    }
}

/// Independent real components per degree of freedom, β: 1 of a shape of one phase, 2 of one whose
/// phases are random.
fn components(shape: &[Complex64]) -> f64 {
    let squared: f64 = shape.iter().map(Complex64::norm_sqr).sum();
    let unconjugated: Complex64 = shape.iter().map(|v| v * v).sum();
    let collinearity = unconjugated.norm() / squared.max(f64::MIN_POSITIVE);
    2.0 / (1.0 + collinearity.min(1.0).powi(2))
}

/// Effective degrees of freedom of shapes over their number, up to 1: `1/(n ⟨w_i · w_j⟩)`, the mean
/// over all pairs of different modes, with `w_id = |φ_id|²/Σ_d |φ_id|²`.
///
/// For independent shapes of random signs `w_i · w_j` is the mean of their MAC, `1/n` where all
/// sensors move alike. Of one shape it is `(3/(w · w) − 2)/n`, since `w · w` of a normal one has
/// the mean `3/(n + 2)`.
pub(super) fn effective_dof_fraction(shapes: &[Vec<Option<Complex64>>]) -> f64 {
    let count = shapes.first().map_or(0, Vec::len);
    let mut sum = vec![0.0; count];
    let (mut diagonal, mut modes) = (0.0, 0.0);
    for shape in shapes {
        let square = |d: usize| shape[d].map_or(0.0, |value| value.norm_sqr());
        let length: f64 = (0..count).map(square).sum();
        if length <= 0.0 {
            continue;
        }
        modes += 1.0;
        for (d, sum) in sum.iter_mut().enumerate() {
            let weight = square(d) / length;
            *sum += weight;
            diagonal += weight * weight;
        }
    }
    let effective = if modes < 2.0 {
        3.0 / diagonal - 2.0
    } else {
        let products = sum.iter().map(|value| value * value).sum::<f64>() - diagonal;
        modes * (modes - 1.0) / products.max(0.0)
    };
    (effective / count.max(1) as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(shape: &[Complex64], multiplicity: usize, (roots, rank): (usize, usize)) -> f64 {
        let unit = |at: usize| {
            let value = |d: usize| f64::from(u8::from(d == at)).into();
            (0..shape.len()).map(value).collect::<Vec<Complex64>>()
        };
        let root: Vec<_> = (0..multiplicity).map(unit).collect();
        let setting = ChanceSetting {
            dofs: shape.len(),
            effective_fraction: 1.0,
            roots,
            rank,
            others_correlate: false,
        };
        ChanceLevel::new(shape, &root, &setting).mac
    }

    fn real(count: usize) -> Vec<Complex64> {
        (0..count).map(|d| (1.0 + d as f64).into()).collect()
    }

    #[test]
    fn chance_level_is_the_quantile_of_the_beta_distribution() {
        // Beta(1/2, 5/2) at 0.99, from Student's t of 5 degrees of freedom at 0.995:
        // 4.0321²/(4.0321² + 5).
        assert!((level(&real(6), 1, (1, 1)) - 0.764_8).abs() < 1e-4);
        // Of three degrees of freedom MAC is the square of a uniform variable.
        assert!((level(&real(3), 1, (1, 1)) - 0.99f64.powi(2)).abs() < 1e-9);
        // Complex, n = 6: 1 − 0.01^(1/5). A double root of real shapes: 1 − 0.01^(1/2).
        let phases: Vec<Complex64> = (0..6).map(|d| Complex64::cis(f64::from(d) * 2.0)).collect();
        let complex = components(&phases);
        assert!((1.9..=2.0).contains(&complex), "{complex}");
        let turns: Vec<Complex64> = (0..6)
            .map(|d| Complex64::cis(f64::from(d) * 0.5 * std::f64::consts::PI / 1.5))
            .collect();
        assert!((level(&turns, 1, (1, 1)) - (1.0 - 0.01f64.powf(0.2))).abs() < 1e-9);
        assert!((level(&real(6), 2, (1, 1)) - (1.0 - 0.01f64.powf(0.5))).abs() < 1e-9);
        // As many modes as degrees of freedom hold every shape.
        assert!((level(&real(3), 3, (1, 1)) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn probabilities_over_the_roots_in_reach_add_up_to_the_significance() {
        // Of three degrees of freedom a level is reached with a probability of 1 − √level.
        for roots in [1, 2, 7] {
            let sum: f64 = (1..=roots)
                .map(|rank| 1.0 - level(&real(3), 1, (roots, rank)).sqrt())
                .sum();
            assert!((sum - SIGNIFICANCE).abs() < 1e-9, "{roots}: {sum}");
        }
        assert!(level(&real(6), 1, (5, 1)) < level(&real(6), 1, (5, 2)));
    }

    #[test]
    fn sensors_that_hardly_move_are_no_effective_degrees_of_freedom() {
        let sine = |mode: usize, small: f64| -> Vec<Option<Complex64>> {
            let value =
                |d: usize| ((d as f64 + 0.5) * mode as f64 * std::f64::consts::PI / 8.0).sin();
            let weight = |d: usize| if d < 8 { 1.0 } else { small };
            (0..16)
                .map(|d| Some((weight(d) * value(d)).into()))
                .collect()
        };
        let all: Vec<_> = (1..6).map(|mode| sine(mode, 1.0)).collect();
        assert!(
            effective_dof_fraction(&all) > 0.95,
            "{}",
            effective_dof_fraction(&all)
        );
        let half: Vec<_> = (1..6).map(|mode| sine(mode, 1e-3)).collect();
        assert!(
            (effective_dof_fraction(&half) - 0.5).abs() < 0.03,
            "{}",
            effective_dof_fraction(&half)
        );
        assert!(effective_dof_fraction(&half[..1]) < 0.95);
        assert!((effective_dof_fraction(&[]) - 1.0).abs() < 1e-15);
    }
}
