//! Lines of a stepped sine are close together at resonances and far apart between them; here they
//! are interpolated onto an even axis as fine as the closest of them.

use num_complex::Complex64;

use crate::axis::FrequencyAxis;

/// Fewest measured lines.
const MIN_LINES: usize = 8;
/// Measured lines that the pole near a line is estimated from. Fewer: it follows from noise alone.
/// More: a second pole is among them (`a_resonance_on_uneven_lines_is_interpolated`).
const NODES: usize = 6;
/// Measured lines that a value is interpolated from, once the pole is divided out.
const CUBIC_NODES: usize = 4;
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
        // A whole number of steps, so that lines on a grid stay where they are.
        let steps = (range / closest.max(finest) * (1.0 - 1e-9)).ceil().max(1.0);
        let axis = FrequencyAxis {
            start_hz,
            step_hz: range / steps,
            len: steps as usize + 1,
        };
        Some(Self { measured, axis })
    }

    /// The values of a function on the even lines; `values` has one for each measured line.
    ///
    /// Near one pole an FRF is `(a + b x + c x²)/(1 + d x)`, x from the wanted line: its product
    /// with `1 + d x` has no third divided difference, which gives d by least squares over the
    /// measured lines around, and the product at x = 0 by a cubic polynomial is the value.
    pub fn interpolated(&self, values: &[Complex64]) -> Vec<Complex64> {
        let mut above = 0;
        let line = |k: usize| {
            let hz = self.axis.hz(k);
            while above < self.measured.len() && self.measured[above].0 < hz {
                above += 1;
            }
            let last_start = self.measured.len() - NODES;
            let start = above.saturating_sub(NODES / 2).min(last_start);
            let nodes: [(f64, Complex64); NODES] = std::array::from_fn(|node| {
                let (at_hz, place) = self.measured[start + node];
                (at_hz - hz, values[place])
            });
            let first = (above - start).saturating_sub(CUBIC_NODES / 2);
            value_at_zero(&nodes, first.min(NODES - CUBIC_NODES))
        };
        (0..self.axis.len).map(line).collect()
    }
}

/// The value at x = 0 from nodes and the first of those that the cubic polynomial goes through.
fn value_at_zero(nodes: &[(f64, Complex64); NODES], first: usize) -> Complex64 {
    let (mut product, mut square) = (Complex64::ZERO, 0.0);
    for window in nodes.windows(CUBIC_NODES) {
        let plain = third_divided_difference(window, |(_, value)| *value);
        let times_x = third_divided_difference(window, |(x, value)| *value * *x);
        product += times_x.conj() * plain;
        square += times_x.norm_sqr();
    }
    let slope = match square > 0.0 {
        true => -product / square,
        false => Complex64::ZERO,
    };
    let cubic = &nodes[first..first + CUBIC_NODES];
    let term = |(place, (x, value)): (usize, &(f64, Complex64))| {
        let weight: f64 = others(cubic, place)
            .map(|other| other / (other - x))
            .product();
        *value * (1.0 + slope * *x) * weight
    };
    cubic.iter().enumerate().map(term).sum()
}

fn third_divided_difference(
    window: &[(f64, Complex64)],
    value: impl Fn(&(f64, Complex64)) -> Complex64,
) -> Complex64 {
    let term = |(place, node): (usize, &(f64, Complex64))| {
        let denominator: f64 = others(window, place).map(|other| node.0 - other).product();
        value(node) / denominator
    };
    window.iter().enumerate().map(term).sum()
}

/// The places of all nodes but one.
fn others(nodes: &[(f64, Complex64)], place: usize) -> impl Iterator<Item = f64> {
    let all = nodes.iter().enumerate();
    all.filter(move |(other, _)| *other != place)
        .map(|(_, (x, _))| *x)
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
            for (k, value) in lines.interpolated(&values).iter().enumerate() {
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
        let even = EvenLines::new(&frequencies).unwrap().interpolated(&values);
        assert_eq!(even.len(), 100);
        assert!((even[70].re - 70.5).abs() < 1e-9);
    }

    #[test]
    fn noise_is_not_amplified() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let frequencies: Vec<f64> = (0..400).map(|k| 10.0 * 1.006f64.powi(k)).collect();
        let mut part = || -> f64 { random.sample(StandardNormal) };
        let noise: Vec<Complex64> = (0..400).map(|_| Complex64::new(part(), part())).collect();
        let even = EvenLines::new(&frequencies).unwrap().interpolated(&noise);
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
        let even = lines.interpolated(&values);
        for (k, value) in even.iter().enumerate() {
            assert!((value - k as f64).norm() < 1e-9);
        }
    }

    #[test]
    fn lines_that_nearly_coincide_do_not_decide_the_spacing() {
        let mut frequencies: Vec<f64> = (0..100).map(f64::from).collect();
        frequencies.push(50.000_001);
        let lines = EvenLines::new(&frequencies).unwrap();
        assert!(lines.axis.len <= 16 * 101 + 1);
        for bad in [vec![1.0; 20], vec![1.0, 2.0, 3.0], vec![f64::NAN; 20]] {
            assert!(EvenLines::new(&bad).is_none());
        }
    }
}
