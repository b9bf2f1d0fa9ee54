//! Line shape of a pole: `1/(iω − λ)`, or its mean over the records of a steady random excitation
//! under a window.
//!
//! Under flat random force the expected H1 is the FRF smoothed by the power spectrum of the window,
//! `E H1 = H * |W|²`. Its inverse transform is the autocorrelation of the window, so that a pole
//! becomes
//!
//! ```text
//! 1/(iω − λ)  →  T ∫₀¹ ρ(u) e^(zu) du,   z = (λ − iω) T
//! ρ(u) = ∫₀^(1−u) w(v) w(v + u) dv / ∫₀¹ w(v)² dv
//! ```
//!
//! with the length T of the records. For a window of cosines, `w(v) = Σ_k a_k cos 2πkv`, ρ is `Σ_k
//! ((1 − u) c_k cos 2πku + s_k sin 2πku)` and the integral is a sum of moments `∫ uⁿ e^(zu) du` at
//! `z ± 2πik`. A hammer test has no such smoothing: its records begin with the response at rest.
//!
//! Reference: Bendat and Piersol (2010), Random Data, 4th ed., section 8.5 (bias of spectral
//! estimates by the resolution); Schmidt (1985), Resolution bias errors in spectral density,
//! frequency response and coherence function measurements, Journal of Sound and Vibration 101(3).

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::frf::{FrfSet, Window};
use crate::linalg::{self, ComplexMatrix};

/// Maximum number of cosines of a window.
const TERMS: usize = 5;
/// Coefficients of the Hann window.
const HANN: [f64; TERMS] = [0.5, -0.5, 0.0, 0.0, 0.0];
/// Coefficients of the flat top window: ISO 18431-2:2004, table 1.
const FLAT_TOP: [f64; TERMS] = [1.0, -1.933, 1.286, -0.388, 0.0322];
/// Powers of a pole that a fit needs: itself and its first two derivatives by λ.
const POWERS: usize = 3;
/// Moments that they need: those of `(1 − u)` need one more.
const MOMENTS: usize = POWERS + 1;
/// Size of z up to which moments are summed as a power series; beyond it by recurrence. At
/// resonance, z = −2, both lose 0.8 digits of the third moment; at −1 the recurrence loses 1.6, at
/// −4 the series 2.
const MAX_SERIES_ARGUMENT: f64 = 2.0;
/// Terms of the series: `2^25/25!` is below rounding.
const SERIES_TERMS: usize = 25;

/// Largest distance of a frequency from its line, lines, that is rounding.
const MAX_LINE_DEVIATION: f64 = 1e-6;
/// Steps of a bisection, to rounding.
const HALVINGS: usize = 60;

/// Line shape of a pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct LineShape(Option<Smoothing>);

/// Smoothing by a window of cosines.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Smoothing {
    record_s: f64,
    window: Window,
    /// Coefficients of the window.
    cosines: [f64; TERMS],
    /// `c_k` and `s_k` of ρ.
    terms: [(f64, f64); TERMS],
}

impl LineShape {
    /// `1/(iω − λ)`.
    pub const EXACT: Self = Self(None);

    /// Line shape of a set whose window is one for steady signals; exact for any other.
    pub fn of(set: &FrfSet) -> Self {
        let record_s = set.axis().step_hz.recip();
        Self((set.window).and_then(|window| Smoothing::new(record_s, window)))
    }

    /// Under each window for steady signals, Hann first, of a set that may come from steady
    /// excitation and states no window; none of any other. An FRF with a window for impacts
    /// makes the set a hammer test.
    pub fn unstated(set: &FrfSet) -> Vec<Self> {
        let is_hammer_test = set.record_duration_s.is_some()
            || set.added_damping_rad_s > 0.0
            || set.mixed_windows.iter().any(|window| window.is_for_hits());
        if is_hammer_test || set.window.is_some() {
            return Vec::new();
        }
        let record_s = set.axis().step_hz.recip();
        let windows = [Window::HannBroad, Window::FlatTop].into_iter();
        windows
            .filter_map(|window| Smoothing::new(record_s, window))
            .map(|smoothing| Self(Some(smoothing)))
            .collect()
    }

