//! Sensitivities of eigenvalues to the parameters of a model, repeated roots included.
//!
//! For a root `lambda` with the mass-normalised modes `Phi`, the derivatives by a parameter p are
//! the eigenvalues of `Phi^T (dK/dp - lambda dM/dp) Phi`: one for a single root; of a repeated
//! root, which splits, one for each branch as p grows, and the same ones, taken with the branches
//! in the reverse order, as it falls. The mean of the branches is the derivative of the cluster's
//! mean, to both sides. None of them depends on the choice of basis.
//!
//! # Reference
//! Fox and Kapoor (1968), Rates of change of eigenvalues and eigenvectors, AIAA Journal 6, 2426;
//! Mills-Curran (1988), Calculation of eigenvector derivatives for structures with repeated
//! eigenvalues, AIAA Journal 26, 867.

use crate::linalg::{RealMatrix, real_matrix, symmetric_eigen};

use super::system::SystemSlope;
use super::{
    ModelRoot, ParameterSpec, SystemDerivative, TheoreticalModel, TheoryError, TheoryModes,
};

/// Sensitivities of one root to the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct RootSensitivity {
    /// Angular frequency of the root, rad/s.
    pub omega_rad_s: f64,
    /// For every parameter, in the order of the model, the derivatives of `lambda = omega^2`,
    /// (rad/s)² per unit of the parameter, of the branches into which the root splits, ascending;
    /// as many as the root has modes. None of a number of parts
    /// ([`ParameterSpec::whole`](super::ParameterSpec::whole)).
    pub branches: Vec<Vec<f64>>,
}

impl RootSensitivity {
    /// Derivative of the mean of the branches by parameter `j`, (rad/s)² per unit; `None` for a
    /// number of parts.
    pub fn mean(&self, j: usize) -> Option<f64> {
        let branches = &self.branches[j];
        (!branches.is_empty()).then(|| branches.iter().sum::<f64>() / branches.len() as f64)
    }

    /// Relative change of the frequency per relative change of parameter `j` with this value, `p/(2
    /// lambda) dlambda/dp`; `None` for a root at 0 and for a number of parts.
    pub fn scaled(&self, j: usize, value: f64) -> Option<f64> {
        let lambda = self.omega_rad_s * self.omega_rad_s;
        let mean = self.mean(j).filter(|_| lambda > 0.0)?;
        Some(0.5 * value * mean / lambda)
    }
}

/// Derivatives of the matrices by every parameter, in their order; `None` for a number of parts.
///
/// # Errors
/// As [`TheoreticalModel::derivative`].
pub fn system_derivatives(
    model: &dyn TheoreticalModel,
    values: &[f64],
) -> Result<Vec<Option<SystemDerivative>>, TheoryError> {
    by_each(model, |j| model.derivative(values, j))
}

/// What a derivative by each parameter gives; `None` for a number of parts.
fn by_each<T>(
    model: &dyn TheoreticalModel,
    by: impl Fn(usize) -> Result<T, TheoryError>,
) -> Result<Vec<Option<T>>, TheoryError> {
    let all = model.parameters().iter().enumerate();
    let derivative = |(j, spec): (usize, &ParameterSpec)| (!spec.whole).then(|| by(j)).transpose();
    all.map(derivative).collect()
}

/// Sensitivities of the roots of these modes, which must be those of the matrices that were
/// differentiated.
///
/// # Errors
/// [`TheoryError::Linalg`] when the eigenvalues of a projection do not converge.
pub fn sensitivities(
    modes: &TheoryModes,
    roots: &[ModelRoot],
    derivatives: &[Option<SystemDerivative>],
) -> Result<Vec<RootSensitivity>, TheoryError> {
    let applied = derivatives.iter().map(|by| {
        let SystemDerivative {
            stiffness, mass, ..
        } = by.as_ref()?;
        Some(move |phi: &RealMatrix, lambda: f64| {
            shifted(&(stiffness * phi), &(mass * phi), lambda)
        })
    });
    of_roots(modes, roots, &applied.collect::<Vec<_>>())
}

/// Sensitivities of the roots of these modes, which are those of the model with these values, dense
/// or sparse.
///
/// # Errors
/// As [`system_derivatives`] and [`sensitivities`].
pub fn model_sensitivities(
    model: &dyn TheoreticalModel,
    values: &[f64],
    modes: &TheoryModes,
    roots: &[ModelRoot],
) -> Result<Vec<RootSensitivity>, TheoryError> {
    let slopes = by_each(model, |j| SystemSlope::of(model, values, j))?;
    let applied = slopes.iter().map(|by| {
        let by = by.as_ref()?;
        Some(move |phi: &RealMatrix, lambda: f64| {
            let [mass, stiffness] = by.products(phi);
            shifted(&stiffness, &mass, lambda)
        })
    });
    of_roots(modes, roots, &applied.collect::<Vec<_>>())
}

/// `A - lambda B`.
fn shifted(a: &RealMatrix, b: &RealMatrix, lambda: f64) -> RealMatrix {
    real_matrix(a.nrows(), a.ncols(), |i, j| a[(i, j)] - lambda * b[(i, j)])
}

