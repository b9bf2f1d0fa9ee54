//! The circle fit estimates frequency and damping from the rate at which frequency sweeps the
//! Nyquist circle of one mode.
//!
//! The isolated receptance of a pole `λ = −σ + iω_d` is `A/(iω − λ)` on some constant: a circle of
//! diameter `|A|/σ` on which the point at `ω` lies at the angle `θ` from the resonance, seen from
//! the centre, with `tan(θ/2) = (ω − ω_d)/σ`, exactly. (A viscously damped *mobility* is a circle
//! as well, with `tan(θ/2) = (ω² − ω_n²)/(2ζω_nω)`; but only for real modes and as a whole. Once
//! the conjugate pole is subtracted with the other modes the receptance circle needs neither and
//! the angle is linear in frequency.)
//!
//! 1. Circle through the points of the window by Taubin's algebraic fit, which has no bias towards
//!    small circles when only an arc is there; the constant needs no model, because the centre is
//!    free.
//! 2. Least squares of the measured angles `ψ_k = φ − 2 atan((ω_k − ω_d)/σ)` for `φ, ω_d, σ`
//!    (Gauss-Newton). All angles carry the same noise, so that no weights are needed; the point of
//!    the largest sweep rate, which is the textbook's natural frequency, is where this curve is
//!    steepest, found from all points instead of two.
//! 3. Damping surface: every pair of a point below and one above the resonance gives `σ_ab = (ω_b −
//!    ω_a)/(tan(θ_b/2) − tan(θ_a/2))`. The damping is their mean, weighted by the inverse variance
//!    of each pair (`var σ_ab ∝ [(1+t_a²)² + (1+t_b²)²]/(t_b − t_a)²`), the quality figure their
//!    relative standard deviation.
//!
//! Functions are averaged with the weight diameter² over noise variance.
//!
//! References: Kennedy and Pancu (1947), J. Aeronautical Sciences 14(11); Ewins (2000), Modal
//! Testing, 2nd ed., section 4.3; Taubin (1991), IEEE PAMI 13(11), in the form of Chernov (2010),
//! Circular and Linear Regression, section 5.9.

use num_complex::Complex64;

use crate::linalg;

use crate::identify::sdof::single_mode_method::{
    FunctionFit, Isolated, SingleModeFit, SingleModeMethod,
};

/// Maximum number of Gauss-Newton steps; three suffice from any pole inside the half-power band.
const MAX_STEPS: usize = 20;

/// Circle fit with the damping surface.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::identify) struct CircleFit;

/// A circle in the complex plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Circle {
    pub center: Complex64,
    pub radius: f64,
}

/// Resonance angle, damped frequency and decay rate of a sweep.
#[derive(Clone, Copy, Debug)]
pub(in crate::identify) struct Sweep {
    pub phase: f64,
    pub omega: f64,
    pub decay: f64,
}

impl Sweep {
    pub fn tangent(&self, omega: f64) -> f64 {
        (omega - self.omega) / self.decay
    }

    /// Measured angle minus the angle of the sweep, in (−π, π].
    pub fn residual(&self, omega: f64, radius_vector: Complex64) -> f64 {
        let half = Complex64::new(1.0, self.tangent(omega));
        (radius_vector * Complex64::cis(-self.phase) * half / half.conj()).arg()
    }
}

/// Taubin's circle: minimises the algebraic distance over its mean squared gradient, by Newton's
/// method on the characteristic cubic from 0. `None` for points on a line.
pub(in crate::identify) fn circle_through(points: &[Complex64]) -> Option<Circle> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<Complex64>() / count;
    let scale = (points.iter().map(|p| (p - mean).norm_sqr()).sum::<f64>() / count).sqrt();
    if scale.is_nan() || scale <= 0.0 {
        return None;
    }
    let [mut xx, mut yy, mut xy, mut xz, mut yz, mut zz] = [0.0; 6];
    for p in points.iter().map(|p| (p - mean) / scale) {
        let z = p.norm_sqr();
        xx += p.re * p.re / count;
        yy += p.im * p.im / count;
        xy += p.re * p.im / count;
        xz += p.re * z / count;
        yz += p.im * z / count;
        zz += z * z / count;
    }
    let (z, covariance) = (xx + yy, xx * yy - xy * xy);
    let cubic = [
        xz * (xz * yy - 2.0 * yz * xy) + yz * yz * xx - zz * covariance + z * z * covariance,
        zz * z + 4.0 * covariance * z - xz * xz - yz * yz - z * z * z,
        -3.0 * z * z - zz,
        4.0 * z,
    ];
    let root = smallest_root(&cubic);
    let determinant = 2.0 * (root * root - root * z + covariance);
    let center =
        Complex64::new(xz * (yy - root) - yz * xy, yz * (xx - root) - xz * xy) / determinant;
    let radius = (center.norm_sqr() + z).sqrt();
    (radius.is_finite() && radius < 1e6).then(|| Circle {
        center: mean + scale * center,
        radius: scale * radius,
    })
}

fn smallest_root(cubic: &[f64; 4]) -> f64 {
    let mut x = 0.0;
    for _ in 0..MAX_STEPS {
        let value = cubic[0] + x * (cubic[1] + x * (cubic[2] + x * cubic[3]));
        let slope = cubic[1] + x * (2.0 * cubic[2] + x * 3.0 * cubic[3]);
        let next = x - value / slope;
        if !next.is_finite() || (next - x).abs() <= 1e-14 * next.abs() {
            break;
        }
        x = next;
    }
    x
}

