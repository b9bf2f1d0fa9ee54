//! A canonical basis for the modes of a repeated root.
//!
//! Any rotation of the vectors of a repeated root is as good a set of modes. What a solver returns
//! depends on rounding; what is returned here depends on the subspace alone, up to signs, which
//! [`fix_sign`] settles.

use crate::linalg::RealMatrix;

/// A coordinate that carries less than this share of its squared motion in the span counts as at
/// rest there: far above rounding (1e-18), far below a rotation in a fine mesh (1e-9).
const AT_REST: f64 = 1e-14;
/// A coordinate is independent of the pivots before it when this part of its squared row in the
/// span is left of it.
const INDEPENDENT: f64 = 1e-3;
/// Components within this part of the largest count as equally large, so that a symmetric shape's
/// sign does not hang on rounding.
const EQUAL_MAGNITUDE: f64 = 1e-6;

/// Replaces the columns `first..first + count`, orthonormal with respect to the mass, by the
/// canonical basis of their span.
///
/// The reduced row echelon basis of the span (the j-th vector 1 at the j-th pivot coordinate and 0
/// at the others, pivots in the order of the coordinates), orthonormalised in order. `total[i]` is
/// the sum of squares of coordinate `i` over all mass-normalised modes, `(M^-1)_ii`, in which the
/// unit of the coordinate cancels.
///
/// With `A` the rows at the pivots, the echelon basis has the coefficients `A^-1`; orthonormalising
/// its columns in order is orthonormalising the rows of `A` in reverse order, which is what is
/// done: nothing is inverted.
pub(super) fn canonicalise(vectors: &mut RealMatrix, first: usize, count: usize, total: &[f64]) {
    let rows: Vec<Vec<f64>> = (0..vectors.nrows())
        .map(|i| (first..first + count).map(|j| vectors[(i, j)]).collect())
        .collect();
    let pivots = pivots(&rows, count, total);
    let mut coefficients: Vec<Vec<f64>> = Vec::new();
    for &pivot in pivots.iter().rev() {
        coefficients.push(orthonormal_part(&rows[pivot], &coefficients));
    }
    coefficients.reverse();
    for (i, row) in rows.iter().enumerate() {
        for (j, column) in coefficients.iter().enumerate() {
            vectors[(i, first + j)] = dot(row, column);
        }
    }
}

/// The first coordinates, in order, that move and are independent of those before; failing one, the
/// best there is.
fn pivots(rows: &[Vec<f64>], count: usize, total: &[f64]) -> Vec<usize> {
    let mut chosen = Vec::new();
    let mut directions: Vec<Vec<f64>> = Vec::new();
    // A coordinate that depends on some directions depends on more of them, too.
    let mut first = 0;
    while chosen.len() < count {
        let left = |i: &usize| {
            let rest = rest(&rows[*i], &directions);
            dot(&rest, &rest)
        };
        let serves = |i: &usize| {
            let square = dot(&rows[*i], &rows[*i]);
            square > AT_REST * total[*i] && left(i) >= INDEPENDENT * square
        };
        let share = |i: &usize| left(i) / total[*i];
        let best = || (0..rows.len()).max_by(|a, b| share(a).total_cmp(&share(b)));
        let found = (first..rows.len()).find(serves);
        first = found.map_or(rows.len(), |pivot| pivot + 1);
        let pivot = found.or_else(best).expect("a mode has coordinates");
        directions.push(orthonormal_part(&rows[pivot], &directions));
        chosen.push(pivot);
    }
    chosen
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// `row` without its parts along orthonormal directions, twice, so that rounding of the first pass
/// is removed as well.
fn rest(row: &[f64], directions: &[Vec<f64>]) -> Vec<f64> {
    let mut rest = row.to_vec();
    for direction in directions.iter().chain(directions) {
        let part = dot(&rest, direction);
        rest.iter_mut()
            .zip(direction)
            .for_each(|(r, d)| *r -= part * d);
    }
    rest
}

fn orthonormal_part(row: &[f64], directions: &[Vec<f64>]) -> Vec<f64> {
    let rest = rest(row, directions);
    let norm = dot(&rest, &rest).sqrt();
    rest.iter().map(|r| r / norm).collect()
}

/// Turns column `j` so that its largest component, the first of equals, is positive.
pub(super) fn fix_sign(vectors: &mut RealMatrix, j: usize) {
    let n = vectors.nrows();
    let largest = (0..n).map(|i| vectors[(i, j)].abs()).fold(0.0, f64::max);
    let leads = |i: &usize| vectors[(*i, j)].abs() >= (1.0 - EQUAL_MAGNITUDE) * largest;
    let negative = (0..n).find(leads).is_some_and(|i| vectors[(i, j)] < 0.0);
    if negative {
        for i in 0..n {
            vectors[(i, j)] = -vectors[(i, j)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::real_matrix;

    /// Orthonormal columns spanning (1, 1, 0, 1) and (0, 0, 1, 1), turned by an angle.
    fn turned(angle: f64) -> RealMatrix {
        let a = [1.0, 1.0, 0.0, 1.0].map(|v: f64| v / 3f64.sqrt());
        let b: [f64; 4] = [-1.0, -1.0, 3.0, 2.0].map(|v: f64| v / 15f64.sqrt());
        let (sin, cos) = angle.sin_cos();
        real_matrix(4, 2, |i, j| {
            if j == 0 {
                cos * a[i] + sin * b[i]
            } else {
                cos * b[i] - sin * a[i]
            }
        })
    }

    #[test]
    fn every_rotation_of_a_basis_gives_the_echelon_vector_first() {
        // Echelon basis of the span: (1, 1, 0, 1) and (0, 0, 1, 1); the second coordinate repeats
        // the first, so that the pivots are 0 and 2. Orthonormalised in order: (1, 1, 0, 1)/sqrt 3
        // and (-1, -1, 3, 2)/sqrt 15.
        let expected = turned(0.0);
        for angle in [0.3, 1.0, 2.5, 4.0] {
            let mut vectors = turned(angle);
            canonicalise(&mut vectors, 0, 2, &[1.0; 4]);
            (0..2).for_each(|j| fix_sign(&mut vectors, j));
            for (i, j) in (0..4).flat_map(|i| [(i, 0), (i, 1)]) {
                assert!(
                    (vectors[(i, j)] - expected[(i, j)]).abs() < 1e-14,
                    "{angle} {i} {j}"
                );
            }
        }
    }

    #[test]
    fn no_coordinate_behind_a_pivot_is_passed_over() {
        let rows = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|row| row.to_vec());
        assert_eq!(pivots(&rows, 2, &[1.0; 3]), [0, 1]);
        // The second row repeats the first.
        let rows = [[1.0, 1.0], [2.0, 2.0], [0.0, 1.0]].map(|row| row.to_vec());
        assert_eq!(pivots(&rows, 2, &[1.0; 3]), [0, 2]);
    }

    #[test]
    fn the_first_of_equally_large_components_becomes_positive() {
        let mut vectors = real_matrix(3, 1, |i, _| [-1.0, 0.5, 1.0 + 1e-9][i]);
        fix_sign(&mut vectors, 0);
        assert!(vectors[(0, 0)] > 0.0 && vectors[(2, 0)] < 0.0);
    }
}
