//! Poles and out-of-band terms predict the FRFs on all lines of a band, with the residual as data
//! minus prediction; the common out-of-band terms are found by singular value decomposition.

use std::borrow::Cow;
use std::ops::Range;

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, RowProduct, ThinQr};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::chebyshev::Chebyshev;
use crate::identify::data::line_noise::LineNoise;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::{
    MIN_OUT_OF_BAND_COLUMNS, OutOfBandBasis, OutOfBandTerm, OutOfBandTerms,
};

/// Length of the segments of a prediction, lines. Larger: more poles are near a segment, and are
/// computed on each of its lines. Smaller: there are more segments, each with all polynomials. The
/// prediction does not depend on it.
const SEGMENT_LINES: usize = 256;
/// Distance from the middle of a segment, in half-lengths, from which polynomials represent the
/// response of a pole, and their number: the error is below `1/T_18(3)`, 3e-14 of the response.
///
/// Larger: the prediction takes longer. Smaller: the error grows, to 1e-9 of the response by the
/// bound for 12 polynomials, which no test notices yet.
const POLYNOMIAL_DISTANCE: f64 = 3.0;
const POLYNOMIALS: usize = 18;

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
    /// Coordinates of smooth functions on the segments of the band.
    smooth: Vec<SmoothCoordinates>,
}

/// Coordinates of functions that are polynomials on a segment of the band.
struct SmoothCoordinates {
    segment: Segment,
    /// Frequencies of the nodes, rad/s.
    nodes: Vec<f64>,
    /// Weights of the values at the nodes: columns × nodes.
    weights: ComplexMatrix,
}

/// Lines of a segment with their middle and half length, rad/s.
struct Segment {
    lines: Range<usize>,
    middle: f64,
    half_length: f64,
}

impl Segment {
    fn new(omega: &[f64], lines: Range<usize>) -> Self {
        let (first, last) = (omega[lines.start], omega[lines.end - 1]);
        Self {
            lines,
            middle: 0.5 * (first + last),
            half_length: 0.5 * (last - first),
        }
    }

    /// Segments of a range of lines.
    fn all(omega: &[f64], lines: &Range<usize>) -> Vec<Self> {
        let count = lines.len().div_ceil(SEGMENT_LINES).max(1);
        let edge = |n: usize| lines.start + n * lines.len() / count;
        let segment = |n: usize| Self::new(omega, edge(n)..edge(n + 1));
        (0..count).map(segment).collect()
    }

    /// Numbers of the poles whose response polynomials do not represent, and of the others.
    fn near_and_far(&self, lambdas: &[Complex64]) -> (Vec<usize>, Vec<usize>) {
        let is_near = |pole: &usize| {
            let distance = (lambdas[*pole] - Complex64::new(0.0, self.middle)).norm();
            distance < POLYNOMIAL_DISTANCE * self.half_length
        };
        (0..lambdas.len()).partition(is_near)
    }

    fn chebyshev(&self) -> Chebyshev {
        Chebyshev::new(self.middle, self.half_length, POLYNOMIALS)
    }
}

impl SmoothCoordinates {
    /// Coordinates by the weights of the lines, lines × columns.
    fn new(omega: &[f64], segment: Segment, weights: &ComplexMatrix) -> Self {
        let chebyshev = segment.chebyshev();
        let angles = chebyshev.angles(&omega[segment.lines.clone()]);
        let polynomials = linalg::complex_matrix(angles.len(), POLYNOMIALS, |k, n| {
            Chebyshev::value(n, angles[k])
        });
        let weights = weights.subrows(segment.lines.start, segment.lines.len());
        Self {
            nodes: chebyshev.nodes(),
            weights: weights.adjoint() * polynomials * chebyshev.coefficients(),
            segment,
        }
    }

    /// Coordinates of the response of poles on the segment: columns × poles.
    fn of_poles(&self, fit: &OutOfBandFit, lambdas: &[Complex64]) -> ComplexMatrix {
        let (near, far) = self.segment.near_and_far(lambdas);
        let lambdas_of =
            |poles: &[usize]| -> Vec<Complex64> { poles.iter().map(|j| lambdas[*j]).collect() };
        let lines = &self.segment.lines;
        let omega = &fit.omega[lines.clone()];
        let weights = fit.weights.subrows(lines.start, lines.len());
        let of_near = weights.adjoint() * columns_at(fit.line_shape, omega, &lambdas_of(&near));
        let of_far = &self.weights * columns_at(fit.line_shape, &self.nodes, &lambdas_of(&far));
        let mut coordinates = ComplexMatrix::zeros(self.weights.nrows(), lambdas.len());
        for (poles, part) in [(&near, of_near), (&far, of_far)] {
            for (c, pole) in poles.iter().enumerate() {
                coordinates.col_mut(*pole).copy_from(part.col(c));
            }
        }
        coordinates
    }
}

