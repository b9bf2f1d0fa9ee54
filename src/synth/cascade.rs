//! Partial fractions of filter and structure in series, driven by a half sine and evaluated at the
//! sampling instants.
//!
//! With the filter `G(s) = sum B_k/(s - q_k)` and the structure `s^m H(s)`, the series has simple
//! poles only: `lambda_r` with `lambda_r^m A_r G(lambda_r)`, and `q_k` with `B_k q_k^m H(q_k)`; a
//! filter of two poles or more leaves no direct term. The response of each pole to a half sine has
//! a closed form ([`super::pulse::Convolution`]). No noise and no sampling effects here.

use num_complex::Complex64;

use crate::quantity::FrfKind;

use super::filter::LowPass;
use super::pulse::{Convolution, HalfSine};
use super::truth::TrueFrf;

/// Samples between two exact exponentials; in between each is the previous one times a constant,
/// which loses less than 64 roundings.
const BLOCK: usize = 64;
/// Powers that are computed at once.
const LANES: usize = 8;
/// A term is left out once it has decayed by e^-80 = 2e-35.
const NEGLIGIBLE_EXPONENT: f64 = -80.0;

/// One term `c/(s - p)`, real part taken: a pair of conjugate poles is one term with twice its
/// coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Term {
    pole: Complex64,
    coefficient: Complex64,
}

impl Term {
    fn new(pole: Complex64, coefficient: Complex64) -> Self {
        let both = if pole.im > 0.0 { 2.0 } else { 1.0 };
        Self {
            pole,
            coefficient: both * coefficient,
        }
    }
}

/// The terms of the force channel: the filter alone.
pub(super) fn force_terms(filter: &LowPass) -> Vec<Term> {
    let fractions = filter.fractions().into_iter();
    fractions.map(|f| Term::new(f.pole, f.residue)).collect()
}

/// The terms of a response channel: structure and filter in series.
pub(super) fn response_terms(filter: &LowPass, pair: &TrueFrf, kind: FrfKind) -> Vec<Term> {
    let order = kind.derivative_order();
    let modes = pair.modes.iter().map(|&(lambda, residue)| {
        Term::new(
            lambda,
            residue * lambda.powi(order) * filter.transfer(lambda),
        )
    });
    let filtered = filter
        .fractions()
        .into_iter()
        .map(|f| Term::new(f.pole, f.residue * pair.transfer(f.pole, kind)));
    modes.chain(filtered).collect()
}

/// Adds the response of all terms to one pulse at the instants `n / rate`.
pub(super) fn add_pulse(samples: &mut [f64], terms: &[Term], pulse: &HalfSine, rate_hz: f64) {
    let first_after = |t: f64| ((t * rate_hz).floor() as usize + 1).min(samples.len());
    let (first, after) = (first_after(pulse.start_s), first_after(pulse.end_s()));
    for term in terms {
        let convolution = Convolution::new(term.pole, pulse.duration_s);
        let scale = pulse.peak_n * term.coefficient;
        for (n, sample) in samples.iter_mut().enumerate().take(after).skip(first) {
            let t = (n as f64 / rate_hz - pulse.start_s).clamp(0.0, pulse.duration_s);
            *sample += (scale * convolution.at(t)).re;
        }
        let decay = Decay {
            pole: term.pole,
            start: scale * convolution.at_end(),
            since_s: pulse.end_s(),
            rate_hz,
        };
        decay.add(samples, after);
    }
}

/// `start e^(pole (t - since))`.
struct Decay {
    pole: Complex64,
    start: Complex64,
    since_s: f64,
    rate_hz: f64,
}

impl Decay {
    fn add(&self, samples: &mut [f64], first: usize) {
        let step = (self.pole / self.rate_hz).exp();
        let mut powers = [Complex64::ONE; LANES];
        for lane in 1..LANES {
            powers[lane] = powers[lane - 1] * step;
        }
        let stride = powers[LANES - 1] * step;
        for (block, chunk) in samples[first..].chunks_mut(BLOCK).enumerate() {
            let t = (first + block * BLOCK) as f64 / self.rate_hz - self.since_s;
            if self.pole.re * t < NEGLIGIBLE_EXPONENT {
                break;
            }
            let value = self.start * (self.pole * t).exp();
            add_powers(chunk, value, &powers, stride);
        }
    }
}

/// Adds the real parts of a value times powers of a step, [`LANES`] at once: each power waits for
/// the one that it is a multiple of.
fn add_powers(
    samples: &mut [f64],
    value: Complex64,
    powers: &[Complex64; LANES],
    stride: Complex64,
) {
    let mut re = powers.map(|power| (value * power).re);
    let mut im = powers.map(|power| (value * power).im);
    let (groups, last) = samples.as_chunks_mut::<LANES>();
    for group in groups {
        for lane in 0..LANES {
            group[lane] += re[lane];
            let next = re[lane] * stride.re - im[lane] * stride.im;
            im[lane] = re[lane] * stride.im + im[lane] * stride.re;
            re[lane] = next;
        }
    }
    for (sample, re) in last.iter_mut().zip(re) {
        *sample += re;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_recursion_is_the_exponential_at_every_sample() {
        let rate_hz = 10_000.0;
        let decay = Decay {
            pole: Complex64::new(-3.0, 20_000.0),
            start: Complex64::new(0.6, -0.8),
            since_s: 0.012_345,
            rate_hz,
        };
        let first = 124;
        let mut samples = vec![0.0; 5000];
        decay.add(&mut samples, first);
        for (n, sample) in samples.iter().enumerate() {
            let t = n as f64 / rate_hz - decay.since_s;
            let exact = if n < first {
                0.0
            } else {
                (decay.start * (decay.pole * t).exp()).re
            };
            // Products of a block, and on both sides the rounding of the time that the phase
            // magnifies.
            let phase = decay.pole.norm() * n as f64 / rate_hz;
            let bound = f64::EPSILON * (4.0 * BLOCK as f64 + phase);
            assert!((sample - exact).abs() < bound, "{n}");
        }
    }

    #[test]
    fn a_decayed_term_does_not_change_the_rest_of_the_record() {
        let decay = Decay {
            pole: Complex64::new(-1e4, 0.0),
            start: Complex64::ONE,
            since_s: 0.0,
            rate_hz: 1e4,
        };
        let mut samples = vec![0.0; 400];
        decay.add(&mut samples, 0);
        assert!(samples[79] > 0.0 && samples[200..].iter().all(|v| *v <= 0.0));
    }
}
