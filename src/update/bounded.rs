//! Bounded least squares minimises a linear residual between bounds.

use crate::linalg::{LinalgError, RealMatrix, least_squares_real, real_matrix};

/// Position of an unknown between its bounds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BoundState {
    Free,
    Lower,
    Upper,
}

/// `min |A x - b|` with `lower <= x <= upper`, by an active set: QR of the free columns, a step as
/// far as the first bound, and release of the bounded unknown whose gradient points inside most.
///
/// `A` is tall with full column rank; 0 lies between all bounds.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
///
/// # Reference
/// Stark and Parker (1995), Bounded-variable least squares: an algorithm and applications,
/// Computational Statistics 10, 129.
pub(super) fn bounded_least_squares(
    a: &RealMatrix,
    b: &[f64],
    bounds: &[(f64, f64)],
) -> Result<Vec<f64>, LinalgError> {
    let n = a.ncols();
    let mut x = vec![0.0; n];
    let mut place = vec![BoundState::Free; n];
    // Every pass binds or releases one unknown; in exact arithmetic no set of bound ones comes
    // twice.
    for _ in 0..10 * (n + 1) {
        let free: Vec<usize> = (0..n).filter(|&j| place[j] == BoundState::Free).collect();
        let goal = unbounded(a, b, &x, &free)?;
        let mut part = 1.0;
        let mut met = None;
        for (&j, &goal) in free.iter().zip(&goal) {
            let (bound, side) = if goal < bounds[j].0 {
                (bounds[j].0, BoundState::Lower)
            } else if goal > bounds[j].1 {
                (bounds[j].1, BoundState::Upper)
            } else {
                continue;
            };
            let ratio = (bound - x[j]) / (goal - x[j]);
            if ratio < part {
                part = ratio;
                met = Some((j, bound, side));
            }
        }
        for (&j, &goal) in free.iter().zip(&goal) {
            x[j] += part * (goal - x[j]);
        }
        if let Some((j, bound, side)) = met {
            x[j] = bound;
            place[j] = side;
            continue;
        }
        match to_release(a, b, &x, &place) {
            Some(j) => place[j] = BoundState::Free,
            None => break,
        }
    }
    Ok(x)
}

/// The free unknowns of the least-squares problem with the others fixed.
fn unbounded(
    a: &RealMatrix,
    b: &[f64],
    x: &[f64],
    free: &[usize],
) -> Result<Vec<f64>, LinalgError> {
    if free.is_empty() {
        return Ok(Vec::new());
    }
    let held = |j: &usize| !free.contains(j);
    let residual = |row: usize| {
        let parts = (0..a.ncols()).filter(held).map(|j| a[(row, j)] * x[j]);
        b[row] - parts.sum::<f64>()
    };
    let rhs: Vec<f64> = (0..a.nrows()).map(residual).collect();
    let columns = real_matrix(a.nrows(), free.len(), |row, k| a[(row, free[k])]);
    least_squares_real(&columns, &rhs)
}

/// The bounded unknown whose gradient points inside most, as a part of its column's length.
fn to_release(a: &RealMatrix, b: &[f64], x: &[f64], place: &[BoundState]) -> Option<usize> {
    /// Gradient over the residual that is round-off.
    const ROUND_OFF_GRADIENT: f64 = 1e-10;
    let row = |i: usize| (0..x.len()).map(|j| a[(i, j)] * x[j]).sum::<f64>();
    let residual: Vec<f64> = (0..a.nrows()).map(|i| b[i] - row(i)).collect();
    let size = residual.iter().map(|r| r * r).sum::<f64>().sqrt();
    let inward = |j: usize| {
        let products = (0..a.nrows()).map(|i| a[(i, j)] * residual[i]);
        let length = (0..a.nrows()).map(|i| a[(i, j)].powi(2)).sum::<f64>();
        let slope = products.sum::<f64>() / length.sqrt().max(f64::MIN_POSITIVE);
        match place[j] {
            BoundState::Free => 0.0,
            BoundState::Lower => slope,
            BoundState::Upper => -slope,
        }
    };
    let best = (0..x.len()).map(|j| (inward(j), j));
    let best = best.filter(|(inward, _)| *inward > ROUND_OFF_GRADIENT * size);
    best.max_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, j)| j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn inside_its_bounds_it_is_the_plain_solution() {
        let a = real_matrix(3, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        // 1 + 2 i.
        let x = bounded_least_squares(&a, &[1.0, 3.0, 5.0], &[(-9.0, 9.0); 2]).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-13 && (x[1] - 2.0).abs() < 1e-13);
    }

    proptest! {
        /// The conditions of Karush, Kuhn and Tucker, which are sufficient for a convex problem.
        #[test]
        fn no_unknown_can_move_inside_its_bounds_to_advantage(
            entries in proptest::collection::vec(-1.0..1.0f64, 24),
            b in proptest::collection::vec(-3.0..3.0f64, 8),
            widths in proptest::collection::vec(0.0..0.8f64, 6),
        ) {
            let a = real_matrix(8, 3, |i, j| entries[3 * i + j] + if i == j { 2.0 } else { 0.0 });
            let bounds: Vec<(f64, f64)> = (0..3).map(|j| (-widths[j], widths[3 + j])).collect();
            let x = bounded_least_squares(&a, &b, &bounds).unwrap();
            for j in 0..3 {
                let residual = |i: usize| b[i] - (0..3).map(|k| a[(i, k)] * x[k]).sum::<f64>();
                let gradient: f64 = (0..8).map(|i| a[(i, j)] * residual(i)).sum();
                let (lower, upper) = bounds[j];
                prop_assert!(lower <= x[j] && x[j] <= upper);
                prop_assert!(gradient < 1e-8 || x[j] >= upper);
                prop_assert!(gradient > -1e-8 || x[j] <= lower);
            }
        }
    }
}
