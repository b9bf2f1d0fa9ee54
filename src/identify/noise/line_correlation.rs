//! How the noise of neighbouring lines hangs together, and what that does to what a root collects
//! of it.
//!
//! Noise is white over the lines only where it is even over the record. A window on the responses,
//! a force that is set to zero after the pulse, or zeros behind a record leave it in a part of the
//! record, and the lines then share it: its course has bumps as wide as those of modes. With the
//! correlation `ρ(m)` over `m` lines, a course `g` over the lines collects `gᴴRg/gᴴg = Σ_m ρ(m)
//! A(m)` times the variance that white noise of the same level gives, with the autocorrelation A of
//! g. For a root of decay rate σ and lines Δ apart, and with `s = 1 + imΔ/2σ`, `A = 1/s` for the
//! amplitude, and `A = 1/s − 2/s² + 2/s³` for the pole, whose course is what is left of the
//! derivative beside the root itself. In time these are `e^(−u)` and `(1 − u)² e^(−u)`, `u = 2σt`.
//!
//! The correlation is told from what a fit leaves over on those stretches of the band where that is
//! no more than the noise; what a mode leaves that is missing hangs together as well. Only phases
//! are used, so that a few large values count no more than others, and of the stretches the median.
//! For circular Gaussian values of correlation ρ the mean product of phases is `(π/4) ρ ₂F₁(1/2,
//! 1/2; 2; |ρ|²)` (Middleton 1960, An Introduction to Statistical Communication Theory, section
//! 9.1).
//!
//! Noise that begins at once with the record, as all noise under a window does, has `ic/m` for long
//! lags. Each of these is too small to be told, but all together are up to half of what a mode
//! collects that decays long before the noise does; c follows from the lags that are told.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::data::residual::Rest;

/// Stretches of the band that are looked at each by itself.
const STRETCHES: usize = 16;
/// Fewest lines of a stretch.
const FEWEST_LINES: usize = 32;
/// Most power of a stretch, over the noise.
const QUIET: f64 = 2.0;
/// Fewest quiet stretches, as a share of all.
const ENOUGH: f64 = 0.2;
/// Correlation below which lags are left out.
const LEAST: f64 = 0.02;
/// Least mean square of a second difference that is believed.
const LEAST_DIFFERENCE: f64 = 0.1;
/// Longest lag, as a share of a stretch.
const LONGEST: f64 = 0.5;
/// What is this many deviations from 0 is no chance.
const CERTAIN: f64 = 4.0;
/// Variance of a median over that of a mean.
const OF_MEDIAN: f64 = std::f64::consts::FRAC_PI_2;
/// Terms of the hypergeometric series and steps of its inversion.
const TERMS: usize = 400;
const HALVINGS: usize = 50;

/// Mean square of a second difference of unit noise that is little.
const LITTLE: f64 = 3.0;
/// Noise that each function has for itself: fewest quiet stretches, largest mean product of phases
/// half-way to the longest lag and beyond, and how alike two functions are at most.
const FEWEST_STRETCHES: usize = 8;
const GONE: f64 = 0.3;
const MOST_ALIKE: f64 = 0.4;
/// The same in long stretches: noise of a window over 100 time constants has 0.24, what three of
/// many modes leave 0.4 to 0.6.
const LITTLE_ALIKE: f64 = 0.32;

/// Sizes of a correlation that tell how noise decays.
const CLEAR: Range<f64> = 0.3..0.9;
/// Least `Im ρ/|ρ|` of these, which is 0.4 to 1 where noise begins with the record, and 0 where it
/// is even and was smoothed.
const LEAST_PHASE: f64 = 0.3;

/// Longest lag of a series, as a part of it, and fewest pairs of values that tell one.
const LAGS: usize = 4;
const FEWEST_PAIRS: f64 = 40.0;

/// Correlation of noise over lines.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Correlation {
    /// `E[r_k conj(r_(k+m))]` over the variance, from m = 1.
    lags: Vec<Complex64>,
}

