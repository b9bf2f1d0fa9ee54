//! What the errors of poles and participation factors add to those of a shape.
//!
//! The shapes ψ are fitted at poles and participation factors u that have errors themselves, of the covariance `C = E[δu δuᴴ]`, the
//! inverse of the Fisher information with the shapes projected out. ψ follows them by `dψ/du_k = −R⁻¹QᴴD_k` (D the derivatives of the
//! model, QR its columns), so that the residues of a mode get `Σ_kl s_k C_kl s_l*` beside the variance that they have at known u. What
//! all residues of the mode share is a change of its scale, no part of the shape, and is taken out of `s_k` first, with the
//! inverse variances as weights. A mode by itself that all outputs see through the same ratio of noise has nothing left.

use num_complex::Complex64;

use crate::linalg::ComplexMatrix;

use super::linearised::{Pattern, Turn};
use super::roots::Root;

/// Shapes of a block and how they follow its unknowns.
pub(super) struct Turning<'a> {
    /// Member and part of each column of shapes.
    pub columns: &'a [(usize, usize)],
    pub patterns: &'a [Pattern],
    /// One for each pattern.
    pub turns: &'a [Turn],
    /// Of the unknowns.
    pub covariance: &'a ComplexMatrix,
}

impl Turning<'_> {
    /// Adds to the variances of a member's residues what the unknowns make of them; nothing where several modes share the root.
    pub fn widen(&self, (j, root): (usize, &Root), variances: &mut [f64]) {
        if root.multiplicity() > 1 {
            return;
        }
        let Some(column) = self.columns.iter().position(|own| own.0 == j) else {
            return;
        };
        let slopes = self.slopes(root, column);
        let slopes: Vec<Vec<Complex64>> = slopes
            .into_iter()
            .map(|own| without_scale(own, &root.residues, variances))
            .collect();
        for (f, variance) in variances.iter_mut().enumerate() {
            let row = |k: usize| -> Complex64 {
                let terms = slopes.iter().enumerate();
                terms
                    .map(|(l, slope)| self.covariance[(k, l)] * slope[f].conj())
                    .sum()
            };
            let added: Complex64 = (0..slopes.len()).map(|k| slopes[k][f] * row(k)).sum();
            *variance += added.re.max(0.0);
        }
    }

    /// Derivatives of the residues by each unknown, as far as they come by the shape.
    fn slopes(&self, root: &Root, column: usize) -> Vec<Vec<Complex64>> {
        let count = self.covariance.nrows();
        let mut slopes = vec![vec![Complex64::ZERO; root.residues.len()]; count];
        for (pattern, turn) in self.patterns.iter().zip(self.turns) {
            for (t, &(unknown, of)) in turn.of.iter().enumerate() {
                for (o, (functions, level)) in pattern.outputs.iter().enumerate() {
                    let slope = -turn.moves[(column, t)] * turn.shapes[(of, o)] * level;
                    for (f, input) in functions.iter().zip(&pattern.inputs) {
                        let factor = root.parts[0][*input] * root.decay().abs();
                        slopes[unknown][*f] += slope * factor;
                    }
                }
            }
        }
        slopes
    }
}

/// What is left of a change of residues beside one that all have in common.
fn without_scale(
    mut slope: Vec<Complex64>,
    residues: &[Complex64],
    variances: &[f64],
) -> Vec<Complex64> {
    let (mut product, mut square) = (Complex64::ZERO, 0.0);
    for ((s, a), v) in slope.iter().zip(residues).zip(variances) {
        if *v > 0.0 {
            product += a.conj() * s / v;
            square += a.norm_sqr() / v;
        }
    }
    if square > 0.0 {
        let common = product / square;
        for (s, a) in slope.iter_mut().zip(residues) {
            *s -= common * a;
        }
    }
    slope
}
