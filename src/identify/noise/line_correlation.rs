//! Correlation of noise between frequency lines, and its effect on the noise of amplitudes and
//! poles.
//!
//! Noise is independent between lines only where it is stationary over the record. A window on the
//! responses, a force that is set to zero after the pulse, or zeros at the end of a record confine
//! it to a part of the record, and neighbouring lines are then correlated: the noise has bumps as
//! wide as those of modes. With the correlation `ρ(m)` over `m` lines, the amplitude of a profile
//! `g` over the lines has `gᴴRg/gᴴg = Σ_m ρ(m) A(m)` times its variance in white noise of the same
//! level, with the autocorrelation A of g. For a pole of decay rate σ and line spacing Δ, and with
//! `s = 1 + imΔ/2σ`, `A = 1/s` for the amplitude, and `A = 1/s − 2/s² + 2/s³` for the pole, whose
//! profile is the derivative orthogonalised to the line shape itself. In time these are `e^(−u)`
//! and `(1 − u)² e^(−u)`, `u = 2σt`.
//!
//! The correlation is estimated from the residual of a fit on those segments of the band where it
//! does not exceed the noise; the residual of a missing mode is correlated as well. Only phases are
//! used, so that a few large values have no more weight than others, and of the segments the
//! median. For circular Gaussian values of correlation ρ the mean product of phases is `(π/4) ρ
//! ₂F₁(1/2, 1/2; 2; |ρ|²)` (Middleton 1960, An Introduction to Statistical Communication Theory,
//! section 9.1).
//!
//! Noise that begins with the record, as all noise under a window does, has `ic/m` for long lags.
//! Each of these is too small to estimate, but their sum is up to half of the noise of a mode that
//! decays long before the noise does; c follows from the estimated lags.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::data::residual::Residual;
use crate::linalg::vectorised;

/// Maximum number of segments of the band.
const MAX_SEGMENTS: usize = 16;
/// Minimum number of lines in a segment.
const MIN_SEGMENT_LINES: usize = 32;
/// Maximum power of a segment of noise alone, over the noise.
const MAX_SEGMENT_POWER: f64 = 2.0;
/// Minimum fraction of segments of noise alone.
const MIN_SEGMENT_FRACTION: f64 = 0.2;
/// Minimum correlation of a lag that is kept.
const MIN_LAG_CORRELATION: f64 = 0.02;
/// Minimum mean square of the second difference of unit noise.
const MIN_DIFFERENCE_SQUARE: f64 = 0.1;
/// Longest lag, as a fraction of a segment.
const MAX_LAG_OVER_SEGMENT: f64 = 0.5;
/// Minimum significance of a lag, standard deviations.
const MIN_LAG_STDS: f64 = 4.0;
/// Variance of a median over that of a mean.
const MEDIAN_VARIANCE_RATIO: f64 = std::f64::consts::FRAC_PI_2;
/// Terms of the hypergeometric series and steps of its inversion.
const SERIES_TERMS: usize = 400;
const BISECTION_STEPS: usize = 50;

/// Mean square of the second difference of unit noise below which it is small.
const SMALL_DIFFERENCE_SQUARE: f64 = 3.0;
/// Criteria of independent noise in each FRF: minimum number of segments of noise alone, maximum
/// mean product of phases from half the longest lag on, and maximum similarity of two FRFs.
const LONG_SEGMENTS: usize = 8;
const MAX_DISTANT_PRODUCT: f64 = 0.3;
const MAX_FRF_SIMILARITY: f64 = 0.4;
/// Maximum similarity in long segments: noise under a window over 100 time constants has 0.24, the
/// residual of three of many modes 0.4 to 0.6.
const MAX_LONG_SEGMENT_SIMILARITY: f64 = 0.32;

/// Magnitudes of the correlation that the decay rate of the noise is estimated from.
const DECAY_MAGNITUDES: Range<f64> = 0.3..0.9;
/// Minimum `Im ρ/|ρ|` of these, which is 0.4 to 1 where noise begins with the record, and 0 where
/// it is stationary and was smoothed.
const MIN_DECAY_PHASE: f64 = 0.3;

/// Longest lag of a series, as a part of it, and minimum number of pairs of values for a lag.
const SERIES_OVER_LONGEST_LAG: usize = 4;
const MIN_LAG_PAIRS: f64 = 40.0;
/// Lags that are summed at once: the sum of one waits for each addition.
const LAGS_AT_ONCE: usize = 8;

