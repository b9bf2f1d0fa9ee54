//! All modes of a sparse model in which few motions carry mass, from the full condensed pair.
//!
//! `K_c = T^T K T` with `T = [I; -K_oo^-1 K_oa]`. `K T` is summed in twice the working precision;
//! its rows without mass are the residual of `T`, so that `K_c` has the square of the error of `T`
//! only, where `K_aa - K_ao K_oo^-1 K_oa` would have its error and the rounding of `K_aa`, which is
//! 1e9 of `K_c` for a mass on a mesh of 800 beam elements.

use crate::linalg::{
    self, LinalgError, RealMatrix, SparseMatrix, SparseModes, Wanted, real_matrix,
    sort_ascending_by,
};

use super::massless::rows_of;
use super::{Condensation, TheoryError};

/// Maximum number of motions with mass that are condensed into full matrices. Smaller: 200 masses
/// at 1e-10 of
/// the stiffness of their coordinates are found
/// (`modes_far_below_the_stiffness_of_their_coordinates_are_found`), 201 end in an error of block
/// Lanczos. Larger: time and memory, which are those of as many solutions.
pub(super) const MAX_MASSIVE_MOTIONS: usize = 200;
/// Fraction of an omega² within which it is one root with the one before.
const REPEATED: f64 = 1e-5;
const ZERO_ROUNDINGS: f64 = 4.0;

/// The lowest modes over all coordinates.
///
/// # Errors
/// [`TheoryError::Linalg`].
pub(super) fn lowest_modes(
    condensation: &Condensation,
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    wanted: Wanted,
    most: usize,
) -> Result<SparseModes, TheoryError> {
    let all = all_modes(condensation, stiffness, mass)?;
    let value = |j: usize| all.omega_squared[j];
    let count = all.omega_squared.len();
    let is_parted = |&j: &usize| {
        let gap = value(j) - value(j - 1);
        value(j) > ZERO_ROUNDINGS * all.rounding[j] && gap > REPEATED * value(j).abs()
    };
    let (found, counted_below) = match wanted {
        Wanted::Below(limit) => (
            all.omega_squared
                .partition_point(|omega_squared| *omega_squared < limit),
            Some(limit),
        ),
        Wanted::Lowest(least) => match (least.max(1)..count).find(is_parted) {
            Some(next) => (next, Some(0.5 * (value(next - 1) + value(next)))),
            None => (count, None),
        },
    };
    if found > most {
        return Err(LinalgError::TooManyModes { got: found, most }.into());
    }
    Ok(SparseModes {
        omega_squared: all.omega_squared[..found].to_vec(),
        vectors: all.vectors.subcols(0, found).to_owned(),
        rounding: all.rounding[..found].to_vec(),
        counted_below,
        solves: count,
    })
}

/// All modes, ascending, with Rayleigh quotients of the whole matrices.
fn all_modes(
    condensation: &Condensation,
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
) -> Result<SparseModes, TheoryError> {
    let division = &condensation.division;
    let (massive, massless) = (&division.massive, &division.massless);
    let turned = division.turned(stiffness)?;
    let followed = condensation.followed(&coupling(&turned, massive, massless))?;
    let condensed = condensed(&turned, massive, massless, &followed);
    let loaded = linalg::principal_block(&division.turned(mass)?, massive)?;
    let condensed_modes = linalg::symmetric_modes(&condensed, &loaded.to_dense())?;
    let vectors = condensation.whole(
        &condensed_modes.vectors,
        &(&followed * &condensed_modes.vectors),
    );
    let quotient =
        |j: usize| linalg::sparse_rayleigh_quotient(stiffness, mass, vectors.col_as_slice(j));
    let quotients: Vec<(f64, f64)> = (0..massive.len()).map(quotient).collect();
    let mut order: Vec<usize> = (0..massive.len()).collect();
    sort_ascending_by(&mut order, |&index| quotients[index].0);
    Ok(SparseModes {
        omega_squared: order.iter().map(|&j| quotients[j].0).collect(),
        vectors: real_matrix(condensation.size, order.len(), |i, j| {
            vectors[(i, order[j])]
        }),
        rounding: order.iter().map(|&j| quotients[j].1).collect(),
        counted_below: None,
        solves: massive.len(),
    })
}

/// `K_oa`.
fn coupling(turned: &SparseMatrix, massive: &[usize], massless: &[usize]) -> RealMatrix {
    let mut row_of = vec![None; turned.size()];
    let rows = massless.iter().enumerate();
    rows.for_each(|(row, &of)| row_of[of] = Some(row));
    let mut column = vec![None; turned.size()];
    let columns = massive.iter().enumerate();
    columns.for_each(|(number, &of)| column[of] = Some(number));
    let mut coupling = real_matrix(massless.len(), massive.len(), |_, _| 0.0);
    for (i, j, value) in turned.entries() {
        if let (Some(row), Some(number)) = (row_of[i], column[j]) {
            coupling[(row, number)] = value;
        }
    }
    coupling
}

/// `T^T K T`, symmetric.
fn condensed(
    turned: &SparseMatrix,
    massive: &[usize],
    massless: &[usize],
    followed: &RealMatrix,
) -> RealMatrix {
    let count = massive.len();
    let mut expansion = real_matrix(turned.size(), count, |_, _| 0.0);
    for j in 0..count {
        expansion[(massive[j], j)] = 1.0;
        for (i, &row) in massless.iter().enumerate() {
            expansion[(row, j)] = followed[(i, j)];
        }
    }
    let forces = turned.multiply_compensated(&expansion);
    let sum = rows_of(&forces, massive) + followed.transpose() * rows_of(&forces, massless);
    real_matrix(count, count, |i, j| 0.5 * (sum[(i, j)] + sum[(j, i)]))
}
