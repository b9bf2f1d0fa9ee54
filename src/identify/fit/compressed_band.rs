//! Compressed band: the values of all FRFs on a range of lines, projected on the few functions of
//! frequency that represent poles and out-of-band terms there.
//!
//! The columns of a fit are out-of-band terms, `g_j = σ_j/(iω − λ_j)` and, for free poles, `g_j²`.
//! The range is cut into segments. On the lines of one, a pole near it has three powers at an
//! expansion point, and all others are polynomials ([`band_segment`]): a step of a fit reads no
//! line, and the values on a segment are read anew only where a pole near it has moved too far from
//! its expansion point. Conjugates and the poles of other blocks have coordinates as well, which
//! are subtracted from those of the values.
//!
//! [`band_segment`]: crate::identify::fit::band_segment

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, ComplexView, StackedPart, ThinQr};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::{MIN_OUT_OF_BAND_COLUMNS, OutOfBandBasis};
use crate::identify::fit::band_segment::{
    Demand, POWERS, PoleColumn, REACH, Segment, middle, polynomials,
};
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::variable_projection::Compressed;
use crate::identify::noise::band_profile::BandProfile;

/// Minimum and maximum distance of a pole from its expansion point, decay rates: the third power of
/// the distance is the truncation error of the line shape, for the minimum a rounding error.
const EXPANSION_DECAY_RATES: [f64; 2] = [3e-5, 1e-2];
/// Truncation error of the strongest response at that distance, over the noise of one value.
const MAX_TRUNCATION_OVER_NOISE: f64 = 1e-3;
/// Error of the polynomials for the strongest response, over the noise of one value. At 1e-3, what
/// a wide pole beyond the data explains, which hardly differs from the out-of-band terms, is wrong
/// by 2e-5 of the energy (`segments_explain_the_same_energy_as_the_lines`).
const MAX_POLYNOMIAL_ERROR_OVER_NOISE: f64 = 1e-6;
/// Maximum difference of the ends of two bands with the same lines, over their length.
const MAX_END_DIFFERENCE: f64 = 1.0 / 32.0;
/// Minimum length of a segment, lines.
const MIN_SEGMENT_LINES: usize = 48;
/// Fits and steps that read a compressed band, and segments that are renewed once meanwhile, on
/// average over an identification from 900 FRFs. They decide the number of segments, and with it
/// the time alone: `segments_explain_the_same_energy_as_the_lines`.
const FITS_PER_BAND: usize = 8;
const STEPS_PER_BAND: usize = 14;
const RENEWED_SEGMENTS: usize = 3;

/// A compressed band.
pub(in crate::identify) struct CompressedBand {
    lines: Range<usize>,
    profile: BandProfile,
    line_shape: LineShape,
    /// Out-of-band terms on the lines: lines × terms.
    out_of_band_terms: ComplexMatrix,
    /// Maximum |ε| of a pole near a segment, and number of polynomials.
    max_expansion_distance: f64,
    polynomials: usize,
    segments: Vec<Segment>,
    /// Version of the data that they were computed from.
    version: u64,
}

/// Amplitudes of all poles, of their conjugates and of the out-of-band terms of all lines, of which
/// a block subtracts those that it does not fit.
pub(in crate::identify) struct KnownResponse {
    /// Every pole, then every conjugate.
    lambdas: Vec<Complex64>,
    /// Poles, conjugates and out-of-band terms × FRFs.
    amplitudes: ComplexMatrix,
}

impl KnownResponse {
    /// Response of poles with their residues, and of out-of-band terms where their coordinates are
    /// given.
    pub fn new(poles: &[ModelPole], functions: usize, out_of_band: Option<&ComplexMatrix>) -> Self {
        let (count, terms) = (poles.len(), out_of_band.map_or(0, ComplexMatrix::nrows));
        let mut amplitudes = ComplexMatrix::zeros(2 * count + terms, functions);
        linalg::for_each_column(&mut amplitudes, |f, column| {
            let (direct, others) = column.split_at_mut(count);
            let (mirrored, of_terms) = others.split_at_mut(count);
            for ((value, conjugate), pole) in direct.iter_mut().zip(mirrored).zip(poles) {
                *value = pole.residues[f];
                *conjugate = pole.residues[f].conj();
            }
            if let Some(terms) = out_of_band {
                of_terms.copy_from_slice(terms.col_as_slice(f));
            }
        });
        let direct = poles.iter().map(|pole| pole.lambda);
        let mirrored = poles.iter().map(|pole| pole.lambda.conj());
        Self {
            lambdas: direct.chain(mirrored).collect(),
            amplitudes,
        }
    }
}

