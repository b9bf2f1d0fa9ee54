//! Repeated roots: how many independent shapes the residues of one pole show.
//!
//! Modes that share one pole λ leave `A = Σ_j ψ_j L_jᵀ` over responses × references: one pole in
//! every function, and as many singular values above the noise as there are modes, responses or
//! references, whichever is least. Around the mode every function is fitted with `b σ/(iω − λ)`,
//! constant, slope and the derivative `d σ²/(iω − λ)²`, with σ the decay rate. `B = U S V^H` gives
//! the number of shapes, `D` says whether they have one pole. The derivative keeps a frequency that
//! moved between hits or sensors, `d = b δ/σ`, out of `B`, where it would look like a shape.
//!
//! *Rank.* A shape counts when its singular value is above
//! - the noise. By Weyl's inequality no singular value beyond the true rank exceeds the norm of the
//!   noise matrix. For independent circular noise of deviations `s_rk` this norm is below `max_r
//!   (Σ_k s²)^½ + max_k (Σ_r s²)^½ + t max s` but for a probability `exp(−t²)`, whatever the rank:
//!   `t² = −ln p` with p false alarms per mode. The deviation of `b` is that of the function times
//!   the gain of the least squares; that of the function comes from its variance where the data
//!   brought it, else from what the fit leaves over;
//! - a share of the first, because not all that is unlike the first shape is another mode: skirts
//!   of modes outside the band leave up to 2 % (see `close`), and hits that were given anew for
//!   every group of sensors scatter by some per cent in place and direction, which raises the
//!   second singular value by that scatter times `n^{-½} + k^{-½}`.
//!
//! *One pole.* Shapes whose poles differ by `δ_j` give `D = Σ_j ψ_j L_jᵀ δ_j/σ`, so that `U^H D V
//! S^{-1}` has the eigenvalues `δ_j/σ`. Its largest singular value, the mean of its diagonal
//! subtracted, bounds their spread in half-power widths; to first order in the shift, so that poles
//! half a width apart show as 0.3 and those farther apart as no less. The root is a repeated one
//! only if this bound, noise included, is small: shapes whose poles the noise does not let tell
//! apart are close modes, not a repeated root.
//!
//! Only a set with every pair of its responses and references is judged; in others, as with one
//! reference or one response, a repeated root gives one mode.
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

/// False alarms of the rank per mode.
const FALSE_ALARM: f64 = 1e-5;
/// Room above the norm of the noise for the scatter of its variances.
const NOISE_ROOM: f64 = 1.3;
/// Share of the first singular value that something other than a mode can explain.
const LEAST_SHARE: f64 = 0.05;
/// Half-power widths that the poles of one repeated root may lie apart.
const MOST_SPREAD: f64 = 0.15;
/// Columns of the fit: pole, constant, slope, derivative.
const COLUMNS: usize = 4;

/// Place of every function in the matrix of responses × references.
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
            let own = references.iter().map(|k| index.get(&(*response, *k)));
            own.map(|i| i.copied()).collect::<Option<Vec<usize>>>()
        };
        let functions: Vec<Vec<usize>> = responses.iter().map(row).collect::<Option<_>>()?;
        (responses.len() >= 2 && references.len() >= 2).then_some(Self { functions })
    }

    fn matrix(&self, value: impl Fn(usize) -> Complex64) -> ComplexMatrix {
        let (rows, columns) = (self.functions.len(), self.functions[0].len());
        linalg::complex_matrix(rows, columns, |r, k| value(self.functions[r][k]))
    }
}

/// What the residues of one peak say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum Judgement {
    /// So many shapes with one pole; 1 for a single mode.
    OnePole(usize),
    /// Several shapes whose poles are not known to be one: bound of their spread in half-power
    /// widths.
    Apart(Excess),
}

/// The lines around one mode, the other modes subtracted.
pub(in crate::identify) struct Surroundings<'a> {
    /// Lines, rad/s.
    pub omega: &'a [f64],
    /// Pole, rad/s.
    pub lambda: Complex64,
    /// Receptance by function, m/N.
    pub rest: &'a [Vec<Complex64>],
    /// Noise variance of each function, (m/N)², where the data brought it.
    pub variance: Option<&'a [f64]>,
}

