//! Lines of a stepped sine are close together at resonances and far apart between them; here they
//! are interpolated onto an even axis as fine as the closest of them.
//!
//! The variance of an even line is that of a measured one times the even lines per measured one, so
//! that the lines of a gap together weigh as much in a fit as the measured line that they stand
//! for. It includes the error of the interpolation.

use num_complex::Complex64;

use crate::axis::FrequencyAxis;

/// Fewest measured lines.
const MIN_LINES: usize = 8;
/// Measured lines that the pole near a line is estimated from. Fewer: it follows from noise alone.
/// More: a second pole is among them (`a_resonance_on_uneven_lines_is_interpolated`).
const NODES: usize = 6;
/// Measured lines that a value is interpolated from, once the pole is divided out.
const CUBIC_NODES: usize = 4;
/// Measured lines on either side whose noise is taken for that of a line. Fewer, at 4: the variance
/// scatters more. More, at 60: noise of a narrow band is missed
/// (`noise_is_estimated_from_neither_too_few_nor_too_many_lines`).
const NOISE_SIDE: usize = 12;
/// Squared difference of two estimates over its mean by noise that is no error of interpolation.
/// Larger: errors are taken for noise (`the_variance_includes_the_error_of_interpolation`).
/// Smaller: noise is counted twice (`modes_of_a_stepped_sine_lie_within_their_intervals`).
const MAX_NOISE_OVER_MEAN: f64 = 4.0;
/// Median over the mean of a window's noise, of which its differences leave between one and two
/// squared complex normal values (0.69 and 0.84), and less where the pole follows from noise; found
/// with white noise (`noise_of_measured_lines_is_estimated_from_their_neighbours`).
const MEDIAN_OVER_MEAN: f64 = 0.57;
/// Distance of a measured line from an even one, in spacings, within which they are the same:
/// frequencies are written with six digits.
const SAME_LINE: f64 = 1e-2;
/// Largest number of even lines over that of the measured ones. Larger: two lines that nearly
/// coincide make millions of lines. Smaller: a logarithmic sweep over four octaves loses its low
/// lines (`lines_that_nearly_coincide_do_not_decide_the_spacing`).
const MAX_LINES_RATIO: f64 = 16.0;

/// Interpolation from measured lines onto even ones.
pub(crate) struct EvenLines {
    /// Frequencies of the measured lines with their places in the file, ascending.
    measured: Vec<(f64, usize)>,
    /// The even lines.
    pub axis: FrequencyAxis,
}

impl EvenLines {
    /// From the frequencies of measured lines, in any order; `None` where they are too few, not
    /// finite or negative. Of two equal ones the later counts.
    pub fn new(frequencies_hz: &[f64]) -> Option<Self> {
        let is_usable = |hz: &f64| hz.is_finite() && *hz >= 0.0;
        if !frequencies_hz.iter().all(is_usable) {
            return None;
        }
        let mut measured: Vec<(f64, usize)> = frequencies_hz.iter().copied().zip(0..).collect();
        measured.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        measured.dedup_by(|later, kept| later.0 <= kept.0);
        if measured.len() < MIN_LINES {
            return None;
        }
        let (start_hz, end_hz) = (measured[0].0, measured[measured.len() - 1].0);
        let range = end_hz - start_hz;
        let spacings = measured.windows(2).map(|pair| pair[1].0 - pair[0].0);
        let closest = spacings.fold(f64::INFINITY, f64::min);
        let finest = range / (MAX_LINES_RATIO * measured.len() as f64);
        // Rounded frequencies of even lines make no more lines; else a whole number of steps, so
        // that lines on a grid stay where they are.
        let gaps = (measured.len() - 1) as f64;
        let is_even_line = |(k, (hz, _)): (usize, &(f64, usize))| {
            (hz - start_hz - k as f64 * range / gaps).abs() < SAME_LINE * range / gaps
        };
        let steps = match measured.iter().enumerate().all(is_even_line) {
            true => gaps,
            false => (range / closest.max(finest) * (1.0 - 1e-9)).ceil().max(1.0),
        };
        let axis = FrequencyAxis {
            start_hz,
            step_hz: range / steps,
            len: steps as usize + 1,
        };
        Some(Self { measured, axis })
    }

