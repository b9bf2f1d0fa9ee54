//! Ordinary coherence of one line.

use super::sums::LineSums;

/// `γ² = |Gfx|² / (Gff Gxx)` in `[0, 1]`; rounding above 1 is taken off, and 0 where either power is 0.
///
/// With one average it is identically 1 and says nothing, so the stage leaves it out there.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., chapter 6 (single-input, single-output relationships).
#[inline]
pub(super) fn coherence(sums: LineSums) -> f64 {
    let power = sums.gff * sums.gxx;
    if power > 0.0 {
        (sums.gfx.norm_sqr() / power).min(1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;

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
