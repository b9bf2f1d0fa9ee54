//! A projection divides a shape into the part in the span of shapes of the model and the residual.
//!
//! # Reference
//! Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, 413, equation 4.7 (derivative of a
//! projection).

use crate::linalg::RealMatrix;
use crate::theory::TheoryModes;

use super::target_shapes::TargetShapes;

/// Smallest part of a vector, independent of the vectors before it, that adds a direction.
const MIN_INDEPENDENT_PART: f64 = 1e-8;

/// The model's shapes `Phi = Q R` at the sensors; linearly dependent columns are left
/// out.
pub(super) struct Projection {
    q: Vec<Vec<f64>>,
    /// Columns of the upper triangle.
    r: Vec<Vec<f64>>,
    /// The modes that they are, by their index in the root pair.
    pub columns: Vec<usize>,
}

impl Projection {
    /// Of the shapes of modes of the model at the sensors of a target.
    pub fn of_modes(shapes: &TargetShapes, modes: &TheoryModes, nearest: &[usize]) -> Self {
        let (d, n) = (shapes.rows.nrows(), shapes.rows.ncols());
        let column = |&mode: &usize| {
            let reading = |row: usize| -> f64 {
                let parts = (0..n).map(|i| shapes.rows[(row, i)] * modes.vectors[(i, mode)]);
                parts.sum()
            };
            (0..d).map(reading).collect()
        };
        Self::of_columns(nearest.iter().map(column))
    }

    /// Of any columns.
    pub fn of_columns(columns: impl Iterator<Item = Vec<f64>>) -> Self {
        let mut projection = Self {
            q: Vec::new(),
            r: Vec::new(),
            columns: Vec::new(),
        };
        for (k, column) in columns.enumerate() {
            projection.add(k, column);
        }
        projection
    }

    fn add(&mut self, k: usize, vector: Vec<f64>) {
        let length = dot(&vector, &vector).sqrt();
        let mut column = vec![0.0; self.q.len()];
        let mut residual = vector;
        // Twice, so that the rounding of the first pass is removed as well.
        for _ in 0..2 {
            for (q, entry) in self.q.iter().zip(&mut column) {
                let part = dot(q, &residual);
                *entry += part;
                residual.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
            }
        }
        let left = dot(&residual, &residual).sqrt();
        if left > MIN_INDEPENDENT_PART * length {
            column.push(left);
            self.q.push(residual.iter().map(|r| r / left).collect());
            self.r.push(column);
            self.columns.push(k);
        }
    }

    /// `(I - Q Q^T) v`.
    pub fn residual(&self, v: &[f64]) -> Vec<f64> {
        let mut residual = v.to_vec();
        for q in &self.q {
            let part = dot(q, &residual);
            residual.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
        }
        residual
    }

    /// `R^-1 Q^T v`.
    pub fn coefficients(&self, v: &[f64]) -> Vec<f64> {
        let mut c: Vec<f64> = self.q.iter().map(|q| dot(q, v)).collect();
        for k in (0..c.len()).rev() {
            c[k] /= self.r[k][k];
            for i in 0..k {
                c[i] -= self.r[k][i] * c[k];
            }
        }
        c
    }

    /// `-(I - Q Q^T) dPhi c - Q R^-T dPhi^T r` with `c = R^-1 Q^T v` and `r` the residual of `v`.
    pub fn derivative(&self, v: &[f64], change: &RealMatrix) -> Vec<f64> {
        let m = self.q.len();
        let (residual, d) = (self.residual(v), v.len());
        let c = self.coefficients(v);
        let column = |row: usize, k: usize| change[(row, self.columns[k])];
        let moved: Vec<f64> = (0..d)
            .map(|row| (0..m).map(|k| column(row, k) * c[k]).sum())
            .collect();
        let mut y: Vec<f64> = (0..m)
            .map(|k| (0..d).map(|row| column(row, k) * residual[row]).sum())
            .collect();
        for k in 0..m {
            for i in 0..k {
                y[k] -= self.r[k][i] * y[i];
            }
            y[k] /= self.r[k][k];
        }
        let mut result: Vec<f64> = self.residual(&moved).iter().map(|x| -x).collect();
        for (q, y) in self.q.iter().zip(&y) {
            result.iter_mut().zip(q).for_each(|(r, q)| *r -= q * y);
        }
        result
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
