//! The noise variance of a measured function, line by line, from the best source there is.
//!
//! In this order: the variances that came with the data; coherence and number of averages (two or more),
//! `var H = |H|² (1 − γ²)/(γ² (n − 1))` as in [`frf`](crate::frf); else the data alone, and then what a fit leaves over of them.
//! Variances of a few averages scatter widely, and a value that is small by chance makes noise look like a signal: their course over
//! the lines counts ([`noise_course`](super::noise_course)).

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::{FrfSet, Function};

use super::noise_course::{self, Estimated, Smooth};
use super::shared::told_by_variances;

/// Lines on either side that a running median looks at, and lines between two evaluations of it.
const REACH: usize = 64;
const HOPS_PER_REACH: usize = 2;
/// The same of a level that lines share, as a part of all.
const LEVEL_REACH: usize = 16;
/// Times that a function's own variances are told anew beside those that the force makes.
const BESIDE_FORCE: usize = 4;
/// Part of a variance from which on the force makes nearly all of it, and fewest such lines that say what of it second differences hold.
const NEARLY_ALL: f64 = 0.8;
const FEWEST_BY_FORCE: usize = 8;
/// Mean square of the logarithm by which variances that a running median tells of white noise differ from it, 0.023 (simulated), with
/// room for chance.
const MOST_SCATTER: f64 = 0.035;
/// Lines whose sums stay in the nearest cache.
const LINES_AT_ONCE: usize = 1024;
/// Relative floor of a variance, so that data without any noise can still be divided by it.
const FLOOR: f64 = 1e-24;

/// Variances of one function.
pub(super) struct Noise {
    /// E|H − E H|² at every line, in the squared unit of the function.
    pub variance: Vec<f64>,
    /// Part of it that goes with |H|²; 0 where it is not known.
    pub by_force: Vec<f64>,
    /// Whether the data brought them (variance or coherence).
    pub measured: bool,
    /// Part of the force's noise that the functions of its hit point share, as far as their variances tell.
    pub shared: f64,
}

/// Variances of all functions of a set on some lines.
pub(super) fn of_set(set: &FrfSet, lines: &Range<usize>) -> Vec<Noise> {
    let estimated: Vec<Option<Estimated>> = (0..set.len())
        .map(|i| estimated(set, i, lines.clone()))
        .collect();
    let mut hits: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
    for (i, function) in set.functions().iter().enumerate() {
        if estimated[i].is_some() {
            hits.entry(&function.reference).or_default().push(i);
        }
    }
    let mut measured = BTreeMap::new();
    for group in hits.into_values() {
        let own: Vec<&Estimated> = group
            .iter()
            .filter_map(|i| estimated[*i].as_ref())
            .collect();
        let smooth = noise_course::smooth(&own);
        let shared = told_by_variances(&own, &smooth);
        let told = smooth.into_iter().map(|own| (own, shared));
        measured.extend(group.into_iter().zip(told));
    }
    let of_function = |i: usize| {
        let values = &set.values(i)[lines.clone()];
        let told: Option<&(Smooth, f64)> = measured.get(&i);
        let mut own = told.map_or_else(
            || Smooth {
                variance: Squares::of_second_differences(values).variance(),
                by_force: vec![0.0; values.len()],
            },
            |(own, _)| own.clone(),
        );
        raise_to_floor(&mut own.variance, values.iter().map(Complex64::norm_sqr));
        Noise {
            variance: own.variance,
            by_force: own.by_force,
            measured: told.is_some(),
            shared: told.map_or(0.0, |(_, shared)| *shared),
        }
    };
    (0..set.len()).into_par_iter().map(of_function).collect()
}

/// The variances that the data bring of a function.
fn estimated(set: &FrfSet, i: usize, lines: Range<usize>) -> Option<Estimated> {
    let values = &set.values(i)[lines.clone()];
    let Function {
        averages,
        variance_dof,
        ..
    } = set.functions()[i];
    let variance = match (set.variance(i), set.coherence(i), averages) {
        (Some(variance), _, _) => variance[lines].to_vec(),
        (None, Some(coherence), Some(n)) if n >= 2 => from_coherence(values, &coherence[lines], n),
        _ => return None,
    };
    let by_averages = averages.filter(|n| *n >= 2).map(|n| 2.0 * f64::from(n - 1));
    Some(Estimated {
        variance,
        power: values.iter().map(Complex64::norm_sqr).collect(),
        degrees_of_freedom: variance_dof.or(by_averages),
        alike: 1.0,
        own: None,
    })
}

/// A function of which a fit leaves something over.
pub(super) struct LeftOver {
    /// |H|² at every line, as measured.
    power: Vec<f64>,
    /// The same of what is left over.
    left: Vec<f64>,
    /// Variances of the function's own.
    own: Vec<f64>,
    /// What tells these, where they did not come with the data.
    told: Option<Squares>,
}