    /// That of the stated window for steady signals, a Hann window where none is stated.
    pub fn possible_leakage(set: &FrfSet) -> Option<Self> {
        let stated = Some(Self::of(set)).filter(Self::is_smoothed);
        stated.or_else(|| Self::unstated(set).first().copied())
    }

    /// Name of the window that smooths; empty for the exact line shape.
    pub fn window_name(&self) -> &'static str {
        self.0.map_or("", |smoothing| smoothing.window.name())
    }

    /// Largest distance of poles that leakage may make of one mode, frequency lines: the first side
    /// lobe of the window, one line beyond its main lobe, 3 for a Hann window. At 2, second poles
    /// 2.6 and 2.9 lines from a mode of simulated bridges remain; at 4, more hammer tests are
    /// fitted twice in vain.
    pub fn split_lines(&self) -> f64 {
        self.0
            .map_or(0.0, |smoothing| smoothing.terms_used() as f64 + 1.0)
    }

    /// Relative bias of the damping of a fit of `1/(iω − λ)`, from the decay rate that it found,
    /// rad/s. `None` for the exact line shape. Infinite where an undamped mode looks as wide.
    ///
    /// The least squares fit `A e^(−σ't)` of `ρ(t) e^(−σt)` has `F(p) + 2σ'F'(p) = 0` at `p = σ +
    /// σ'`, F the transform of ρ. To first order it is `4/(3b²)` under a Hann window, b the
    /// half-power bandwidth in lines.
    pub fn leakage_bias(&self, decay: f64) -> Option<f64> {
        let smoothing = self.0?;
        let found = |p: f64| {
            let power = |n| smoothing.power(p.into(), n).re;
            power(1) / (2.0 * power(2))
        };
        let (mut low, mut high) = (0.0, 2.0 * decay + 20.0 / smoothing.record_s);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if found(middle) < decay {
                low = middle;
            } else {
                high = middle;
            }
        }
        let truth = low - decay;
        Some(if truth > 0.0 {
            decay / truth - 1.0
        } else {
            f64::INFINITY
        })
    }

    /// Correlation of the noise of H1 between lines, from that of adjacent lines: that of the
    /// spectra under the window, squared, as those of force and response noise are independent;
    /// `None` for the exact line shape.
    pub fn noise_correlation(&self) -> Option<Vec<Complex64>> {
        let cosines = self.0?.cosines;
        let last = TERMS as i32 - 1;
        let line = |k: i32| match k.unsigned_abs() as usize {
            0 => cosines[0],
            place => cosines.get(place).map_or(0.0, |a| 0.5 * a),
        };
        let product = |m: i32| -> f64 { (-last..=last).map(|k| line(k) * line(k + m)).sum() };
        let lag = |m: i32| Complex64::from((product(m) / product(0)).powi(2));
        Some((1..=2 * last).map(lag).collect())
    }

    /// Whether poles are smoothed.
    pub fn is_smoothed(&self) -> bool {
        self.0.is_some()
    }

    /// `(scale/(iω − λ))ⁿ`, n = 1, 2, 3, or smoothed: `scaleⁿ/(n − 1)!` times the
    /// derivative of order n − 1 by λ of the smoothed pole.
    pub fn power(&self, scale: f64, omega: f64, lambda: Complex64, n: usize) -> Complex64 {
        let s = Complex64::new(0.0, omega) - lambda;
        match &self.0 {
            None => (scale / s).powu(n as u32),
            Some(smoothing) => smoothing.power(s, n) * scale.powi(n as i32),
        }
    }

    /// [`Self::power`] for n = 1 to `count` at each frequency: lines × powers. Where the
    /// frequencies are consecutive lines, a smoothed pole needs one exponential for all of them.
    pub fn powers(
        &self,
        scale: f64,
        omega: &[f64],
        lambda: Complex64,
        count: usize,
    ) -> ComplexMatrix {
        if let Some(smoothing) = &self.0
            && smoothing.are_consecutive_lines(omega)
        {
            let of_lines = smoothing.powers_on_lines(omega, lambda, count);
            return linalg::complex_matrix(omega.len(), count, |k, n| {
                of_lines[k][n] * scale.powi(n as i32 + 1)
            });
        }
        linalg::complex_matrix(omega.len(), count, |k, n| {
            self.power(scale, omega[k], lambda, n + 1)
        })
    }

    /// Fills a column with [`Self::pole`] at each frequency.
    pub fn fill_pole(&self, omega: &[f64], lambda: Complex64, column: &mut [Complex64]) {
        if self.is_smoothed() {
            let powers = self.powers(1.0, omega, lambda, 1);
            column.copy_from_slice(powers.col_as_slice(0));
            return;
        }
        for (value, omega) in column.iter_mut().zip(omega) {
            *value = self.pole(*omega, lambda);
        }
    }

    /// `1/(iω − λ)`, smoothed by the window where there is one.
    pub fn pole(&self, omega: f64, lambda: Complex64) -> Complex64 {
        match self.0 {
            None => (Complex64::new(0.0, omega) - lambda).inv(),
            Some(_) => self.power(1.0, omega, lambda, 1),
        }
    }
}

