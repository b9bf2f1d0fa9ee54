//! The complexity of a mode shape is its deviation from a real shape.

use num_complex::Complex64;

/// Modal phase collinearity: 1 for a shape whose components lie on one line through the origin, 0
/// for a circle.
///
/// With `S_xx = |Re phi|^2`, `S_yy = |Im phi|^2`, `S_xy = Re phi . Im phi` (not centred): `((S_xx -
/// S_yy)^2 + 4 S_xy^2) / (S_xx + S_yy)^2`. `None` for fewer than two components or a zero shape.
///
/// # Reference
/// Pappa, Elliott and Schenk (1993), A consistent-mode indicator for the eigensystem realization
/// algorithm, J. Guidance 16(5), eq. 13 to 15, in its equivalent closed form.
pub fn modal_phase_collinearity(shape: &[Complex64]) -> Option<f64> {
    let xx: f64 = shape.iter().map(|v| v.re * v.re).sum();
    let yy: f64 = shape.iter().map(|v| v.im * v.im).sum();
    let xy: f64 = shape.iter().map(|v| v.re * v.im).sum();
    (shape.len() >= 2 && xx + yy > 0.0)
        .then(|| ((xx - yy).powi(2) + 4.0 * xy * xy) / (xx + yy).powi(2))
}

/// Mean phase of a shape, rad in (−π/2, π/2]: the direction of the line through the origin that
/// fits its components best.
///
/// `½ arg Σ φ²`, the principal axis of the components in the complex plane. `None` for a shape
/// whose squares cancel, which has no direction.
///
/// # Reference
/// Heylen, Lammens and Sas (1997), Modal Analysis Theory and Testing, in its closed form for least
/// squares of distances from a line.
pub fn mean_phase(shape: &[Complex64]) -> Option<f64> {
    let squares: Complex64 = shape.iter().map(|v| v * v).sum();
    let power: f64 = shape.iter().map(Complex64::norm_sqr).sum();
    (squares.norm() > f64::EPSILON * power).then(|| 0.5 * squares.arg())
}

/// Mean phase deviation (MPD), rad: mean angle of the components from the line of their mean phase,
/// weighted by magnitude; 0 for a real shape.
///
/// `Σ |φ| acos(|Re φ e^{−iθ}|/|φ|) / Σ |φ|` with the mean phase θ. `None` where there is no mean
/// phase, or for fewer than two components.
///
/// # Reference
/// Heylen, Lammens and Sas (1997), Modal Analysis Theory and Testing; with weights: Reynders,
/// Houbrechts and De Roeck (2012), Fully automated (operational) modal analysis, MSSP 29.
pub fn mean_phase_deviation(shape: &[Complex64]) -> Option<f64> {
    let turn = Complex64::cis(-mean_phase(shape)?);
    let weights: f64 = shape.iter().map(|v| v.norm()).sum();
    let angle = |v: &Complex64| {
        let turned = v * turn;
        v.norm() * turned.im.abs().atan2(turned.re.abs())
    };
    (shape.len() >= 2).then(|| shape.iter().map(angle).sum::<f64>() / weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_phase_is_the_phase_of_the_fitted_line_and_its_deviation_the_angle_from_it() {
        let turn = Complex64::from_polar(1.0, 0.7);
        let real: Vec<_> = [1.0, -2.0, 0.5].iter().map(|v| turn * *v).collect();
        assert!((mean_phase(&real).unwrap() - 0.7).abs() < 1e-14);
        assert!(mean_phase_deviation(&real).unwrap() < 1e-7);
        // Two components of one size, 0.2 rad to either side of a line.
        let fan = [0.9, 0.5].map(|phase| Complex64::from_polar(2.0, phase));
        assert!((mean_phase(&fan).unwrap() - 0.7).abs() < 1e-14);
        assert!((mean_phase_deviation(&fan).unwrap() - 0.2).abs() < 1e-14);
        let circle = [Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0)];
        assert_eq!(
            (mean_phase(&circle), mean_phase_deviation(&circle)),
            (None, None)
        );
        assert_eq!(mean_phase_deviation(&real[..1]), None);
    }

    #[test]
    fn a_rotated_real_shape_is_collinear_and_a_circle_is_not() {
        let turn = Complex64::from_polar(1.0, 0.7);
        let real: Vec<_> = [1.0, -2.0, 0.5].iter().map(|v| turn * *v).collect();
        assert!((modal_phase_collinearity(&real).unwrap() - 1.0).abs() < 1e-14);
        let circle = [Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0)];
        assert!(modal_phase_collinearity(&circle).unwrap() < 1e-14);
    }
}
