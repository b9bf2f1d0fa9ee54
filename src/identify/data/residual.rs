//! Poles and out-of-band terms predict the FRFs on all lines of a band, with the residual as data
//! minus prediction; the common out-of-band terms are found by singular value decomposition.

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::{
    MIN_OUT_OF_BAND_COLUMNS, OutOfBandBasis, OutOfBandTerm, OutOfBandTerms,
};

/// Basis of the out-of-band terms over all lines of the band.
///
/// A fit of a few lines in the middle of the band has only constant and slope for out-of-band
/// modes; over a long band the contribution of a strong mode beyond its end is curved, which only
/// all lines together determine.
pub(in crate::identify) struct OutOfBandFit {
    omega: Vec<f64>,
    line_shape: LineShape,
    level: Vec<f64>,
    /// Columns of the basis times the noise profile, and the weights that yield the coordinates:
    /// lines × columns.
    columns: ComplexMatrix,
    weights: ComplexMatrix,
    /// Coordinates of the measured values: columns × FRFs.
    coordinates: ComplexMatrix,
}

/// Residual on a range of lines: data minus model, over the standard deviation of the noise.
pub(in crate::identify) struct Residual {
    /// The range of lines.
    pub lines: Range<usize>,
    /// Lines × FRFs.
    pub values: ComplexMatrix,
}

impl Residual {
    /// Residual of lines × FRFs, from the first line.
    #[cfg(test)]
    pub fn of_all(values: ComplexMatrix) -> Self {
        Self {
            lines: 0..values.nrows(),
            values,
        }
    }

    /// Residual of an FRF at a line.
    pub fn at(&self, function: usize, line: usize) -> Complex64 {
        self.values[(line - self.lines.start, function)]
    }

    /// Residual of an FRF on a range of lines.
    pub fn of(&self, function: usize, lines: Range<usize>) -> &[Complex64] {
        let start = lines.start - self.lines.start;
        &self.values.col_as_slice(function)[start..start + lines.len()]
    }

    /// Rescales the residual from one set of noise variances, by FRF and line, to another.
    pub fn rescale(&mut self, before: &[Vec<f64>], now: &[Vec<f64>]) {
        let lines = self.lines.clone();
        linalg::for_each_column(&mut self.values, |f, column| {
            let variances = before[f][lines.clone()].iter().zip(&now[f][lines.clone()]);
            for (value, (before, now)) in column.iter_mut().zip(variances) {
                *value *= (before / now).sqrt();
            }
        });
    }

    /// `Σ|r|²` of the residual r.
    pub fn energy(&self) -> f64 {
        self.values.squared_norm_l2()
    }

    /// Mean square of the residual.
    pub fn mean_power(&self) -> f64 {
        self.energy() / (self.values.nrows() * self.values.ncols()) as f64
    }
}

impl OutOfBandFit {
    /// Fit of the terms to all lines of a band, weighted by the noise: its level by FRF and its
    /// profile over the lines.
    pub fn new(
        frfs: &BandFrfs,
        terms: &OutOfBandTerms,
        level: Vec<f64>,
        noise_profile: &[f64],
    ) -> Self {
        let terms = OutOfBandBasis::new(&frfs.omega, &(0..frfs.lines()), terms);
        // Orthonormal after division by the noise profile.
        let basis = terms.basis(&frfs.omega, noise_profile);
        let of = |scale: &dyn Fn(usize) -> f64| {
            linalg::complex_matrix(basis.nrows(), basis.ncols(), |k, c| {
                basis[(k, c)] * scale(k)
            })
        };
        let weights = of(&|k| noise_profile[k].recip());
        Self {
            omega: frfs.omega.clone(),
            line_shape: frfs.line_shape,
            coordinates: linalg::adjoint_product(&weights, frfs.values.matrix().as_ref()),
            columns: of(&|k| noise_profile[k]),
            weights,
            level,
        }
    }

    /// The columns of the basis: lines × columns.
    pub fn columns(&self) -> &ComplexMatrix {
        &self.columns
    }

    /// Coordinates of the residual of the poles: columns × FRFs.
    pub fn residual_coordinates(&self, roots: &[ModelPole]) -> ComplexMatrix {
        let poles = pole_columns(self.line_shape, &self.omega, roots);
        let pole_coordinates = self.weights.adjoint() * poles;
        &self.coordinates - pole_coordinates * residues(roots, self.level.len())
    }