/// Coefficients of a window for steady signals; `None` for those of a hammer test, and for records
/// without window: whether their force was random is not stated.
pub fn cosines(window: Window) -> Option<[f64; TERMS]> {
    match window {
        Window::HannNarrow | Window::HannBroad => Some(HANN),
        Window::FlatTop => Some(FLAT_TOP),
        Window::Rectangular | Window::Exponential | Window::Force | Window::ForceAndExponential => {
            None
        }
    }
}

impl Smoothing {
    /// `None` for a window that is none for steady signals.
    fn new(record_s: f64, window: Window) -> Option<Self> {
        let cosines = cosines(window)?;
        let mut terms = autocorrelation(cosines);
        let whole: f64 = terms.iter().map(|(c, _)| c).sum();
        for (c, s) in &mut terms {
            *c /= whole;
            *s /= whole;
        }
        Some(Self {
            record_s,
            window,
            cosines,
            terms,
        })
    }

    /// Cosines of the window, the constant included.
    fn terms_used(&self) -> usize {
        self.cosines.iter().filter(|a| a.abs() > 0.0).count()
    }

    /// `1/sⁿ` smoothed: `Tⁿ/(n − 1)! ∫ u^(n−1) ρ(u) e^(−sTu) du`.
    fn power(&self, s: Complex64, n: usize) -> Complex64 {
        let z = -s * self.record_s;
        let end = z.exp();
        self.sum_of_moments(n, |turns| {
            moments(z + Complex64::new(0.0, TAU * turns as f64), end, n + 1)
        })
    }

    /// Whether each frequency is one line above the one before.
    fn are_consecutive_lines(&self, omega: &[f64]) -> bool {
        let lines = |k: usize| (omega[k] - omega[0]) * self.record_s / TAU;
        (0..omega.len()).all(|k| (lines(k) - k as f64).abs() < MAX_LINE_DEVIATION)
    }

    /// The first `count` powers of a pole at each of some consecutive lines: from one line to the
    /// next z decreases by 2πi, so that `e^z` stays and the moments are shared.
    fn powers_on_lines(
        &self,
        omega: &[f64],
        lambda: Complex64,
        count: usize,
    ) -> Vec<[Complex64; POWERS]> {
        let z = match omega.first() {
            Some(first) => (lambda - Complex64::new(0.0, *first)) * self.record_s,
            None => return Vec::new(),
        };
        let (end, margin) = (z.exp(), self.terms_used() as i32 - 1);
        let of_line = |line: i32| {
            let turns = Complex64::new(0.0, TAU * f64::from(line));
            moments(z - turns, end, count + 1)
        };
        let lines = -margin..omega.len() as i32 + margin;
        let of_lines: Vec<[Complex64; MOMENTS]> = lines.map(of_line).collect();
        let powers = |line: usize| {
            let mut powers = [Complex64::ZERO; POWERS];
            for (order, power) in powers[..count].iter_mut().enumerate() {
                let shifted = |turns: i32| of_lines[(line as i32 + margin - turns) as usize];
                *power = self.sum_of_moments(order + 1, shifted);
            }
            powers
        };
        (0..omega.len()).map(powers).collect()
    }