/// Residual on a range of lines: data minus model, over the standard deviation of the noise.
///
/// The difference is formed in double precision and held in single, in half the memory of the FRFs:
/// it has 6e-8 of the residual as rounding.
pub(in crate::identify) struct Residual {
    /// The range of lines.
    pub lines: Range<usize>,
    /// By FRF.
    values: Vec<Vec<Complex32>>,
}

impl Residual {
    /// Residual of lines × FRFs, from the first line.
    pub fn of_all(values: &ComplexMatrix) -> Self {
        let column = |f: usize| values.col_as_slice(f).iter().map(single).collect();
        Self {
            lines: 0..values.nrows(),
            values: (0..values.ncols()).map(column).collect(),
        }
    }

    /// Number of FRFs.
    pub fn functions(&self) -> usize {
        self.values.len()
    }

    /// Residual of an FRF at a line.
    #[inline]
    pub fn at(&self, function: usize, line: usize) -> Complex64 {
        double(&self.values[function][line - self.lines.start])
    }

    /// Residual of an FRF on a range of lines.
    pub fn of(
        &self,
        function: usize,
        lines: Range<usize>,
    ) -> impl ExactSizeIterator<Item = Complex64> {
        let start = lines.start - self.lines.start;
        let values = &self.values[function][start..start + lines.len()];
        values.iter().map(double)
    }

    /// Rescales the residual from the noise of each FRF before to that now.
    pub fn rescale(&mut self, before: &[LineNoise], now: &[LineNoise]) {
        let lines = self.lines.clone();
        let columns = self.values.par_iter_mut().enumerate();
        columns.for_each(|(f, column)| {
            let (before, now) = (before[f].stds(lines.clone()), now[f].stds(lines.clone()));
            for (value, (before, now)) in column.iter_mut().zip(before.zip(now)) {
                *value = single(&(double(value) * (before / now)));
            }
        });
    }

    /// `Σ|r|²` of the residual r.
    pub fn energy(&self) -> f64 {
        let energy = |column: &Vec<Complex32>| -> f64 {
            column.iter().map(|value| double(value).norm_sqr()).sum()
        };
        let energies: Vec<f64> = self.values.par_iter().map(energy).collect();
        energies.iter().sum()
    }

    /// Mean square of the residual.
    pub fn mean_power(&self) -> f64 {
        self.energy() / (self.lines.len() * self.values.len()) as f64
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
        let segments = match frfs.line_shape.is_smoothed() {
            // Between the lines a smoothed pole is no polynomial.
            true => Vec::new(),
            false => Segment::all(&frfs.omega, &(0..frfs.lines())),
        };
        let smooth = segments.into_par_iter();
        let smooth = smooth.map(|segment| SmoothCoordinates::new(&frfs.omega, segment, &weights));
        Self {
            smooth: smooth.collect(),
            omega: frfs.omega.clone(),
            line_shape: frfs.line_shape,
            coordinates: frfs.values.adjoint_product(&weights, 0..frfs.lines()),
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
        let pole_coordinates = self.pole_coordinates(&with_conjugates(roots));
        &self.coordinates - pole_coordinates * residues(roots, self.level.len())
    }

    /// Coordinates of the response of poles: columns × poles.
    fn pole_coordinates(&self, lambdas: &[Complex64]) -> ComplexMatrix {
        if self.smooth.is_empty() {
            return self.weights.adjoint() * columns_at(self.line_shape, &self.omega, lambdas);
        }
        let parts = self.smooth.par_iter();
        let parts: Vec<ComplexMatrix> = parts.map(|part| part.of_poles(self, lambdas)).collect();
        let mut sum = ComplexMatrix::zeros(self.weights.ncols(), lambdas.len());
        for part in parts {
            sum += part;
        }
        sum
    }

    /// Prediction of the lines by poles and out-of-band terms, with the noise of each FRF.
    pub fn predict<'a>(
        &'a self,
        frfs: &'a BandFrfs,
        noise: &'a [LineNoise],
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
            noise,
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
    noise: &'a [LineNoise],
    poles: &'a [ModelPole],
    /// Amplitudes of out-of-band terms, poles and conjugates: columns × FRFs.
    amplitudes: ComplexMatrix,
}

impl PredictedResponse<'_> {
    /// Residual on a range of lines, over the noise at each.
    pub fn residual(&self, lines: Range<usize>) -> Residual {
        let segments = Segment::all(&self.out_of_band.omega, &lines).into_par_iter();
        let segments: Vec<RowProduct> = segments.map(|segment| self.segment(segment)).collect();
        let over_noise =
            |f: usize, lines: Range<usize>, rest: &[Complex64], all: &mut Vec<Complex32>| {
                let values = rest.iter().zip(self.noise[f].stds(lines));
                all.extend(values.map(|(value, std)| single(&(value * std.recip()))));
            };
        Residual {
            values: self.frfs.values.subtract_products(&segments, over_noise),
            lines,
        }
    }

