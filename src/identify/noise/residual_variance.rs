//! The noise of functions as what a fit leaves over of them tells it.
//!
//! What is a function's own came with the data, or second differences tell it, or the level of what
//! is left over. Noise of the force goes with |H|² (`v = a + b|H|²`,
//! [`noise_course`](crate::identify::noise::variance_model)), and between resonances it may be more than what is the
//! function's own: there second differences tell both, and a missing mode puts little into them.
//! Within resonances what is left over tells b alone, beside an `a` that is known.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::noise::input_variance::{Squares, raise_to_floor};
use crate::identify::noise::variance_model::{self, Estimated, Smooth};

/// Times that what is a function's own is told beside the noise of the force, and its least part of
/// what was told without: medians of some hundred lines tell no less.
const BESIDE_FORCE: usize = 2;
const LEAST_OWN: f64 = 0.1;
/// Power over its median up to which a line is outside resonances.
const OUTSIDE: f64 = 30.0;
/// Mean square of the logarithm by which variances that a running median tells of white noise
/// differ from it, 0.023 (simulated), with room for chance.
const MOST_SCATTER: f64 = 0.035;
/// Lines whose sums stay in the nearest cache.
const LINES_AT_ONCE: usize = 1024;

/// A function of which a fit leaves something over.
pub(in crate::identify) struct LeftOver {
    /// What is left over at every line, beside |H|² as measured and variances of the function's
    /// own.
    left: Estimated,
    /// What tells these variances, where they did not come with the data.
    told: Option<Squares>,
    /// |H|² of the fit alone: noise of a line has no part in it.
    fitted: Vec<f64>,
}

/// What tells the noise of a function.
pub(in crate::identify) enum Source {
    /// Variances that came with the data.
    Stated(Vec<f64>),
    /// Second differences of what a fit leaves over; with the mean square of those of unit noise, 6
    /// for white noise.
    SecondDifferences(f64),
    /// The level of what a fit leaves over.
    Level,
}

impl LeftOver {
    /// Of H, and what is left over of it; `alike` lines count for one.
    pub fn new(values: &[Complex64], rest: &[Complex64], (source, alike): (Source, f64)) -> Self {
        let power = values.iter().map(Complex64::norm_sqr).collect();
        let fit = values.iter().zip(rest);
        let fitted = fit.map(|(h, rest)| (h - rest).norm_sqr()).collect();
        let left: Vec<f64> = rest.iter().map(Complex64::norm_sqr).collect();
        let (own, told) = match source {
            Source::Stated(own) => (own, None),
            Source::SecondDifferences(of_unit) => {
                let mut squares = Squares::of_second_differences(rest);
                squares.values.iter_mut().for_each(|v| *v *= 6.0 / of_unit);
                (squares.variance(), Some(squares))
            }
            Source::Level => {
                let squares = Squares::of_level(&left);
                (squares.variance(), Some(squares))
            }
        };
        let mut new = Self {
            left: Estimated {
                variance: left,
                power,
                degrees_of_freedom: Some(2.0),
                alike,
                own: None,
            },
            told,
            fitted,
        };
        new.set_own(own);
        new
    }

    /// What its second differences tell of some lines, over its own variances as told before: what
    /// changes slowly is these.
    fn differences_at(&self, lines: &[usize]) -> Option<Estimated> {
        let (told, own) = (self.told.as_ref()?, self.left.own.as_ref()?);
        let mean = |k: &usize| std::f64::consts::LN_2 * told.values[*k] / own[*k];
        Some(Estimated {
            variance: lines.iter().map(mean).collect(),
            power: lines.iter().map(|k| self.fitted[*k] / own[*k]).collect(),
            degrees_of_freedom: Some(2.0),
            alike: self.left.alike * told.differences_alike?,
            own: None,
        })
    }

    fn told_by_differences(&self) -> Option<&Squares> {
        let told = self.told.as_ref();
        told.filter(|told| told.differences_alike.is_some())
    }