/// Squares of which a running median is the variance of noise.
struct Squares {
    values: Vec<f64>,
    reach: usize,
}

impl Squares {
    /// White noise of variance `v` on a smooth function: the second difference `h₋ − 2h + h₊` has variance `6v`, and the
    /// median of its squared magnitude is `6v ln 2`. Resonances take few lines and do not move the median.
    fn of_second_differences(values: &[Complex64]) -> Self {
        let scale = (6.0 * std::f64::consts::LN_2).recip();
        let square =
            |k: usize| (values[k - 1] - 2.0 * values[k] + values[k + 1]).norm_sqr() * scale;
        let last = values.len() - 2;
        // The first and the last line have those of their neighbours.
        let own = (0..values.len()).map(|k| square(k.clamp(1, last)));
        Self {
            values: own.collect(),
            reach: REACH,
        }
    }

    /// Noise of variance `v`: the median of its squared magnitude is `v ln 2`.
    fn of_level(squares: &[f64]) -> Self {
        let own = squares.iter().map(|square| square / std::f64::consts::LN_2);
        Self {
            values: own.collect(),
            reach: REACH.max(squares.len() / LEVEL_REACH),
        }
    }

    fn variance(&self) -> Vec<f64> {
        running_median(&self.values, self.reach)
    }

    /// The variance `a` beside a part of the force: the squares over `a + b p` have the median 1.
    fn beside(&self, own: &[f64], force: &[f64]) -> Vec<f64> {
        let over = self.values.iter().zip(own.iter().zip(force));
        let over: Vec<f64> = over
            .map(|(square, (a, force))| square / (a + force))
            .collect();
        let factor = running_median(&over, self.reach);
        own.iter()
            .zip(factor)
            .map(|(a, factor)| a * factor)
            .collect()
    }
}

/// What tells the noise of a function.
pub(super) enum Source {
    /// Variances that came with the data.
    Stated(Vec<f64>),
    /// Second differences of what a fit leaves over; with the mean square of those of unit noise, 6 for white noise.
    SecondDifferences(f64),
    /// The level of what a fit leaves over.
    Level,
}

impl LeftOver {
    /// Of |H|², and what is left over of H.
    pub fn new(power: Vec<f64>, rest: &[Complex64], source: Source) -> Self {
        let left: Vec<f64> = rest.iter().map(Complex64::norm_sqr).collect();
        let told = match source {
            Source::Stated(own) => {
                return Self {
                    power,
                    left,
                    own,
                    told: None,
                };
            }
            Source::SecondDifferences(of_unit) => {
                let mut own = Squares::of_second_differences(rest);
                own.values.iter_mut().for_each(|v| *v *= 6.0 / of_unit);
                own
            }
            Source::Level => Squares::of_level(&left),
        };
        let mut own = told.variance();
        raise_to_floor(&mut own, power.iter().copied());
        Self {
            power,
            left,
            own,
            told: Some(told),
        }
    }

    /// What tells its own variances, over those that the force makes, where these are nearly all.
    fn by_force<'a>(&'a self, smooth: &'a Smooth) -> impl Iterator<Item = f64> + 'a {
        let told = self.told.iter().flat_map(|told| &told.values);
        let force = smooth.variance.iter().zip(&smooth.by_force);
        let nearly_all = told.zip(force).filter(|(_, (_, part))| **part > NEARLY_ALL);
        nearly_all.map(|(square, (v, part))| square / (v * part))
    }

    /// Tells its own variances anew beside so much of those that the force makes.
    fn tell_beside(&mut self, smooth: &Smooth, told_of_force: f64) {
        let Some(told) = &self.told else {
            return;
        };
        let force = smooth.variance.iter().zip(&smooth.by_force);
        let force: Vec<f64> = force.map(|(v, part)| told_of_force * v * part).collect();
        self.own = told.beside(&self.own, &force);
        raise_to_floor(&mut self.own, self.power.iter().copied());
    }
}

/// Variances of functions of one hit point from what a fit leaves over of them.
///
/// What is the function's own came with the data; else it is even over the lines, and second differences tell it, which what a missing
/// mode leaves hardly moves, or the level where lines share so much noise that differences hold little of it. Noise of the force under a window is smooth over the lines; it goes with |H|², and what is left over in
/// all resonances together tells it, better than the variances of a few hits do; `alike` lines count for one.
pub(super) fn of_rest(mut functions: Vec<LeftOver>, alike: f64) -> Vec<Smooth> {
    let mut smooth = course_of(&mut functions, alike);
    for _ in 0..BESIDE_FORCE {
        let own = functions.iter().zip(&smooth);
        let by_force = own.flat_map(|(function, smooth)| function.by_force(smooth));
        let mut by_force: Vec<f64> = by_force.collect();
        if by_force.len() < FEWEST_BY_FORCE {
            break;
        }
        let middle = by_force.len() / 2;
        let told_of_force = *by_force.select_nth_unstable_by(middle, f64::total_cmp).1;
        let own = functions.par_iter_mut().zip(&smooth);
        own.for_each(|(function, smooth)| function.tell_beside(smooth, told_of_force));
        smooth = course_of(&mut functions, alike);
    }
    smooth
}