/// Correlation of noise between frequency lines.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct LineCorrelation {
    /// `E[r_k conj(r_(k+m))]` over the variance, from m = 1.
    lags: Vec<Complex64>,
}

impl LineCorrelation {
    /// Of noise that is white over the lines.
    pub const WHITE: Self = Self { lags: Vec::new() };

    /// Of noise under an exponential window `e^(−at)` over the whole record, whose inverse length
    /// is the spacing of the lines: `ρ(m) = 1/(1 − imΔ/2a)`, as far as there are lines.
    pub fn of_window(added_damping_rad_s: f64, step: f64, lines: usize) -> Self {
        // That holds where the window decays within the record.
        if added_damping_rad_s * std::f64::consts::TAU / step <= 1.0 {
            return Self::WHITE;
        }
        let ratio = step / (2.0 * added_damping_rad_s);
        let lag = |m: usize| Complex64::new(1.0, -ratio * m as f64).inv();
        Self {
            lags: (1..=lines).map(lag).collect(),
        }
    }

    /// Correlation of the given lags, from that of adjacent lines.
    pub fn of_lags(lags: Vec<Complex64>) -> Self {
        Self { lags }
    }

    /// Estimate from the residual of a fit; `None` where it exceeds the noise nearly everywhere.
    pub fn from_residual(rest: &Residual) -> Option<Self> {
        Some(NoiseSegments::new(rest, MAX_SEGMENTS)?.correlation())
    }

    /// As [`Self::from_residual`], where the residual can only be noise with small second
    /// differences: every FRF has an independent profile, and distant lines of a segment are
    /// uncorrelated.
    pub fn of_correlated_noise(rest: &Residual) -> Option<Self> {
        let is_independent = |noise: &NoiseSegments| {
            let (enough_segments, longest) =
                (noise.segments.len() >= LONG_SEGMENTS, noise.longest_lag());
            let decays = || {
                let mut lags = longest / 2..longest + 1;
                std::iter::from_fn(|| next_lags(&mut lags, LAGS_AT_ONCE))
                    .flat_map(|lags| noise.products(lags))
                    .all(|product| product.norm() < MAX_DISTANT_PRODUCT)
            };
            enough_segments && noise.similarity() < MAX_FRF_SIMILARITY && decays()
        };
        let mut noise = [MAX_SEGMENTS, LONG_SEGMENTS].into_iter();
        let noise =
            noise.find_map(|segments| NoiseSegments::new(rest, segments).filter(is_independent))?;
        Some(noise.correlation()).filter(Self::has_small_second_differences)
    }

    /// Whether the FRFs have independent residuals, in long segments, where noise correlated over
    /// many lines is no longer similar at random.
    pub fn frfs_have_independent_noise(rest: &Residual) -> bool {
        NoiseSegments::new(rest, LONG_SEGMENTS)
            .is_some_and(|noise| noise.similarity() < MAX_LONG_SEGMENT_SIMILARITY)
    }

    /// Estimate from the phases of series of values, 0 where there is none; `None` for too few
    /// values.
    pub fn from_phases(series: &[Vec<Complex64>]) -> Option<Self> {
        let lines = series.iter().map(Vec::len).max().unwrap_or(0);
        let series: Vec<PhaseParts> = series
            .iter()
            .map(|phases| PhaseParts::new(phases))
            .collect();
        let mut sums = [(Complex64::ZERO, 0.0); LAGS_AT_ONCE];
        let mut lags = Vec::new();
        for lag in 1..lines / SERIES_OVER_LONGEST_LAG {
            let place = (lag - 1) % LAGS_AT_ONCE;
            if place == 0 {
                sums = sums_of_lags(&series, lag);
            }
            let (sum, pairs) = sums[place];
            let product = sum / pairs;
            let limit = MIN_LAG_STDS * (0.5 / pairs).sqrt();
            if pairs < MIN_LAG_PAIRS && lag == 1 {
                return None;
            }
            // Lags after the first insignificant one are noise; so are lags of few pairs.
            if pairs < MIN_LAG_PAIRS || product.re.abs() < limit && product.im.abs() < limit {
                break;
            }
            lags.push(correlation(product));
        }
        Some(Self { lags })
    }

