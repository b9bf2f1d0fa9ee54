//! FRFs computed directly from the matrices: no modal truncation, any damping.

use num_complex::Complex64;

use crate::linalg::{ComplexMatrix, complex_matrix, solve_square};

use super::{SystemMatrices, TheoryError};

/// Receptances at `s = i omega` (or any other point of the plane), one row for each response, one
/// column for each hit: `B_y (s^2 M + s C + K)^-1 B_f^T` with the observation rows of responses and
/// hits, m/N.
///
/// It costs a solution of all equations at every line, where a sum over modes costs one number for
/// each; it does not need proportional damping, and includes the modes above the band.
///
/// # Errors
/// [`TheoryError::MatrixSize`] of matrices that are not square over the coordinates;
/// [`TheoryError::RowLength`] of an observation row without one entry for each coordinate.
///
/// # Reference
/// Ewins (2000), Modal Testing, 2nd ed., section 2.6.
pub fn direct_receptance(
    matrices: &SystemMatrices,
    s: Complex64,
    responses: &[Vec<f64>],
    hits: &[Vec<f64>],
) -> Result<ComplexMatrix, TheoryError> {
    let n = matrices.coordinates.len();
    check_matrices(matrices, n)?;
    check_rows("response", responses, n)?;
    check_rows("hit", hits, n)?;
    let damping = |i, j| matrices.damping.as_ref().map_or(0.0, |c| c[(i, j)]);
    let dynamic = complex_matrix(n, n, |i, j| {
        s * s * matrices.mass[(i, j)] + s * damping(i, j) + matrices.stiffness[(i, j)]
    });
    let forces = complex_matrix(n, hits.len(), |i, hit| hits[hit][i].into());
    let moved = solve_square(&dynamic, &forces)?;
    Ok(complex_matrix(responses.len(), hits.len(), |row, hit| {
        let parts = responses[row].iter().enumerate();
        parts.map(|(i, b)| *b * moved[(i, hit)]).sum()
    }))
}

fn check_matrices(matrices: &SystemMatrices, expected: usize) -> Result<(), TheoryError> {
    let named = [
        ("mass", Some(&matrices.mass)),
        ("damping", matrices.damping.as_ref()),
        ("stiffness", Some(&matrices.stiffness)),
    ];
    for (matrix, entries) in named {
        let Some(entries) = entries else { continue };
        let (got_rows, got_columns) = (entries.nrows(), entries.ncols());
        if expected == 0 || got_rows != expected || got_columns != expected {
            return Err(TheoryError::MatrixSize {
                matrix,
                got_rows,
                got_columns,
                expected,
            });
        }
    }
    Ok(())
}

fn check_rows(what: &'static str, rows: &[Vec<f64>], expected: usize) -> Result<(), TheoryError> {
    let wrong = rows.iter().position(|row| row.len() != expected);
    wrong.map_or(Ok(()), |index| {
        Err(TheoryError::RowLength {
            what,
            index,
            got: rows[index].len(),
            expected,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::real_matrix;
    use crate::theory::{Coordinate, Motion};

    fn coordinate(name: &str) -> Coordinate {
        Coordinate {
            name: name.to_owned(),
            body: name.to_owned(),
            motion: Motion::Translation,
            axis: [1.0, 0.0, 0.0],
            at_m: [0.0; 3],
        }
    }

    /// Two masses on springs to the ground with a damper between them: `H` by the adjugate of two
    /// rows, written out.
    #[test]
    fn two_masses_with_a_damper_between_them_are_the_closed_form() {
        let (m, k, c) = ([2.0, 3.0], [500.0, 800.0], 4.0);
        let diagonal =
            |values: [f64; 2]| real_matrix(2, 2, |i, j| if i == j { values[i] } else { 0.0 });
        let mut matrices = SystemMatrices {
            mass: diagonal(m),
            damping: Some(real_matrix(2, 2, |i, j| if i == j { c } else { -c })),
            stiffness: diagonal(k),
            coordinates: vec![coordinate("a"), coordinate("b")],
            springs: Vec::new(),
        };
        // The second response is half of the first mass less the second one, as a sensor with a
        // lever would read it.
        let responses = [vec![1.0, 0.0], vec![0.5, -1.0]];
        let hits = [vec![0.0, 2.0]];
        for omega in [3.0, 15.8, 40.0] {
            let s = Complex64::I * omega;
            let [a, b] = [0, 1].map(|i| s * s * m[i] + s * c + k[i]);
            let determinant = a * b - s * s * c * c;
            let expected = [s * c * 2.0, s * c - a * 2.0].map(|numerator| numerator / determinant);
            let found = direct_receptance(&matrices, s, &responses, &hits).unwrap();
            for (row, wanted) in expected.into_iter().enumerate() {
                let got = found[(row, 0)];
                assert!(
                    (got - wanted).norm() < 1e-13 * wanted.norm(),
                    "{got} {wanted}"
                );
            }
        }
        matrices.damping = None;
        let found = direct_receptance(&matrices, Complex64::I * 10.0, &responses, &hits).unwrap();
        assert!(found[(0, 0)].norm() < 1e-18, "nothing joins them");
        assert!((found[(1, 0)] + 2.0 / 500.0).norm() < 1e-15);
    }

    #[test]
    fn inconsistent_sizes_are_reported() {
        let square = |n: usize| real_matrix(n, n, |i, j| if i == j { 1.0 } else { 0.0 });
        let good = SystemMatrices {
            mass: square(2),
            damping: None,
            stiffness: square(2),
            coordinates: vec![coordinate("a"), coordinate("b")],
            springs: Vec::new(),
        };
        let row = |n: usize| vec![1.0; n];
        let error = |matrices: &SystemMatrices, responses: &[Vec<f64>], hits: &[Vec<f64>]| {
            direct_receptance(matrices, Complex64::I, responses, hits).unwrap_err()
        };
        let rows = |what, index, got| TheoryError::RowLength {
            what,
            index,
            got,
            expected: 2,
        };
        let wrong = error(&good, &[row(2), row(3)], &[row(2)]);
        assert_eq!(wrong, rows("response", 1, 3));
        assert_eq!(
            wrong.to_string(),
            "observation row of response 1 (from 0): got 3 entries, expected 2 (one for each coordinate)"
        );
        assert_eq!(error(&good, &[row(2)], &[row(1)]), rows("hit", 0, 1));
        let size = |matrix, got, expected| TheoryError::MatrixSize {
            matrix,
            got_rows: got,
            got_columns: got,
            expected,
        };
        let mut bad = good.clone();
        bad.damping = Some(square(3));
        assert_eq!(error(&bad, &[row(2)], &[row(2)]), size("damping", 3, 2));
        bad = good.clone();
        bad.stiffness = square(1);
        assert_eq!(error(&bad, &[row(2)], &[row(2)]), size("stiffness", 1, 2));
        bad = good;
        bad.coordinates.clear();
        assert_eq!(error(&bad, &[], &[]), size("mass", 2, 0));
    }
}
