//! The single-mode methods find the multiplicity of a repeated pole: the number of independent
//! shapes in the residues around it.
//!
//! Modes that share one pole λ leave `A = Σ_j ψ_j L_jᵀ` over responses × references: one pole in
//! every function, and as many singular values above the noise as there are modes, responses or
//! references, whichever is least. Around the mode every function is fitted with `b σ/(iω − λ)`,
//! constant, slope and the derivative `d σ²/(iω − λ)²`, with σ the decay rate. `B = U S V^H` gives
//! the number of shapes, `D` shows whether they have one pole. The derivative takes up a frequency
//! shift between hits or sensors, `d = b δ/σ`, which in `B` would look like a shape.
//!
//! *Rank.* A shape counts when its singular value is above
//! - the noise. By Weyl's inequality no singular value beyond the true rank exceeds the norm of the
//!   noise matrix. For independent circular noise of standard deviations `s_rk` this norm is below
//!   `max_r (Σ_k s²)^½ + max_k (Σ_r s²)^½ + t max s` but for a probability `exp(−t²)`, whatever the
//!   rank: `t² = −ln p` with p false alarms per mode. The standard deviation of `b` is that of the
//!   FRF times the gain of the least squares; that of the FRF is estimated from its variance where
//!   the data supply it, else from the residual of the fit;
//! - a fraction of the first singular value, because other effects also differ from the first
//!   shape: skirts of modes outside the band leave up to 2 % (see `single_mode_test`), and hits
//!   that are repeated for every group of sensors scatter by some per cent in position and
//!   direction, which raises the second singular value by that scatter times `n^{-½} + k^{-½}`.
//!
//! *One pole.* Shapes whose poles differ by `δ_j` give `D = Σ_j ψ_j L_jᵀ δ_j/σ`, so that `U^H D V
//! S^{-1}` has the eigenvalues `δ_j/σ`. Its largest singular value, the mean of its diagonal
//! subtracted, bounds their spread in half-power bandwidths, to first order in the shift: a
//! separation of half a bandwidth gives 0.3, a larger one no less. The pole is a repeated one only
//! if this bound, noise included, is small: shapes whose poles cannot be separated because of the
//! noise are close modes, not a repeated pole.
//!
//! Only a set with every pair of its responses and references is tested; in others, as with one
//! reference or one response, a repeated pole gives one mode.
//!
//! References: Shih, Tsuei, Allemang and Brown (1988), Mechanical Systems and Signal Processing
//! 2(4), for the rank; Davidson and Szarek (2001), Handbook of the Geometry of Banach Spaces 1,
//! theorem II.13, and Bandeira and van Handel (2016), Annals of Probability 44(4), theorem 3.1, for
//! the norm of the noise.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::frf::Function;
use crate::linalg::{self, ComplexMatrix, LinalgError};

use crate::identify::fit::residues::pole_columns;
use crate::identify::sdof::single_mode_test::Excess;

/// False-alarm probability of the rank, per mode.
const FALSE_ALARM_PROBABILITY: f64 = 1e-5;
/// Factor on the norm of the noise for the scatter of its variances.
const NOISE_NORM_MARGIN: f64 = 1.3;
/// Minimum singular value of a shape over the first; smaller ones need not come from a mode.
const MIN_SINGULAR_VALUE_RATIO: f64 = 0.05;
/// Maximum spread of the poles of one repeated pole, in half-power bandwidths.
const MAX_POLE_SPREAD_BANDWIDTHS: f64 = 0.15;
/// Columns of the fit: pole, constant, slope, derivative.
const COLUMNS: usize = 4;

/// Index of every FRF in the matrix of responses × references.
pub(in crate::identify) struct PairTable {
    /// Function by response, then by reference.
    functions: Vec<Vec<usize>>,
}

impl PairTable {
    /// The table of a set with two responses and two references or more and all their pairs.
    pub fn complete(functions: &[Function]) -> Option<Self> {
        let responses: BTreeSet<&Dof> = functions.iter().map(|f| &f.response).collect();
        let references: BTreeSet<&Dof> = functions.iter().map(|f| &f.reference).collect();
        let index: BTreeMap<(&Dof, &Dof), usize> = functions
            .iter()
            .enumerate()
            .map(|(i, f)| ((&f.response, &f.reference), i))
            .collect();
        let row = |response: &&Dof| {
            let row_indices = references.iter().map(|k| index.get(&(*response, *k)));
            row_indices
                .map(|i| i.copied())
                .collect::<Option<Vec<usize>>>()
        };
        let functions: Vec<Vec<usize>> = responses.iter().map(row).collect::<Option<_>>()?;
        (responses.len() >= 2 && references.len() >= 2).then_some(Self { functions })
    }

    fn matrix(&self, value: impl Fn(usize) -> Complex64) -> ComplexMatrix {
        let (rows, columns) = (self.functions.len(), self.functions[0].len());
        linalg::complex_matrix(rows, columns, |r, k| value(self.functions[r][k]))
    }
}

/// Number of shapes under one peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum ShapeCount {
    /// Number of shapes with one pole; 1 for a single mode.
    OnePole(usize),
    /// Several shapes whose poles may differ: bound of their spread in half-power bandwidths.
    SeparatePoles(Excess),
}