/// Coordinates of the values minus the contribution of other poles and out-of-band terms.
pub(in crate::identify) struct CompressedValues {
    /// Coordinates × FRFs.
    values: ComplexMatrix,
    /// Energy over the noise, that outside the coordinates included.
    pub energy: f64,
}

impl CompressedBand {
    /// Compresses a range of lines for poles, conjugates included, of which `members` are fitted
    /// there.
    pub fn new(data: &FitData, lines: &Range<usize>, poles: &[Complex64], members: usize) -> Self {
        let profile = BandProfile::new(&data.noise, lines.clone());
        let omega = &data.frfs.omega[lines.clone()];
        let terms = OutOfBandBasis::new(&data.frfs.omega, lines, data.out_of_band_terms());
        let out_of_band_terms = linalg::complex_matrix(omega.len(), terms.columns(), |k, c| {
            terms.value(c, omega, k)
        });
        let over_noise = response_over_noise(&data.frfs, lines, &profile);
        let [minimum, maximum] = EXPANSION_DECAY_RATES;
        let mut band = Self {
            lines: lines.clone(),
            line_shape: data.frfs.line_shape,
            out_of_band_terms,
            max_expansion_distance: (MAX_TRUNCATION_OVER_NOISE / over_noise)
                .cbrt()
                .clamp(minimum, maximum),
            polynomials: polynomials(MAX_POLYNOMIAL_ERROR_OVER_NOISE, over_noise),
            segments: Vec::new(),
            version: data.version(),
            profile,
        };
        let ranges = band.cheapest_ranges(data, poles, members);
        band.set_segments(data, poles, ranges);
        band
    }

    fn set_segments(&mut self, data: &FitData, poles: &[Complex64], ranges: Vec<Range<usize>>) {
        let new = |range: Range<usize>| {
            let demand = self.demand(data, &range, poles);
            Segment::new(data, &self.profile, self.lines.start, range, &demand)
        };
        self.segments = ranges.into_par_iter().map(new).collect();
    }

    /// The same band in a number of segments.
    #[cfg(test)]
    pub fn in_segments(mut self, data: &FitData, poles: &[Complex64], count: usize) -> Self {
        let ranges = equal_ranges(&self.lines, count);
        self.set_segments(data, poles, ranges);
        self
    }

    pub fn lines(&self) -> &Range<usize> {
        &self.lines
    }

    pub fn profile(&self) -> &BandProfile {
        &self.profile
    }

    /// Number of columns of the out-of-band terms.
    pub fn out_of_band_columns(&self) -> usize {
        self.out_of_band_terms.ncols()
    }

    /// Whether the data are unchanged since.
    pub fn is_of(&self, data: &FitData) -> bool {
        self.version == data.version()
    }

    /// Whether its lines are nearly the given ones; both or neither must end with all `all` lines.
    pub fn covers(&self, lines: &Range<usize>, all: usize) -> bool {
        let tolerance = MAX_END_DIFFERENCE * lines.len() as f64;
        let near = |a: usize, b: usize| a.abs_diff(b) as f64 <= tolerance;
        let ends = |range: &Range<usize>| (range.start == 0, range.end == all);
        let same = near(self.lines.start, lines.start) && near(self.lines.end, lines.end);
        same && ends(&self.lines) == ends(lines)
    }

    /// Compresses those segments anew in which a pole has moved too far from its expansion point.
    /// Returns whether there were any.
    pub fn follow(&mut self, data: &FitData, poles: &[Complex64]) -> bool {
        let serves = |segment: &Segment| segment.serves(poles, self.max_expansion_distance);
        let left: Vec<usize> = (0..self.segments.len())
            .filter(|index| !serves(&self.segments[*index]))
            .collect();
        let mut segments = std::mem::take(&mut self.segments);
        let renew = |(index, segment): (usize, &mut Segment)| {
            if left.binary_search(&index).is_ok() {
                let demand = self.demand(data, segment.lines(), poles);
                segment.renew(data, &self.profile, &demand);
            }
        };
        segments.par_iter_mut().enumerate().for_each(renew);
        self.segments = segments;
        !left.is_empty()
    }