impl Correlation {
    /// Of noise that is white over the lines.
    pub const WHITE: Self = Self { lags: Vec::new() };

    /// Of noise under an exponential window `e^(−at)` over the whole record, whose inverse length
    /// is the spacing of the lines: `ρ(m) = 1/(1 − imΔ/2a)`, as far as there are lines.
    pub fn of_window(added_damping_rad_s: f64, (step, lines): (f64, usize)) -> Self {
        // The window has to fall within the record for that.
        if added_damping_rad_s * std::f64::consts::TAU / step <= 1.0 {
            return Self::WHITE;
        }
        let ratio = step / (2.0 * added_damping_rad_s);
        let lag = |m: usize| Complex64::new(1.0, -ratio * m as f64).inv();
        Self {
            lags: (1..=lines).map(lag).collect(),
        }
    }

    /// Of some lags, from that of neighbours on.
    pub fn of_lags(lags: Vec<Complex64>) -> Self {
        Self { lags }
    }

    /// Of what a fit leaves over. `None` where it is more than noise nearly everywhere.
    pub fn of_rest(rest: &Rest) -> Option<Self> {
        Some(Quiet::new(rest, STRETCHES)?.correlation())
    }

    /// As [`Self::of_rest`], where it can be nothing but noise of which second differences hold
    /// little: every function has its own, and lines of a stretch that are far apart share none.
    pub fn of_own_noise(rest: &Rest) -> Option<Self> {
        let own_noise = |quiet: &Quiet| {
            let (enough, longest) = (quiet.stretches.len() >= FEWEST_STRETCHES, quiet.longest());
            let gone = || (longest / 2..=longest).all(|lag| quiet.product(lag).norm() < GONE);
            enough && quiet.alike() < MOST_ALIKE && gone()
        };
        let mut quiet = [STRETCHES, FEWEST_STRETCHES].into_iter();
        let quiet = quiet.find_map(|most| Quiet::new(rest, most).filter(own_noise))?;
        Some(quiet.correlation()).filter(Self::differences_hold_little)
    }

    /// Whether every function has a course of its own in what is left over, in long stretches,
    /// where noise that lines share far apart is alike by chance no longer.
    pub fn functions_differ(rest: &Rest) -> bool {
        Quiet::new(rest, FEWEST_STRETCHES).is_some_and(|quiet| quiet.alike() < LITTLE_ALIKE)
    }

    /// Of the phases of some series of values, 0 where there is none. `None` where they are too few
    /// to tell.
    pub fn of_phases(series: &[Vec<Complex64>]) -> Option<Self> {
        let lines = series.iter().map(Vec::len).max().unwrap_or(0);
        let mut lags = Vec::new();
        for lag in 1..lines / LAGS {
            let (mut sum, mut pairs) = (Complex64::ZERO, 0.0);
            for phases in series {
                for (a, b) in phases.iter().zip(&phases[lag..]) {
                    sum += a * b.conj();
                    pairs += a.norm_sqr() * b.norm_sqr();
                }
            }
            let own = sum / pairs;
            let limit = CERTAIN * (0.5 / pairs).sqrt();
            if pairs < FEWEST_PAIRS && lag == 1 {
                return None;
            }
            // What comes after the first that chance makes is chance; so is all of a few.
            if pairs < FEWEST_PAIRS || own.re.abs() < limit && own.im.abs() < limit {
                break;
            }
            lags.push(correlation(own));
        }
        Some(Self { lags })
    }

    /// Variance of a root's amplitude over that under white noise, 1 at least; `step` is the
    /// spacing of the lines, rad/s.
    pub fn of_amplitude(&self, decay: f64, step: f64) -> f64 {
        self.factor(decay, step, |s| s.inv())
    }

    /// The same of its pole.
    pub fn of_pole(&self, decay: f64, step: f64) -> f64 {
        self.factor(decay, step, |s| s.inv() - 2.0 / (s * s) + 2.0 / (s * s * s))
    }

