//! The averaged power and cross spectra of one line, and the three estimators made from them.
//!
//! `Gff = Σ|F|²`, `Gxx = Σ|X|²`, `Gfx = ΣF* X` over the hits of a pair, unscaled: every result is a
//! ratio.

use std::sync::Arc;

use num_complex::Complex64;

use crate::linalg::vectorised;

use super::Estimator;

/// Sums over hits at one line.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(super) struct LineSums {
    /// `Σ|F|²`.
    pub gff: f64,
    /// `Σ|X|²`.
    pub gxx: f64,
    /// `ΣF* X`.
    pub gfx: Complex64,
}

/// Why a line has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LineError {
    /// `Gff = 0`.
    NoForce,
    /// `Gfx = 0` where the estimator divides by it.
    NotCorrelated,
}

/// Lines whose sums stay in the nearest cache while several hits are added to them.
const LINES_AT_ONCE: usize = 128;

/// Sums over hits at every line.
#[derive(Default)]
pub(super) struct Sums {
    /// `Σ|F|²`, which functions of the same hits share.
    pub gff: Arc<[f64]>,
    /// `Σ|X|²`.
    pub gxx: Vec<f64>,
    /// `ΣF* X`.
    pub gfx: Vec<Complex64>,
    /// Whether responses are in the sums; without any they hold what was there before.
    begun: bool,
}

impl Sums {
    /// Starts again with no response; `Σ|F|²` is given when all of them are there.
    pub fn clear(&mut self, lines: usize) {
        self.gxx.resize(lines, 0.0);
        self.gfx.resize(lines, Complex64::ZERO);
        self.begun = false;
    }

    /// Adds the spectra of the force and the response of each of these hits, in order.
    pub fn add(&mut self, hits: &[(&[Complex64], &[Complex64])]) {
        let begun = std::mem::replace(&mut self.begun, true);
        vectorised(
            #[inline(always)]
            || {
                let gxx = self.gxx.chunks_mut(LINES_AT_ONCE);
                let gfx = self.gfx.chunks_mut(LINES_AT_ONCE);
                for (piece, (gxx, gfx)) in gxx.zip(gfx).enumerate() {
                    if !begun {
                        gxx.fill(0.0);
                        gfx.fill(Complex64::ZERO);
                    }
                    let first = piece * LINES_AT_ONCE;
                    let lines = first..first + gxx.len();
                    for (force, response) in hits {
                        add_lines(gxx, gfx, &force[lines.clone()], &response[lines.clone()]);
                    }
                }
            },
        );
    }

    /// The sums of each line.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = LineSums> {
        let sums = self.gff.iter().zip(&self.gxx).zip(&self.gfx);
        sums.map(|((gff, gxx), gfx)| LineSums {
            gff: *gff,
            gxx: *gxx,
            gfx: *gfx,
        })
    }

    /// One number of each line.
    pub fn each(&self, of: impl Fn(LineSums) -> f64) -> Vec<f64> {
        let mut out = vec![0.0; self.gff.len()];
        vectorised(
            #[inline(always)]
            || {
                let lines = out.iter_mut().zip(self.iter());
                lines.for_each(|(place, line)| *place = of(line));
            },
        );
        out
    }

    /// The estimate at every line; of the first line without one its number and the reason.
    pub fn estimates(
        &self,
        estimator: Estimator,
        kappa: f64,
    ) -> Result<Vec<Complex64>, (usize, LineError)> {
        if estimator == Estimator::H1 && self.gff.iter().all(|gff| *gff > 0.0) {
            return Ok(self.h1());
        }
        let value = |(line, sums): (usize, LineSums)| {
            sums.estimate(estimator, kappa)
                .map_err(|error| (line, error))
        };
        self.iter().enumerate().map(value).collect()
    }

    /// H1 of lines that all have a force, as [`LineSums::estimate`].
    fn h1(&self) -> Vec<Complex64> {
        let mut values = vec![Complex64::ZERO; self.gff.len()];
        vectorised(
            #[inline(always)]
            || {
                let lines = values.iter_mut().zip(self.gff.iter().zip(&self.gfx));
                lines.for_each(|(value, (gff, gfx))| *value = gfx / gff);
            },
        );
        values
    }
}

#[inline(always)]
fn add_lines(gxx: &mut [f64], gfx: &mut [Complex64], force: &[Complex64], response: &[Complex64]) {
    let spectra = force.iter().zip(response);
    for ((gxx, gfx), (f, x)) in gxx.iter_mut().zip(gfx).zip(spectra) {
        *gxx += x.re * x.re + x.im * x.im;
        gfx.re += f.re * x.re + f.im * x.im;
        gfx.im += f.re * x.im - f.im * x.re;
    }
}