    /// Values of measured lines in ascending order, where the measured lines are the even ones and
    /// only their order differs.
    pub fn reordered(&self, values: &[Complex64]) -> Option<Vec<Complex64>> {
        let is_line = |(k, (hz, _)): (usize, &(f64, usize))| {
            (hz - self.axis.hz(k)).abs() < SAME_LINE * self.axis.step_hz
        };
        let mut measured = self.measured.iter().enumerate();
        let is_even = self.measured.len() == self.axis.len && measured.all(is_line);
        let places = self.measured.iter();
        is_even.then(|| places.map(|(_, place)| values[*place]).collect())
    }

    /// The value of the nearest even line.
    fn at(&self, values: &[f64], hz: f64) -> f64 {
        let line = self.axis.nearest(hz).unwrap_or(self.axis.len - 1);
        values[line]
    }

    /// Real values of measured lines, such as coherence, on the even lines: linearly between them.
    pub fn linear(&self, values: &[f64]) -> Vec<f64> {
        let mut above = 1;
        let line = |k: usize| {
            let hz = self.axis.hz(k);
            while above + 1 < self.measured.len() && self.measured[above].0 < hz {
                above += 1;
            }
            let [(low_hz, low), (high_hz, high)] = [self.measured[above - 1], self.measured[above]];
            let part = (hz - low_hz) / (high_hz - low_hz);
            (1.0 - part) * values[low] + part * values[high]
        };
        (0..self.axis.len).map(line).collect()
    }

    /// A function on the even lines. `values` has one for each measured line; the variance of the
    /// measured values, where it is stated, one for each even line, else it is estimated from
    /// neighbouring measured lines.
    pub fn interpolated(&self, values: &[Complex64], stated: Option<&[f64]>) -> EvenFunction {
        let lines: Vec<Line> = self
            .measured
            .iter()
            .map(|(hz, place)| Line {
                hz: *hz,
                value: values[*place],
            })
            .collect();
        let noise = match stated {
            Some(stated) => lines.iter().map(|line| self.at(stated, line.hz)).collect(),
            None => noise_variances(&lines),
        };
        let mut even = EvenFunction::default();
        let mut above = 0;
        for k in 0..self.axis.len {
            let hz = self.axis.hz(k);
            while above + 1 < lines.len() && lines[above].hz < hz {
                above += 1;
            }
            let gap = (above.max(1) - 1, above.max(1));
            let place = |nodes: usize| above.saturating_sub(nodes / 2).min(lines.len() - nodes);
            let first = place(CUBIC_NODES);
            let estimate = |first: usize, window: usize| Estimate::new(&lines, hz, first, window);
            let best = estimate(first, place(NODES));
            // How far the value depends on the measured lines that it follows from.
            let shifted = [first.checked_sub(1), Some(first + 1)]
                .into_iter()
                .flatten();
            let shifted = shifted.filter(|first| first + CUBIC_NODES <= lines.len());
            let errors = shifted.map(|first| {
                let window = first.saturating_sub(1).min(lines.len() - NODES);
                best.squared_error(&estimate(first, window), &noise)
            });
            let error = errors.fold(f64::INFINITY, f64::min);
            let measured = 0.5 * (noise[gap.0] + noise[gap.1]);
            let per_measured = (lines[gap.1].hz - lines[gap.0].hz) / self.axis.step_hz;
            even.values.push(best.value);
            even.variance
                .push(per_measured.max(1.0) * (measured + error));
        }
        even
    }
}

/// A function on the even lines.
#[derive(Default)]
pub(crate) struct EvenFunction {
    pub values: Vec<Complex64>,
    /// As the head of this file defines it.
    pub variance: Vec<f64>,
}

/// A measured line.
struct Line {
    hz: f64,
    value: Complex64,
}

/// A value between measured lines, a weighted sum of four of them.
struct Estimate {
    value: Complex64,
    /// The first of the four.
    first: usize,
    weights: [Complex64; CUBIC_NODES],
}