    fn demand<'a>(
        &'a self,
        data: &'a FitData,
        lines: &Range<usize>,
        poles: &'a [Complex64],
    ) -> Demand<'a> {
        Demand {
            poles,
            polynomials: self.polynomials,
            out_of_band_terms: &self.out_of_band_terms,
            end_terms: end_terms(data, lines),
        }
    }

    /// The segments that need the least operations. Long ones have few coordinates, of which every
    /// fit and every step takes products; of short ones the decompositions take less, and a pole
    /// that moves renews few lines.
    fn cheapest_ranges(
        &self,
        data: &FitData,
        poles: &[Complex64],
        members: usize,
    ) -> Vec<Range<usize>> {
        let functions = data.frfs.functions();
        let fitted = self.out_of_band_terms.ncols() + 2 * members;
        let known = poles.len() + data.out_of_band_fit().columns().ncols();
        let operations_per_coordinate =
            FITS_PER_BAND * known * functions + STEPS_PER_BAND * fitted * (fitted + functions);
        let cost = |ranges: &Vec<Range<usize>>| {
            let (mut coordinates, mut operations) = (0, 0);
            for range in ranges {
                let (middle, half_length) = middle(data, range);
                let is_near = |pole: &&Complex64| (*pole - middle).norm() < REACH * half_length;
                let near = poles.iter().filter(is_near).count();
                let ends = end_terms(data, range).ncols();
                let columns = (self.polynomials + ends + POWERS * near).min(range.len());
                coordinates += columns;
                operations += range.len() * columns * (columns + functions);
            }
            let renewed = ranges.len().min(RENEWED_SEGMENTS) as f64 / ranges.len() as f64;
            let operations = (1.0 + renewed) * operations as f64;
            operations + (coordinates * operations_per_coordinate) as f64
        };
        let halves = std::iter::successors(Some(1), |count| Some(2 * count));
        let counts =
            halves.take_while(|count| *count == 1 || self.lines.len() >= count * MIN_SEGMENT_LINES);
        let ranges = counts.map(|count| equal_ranges(&self.lines, count));
        let costs = ranges.map(|ranges| (cost(&ranges), ranges));
        let cheapest = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        cheapest.map_or_else(Vec::new, |(_, ranges)| ranges)
    }

    /// Coordinates of the values minus the known response, without that of `members`, the numbers
    /// of the poles that are fitted, ascending.
    pub fn without_known_response(
        &self,
        known: &KnownResponse,
        members: &[usize],
    ) -> CompressedValues {
        let is_subtracted = |row: &usize| members.binary_search(row).is_err();
        let rows = (0..known.lambdas.len()).filter(is_subtracted);
        let rows: Vec<usize> = rows.collect();
        let unit = |row: &usize| PoleColumn {
            lambda: known.lambdas[*row],
            scale: 1.0,
            n: 1,
        };
        let columns: Vec<PoleColumn> = rows.iter().map(unit).collect();
        let functions = self.profile.level.len();
        let (first, all) = (known.lambdas.len(), known.amplitudes.nrows());
        let columns_of = |segment: &Segment| {
            let line_shapes = segment.line_shapes(self.line_shape, &columns);
            let mut a = ComplexMatrix::zeros(segment.coordinates(), all);
            for (c, row) in rows.iter().enumerate() {
                a.col_mut(*row).copy_from(line_shapes.col(c));
            }
            if all > first {
                a.subcols_mut(first, all - first)
                    .copy_from(&segment.out_of_band_columns);
            }
            a
        };
        let segments = self.segments.par_iter();
        let parts: Vec<StackedPart> = segments
            .map(|segment| StackedPart {
                b: &segment.values,
                a: columns_of(segment),
            })
            .collect();
        let values = linalg::stacked_difference(&parts, &known.amplitudes);
        let energy = |f: usize| {
            let energy: f64 = values.col_as_slice(f).iter().map(Complex64::norm_sqr).sum();
            energy / self.profile.level[f].powi(2)
        };
        let inside: f64 = (0..functions).map(energy).sum();
        let outside: f64 = self.segments.iter().map(|part| part.energy_outside).sum();
        CompressedValues {
            energy: inside + outside,
            values,
        }
    }

    /// The values in the coordinates of out-of-band terms, line shapes and the derivatives of the
    /// free poles, and the energy that these can explain.
    pub fn compressed(
        &self,
        near: &CompressedValues,
        members: &[ModelPole],
        moving: &[usize],
    ) -> (Compressed, f64) {
        let (count, first) = (members.len(), self.out_of_band_terms.ncols());
        let column = |j: usize, n: usize| PoleColumn {
            lambda: members[j].lambda,
            scale: members[j].lambda.re.abs(),
            n,
        };
        let line_shapes = (0..count).map(|j| column(j, 1));
        let derivatives = moving.iter().map(|j| column(*j, 2));
        let poles: Vec<PoleColumn> = line_shapes.chain(derivatives).collect();
        let of_segment = |segment: &Segment| {
            let line_shapes = segment.line_shapes(self.line_shape, &poles);
            linalg::complex_matrix(segment.coordinates(), first + poles.len(), |i, c| {
                match c.checked_sub(first) {
                    None => segment.out_of_band_terms[(i, c)],
                    Some(c) => line_shapes[(i, c)],
                }
            })
        };
        let parts: Vec<ComplexMatrix> = self.segments.par_iter().map(of_segment).collect();
        let qr = ThinQr::or_not_a_number(&stack(&parts, first + poles.len()));
        let z = linalg::adjoint_product(&qr.q, near.values.as_ref());
        let energy = |f: usize| {
            let energy: f64 = z.col(f).iter().map(Complex64::norm_sqr).sum();
            energy / self.profile.level[f].powi(2)
        };
        let explained: f64 = (0..z.ncols()).map(energy).sum();
        let rows = qr.q.ncols() - first;
        let mut line_shapes = linalg::complex_matrix(rows, 2 * count, |_, _| Complex64::ZERO);
        for i in 0..rows {
            for j in 0..count {
                line_shapes[(i, j)] = qr.r[(first + i, first + j)];
            }
            for (index, &j) in moving.iter().enumerate() {
                line_shapes[(i, count + j)] = qr.r[(first + i, first + count + index)];
            }
        }
        let below = |matrix: &ComplexMatrix, columns: usize, before: usize| {
            linalg::complex_matrix(rows, columns, |i, j| matrix[(first + i, before + j)])
        };
        let compressed = Compressed {
            z: below(&z, z.ncols(), 0),
            g: below(&qr.r, count, first),
            squares: line_shapes.adjoint() * &line_shapes,
            line_shapes,
        };
        (compressed, explained)
    }
}