#[cfg(test)]
impl From<&[LineSums]> for Sums {
    fn from(lines: &[LineSums]) -> Self {
        Self {
            gff: lines.iter().map(|line| line.gff).collect(),
            gxx: lines.iter().map(|line| line.gxx).collect(),
            gfx: lines.iter().map(|line| line.gfx).collect(),
            begun: true,
        }
    }
}

impl LineSums {
    /// Adds one hit.
    #[cfg(test)]
    pub fn add(&mut self, force: Complex64, response: Complex64) {
        self.gff += force.norm_sqr();
        self.gxx += response.norm_sqr();
        self.gfx += force.conj() * response;
    }

    /// The estimate; `kappa` is used by Hv alone.
    ///
    /// A response of exactly 0 in every hit gives 0 with each estimator. Otherwise a line without
    /// force has no value, and neither have H2 and Hv where force and response are not correlated
    /// at all.
    pub fn estimate(&self, estimator: Estimator, kappa: f64) -> Result<Complex64, LineError> {
        if self.gff <= 0.0 {
            return Err(LineError::NoForce);
        }
        let uncorrelated = self.gfx.norm_sqr() <= 0.0;
        match estimator {
            Estimator::H1 => Ok(self.gfx / self.gff),
            _ if self.gxx <= 0.0 => Ok(Complex64::ZERO),
            Estimator::H2 if uncorrelated => Err(LineError::NotCorrelated),
            Estimator::H2 => Ok(self.gxx / self.gfx.conj()),
            Estimator::Hv => self.hv(kappa),
        }
    }

