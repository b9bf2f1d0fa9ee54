//! The circle fit of one resonance in one FRF gives its circle, its resonance point and its damping
//! surface.

use num_complex::Complex64;

use crate::identify::sdof::circle_fit::{circle_through, fit_sweep};

/// The circle of one isolated resonance, as [`circle_detail`] gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct CircleDetail {
    /// Centre, m/N.
    pub center: Complex64,
    /// Radius, m/N.
    pub radius: f64,
    /// Point of the circle at the damped frequency, m/N.
    pub resonance: Complex64,
    /// Damped frequency at which the sweep of the angle is fastest, rad/s.
    pub omega_rad_s: f64,
    /// Lines below the resonance: indices into the window.
    pub below: Vec<usize>,
    /// Lines above it.
    pub above: Vec<usize>,
    /// Damping ratio of every pair of a line below (row) and a line above (column); `None` where
    /// the angle between them determines no damping.
    pub damping: Vec<Vec<Option<f64>>>,
}

/// Largest angle from the resonance at which a line still determines the damping, rad: at 180° the
/// circle closes.
const MAX_ANGLE_RAD: f64 = 0.95 * std::f64::consts::PI;

/// Circle and damping surface of the receptances in a window, with all other modes subtracted.
///
/// `first` is the initial pole, rad/s, as in the data. A line below the resonance at the angle
/// `θ_a` and one above at `θ_b`, seen from the centre, give the decay rate `(ω_b − ω_a)/(tan(θ_b/2)
/// − tan(θ_a/2))`; divided by the frequency of the resonance it is a damping ratio. `None` where
/// the points lie on no circle or the resonance is outside the window.
///
/// # Reference
/// Ewins (2000), Modal Testing, 2nd ed., section 4.3.
pub fn circle_detail(
    omega_rad_s: &[f64],
    values: &[Complex64],
    first: Complex64,
) -> Option<CircleDetail> {
    if omega_rad_s.len() != values.len() || values.len() < 3 {
        return None;
    }
    let circle = circle_through(values)?;
    let arms: Vec<Complex64> = values.iter().map(|p| p - circle.center).collect();
    let sweep = fit_sweep(omega_rad_s, &arms, first)?;
    let angle = |k: usize| {
        let swept = 2.0 * sweep.tangent(omega_rad_s[k]).atan();
        swept - sweep.residual(omega_rad_s[k], arms[k])
    };
    let angles: Vec<f64> = (0..values.len()).map(angle).collect();
    let is_usable = |k: &usize| angles[*k].abs() < MAX_ANGLE_RAD;
    let lines = || (0..values.len()).filter(is_usable);
    let below: Vec<usize> = lines()
        .filter(|k| omega_rad_s[*k] < sweep.omega && angles[*k] < 0.0)
        .collect();
    let above: Vec<usize> = lines()
        .filter(|k| omega_rad_s[*k] > sweep.omega && angles[*k] > 0.0)
        .collect();
    let ratio = |a: usize, b: usize| {
        let opening = (0.5 * angles[b]).tan() - (0.5 * angles[a]).tan();
        let ratio = (omega_rad_s[b] - omega_rad_s[a]) / opening / sweep.omega;
        ratio.is_finite().then_some(ratio)
    };
    let row = |a: &usize| above.iter().map(|b| ratio(*a, *b)).collect();
    let damping = below.iter().map(row).collect();
    Some(CircleDetail {
        center: circle.center,
        radius: circle.radius,
        resonance: circle.center + Complex64::from_polar(circle.radius, sweep.phase),
        omega_rad_s: sweep.omega,
        below,
        above,
        damping,
    })
}

#[cfg(test)]
mod tests {
    use crate::identify::sdof::circle_detail::*;

    #[test]
    fn an_exact_resonance_has_its_damping_at_every_pair() {
        let lambda = Complex64::new(-0.7, 100.1);
        let omega: Vec<f64> = (-8..=8).map(|k| 100.0 + 0.2 * f64::from(k)).collect();
        let value = |w: &f64| Complex64::new(0.2, -3.0) / (Complex64::new(0.0, *w) - lambda);
        let values: Vec<Complex64> = omega.iter().map(value).collect();
        let detail = circle_detail(&omega, &values, Complex64::new(-1.0, 100.0)).unwrap();
        assert!((detail.omega_rad_s - lambda.im).abs() < 1e-8);
        // The diameter is |A|/σ, and the resonance lies across the origin.
        assert!((detail.radius - 0.5 * Complex64::new(0.2, -3.0).norm() / 0.7).abs() < 1e-8);
        assert!((detail.resonance - 2.0 * detail.center).norm() < 1e-8);
        assert_eq!((detail.below.len(), detail.above.len()), (9, 8));
        for ratio in detail.damping.iter().flatten() {
            assert!((ratio.unwrap() - 0.7 / 100.1).abs() < 1e-9);
        }
    }

    #[test]
    fn too_few_points_or_a_line_are_no_circle() {
        let omega = [1.0, 2.0, 3.0, 4.0];
        let line: Vec<Complex64> = omega.iter().map(|w| Complex64::new(*w, 0.0)).collect();
        let first = Complex64::new(-0.1, 2.5);
        assert_eq!(circle_detail(&omega, &line, first), None);
        assert_eq!(circle_detail(&omega[..2], &line[..2], first), None);
        assert_eq!(circle_detail(&omega, &line[..3], first), None);
    }
}
