//! Null space of a symmetric matrix that should be positive definite, to working precision, and
//! solutions with one that is.
//!
//! All is judged in the scale of the diagonal: `D^-1/2 A D^-1/2` with `D = diag(A)`, which does not
//! depend on the units of the coordinates.

use super::pencil::Pencil;
use super::sparse::SparseMatrix;
use super::{LinalgError, RealMatrix, real_matrix};

/// Eigenvalues of the scaled matrix below this many `sqrt(n) eps` are 0. Smaller: rounding counts
/// as stiffness or mass (measured: 7 eps of a mass between two nodes, n = 4; 3 eps of a free beam,
/// n = 202; 2 eps of free chains, n up to 1000). Larger: a regular matrix counts as singular (a
/// clamped massless beam of 400 elements, n = 800, has 3200 `sqrt(n) eps`). Tests:
/// `a_mechanism_of_many_massless_nodes_is_seen_at_any_size_and_scale`,
/// `a_long_massless_beam_is_no_mechanism`.
const NULL_OVER_ROUNDING: f64 = 16.0;
/// Applications of the shifted inverse: each takes what is not in the null space down by the shift
/// over its eigenvalue.
const INVERSE_APPLICATIONS: usize = 3;
/// Steps of a hundredfold shift until the shifted matrix is definite; an indefinite one needs more
/// than rounding.
const SHIFT_TRIES: usize = 9;
/// Bisections of the shift of an indefinite matrix, from a factor of 100 to one of 1.005. Fewer:
/// the vector holds others than that of the lowest eigenvalue, and coordinates at rest are named;
/// test `negative_springs_on_massless_coordinates_are_named`.
const BISECTIONS: usize = 10;
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// The rows and columns `kept` of a matrix, in their order.
///
/// # Errors
/// [`LinalgError::OutsideMatrix`] never for rows of the matrix.
pub fn principal_block(a: &SparseMatrix, kept: &[usize]) -> Result<SparseMatrix, LinalgError> {
    let mut place = vec![None; a.size()];
    kept.iter()
        .enumerate()
        .for_each(|(new, &old)| place[old] = Some(new));
    let inside = a
        .entries()
        .filter_map(|(i, j, value)| Some((place[i]?, place[j]?, value)));
    SparseMatrix::from_entries(kept.len(), &inside.collect::<Vec<_>>())
}

/// Number of eigenvalues of `D^-1/2 A D^-1/2` that are 0 to working precision, or negative.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
///
/// # Reference
/// Parlett (1998), The Symmetric Eigenvalue Problem, theorem 3.3.1 (Sylvester's law of inertia).
pub fn null_dimension(a: &SparseMatrix) -> Result<usize, LinalgError> {
    if a.size() == 0 {
        return Ok(0);
    }
    let pencil = Pencil::new(a, &diagonal_or_one(a)?)?;
    let limit = null_limit(a.size());
    // A Cholesky factor of the matrix less the limit, whose pivots do not grow, proves that there
    // is none.
    if pencil.cholesky(1.0, limit).is_ok() {
        return Ok(0);
    }
    pencil.count_below(limit)
}

/// Number of eigenvalues of `D^-1/2 A D^-1/2` that are negative beyond working precision.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
pub fn negative_dimension(a: &SparseMatrix) -> Result<usize, LinalgError> {
    if a.size() == 0 {
        return Ok(0);
    }
    let pencil = Pencil::new(a, &diagonal_or_one(a)?)?;
    let limit = null_limit(a.size());
    if pencil.cholesky(1.0, -limit).is_ok() {
        return Ok(0);
    }
    pencil.count_below(-limit)
}

/// A vector of the null space of a matrix (of its lowest eigenvalue, where that is negative) with a
/// part of every direction in it, in the scale of the diagonal: squares of its components are
/// shares.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::NotPositiveDefinite`] for a matrix that no shift
/// within reach makes definite.
pub fn null_vector(a: &SparseMatrix) -> Result<Vec<f64>, LinalgError> {
    let n = a.size();
    let diagonal = diagonal_or_one(a)?;
    let pencil = Pencil::new(a, &diagonal)?;
    let factor = pencil.cholesky(1.0, -definite_shift(&pencil, null_limit(n)))?;
    // Components without a pattern, the same in every run.
    let mut vector = real_matrix(n, 1, |i, _| (i as f64 * GOLDEN_RATIO).fract() - 0.5);
    for _ in 0..INVERSE_APPLICATIONS {
        vector = diagonal.multiply(&vector);
        factor.solve(&mut vector);
        let largest = vector.col(0).iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        vector = real_matrix(n, 1, |i, _| vector[(i, 0)] / largest);
    }
    Ok((0..n)
        .map(|i| vector[(i, 0)] * diagonal.get(i, i).sqrt())
        .collect())
}

/// A shift that makes a matrix definite: the first where it does, else one little above the size of
/// its lowest eigenvalue, so that the inverse holds hardly more than the vector of that.
fn definite_shift(pencil: &Pencil, first: f64) -> f64 {
    let is_definite = |shift: &f64| pencil.cholesky(1.0, -shift).is_ok();
    if is_definite(&first) {
        return first;
    }
    let mut shifts = (1..SHIFT_TRIES).map(|step| first * 100f64.powi(step as i32));
    let Some(mut shift) = shifts.find(is_definite) else {
        return first;
    };
    let mut indefinite = shift / 100.0;
    for _ in 0..BISECTIONS {
        let between = (shift * indefinite).sqrt();
        match is_definite(&between) {
            true => shift = between,
            false => indefinite = between,
        }
    }
    shift
}

/// `A^-1 B` of a sparse symmetric positive definite matrix.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`]; [`LinalgError::NotConverged`].
pub fn solve_sparse_definite(a: &SparseMatrix, b: &RealMatrix) -> Result<RealMatrix, LinalgError> {
    let pencil = Pencil::new(a, &diagonal_or_one(a)?)?;
    let mut solution = b.clone();
    pencil.cholesky(1.0, 0.0)?.solve(&mut solution);
    Ok(solution)
}

/// The diagonal of a matrix, 1 where it is 0.
fn diagonal_or_one(a: &SparseMatrix) -> Result<SparseMatrix, LinalgError> {
    let entry = |i: usize| {
        let diagonal = a.get(i, i).abs();
        (i, i, if diagonal > 0.0 { diagonal } else { 1.0 })
    };
    SparseMatrix::from_entries(a.size(), &(0..a.size()).map(entry).collect::<Vec<_>>())
}

/// Eigenvalues of a matrix scaled to a unit diagonal that are 0 to working precision.
pub fn null_limit(size: usize) -> f64 {
    NULL_OVER_ROUNDING * (size as f64).sqrt() * f64::EPSILON
}