    /// Total least squares, `[b + sqrt(b² + 4κ|Gfx|²)] / (2 Gfx*)` with `b = Gxx - κ Gff`; where `b
    /// < 0` in the form `2κ Gfx / [sqrt(...) - b]`, which is the same number without the difference
    /// of two close ones.
    fn hv(&self, kappa: f64) -> Result<Complex64, LineError> {
        let b = self.gxx - kappa * self.gff;
        let root = b.hypot(2.0 * kappa.sqrt() * self.gfx.norm());
        if b < 0.0 {
            Ok(2.0 * kappa * self.gfx / (root - b))
        } else if self.gfx.norm_sqr() <= 0.0 {
            Err(LineError::NotCorrelated)
        } else {
            Ok((b + root) / (2.0 * self.gfx.conj()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// F = (1, 2i, -3), X = (2i, 1, -7): Gff 14, Gxx 54, Gfx = 2i - 2i + 21.
    fn hand_made() -> LineSums {
        let i = Complex64::I;
        let mut sums = LineSums::default();
        sums.add(Complex64::ONE, 2.0 * i);
        sums.add(2.0 * i, Complex64::ONE);
        sums.add(Complex64::new(-3.0, 0.0), Complex64::new(-7.0, 0.0));
        sums
    }

    #[test]
    fn the_estimators_have_their_closed_forms() {
        let sums = hand_made();
        let value = |estimator, kappa| sums.estimate(estimator, kappa).unwrap();
        assert!((value(Estimator::H1, 0.0) - 1.5).norm() < 1e-15);
        assert!((value(Estimator::H2, 0.0) - 54.0 / 21.0).norm() < 1e-15);
        // kappa 2: b = 26; kappa 5: b = -16, the other branch.
        for (kappa, b) in [(2.0, 26.0), (5.0, -16.0)] {
            let expected = (b + f64::sqrt(b * b + 4.0 * kappa * 441.0)) / 42.0;
            assert!((value(Estimator::Hv, kappa) - expected).norm() < 1e-14);
        }
    }

    #[test]
    fn the_frf_phase_is_response_minus_force() {
        let mut sums = LineSums::default();
        sums.add(Complex64::cis(0.7), Complex64::from_polar(3.0, 0.2));
        let expected = Complex64::from_polar(3.0, -0.5);
        for estimator in [Estimator::H1, Estimator::H2, Estimator::Hv] {
            assert!((sums.estimate(estimator, 9.5).unwrap() - expected).norm() < 1e-14);
        }
    }

    #[test]
    fn hv_tends_to_h1_and_h2_at_extreme_noise_ratios() {
        let sums = hand_made();
        let hv = |kappa| sums.estimate(Estimator::Hv, kappa).unwrap();
        let (h1, h2) = (Complex64::new(1.5, 0.0), Complex64::new(54.0 / 21.0, 0.0));
        // The distances fall in proportion to 1/kappa and to kappa.
        for kappa in [1e6, 1e9, 1e12, 1e200] {
            assert!((hv(kappa) - h1).norm() < 10.0 / kappa + 1e-15);
            assert!((hv(1.0 / kappa) - h2).norm() < 10.0 / kappa + 1e-15);
        }
        assert!((hv(1e6) - h1).norm() > 0.1 / 1e6);
    }

    #[test]
    fn degenerate_lines_are_decided() {
        let sums = |gff, gxx, gfx: f64| LineSums {
            gff,
            gxx,
            gfx: gfx.into(),
        };
        for estimator in [Estimator::H1, Estimator::H2, Estimator::Hv] {
            assert_eq!(
                sums(0.0, 1.0, 0.0).estimate(estimator, 1.0),
                Err(LineError::NoForce)
            );
            assert_eq!(
                sums(1.0, 0.0, 0.0).estimate(estimator, 1.0),
                Ok(Complex64::ZERO)
            );
        }
        let noise = sums(1.0, 4.0, 0.0);
        assert_eq!(noise.estimate(Estimator::H1, 1.0), Ok(Complex64::ZERO));
        for estimator in [Estimator::H2, Estimator::Hv] {
            assert_eq!(
                noise.estimate(estimator, 1.0),
                Err(LineError::NotCorrelated)
            );
        }
    }

    #[test]
    fn all_lines_together_have_the_estimates_of_each() {
        let mut lines: Vec<LineSums> = (0..37)
            .map(|line| {
                let mut sums = hand_made();
                sums.add(Complex64::cis(f64::from(line)), Complex64::new(0.3, 0.9));
                sums
            })
            .collect();
        let sums = Sums::from(lines.as_slice());
        for estimator in [Estimator::H1, Estimator::H2, Estimator::Hv] {
            let expected = lines
                .iter()
                .map(|line| line.estimate(estimator, 0.7).unwrap());
            let expected: Vec<Complex64> = expected.collect();
            assert_eq!(sums.estimates(estimator, 0.7), Ok(expected));
        }
        let powers: Vec<f64> = lines.iter().map(|line| line.gxx).collect();
        assert_eq!(sums.each(|line| line.gxx), powers);
        lines[20].gff = 0.0;
        let without = Sums::from(lines.as_slice()).estimates(Estimator::H1, 0.7);
        assert_eq!(without, Err((20, LineError::NoForce)));
    }

    #[test]
    fn sums_of_hits_equal_the_sums_of_each_hit() {
        for lines in [1, LINES_AT_ONCE, 3 * LINES_AT_ONCE + 5] {
            let spectrum = |seed: usize| -> Vec<Complex64> {
                let value =
                    |line: usize| Complex64::cis((seed * line) as f64) * (seed + line) as f64;
                (0..lines).map(value).collect()
            };
            let spectra: Vec<_> = (1..4).map(|h| (spectrum(h), spectrum(h + 10))).collect();
            let hits: Vec<_> = spectra.iter().map(|(f, x)| (&f[..], &x[..])).collect();
            let mut sums = Sums::default();
            sums.clear(lines);
            sums.add(&hits);
            sums.clear(lines);
            sums.add(&hits[..2]);
            sums.add(&hits[2..]);
            for line in 0..lines {
                let mut expected = LineSums::default();
                hits.iter()
                    .for_each(|(f, x)| expected.add(f[line], x[line]));
                let (gxx, gfx) = (sums.gxx[line], sums.gfx[line]);
                assert!((gxx / expected.gxx - 1.0).abs() < 1e-14, "{line}");
                assert!((gfx - expected.gfx).norm() < 1e-14 * expected.gfx.norm() + 1e-11);
            }
        }
    }

    proptest! {
        /// Hv lies between H1 and H2, with their phase.
        #[test]
        fn hv_lies_between(parts in proptest::collection::vec(-5.0..5.0f64, 12), log_kappa in -6.0..6.0f64) {
            let mut sums = LineSums::default();
            for p in parts.chunks(4) {
                sums.add(Complex64::new(p[0], p[1]), Complex64::new(p[2], p[3]));
            }
            prop_assume!(sums.gfx.norm() > 1e-3);
            let [h1, hv, h2] = [Estimator::H1, Estimator::Hv, Estimator::H2]
                .map(|e| sums.estimate(e, 10f64.powf(log_kappa)).unwrap());
            prop_assert!(h1.norm() <= hv.norm() * (1.0 + 1e-12));
            prop_assert!(hv.norm() <= h2.norm() * (1.0 + 1e-12));
            prop_assert!((hv / h1).im.abs() < 1e-12 * (hv / h1).norm());
        }
    }
}