/// Coefficients of the fit of every function.
struct Fit {
    /// Of the pole.
    residue: Vec<Complex64>,
    /// Of the derivative.
    derivative: Vec<Complex64>,
    /// Standard deviation of the first.
    deviation: Vec<f64>,
}

/// The number of shapes under one peak and whether they share its pole.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub(in crate::identify) fn judge(
    table: &PairTable,
    around: &Surroundings,
) -> Result<Judgement, LinalgError> {
    if around.omega.len() < COLUMNS + 3 {
        return Ok(Judgement::OnePole(1));
    }
    let fit = fit(around);
    let svd = linalg::singular_vectors(&table.matrix(|f| fit.residue[f]))?;
    let least = noise_norm(table, &fit.deviation).max(LEAST_SHARE * svd.values[0]);
    let rank = svd.values.iter().filter(|s| **s > least).count();
    if rank < 2 {
        return Ok(Judgement::OnePole(1));
    }
    let derivative = table.matrix(|f| fit.derivative[f]);
    let projected = svd.left.adjoint() * derivative * &svd.right;
    let shift = |i: usize, j: usize| projected[(i, j)] / svd.values[j];
    let mean = (0..rank).map(|j| shift(j, j)).sum::<Complex64>() / rank as f64;
    let apart = linalg::complex_matrix(rank, rank, |i, j| {
        shift(i, j) - if i == j { mean } else { Complex64::ZERO }
    });
    let excess = Excess {
        value: linalg::singular_values(&apart)?[0],
        limit: MOST_SPREAD,
    };
    Ok(if excess.value > excess.limit {
        Judgement::Apart(excess)
    } else {
        Judgement::OnePole(rank)
    })
}

fn fit(around: &Surroundings) -> Fit {
    let lines = around.omega.len();
    let columns = pole_columns(around.omega, around.lambda, COLUMNS);
    let right = linalg::complex_matrix(lines, around.rest.len(), |i, f| around.rest[f][i]);
    let solution = linalg::least_squares(&columns, &right)
        .unwrap_or_else(|_| linalg::not_a_number(columns.ncols(), right.ncols()));
    let gain = gain(&columns);
    let deviation = match around.variance {
        Some(variance) => variance.iter().map(|v| (gain * v).sqrt()).collect(),
        None => {
            let left_over = &right - &columns * &solution;
            let square = |f: usize| {
                left_over
                    .col(f)
                    .iter()
                    .map(Complex64::norm_sqr)
                    .sum::<f64>()
            };
            let freedom = (lines - COLUMNS) as f64;
            let deviation = |f: usize| (gain * square(f) / freedom).sqrt();
            (0..around.rest.len()).map(deviation).collect()
        }
    };
    let row = |i: usize| (0..around.rest.len()).map(|f| solution[(i, f)]).collect();
    Fit {
        residue: row(0),
        derivative: row(COLUMNS - 1),
        deviation,
    }
}

/// Variance of the first coefficient for noise of variance 1: one over the squared norm of what the
/// other columns leave of its column.
fn gain(columns: &ComplexMatrix) -> f64 {
    let lines = columns.nrows();
    let own = linalg::complex_matrix(lines, 1, |i, _| columns[(i, 0)]);
    let others = linalg::complex_matrix(lines, COLUMNS - 1, |i, c| columns[(i, c + 1)]);
    let Ok(solution) = linalg::least_squares(&others, &own) else {
        return f64::NAN;
    };
    let left = &own - &others * solution;
    1.0 / left.col(0).iter().map(Complex64::norm_sqr).sum::<f64>()
}

/// What the norm of a matrix of independent noise with these deviations stays below.
fn noise_norm(table: &PairTable, deviation: &[f64]) -> f64 {
    let (rows, columns) = (table.functions.len(), table.functions[0].len());
    let square = |r: usize, k: usize| deviation[table.functions[r][k]].powi(2);
    let row = (0..rows).map(|r| (0..columns).map(|k| square(r, k)).sum::<f64>());
    let column = (0..columns).map(|k| (0..rows).map(|r| square(r, k)).sum::<f64>());
    let largest = deviation.iter().copied().fold(0.0, f64::max);
    let tail = (-FALSE_ALARM.ln()).sqrt() * largest;
    NOISE_ROOM * (row.fold(0.0, f64::max).sqrt() + column.fold(0.0, f64::max).sqrt() + tail)
}
