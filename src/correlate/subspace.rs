//! The subspace MAC compares a shape or a subspace with a subspace, as for a repeated root.

use num_complex::Complex64;

use crate::linalg::{complex_matrix, singular_values};

use super::CorrelateError;

/// Minimum length of the part of a vector that is independent of those before, over its length, for
/// a new direction.
const MIN_INDEPENDENT_FRACTION: f64 = 1e-8;

fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(x, y)| x.conj() * y).sum()
}

fn norm(a: &[Complex64]) -> f64 {
    inner(a, a).re.sqrt()
}

/// The Q of a QR decomposition by modified Gram-Schmidt, each vector twice; dependent vectors are
/// dropped.
pub(super) fn orthonormal(vectors: &[Vec<Complex64>]) -> Vec<Vec<Complex64>> {
    let mut basis: Vec<Vec<Complex64>> = Vec::new();
    for vector in vectors {
        let mut residual = vector.clone();
        for direction in basis.iter().chain(&basis) {
            let part = inner(direction, &residual);
            residual
                .iter_mut()
                .zip(direction)
                .for_each(|(r, d)| *r -= part * d);
        }
        let length = norm(&residual);
        if length > MIN_INDEPENDENT_FRACTION * norm(vector) {
            basis.push(residual.iter().map(|r| r / length).collect());
        }
    }
    basis
}

/// The fraction of a vector's squared length in the span of others: `|Q^H v|^2 / |v|^2` with
/// Q an orthonormal basis of the span.
///
/// For a span of one vector it is the modal assurance criterion; it does not depend on the basis of
/// the span. `None` when the vector or the whole span is zero. All vectors
/// have the same length.
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., sections 5.2.8 (modified Gram-Schmidt)
/// and 6.4.3.
pub fn subspace_mac(vector: &[Complex64], span: &[Vec<Complex64>]) -> Option<f64> {
    let basis = orthonormal(span);
    let squared = inner(vector, vector).re;
    if basis.is_empty() || squared <= 0.0 {
        return None;
    }
    let captured: f64 = basis.iter().map(|q| inner(q, vector).norm_sqr()).sum();
    Some((captured / squared).min(1.0))
}

/// The part of a vector that lies in the span of others, `Q Q^H v`.
pub(super) fn projection(vector: &[Complex64], span: &[Vec<Complex64>]) -> Vec<Complex64> {
    let mut part = vec![Complex64::ZERO; vector.len()];
    for q in orthonormal(span) {
        let along = inner(&q, vector);
        part.iter_mut().zip(&q).for_each(|(p, q)| *p += along * q);
    }
    part
}

/// Principal angles between two subspaces, ascending, degrees; as many as the smaller has
/// dimensions.
///
/// The cosines are the singular values of `Q_a^H Q_b`; an angle below about 1e-6 degrees is lost in
/// rounding.
///
/// # Errors
/// [`CorrelateError::Linalg`].
///
/// # Reference
/// Björck and Golub (1973), Numerical methods for computing angles between linear subspaces, Math.
/// Comp. 27.
pub fn principal_angles_deg(
    a: &[Vec<Complex64>],
    b: &[Vec<Complex64>],
) -> Result<Vec<f64>, CorrelateError> {
    let (a, b) = (orthonormal(a), orthonormal(b));
    if a.is_empty() || b.is_empty() {
        return Ok(Vec::new());
    }
    let product = complex_matrix(a.len(), b.len(), |i, j| inner(&a[i], &b[j]));
    let cosines = singular_values(&product)?;
    Ok(cosines
        .iter()
        .map(|c| c.min(1.0).acos().to_degrees())
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real(values: &[f64]) -> Vec<Complex64> {
        values.iter().map(|&v| v.into()).collect()
    }

    #[test]
    fn one_vector_gives_the_mac_and_a_plane_the_share_inside_it() {
        let v = real(&[1.0, 2.0, 2.0]);
        let mac = subspace_mac(&v, &[real(&[1.0, 0.0, 0.0])]).unwrap();
        assert!((mac - 1.0 / 9.0).abs() < 1e-15);
        // Two vectors that are not at a right angle span the plane x = 0, which holds 8 of 9 parts.
        let plane = [real(&[0.0, 1.0, 1.0]), real(&[0.0, 1.0, 3.0])];
        assert!((subspace_mac(&v, &plane).unwrap() - 8.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn a_dependent_vector_adds_nothing_and_zero_has_no_mac() {
        let v = real(&[1.0, 1.0]);
        let line = [real(&[1.0, 0.0]), real(&[-3.0, 0.0])];
        assert!((subspace_mac(&v, &line).unwrap() - 0.5).abs() < 1e-15);
        assert_eq!(subspace_mac(&real(&[0.0, 0.0]), &line), None);
        assert_eq!(subspace_mac(&v, &[real(&[0.0, 0.0])]), None);
    }

    #[test]
    fn two_planes_that_share_a_line_have_the_angle_between_their_other_lines() {
        let (sin, cos) = 25f64.to_radians().sin_cos();
        let a = [real(&[1.0, 0.0, 0.0]), real(&[1.0, 1.0, 0.0])];
        let b = [real(&[1.0, 0.0, 0.0]), real(&[5.0, cos, sin])];
        let angles = principal_angles_deg(&a, &b).unwrap();
        assert_eq!(angles.len(), 2);
        assert!(
            angles[0] < 1e-5 && (angles[1] - 25.0).abs() < 1e-10,
            "{angles:?}"
        );
    }
}