/// Out-of-band terms on the lines of a segment within its length of an end of the data, without
/// constant and slope; none elsewhere, where they are polynomials. Those of all lines include those
/// of a range that ends there.
fn end_terms<'a>(data: &'a FitData, lines: &Range<usize>) -> ComplexView<'a> {
    let columns = data.out_of_band_fit().columns();
    let is_near = lines.start < lines.len() || columns.nrows() - lines.end < lines.len();
    let count = match is_near {
        true => columns.ncols() - MIN_OUT_OF_BAND_COLUMNS,
        false => 0,
    };
    columns
        .subrows(lines.start, lines.len())
        .subcols(columns.ncols() - count, count)
}

/// Lines in a number of ranges of the same length.
fn equal_ranges(lines: &Range<usize>, count: usize) -> Vec<Range<usize>> {
    let edge = |n: usize| lines.start + n * lines.len() / count;
    (0..count).map(|n| edge(n)..edge(n + 1)).collect()
}

/// Strongest value over its noise, at least 1.
fn response_over_noise(frfs: &BandFrfs, lines: &Range<usize>, profile: &BandProfile) -> f64 {
    let weights = profile
        .noise_profile
        .iter()
        .map(|factor| (factor * factor).recip());
    let weights: Vec<f64> = weights.collect();
    let strongest = |f: usize| {
        let values = frfs.values.of(f, lines.clone());
        let powers = values
            .iter()
            .zip(&weights)
            .map(|(h, weight)| h.norm_sqr() * weight);
        powers.fold(0.0, f64::max) / profile.level[f].powi(2)
    };
    let functions = (0..frfs.functions()).into_par_iter();
    functions.map(strongest).reduce(|| 1.0, f64::max).sqrt()
}

/// Matrices of the same number of columns, below each other.
fn stack(parts: &[ComplexMatrix], columns: usize) -> ComplexMatrix {
    let rows = parts.iter().map(ComplexMatrix::nrows).sum();
    let mut whole = ComplexMatrix::zeros(rows, columns);
    let mut first = 0;
    for part in parts {
        whole.subrows_mut(first, part.nrows()).copy_from(part);
        first += part.nrows();
    }
    whole
}
