//! Variance of an averaged FRF value: from the scatter of its hits, or from the noise before them.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::linalg::vectorised;

use super::spectra_sums::{LineSums, Sums};

/// Up to so many hits the scatter of one line says little, and neighbouring lines are pooled: with
/// three hits a line has four degrees of freedom, and its stated deviation is off by a third.
const MAX_HITS_POOLED: usize = 3;

/// Lines that are pooled: the noise of a sensor, unlike a resonance, does not change within so few.
const POOLED_LINES: usize = 5;

/// Mean expected energies of the noise under the windows of a function's hits; per line of the
/// spectrum, that is the noise's power too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NoisePowers {
    /// Of the response; `None` without pre-trigger samples.
    pub response: Option<f64>,
    /// Of the force.
    pub force: Option<f64>,
    /// Pre-trigger samples of the response.
    pub samples: usize,
}

/// Variances of all lines of a function.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variances {
    /// One per line, SI unit squared.
    pub values: Vec<f64>,
    /// Degrees of freedom of each, real numbers.
    pub degrees_of_freedom: f64,
}

/// An averaged function whose variances are wanted.
pub(super) struct Averaged<'a> {
    pub sums: &'a Sums,
    pub values: &'a [Complex64],
    /// Whether the values are H1.
    pub is_h1: bool,
    /// γ² of each line; of one hit none is needed.
    pub coherence: &'a [f64],
    /// Number of hits.
    pub averages: usize,
}

/// Variance of every line with its degrees of freedom; `pooled_lines` are the [`independent_lines`]
/// of the window.
///
/// - More than three hits: the scatter of each line ([`scatter`]), 2(n − 1) degrees of freedom.
/// - Two or three: the residual power `(1 − γ²) Gxx` of five neighbouring lines is pooled before it
///   is divided by `Gff (n − 1)`; degrees of freedom 2(n − 1) times the lines, fewer where a window
///   makes neighbours alike.
/// - One: `(Sxx + |H|² Sff) / |F|²` with the white noise found before the hit; `None` where that is
///   not known.
pub(super) fn variances(
    averaged: &Averaged,
    pooled_lines: f64,
    noise: &NoisePowers,
) -> Option<Variances> {
    let freedom = averaged.averages as f64 - 1.0;
    match averaged.averages {
        0 => None,
        1 => {
            let (response, force) = (noise.response?, noise.force?);
            let of = |(sums, value): (LineSums, &Complex64)| {
                (response + value.norm_sqr() * force) / sums.gff
            };
            Some(Variances {
                values: averaged.sums.iter().zip(averaged.values).map(of).collect(),
                degrees_of_freedom: noise.samples as f64 - 1.0,
            })
        }
        averages if averages <= MAX_HITS_POOLED && averaged.values.len() > POOLED_LINES + 2 => {
            let lines = averaged.sums.iter().zip(averaged.coherence);
            let powers: Vec<f64> = lines
                .map(|(sums, coherence)| residual_power(sums, *coherence))
                .collect();
            let lines = averaged.sums.iter().zip(pooled_powers(&powers));
            let mut values: Vec<f64> = lines
                .map(|(sums, power)| power / (sums.gff * freedom))
                .collect();
            averaged.scale(&mut values);
            Some(Variances {
                values,
                degrees_of_freedom: 2.0 * freedom * pooled_lines,
            })
        }
        _ => Some(Variances {
            values: averaged.scatters(freedom),
            degrees_of_freedom: 2.0 * freedom,
        }),
    }
}

impl Averaged<'_> {
    /// [`scatter`] of every line.
    fn scatters(&self, freedom: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.values.len()];
        vectorised(
            #[inline(always)]
            || {
                let lines = self.sums.iter().zip(self.coherence);
                for (place, (sums, coherence)) in out.iter_mut().zip(lines) {
                    *place = scatter(sums, *coherence, freedom);
                }
            },
        );
        self.scale(&mut out);
        out
    }

    /// Takes variances of H1 to those of the values.
    fn scale(&self, variances: &mut [f64]) {
        if !self.is_h1 {
            let lines = self.sums.iter().zip(self.values);
            for (variance, (sums, value)) in variances.iter_mut().zip(lines) {
                *variance *= power_over_h1(sums, *value);
            }
        }
    }
}