    /// The power n of a pole from the moments at `z + 2πik` by k.
    fn sum_of_moments(
        &self,
        n: usize,
        moments_at: impl Fn(i32) -> [Complex64; MOMENTS],
    ) -> Complex64 {
        let order = n - 1;
        let term = |(k, (c, s)): (usize, &(f64, f64))| {
            let above = moments_at(k as i32);
            let fading = |moments: &[Complex64; MOMENTS]| moments[order] - moments[order + 1];
            if k == 0 {
                return *c * fading(&above);
            }
            let below = moments_at(-(k as i32));
            let cosine = 0.5 * (fading(&above) + fading(&below));
            let sine = (above[order] - below[order]) / Complex64::new(0.0, 2.0);
            *c * cosine + *s * sine
        };
        let used = self
            .terms
            .iter()
            .enumerate()
            .filter(|(_, t)| **t != (0.0, 0.0));
        let factorial = if n == POWERS { 2.0 } else { 1.0 };
        used.map(term).sum::<Complex64>() * (self.record_s.powi(n as i32) / factorial)
    }
}

/// `c_k` and `s_k` of `∫₀^(1−u) w(v) w(v + u) dv = Σ_k ((1 − u) c_k cos 2πku + s_k sin 2πku)`.
fn autocorrelation(cosines: [f64; TERMS]) -> [(f64, f64); TERMS] {
    let mut terms = [(0.0, 0.0); TERMS];
    for (k, a) in cosines.iter().enumerate() {
        for (l, b) in cosines.iter().enumerate() {
            let product = 0.5 * a * b / TAU;
            let (sum, difference) = ((k + l) as f64, k as f64 - l as f64);
            if k == l {
                terms[k].0 += if k == 0 { a * b } else { 0.5 * a * b };
            } else {
                terms[l].1 += product / difference;
                terms[k].1 -= product / difference;
            }
            if k + l > 0 {
                terms[k].1 -= product / sum;
                terms[l].1 -= product / sum;
            }
        }
    }
    terms
}

/// The first `count` moments `∫₀¹ uⁿ e^(zu) du`, n = 0, 1, ...; the others are 0. `end` is `e^z`,
/// equal to that of `z ± 2πik`.
fn moments(z: Complex64, end: Complex64, count: usize) -> [Complex64; MOMENTS] {
    let mut moments = [Complex64::ZERO; MOMENTS];
    let used = &mut moments[..count];
    if z.norm_sqr() > MAX_SERIES_ARGUMENT * MAX_SERIES_ARGUMENT {
        let reciprocal = z.inv();
        let mut last = (end - 1.0) * reciprocal;
        for (n, moment) in used.iter_mut().enumerate() {
            if n > 0 {
                last = (end - n as f64 * last) * reciprocal;
            }
            *moment = last;
        }
        return moments;
    }
    let mut power = Complex64::ONE;
    for j in 0..SERIES_TERMS {
        for (n, moment) in used.iter_mut().enumerate() {
            *moment = *moment + power / (n + j + 1) as f64;
        }
        power = power * z / (j + 1) as f64;
    }
    moments
}

#[cfg(test)]
mod tests {
    use crate::axis::FrequencyAxis;
    use crate::identify::data::line_shape::*;

    const STEPS: usize = 2000;

