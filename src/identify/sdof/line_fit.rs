//! The line fit estimates a pole from two straight lines: the inverse of a difference of
//! receptances over frequency, and the slope of that line over the reference frequency.
//!
//! Around one pole `λ` the isolated receptance is `P(ω) = A/(iω − λ) + c`. The constant falls out
//! of a difference from a fixed frequency Ω, and
//!
//! `Δ(ω, Ω) = i(ω − Ω)/(P(ω) − P(Ω)) = −(iΩ − λ)(iω − λ)/A`
//!
//! is a straight line over ω for each Ω, with the slope `t(Ω) = (Ω + iλ)/A`, which is a straight
//! line over Ω: its slope is `1/A` and its root `Ω = −iλ`. Both lines are fitted by weighted least
//! squares with complex coefficients. Dobson (1987) writes this for hysteretic damping with real
//! and imaginary parts apart; with the conjugate pole subtracted before, viscous damping needs no
//! more.
//!
//! Noise of variance v on P puts `|ω − Ω|² · 2v/|P(ω) − P(Ω)|⁴` on Δ: the weights. They leave out,
//! in effect, lines far from the resonance and differences between neighbouring points of the
//! circle, the short arcs on which the method breaks down. FRFs are averaged with the weight power
//! over variance; the relative residual of their second lines is the figure of merit.
//!
//! Reference: Dobson (1987), A straight-line technique for extracting modal properties from
//! frequency response data, MSSP 1(1); Ewins (2000), Modal Testing, 2nd ed., chapter 4.

use num_complex::Complex64;

use crate::identify::sdof::single_mode_method::{
    FunctionFit, Isolated, SingleModeFit, SingleModeMethod,
};

/// Line fit.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::identify) struct LineFit;

/// A straight line `a + b x` through weighted points, with its relative residual.
#[derive(Clone, Copy, Debug)]
struct Line {
    a: Complex64,
    b: Complex64,
    /// Weight of the slope: its inverse variance for weights that are inverse variances.
    precision: f64,
    /// Root mean square residual over the root mean square value.
    relative_residual: f64,
}

/// Weighted least squares of a straight line; `None` for fewer than three points or where all have
/// the same abscissa.
fn straight_line(points: &[(f64, Complex64, f64)]) -> Option<Line> {
    let weights: f64 = points.iter().map(|p| p.2).sum();
    let mean_x = points.iter().map(|p| p.2 * p.0).sum::<f64>() / weights;
    let mean = points.iter().map(|p| p.2 * p.1).sum::<Complex64>() / weights;
    let precision: f64 = points.iter().map(|p| p.2 * (p.0 - mean_x).powi(2)).sum();
    if points.len() < 3 || !(precision > 0.0 && precision.is_finite()) {
        return None;
    }
    let slope = |p: &(f64, Complex64, f64)| p.2 * (p.0 - mean_x) * (p.1 - mean);
    let b = points.iter().map(slope).sum::<Complex64>() / precision;
    let a = mean - b * mean_x;
    let residual_power = |p: &(f64, Complex64, f64)| p.2 * (p.1 - a - b * p.0).norm_sqr();
    let power: f64 = points.iter().map(|p| p.2 * p.1.norm_sqr()).sum();
    let relative_residual = (points.iter().map(residual_power).sum::<f64>() / power).sqrt();
    Some(Line {
        a,
        b,
        precision,
        relative_residual,
    })
}

fn fit_function(isolated: &Isolated, function: usize) -> Option<FunctionFit> {
    let values = &isolated.values[function];
    // Frequencies from the pole of the pass before, in its decay rates, keep the numbers near 1.
    let (center, scale) = (isolated.lambda.im, isolated.lambda.re.abs());
    let x: Vec<f64> = isolated
        .omega
        .iter()
        .map(|w| (w - center) / scale)
        .collect();
    let slope_at = |fixed: usize| {
        let point = |k: usize| {
            let difference = values[k] - values[fixed];
            let step = x[k] - x[fixed];
            let weight = difference.norm_sqr().powi(2) / (step * step);
            (x[k], Complex64::new(0.0, step) / difference, weight)
        };
        let others = (0..x.len()).filter(|k| *k != fixed && values[*k] != values[fixed]);
        let points: Vec<(f64, Complex64, f64)> = others.map(point).collect();
        let line = straight_line(&points)?;
        Some((x[fixed], line.b, line.precision))
    };
    let slopes: Vec<(f64, Complex64, f64)> = (0..x.len()).filter_map(slope_at).collect();
    let line = straight_line(&slopes)?;
    // t = (Ω + iμ)/A with μ the pole in these units.
    let pole = -Complex64::I * line.a / line.b;
    let lambda = Complex64::new(0.0, center) + scale * pole;
    let power = line.b.norm_sqr().recip();
    let inside = lambda.re < 0.0
        && lambda.im > isolated.omega[0]
        && lambda.im < isolated.omega[isolated.omega.len() - 1];
    (inside && lambda.is_finite() && power.is_finite()).then(|| FunctionFit {
        weight: power / isolated.variance[function],
        lambda,
        spread: line.relative_residual,
    })
}