    /// Tells its own variances beside a part of |H|² that the force makes.
    fn tell_beside(&mut self, by_power: &[f64]) {
        let Some(told) = self.told_by_differences() else {
            return;
        };
        let force = self.fitted.iter().zip(by_power).map(|(p, b)| b * p);
        let beside = told.beside(force).into_iter().zip(told.variance());
        let own = beside.map(|(v, without)| v.max(LEAST_OWN * without));
        self.set_own(own.collect());
    }

    /// Raises variances to those that its own were told beside.
    fn at_least_beside(&self, smooth: &mut Smooth, by_power: &[f64]) {
        let (Some(own), Some(_)) = (&self.left.own, self.told_by_differences()) else {
            return;
        };
        for (k, b) in by_power.iter().enumerate() {
            let least = own[k] + b * self.fitted[k];
            if smooth.variance[k] < least {
                smooth.variance[k] = least;
                smooth.by_force[k] = 1.0 - own[k] / least;
            }
        }
    }

    /// Takes variances as its own, raised to the floor where the data did not state them.
    fn set_own(&mut self, mut own: Vec<f64>) {
        if self.told.is_some() {
            raise_to_floor(&mut own, self.left.power.iter().copied());
        }
        self.left.own = Some(own);
    }
}

/// Variances of functions of one hit point from what a fit leaves over of them.
///
/// What is the function's own came with the data; else it is even over the lines, and second
/// differences tell it, which what a missing mode leaves hardly moves, or the level where lines
/// share so much noise that differences hold little of it. Noise of the force under a window is
/// smooth over the lines; it goes with |H|², and what is left over in all resonances together tells
/// it, better than the variances of a few hits do.
pub(in crate::identify) fn of_rest(mut functions: Vec<LeftOver>) -> Vec<Smooth> {
    let mut by_power = Vec::new();
    for _ in 0..BESIDE_FORCE {
        let told = by_power_outside(&functions);
        if told.iter().all(|b| *b <= 0.0) {
            break;
        }
        by_power = told;
        functions
            .par_iter_mut()
            .for_each(|own| own.tell_beside(&by_power));
    }
    let unstated = functions.iter_mut().filter(|own| own.told.is_some());
    share_course(unstated.filter_map(|own| own.left.own.as_mut()).collect());
    let left: Vec<&Estimated> = functions.iter().map(|own| &own.left).collect();
    let mut smooth = variance_model::smooth(&left);
    let of_both = smooth.par_iter_mut().zip(&functions);
    of_both.for_each(|(smooth, function)| function.at_least_beside(smooth, &by_power));
    smooth
}

/// Part of |H|² that the force makes at every line, as second differences tell it outside
/// resonances: a missing mode puts little into these, and much into those within its own.
fn by_power_outside(functions: &[LeftOver]) -> Vec<f64> {
    let differences = functions
        .iter()
        .filter(|own| own.told_by_differences().is_some());
    let powers: Vec<&[f64]> = differences.map(|own| &own.fitted[..]).collect();
    let Some(lines) = powers.first().map(|power| power.len()) else {
        return Vec::new();
    };
    let mut whole = vec![0.0; lines];
    for power in powers {
        let level = power.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let own = whole.iter_mut().zip(power);
        own.for_each(|(sum, p)| *sum += p / level);
    }
    let mut sorted = whole.clone();
    let most = OUTSIDE * *sorted.select_nth_unstable_by(lines / 2, f64::total_cmp).1;
    let outside: Vec<usize> = (0..lines).filter(|k| whole[*k] <= most).collect();
    let Some(last) = outside.len().checked_sub(1) else {
        return Vec::new();
    };
    let told = functions.par_iter();
    let told: Vec<Estimated> = told
        .filter_map(|own| own.differences_at(&outside))
        .collect();
    let by_power = variance_model::by_power(&told.iter().collect::<Vec<_>>());
    let next = |k: usize| outside.partition_point(|line| *line < k).min(last);
    (0..lines).map(|k| by_power[next(k)]).collect()
}