    /// ρ at each step of the record, by its definition: trapezoidal sums over the window.
    fn correlation(cosines: [f64; TERMS]) -> Vec<f64> {
        let weight = |v: usize| -> f64 {
            let at = |k: usize| TAU * (k * v) as f64 / STEPS as f64;
            (0..TERMS).map(|k| cosines[k] * at(k).cos()).sum()
        };
        let weights: Vec<f64> = (0..=STEPS).map(weight).collect();
        let correlation = |u: usize| -> f64 {
            let products = weights.iter().zip(&weights[u..]).map(|(a, b)| a * b);
            let ends = weights[0] * weights[u] + weights[STEPS - u] * weights[STEPS];
            products.sum::<f64>() - 0.5 * ends
        };
        (0..=STEPS)
            .map(|u| correlation(u) / correlation(0))
            .collect()
    }

    /// The smoothed power by its definition: a trapezoidal sum over the record.
    fn by_definition(correlation: &[f64], (s, n): (Complex64, usize)) -> Complex64 {
        let value = |(u, rho): (usize, &f64)| {
            let at = u as f64 / STEPS as f64;
            let end = if u == 0 || u == STEPS { 0.5 } else { 1.0 };
            (-s * at).exp() * (end * rho * at.powi(n as i32 - 1))
        };
        let factorial = if n == 3 { 2.0 } else { 1.0 };
        correlation.iter().enumerate().map(value).sum::<Complex64>() / (STEPS as f64 * factorial)
    }

