//! The modes of a repeated root: its residue matrix as a sum of as many rank-one parts as it has
//! shapes.
//!
//! The matrix is first cut to its rank m (its m largest singular values), then taken apart by
//! elimination: at a pivot `A_rk` the part is `a_·k a_r· / A_rk`, which clears row r and column k;
//! m such parts leave nothing. Any rotation of the modes of one root is as good a set of modes.
//! This one means something: the first is what moves when the structure is struck at the first
//! pivot, the next what moves at the second with the first at rest, and so on.
//!
//! *Scale.* At a driving point the pivot is `A_rr = φ_r²/(2iω_d)`, and by reciprocity the part is
//! `φ φᵀ/(2iω_d)` with a modal mass of 1 kg: the elimination is then the Cholesky factorisation of
//! `2iω_d A`, real, symmetric and positive semidefinite for real modes. Driving points are
//! therefore pivots as long as one is left that has the phase of a real mode and does not vanish
//! beside the rest. Without one the largest values are pivots, and nothing is known of the mass.
//!
//! *The same basis for the same data.* Structures with repeated roots are symmetric, so that equal
//! values are the rule and the largest is a matter of rounding; the pivot is the first, in the
//! order of the degrees of freedom, that is not much less than the largest (threshold pivoting,
//! Golub and Van Loan (2013), Matrix Computations, 4th ed., section 11.5.9; Cholesky with pivots in
//! section 4.2.8).

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::linalg::{self, ComplexMatrix, LinalgError};

use crate::identify::modes::shape::{Residues, as_of_a_real_mode, driving_point_sign};

/// A pivot is at least this share of the largest that could be taken; between the squared cosines
/// of simple fractions of a turn (1/4, 1/2, 3/4), which symmetric structures have.
const PIVOT_SHARE: f64 = 0.3;
/// Driving points below this share of the largest value left are of no use as pivots: errors grow
/// by its inverse.
const DRIVING_SHARE: f64 = 0.05;

/// One mode of a repeated root.
pub(in crate::identify) struct Part {
    /// Its residues, of rank one.
    pub residues: Residues,
    /// Whether its pivot is a driving point, so that its driving points give its modal mass.
    pub reciprocal: bool,
}

/// The residues of a root of multiplicity `count` with the damped frequency ω_d, rad/s, as `count`
/// rank-one parts whose sum is the nearest matrix of that rank; every pair of responses and
/// references must be there.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub(in crate::identify) fn parts(
    residues: &Residues,
    count: usize,
    damped_rad_s: f64,
) -> Result<Vec<Part>, LinalgError> {
    let mut table = Table::new(residues, count)?;
    let part = |_| {
        let (row, column, reciprocal) = table.pivot(damped_rad_s);
        Part {
            residues: table.take(row, column),
            reciprocal,
        }
    };
    Ok((0..count).map(part).collect())
}

/// What is left of the matrix, with its labels.
struct Table {
    responses: Vec<Dof>,
    references: Vec<Dof>,
    left: ComplexMatrix,
}

impl Table {
    fn new(residues: &Residues, rank: usize) -> Result<Self, LinalgError> {
        let responses: BTreeSet<&Dof> = residues.keys().map(|(response, _)| response).collect();
        let references: BTreeSet<&Dof> = residues.keys().map(|(_, reference)| reference).collect();
        let responses: Vec<Dof> = responses.into_iter().cloned().collect();
        let references: Vec<Dof> = references.into_iter().cloned().collect();
        let all: Vec<Complex64> = residues.values().copied().collect();
        let width = references.len();
        let matrix = linalg::complex_matrix(responses.len(), width, |r, k| all[r * width + k]);
        let left = linalg::singular_vectors(&matrix)?.truncated(rank);
        Ok(Self {
            responses,
            references,
            left,
        })
    }

    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let columns = self.references.len();
        (0..self.responses.len()).flat_map(move |r| (0..columns).map(move |k| (r, k)))
    }

    /// Row and column of the next pivot, and whether it is a driving point.
    fn pivot(&self, damped_rad_s: f64) -> (usize, usize, bool) {
        let size = |(r, k): (usize, usize)| self.left[(r, k)].norm();
        let largest = self.places().map(size).fold(0.0, f64::max);
        let serves = |(r, k): &(usize, usize)| {
            let sign = driving_point_sign(&self.responses[*r], &self.references[*k]);
            sign.is_some_and(|sign| {
                let square = Complex64::new(0.0, 2.0 * damped_rad_s * sign) * self.left[(*r, *k)];
                as_of_a_real_mode(square) && size((*r, *k)) >= DRIVING_SHARE * largest
            })
        };
        let driving: Vec<(usize, usize)> = self.places().filter(serves).collect();
        let best = driving.iter().map(|p| size(*p)).fold(0.0, f64::max);
        let large = |p: &(usize, usize), best: f64| size(*p) >= PIVOT_SHARE * best;
        match driving.iter().find(|p| large(p, best)) {
            Some((r, k)) => (*r, *k, true),
            None => {
                let (r, k) = self.places().find(|p| large(p, largest)).unwrap_or((0, 0));
                (r, k, false)
            }
        }
    }

    /// The part of a pivot, which is taken out of what is left.
    fn take(&mut self, row: usize, column: usize) -> Residues {
        let pivot = self.left[(row, column)];
        let mut part = BTreeMap::new();
        let term = |r: usize, k: usize| self.left[(r, column)] * (self.left[(row, k)] / pivot);
        let terms: Vec<((usize, usize), Complex64)> =
            self.places().map(|(r, k)| ((r, k), term(r, k))).collect();
        for ((r, k), value) in terms {
            self.left[(r, k)] -= value;
            let pair = (self.responses[r].clone(), self.references[k].clone());
            part.insert(pair, value);
        }
        part
    }
}
