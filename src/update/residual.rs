//! The residuals of a root pair are differences of frequencies and shapes over their standard
//! deviations.
//!
//! Frequencies: `e = (f_model - f_test)/(f_test sigma)`. Where a root pair has as many measured
//! roots as modes, they are compared in ascending order. The residuals are their mean `sum
//! e/sqrt(k)` and their splits, the orthonormal contrasts `(e_1 + ... + e_j - j e_(j+1))/sqrt(j
//! (j+1))`; the sum of squares is that of the single `e`. Where fewer roots were measured, their
//! mean is compared with the mean of all modes of the root.
//!
//! Shapes: `r = (I - Q Q^T) psi` with `psi` the measured and `Q` a basis of the model's shapes at
//! the sensors, both divided by the deviations: the residual of a shape with free scale.
//! With equal deviations `sigma` of all `d` components, whose root mean square is 1, its square is
//! `d (1 - MAC)/sigma^2` (for a repeated root with the MAC of the subspace).

use crate::linalg::{RealMatrix, real_matrix, right_singular_vectors, sort_ascending_by};
use crate::theory::{ModeDerivatives, TheoryModes};

use super::model_state::ModelState;
use super::projection::{Projection, dot};
use super::target_shapes::TargetShapes;
use super::{RootPair, Target, UpdateError};

const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
/// Minimum ratio of the smallest to the largest singular value of the coefficients of measured
/// shapes that separate the branches of a root.
const MIN_SINGULAR_VALUE_RATIO: f64 = 0.2;

/// One root pair with its targets, modes and projections.
pub(super) struct RootPairResidual<'a> {
    targets: Vec<&'a Target>,
    modes: &'a TheoryModes,
    /// Ascending in frequency.
    members: Vec<usize>,
    /// The model's shapes at the sensors of each target that has shapes.
    projections: Vec<Option<Projection>>,
}

impl<'a> RootPairResidual<'a> {
    pub fn new(root_pair: &RootPair, targets: &'a [Target], states: &'a [ModelState]) -> Self {
        let modes = &states[root_pair.configuration].modes;
        let mut members = root_pair.modes.clone();
        sort_ascending_by(&mut members, |&member| modes.omega_rad_s[member]);
        let targets: Vec<&Target> = root_pair.targets.iter().map(|&t| &targets[t]).collect();
        let projection = |target: &&Target| {
            let shapes = target.shapes.as_ref()?;
            Some(Projection::of_modes(shapes, modes, &members))
        };
        Self {
            projections: targets.iter().map(projection).collect(),
            targets,
            modes,
            members,
        }
    }

    /// The modes whose derivatives it needs, in its order.
    pub fn modes_of_root_pair(&self) -> &[usize] {
        &self.members
    }

    /// For every target the modes, by their index in `members`, whose mean frequency it measures.
    fn branches(&self) -> Vec<std::ops::Range<usize>> {
        let measured: usize = self.targets.iter().map(|t| t.modes.len()).sum();
        let whole = 0..self.members.len();
        if measured != self.members.len() {
            return self.targets.iter().map(|_| whole.clone()).collect();
        }
        let mut start = 0;
        let next = |target: &&Target| {
            let range = start..start + target.modes.len();
            start = range.end;
            range
        };
        self.targets.iter().map(next).collect()
    }

    fn model_hz(&self, branch: &std::ops::Range<usize>) -> f64 {
        let omega = branch
            .clone()
            .map(|k| self.modes.omega_rad_s[self.members[k]]);
        omega.sum::<f64>() / branch.len() as f64 / std::f64::consts::TAU
    }