    fn factor(&self, decay: f64, step: f64, course: impl Fn(Complex64) -> Complex64) -> f64 {
        let ratio = step / (2.0 * decay);
        let term = |(place, rho): (usize, &Complex64)| {
            let s = Complex64::new(1.0, ratio * (place + 1) as f64);
            2.0 * (rho * course(s)).re
        };
        (1.0 + self.lags.iter().enumerate().map(term).sum::<f64>()).max(1.0)
    }

    /// ρ(m), 0 where nothing hangs together any more.
    pub fn lag(&self, m: usize) -> Complex64 {
        match m {
            0 => Complex64::ONE,
            _ => self.lags.get(m - 1).copied().unwrap_or(Complex64::ZERO),
        }
    }

    /// Values that count for one where powers are added up: `Σ |ρ|²` over all lags.
    pub fn alike(&self) -> f64 {
        1.0 + 2.0 * self.lags.iter().map(Complex64::norm_sqr).sum::<f64>()
    }

    /// Decay rate a of noise that falls as `e^(−at)`, of `ρ = 1/(1 − imx)`, `x = Δ/2a`, 1/s, from
    /// its magnitude; `step` is Δ in rad/s. `None` where its phase is far from that, as after
    /// smoothing over the lines.
    pub fn decay(&self, step: f64) -> Option<f64> {
        let own = self.lags.iter().enumerate();
        let own: Vec<(f64, Complex64)> = own
            .map(|(n, rho)| ((n + 1) as f64, *rho))
            .take_while(|(_, rho)| rho.norm() > CLEAR.start)
            .filter(|(_, rho)| rho.norm() < CLEAR.end)
            .collect();
        if own.is_empty() {
            return None;
        }
        let phase = median(own.iter().map(|(_, rho)| rho.im / rho.norm()).collect());
        let by_size = |(m, rho): &(f64, Complex64)| (1.0 / rho.norm_sqr() - 1.0).sqrt() / m;
        let by_size = median(own.iter().map(by_size).collect());
        (phase > LEAST_PHASE).then(|| 0.5 * step / by_size)
    }

    /// Whether second differences hold little of the noise.
    pub fn differences_hold_little(&self) -> bool {
        self.of_second_difference() < LITTLE
    }

    /// Mean square of the second difference of unit noise, 6 for white.
    pub fn of_second_difference(&self) -> f64 {
        (6.0 - 8.0 * self.lag(1).re + 2.0 * self.lag(2).re).max(LEAST_DIFFERENCE)
    }
}

/// Phases of what a fit leaves over where that is no more than noise.
struct Quiet {
    /// Lines of each stretch, of one length.
    stretches: Vec<Range<usize>>,
    /// By function and line; 0 where there is none.
    phases: Vec<Vec<Complex64>>,
    /// Lines of the band.
    lines: usize,
}

impl Quiet {
    /// Of so many stretches at most; `None` where too few are quiet.
    fn new(rest: &Rest, most: usize) -> Option<Self> {
        let (lines, functions) = (rest.lines.len(), rest.values.ncols());
        let count = (lines / FEWEST_LINES).clamp(1, most);
        let length = lines / count;
        let power = |stretch: &Range<usize>| {
            let of = |f: usize| {
                let own = rest.values.col_as_slice(f)[stretch.clone()].iter();
                own.map(Complex64::norm_sqr).sum::<f64>()
            };
            (0..functions).map(of).sum::<f64>() / (length * functions) as f64
        };
        let stretches: Vec<Range<usize>> = (0..count)
            .into_par_iter()
            .map(|n| n * length..(n + 1) * length)
            .filter(|stretch| power(stretch) < QUIET)
            .collect();
        if (stretches.len() as f64) < ENOUGH * count as f64 {
            return None;
        }
        let phases = (0..functions)
            .into_par_iter()
            .map(|f| rest.values.col_as_slice(f).iter().map(phase).collect());
        Some(Self {
            stretches,
            phases: phases.collect(),
            lines,
        })
    }

    fn length(&self) -> usize {
        self.stretches[0].len()
    }

    /// Longest lag.
    fn longest(&self) -> usize {
        (LONGEST * self.length() as f64) as usize
    }