    /// Variance of the amplitude of a pole over that under white noise, at least 1; `step` is the
    /// spacing of the lines, rad/s.
    pub fn amplitude_noise_factor(&self, decay: f64, step: f64) -> f64 {
        self.factor(decay, step, |s| s.inv())
    }

    /// Variance of the pole itself over that under white noise, at least 1.
    pub fn pole_noise_factor(&self, decay: f64, step: f64) -> f64 {
        self.factor(decay, step, |s| s.inv() - 2.0 / (s * s) + 2.0 / (s * s * s))
    }

    fn factor(
        &self,
        decay: f64,
        step: f64,
        autocorrelation: impl Fn(Complex64) -> Complex64,
    ) -> f64 {
        let ratio = step / (2.0 * decay);
        let term = |(index, rho): (usize, &Complex64)| {
            let s = Complex64::new(1.0, ratio * (index + 1) as f64);
            2.0 * (rho * autocorrelation(s)).re
        };
        (1.0 + self.lags.iter().enumerate().map(term).sum::<f64>()).max(1.0)
    }

    /// ρ(m), 0 beyond the last lag.
    pub fn lag(&self, m: usize) -> Complex64 {
        match m {
            0 => Complex64::ONE,
            _ => self.lags.get(m - 1).copied().unwrap_or(Complex64::ZERO),
        }
    }

    /// Number of values with the information of one independent value, where powers are summed: `Σ
    /// |ρ|²` over all lags.
    pub fn lines_per_effective_line(&self) -> f64 {
        1.0 + 2.0 * self.lags.iter().map(Complex64::norm_sqr).sum::<f64>()
    }

    /// Decay rate a of noise that decays as `e^(−at)`, with `ρ = 1/(1 − imx)`, `x = Δ/2a`, 1/s,
    /// from the magnitude of ρ; `step` is Δ in rad/s. `None` where its phase differs from that, as
    /// after smoothing over the lines.
    pub fn decay(&self, step: f64) -> Option<f64> {
        let lags = self.lags.iter().enumerate();
        let lags: Vec<(f64, Complex64)> = lags
            .map(|(n, rho)| ((n + 1) as f64, *rho))
            .take_while(|(_, rho)| rho.norm() > DECAY_MAGNITUDES.start)
            .filter(|(_, rho)| rho.norm() < DECAY_MAGNITUDES.end)
            .collect();
        if lags.is_empty() {
            return None;
        }
        let phase = median(lags.iter().map(|(_, rho)| rho.im / rho.norm()).collect());
        let ratio = |(m, rho): &(f64, Complex64)| (1.0 / rho.norm_sqr() - 1.0).sqrt() / m;
        let ratio = median(lags.iter().map(ratio).collect());
        (phase > MIN_DECAY_PHASE).then(|| 0.5 * step / ratio)
    }

    /// Whether second differences contain little of the noise.
    pub fn has_small_second_differences(&self) -> bool {
        self.second_difference_square() < SMALL_DIFFERENCE_SQUARE
    }

    /// Mean square of the second difference of unit noise, 6 for white.
    pub fn second_difference_square(&self) -> f64 {
        (6.0 - 8.0 * self.lag(1).re + 2.0 * self.lag(2).re).max(MIN_DIFFERENCE_SQUARE)
    }
}

/// A series of phases by part, with zeros behind it for as many lags as are summed at once.
struct PhaseParts {
    re: Vec<f64>,
    im: Vec<f64>,
    square: Vec<f64>,
    /// Number of phases.
    len: usize,
}

impl PhaseParts {
    fn new(phases: &[Complex64]) -> Self {
        let part = |of: fn(&Complex64) -> f64| {
            let zeros = std::iter::repeat_n(0.0, LAGS_AT_ONCE);
            phases.iter().map(of).chain(zeros).collect()
        };
        Self {
            re: part(|phase| phase.re),
            im: part(|phase| phase.im),
            square: part(Complex64::norm_sqr),
            len: phases.len(),
        }
    }
}

