//! FRF residuals compare measured FRFs with those of the model, line by line.
//!
//! The model's are `H = s^d b_y Z^-1 b_f^T` with `Z = s^2 M + s C + K`, the observation rows of
//! response and hit, and `s = a + i omega` for an exponential window of rate `a` that the functions
//! still carry. Damping is not updated: `C` is `M Phi diag(2 zeta omega) Phi^T M` of the model
//! where modes alone are brought to the test, with the measured ratios (of a mode that was not
//! measured their mean), and stays. With the motions `X = Z^-1 B^T` the derivatives are `dH = -s^d
//! x_y^T (dK + s^2 dM) x_f`.
//!
//! Complex residuals are `(H - H_t)/sigma` in real and imaginary part, `sigma^2 = (var +
//! (floor |H_t|)^2)/2`; residuals of the logarithm are `ln|H/H_t|/sigma`, `sigma^2 = (var/|H_t|^2 +
//! floor^2)/2`. The floor stands for errors of damping and calibration, which a whole function
//! shares, and counts at every line as if it were independent: where it is more than the variance,
//! posterior deviations are too small.
//!
//! # Reference
//! Lin and Ewins (1990), Proc. IMAC 8, 141 (sensitivity of receptances); Friswell and Mottershead
//! (1995), sections 5.2 and 8.2 (FRF residuals, logarithms).

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::{FrfSet, Function};
use crate::linalg::{
    ComplexMatrix, RealMatrix, complex_matrix, not_a_number, real_matrix, solve_square,
};
use crate::theory::{SystemDerivative, SystemMatrices, TheoryModes};

use super::UpdateError;

/// Smallest power of a function over its variance, 10 dB, at which its logarithm is compared: noise
/// biases the logarithm of a smaller one.
const MIN_POWER_OVER_VARIANCE: f64 = 10.0;

/// The functions of one set that the model's sensors read, at the compared lines.
#[derive(Clone, Debug)]
pub(super) struct FrfTarget {
    /// Index of the test.
    pub test: usize,
    /// `s` of every line.
    lines: Vec<Complex64>,
    /// Observation rows of all responses and hits, one row each.
    rows: RealMatrix,
    functions: Vec<MeasuredFrf>,
    logarithms: bool,
    /// `C`.
    damping: RealMatrix,
}

#[derive(Clone, Debug)]
struct MeasuredFrf {
    /// Rows of response and hit.
    places: (usize, usize),
    sign: f64,
    order: i32,
    values: Vec<Complex64>,
    /// Standard deviation at each line; `None` for a line that is not compared.
    std: Vec<Option<f64>>,
}

/// Selection of functions and lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrfSelection {
    pub band: Option<Band>,
    pub most_lines: usize,
    pub floor: f64,
    pub logarithms: bool,
}

impl FrfTarget {
    /// `None` where no function has both ends at sensors of the model, or no line is compared. FRFs
    /// at reversed sensors are left out.
    ///
    /// # Errors
    /// [`UpdateError::NoVariance`] for a function with both ends at sensors: it is not free of
    /// noise.
    pub fn new(
        test: usize,
        set: &FrfSet,
        sensors: &[(Dof, Vec<f64>)],
        selection: &FrfSelection,
        is_reversed: impl Fn(&Function) -> bool,
    ) -> Result<Option<Self>, UpdateError> {
        let place = |dof: &Dof| {
            sensors
                .iter()
                .position(|(sensor, _)| *sensor == dof.positive())
        };
        let lines = chosen_lines(set, selection);
        let at_sensors = |i: usize| {
            let function = &set.functions()[i];
            if is_reversed(function) {
                return None;
            }
            let places = place(&function.response).zip(place(&function.reference))?;
            Some((i, function, places))
        };
        let target = |(i, function, places): (usize, &Function, (usize, usize))| {
            let variance = set.variance(i).ok_or_else(|| UpdateError::NoVariance {
                response: function.response.to_string(),
                reference: function.reference.to_string(),
            })?;
            let values: Vec<Complex64> = lines.iter().map(|&k| set.values(i)[k]).collect();
            let pairs = lines.iter().zip(&values);
            let std = pairs
                .map(|(&k, h)| selection.std(*h, variance[k]))
                .collect();
            Ok(MeasuredFrf {
                places,
                sign: function.response.sign() * function.reference.sign(),
                order: function.kind.derivative_order(),
                values,
                std,
            })
        };
        let functions = (0..set.len()).filter_map(at_sensors).map(target);
        let mut functions: Vec<MeasuredFrf> = functions.collect::<Result<_, UpdateError>>()?;
        functions.retain(|function| function.std.iter().any(Option::is_some));
        let n = sensors.first().map_or(0, |(_, row)| row.len());
        let s = |&k: &usize| Complex64::new(set.added_damping_rad_s, set.axis().rad_s(k));
        Ok((!functions.is_empty()).then(|| Self {
            test,
            lines: lines.iter().map(s).collect(),
            rows: real_matrix(sensors.len(), n, |i, j| sensors[i].1[j]),
            functions,
            logarithms: selection.logarithms,
            damping: real_matrix(n, n, |_, _| 0.0),
        }))
    }

    /// Sets the damping matrix that gives the modes of the model these ratios.
    pub fn set_damping(&mut self, mass: &RealMatrix, modes: &TheoryModes, ratios: &[f64]) {
        let moved = mass * &modes.vectors;
        let (n, m) = (moved.nrows(), moved.ncols());
        let scaled = real_matrix(n, m, |i, r| {
            2.0 * ratios[r] * modes.omega_rad_s[r] * moved[(i, r)]
        });
        self.damping = &scaled * moved.transpose();
    }

