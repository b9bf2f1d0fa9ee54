//! Fewer coordinates for the same modes: static (Guyan) reduction, and SEREP, by which shapes
//! measured at some coordinates expand to all of them.

use crate::linalg::{RealMatrix, complex_matrix, real_matrix, singular_vectors, solve_definite};

use super::{SystemMatrices, TheoryError};

/// Least singular value, as a part of the largest, of the modes at the measured coordinates: below
/// it they do not separate the modes.
const INDEPENDENT: f64 = 1e-10;

/// A model over fewer coordinates.
#[derive(Clone, Debug)]
pub struct ReducedModel {
    /// `T^T M T`, `T^T C T`, `T^T K T` over the coordinates kept, in their order; no springs.
    pub matrices: SystemMatrices,
    /// `T`: all coordinates (rows) from those kept (columns).
    pub expansion: RealMatrix,
}

/// Static reduction to the coordinates `kept`: the others follow them without inertia.
///
/// `T = [I; -K_ss^-1 K_sm]` with `m` the coordinates kept and `s` the others; `K_ss` must be
/// positive definite, that is, the model with the kept coordinates held must be held. Frequencies
/// come out too high, the static deflection under forces on the kept coordinates exact.
///
/// # Errors
/// [`TheoryError::KeptCoordinates`] for none, one twice or one that is not there;
/// [`TheoryError::Linalg`] for a `K_ss` that is not definite.
///
/// # Reference
/// Guyan (1965), Reduction of stiffness and mass matrices, AIAA Journal 3, 380.
pub fn guyan(matrices: &SystemMatrices, kept: &[usize]) -> Result<ReducedModel, TheoryError> {
    let n = matrices.coordinates.len();
    check_kept(kept, n)?;
    let others: Vec<usize> = (0..n).filter(|i| !kept.contains(i)).collect();
    let k = &matrices.stiffness;
    let mut expansion = real_matrix(n, kept.len(), |i, a| f64::from(u8::from(kept[a] == i)));
    if !others.is_empty() {
        let size = others.len();
        let stiffness = real_matrix(size, size, |i, j| k[(others[i], others[j])]);
        let coupling = real_matrix(size, kept.len(), |i, a| -k[(others[i], kept[a])]);
        let followed = solve_definite(&stiffness, &coupling)?;
        for (i, &row) in others.iter().enumerate() {
            (0..kept.len()).for_each(|a| expansion[(row, a)] = followed[(i, a)]);
        }
    }
    Ok(ReducedModel {
        matrices: reduced(matrices, &expansion, kept),
        expansion,
    })
}

/// Expansion from readings to all coordinates through modes of the model: `T = Phi (B Phi)^+`.
///
/// `modes` has a mode in each column; `rows` are the observation rows `b` of the readings, of which
/// there must be as many as modes or more. A motion that is a sum of these modes comes back
/// exactly; any other as the sum that is nearest at the readings in the sense of least squares.
///
/// # Errors
/// [`TheoryError::MatrixSize`] for rows of another length or fewer than modes;
/// [`TheoryError::IndistinctModes`] where the readings do not separate the modes;
/// [`TheoryError::Linalg`].
///
/// # Reference
/// O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion process (SEREP),
/// IMAC 7, 29.
pub fn serep_expansion(modes: &RealMatrix, rows: &[Vec<f64>]) -> Result<RealMatrix, TheoryError> {
    let (n, m) = (modes.nrows(), modes.ncols());
    let wrong = rows.iter().find(|row| row.len() != n);
    if wrong.is_some() || rows.len() < m || m == 0 {
        return Err(TheoryError::MatrixSize {
            matrix: "readings",
            got_rows: rows.len(),
            got_columns: wrong.map_or(m, Vec::len),
            expected: m.max(1),
        });
    }
    let read = |i: usize, j: usize| -> f64 {
        let products = rows[i].iter().enumerate().map(|(k, b)| b * modes[(k, j)]);
        products.sum()
    };
    let svd = singular_vectors(&complex_matrix(rows.len(), m, |i, j| read(i, j).into()))?;
    let got = svd.values[m - 1] / svd.values[0];
    if got.is_nan() || got <= INDEPENDENT {
        return Err(TheoryError::IndistinctModes {
            modes: m,
            readings: rows.len(),
            got,
            expected: INDEPENDENT,
        });
    }
    // (B Phi)^+ = V S^-1 U^T, real because B Phi is.
    let inverse = real_matrix(m, rows.len(), |j, i| {
        let terms = (0..m).map(|k| svd.right[(j, k)] * svd.left[(i, k)].conj() / svd.values[k]);
        terms.sum::<num_complex::Complex64>().re
    });
    Ok(modes * inverse)
}

/// Reduction to the coordinates `kept` that has these modes of the full model exactly: SEREP.
///
/// The reduced matrices have the rank of the modes, so that they are definite only where as many
/// coordinates are kept as there are modes.
///
/// # Errors
/// As [`serep_expansion`]; [`TheoryError::KeptCoordinates`].
pub fn serep(
    matrices: &SystemMatrices,
    modes: &RealMatrix,
    kept: &[usize],
) -> Result<ReducedModel, TheoryError> {
    let n = matrices.coordinates.len();
    check_kept(kept, n)?;
    let row = |&at: &usize| (0..n).map(|i| f64::from(u8::from(i == at))).collect();
    let rows: Vec<Vec<f64>> = kept.iter().map(row).collect();
    let expansion = serep_expansion(modes, &rows)?;
    Ok(ReducedModel {
        matrices: reduced(matrices, &expansion, kept),
        expansion,
    })
}

fn check_kept(kept: &[usize], size: usize) -> Result<(), TheoryError> {
    let mut sorted = kept.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let inside = sorted.last().is_some_and(|last| *last < size);
    if inside && sorted.len() == kept.len() {
        return Ok(());
    }
    Err(TheoryError::KeptCoordinates {
        got: kept.to_vec(),
        size,
    })
}

fn reduced(matrices: &SystemMatrices, expansion: &RealMatrix, kept: &[usize]) -> SystemMatrices {
    let project = |a: &RealMatrix| {
        let product = expansion.transpose() * (a * expansion);
        let n = kept.len();
        real_matrix(n, n, |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
    };
    let coordinates = kept.iter().map(|&i| matrices.coordinates[i].clone());
    SystemMatrices {
        mass: project(&matrices.mass),
        damping: matrices.damping.as_ref().map(project),
        stiffness: project(&matrices.stiffness),
        coordinates: coordinates.collect(),
        springs: Vec::new(),
    }
}
