//! Half-power points of a peak, from the inverse of its power.
//!
//! Around one pole `λ = −σ + iω_d` the isolated receptance is `A/(iω − λ)`, so that the inverse of
//! the power of any number of functions is a parabola in frequency, exactly: `1/Σ w_f|P_f|² = c [(ω
//! − ω_d)² + σ²]`. Its vertex is the damped frequency and its half-power points lie at `ω_d ± σ`.
//! The parabola is fitted through the lines around the top, and each half-power point is
//! interpolated on it between the two lines that enclose it, linearly in `(ω − ω_d)²`, which is
//! exact too: no bias from the line spacing, however coarse.

use std::ops::Range;

use crate::linalg;

/// Minimum power, relative to the peak, of the lines that the parabola is fitted to.
const MIN_TOP_POWER_RATIO: f64 = 0.6;

/// Frequency and decay of one peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct HalfPower {
    /// Frequency of the top, rad/s.
    pub omega_rad_s: f64,
    /// Distance of the lower half-power point, rad/s, when there is one.
    pub lower_rad_s: Option<f64>,
    /// Distance of the upper half-power point, rad/s, when there is one.
    pub upper_rad_s: Option<f64>,
}

impl HalfPower {
    /// Half the distance of the half-power points, a missing one replaced by the other, rad/s.
    pub fn decay_rad_s(&self) -> f64 {
        match (self.lower_rad_s, self.upper_rad_s) {
            (Some(lower), Some(upper)) => 0.5 * (lower + upper),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => 0.0,
        }
    }

    /// Distance of the nearer half-power point, rad/s: the better of the two while a neighbour
    /// widens one side.
    pub fn narrower_rad_s(&self) -> f64 {
        let sides = [self.lower_rad_s, self.upper_rad_s];
        sides.into_iter().flatten().fold(f64::INFINITY, f64::min)
    }

    /// Whether one of the points was not found.
    pub fn one_sided(&self) -> bool {
        self.lower_rad_s.is_none() || self.upper_rad_s.is_none()
    }
}

/// Frequency and half-power width of the peak at a line; `None` without a top or without any
/// half-power point.
pub(in crate::identify) fn half_power(
    omega: &[f64],
    power: &[f64],
    top: usize,
) -> Option<HalfPower> {
    let vertex = vertex(omega, power, top)?;
    let lower_rad_s = half_point(omega, power, &vertex, (0..=top).rev());
    let upper_rad_s = half_point(omega, power, &vertex, top..power.len());
    (lower_rad_s.is_some() || upper_rad_s.is_some()).then_some(HalfPower {
        omega_rad_s: vertex.omega,
        lower_rad_s,
        upper_rad_s,
    })
}

/// Lowest point of the inverse power.
struct Vertex {
    omega: f64,
    inverse: f64,
}

/// Lowest point of a parabola through the inverse power of the lines around the top. Where the
/// vertex lies outside these lines, the parabola passes through three lines, which enclose it.
fn vertex(omega: &[f64], power: &[f64], top: usize) -> Option<Vertex> {
    let near = |line: &usize| power[*line] >= MIN_TOP_POWER_RATIO * power[top];
    let left = (0..top).rev().take_while(near).count();
    let right = (top + 1..power.len()).take_while(near).count();
    if top == 0 || top + 1 >= power.len() {
        return None;
    }
    let wide = top - left.max(1)..top + right.max(1) + 1;
    vertex_of(omega, power, top, wide).or_else(|| vertex_of(omega, power, top, top - 1..top + 2))
}

/// Weighted least squares of the parabola. The noise of a power `S` is proportional to `√S`, that
/// of its inverse to `S^{-3/2}`, so that the weight is `S^{3/2}`.
fn vertex_of(omega: &[f64], power: &[f64], top: usize, lines: Range<usize>) -> Option<Vertex> {
    let (first, last) = (omega[lines.start], omega[lines.end - 1]);
    let scale = last - first;
    let x = |i: usize| (omega[lines.start + i] - omega[top]) / scale;
    let weight = |i: usize| (power[lines.start + i] / power[top]).powf(1.5);
    let columns = linalg::real_matrix(lines.len(), 3, |i, j| weight(i) * x(i).powi(j as i32));
    let inverse: Vec<f64> = (0..lines.len())
        .map(|i| weight(i) * power[top] / power[lines.start + i])
        .collect();
    let c = linalg::least_squares_real(&columns, &inverse).ok()?;
    let vertex = Vertex {
        omega: omega[top] - scale * c[1] / (2.0 * c[2]),
        inverse: (c[0] - c[1] * c[1] / (4.0 * c[2])) / power[top],
    };
    let inside = vertex.omega >= first && vertex.omega <= last;
    (c[2] > 0.0 && vertex.inverse > 0.0 && inside).then_some(vertex)
}

/// Distance from the vertex at which the inverse power doubles, searched along lines that lead
/// outwards from the top until one rises above it.
fn half_point(
    omega: &[f64],
    power: &[f64],
    vertex: &Vertex,
    mut lines: impl Iterator<Item = usize>,
) -> Option<f64> {
    let target = 2.0 * vertex.inverse;
    let mut inside = lines.next()?;
    let top = power[inside];
    for outside in lines.take_while(|line| power[*line] <= top) {
        let (a, b) = (1.0 / power[inside], 1.0 / power[outside]);
        if b >= target {
            let square = |line: usize| (omega[line] - vertex.omega).powi(2);
            let fraction = (target - a) / (b - a);
            let half = square(inside) + fraction * (square(outside) - square(inside));
            return (half > 0.0).then(|| half.sqrt());
        }
        inside = outside;
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::identify::data::half_power::*;

    fn highest(power: &[f64]) -> usize {
        let lines = 0..power.len();
        lines
            .max_by(|a, b| power[*a].total_cmp(&power[*b]))
            .unwrap()
    }

    #[test]
    fn single_resonance_gives_exact_frequency_and_bandwidth_from_few_or_many_lines() {
        for (step, shift) in [(0.9, 0.31), (0.3, 0.0), (0.05, -0.4)] {
            let (center, decay) = (100.0 + shift, 0.7);
            let omega: Vec<f64> = (0..400).map(|k| 90.0 + step * k as f64).collect();
            let power = |w: &f64| 5.0 / ((w - center).powi(2) + decay * decay);
            let power: Vec<f64> = omega.iter().map(power).collect();
            let fit = half_power(&omega, &power, highest(&power)).unwrap();
            assert!((fit.omega_rad_s - center).abs() < 1e-9 && !fit.one_sided());
            assert!((fit.decay_rad_s() - decay).abs() < 1e-9, "{step} {fit:?}");
        }
    }

    #[test]
    fn missing_half_power_point_is_reported_and_replaced_by_the_other() {
        let omega: Vec<f64> = (0..40).map(|k| 99.7 + 0.1 * f64::from(k)).collect();
        let power: Vec<f64> = omega
            .iter()
            .map(|w| 1.0 / ((w - 100.0).powi(2) + 0.25))
            .collect();
        let fit = half_power(&omega, &power, highest(&power)).unwrap();
        assert!(fit.one_sided() && (fit.decay_rad_s() - 0.5).abs() < 1e-9);
        assert_eq!(half_power(&omega[..6], &power[..6], 3), None);
    }
}