/// Functions whose variances differ from a common course by no more than such estimates scatter
/// have that course, each with a level of its own: the scatter of each by itself would look like
/// power that noise does not have where there are many.
fn share_course(mut own: Vec<&mut Vec<f64>>) {
    let lines = own.first().map_or(0, |values| values.len());
    let levels: Vec<f64> = own
        .par_iter()
        .map(|values| values.iter().sum::<f64>() / lines as f64)
        .collect();
    let mut course = vec![0.0; lines];
    let pieces = course.par_chunks_mut(LINES_AT_ONCE).enumerate();
    pieces.for_each(|(number, sums)| {
        let first = number * LINES_AT_ONCE;
        for (values, level) in own.iter().zip(&levels) {
            let part = (level * levels.len() as f64).recip();
            for (sum, v) in sums.iter_mut().zip(&values[first..]) {
                *sum += v * part;
            }
        }
    });
    let course = &course;
    own.par_iter_mut().zip(levels).for_each(|(values, level)| {
        let apart = |(v, c): (&f64, &f64)| (v / (level * c)).ln().powi(2);
        let scatter = values.iter().zip(course).map(apart).sum::<f64>() / lines as f64;
        if scatter <= MOST_SCATTER {
            for (v, c) in values.iter_mut().zip(course) {
                *v = level * c;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use crate::identify::noise::residual_variance::*;
    use crate::identify::synthetic::white_noise;

    #[test]
    fn what_is_left_over_tells_the_noise_of_the_force_beside_that_of_the_response() {
        // Resonances 20 lines wide; an own variance of 1e-6, and 1 % of the response, even over 40
        // lines.
        let line = |k: usize, at: f64| 10.0 / Complex64::new(10.0, k as f64 - at);
        let clean = |k: usize| (0..8).map(|n| line(k, 250.0 + 500.0 * n as f64)).sum();
        let values: Vec<Complex64> = (0..4000).map(clean).collect();
        let white = white_noise(4040, 1e-4 / 40.0, 3);
        let force = |k: usize| white[k..k + 40].iter().sum::<Complex64>();
        let functions: Vec<_> = (0..6)
            .map(|f| {
                let own = white_noise(4000, 1e-6, 10 + f);
                let rest = (0..4000).map(|k| own[k] + force(k) * values[k]);
                LeftOver::new(
                    &values,
                    &rest.collect::<Vec<_>>(),
                    (Source::SecondDifferences(6.0), 1.0),
                )
            })
            .collect();
        let told = of_rest(functions);
        let between: f64 = told.iter().map(|own| own.variance[500]).sum::<f64>() / 6.0;
        assert!((between / 1.05e-6 - 1.0).abs() < 0.15, "{between}");
        // Half a dozen independent errors within each of eight resonances: their mean square to a
        // sixth.
        let tops = (0..8).map(|n| told[0].variance[250 + 500 * n]);
        let top = tops.sum::<f64>() / 8.0;
        assert!((top / 1.01e-4 - 1.0).abs() < 0.5, "{top}");
        assert!(told[0].by_force[250] > 0.9 && told[0].by_force[500] < 0.2);
    }

    #[test]
    fn what_is_left_over_adds_noise_of_the_force_to_stated_variances() {
        // Stated: 1e-6 at every line. Of the six, one response has ten times that, stated as well.
        let line = |k: usize, at: f64| 10.0 / Complex64::new(10.0, k as f64 - at);
        let clean = |k: usize| (0..8).map(|n| line(k, 250.0 + 500.0 * n as f64)).sum();
        let values: Vec<Complex64> = (0..4000).map(clean).collect();
        let told = |by_force: f64| {
            let force = white_noise(4000, by_force, 3);
            let left = |f: u64| {
                let stated = if f == 5 { 1e-5 } else { 1e-6 };
                let own = white_noise(4000, stated, 10 + f);
                let rest = (0..4000).map(|k| own[k] + force[k] * values[k]);
                let stated = Source::Stated(vec![stated; 4000]);
                LeftOver::new(&values, &rest.collect::<Vec<_>>(), (stated, 1.0))
            };
            of_rest((0..6).map(left).collect())
        };
        let top = |own: &Smooth| {
            let tops = (0..8).flat_map(|n| 240 + 500 * n..260 + 500 * n);
            tops.map(|k| own.variance[k] / values[k].norm_sqr())
                .sum::<f64>()
                / 160.0
        };
        let with = told(1e-4);
        // 160 lines, each an own draw of the force: its mean square to 8 %, four times.
        assert!(
            (top(&with[0]) / 1.01e-4 - 1.0).abs() < 0.3,
            "{}",
            top(&with[0])
        );
        // Half-way between two resonances the force adds 2 % at most.
        assert!((with[0].variance[500] / 1.05e-6 - 1.0).abs() < 0.15);
        assert!((with[5].variance[500] / 1.005e-5 - 1.0).abs() < 0.15);
        assert!(with[0].by_force[250] > 0.9 && with[0].by_force[500] < 0.2);
        // Where the stated variances are all there is, they stay.
        let without = told(1e-12);
        assert!(
            (top(&without[0]) / 1e-6 - 1.0).abs() < 1.0,
            "{}",
            top(&without[0])
        );
        assert!((without[5].variance[500] / 1e-5 - 1.0).abs() < 0.15);
    }

    #[test]
    fn noise_of_the_force_outside_resonances_is_no_noise_of_the_responses() {
        // 1 % of the response, far more than its own noise between resonances of ten lines;
        // antiresonances where the functions' signs put them. The ninth function holds hardly
        // anything but noise.
        let resonance = |k: usize, at: f64| 5.0 / Complex64::new(5.0, k as f64 - at);
        let sign = |f: usize, n: usize| if (f >> (n % 3)) & 1 == 0 { 1.0 } else { -1.0 };
        let value = |f: usize, k: usize| -> Complex64 {
            let at = |n: usize| 250.0 + 500.0 * n as f64;
            (0..8).map(|n| sign(f, n) * resonance(k, at(n))).sum()
        };
        let of_force = 1e-4;
        let mut truth = Vec::new();
        let functions = (0..9).map(|f| {
            let of_response = if f < 8 { 1e-11 } else { 1.0 };
            let scale = if f < 8 { 1.0 } else { 1e-3 };
            let values: Vec<Complex64> = (0..4000).map(|k| scale * value(f, k)).collect();
            let seed = f as u64;
            let force = white_noise(4000, of_force, 100 + seed);
            let own = white_noise(4000, of_response, 200 + seed);
            let rest: Vec<Complex64> = (0..4000).map(|k| own[k] + force[k] * values[k]).collect();
            let variance = values.iter().map(|h| of_response + of_force * h.norm_sqr());
            truth.push(variance.collect::<Vec<f64>>());
            let measured: Vec<Complex64> = values.iter().zip(&rest).map(|(h, e)| h + e).collect();
            LeftOver::new(&measured, &rest, (Source::SecondDifferences(6.0), 1.0))
        });
        let told = of_rest(functions.collect());
        for (told, truth) in told.iter().zip(&truth) {
            let both = told.variance.iter().zip(truth);
            let apart = both.map(|(v, own)| (v / own).ln());
            let (sum, squares) = apart.fold((0.0, 0.0), |(a, b), x| (a + x, b + x * x));
            assert!(sum.abs() < 0.1 * 4000.0, "{}", sum / 4000.0);
            let deviation = (squares / 4000.0).sqrt();
            assert!(deviation < 0.3, "{deviation}");
        }
    }
}