    /// Frequencies of the model that the targets measure, Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.branches().iter().map(|b| self.model_hz(b)).collect()
    }

    /// Mean and splits of numbers that belong to the targets; the mean alone where not all of the
    /// root was measured.
    fn contrasts(&self, e: &[f64]) -> Vec<f64> {
        let k = e.len();
        let mean = e.iter().sum::<f64>() / (k as f64).sqrt();
        let measured: usize = self.targets.iter().map(|t| t.modes.len()).sum();
        if measured != self.members.len() {
            return vec![mean];
        }
        let split = |j: usize| {
            let count = j as f64;
            let below: f64 = e[..j].iter().sum();
            (below - count * e[j]) / (count * (count + 1.0)).sqrt()
        };
        std::iter::once(mean).chain((1..k).map(split)).collect()
    }

    /// All residuals: frequencies, then shapes.
    pub fn values(&self) -> Vec<f64> {
        let pairs = self.targets.iter().zip(self.frequencies_hz());
        let e: Vec<f64> = pairs
            .map(|(target, hz)| (hz / target.hz - 1.0) / target.relative_std)
            .collect();
        let mut all = self.contrasts(&e);
        for (shapes, projection) in self.shapes() {
            let residuals = shapes.vectors.iter().map(|v| projection.residual(v));
            all.extend(residuals.flatten());
        }
        all
    }

    /// Derivatives of [`values`](Self::values) from those of its modes.
    pub fn derivatives(&self, by: &ModeDerivatives) -> Vec<f64> {
        let slopes = self.frequency_derivatives_hz(by);
        let pairs = self.targets.iter().zip(slopes);
        let e: Vec<f64> = pairs
            .map(|(target, slope)| slope / target.hz / target.relative_std)
            .collect();
        let mut all = self.contrasts(&e);
        for (shapes, projection) in self.shapes() {
            let change = &shapes.rows * &by.vectors;
            let vectors = shapes.vectors.iter();
            all.extend(vectors.flat_map(|v| projection.derivative(v, &change)));
        }
        all
    }

    /// Derivatives of [`frequencies_hz`](Self::frequencies_hz), Hz per unit of the parameter.
    pub fn frequency_derivatives_hz(&self, by: &ModeDerivatives) -> Vec<f64> {
        let slope = |k: usize| 0.5 * by.projected[(k, k)] / self.modes.omega_rad_s[self.members[k]];
        let mean = |branch: &std::ops::Range<usize>| {
            let sum: f64 = branch.clone().map(slope).sum();
            sum / branch.len() as f64 / std::f64::consts::TAU
        };
        self.branches().iter().map(mean).collect()
    }

    /// Turns the derivatives of a repeated root by all parameters, each with its weight, to one
    /// basis, so that the diagonals of `projected` are those of its branches: those whose shapes
    /// the targets measured, in their order, where the shapes separate them; else those into which
    /// a mixture of all parameters splits the root, ascending. Where the parameters split the root
    /// into the same shapes, these are the branches of each single parameter, too.
    pub fn split(&self, by: &mut [(&mut ModeDerivatives, f64)]) -> Result<(), UpdateError> {
        let m = self.members.len();
        let bits = |k: usize| self.modes.omega_rad_s[self.members[k]].to_bits();
        if m < 2 || (1..m).any(|k| bits(k) != bits(0)) {
            return Ok(());
        }
        if let Some(basis) = self.measured_basis()? {
            for (pencil, _) in by {
                pencil.projected = basis.transpose() * &pencil.projected * &basis;
            }
            return Ok(());
        }
        let mut mixture = real_matrix(m, m, |_, _| 0.0);
        for (number, (pencil, weight)) in by.iter().enumerate() {
            let p =
                |r: usize, c: usize| weight * (pencil.projected[(r, c)] + pencil.projected[(c, r)]);
            let entries = (0..m * m).map(|i| p(i / m, i % m).powi(2));
            let size = entries.sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            // Parts without a ratio among whole numbers: no two sums of parameters weigh the same.
            let part = 1.0 + (number as f64 * GOLDEN_RATIO).fract();
            mixture += real_matrix(m, m, |r, c| part * p(r, c) / size);
        }
        let basis = crate::linalg::symmetric_eigen(&mixture)?.vectors;
        for (pencil, _) in by {
            pencil.projected = basis.transpose() * &pencil.projected * &basis;
        }
        Ok(())
    }

    /// The orthonormal basis of a root next to the measured shapes, one column for each of them: `C
    /// (C^T C)^(-1/2)` with the shapes' coefficients `C` over the modes. `None` unless as many were
    /// measured as there are modes, and the shapes separate them.
    fn measured_basis(&self) -> Result<Option<RealMatrix>, UpdateError> {
        let m = self.members.len();
        let of_shapes = |(shapes, projection): (&TargetShapes, &Projection)| {
            let vectors = shapes.vectors.iter();
            let residuals = vectors
                .map(|v| (projection.columns.len() == m).then(|| projection.coefficients(v)));
            residuals.collect::<Vec<_>>()
        };
        let columns: Option<Vec<Vec<f64>>> = self.shapes().flat_map(of_shapes).collect();
        let Some(columns) = columns.filter(|columns| columns.len() == m) else {
            return Ok(None);
        };
        let unit = |column: &Vec<f64>| {
            let length = dot(column, column).sqrt();
            column.iter().map(|x| x / length).collect::<Vec<f64>>()
        };
        let columns: Vec<Vec<f64>> = columns.iter().map(unit).collect();
        let c = real_matrix(m, m, |i, j| columns[j][i]);
        let (values, v) = right_singular_vectors(&c)?;
        if values[m - 1] < MIN_SINGULAR_VALUE_RATIO * values[0] {
            return Ok(None);
        }
        let half = real_matrix(m, m, |i, j| {
            (0..m).map(|k| v[(i, k)] * v[(j, k)] / values[k]).sum()
        });
        Ok(Some(&c * &half))
    }

    fn shapes(&self) -> impl Iterator<Item = (&TargetShapes, &Projection)> {
        let pairs = self.targets.iter().zip(&self.projections);
        pairs.filter_map(|(target, projection)| target.shapes.as_ref().zip(projection.as_ref()))
    }

    /// Number of residuals of frequencies, which come first.
    pub fn frequency_count(&self) -> usize {
        self.contrasts(&vec![0.0; self.targets.len()]).len()
    }

    /// Number of independent residuals: a shape has one less for every mode of the model.
    pub fn independent_count(&self) -> usize {
        let vectors = self.shapes().flat_map(|(shapes, _)| &shapes.vectors);
        let shapes = vectors.map(|v| v.len().saturating_sub(self.members.len()));
        self.frequency_count() + shapes.sum::<usize>()
    }

    /// Smallest MAC of a target's shapes with the modes of the root pair, weighted by the standard
    /// deviations; `None` without shapes.
    pub fn mac(&self, target: usize) -> Option<f64> {
        let shapes = self.targets[target].shapes.as_ref()?;
        let projection = self.projections[target].as_ref()?;
        let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        let mac = |v: &Vec<f64>| 1.0 - square(&projection.residual(v)) / square(v);
        shapes.vectors.iter().map(mac).reduce(f64::min)
    }
}