    /// Number of residuals.
    pub fn len(&self) -> usize {
        let parts = if self.logarithms { 1 } else { 2 };
        parts * self.line_count()
    }

    /// Number of functions.
    pub fn function_count(&self) -> usize {
        self.functions.len()
    }

    /// Number of compared lines, of all functions.
    pub fn line_count(&self) -> usize {
        let stds = self.functions.iter().flat_map(|function| &function.std);
        stds.flatten().count()
    }

    /// The residuals, line by line.
    pub fn values(&self, matrices: &SystemMatrices) -> Vec<f64> {
        let of_line = |line: usize| {
            let x = self.displacements(line, matrices);
            let mut all = Vec::new();
            for (function, std) in self.at(line) {
                let h = self.model_frf(function, line, &x);
                all.extend(self.parts(h, function.values[line], std));
            }
            all
        };
        self.each(of_line).into_iter().flatten().collect()
    }

    /// Their derivatives by parameters, one column for each.
    pub fn derivatives(&self, matrices: &SystemMatrices, by: &[SystemDerivative]) -> Vec<Vec<f64>> {
        let of_line = |line: usize| self.derivatives_at(line, matrices, by);
        let lines = self.each(of_line);
        let column = |j: usize| {
            lines
                .iter()
                .flat_map(|by_parameter| by_parameter[j].clone())
                .collect()
        };
        (0..by.len()).map(column).collect()
    }

    fn derivatives_at(
        &self,
        line: usize,
        matrices: &SystemMatrices,
        by: &[SystemDerivative],
    ) -> Vec<Vec<f64>> {
        let x = self.displacements(line, matrices);
        let s = self.lines[line];
        let n = x.nrows();
        let of = |by: &SystemDerivative| {
            let change =
                complex_matrix(n, n, |i, j| by.stiffness[(i, j)] + s * s * by.mass[(i, j)]);
            let loads = &change * &x;
            let mut all = Vec::new();
            for (function, std) in self.at(line) {
                let (response, hit) = function.places;
                let product: Complex64 = (0..n).map(|i| x[(i, response)] * loads[(i, hit)]).sum();
                let slope = -function.sign * s.powi(function.order) * product;
                all.extend(self.slopes(slope, self.model_frf(function, line, &x), std));
            }
            all
        };
        by.iter().map(of).collect()
    }

    /// `Z^-1 B^T` at a line.
    fn displacements(&self, line: usize, matrices: &SystemMatrices) -> ComplexMatrix {
        let s = self.lines[line];
        let n = self.damping.nrows();
        let dynamic = complex_matrix(n, n, |i, j| {
            s * s * matrices.mass[(i, j)] + s * self.damping[(i, j)] + matrices.stiffness[(i, j)]
        });
        let rows = &self.rows;
        let forces = complex_matrix(n, rows.nrows(), |i, j| rows[(j, i)].into());
        // A line at which the model is singular has no residual; the update reports what is not
        // finite.
        solve_square(&dynamic, &forces).unwrap_or_else(|_| not_a_number(n, forces.ncols()))
    }

    /// The model's function at a line.
    fn model_frf(&self, function: &MeasuredFrf, line: usize, x: &ComplexMatrix) -> Complex64 {
        let (response, hit) = function.places;
        let parts = (0..x.nrows()).map(|i| self.rows[(response, i)] * x[(i, hit)]);
        function.sign * self.lines[line].powi(function.order) * parts.sum::<Complex64>()
    }

    /// The functions that are compared at a line.
    fn at(&self, line: usize) -> impl Iterator<Item = (&MeasuredFrf, f64)> {
        let functions = self.functions.iter();
        functions.filter_map(move |function| Some((function, function.std[line]?)))
    }

    fn parts(&self, h: Complex64, measured: Complex64, std: f64) -> Vec<f64> {
        if self.logarithms {
            return vec![(h.norm() / measured.norm()).ln() / std];
        }
        let residual = h - measured;
        vec![residual.re / std, residual.im / std]
    }

    fn slopes(&self, slope: Complex64, h: Complex64, std: f64) -> Vec<f64> {
        if self.logarithms {
            return vec![(slope / h).re / std];
        }
        vec![slope.re / std, slope.im / std]
    }

    /// The result of every line, in their order, in the thread pool of the caller.
    fn each<T: Send>(&self, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        (0..self.lines.len()).into_par_iter().map(of).collect()
    }
}

impl FrfSelection {
    /// Standard deviation of the residuals of a line; `None` for a line that is not compared.
    fn std(&self, h: Complex64, variance: f64) -> Option<f64> {
        let (power, floor) = (h.norm_sqr(), self.floor * self.floor);
        let square = if self.logarithms {
            (power >= MIN_POWER_OVER_VARIANCE * variance).then(|| variance / power + floor)?
        } else {
            variance + floor * power
        };
        let std = (0.5 * square).sqrt();
        (std > 0.0 && std.is_finite()).then_some(std)
    }
}

/// The lines above 0 Hz in the band, evenly thinned to at most `most_lines`.
fn chosen_lines(set: &FrfSet, selection: &FrfSelection) -> Vec<usize> {
    let axis = set.axis();
    let inside = |k: &usize| {
        let hz = axis.hz(*k);
        let bands = [selection.band, set.valid_band];
        hz > 0.0 && bands.iter().flatten().all(|band| band.contains(hz))
    };
    let all: Vec<usize> = (0..axis.len).filter(inside).collect();
    let step = all.len().div_ceil(selection.most_lines.max(1)).max(1);
    all.into_iter().step_by(step).collect()
}