    #[test]
    fn smoothed_pole_and_derivatives_equal_the_integral_over_the_autocorrelation() {
        for (window, cosines) in [(Window::HannBroad, HANN), (Window::FlatTop, FLAT_TOP)] {
            let smoothing = Smoothing::new(1.0, window).unwrap();
            let correlation = correlation(cosines);
            for decay in [0.01, 1.0, 1.9, 2.1, 20.0] {
                for turn in [0.0, 0.4, 3.0, TAU, 9.0, -2.0 * TAU] {
                    let s = Complex64::new(decay, turn);
                    for n in 1..=POWERS {
                        let expected = by_definition(&correlation, (s, n));
                        let error = (smoothing.power(s, n) - expected).norm();
                        // |s|²/12 over the square of the steps, 1e-5 at most.
                        assert!(error < 2e-5, "{s} {n}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn powers_at_several_frequencies_are_those_at_each() {
        let lines = |first: i32, last: i32| (first..last).map(f64::from).collect();
        let cases: [Vec<f64>; 4] = [lines(300, 340), lines(317, 318), vec![316.0, 318.5], vec![]];
        for (window, lines) in [Window::HannBroad, Window::FlatTop]
            .into_iter()
            .flat_map(|window| cases.iter().map(move |lines| (window, lines)))
        {
            let shape = LineShape(Smoothing::new(0.5, window));
            let omega: Vec<f64> = lines.iter().map(|k| 2.0 * TAU * k).collect();
            let lambda = Complex64::new(-3.0, 2.0 * TAU * 317.3);
            let powers = shape.powers(5.0, &omega, lambda, POWERS);
            let mut column = vec![Complex64::ZERO; omega.len()];
            shape.fill_pole(&omega, lambda, &mut column);
            for (k, omega) in omega.iter().enumerate() {
                let error = (column[k] - shape.pole(*omega, lambda)).norm();
                assert!(error < 1e-11 * column[k].norm(), "{window:?} {k}: {error}");
                for n in 1..=POWERS {
                    let expected = shape.power(5.0, *omega, lambda, n);
                    let error = (powers[(k, n - 1)] - expected).norm();
                    assert!(
                        error < 1e-11 * expected.norm(),
                        "{window:?} {k} {n}: {error}"
                    );
                }
            }
        }
    }

    #[test]
    fn far_from_a_pole_smoothing_changes_nothing() {
        let smoothing = Smoothing::new(0.5, Window::HannBroad).unwrap();
        let s = Complex64::new(2.0, 3e3);
        for n in 1..=POWERS {
            let exact = s.powu(n as u32).inv();
            let error = (smoothing.power(s, n) / exact - 1.0).norm();
            // ρ″(0)/(sT)² = 13.2/1500² for the pole, with its second derivative six times that.
            assert!(error < 5e-5, "{n}: {error}");
        }
    }

    /// A set without FRFs whose lines are half a hertz apart: records of 2 s.
    fn set_under(window: Option<Window>) -> FrfSet {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.5,
            len: 3,
        };
        let mut set = FrfSet::new(axis);
        set.window = window;
        set
    }

    #[test]
    fn record_length_is_one_over_the_line_spacing_and_scale_counts_once_for_each_power() {
        let shape = LineShape::of(&set_under(Some(Window::HannNarrow)));
        let correlation = correlation(HANN);
        let (omega, lambda) = (40.0, Complex64::new(-0.8, 41.0));
        let s = Complex64::new(0.0, omega) - lambda;
        for n in 1..=POWERS {
            let expected = by_definition(&correlation, (2.0 * s, n)) * 6f64.powi(n as i32);
            let error = (shape.power(3.0, omega, lambda, n) - expected).norm();
            assert!(error < 2e-5 * 6f64.powi(n as i32), "{n}: {error}");
        }
        assert_eq!(LineShape::of(&set_under(None)), LineShape::EXACT);
        assert_eq!(
            LineShape::of(&set_under(Some(Window::Exponential))),
            LineShape::EXACT
        );
    }

    #[test]
    fn noise_of_lines_under_a_hann_window_is_correlated_by_4_9_and_1_36() {
        let shape = LineShape::of(&set_under(Some(Window::HannBroad)));
        let noise = shape.noise_correlation().expect("a window");
        // Lines of the spectrum 1/2 and -1/4: their products sum up to 3/8, -1/4 and 1/16.
        for (lag, expected) in [4.0 / 9.0, 1.0 / 36.0, 0.0].into_iter().enumerate() {
            let error = (noise[lag] - expected).norm();
            assert!(error < 1e-12, "{}: {error}", lag + 1);
        }
        assert!(LineShape::EXACT.noise_correlation().is_none());
    }

    #[test]
    fn leakage_bias_falls_with_the_square_of_the_bandwidth_in_lines() {
        for lines in [10.0, 20.0, 40.0] {
            // Half-power bandwidth of decay/pi hertz, in lines of half a hertz.
            let decay = std::f64::consts::PI * 0.5 * lines;
            let first_order = 4.0 / (3.0 * lines * lines);
            for window in [Some(Window::HannNarrow), None] {
                let set = set_under(window);
                let shapes = [vec![LineShape::of(&set)], LineShape::unstated(&set)].concat();
                let bias = shapes.iter().find_map(|shape| shape.leakage_bias(decay));
                let bias = bias.expect("a steady signal");
                let error = bias / first_order - 1.0;
                // The next order is smaller by a few squares of the bandwidth.
                assert!(
                    error.abs() < 20.0 / (lines * lines),
                    "{lines}: {bias} {error}"
                );
            }
        }
        let force = set_under(Some(Window::Force));
        assert_eq!(LineShape::of(&force).leakage_bias(1.0), None);
        assert!(LineShape::unstated(&force).is_empty());
    }

    #[test]
    fn powers_are_derivatives_of_the_pole() {
        let shape = LineShape(Smoothing::new(2.0, Window::HannBroad));
        let (omega, lambda, step) = (7.0, Complex64::new(-0.6, 6.5), 1e-5);
        let at = |n: usize, pole: Complex64| shape.power(1.0, omega, pole, n);
        for n in 1..POWERS {
            let difference = (at(n, lambda + step) - at(n, lambda - step)) / (2.0 * step);
            let error = (difference / (n as f64) - at(n + 1, lambda)).norm();
            assert!(error < 1e-7 * at(n + 1, lambda).norm(), "{n}: {error}");
        }
    }
}
