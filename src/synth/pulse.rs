//! The hammer's pulse: as stated, as drawn, and its convolution with an exponential in closed form.

use std::f64::consts::PI;

use num_complex::Complex64;
use rand::Rng;
use rand::distr::Open01;
use rand_chacha::ChaCha8Rng;

/// Half-sine pulses as stated: peak and duration of each hit are drawn uniformly within `value (1 ±
/// spread)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Mean peak force, N.
    pub peak_n: f64,
    /// Half width of the peaks over their mean, 0 up to below 1.
    pub peak_spread: f64,
    /// Mean contact time, s.
    pub duration_s: f64,
    /// Half width of the contact times over their mean, 0 up to below 1.
    pub duration_spread: f64,
}

impl Pulse {
    /// Draws the pulse of one hit. It begins inside the sample interval that follows the
    /// pre-trigger.
    pub(super) fn draw(&self, pretrigger_s: f64, step_s: f64, random: &mut ChaCha8Rng) -> HalfSine {
        let mut around = |value: f64, spread: f64| {
            let u: f64 = random.sample(Open01);
            value * (1.0 + spread * (2.0 * u - 1.0))
        };
        let peak_n = around(self.peak_n, self.peak_spread);
        let duration_s = around(self.duration_s, self.duration_spread);
        let fraction: f64 = random.sample(Open01);
        HalfSine {
            start_s: pretrigger_s + fraction * step_s,
            peak_n,
            duration_s,
        }
    }
}

/// One force pulse `f(t) = peak sin(pi (t - start)/duration)` on `[start, start + duration]`, 0
/// elsewhere, before the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSine {
    /// First contact on the record's time axis, s.
    pub start_s: f64,
    /// Peak force, N.
    pub peak_n: f64,
    /// Contact time, s.
    pub duration_s: f64,
}

impl HalfSine {
    /// End of contact on the record's time axis, s.
    pub fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    /// Laplace transform at s, N s: `peak e^(-s start) w (1 + e^(-s T)) / (s^2 + w^2)`, `w = pi/T`.
    pub fn transform(&self, s: Complex64) -> Complex64 {
        // sin(w tau) is the same read backwards, so the transform is a convolution taken at the
        // end.
        self.peak_n * (-s * self.start_s).exp() * Convolution::new(-s, self.duration_s).at_end()
    }
}

/// `g(t) = integral_0^t e^(p (t - tau)) sin(w tau) d tau` for `0 <= t <= T`, `w = pi/T`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convolution {
    pole: Complex64,
    omega: f64,
    duration_s: f64,
    /// The pole lies so near to +iw or -iw that the plain form cancels.
    resonant: bool,
}

impl Convolution {
    /// The convolution for one pole, rad/s, and one contact time.
    pub fn new(pole: Complex64, duration_s: f64) -> Self {
        let omega = PI / duration_s;
        let off = Complex64::new(pole.re, pole.im.abs() - omega);
        Self {
            pole,
            omega,
            duration_s,
            resonant: off.norm() * duration_s < 1.0,
        }
    }

    /// g at t: `(w e^(p t) - p sin(w t) - w cos(w t)) / (p^2 + w^2)`, and near p = ±iw, where that
    /// is 0/0, half the difference of `(e^(±i w t) - e^(p t))/(±i w - p)` over i.
    pub fn at(&self, t: f64) -> Complex64 {
        let (p, omega) = (self.pole, self.omega);
        if self.resonant {
            let turn = Complex64::new(0.0, omega);
            let difference = divided_difference(turn, p, t) - divided_difference(-turn, p, t);
            return difference / Complex64::new(0.0, 2.0);
        }
        let (sin, cos) = (omega * t).sin_cos();
        let i_omega = Complex64::new(0.0, omega);
        (omega * ((p * t).exp() - cos) - p * sin) / ((p - i_omega) * (p + i_omega))
    }

    /// g at the end of contact; later it only decays, `g(t) = e^(p (t - T)) g(T)`.
    pub fn at_end(&self) -> Complex64 {
        self.at(self.duration_s)
    }
}

/// `(e^(a t) - e^(b t)) / (a - b)`, without cancellation when `a` and `b` meet.
fn divided_difference(a: Complex64, b: Complex64, t: f64) -> Complex64 {
    let z = (a - b) * t;
    if z.norm() >= 1.0 {
        ((a * t).exp() - (b * t).exp()) / (a - b)
    } else {
        (b * t).exp() * t * exponential_quotient(z)
    }
}