impl Estimate {
    /// Near one pole an FRF is `(a + b x + c x²)/(1 + d x)`, x from the wanted line: its product
    /// with `1 + d x` has no third divided difference, which gives d by least squares over the
    /// window of measured lines, and the product at x = 0 by a cubic polynomial is the value.
    fn new(lines: &[Line], hz: f64, first: usize, window: usize) -> Self {
        let slope = Differences::new(&lines[window..window + NODES], hz).slope();
        let nodes = &lines[first..first + CUBIC_NODES];
        let weights: [Complex64; CUBIC_NODES] = std::array::from_fn(|place| {
            let x = nodes[place].hz - hz;
            let lagrange: f64 = others(nodes, place)
                .map(|other| (other - hz) / (other - nodes[place].hz))
                .product();
            (1.0 + slope * x) * lagrange
        });
        let terms = weights.iter().zip(nodes);
        Self {
            value: terms.map(|(weight, line)| weight * line.value).sum(),
            first,
            weights,
        }
    }

    /// The squared difference from another estimate, without what noise contributes.
    fn squared_error(&self, other: &Estimate, noise: &[f64]) -> f64 {
        let weight = |estimate: &Estimate, line: usize| {
            let place = line.checked_sub(estimate.first);
            let weight = place.and_then(|place| estimate.weights.get(place));
            weight.copied().unwrap_or_default()
        };
        let lines = self.first.min(other.first)..self.first.max(other.first) + CUBIC_NODES;
        let of_noise: f64 = lines
            .map(|line| (weight(self, line) - weight(other, line)).norm_sqr() * noise[line])
            .sum();
        ((self.value - other.value).norm_sqr() - MAX_NOISE_OVER_MEAN * of_noise).max(0.0)
    }
}

/// Third divided differences of the values of a window, and of their products with x.
struct Differences {
    plain: [Complex64; NODES - CUBIC_NODES + 1],
    times_x: [Complex64; NODES - CUBIC_NODES + 1],
}

impl Differences {
    fn new(window: &[Line], hz: f64) -> Self {
        let difference = |first: usize, power: i32| -> Complex64 {
            let nodes = &window[first..first + CUBIC_NODES];
            let terms = nodes.iter().zip(coefficients(nodes));
            terms
                .map(|(line, factor)| line.value * factor * (line.hz - hz).powi(power))
                .sum()
        };
        Self {
            plain: std::array::from_fn(|first| difference(first, 0)),
            times_x: std::array::from_fn(|first| difference(first, 1)),
        }
    }

    /// The d for which the differences of the product are least.
    fn slope(&self) -> Complex64 {
        let pairs = || self.times_x.iter().zip(&self.plain);
        let square: f64 = self.times_x.iter().map(Complex64::norm_sqr).sum();
        match square > 0.0 {
            true => {
                -pairs()
                    .map(|(x, plain)| x.conj() * plain)
                    .sum::<Complex64>()
                    / square
            }
            false => Complex64::ZERO,
        }
    }
}

/// Variance of the noise of each measured line: the median over its neighbours of what their
/// differences leave beside one pole.
fn noise_variances(lines: &[Line]) -> Vec<f64> {
    let windows: Vec<f64> = lines.windows(NODES).map(noise_variance).collect();
    let around = |line: usize| {
        let middle = line.saturating_sub(NODES / 2);
        let end = (middle + NOISE_SIDE + 1).min(windows.len());
        let start = middle.saturating_sub(NOISE_SIDE).min(end - 1);
        let mut near = windows[start..end].to_vec();
        near.sort_unstable_by(f64::total_cmp);
        near[near.len() / 2] / MEDIAN_OVER_MEAN
    };
    (0..lines.len()).map(around).collect()
}