    /// Prediction of the lines of a segment, with polynomials for all columns that are smooth
    /// there, where that takes fewer operations: poles far from the segment, and out-of-band terms
    /// unless the data end near it.
    fn segment(&self, segment: Segment) -> RowProduct<'_> {
        let fit = self.out_of_band;
        let lines = segment.lines.clone();
        let omega = &fit.omega[lines.clone()];
        let lambdas = with_conjugates(self.poles);
        let (near, far) = segment.near_and_far(&lambdas);
        let terms = fit.columns.ncols();
        let is_at_end = lines.start < lines.len() || fit.omega.len() - lines.end < lines.len();
        let smooth = far.len() + if is_at_end { 0 } else { terms };
        let is_shorter = POLYNOMIALS * (lines.len() + smooth + POLYNOMIALS) < smooth * lines.len();
        if !is_shorter || fit.line_shape.is_smoothed() {
            let poles = columns_at(fit.line_shape, omega, &lambdas);
            let column = |k: usize, c: usize| match c.checked_sub(terms) {
                None => fit.columns[(lines.start + k, c)],
                Some(c) => poles[(k, c)],
            };
            return RowProduct {
                a: linalg::complex_matrix(lines.len(), terms + lambdas.len(), column),
                c: Cow::Borrowed(&self.amplitudes),
                rows: lines,
            };
        }
        let chebyshev = segment.chebyshev();
        let angles = chebyshev.angles(omega);
        let polynomials = linalg::complex_matrix(lines.len(), POLYNOMIALS, |k, n| {
            Chebyshev::value(n, angles[k])
        });
        let qr = ThinQr::or_not_a_number(&polynomials);
        let lambdas_of =
            |poles: &[usize]| -> Vec<Complex64> { poles.iter().map(|j| lambdas[*j]).collect() };
        let functions = self.amplitudes.ncols();
        let of_far = linalg::complex_matrix(far.len(), functions, |j, f| {
            self.amplitudes[(terms + far[j], f)]
        });
        let at_nodes = columns_at(fit.line_shape, &chebyshev.nodes(), &lambdas_of(&far));
        let coefficients = qr.r.subcols(0, POLYNOMIALS) * chebyshev.coefficients();
        let mut of_smooth = coefficients * (at_nodes * of_far);
        let mut explicit = Vec::new();
        if is_at_end {
            explicit.extend(0..terms);
        } else {
            let columns = fit.columns.subrows(lines.start, lines.len());
            let columns = qr.q.adjoint() * columns;
            of_smooth += columns * self.amplitudes.subrows(0, terms);
        }
        let terms_at_end = explicit.len();
        explicit.extend(near.iter().map(|pole| terms + pole));
        let of_near = columns_at(fit.line_shape, omega, &lambdas_of(&near));
        let column = |k: usize, c: usize| match c.checked_sub(explicit.len()) {
            Some(polynomial) => qr.q[(k, polynomial)],
            None if c < terms_at_end => fit.columns[(lines.start + k, c)],
            None => of_near[(k, c - terms_at_end)],
        };
        let columns = explicit.len() + POLYNOMIALS;
        let amplitude = |c: usize, f: usize| match c.checked_sub(explicit.len()) {
            Some(polynomial) => of_smooth[(polynomial, f)],
            None => self.amplitudes[(explicit[c], f)],
        };
        RowProduct {
            a: linalg::complex_matrix(lines.len(), columns, column),
            c: Cow::Owned(linalg::complex_matrix(columns, functions, amplitude)),
            rows: lines,
        }
    }
}

fn single(value: &Complex64) -> Complex32 {
    Complex32::new(value.re as f32, value.im as f32)
}

fn double(value: &Complex32) -> Complex64 {
    Complex64::new(value.re.into(), value.im.into())
}