    /// Prediction of the lines by poles and out-of-band terms; `variance` is that of the noise, by
    /// FRF and line.
    pub fn predict<'a>(
        &'a self,
        frfs: &'a BandFrfs,
        variance: &'a [Vec<f64>],
        roots: &'a [ModelPole],
    ) -> PredictedResponse<'a> {
        let (coordinates, residues) = (
            self.residual_coordinates(roots),
            residues(roots, self.level.len()),
        );
        let first = self.columns.ncols();
        let rows = first + residues.nrows();
        let amplitudes = linalg::complex_matrix(rows, self.level.len(), |c, f| {
            if c < first {
                coordinates[(c, f)]
            } else {
                residues[(c - first, f)]
            }
        });
        PredictedResponse {
            out_of_band: self,
            frfs,
            variance,
            poles: roots,
            amplitudes,
        }
    }

    /// Coordinates of the residual of the poles, over the noise, without constant and slope:
    /// columns × FRFs.
    fn whitened_coordinates(&self, roots: &[ModelPole]) -> ComplexMatrix {
        let coordinates = self.residual_coordinates(roots);
        let columns = coordinates.nrows() - MIN_OUT_OF_BAND_COLUMNS;
        linalg::complex_matrix(columns, coordinates.ncols(), |c, f| {
            coordinates[(MIN_OUT_OF_BAND_COLUMNS + c, f)] / self.level[f]
        })
    }

    /// Out-of-band terms of the residual of the poles beyond constant and slope, the strongest
    /// first: as many as reduce the residual to noise, of which `lines_per_effective_line` lines
    /// have the information of one, and at most `max_terms`.
    ///
    /// The coordinates over the noise, a matrix of columns × FRFs, are noise of unit variance plus
    /// one rank-one term per mode; after r terms (columns − r)(FRFs − r) numbers remain (reduced
    /// rank: Anderson 1951, Annals of Mathematical Statistics 22).
    pub fn strongest(
        &self,
        roots: &[ModelPole],
        lines_per_effective_line: f64,
        max_terms: usize,
    ) -> Vec<OutOfBandTerm> {
        let beyond = self.whitened_coordinates(roots);
        let Ok(svd) = linalg::singular_vectors(&beyond) else {
            return Vec::new();
        };
        let remaining = |rank: usize| svd.values[rank..].iter().map(|s| s * s).sum::<f64>();
        let noise = |rank: usize| {
            let numbers = ((beyond.nrows() - rank) * (beyond.ncols() - rank)) as f64;
            lines_per_effective_line * (numbers + numbers.sqrt())
        };
        let all = svd.values.len();
        let needed = (0..all).find(|rank| remaining(*rank) <= noise(*rank));
        let count = needed.unwrap_or(all).min(max_terms);
        let term = |rank: usize| {
            let at = |k: usize| -> Complex64 {
                let terms = (0..beyond.nrows())
                    .map(|c| self.columns[(k, MIN_OUT_OF_BAND_COLUMNS + c)] * svd.left[(c, rank)]);
                terms.sum()
            };
            let frf_amplitudes = (0..beyond.ncols()).map(|f| svd.right[(f, rank)].conj());
            OutOfBandTerm {
                values: (0..self.columns.nrows()).map(at).collect(),
                frf_amplitudes: frf_amplitudes.collect(),
            }
        };
        (0..count).map(term).collect()
    }

    /// Energy of the residual of the poles that the out-of-band terms explain beyond constant and
    /// slope, over the noise, with its number of complex values.
    pub fn explained(&self, roots: &[ModelPole]) -> (f64, usize) {
        let beyond = self.whitened_coordinates(roots);
        (beyond.squared_norm_l2(), beyond.nrows() * beyond.ncols())
    }
}

/// Prediction of the FRFs by poles and out-of-band terms.
pub(in crate::identify) struct PredictedResponse<'a> {
    out_of_band: &'a OutOfBandFit,
    frfs: &'a BandFrfs,
    variance: &'a [Vec<f64>],
    poles: &'a [ModelPole],
    /// Amplitudes of out-of-band terms, poles and conjugates: columns × FRFs.
    amplitudes: ComplexMatrix,
}

impl PredictedResponse<'_> {
    /// Residual on a range of lines, over the noise at each.
    pub fn residual(&self, lines: Range<usize>) -> Residual {
        let first = self.out_of_band.columns.ncols();
        let of_poles = pole_columns(
            self.out_of_band.line_shape,
            &self.out_of_band.omega[lines.clone()],
            self.poles,
        );
        let columns = linalg::complex_matrix(lines.len(), self.amplitudes.nrows(), |k, c| {
            if c < first {
                self.out_of_band.columns[(lines.start + k, c)]
            } else {
                of_poles[(k, c - first)]
            }
        });
        let over_noise = |f: usize, column: &mut [Complex64]| {
            let variance = &self.variance[f][lines.clone()];
            for (value, variance) in column.iter_mut().zip(variance) {
                *value /= variance.sqrt();
            }
        };
        let measured = self.frfs.values.matrix();
        let measured = measured.subrows(lines.start, lines.len());
        let values = linalg::subtract_product(measured, &columns, &self.amplitudes, over_noise);
        Residual { lines, values }
    }
}

/// `1/(iω − λ)` of every pole and of its conjugate: lines × twice the number of poles.
pub(in crate::identify) fn pole_columns(
    line_shape: LineShape,
    omega: &[f64],
    roots: &[ModelPole],
) -> ComplexMatrix {
    let mut columns = ComplexMatrix::zeros(omega.len(), 2 * roots.len());
    linalg::for_each_column(&mut columns, |column, values| {
        let lambda = roots[column / 2].lambda;
        let lambda = if column % 2 == 0 {
            lambda
        } else {
            lambda.conj()
        };
        line_shape.fill_pole(omega, lambda, values);
    });
    columns
}

/// Residues of every pole and of its conjugate: twice the number of poles × FRFs.
pub(in crate::identify) fn residues(roots: &[ModelPole], functions: usize) -> ComplexMatrix {
    linalg::complex_matrix(2 * roots.len(), functions, |row, f| {
        let residue = roots[row / 2].residues[f];
        if row % 2 == 0 {
            residue
        } else {
            residue.conj()
        }
    })
}