/// The mean squared noise of a window with one pole.
fn noise_variance(window: &[Line]) -> f64 {
    const ROWS: usize = NODES - CUBIC_NODES + 1;
    let hz = window[NODES / 2].hz;
    let differences = Differences::new(window, hz);
    let slope = differences.slope();
    // Each row is the weighted sum of values that noise alone keeps from zero.
    let rows: [[Complex64; NODES]; ROWS] = std::array::from_fn(|first| {
        let mut row = [Complex64::ZERO; NODES];
        let nodes = &window[first..first + CUBIC_NODES];
        for (place, factor) in coefficients(nodes).into_iter().enumerate() {
            row[first + place] = factor * (1.0 + slope * (nodes[place].hz - hz));
        }
        row
    });
    let product = |a: &[Complex64; NODES], b: &[Complex64; NODES]| -> Complex64 {
        a.iter().zip(b).map(|(a, b)| a * b.conj()).sum()
    };
    let size = rows.each_ref().map(|row| product(row, row).re.sqrt());
    let scaled = |row: usize, value: Complex64| value / size[row];
    let left = |row: usize| {
        scaled(
            row,
            differences.plain[row] + slope * differences.times_x[row],
        )
    };
    let along: [Complex64; ROWS] = std::array::from_fn(|row| scaled(row, differences.times_x[row]));
    let length: f64 = along.iter().map(Complex64::norm_sqr).sum();
    let inner: Complex64 = (0..ROWS).map(|row| along[row].conj() * left(row)).sum();
    let residual: f64 = (0..ROWS)
        .map(|row| (left(row) - along[row] * inner / length).norm_sqr())
        .sum();
    let correlation = |a: usize, b: usize| product(&rows[a], &rows[b]) / (size[a] * size[b]);
    let pairs = (0..ROWS).flat_map(|a| (0..ROWS).map(move |b| (a, b)));
    let of_slope: Complex64 = pairs
        .map(|(a, b)| along[a].conj() * correlation(a, b) * along[b])
        .sum();
    let freedom = ROWS as f64 - of_slope.re / length;
    match freedom > 0.0 && residual.is_finite() {
        true => residual / freedom,
        false => 0.0,
    }
}

/// Coefficients of the third divided difference.
fn coefficients(nodes: &[Line]) -> [f64; CUBIC_NODES] {
    std::array::from_fn(|place| {
        let denominator: f64 = others(nodes, place)
            .map(|other| nodes[place].hz - other)
            .product();
        denominator.recip()
    })
}