    fn correlation(&self) -> Correlation {
        let values = (self.stretches.len() * self.length() * self.phases.len()) as f64;
        let limit = CERTAIN * (OF_MEDIAN / (2.0 * values)).sqrt();
        let mut lags = Vec::new();
        for lag in 1..=self.longest() {
            let own = self.product(lag);
            // What comes after the first that chance makes is chance, and a fit of many columns
            // leaves a little of its own.
            let limit = limit.max(LEAST);
            if own.re.abs() < limit && own.im.abs() < limit {
                break;
            }
            lags.push(correlation(own));
        }
        let told = lags.len();
        // What stopped it belongs to the mean: noise of a part of the record has zeros there.
        let begin = if told < self.longest() {
            let stop = correlation(self.product(told + 1));
            beginning(&[lags.as_slice(), &[stop]].concat(), 0)
        } else {
            beginning(&lags, told / 2)
        };
        let tail = (told + 1..=self.lines).filter(|_| told > 0);
        lags.extend(tail.map(|m| Complex64::new(0.0, begin / m as f64)));
        Correlation { lags }
    }

    /// Median over the stretches of the mean product of phases so many lines apart.
    fn product(&self, lag: usize) -> Complex64 {
        let products: Vec<Complex64> = self
            .stretches
            .par_iter()
            .map(|stretch| mean_product(&self.phases, stretch.clone(), lag))
            .collect();
        Complex64::new(
            median(products.iter().map(|p| p.re).collect()),
            median(products.iter().map(|p| p.im).collect()),
        )
    }

    /// How alike the courses of neighbouring functions are: mean square of their mean product of
    /// phases over a stretch.
    fn alike(&self) -> f64 {
        let square = |(a, b): (&Vec<Complex64>, &Vec<Complex64>), stretch: &Range<usize>| {
            let product = stretch.clone().map(|k| a[k] * b[k].conj());
            (product.sum::<Complex64>() / self.length() as f64).norm_sqr()
        };
        let pairs = || self.phases.iter().zip(&self.phases[1..]);
        let sum = |stretch| pairs().map(|pair| square(pair, stretch)).sum::<f64>();
        let sum: f64 = self.stretches.iter().map(sum).sum();
        sum / (pairs().count() * self.stretches.len()) as f64
    }
}

/// `c` of the `ic/m` that noise which begins at once with the record has for lags too long to be
/// told: each is next to nothing, all together are half of what a mode collects that decays long
/// before the noise does. Mean of `m Im ρ` from some lag on.
fn beginning(lags: &[Complex64], from: usize) -> f64 {
    let told = lags.iter().enumerate().skip(from);
    let sum: f64 = told.map(|(n, rho)| (n + 1) as f64 * rho.im).sum();
    sum / (lags.len() - from).max(1) as f64
}

fn phase(value: &Complex64) -> Complex64 {
    let size = value.norm_sqr().sqrt();
    if size > 0.0 && size.is_finite() {
        value / size
    } else {
        Complex64::ZERO
    }
}

fn mean_product(phases: &[Vec<Complex64>], stretch: Range<usize>, lag: usize) -> Complex64 {
    let last = stretch.end - lag;
    let own = |values: &Vec<Complex64>| -> Complex64 {
        (stretch.start..last)
            .map(|k| values[k] * values[k + lag].conj())
            .sum()
    };
    phases.iter().map(own).sum::<Complex64>() / ((last - stretch.start) * phases.len()) as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[values.len() / 2] + values[(values.len() - 1) / 2])
}

/// Correlation of Gaussian values from the mean product of their phases.
fn correlation(product: Complex64) -> Complex64 {
    let size = product.norm();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
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
    for n in 0..TERMS {
        let half = n as f64 + 0.5;
        term *= square * half * half / ((n as f64 + 2.0) * (n as f64 + 1.0));
        sum += term;
    }
    std::f64::consts::FRAC_PI_4 * rho * sum
}

#[cfg(test)]
#[path = "line_correlation_tests.rs"]
mod tests;