fn course_of(functions: &mut [LeftOver], alike: f64) -> Vec<Smooth> {
    let unstated = functions
        .iter_mut()
        .filter(|function| function.told.is_some());
    share_course(unstated.map(|function| &mut function.own).collect());
    let estimated: Vec<Estimated> = functions
        .iter()
        .map(|function| Estimated {
            variance: function.left.clone(),
            power: function.power.clone(),
            degrees_of_freedom: Some(2.0),
            alike,
            own: Some(function.own.clone()),
        })
        .collect();
    noise_course::smooth(&estimated.iter().collect::<Vec<_>>())
}

/// Functions whose variances differ from a common course by no more than such estimates scatter have that course, each with a level of
/// its own: the scatter of each by itself would look like power that noise does not have where there are many.
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

/// Raises variances to what rounding leaves of so much power at each line.
fn raise_to_floor(variance: &mut [f64], power: impl Iterator<Item = f64>) {
    let mean_square = power.sum::<f64>() / variance.len() as f64;
    let floor = if mean_square > 0.0 {
        FLOOR * mean_square
    } else {
        1.0
    };
    variance.iter_mut().for_each(|v| *v = v.max(floor));
}

fn from_coherence(values: &[Complex64], coherence: &[f64], averages: u32) -> Vec<f64> {
    let variance = |(h, g): (&Complex64, &f64)| {
        let gamma_squared = g.clamp(1e-6, 1.0);
        h.norm_sqr() * (1.0 - gamma_squared) / (gamma_squared * f64::from(averages - 1))
    };
    values.iter().zip(coherence).map(variance).collect()
}

/// Median over `±reach` lines, evaluated twice in a reach and straight between.
fn running_median(values: &[f64], reach: usize) -> Vec<f64> {
    let (last, every) = (values.len() - 1, reach / HOPS_PER_REACH);
    let mut near = Vec::with_capacity(2 * reach + 1);
    let mut median = |centre: usize| {
        near.clear();
        near.extend_from_slice(
            &values[centre.saturating_sub(reach)..(centre + reach + 1).min(values.len())],
        );
        let middle = near.len() / 2;
        *near.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let medians: Vec<f64> = (0..=last.div_ceil(every))
        .map(|hop| median((hop * every).min(last)))
        .collect();
    let between = |k: usize| {
        let (hop, part) = (k / every, (k % every) as f64 / every as f64);
        let next = medians[(hop + 1).min(medians.len() - 1)];
        medians[hop] + part * (next - medians[hop])
    };
    (0..values.len()).map(between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::synthetic::white_noise;

    fn powers(values: &[Complex64]) -> Vec<f64> {
        values.iter().map(Complex64::norm_sqr).collect()
    }

    #[test]
    fn second_differences_return_the_variance_of_white_noise_under_a_resonance() {
        let noise = white_noise(4000, 0.25, 7);
        let line = |k: usize| 50.0 / Complex64::new(3.0, k as f64 - 2000.0);
        let values: Vec<Complex64> = (0..4000).map(|k| line(k) + noise[k]).collect();
        let estimate = Squares::of_second_differences(&values).variance();
        let mean = estimate.iter().sum::<f64>() / 4000.0;
        // 129 differences per median, 126 medians that overlap: the mean is known to about 3 %.
        assert!((mean / 0.25 - 1.0).abs() < 0.06, "{mean}");
        assert!(estimate[2000] < 0.5);
    }

    #[test]
    fn what_is_left_over_tells_the_noise_of_the_force_beside_that_of_the_response() {
        // Resonances 20 lines wide; an own variance of 1e-6, and 1 % of the response, even over 40 lines.
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
                    powers(&values),
                    &rest.collect::<Vec<_>>(),
                    Source::SecondDifferences(6.0),
                )
            })
            .collect();
        let told = of_rest(functions, 1.0);
        let between: f64 = told.iter().map(|own| own.variance[500]).sum::<f64>() / 6.0;
        assert!((between / 1.05e-6 - 1.0).abs() < 0.15, "{between}");
        // Half a dozen independent errors within each of eight resonances: their mean square to a sixth.
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
                LeftOver::new(powers(&values), &rest.collect::<Vec<_>>(), stated)
            };
            of_rest((0..6).map(left).collect(), 1.0)
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
    fn coherence_gives_the_textbook_variance() {
        let variance = from_coherence(&[Complex64::new(0.0, 2.0)], &[0.8], 5);
        assert!((variance[0] - 4.0 * 0.2 / (0.8 * 4.0)).abs() < 1e-15);
    }
}
