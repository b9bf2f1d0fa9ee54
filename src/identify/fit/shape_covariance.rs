//! Covariance of mode shapes by the errors of poles and participation factors.
//!
//! The shapes ψ are fitted at poles and participation factors u that have errors, with the
//! covariance `C = E[δu δuᴴ]`, the inverse of the Fisher information with the shapes projected out.
//! ψ depends on them by `dψ/du_k = −R⁻¹QᴴD_k` (D the derivatives of the model, QR its columns), so
//! that `Σ_kl s_k C_kl s_l*` adds to the variance that the residues of a mode have for exact u. A
//! change common to all residues of the mode is a change of its scale, not of the shape, and is
//! subtracted from `s_k` first, with the inverse variances as weights. An isolated mode with the
//! same ratio of noise at all outputs has no other change.

use num_complex::Complex64;

use crate::linalg::ComplexMatrix;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::fit::variable_projection::{Pattern, ShapeSolution};

/// Shapes of a block and their derivatives by its unknowns.
pub(in crate::identify) struct ShapeCovariance<'a> {
    /// Member and rank-one term of each column of shapes.
    pub columns: &'a [(usize, usize)],
    pub patterns: &'a [Pattern],
    /// One for each pattern; `None` for outputs without information.
    pub solutions: &'a [Option<ShapeSolution>],
    /// Covariance of the unknowns.
    pub covariance: &'a ComplexMatrix,
}

impl ShapeCovariance<'_> {
    /// Adds the effect of the errors of the unknowns to the variances of the residues of a member;
    /// none for a repeated pole.
    pub fn add_pole_uncertainty(&self, j: usize, root: &ModelPole, variances: &mut [f64]) {
        if root.multiplicity() > 1 {
            return;
        }
        let Some(column) = self.columns.iter().position(|(member, _)| *member == j) else {
            return;
        };
        let mut added = vec![0.0; root.residues.len()];
        let mut slopes = self.slopes(root, column);
        for unknown in 0..slopes.ncols() {
            remove_common_scale(slopes.col_as_slice_mut(unknown), &root.residues, variances);
        }
        let by_covariance = &slopes * self.covariance;
        for unknown in 0..slopes.ncols() {
            let terms = by_covariance.col_as_slice(unknown).iter();
            let terms = terms.zip(slopes.col_as_slice(unknown));
            for (sum, (product, slope)) in added.iter_mut().zip(terms) {
                *sum += product.re * slope.re + product.im * slope.im;
            }
        }
        for (variance, added) in variances.iter_mut().zip(added) {
            *variance += added.max(0.0);
        }
    }

    /// Derivatives of the residues by each unknown through the shape: FRFs × unknowns.
    fn slopes(&self, root: &ModelPole, column: usize) -> ComplexMatrix {
        let mut slopes = ComplexMatrix::zeros(root.residues.len(), self.covariance.nrows());
        for (pattern, solution) in self.patterns.iter().zip(self.solutions) {
            let Some(solution) = solution else { continue };
            let inverse = solution.inverse.subrows(column, 1);
            // `R⁻¹QᴴD` for a shape value of 1 in the term.
            let moves = inverse * &solution.within;
            let factors: Vec<Complex64> = pattern
                .inputs
                .iter()
                .map(|input| root.parts[0][*input] * root.decay().abs())
                .collect();
            for (t, &(unknown, of)) in solution.of.iter().enumerate() {
                let moves = -moves[(0, t)];
                let slopes = slopes.col_as_slice_mut(unknown);
                let shapes = solution.shapes.row(of);
                for ((functions, level), shape) in pattern.outputs.iter().zip(shapes.iter()) {
                    let slope = moves * shape * level;
                    for (f, factor) in functions.iter().zip(&factors) {
                        slopes[*f] += slope * factor;
                    }
                }
            }
        }
        slopes
    }
}

/// Subtracts from a change of residues the component proportional to the residues.
fn remove_common_scale(slope: &mut [Complex64], residues: &[Complex64], variances: &[f64]) {
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
}