/// Least squares of the angles seen from the centre, from an initial pole. `None` when the pole
/// leaves the window, or a step has no accurate solution.
pub(in crate::identify) fn fit_sweep(
    omega: &[f64],
    arms: &[Complex64],
    first: Complex64,
) -> Option<Sweep> {
    let mut sweep = Sweep {
        phase: 0.0,
        omega: first.im,
        decay: -first.re,
    };
    let unit_residual = |(w, arm): (&f64, &Complex64)| Complex64::cis(sweep.residual(*w, *arm));
    sweep.phase = omega
        .iter()
        .zip(arms)
        .map(unit_residual)
        .sum::<Complex64>()
        .arg();
    for _ in 0..MAX_STEPS {
        let step = gauss_newton_step(omega, arms, &sweep)?;
        let small = step[1].abs() + step[2].abs() < 1e-12 * sweep.omega;
        sweep.phase += step[0];
        sweep.omega += step[1].clamp(-sweep.decay, sweep.decay);
        sweep.decay = (sweep.decay + step[2]).clamp(0.5 * sweep.decay, 2.0 * sweep.decay);
        if small {
            break;
        }
    }
    let inside = sweep.omega > omega[0] && sweep.omega < omega[omega.len() - 1];
    (inside && sweep.decay.is_finite()).then_some(sweep)
}

fn gauss_newton_step(omega: &[f64], arms: &[Complex64], sweep: &Sweep) -> Option<Vec<f64>> {
    let columns = linalg::real_matrix(omega.len(), 3, |i, j| {
        let t = sweep.tangent(omega[i]);
        let slope = 2.0 / (sweep.decay * (1.0 + t * t));
        [1.0, slope, slope * t][j]
    });
    let residuals: Vec<f64> = omega
        .iter()
        .zip(arms)
        .map(|(w, arm)| sweep.residual(*w, *arm))
        .collect();
    linalg::least_squares_real(&columns, &residuals).ok()
}

/// Weighted mean and relative standard deviation of the damping surface; `None` without a pair.
fn damping_surface(omega: &[f64], arms: &[Complex64], sweep: &Sweep) -> Option<(f64, f64)> {
    let tangent = |(w, arm): (&f64, &Complex64)| {
        let theta = 2.0 * sweep.tangent(*w).atan() - sweep.residual(*w, *arm);
        (*w, (0.5 * theta).tan(), theta)
    };
    let points: Vec<(f64, f64, f64)> = omega.iter().zip(arms).map(tangent).collect();
    let is_usable = |p: &&(f64, f64, f64)| p.2.abs() < 0.95 * std::f64::consts::PI;
    let below = points
        .iter()
        .filter(|p| p.0 < sweep.omega && p.2 < 0.0)
        .filter(is_usable);
    let (mut weights, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for a in below {
        for b in points
            .iter()
            .filter(|p| p.0 > sweep.omega && p.2 > 0.0)
            .filter(is_usable)
        {
            let opening = b.1 - a.1;
            let decay = (b.0 - a.0) / opening;
            let noise = (1.0 + a.1 * a.1).powi(2) + (1.0 + b.1 * b.1).powi(2);
            let weight = opening * opening / noise;
            weights += weight;
            sum += weight * decay;
            squares += weight * decay * decay;
        }
    }
    let mean = sum / weights;
    (weights > 0.0).then(|| {
        (
            mean,
            (squares / weights / (mean * mean) - 1.0).max(0.0).sqrt(),
        )
    })
}

fn fit_function(isolated: &Isolated, function: usize) -> Option<FunctionFit> {
    let values = &isolated.values[function];
    let circle = circle_through(values)?;
    let arms: Vec<Complex64> = values.iter().map(|p| p - circle.center).collect();
    let sweep = fit_sweep(isolated.omega, &arms, isolated.lambda)?;
    let (decay, spread) = damping_surface(isolated.omega, &arms, &sweep)?;
    let radial_error = |arm: &Complex64| (arm.norm() - circle.radius).powi(2);
    let radial = arms.iter().map(radial_error).sum::<f64>() / arms.len() as f64;
    Some(FunctionFit {
        weight: circle.radius.powi(2) / (isolated.variance[function] + radial),
        lambda: Complex64::new(-decay, sweep.omega),
        spread,
    })
}

impl SingleModeMethod for CircleFit {
    fn name(&self) -> &'static str {
        "circle"
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
    use crate::identify::sdof::circle_fit::*;

    fn resonance(step: f64) -> (Vec<f64>, Vec<Complex64>) {
        let lambda = Complex64::new(-0.7, 100.2);
        let omega: Vec<f64> = (-8..=8).map(|k| 100.0 + step * f64::from(k)).collect();
        let value = |w: &f64| {
            Complex64::new(0.2, -3.0) / (Complex64::new(0.0, *w) - lambda)
                + Complex64::new(5.0, 1.0)
        };
        let values = omega.iter().map(value).collect();
        (omega, values)
    }

    #[test]
    fn displaced_rotated_circle_gives_its_pole_exactly() {
        for step in [0.05, 0.2, 0.6] {
            let (omega, values) = resonance(step);
            let isolated = Isolated {
                omega: &omega,
                values: vec![values],
                variance: vec![1e-12],
                lambda: Complex64::new(-1.0, 100.0),
            };
            let fit = CircleFit.fit(&isolated).unwrap();
            assert!(
                (fit.lambda - Complex64::new(-0.7, 100.2)).norm() < 1e-8,
                "{fit:?}"
            );
            assert!(fit.spread.unwrap() < 1e-7 && fit.omega_std_rad_s.is_none());
        }
    }

    #[test]
    fn points_on_a_line_are_no_circle() {
        let line: Vec<Complex64> = (0..9).map(|k| Complex64::new(f64::from(k), 2.0)).collect();
        assert_eq!(circle_through(&line), None);
        assert_eq!(circle_through(&[Complex64::ONE; 9]), None);
    }
}
