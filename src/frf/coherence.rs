//! Coherence of force and response from averaged spectra, and the variance of H1 from coherence and
//! number of averages.

use num_complex::Complex64;

use super::spectra_sums::LineSums;

/// Smallest coherence that a variance is computed from; lines below it get its variance, 10⁶
/// |H|²/(n − 1), which is finite.
const MIN_COHERENCE: f64 = 1e-6;

/// Coherence that noise alone gives with hundreds of averages.
const MAX_NOISE_COHERENCE: f64 = 1e-3;

/// `γ² = |Gfx|² / (Gff Gxx)` in `[0, 1]`; rounding above 1 is taken off, and 0 where either power
/// is 0.
///
/// With one average it is identically 1 and says nothing, so the stage leaves it out there.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., chapter 6 (single-input, single-output
/// relationships).
#[inline]
pub(super) fn coherence(sums: LineSums) -> f64 {
    let power = sums.gff * sums.gxx;
    if power > 0.0 {
        (sums.gfx.norm_sqr() / power).min(1.0)
    } else {
        0.0
    }
}

/// Variance of H1 at every line from its coherence and the number of averages, 2 or more: `|H|²(1 −
/// γ²)/(γ²(n − 1))`. Where there is hardly any coherence ([`MAX_NOISE_COHERENCE`]), `|H|²` is at
/// least its mean over the lines: a value that is 0 for want of a signal is not a sure one. A
/// coherence that is 1 as it was stored counts as half a [`storage_step`] below 1: no line is free
/// of noise beside others.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., table 9.6.
pub(crate) fn variance_from_coherence(
    values: &[Complex64],
    coherence: &[f64],
    averages: u32,
) -> Vec<f64> {
    let finite = values.iter().map(Complex64::norm_sqr);
    let finite: Vec<f64> = finite.filter(|power| power.is_finite()).collect();
    let mean = finite.iter().sum::<f64>() / finite.len().max(1) as f64;
    let highest = 1.0 - 0.5 * storage_step(coherence);
    let variance = |(h, g): (&Complex64, &f64)| {
        let gamma_squared = g.clamp(MIN_COHERENCE, highest);
        let least = if *g <= MAX_NOISE_COHERENCE { mean } else { 0.0 };
        let power = h.norm_sqr().max(least);
        power * (1.0 - gamma_squared) / (gamma_squared * f64::from(averages - 1))
    };
    values.iter().zip(coherence).map(variance).collect()
}

/// Decimals of a printed coherence: fewer count as 3, and more are finer than single precision.
const PRINTED_DECIMALS: std::ops::RangeInclusive<i32> = 3..=7;
/// Largest distance of a printed value from whole steps, in steps: what single precision leaves of
/// 3 decimals is 6e-5.
const MAX_STEP_DEVIATION: f64 = 1e-3;

/// Step in which a coherence is stored: that of its decimals, or of single precision; 0 in double
/// precision, and where it is 1 at every line.
fn storage_step(coherence: &[f64]) -> f64 {
    let below = || coherence.iter().filter(|g| **g < 1.0);
    if below().next().is_none() {
        return 0.0;
    }
    let is_printed = |decimals: &i32| {
        let scale = 10f64.powi(*decimals);
        below().all(|g| (g * scale - (g * scale).round()).abs() < MAX_STEP_DEVIATION)
    };
    if let Some(decimals) = PRINTED_DECIMALS.into_iter().find(is_printed) {
        return 10f64.powi(-decimals);
    }
    let is_single = |g: &f64| (*g - f64::from(*g as f32)).abs() <= 0.0;
    match below().all(is_single) {
        true => f64::from(f32::EPSILON),
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coherence_of_1_is_half_a_step_of_its_resolution_below_1() {
        let exact = [0.123_456_789_012, 0.999_999_912_345_678, 0.5];
        let printed = |decimals: i32| {
            let scale = 10f64.powi(decimals);
            exact.map(|g| (g * scale).round() / scale)
        };
        for (stored, step) in [
            (exact, 0.0),
            (printed(3), 1e-3),
            (printed(6), 1e-6),
            (exact.map(|g| f64::from(g as f32)), f64::from(f32::EPSILON)),
            ([1.0; 3], 0.0),
        ] {
            assert!((storage_step(&stored) - step).abs() < 1e-12, "{stored:?}");
        }
        let h = [Complex64::new(3.0, 4.0); 3];
        let variance = variance_from_coherence(&h, &printed(6), 3);
        assert!((variance[1] / (25.0 * 5e-7 / 2.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn hand_made_sums() {
        let sums = LineSums {
            gff: 14.0,
            gxx: 62.0,
            gfx: Complex64::new(0.0, 29.0),
        };
        assert!((coherence(sums) - 841.0 / 868.0).abs() < 1e-15);
        assert!(coherence(LineSums::default()).abs() < 1e-300);
    }

    #[test]
    fn coherence_gives_the_textbook_variance_and_never_an_infinite_one() {
        let h = [Complex64::new(3.0, 4.0); 4];
        let variance = variance_from_coherence(&h, &[0.8, 1.0, 0.0, 1.1], 3);
        assert!((variance[0] - 25.0 * 0.2 / (0.8 * 2.0)).abs() < 1e-12);
        assert!((variance[2] / 12.5e6 - 1.0).abs() < 1e-5, "{}", variance[2]);
        // Half a thousandth below 1.
        let expected = 25.0 * 5e-4 / (0.9995 * 2.0);
        assert!(
            [variance[1], variance[3]]
                .iter()
                .all(|v| (v / expected - 1.0).abs() < 1e-9)
        );
        let variance = variance_from_coherence(&h, &[1.0; 4], 3);
        assert!(variance.iter().all(|v| v.abs() < 1e-300));
        // Nothing coherent with the force, and nothing measured: the variance is that of the mean
        // of the others.
        let infinite = Complex64::new(f64::INFINITY, 0.0);
        let variance =
            variance_from_coherence(&[h[0], Complex64::ZERO, infinite], &[1.0, 0.0, 1.0], 3);
        assert!((variance[1] / 6.25e6 - 1.0).abs() < 1e-5, "{}", variance[1]);
        let variance = variance_from_coherence(&[h[0], Complex64::ZERO], &[1.0, 1e-4], 3);
        assert!((variance[1] / 6.25e4 - 1.0).abs() < 1e-3, "{}", variance[1]);
    }

    #[test]
    fn proportional_spectra_have_coherence_one_and_never_more() {
        let mut sums = LineSums::default();
        for n in 1..50 {
            let force = Complex64::new(0.1 * f64::from(n), 0.7 / f64::from(n));
            sums.add(force, Complex64::new(0.3, 0.9) * force);
            let gamma_squared = coherence(sums);
            assert!((1.0 - 1e-14..=1.0).contains(&gamma_squared));
        }
    }
}