/// `(e^z - 1)/z` for |z| < 1 by its series; the first term left out is below 1/20! = 4e-19.
fn exponential_quotient(z: Complex64) -> Complex64 {
    (2..=19)
        .rev()
        .fold(Complex64::ONE, |sum, k| 1.0 + sum * z / f64::from(k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Nodes and weights of five-point Gauss-Legendre on [-1, 1] (Abramowitz and Stegun 1964,
    /// section 25.4.29 in closed form).
    fn gauss_legendre() -> [(f64, f64); 5] {
        let root = (10.0f64 / 7.0).sqrt();
        let (inner, outer) = (
            (5.0 - 2.0 * root).sqrt() / 3.0,
            (5.0 + 2.0 * root).sqrt() / 3.0,
        );
        let part = 13.0 * 70f64.sqrt();
        let (near, far) = ((322.0 + part) / 900.0, (322.0 - part) / 900.0);
        [
            (-outer, far),
            (-inner, near),
            (0.0, 128.0 / 225.0),
            (inner, near),
            (outer, far),
        ]
    }

    fn quadrature(p: Complex64, omega: f64, t: f64) -> Complex64 {
        const PANELS: usize = 2000;
        let half = 0.5 * t / PANELS as f64;
        let mut sum = Complex64::ZERO;
        for panel in 0..PANELS {
            let middle = (2 * panel + 1) as f64 * half;
            for (x, weight) in gauss_legendre() {
                let tau = middle + half * x;
                sum += weight * half * (p * (t - tau)).exp() * (omega * tau).sin();
            }
        }
        sum
    }

    #[test]
    fn the_convolution_is_the_integral_for_poles_far_from_and_at_the_pulse_frequency() {
        let duration = 2e-3;
        let omega = PI / duration;
        let poles = [
            Complex64::new(-30.0, 900.0),
            Complex64::new(-0.5, 40.0),
            Complex64::new(-400.0, -9000.0),
            Complex64::new(-2e4, 3e4),
            Complex64::new(-5e4, 0.0),
            Complex64::new(0.0, omega),
            Complex64::new(0.0, -omega),
            Complex64::new(-1e-6, omega * (1.0 + 1e-9)),
            Complex64::new(-3.0, omega - 2.0),
            Complex64::new(-0.7 / duration, omega + 0.7 / duration),
            Complex64::new(-0.72 / duration, omega + 0.72 / duration),
        ];
        for p in poles {
            let convolution = Convolution::new(p, duration);
            let peak = duration.min(1.0 / (p.norm() + f64::MIN_POSITIVE));
            for i in 1..=8 {
                let t = duration * f64::from(i) / 8.0;
                let error = (convolution.at(t) - quadrature(p, omega, t)).norm();
                assert!(error < 1e-12 * peak, "p {p}, t {t}: {:e}", error / peak);
            }
            assert!(convolution.at(0.0).norm() < 1e-15 * peak);
        }
    }

    #[test]
    fn a_pole_decaying_within_the_pulse_neither_overflows_nor_vanishes() {
        let duration = 1e-2;
        let omega = PI / duration;
        let p = Complex64::new(-1e6, 2e5);
        let t = 0.3 * duration;
        let steady = ((Complex64::new(0.0, omega * t)).exp() / (Complex64::new(0.0, omega) - p)
            - (Complex64::new(0.0, -omega * t)).exp() / (Complex64::new(0.0, -omega) - p))
            / Complex64::new(0.0, 2.0);
        let got = Convolution::new(p, duration).at(t);
        assert!((got - steady).norm() < 1e-14 * steady.norm());
    }

    #[test]
    fn the_transform_at_zero_is_the_impulse_of_a_half_sine() {
        let pulse = HalfSine {
            start_s: 0.4,
            peak_n: 120.0,
            duration_s: 3e-3,
        };
        let impulse = 2.0 * 120.0 * 3e-3 / PI;
        assert!((pulse.transform(Complex64::ZERO) - impulse).norm() < 1e-14);
        let s = Complex64::new(0.0, 500.0);
        let turned = (pulse.transform(s) * (s * (0.4 + 1.5e-3)).exp()).im;
        assert!(turned.abs() < 1e-13, "symmetric about its middle: {turned}");
    }

    #[test]
    fn draws_stay_within_their_spread_and_begin_between_two_samples() {
        let stated = Pulse {
            peak_n: 200.0,
            peak_spread: 0.25,
            duration_s: 1e-3,
            duration_spread: 0.1,
        };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let drawn: Vec<HalfSine> = (0..4000)
            .map(|_| stated.draw(0.1, 1e-4, &mut random))
            .collect();
        let mean = |f: fn(&HalfSine) -> f64| drawn.iter().map(f).sum::<f64>() / 4000.0;
        for p in &drawn {
            assert!((150.0..=250.0).contains(&p.peak_n));
            assert!((0.9e-3..=1.1e-3).contains(&p.duration_s));
            assert!(p.start_s > 0.1 && p.start_s < 0.1001);
        }
        // Five standard deviations of the mean of uniform draws: 5 * width / sqrt(12 * 4000).
        assert!((mean(|p| p.peak_n) - 200.0).abs() < 5.0 * 100.0 / 219.0);
        assert!((mean(|p| p.duration_s) - 1e-3).abs() < 5.0 * 2e-4 / 219.0);
        assert!((mean(|p| p.start_s) - 0.10005).abs() < 5.0 * 1e-4 / 219.0);
    }
}