/// `applied` gives `(dK - lambda dM) Phi` for each parameter that has a derivative.
fn of_roots(
    modes: &TheoryModes,
    roots: &[ModelRoot],
    applied: &[Option<impl Fn(&RealMatrix, f64) -> RealMatrix>],
) -> Result<Vec<RootSensitivity>, TheoryError> {
    let of_root = |root: &ModelRoot| {
        let branches = applied.iter().map(|by| match by {
            Some(by) => branches(modes, root, by),
            None => Ok(Vec::new()),
        });
        Ok(RootSensitivity {
            omega_rad_s: root.omega_rad_s,
            branches: branches.collect::<Result<_, _>>()?,
        })
    };
    roots.iter().map(of_root).collect()
}

/// Derivatives of the modes of one root by a parameter.
#[derive(Clone, Debug)]
pub struct ModeDerivatives {
    /// `Phi^T (dK/dp - lambda dM/dp) Phi` over the modes asked for, each column with the
    /// eigenvalue: derivatives of the eigenvalues on the diagonal, (rad/s)² per unit of the
    /// parameter.
    pub projected: RealMatrix,
    /// Derivatives of the vectors over all coordinates, one column per mode, without their parts
    /// along the modes themselves: those scale a vector or turn the basis, and leave the subspace
    /// what it is.
    pub vectors: RealMatrix,
}

/// Derivatives of the modes of several roots by one parameter, by expansion in all modes of the
/// model, which must all be there; one for each entry of `roots`, which holds the modes of a root.
///
/// `dphi = sum_k phi_k (phi_k^T (dK - lambda dM) phi)/(lambda - lambda_k)` over the modes `k` that
/// are not of its root: neither in its list nor of the same frequency, which a list of part of a
/// repeated root leaves out. Motions without mass, which have no mode, add `-G (dK - lambda dM)
/// phi` with their static compliance `G` ([`Condensation::relax`](super::Condensation::relax)),
/// also where `dM` gives them mass: the sum and `G` together are `(K - lambda M)^-1` without the
/// root.
///
/// # Errors
/// [`TheoryError::Linalg`] where the stiffness of motions without mass is not positive definite.
///
/// # Reference
/// Fox and Kapoor (1968), equation 18.
pub fn mode_derivatives(
    modes: &TheoryModes,
    roots: &[&[usize]],
    by: &SystemDerivative,
) -> Result<Vec<ModeDerivatives>, TheoryError> {
    let lambda = |k: usize| modes.omega_rad_s[k] * modes.omega_rad_s[k];
    // All columns at once: a product of matrices costs less than as many of a matrix and a vector.
    let columns: Vec<(usize, &[usize])> = roots
        .iter()
        .flat_map(|root| root.iter().map(move |&mode| (mode, *root)))
        .collect();
    let (n, m) = (modes.vectors.nrows(), columns.len());
    let phi = real_matrix(n, m, |i, c| modes.vectors[(i, columns[c].0)]);
    let (stiffness, mass) = (&by.stiffness * &phi, &by.mass * &phi);
    let force = real_matrix(n, m, |i, c| {
        stiffness[(i, c)] - lambda(columns[c].0) * mass[(i, c)]
    });
    let all = modes.vectors.transpose() * &force;
    let share = real_matrix(modes.vectors.ncols(), m, |k, c| {
        let (mode, root) = columns[c];
        let same = modes.omega_rad_s[k].to_bits() == modes.omega_rad_s[mode].to_bits();
        if same || root.contains(&k) {
            0.0
        } else {
            all[(k, c)] / (lambda(mode) - lambda(k))
        }
    });
    let mut vectors = &modes.vectors * &share;
    if let Some(condensation) = &modes.condensation {
        vectors -= condensation.relax(&force)?;
    }
    let mut first = 0;
    let part = |root: &&[usize]| {
        let start = first;
        first += root.len();
        ModeDerivatives {
            projected: real_matrix(root.len(), root.len(), |r, c| all[(root[r], start + c)]),
            vectors: real_matrix(n, root.len(), |i, c| vectors[(i, start + c)]),
        }
    };
    Ok(roots.iter().map(part).collect())
}

fn branches(
    modes: &TheoryModes,
    root: &ModelRoot,
    applied: impl Fn(&RealMatrix, f64) -> RealMatrix,
) -> Result<Vec<f64>, TheoryError> {
    let lambda = root.omega_rad_s * root.omega_rad_s;
    let (n, m) = (modes.vectors.nrows(), root.modes.len());
    let phi = real_matrix(n, m, |i, k| modes.vectors[(i, root.modes[k])]);
    let projected: RealMatrix = phi.transpose() * applied(&phi, lambda);
    if m == 1 {
        return Ok(vec![projected[(0, 0)]]);
    }
    let symmetric = real_matrix(m, m, |i, j| 0.5 * (projected[(i, j)] + projected[(j, i)]));
    Ok(symmetric_eigen(&symmetric)?.values)
}