impl SingleModeMethod for LineFit {
    fn name(&self) -> &'static str {
        "line"
    }

    fn window(&self) -> (f64, usize) {
        (1.25, 3)
    }

    fn fit(&self, isolated: &Isolated) -> Option<SingleModeFit> {
        SingleModeFit::mean_over_functions(isolated, fit_function)
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::sdof::line_fit::*;
    use crate::identify::synthetic::white_noise;

    /// Six FRFs with noise of a standard deviation; the noise of each has its seed, from `seed` up.
    fn isolated(omega: &[f64], noise: f64, seed: u64) -> Isolated<'_> {
        let lambda = Complex64::new(-0.7, 100.2);
        let value = |(w, z): (&f64, Complex64)| {
            Complex64::new(0.2, -3.0) / (Complex64::new(0.0, *w) - lambda)
                + Complex64::new(5.0, 1.0)
                + z
        };
        let function = |seed: u64| {
            let noise = white_noise(omega.len(), noise * noise, seed);
            omega.iter().zip(noise).map(value).collect()
        };
        Isolated {
            omega,
            values: (seed..seed + 6).map(function).collect(),
            variance: vec![1e-12_f64.max(noise * noise); 6],
            lambda: Complex64::new(-1.0, 100.0),
        }
    }

    #[test]
    fn two_straight_lines_give_the_pole_of_a_displaced_rotated_circle() {
        for step in [0.05, 0.2, 0.6] {
            let omega: Vec<f64> = (-8..=8).map(|k| 100.0 + step * f64::from(k)).collect();
            let fit = LineFit.fit(&isolated(&omega, 0.0, 0)).unwrap();
            let error = (fit.lambda - Complex64::new(-0.7, 100.2)).norm();
            assert!(error < 1e-9 && fit.spread.unwrap() < 1e-9, "{fit:?}");
        }
    }

    #[test]
    fn pole_error_by_noise_matches_its_standard_deviation() {
        // A hundredth of the diameter at 19 lines: the standard deviation is a few thousandths of
        // the decay rate.
        let omega: Vec<f64> = (-9..=9).map(|k| 100.2 + 0.15 * f64::from(k)).collect();
        let (mut decay_ratios, mut frequency_ratios) = (Vec::new(), Vec::new());
        for draw in 0..400 {
            let fit = LineFit.fit(&isolated(&omega, 0.04, 6 * draw)).unwrap();
            let error = fit.lambda - Complex64::new(-0.7, 100.2);
            assert!(error.norm() < 0.03 * 0.7, "{error}");
            decay_ratios.push(error.re.abs() / fit.decay_std_rad_s.unwrap());
            frequency_ratios.push(error.im.abs() / fit.omega_std_rad_s.unwrap());
        }
        // The scatter of six functions leaves five degrees of freedom: the median magnitude of
        // Student's t is 0.727, and its standard deviation among 400 is 1/(2 · 0.56 · 20) = 0.045;
        // three and a half of these are allowed.
        for mut ratios in [decay_ratios, frequency_ratios] {
            ratios.sort_by(f64::total_cmp);
            assert!((0.57..0.88).contains(&ratios[200]), "{}", ratios[200]);
        }
    }

    #[test]
    fn points_on_a_line_are_no_resonance() {
        let omega: Vec<f64> = (0..9).map(|k| 100.0 + f64::from(k)).collect();
        let isolated = Isolated {
            omega: &omega,
            values: vec![vec![Complex64::ONE; 9]],
            variance: vec![1.0],
            lambda: Complex64::new(-1.0, 104.0),
        };
        assert!(LineFit.fit(&isolated).is_none());
    }
}
