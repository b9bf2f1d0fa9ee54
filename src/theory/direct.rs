//! FRFs straight from the matrices: no modes, none left out, any damping.

use num_complex::Complex64;

use crate::linalg::{ComplexMatrix, complex_matrix, least_squares};

use super::SystemMatrices;

/// Receptances at `s = i omega` (or any other point of the plane), one row for each response, one column for each hit:
/// `B_y (s^2 M + s C + K)^-1 B_f^T` with the observation rows of responses and hits, m/N.
///
/// It costs a solution of all equations at every line, where a sum over modes costs one number for each; it needs no damping that
/// modes uncouple, and lacks no mode above the band. At a root of the equations the entries are not finite.
///
/// # Reference
/// Ewins (2000), Modal Testing, 2nd ed., section 2.6.
pub fn direct_receptance(
    matrices: &SystemMatrices,
    s: Complex64,
    responses: &[Vec<f64>],
    hits: &[Vec<f64>],
) -> ComplexMatrix {
    let n = matrices.coordinates.len();
    let damping = |i, j| matrices.damping.as_ref().map_or(0.0, |c| c[(i, j)]);
    let dynamic = complex_matrix(n, n, |i, j| {
        s * s * matrices.mass[(i, j)] + s * damping(i, j) + matrices.stiffness[(i, j)]
    });
    let forces = complex_matrix(n, hits.len(), |i, hit| hits[hit][i].into());
    let moved = least_squares(&dynamic, &forces);
    complex_matrix(responses.len(), hits.len(), |row, hit| {
        let parts = responses[row].iter().enumerate();
        parts.map(|(i, b)| *b * moved[(i, hit)]).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::real_matrix;
    use crate::theory::{Coordinate, Motion};

    /// Two masses on springs to the ground with a damper between them: `H` by the adjugate of two rows, written out.
    #[test]
    fn two_masses_with_a_damper_between_them_are_the_closed_form() {
        let (m, k, c) = ([2.0, 3.0], [500.0, 800.0], 4.0);
        let coordinate = |name: &str| Coordinate {
            name: name.to_owned(),
            body: name.to_owned(),
            motion: Motion::Translation,
            axis: [1.0, 0.0, 0.0],
            at_m: [0.0; 3],
        };
        let diagonal = |own: [f64; 2]| real_matrix(2, 2, |i, j| if i == j { own[i] } else { 0.0 });
        let mut matrices = SystemMatrices {
            mass: diagonal(m),
            damping: Some(real_matrix(2, 2, |i, j| if i == j { c } else { -c })),
            stiffness: diagonal(k),
            coordinates: vec![coordinate("a"), coordinate("b")],
            springs: Vec::new(),
        };
        // The second response is half of the first mass less the second one, as a sensor with a lever would read it.
        let responses = [vec![1.0, 0.0], vec![0.5, -1.0]];
        let hits = [vec![0.0, 2.0]];
        for omega in [3.0, 15.8, 40.0] {
            let s = Complex64::I * omega;
            let [a, b] = [0, 1].map(|i| s * s * m[i] + s * c + k[i]);
            let determinant = a * b - s * s * c * c;
            let expected = [s * c * 2.0, s * c - a * 2.0].map(|own| own / determinant);
            let found = direct_receptance(&matrices, s, &responses, &hits);
            for (row, wanted) in expected.into_iter().enumerate() {
                let own = found[(row, 0)];
                assert!(
                    (own - wanted).norm() < 1e-13 * wanted.norm(),
                    "{own} {wanted}"
                );
            }
        }
        matrices.damping = None;
        let own = direct_receptance(&matrices, Complex64::I * 10.0, &responses, &hits);
        assert!(own[(0, 0)].norm() < 1e-18, "nothing joins them");
        assert!((own[(1, 0)] + 2.0 / 500.0).norm() < 1e-15);
    }
}