/// `E|H1 - E H1|²` of the average over `n` hits, `|H1|² (1 - γ²) / (γ² (n - 1))`, with `freedom` n
/// − 1.
///
/// This is the force-weighted scatter `Σ|X_i - H F_i|² / ((n - 1) Σ|F_i|²)`: a least-squares slope
/// through the origin with `n - 1` complex degrees of freedom, so that it is unbiased for noise on
/// the responses of equal power in every hit. Each of the real and imaginary part has half of it.
/// Computed as `(1 - γ²) Gxx / (Gff (n - 1))`, which holds where γ² = 0 too. For H2 and Hv it is
/// taken times `|H|² / |H1|²`: to first order the same relative variance belongs to them
/// (regression of the force on the response has the same γ²).
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., chapter 9 (gain factor estimates): the
/// normalised random error `sqrt(1 - γ²) / (γ sqrt(2 n))` of the magnitude, whose square is half of
/// this over `|H|²` for large `n`.
#[inline]
fn scatter(sums: LineSums, coherence: f64, freedom: f64) -> f64 {
    residual_power(sums, coherence) / (sums.gff * freedom)
}

/// `(1 − γ²) Gxx`: the power of the response that the force does not explain, times n.
#[inline]
fn residual_power(sums: LineSums, coherence: f64) -> f64 {
    (1.0 - coherence) * sums.gxx
}

/// `|H|² / |H1|²`; 1 where H1 is 0.
fn power_over_h1(sums: LineSums, value: Complex64) -> f64 {
    let h1 = sums.gfx.norm_sqr() / (sums.gff * sums.gff);
    if h1 > 0.0 { value.norm_sqr() / h1 } else { 1.0 }
}

/// Mean over the neighbours of each line, as many at the ends, where they lie on one side. The
/// first and the last line are real, with half the degrees of freedom, and the first holds the
/// offsets: they are in no mean.
fn pooled_powers(powers: &[f64]) -> impl Iterator<Item = f64> {
    let last = powers.len() - POOLED_LINES - 1;
    (0..powers.len()).map(move |line| {
        let first = line.saturating_sub(POOLED_LINES / 2).clamp(1, last);
        powers[first..first + POOLED_LINES].iter().sum::<f64>() / POOLED_LINES as f64
    })
}