/// Sums of the products `a conj(b)` of phases `first` lines apart and of their squared magnitudes,
/// and of those of the next lags; each in the order of the lines.
fn sums_of_lags(series: &[PhaseParts], first: usize) -> [(Complex64, f64); LAGS_AT_ONCE] {
    vectorised(
        #[inline(always)]
        || {
            let mut re = [0.0; LAGS_AT_ONCE];
            let mut im = [0.0; LAGS_AT_ONCE];
            let mut squares = [0.0; LAGS_AT_ONCE];
            for phases in series {
                for k in 0..phases.len.saturating_sub(first) {
                    let others = k + first..k + first + LAGS_AT_ONCE;
                    let (b_re, b_im) = (&phases.re[others.clone()], &phases.im[others.clone()]);
                    let b_square = &phases.square[others];
                    let (a_re, a_im, a_square) = (phases.re[k], phases.im[k], phases.square[k]);
                    for n in 0..LAGS_AT_ONCE {
                        re[n] += a_re * b_re[n] + a_im * b_im[n];
                        im[n] += a_im * b_re[n] - a_re * b_im[n];
                        squares[n] += a_square * b_square[n];
                    }
                }
            }
            std::array::from_fn(|n| (Complex64::new(re[n], im[n]), squares[n]))
        },
    )
}

/// The next lags of a range, at most a given number; `None` at its end.
fn next_lags(lags: &mut Range<usize>, most: usize) -> Option<Range<usize>> {
    let next = lags.start..lags.end.min(lags.start + most);
    lags.start = next.end;
    (!next.is_empty()).then_some(next)
}

/// Segments where the residual does not exceed the noise.
struct NoiseSegments<'a> {
    /// Lines of each segment, all of one length.
    segments: Vec<Range<usize>>,
    rest: &'a Residual,
}

impl<'a> NoiseSegments<'a> {
    /// Divides the band into at most `most` segments; `None` where too few are noise alone.
    fn new(rest: &'a Residual, most: usize) -> Option<Self> {
        let (lines, functions) = (rest.lines.len(), rest.functions());
        let count = (lines / MIN_SEGMENT_LINES).clamp(1, most);
        let length = lines / count;
        let power = |segment: &Range<usize>| {
            let of = |f: usize| {
                let values = rest.of(f, on_lines(rest, segment));
                values.map(|value| value.norm_sqr()).sum::<f64>()
            };
            (0..functions).map(of).sum::<f64>() / (length * functions) as f64
        };
        let segments: Vec<Range<usize>> = (0..count)
            .into_par_iter()
            .map(|n| n * length..(n + 1) * length)
            .filter(|segment| power(segment) < MAX_SEGMENT_POWER)
            .collect();
        if (segments.len() as f64) < MIN_SEGMENT_FRACTION * count as f64 {
            return None;
        }
        Some(Self { segments, rest })
    }

    fn functions(&self) -> usize {
        self.rest.functions()
    }

    /// Phases of an FRF on the lines of a segment; 0 where the residual is 0.
    fn phases(&self, function: usize, segment: &Range<usize>) -> Vec<Complex64> {
        let values = self.rest.of(function, on_lines(self.rest, segment));
        values.map(phase).collect()
    }

    fn length(&self) -> usize {
        self.segments[0].len()
    }

    /// Longest lag.
    fn longest_lag(&self) -> usize {
        (MAX_LAG_OVER_SEGMENT * self.length() as f64) as usize
    }

    fn correlation(&self) -> LineCorrelation {
        let values = (self.segments.len() * self.length() * self.functions()) as f64;
        let limit = MIN_LAG_STDS * (MEDIAN_VARIANCE_RATIO / (2.0 * values)).sqrt();
        let mut lags = Vec::new();
        let mut products = Vec::new();
        for lag in 1..=self.longest_lag() {
            if products.len() < lag {
                // White noise ends at the first lag, other noise after dozens.
                let last = (2 * lag - 1)
                    .min(lag + LAGS_AT_ONCE - 1)
                    .min(self.longest_lag());
                products.extend(self.products(lag..last + 1));
            }
            let product = products[lag - 1];
            // Lags after the first insignificant one are noise, and a fit of many columns leaves a
            // little correlation.
            let limit = limit.max(MIN_LAG_CORRELATION);
            if product.re.abs() < limit && product.im.abs() < limit {
                break;
            }
            lags.push(correlation(product));
        }
        let count = lags.len();
        // The first rejected lag enters the mean: noise in a part of the record has zeros there.
        let tail_factor = if count < self.longest_lag() {
            let stop = correlation(products[count]);
            tail_coefficient(&[lags.as_slice(), &[stop]].concat(), 0)
        } else {
            tail_coefficient(&lags, count / 2)
        };
        let tail = (count + 1..=self.rest.lines.len()).filter(|_| count > 0);
        lags.extend(tail.map(|m| Complex64::new(0.0, tail_factor / m as f64)));
        LineCorrelation { lags }
    }

