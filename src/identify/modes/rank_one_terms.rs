//! Rank-one terms of the residue matrix of a repeated pole give its modes, one per shape.
//!
//! The matrix is first truncated to its rank m (its m largest singular values), then decomposed by
//! elimination: at a pivot `A_rk` the term is `a_·k a_r· / A_rk`, which clears row r and column k;
//! after m terms the matrix is zero. Any rotation of the modes of a repeated pole is as good a set
//! of modes. This one has a physical meaning: the first mode is the motion under a force at the
//! first pivot, the second the motion under a force at the second pivot with the first at rest, and
//! so on.
//!
//! *Scale.* At a driving point the pivot is `A_rr = φ_r²/(2iω_d)`, and by reciprocity the term is
//! `φ φᵀ/(2iω_d)` with a modal mass of 1 kg: the elimination is then the Cholesky factorisation of
//! `2iω_d A`, real, symmetric and positive semidefinite for real modes. Driving points are
//! therefore pivots as long as one has the phase of a real mode and is not negligible compared with
//! the remainder. Without one the largest values are pivots, and the modal mass is undetermined.
//!
//! *The same basis for the same data.* Structures with repeated poles are symmetric, so that values
//! are often equal and round-off decides which is the largest; the pivot is the first, in the
//! order of the degrees of freedom, that is not much less than the largest (threshold pivoting,
//! Golub and Van Loan (2013), Matrix Computations, 4th ed., section 11.5.9; Cholesky with pivots in
//! section 4.2.8).

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::linalg::{self, ComplexMatrix, LinalgError};

use crate::identify::modes::shape::{Residues, driving_point_sign, has_real_mode_phase};

/// Minimum pivot over the largest one available; between the squared cosines of simple fractions of
/// a turn (1/4, 1/2, 3/4), which symmetric structures have.
const MIN_PIVOT_RATIO: f64 = 0.3;
/// Minimum driving point over the largest remaining value for a pivot: errors grow by its inverse.
const MIN_DRIVING_POINT_RATIO: f64 = 0.05;

/// Rank-one term of one mode of a repeated pole.
pub(in crate::identify) struct RankOneTerm {
    /// Its residues, of rank one.
    pub residues: Residues,
    /// Whether its pivot is a driving point, so that its driving points give its modal mass.
    pub reciprocal: bool,
}

/// The residues of a pole of multiplicity `count` with the damped frequency ω_d, rad/s, as `count`
/// rank-one terms whose sum is the nearest matrix of that rank; every pair of responses and
/// references must be present.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub(in crate::identify) fn decompose_residues(
    residues: &Residues,
    count: usize,
    damped_rad_s: f64,
) -> Result<Vec<RankOneTerm>, LinalgError> {
    let mut matrix = ResidueMatrix::new(residues, count)?;
    let next_term = |_| {
        let (row, column, reciprocal) = matrix.pivot(damped_rad_s);
        RankOneTerm {
            residues: matrix.extract_term(row, column),
            reciprocal,
        }
    };
    Ok((0..count).map(next_term).collect())
}

/// Remainder of the residue matrix after elimination, with its labels.
struct ResidueMatrix {
    responses: Vec<Dof>,
    references: Vec<Dof>,
    remainder: ComplexMatrix,
}

impl ResidueMatrix {
    fn new(residues: &Residues, rank: usize) -> Result<Self, LinalgError> {
        let responses: BTreeSet<&Dof> = residues.keys().map(|(response, _)| response).collect();
        let references: BTreeSet<&Dof> = residues.keys().map(|(_, reference)| reference).collect();
        let responses: Vec<Dof> = responses.into_iter().cloned().collect();
        let references: Vec<Dof> = references.into_iter().cloned().collect();
        let all: Vec<Complex64> = residues.values().copied().collect();
        let width = references.len();
        let matrix = linalg::complex_matrix(responses.len(), width, |r, k| all[r * width + k]);
        let remainder = linalg::singular_vectors(&matrix)?.truncated(rank);
        Ok(Self {
            responses,
            references,
            remainder,
        })
    }

    fn entries(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let columns = self.references.len();
        (0..self.responses.len()).flat_map(move |r| (0..columns).map(move |k| (r, k)))
    }

    /// Row and column of the next pivot, and whether it is a driving point.
    fn pivot(&self, damped_rad_s: f64) -> (usize, usize, bool) {
        let size = |(r, k): (usize, usize)| self.remainder[(r, k)].norm();
        let largest = self.entries().map(size).fold(0.0, f64::max);
        let is_usable = |(r, k): &(usize, usize)| {
            let sign = driving_point_sign(&self.responses[*r], &self.references[*k]);
            sign.is_some_and(|sign| {
                let square =
                    Complex64::new(0.0, 2.0 * damped_rad_s * sign) * self.remainder[(*r, *k)];
                has_real_mode_phase(square) && size((*r, *k)) >= MIN_DRIVING_POINT_RATIO * largest
            })
        };
        let driving: Vec<(usize, usize)> = self.entries().filter(is_usable).collect();
        let best = driving.iter().map(|p| size(*p)).fold(0.0, f64::max);
        let large = |p: &(usize, usize), best: f64| size(*p) >= MIN_PIVOT_RATIO * best;
        match driving.iter().find(|p| large(p, best)) {
            Some((r, k)) => (*r, *k, true),
            None => {
                let (r, k) = self.entries().find(|p| large(p, largest)).unwrap_or((0, 0));
                (r, k, false)
            }
        }
    }

    /// The rank-one term of a pivot, subtracted from the remainder.
    fn extract_term(&mut self, row: usize, column: usize) -> Residues {
        let pivot = self.remainder[(row, column)];
        let mut term_residues = BTreeMap::new();
        let term =
            |r: usize, k: usize| self.remainder[(r, column)] * (self.remainder[(row, k)] / pivot);
        let terms: Vec<((usize, usize), Complex64)> =
            self.entries().map(|(r, k)| ((r, k), term(r, k))).collect();
        for ((r, k), value) in terms {
            self.remainder[(r, k)] -= value;
            let pair = (self.responses[r].clone(), self.references[k].clone());
            term_residues.insert(pair, value);
        }
        term_residues
    }
}
