//! Variance of an averaged FRF value from the scatter of its hits.

use num_complex::Complex64;

use super::coherence::coherence;
use super::sums::LineSums;

/// `E|H - E H|²` of the average over `n` hits, `|H|² (1 - γ²) / (γ² (n - 1))`; `None` for one hit.
///
/// For H1 this is the force-weighted scatter `Σ|X_i - H F_i|² / ((n - 1) Σ|F_i|²)`: a least-squares slope through
/// the origin with `n - 1` complex degrees of freedom, so that it is unbiased for noise on the responses of equal
/// power in every hit. Each of the real and imaginary part has half of it. Computed as `(1 - γ²) Gxx / (Gff (n - 1))`,
/// which holds where γ² = 0 too, times `|H|² / |H1|²`: to first order the same relative variance belongs to H2 and
/// Hv (regression of the force on the response has the same γ²).
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., chapter 9 (gain factor estimates): the normalised random error
/// `sqrt(1 - γ²) / (γ sqrt(2 n))` of the magnitude, whose square is half of this over `|H|²` for large `n`.
pub(super) fn variance(sums: &LineSums, value: Complex64, averages: usize) -> Option<f64> {
    if averages < 2 {
        return None;
    }
    let of_h1 = (1.0 - coherence(sums)) * sums.gxx / (sums.gff * (averages as f64 - 1.0));
    let h1 = sums.gfx.norm_sqr() / (sums.gff * sums.gff);
    let ratio = if h1 > 0.0 { value.norm_sqr() / h1 } else { 1.0 };
    Some(of_h1 * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::Estimator;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn hits() -> Vec<(Complex64, Complex64)> {
        let h = Complex64::new(-2.0, 0.5);
        (1..=6)
            .map(|n| {
                let n = f64::from(n);
                let force = Complex64::new(1.0 + 0.3 * n, -0.2 * n * n);
                let noise = Complex64::new((7.1 * n).sin(), (4.3 * n).cos());
                (force, h * force + 0.4 * noise)
            })
            .collect()
    }

    fn sums(hits: &[(Complex64, Complex64)]) -> LineSums {
        let mut sums = LineSums::default();
        hits.iter().for_each(|(f, x)| sums.add(*f, *x));
        sums
    }

    #[test]
    fn it_is_the_force_weighted_scatter_over_n_minus_one() {
        let hits = hits();
        let sums = sums(&hits);
        let h = sums.estimate(Estimator::H1, 0.0).unwrap();
        let scatter: f64 = hits
            .iter()
            .map(|(f, x)| f.norm_sqr() * (x / f - h).norm_sqr())
            .sum();
        let expected = scatter / (5.0 * sums.gff);
        let got = variance(&sums, h, 6).unwrap();
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} {expected}");
        let gamma_squared = coherence(&sums);
        let textbook = h.norm_sqr() * (1.0 - gamma_squared) / (gamma_squared * 5.0);
        assert!((got / textbook - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_variance_of_h2_has_its_own_magnitude() {
        let sums = sums(&hits());
        let (h1, h2) = (Estimator::H1, Estimator::H2);
        let value = |e| sums.estimate(e, 0.0).unwrap();
        let of = |e| variance(&sums, value(e), 6).unwrap() / value(e).norm_sqr();
        assert!((of(h2) / of(h1) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn on_average_it_is_the_scatter_of_the_estimate() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let h = Complex64::new(0.6, -1.1);
        let (mut scatter, mut stated) = (0.0, 0.0);
        let draws = 20_000;
        for _ in 0..draws {
            let mut sums = LineSums::default();
            for force in [1.0, 0.8, 1.3] {
                let noise = Complex64::new(normal(), normal());
                sums.add(force.into(), h * force + noise);
            }
            let estimate = sums.estimate(Estimator::H1, 0.0).unwrap();
            scatter += (estimate - h).norm_sqr() / f64::from(draws);
            stated += variance(&sums, estimate, 3).unwrap() / f64::from(draws);
        }
        // Noise power 2 over Gff = 3.33. Relative deviations of the two means: 1 and 1/sqrt(2) over sqrt(draws).
        let expected = 2.0 / 3.33;
        assert!((scatter / expected - 1.0).abs() < 4.0 * 0.0071);
        assert!((stated / expected - 1.0).abs() < 4.0 * 0.005);
    }

    #[test]
    fn one_hit_has_none_and_pure_noise_has_its_power() {
        let sums = LineSums {
            gff: 4.0,
            gxx: 6.0,
            gfx: Complex64::ZERO,
        };
        assert_eq!(variance(&sums, Complex64::ZERO, 1), None);
        let got = variance(&sums, Complex64::ZERO, 4).unwrap();
        assert!((got - 0.5).abs() < 1e-15);
    }
}