/// The frequencies of all nodes but one.
fn others(nodes: &[Line], place: usize) -> impl Iterator<Item = f64> {
    let all = nodes.iter().enumerate();
    all.filter(move |(other, _)| *other != place)
        .map(|(_, line)| line.hz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// A resonance of half-power bandwidth 0.4 Hz beside a wider one.
    fn resonance(hz: f64) -> Complex64 {
        let pole = |at_hz: f64, width| Complex64::ONE / Complex64::new(width, hz - at_hz);
        pole(20.0, 0.2) + 0.5 * pole(23.0, 0.5) + 0.01 * hz
    }

    #[test]
    fn a_resonance_on_uneven_lines_is_interpolated() {
        let coarse = (0..20).map(|k| 10.0 + 0.4 * f64::from(k));
        let fine = (0..40).map(|k| 18.0 + 0.1 * f64::from(k));
        let above = (0..20).map(|k| 22.0 + 0.4 * f64::from(k));
        let stepped: Vec<f64> = coarse.chain(fine).chain(above).collect();
        let sweep: Vec<f64> = (0..200).map(|k| 10.0 * 1.006f64.powi(k)).collect();
        let down: Vec<f64> = stepped.iter().rev().copied().collect();
        for frequencies in [stepped, sweep, down] {
            let lines = EvenLines::new(&frequencies).unwrap();
            let values: Vec<Complex64> = frequencies.iter().map(|hz| resonance(*hz)).collect();
            for (k, value) in lines.interpolated(&values, None).values.iter().enumerate() {
                let exact = resonance(lines.axis.hz(k));
                assert!((value - exact).norm() < 1e-3 * 5.0, "{}", lines.axis.hz(k));
            }
        }
    }

    #[test]
    fn of_two_values_at_one_frequency_the_second_counts() {
        let mut frequencies: Vec<f64> = (0..100).map(f64::from).collect();
        frequencies.push(70.0);
        let mut values: Vec<Complex64> = frequencies.iter().map(|hz| (*hz).into()).collect();
        values[100] += 0.5;
        let lines = EvenLines::new(&frequencies).unwrap();
        let even = lines.interpolated(&values, None).values;
        assert_eq!(even.len(), 100);
        assert!((even[70].re - 70.5).abs() < 1e-9);
    }

    #[test]
    fn noise_is_not_amplified() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let frequencies: Vec<f64> = (0..400).map(|k| 10.0 * 1.006f64.powi(k)).collect();
        let mut part = || -> f64 { random.sample(StandardNormal) };
        let noise: Vec<Complex64> = (0..400).map(|_| Complex64::new(part(), part())).collect();
        let lines = EvenLines::new(&frequencies).unwrap();
        let even = lines.interpolated(&noise, None).values;
        let power = even.iter().map(Complex64::norm_sqr).sum::<f64>() / even.len() as f64;
        assert!(power < 2.2, "{power}");
    }

    #[test]
    fn lines_of_a_grid_stay_where_they_are() {
        let grid = |k: &f64| 5.0 + 0.25 * k;
        let steps = [0.0, 2.0, 4.0, 5.0, 6.0, 7.0, 9.0, 12.0, 14.0];
        let frequencies: Vec<f64> = steps.iter().map(grid).collect();
        let lines = EvenLines::new(&frequencies).unwrap();
        assert_eq!(lines.axis.len, 15);
        assert!((lines.axis.step_hz - 0.25).abs() < 1e-12);
        let values: Vec<Complex64> = steps.iter().map(|k| Complex64::new(*k, 0.0)).collect();
        let even = lines.interpolated(&values, None).values;
        for (k, value) in even.iter().enumerate() {
            assert!((value - k as f64).norm() < 1e-9);
        }
    }

    #[test]
    fn real_values_are_interpolated_linearly() {
        let frequencies: Vec<f64> = (0..60).map(|k| 10.0 * 1.01f64.powi(k)).collect();
        let lines = EvenLines::new(&frequencies).unwrap();
        let values: Vec<f64> = frequencies.iter().map(|hz| 1.0 - 0.01 * hz).collect();
        for (k, value) in lines.linear(&values).iter().enumerate() {
            let exact = 1.0 - 0.01 * lines.axis.hz(k);
            assert!((value - exact).abs() < 1e-12, "{k}: {value} {exact}");
        }
        // A bend shows which lines a value lies between.
        let bent: Vec<f64> = (0..60).map(|k| f64::from(u8::from(k >= 30))).collect();
        for (k, value) in lines.linear(&bent).iter().enumerate() {
            let part = (lines.axis.hz(k) - frequencies[29]) / (frequencies[30] - frequencies[29]);
            assert!((value - part.clamp(0.0, 1.0)).abs() < 1e-9, "{k}: {value}");
        }
    }

    #[test]
    fn even_lines_in_descending_order_are_reordered() {
        // As printed with six digits.
        let printed = |k: u32| (1e3 * (5.0 + f64::from(k) / 3.0)).round() / 1e3;
        let frequencies: Vec<f64> = (0..700).rev().map(printed).collect();
        let values: Vec<Complex64> = frequencies.iter().map(|hz| (*hz).into()).collect();
        let lines = EvenLines::new(&frequencies).unwrap();
        let ascending: Vec<Complex64> = values.iter().rev().copied().collect();
        assert_eq!(lines.reordered(&values), Some(ascending));
        let uneven = EvenLines::new(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0]).unwrap();
        assert_eq!(uneven.reordered(&values), None);
    }

    #[test]
    fn lines_that_nearly_coincide_do_not_decide_the_spacing() {
        let mut frequencies: Vec<f64> = (0..100).map(f64::from).collect();
        frequencies.push(50.000_001);
        let lines = EvenLines::new(&frequencies).unwrap();
        assert!(lines.axis.len <= 16 * 101 + 1);
        let sweep: Vec<f64> = (0..400)
            .map(|k| 10.0 * 16f64.powf(f64::from(k) / 399.0))
            .collect();
        let step_hz = EvenLines::new(&sweep).unwrap().axis.step_hz;
        assert!(step_hz <= sweep[1] - sweep[0], "{step_hz}");
        for bad in [vec![1.0; 20], vec![1.0, 2.0, 3.0], vec![f64::NAN; 20]] {
            assert!(EvenLines::new(&bad).is_none());
        }
    }

    /// Lines of a logarithmic sweep with noise of this variance.
    fn sweep(variance: f64, ratio: f64, seed: u64) -> (Vec<f64>, Vec<Complex64>) {
        let lines = std::iter::successors(Some(10.0), |hz| Some(hz * ratio));
        let lines: Vec<f64> = lines.take_while(|hz| *hz < 40.0).collect();
        let values = noisy(&lines, |_| variance, seed);
        (lines, values)
    }

    fn noisy(lines: &[f64], variance: impl Fn(f64) -> f64, seed: u64) -> Vec<Complex64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut part = || random.sample::<f64, _>(StandardNormal);
        let noisy = |hz: &f64| {
            let noise = Complex64::new(part(), part());
            resonance(*hz) + (0.5 * variance(*hz)).sqrt() * noise
        };
        lines.iter().map(noisy).collect()
    }

    /// The estimated noise of measured lines.
    fn estimated(hz: &[f64], values: &[Complex64]) -> Vec<f64> {
        let line = |(hz, value): (&f64, &Complex64)| Line {
            hz: *hz,
            value: *value,
        };
        let lines: Vec<Line> = hz.iter().zip(values).map(line).collect();
        noise_variances(&lines)
    }

    #[test]
    fn noise_is_estimated_from_neither_too_few_nor_too_many_lines() {
        let (hz, values) = sweep(1e-2, 1.001, 5);
        let mut noise = estimated(&hz, &values);
        noise.sort_unstable_by(f64::total_cmp);
        let at = |part: usize| noise[noise.len() * part / 100] / 1e-2;
        // Louder in a narrow band.
        let variance = |hz: f64| {
            if (29.5..30.5).contains(&hz) {
                1e-2
            } else {
                1e-6
            }
        };
        let values = noisy(&hz, variance, 6);
        let middle = hz.iter().position(|hz| *hz >= 30.0).unwrap();
        let loud = estimated(&hz, &values)[middle] / 1e-2;
        assert!(at(5) > 0.38 && at(95) < 2.3, "{} {}", at(5), at(95));
        assert!(loud > 0.1, "{loud}");
    }

    #[test]
    fn noise_of_measured_lines_is_estimated_from_their_neighbours() {
        for (variance, ratio) in [(1e-6, 1.001), (1e-1, 1.001), (1e-5, 1.003), (1e-2, 1.003)] {
            let draws = 20;
            let median = |seed: u64| {
                let (hz, values) = sweep(variance, ratio, seed);
                let mut noise = estimated(&hz, &values);
                noise.sort_unstable_by(f64::total_cmp);
                noise[noise.len() / 2] / variance
            };
            let mean = (0..draws).map(median).sum::<f64>() / draws as f64;
            assert!((0.9..1.15).contains(&mean), "{variance} {ratio} {mean}");
        }
    }

    #[test]
    fn the_variance_includes_the_error_of_interpolation() {
        for ratio in [1.002, 1.005, 1.01, 1.02] {
            let (hz, values) = sweep(0.0, ratio, 1);
            let lines = EvenLines::new(&hz).unwrap();
            for stated in [None, Some(vec![1e-12; lines.axis.len])] {
                let even = lines.interpolated(&values, stated.as_deref());
                let over_variance = |k: usize| {
                    let error = even.values[k] - resonance(lines.axis.hz(k));
                    error.norm_sqr() / even.variance[k]
                };
                let worst = (0..lines.axis.len).map(over_variance).fold(0.0, f64::max);
                assert!(worst < 1.0, "{ratio} {worst}");
            }
        }
    }
}