/// Every pole and its conjugate.
fn with_conjugates(roots: &[ModelPole]) -> Vec<Complex64> {
    let pairs = roots.iter().map(|root| [root.lambda, root.lambda.conj()]);
    pairs.flatten().collect()
}

/// `1/(iω − λ)`: frequencies × poles.
fn columns_at(line_shape: LineShape, omega: &[f64], lambdas: &[Complex64]) -> ComplexMatrix {
    let mut columns = ComplexMatrix::zeros(omega.len(), lambdas.len());
    linalg::for_each_column(&mut columns, |column, values| {
        line_shape.fill_pole(omega, lambdas[column], values);
    });
    columns
}

/// `1/(iω − λ)` of every pole and of its conjugate: lines × twice the number of poles.
pub(in crate::identify) fn pole_columns(
    line_shape: LineShape,
    omega: &[f64],
    roots: &[ModelPole],
) -> ComplexMatrix {
    columns_at(line_shape, omega, &with_conjugates(roots))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    const SENSORS: usize = 5;

    /// Fifteen modes in 2000 lines, most of them far from each segment.
    fn measured() -> (BandFrfs, Vec<ModelPole>) {
        let shape = |j: usize| -> Vec<f64> {
            let at = |p: usize| (0.3 + 0.7 * (j * SENSORS + p) as f64).cos();
            (0..SENSORS).map(at).collect()
        };
        let hz = |j: usize| 82.0 + 2.5 * j as f64;
        let structure = Structure {
            modes: (0..15).map(|j| (hz(j), 0.002, shape(j))).collect(),
        };
        let axis = FrequencyAxis {
            start_hz: 80.0,
            step_hz: 0.02,
            len: 2000,
        };
        let set = structure.measured(&Measurement::of_sensors(SENSORS, axis));
        let frfs = BandFrfs::new(&set, Band::new(80.0, 119.98).unwrap()).unwrap();
        let pole = |j: usize| {
            let lambda = Pole::from_frequency(hz(j), 0.002).lambda;
            let mut pole = ModelPole::single(lambda, &[Complex64::ONE], SENSORS);
            let residue = |v: &f64| Complex64::new(0.1 * v, v - 0.5);
            pole.residues = shape(j).iter().map(residue).collect();
            pole
        };
        (frfs, (0..15).map(pole).collect())
    }

    fn out_of_band_fit(frfs: &BandFrfs) -> OutOfBandFit {
        let terms = OutOfBandTerms::BasisFunctions(Vec::new());
        let profile: Vec<f64> = (0..frfs.lines()).map(|k| 1.0 + 1e-4 * k as f64).collect();
        OutOfBandFit::new(frfs, &terms, vec![1.0; SENSORS], &profile)
    }

    #[test]
    fn coordinates_of_poles_by_nodes_are_those_of_the_lines() {
        let (frfs, poles) = measured();
        let fit = out_of_band_fit(&frfs);
        let lambdas = with_conjugates(&poles);
        let on_lines = fit.weights.adjoint() * columns_at(fit.line_shape, &fit.omega, &lambdas);
        let difference = fit.pole_coordinates(&lambdas) - &on_lines;
        assert!(fit.smooth.len() > 4 && on_lines.norm_l2() > 0.0);
        let limit = 1e-11 * on_lines.norm_l2();
        assert!(difference.norm_l2() < limit, "{}", difference.norm_l2());
    }

    #[test]
    fn far_poles_are_predicted_as_on_the_lines() {
        let (frfs, poles) = measured();
        let fit = out_of_band_fit(&frfs);
        let largest = (0..frfs.lines()).map(|k| frfs.values.at(0, k).norm());
        let std = 1e-9 * largest.fold(0.0, f64::max);
        let lines = frfs.lines();
        let noise = LineNoise::new(&vec![std * std; lines], &vec![0.0; lines]);
        let noise = vec![noise; SENSORS];
        let mut poles = poles;
        let scale = 1e9 * std;
        for residue in poles.iter_mut().flat_map(|pole| &mut pole.residues) {
            *residue *= scale;
        }
        let described = fit.predict(&frfs, &noise, &poles);
        let all = described.residual(0..lines);
        for k in (0..lines).step_by(7) {
            // Of one line no polynomial is worth it.
            let alone = described.residual(k..k + 1);
            for f in 0..SENSORS {
                let difference = (all.at(f, k) - alone.at(f, k)).norm();
                let limit = 3e-3 + 1e-6 * alone.at(f, k).norm();
                assert!(difference < limit, "{k} {f}: {difference} of {limit}");
            }
        }
    }
}