/// The lines around one mode, the other modes subtracted.
pub(in crate::identify) struct IsolatedLines<'a> {
    /// Lines, rad/s.
    pub omega: &'a [f64],
    /// Pole, rad/s.
    pub lambda: Complex64,
    /// Receptance by FRF, with the other modes subtracted, m/N.
    pub values: &'a [Vec<Complex64>],
    /// Noise variance of each FRF, (m/N)², where the data supply it.
    pub variance: Option<&'a [f64]>,
}

/// Coefficients of the fit of every function.
struct Fit {
    /// Of the pole.
    residue: Vec<Complex64>,
    /// Of the derivative.
    derivative: Vec<Complex64>,
    /// Standard residue_std of the first.
    residue_std: Vec<f64>,
}

/// The number of shapes under one peak and whether they share its pole.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub(in crate::identify) fn count_shapes(
    table: &PairTable,
    isolated: &IsolatedLines,
) -> Result<ShapeCount, LinalgError> {
    if isolated.omega.len() < COLUMNS + 3 {
        return Ok(ShapeCount::OnePole(1));
    }
    let fit = fit(isolated);
    let svd = linalg::singular_vectors(&table.matrix(|f| fit.residue[f]))?;
    let threshold =
        noise_norm(table, &fit.residue_std).max(MIN_SINGULAR_VALUE_RATIO * svd.values[0]);
    let rank = svd.values.iter().filter(|s| **s > threshold).count();
    if rank < 2 {
        return Ok(ShapeCount::OnePole(1));
    }
    let derivative = table.matrix(|f| fit.derivative[f]);
    let projected = svd.left.adjoint() * derivative * &svd.right;
    let shift = |i: usize, j: usize| projected[(i, j)] / svd.values[j];
    let mean = (0..rank).map(|j| shift(j, j)).sum::<Complex64>() / rank as f64;
    let pole_differences = linalg::complex_matrix(rank, rank, |i, j| {
        shift(i, j) - if i == j { mean } else { Complex64::ZERO }
    });
    let excess = Excess {
        value: linalg::singular_values(&pole_differences)?[0],
        limit: MAX_POLE_SPREAD_BANDWIDTHS,
    };
    Ok(if excess.value > excess.limit {
        ShapeCount::SeparatePoles(excess)
    } else {
        ShapeCount::OnePole(rank)
    })
}

fn fit(isolated: &IsolatedLines) -> Fit {
    let lines = isolated.omega.len();
    let columns = pole_columns(isolated.omega, isolated.lambda, COLUMNS);
    let right = linalg::complex_matrix(lines, isolated.values.len(), |i, f| isolated.values[f][i]);
    let solution = linalg::least_squares(&columns, &right)
        .unwrap_or_else(|_| linalg::not_a_number(columns.ncols(), right.ncols()));
    let gain = gain(&columns);
    let residue_std = match isolated.variance {
        Some(variance) => variance.iter().map(|v| (gain * v).sqrt()).collect(),
        None => {
            let residual = &right - &columns * &solution;
            let square = |f: usize| residual.col(f).iter().map(Complex64::norm_sqr).sum::<f64>();
            let freedom = (lines - COLUMNS) as f64;
            let residue_std = |f: usize| (gain * square(f) / freedom).sqrt();
            (0..isolated.values.len()).map(residue_std).collect()
        }
    };
    let row = |i: usize| {
        (0..isolated.values.len())
            .map(|f| solution[(i, f)])
            .collect()
    };
    Fit {
        residue: row(0),
        derivative: row(COLUMNS - 1),
        residue_std,
    }
}

/// Variance of the first coefficient for noise of variance 1: one over the squared norm of its
/// column after projection off the other columns.
fn gain(columns: &ComplexMatrix) -> f64 {
    let lines = columns.nrows();
    let pole_column = linalg::complex_matrix(lines, 1, |i, _| columns[(i, 0)]);
    let others = linalg::complex_matrix(lines, COLUMNS - 1, |i, c| columns[(i, c + 1)]);
    let Ok(solution) = linalg::least_squares(&others, &pole_column) else {
        return f64::NAN;
    };
    let unexplained = &pole_column - &others * solution;
    1.0 / unexplained
        .col(0)
        .iter()
        .map(Complex64::norm_sqr)
        .sum::<f64>()
}

/// Upper limit of the norm of a matrix of independent noise with these standard deviations.
fn noise_norm(table: &PairTable, residue_std: &[f64]) -> f64 {
    let (rows, columns) = (table.functions.len(), table.functions[0].len());
    let square = |r: usize, k: usize| residue_std[table.functions[r][k]].powi(2);
    let row = (0..rows).map(|r| (0..columns).map(|k| square(r, k)).sum::<f64>());
    let column = (0..columns).map(|k| (0..rows).map(|r| square(r, k)).sum::<f64>());
    let largest = residue_std.iter().copied().fold(0.0, f64::max);
    let tail = (-FALSE_ALARM_PROBABILITY.ln()).sqrt() * largest;
    NOISE_NORM_MARGIN * (row.fold(0.0, f64::max).sqrt() + column.fold(0.0, f64::max).sqrt() + tail)
}