    /// Median over the segments of the mean product of phases a lag apart, for each of some lags,
    /// lines.
    fn products(&self, lags: Range<usize>) -> Vec<Complex64> {
        let of_segment = |segment: &Range<usize>| self.mean_products(segment, lags.clone());
        let products: Vec<Vec<Complex64>> = self.segments.par_iter().map(of_segment).collect();
        let of_lag = |index: usize| {
            Complex64::new(
                median(products.iter().map(|products| products[index].re).collect()),
                median(products.iter().map(|products| products[index].im).collect()),
            )
        };
        (0..lags.len()).map(of_lag).collect()
    }

    /// Mean products of the phases of a segment a lag apart.
    fn mean_products(&self, segment: &Range<usize>, lags: Range<usize>) -> Vec<Complex64> {
        let mut sums = vec![Complex64::ZERO; lags.len()];
        for f in 0..self.functions() {
            let phases = self.phases(f, segment);
            for (sum, lag) in sums.iter_mut().zip(lags.clone()) {
                let pairs = phases.iter().zip(&phases[lag..]);
                *sum += pairs.map(|(a, b)| a * b.conj()).sum::<Complex64>();
            }
        }
        let pairs = lags.map(|lag| ((segment.len() - lag) * self.functions()) as f64);
        sums.iter()
            .zip(pairs)
            .map(|(sum, pairs)| sum / pairs)
            .collect()
    }

    /// Similarity of neighbouring FRFs: mean square of their mean product of phases over a segment.
    fn similarity(&self) -> f64 {
        let sum = |segment: &Range<usize>| {
            let mut before = self.phases(0, segment);
            let square = |f: usize| {
                let now = self.phases(f, segment);
                let products = before.iter().zip(&now).map(|(a, b)| a * b.conj());
                let mean = products.sum::<Complex64>() / self.length() as f64;
                before = now;
                mean.norm_sqr()
            };
            (1..self.functions()).map(square).sum::<f64>()
        };
        let sums: Vec<f64> = self.segments.par_iter().map(sum).collect();
        let pairs = (self.functions() - 1) * self.segments.len();
        sums.iter().sum::<f64>() / pairs as f64
    }
}

/// `c` of the `ic/m` of noise that begins with the record, for lags too long to be estimated: each
/// is small, their sum is half of the noise of a mode that decays long before the noise does. Mean
/// of `m Im ρ` from the lag `from`.
fn tail_coefficient(lags: &[Complex64], from: usize) -> f64 {
    let used = lags.iter().enumerate().skip(from);
    let sum: f64 = used.map(|(n, rho)| (n + 1) as f64 * rho.im).sum();
    sum / (lags.len() - from).max(1) as f64
}

/// Lines of a segment, which counts from the first line of the residual.
fn on_lines(rest: &Residual, segment: &Range<usize>) -> Range<usize> {
    rest.lines.start + segment.start..rest.lines.start + segment.end
}

fn phase(value: Complex64) -> Complex64 {
    let size = value.norm_sqr().sqrt();
    if size > 0.0 && size.is_finite() {
        value / size
    } else {
        Complex64::ZERO
    }
}

pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[values.len() / 2] + values[(values.len() - 1) / 2])
}

/// Correlation of Gaussian values from the mean product of their phases.
fn correlation(product: Complex64) -> Complex64 {
    let size = product.norm();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTION_STEPS {
        let middle = 0.5 * (low + high);
        if product_of_phases(middle) < size {
            low = middle;
        } else {
            high = middle;
        }
    }
    product * (0.5 * (low + high) / size)
}

fn product_of_phases(rho: f64) -> f64 {
    let square = rho * rho;
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 0..SERIES_TERMS {
        let half = n as f64 + 0.5;
        term *= square * half * half / ((n as f64 + 2.0) * (n as f64 + 1.0));
        sum += term;
        // The terms decrease: no later one changes the sum, either.
        if term < 0.25 * f64::EPSILON * sum {
            break;
        }
    }
    std::f64::consts::FRAC_PI_4 * rho * sum
}

#[cfg(test)]
#[path = "line_correlation_tests.rs"]
mod tests;