/// How many of the pooled lines count: `K² / Σ ρ²(i − j)`, with the squared correlation ρ² of white
/// noise under the window between lines that far apart, `|Σ w² e^{−2πimn/N}|² / (Σ w²)²`.
pub(super) fn independent_lines(weights: Option<&[f64]>) -> f64 {
    let Some(weights) = weights else {
        return POOLED_LINES as f64;
    };
    let correlation = |apart: usize| {
        let turn = -TAU * apart as f64 / weights.len() as f64;
        let terms = weights.iter().enumerate();
        let sum: Complex64 = terms
            .map(|(n, w)| w * w * Complex64::cis(turn * n as f64))
            .sum();
        sum.norm_sqr()
    };
    let alone = correlation(0);
    let pairs = |apart: usize| {
        if apart == 0 {
            POOLED_LINES
        } else {
            2 * (POOLED_LINES - apart)
        }
    };
    let alike: f64 = (0..POOLED_LINES)
        .map(|apart| pairs(apart) as f64 * correlation(apart) / alone)
        .sum();
    (POOLED_LINES * POOLED_LINES) as f64 / alike
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::Estimator;
    use crate::frf::coherence::coherence;
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

    /// Variances of lines with these sums.
    fn of_lines(
        lines: &[LineSums],
        (estimator, averages): (Estimator, usize),
        noise: &NoisePowers,
    ) -> Option<Variances> {
        let values = lines.iter().map(|sums| sums.estimate(estimator, 0.0));
        let values: Vec<Complex64> = values.collect::<Result<_, _>>().unwrap();
        let coherence: Vec<f64> = lines.iter().map(|sums| coherence(*sums)).collect();
        let averaged = Averaged {
            sums: &Sums::from(lines),
            values: &values,
            is_h1: estimator == Estimator::H1,
            coherence: &coherence,
            averages,
        };
        variances(&averaged, 5.0, noise)
    }

    /// Variance of one line of more than three hits.
    fn of_line(sums: LineSums, estimator: Estimator, averages: usize) -> f64 {
        of_lines(&[sums], (estimator, averages), &UNKNOWN)
            .unwrap()
            .values[0]
    }

    #[test]
    fn it_is_the_force_weighted_scatter_over_n_minus_one() {
        let hits = hits();
        let sums = sums(&hits);
        let h = sums.estimate(Estimator::H1, 0.0).unwrap();
        let by_hit: f64 = hits
            .iter()
            .map(|(f, x)| f.norm_sqr() * (x / f - h).norm_sqr())
            .sum();
        let expected = by_hit / (5.0 * sums.gff);
        let got = of_line(sums, Estimator::H1, 6);
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} {expected}");
        let gamma_squared = coherence(sums);
        let textbook = h.norm_sqr() * (1.0 - gamma_squared) / (gamma_squared * 5.0);
        assert!((got / textbook - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_variance_of_h2_scales_with_the_magnitude_of_h2() {
        let sums = sums(&hits());
        let (h1, h2) = (Estimator::H1, Estimator::H2);
        let value = |e| sums.estimate(e, 0.0).unwrap();
        let of = |e| of_line(sums, e, 6) / value(e).norm_sqr();
        assert!((of(h2) / of(h1) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn on_average_it_is_the_scatter_of_the_estimate() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let h = Complex64::new(0.6, -1.1);
        let (mut observed, mut stated) = (0.0, 0.0);
        let draws = 20_000;
        for _ in 0..draws {
            let mut sums = LineSums::default();
            for force in [1.0, 0.8, 1.3] {
                let noise = Complex64::new(normal(), normal());
                sums.add(force.into(), h * force + noise);
            }
            let estimate = sums.estimate(Estimator::H1, 0.0).unwrap();
            observed += (estimate - h).norm_sqr() / f64::from(draws);
            stated += scatter(sums, coherence(sums), 2.0) / f64::from(draws);
        }
        // Noise power 2 over Gff = 3.33. Relative deviations of the two means: 1 and 1/sqrt(2) over
        // sqrt(draws).
        let expected = 2.0 / 3.33;
        assert!((observed / expected - 1.0).abs() < 4.0 * 0.0071);
        assert!((stated / expected - 1.0).abs() < 4.0 * 0.005);
    }

    #[test]
    fn pure_noise_has_its_power() {
        let sums = LineSums {
            gff: 4.0,
            gxx: 6.0,
            gfx: Complex64::ZERO,
        };
        assert!((of_line(sums, Estimator::H1, 4) - 0.5).abs() < 1e-15);
    }

    const UNKNOWN: NoisePowers = NoisePowers {
        response: None,
        force: None,
        samples: 0,
    };

    #[test]
    fn the_variance_of_one_hit_comes_from_pretrigger_noise_or_is_absent() {
        let sums = LineSums {
            gff: 4.0,
            gxx: 36.0,
            gfx: Complex64::new(12.0, 0.0),
        };
        let one = |noise: &NoisePowers| of_lines(&[sums], (Estimator::H1, 1), noise);
        assert_eq!(one(&UNKNOWN), None);
        let noise = NoisePowers {
            response: Some(0.02),
            force: Some(0.01),
            samples: 51,
        };
        let single = one(&noise).unwrap();
        assert!((single.values[0] - (0.02 + 9.0 * 0.01) / 4.0).abs() < 1e-15);
        assert!((single.degrees_of_freedom - 50.0).abs() < 1e-12);
    }

    #[test]
    fn few_hits_pool_neighbouring_lines_and_state_degrees_of_freedom() {
        let sums: Vec<LineSums> = (0..20)
            .map(|line| LineSums {
                gff: 2.0,
                gxx: 1.0 + f64::from(line % 2),
                gfx: Complex64::ZERO,
            })
            .collect();
        let of = |averages| of_lines(&sums, (Estimator::H1, averages), &UNKNOWN).unwrap();
        let few = of(3);
        // Residual powers 1 2 1 2 1 about an even line, 2 1 2 1 2 about an odd one.
        assert!((few.values[10] - 7.0 / 5.0 / 4.0).abs() < 1e-15);
        assert!((few.values[11] - 8.0 / 5.0 / 4.0).abs() < 1e-15);
        // The first line is in no mean: lines 1 to 5 stand for it.
        assert!((few.values[0] - few.values[3]).abs() < 1e-15);
        assert!((few.degrees_of_freedom - 20.0).abs() < 1e-12);
        let many = of(4);
        assert!((many.values[11] - 2.0 / (2.0 * 3.0)).abs() < 1e-15);
        assert!((many.degrees_of_freedom - 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_window_makes_neighbours_alike() {
        assert!((independent_lines(Some(&[1.0; 64])) - 5.0).abs() < 1e-9);
        // A window that leaves a tenth of the record widens each line by ten: nearly one
        // independent line.
        let short: Vec<f64> = (0..640).map(|n| f64::from(n < 64)).collect();
        let lines = independent_lines(Some(&short));
        assert!((1.0..1.3).contains(&lines), "{lines}");
    }
}
