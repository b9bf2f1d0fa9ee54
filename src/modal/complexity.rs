//! How far a complex shape is from a real one.

use num_complex::Complex64;

/// Modal phase collinearity: 1 for a shape whose components lie on one line through the origin, 0 for a circle.
///
/// With `S_xx = |Re phi|^2`, `S_yy = |Im phi|^2`, `S_xy = Re phi . Im phi` (not centred):
/// `((S_xx - S_yy)^2 + 4 S_xy^2) / (S_xx + S_yy)^2`. `None` for fewer than two components or a zero shape.
///
/// # Reference
/// Pappa, Elliott and Schenk (1993), A consistent-mode indicator for the eigensystem realization algorithm,
/// J. Guidance 16(5), eq. 13 to 15, in its equivalent closed form.
pub fn modal_phase_collinearity(shape: &[Complex64]) -> Option<f64> {
    let xx: f64 = shape.iter().map(|v| v.re * v.re).sum();
    let yy: f64 = shape.iter().map(|v| v.im * v.im).sum();
    let xy: f64 = shape.iter().map(|v| v.re * v.im).sum();
    (shape.len() >= 2 && xx + yy > 0.0)
        .then(|| ((xx - yy).powi(2) + 4.0 * xy * xy) / (xx + yy).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_real_shape_is_collinear_and_a_circle_is_not() {
        let turn = Complex64::from_polar(1.0, 0.7);
        let real: Vec<_> = [1.0, -2.0, 0.5].iter().map(|v| turn * *v).collect();
        assert!((modal_phase_collinearity(&real).unwrap() - 1.0).abs() < 1e-14);
        let circle = [Complex64::new(1.0, 0.0), Complex64::new(0.0, 1.0)];
        assert!(modal_phase_collinearity(&circle).unwrap() < 1e-14);
    }
}
