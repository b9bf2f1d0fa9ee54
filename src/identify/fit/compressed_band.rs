//! Compressed band: the values of all FRFs on a range of lines, projected on the few functions of
//! frequency that a fit of its poles needs.
//!
//! The columns of a fit are out-of-band terms, `g_j = σ_j/(iω − λ_j)` and, for free poles, `g_j²`.
//! About poles `λ_j0` with `x = |σ_j0|/(iω − λ_j0)` and `ε = (λ_j − λ_j0)/|σ_j0|`
//!
//! ```text
//! g = |σ/σ_0| (x + ε x² + ε² x³ + …)      g² = |σ/σ_0|² (x² + 2ε x³ + …)
//! ```
//!
//! (for a smoothed pole, xⁿ is its derivative of order n − 1 by λ, times `|σ_0|ⁿ/(n − 1)!`) so that
//! the coordinates of the values in an orthonormal basis of out-of-band terms, x, x² and x³ are
//! valid for all poles near λ_0: a step of a fit reads no line, and the values are read once for as
//! long as poles stay near and the noise is unchanged. The contribution of other poles has
//! coordinates as well, which are subtracted from those of the values.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, ThinQr};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandBasis;
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::variable_projection::Compressed;
use crate::identify::noise::band_profile::BandProfile;

/// Powers of each line shape.
const POWERS: usize = 3;
/// Minimum and maximum distance of a pole from its expansion point, decay rates: the third power of
/// the distance is the truncation error of the line shape, for the minimum a rounding error.
const EXPANSION_DECAY_RATES: [f64; 2] = [3e-5, 1e-2];
/// Truncation error of the strongest response at that distance, over the noise of one value.
const MAX_TRUNCATION_OVER_NOISE: f64 = 1e-3;
/// Maximum number of FRFs whose whole energy is summed.
const MAX_SAMPLED_FRFS: usize = 48;
/// Maximum number of coordinates, over those of a new compressed band.
const MAX_GROWTH: f64 = 1.5;
/// Maximum difference of the ends of two bands with the same lines, over their length.
const MAX_END_DIFFERENCE: f64 = 1.0 / 32.0;

/// A compressed band.
pub(in crate::identify) struct CompressedBand {
    lines: Range<usize>,
    profile: BandProfile,
    /// Number of columns of the out-of-band terms.
    background: usize,
    /// Expansion point λ_0 of each line shape.
    expansion_points: Vec<Complex64>,
    /// Maximum |ε|.
    max_expansion_distance: f64,
    /// Coordinates of out-of-band terms and powers: an upper triangle.
    triangle: ComplexMatrix,
    /// Weights that yield the coordinates of values: lines × coordinates.
    weights: ComplexMatrix,
    /// Coordinates of the measured values, coordinates × FRFs.
    values: ComplexMatrix,
    /// Coordinates of the out-of-band columns of all lines.
    out_of_band_column_coordinates: ComplexMatrix,
    /// Version of the data that they were computed from.
    version: u64,
}

/// Response of other poles and of out-of-band terms, which is subtracted from the values.
pub(in crate::identify) struct KnownResponse<'a> {
    /// Line shapes of the poles and of their conjugates: lines × twice the number of poles.
    pub line_shapes: &'a ComplexMatrix,
    /// Residues of the poles and of their conjugates: twice the number of poles × FRFs.
    pub residues: &'a ComplexMatrix,
    /// Coordinates of the out-of-band terms of all lines, where they are subtracted.
    pub out_of_band: Option<&'a ComplexMatrix>,
}

/// Coordinates of the values minus the contribution of other poles and out-of-band terms.
pub(in crate::identify) struct CompressedValues {
    /// Coordinates × FRFs.
    values: ComplexMatrix,
    /// Energy of these, over the noise.
    pub energy: f64,
}

impl CompressedBand {
    /// Compresses a range of lines, with expansion points for some poles.
    pub fn new(data: &FitData, lines: &Range<usize>, expansion_points: Vec<Complex64>) -> Self {
        let profile = BandProfile::new(&data.noise, lines.clone());
        let omega = &data.frfs.omega[lines.clone()];
        let background = OutOfBandBasis::new(&data.frfs.omega, lines, data.out_of_band_terms());
        let first = background.columns();
        let columns = first + POWERS * expansion_points.len();
        let powers = line_shape_powers(data.frfs.line_shape, omega, &expansion_points);
        let value = |k: usize, column: usize| {
            let value = match column.checked_sub(first) {
                None => background.value(column, omega, k),
                Some(index) => powers[(k, index)],
            };
            value / profile.noise_profile[k]
        };
        let qr = ThinQr::or_not_a_number(&linalg::complex_matrix(omega.len(), columns, value));
        let weights = divide_by_profile(&qr.q, &profile.noise_profile);
        let rows = |matrix: &ComplexMatrix| {
            let measured = matrix.subrows(lines.start, lines.len());
            linalg::adjoint_product(&weights, measured)
        };
        Self {
            values: rows(data.frfs.values.matrix()),
            out_of_band_column_coordinates: rows(data.out_of_band_fit().columns()),
            lines: lines.clone(),
            background: first,
            triangle: qr.r,
            version: data.version(),
            max_expansion_distance: max_expansion_distance(&data.frfs, lines, &profile),
            expansion_points,
            weights,
            profile,
        }
    }

    pub fn lines(&self) -> &Range<usize> {
        &self.lines
    }

    pub fn profile(&self) -> &BandProfile {
        &self.profile
    }

    /// Number of columns of the out-of-band terms.
    pub fn background(&self) -> usize {
        self.background
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

    /// Whether every pole is within range of an expansion point.
    pub fn serves(&self, poles: &[Complex64]) -> bool {
        poles
            .iter()
            .all(|lambda| self.expansion_of(*lambda).is_some())
    }

    /// Adds expansion points for the poles that are out of range of the present ones; compresses
    /// the lines anew where the number of coordinates would grow too much.
    pub fn add_missing_expansion_points(&mut self, data: &FitData, poles: Vec<Complex64>) {
        let uncovered = poles
            .iter()
            .filter(|lambda| self.expansion_of(**lambda).is_none());
        let uncovered: Vec<Complex64> = uncovered.copied().collect();
        let needed = self.background + POWERS * poles.len();
        let grown = self.weights.ncols() + POWERS * uncovered.len();
        if grown as f64 > MAX_GROWTH * needed as f64 || grown > self.lines.len() {
            *self = Self::new(data, &self.lines, poles);
        } else {
            self.add_expansion_points(data, uncovered);
        }
    }

    fn add_expansion_points(&mut self, data: &FitData, more: Vec<Complex64>) {
        let noise_profile = &self.profile.noise_profile;
        let columns = line_shape_powers(
            data.frfs.line_shape,
            &data.frfs.omega[self.lines.clone()],
            &more,
        );
        // Twice, the second time at full length: for columns nearly in the basis one pass leaves
        // rounding errors.
        let (above, first) = self.split_off(&divide_by_profile(&columns, noise_profile));
        let (correction, second) = self.split_off(&first.q);
        let above = above + correction * &first.r;
        let triangle = second.r * first.r;
        let added = second.q;
        let weights = divide_by_profile(&added, noise_profile);
        let rows = |matrix: &ComplexMatrix| {
            let range = matrix.subrows(self.lines.start, self.lines.len());
            linalg::adjoint_product(&weights, range)
        };
        self.values = stack(&self.values, &rows(data.frfs.values.matrix()));
        self.out_of_band_column_coordinates = stack(
            &self.out_of_band_column_coordinates,
            &rows(data.out_of_band_fit().columns()),
        );
        let (high, wide) = (self.triangle.nrows(), self.triangle.ncols());
        self.triangle =
            linalg::complex_matrix(high + added.ncols(), wide + added.ncols(), |i, j| {
                match (i.checked_sub(high), j.checked_sub(wide)) {
                    (None, None) => self.triangle[(i, j)],
                    (None, Some(j)) => above[(i, j)],
                    (Some(i), Some(j)) => triangle[(i, j)],
                    (Some(_), None) => Complex64::ZERO,
                }
            });
        let first = self.weights.ncols();
        self.weights = linalg::complex_matrix(added.nrows(), first + added.ncols(), |k, c| {
            if c < first {
                self.weights[(k, c)]
            } else {
                weights[(k, c - first)]
            }
        });
        self.expansion_points.extend(more);
    }

    /// Coordinates of columns, and their components outside the present basis.
    fn split_off(&self, columns: &ComplexMatrix) -> (ComplexMatrix, ThinQr) {
        let noise_profile = &self.profile.noise_profile;
        let raw = linalg::complex_matrix(columns.nrows(), columns.ncols(), |k, c| {
            columns[(k, c)] * noise_profile[k]
        });
        let coordinates = linalg::adjoint_product(&self.weights, raw.as_ref());
        let explained = &self.weights * &coordinates;
        let remainder = linalg::complex_matrix(columns.nrows(), columns.ncols(), |k, c| {
            columns[(k, c)] - explained[(k, c)] * noise_profile[k]
        });
        (coordinates, ThinQr::or_not_a_number(&remainder))
    }

    /// Number of the expansion point nearest to a pole, and ε.
    fn expansion_of(&self, lambda: Complex64) -> Option<(usize, Complex64)> {
        let offset = |point: &Complex64| match lambda - point {
            Complex64::ZERO => Complex64::ZERO,
            difference => difference / point.re.abs(),
        };
        let offsets = self.expansion_points.iter().map(offset).enumerate();
        let nearest = offsets.min_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))?;
        (nearest.1.norm() <= self.max_expansion_distance).then_some(nearest)
    }

    /// Coordinates of the values minus the known response.
    pub fn without_known_response(&self, known: &KnownResponse) -> CompressedValues {
        let pole_coordinates = linalg::adjoint_product(&self.weights, known.line_shapes.as_ref());
        let mut values = &self.values - pole_coordinates * known.residues;
        if let Some(coordinates) = known.out_of_band {
            values -= &self.out_of_band_column_coordinates * coordinates;
        }
        let energy = |f: usize| {
            let energy: f64 = values.col(f).iter().map(Complex64::norm_sqr).sum();
            energy / self.profile.level[f].powi(2)
        };
        CompressedValues {
            energy: (0..values.ncols()).map(energy).sum(),
            values,
        }
    }

    /// Energy over the noise of the values minus the known response, with the coordinates of these.
    /// The part outside the basis is estimated from some FRFs, for all.
    pub fn energy(&self, data: &FitData, known: &KnownResponse, near: &CompressedValues) -> f64 {
        let functions = data.frfs.functions();
        let stride = functions.div_ceil(MAX_SAMPLED_FRFS);
        let sampled: Vec<usize> = (0..functions).step_by(stride).collect();
        let of = |matrix: &ComplexMatrix| {
            linalg::complex_matrix(matrix.nrows(), sampled.len(), |i, index| {
                matrix[(i, sampled[index])]
            })
        };
        let mut subtracted = known.line_shapes * of(known.residues);
        if let Some(coordinates) = known.out_of_band {
            let columns = data.out_of_band_fit().columns();
            subtracted += columns.subrows(self.lines.start, self.lines.len()) * of(coordinates);
        }
        let outside_basis = |(index, f): (usize, &usize)| {
            let values = data.frfs.values[*f][self.lines.clone()].iter();
            let terms = values
                .zip(subtracted.col(index).iter())
                .zip(&self.profile.noise_profile);
            let terms =
                terms.map(|((h, known), profile)| (h - known).norm_sqr() / (profile * profile));
            let inside = near.values.col(*f).iter().map(Complex64::norm_sqr);
            (terms.sum::<f64>() - inside.sum::<f64>()) / self.profile.level[*f].powi(2)
        };
        let outside: f64 = sampled.iter().enumerate().map(outside_basis).sum();
        near.energy + outside * functions as f64 / sampled.len() as f64
    }

    /// The values in the coordinates of out-of-band terms, line shapes and the derivatives of the
    /// free poles, and the energy that these can explain.
    pub fn compressed(
        &self,
        near: &CompressedValues,
        members: &[ModelPole],
        moving: &[usize],
    ) -> (Compressed, f64) {
        let (count, first) = (members.len(), self.background);
        let expansions: Vec<(usize, Complex64)> = members
            .iter()
            .map(|root| {
                let expansion = self.expansion_of(root.lambda);
                expansion.expect("the window follows the poles")
            })
            .collect();
        let value = |i: usize, column: usize| {
            let Some(index) = column.checked_sub(first) else {
                return self.triangle[(i, column)];
            };
            let j = if index < count {
                index
            } else {
                moving[index - count]
            };
            let (point, offset) = expansions[j];
            let scale = members[j].lambda.re / self.expansion_points[point].re;
            let power = |n: usize| self.triangle[(i, first + POWERS * point + n)];
            if index < count {
                scale * (power(0) + offset * (power(1) + offset * power(2)))
            } else {
                scale * scale * (power(1) + 2.0 * offset * power(2))
            }
        };
        let columns = first + count + moving.len();
        let qr = ThinQr::or_not_a_number(&linalg::complex_matrix(
            self.triangle.nrows(),
            columns,
            value,
        ));
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

/// Maximum distance of poles from their expansion points, decay rates.
fn max_expansion_distance(frfs: &BandFrfs, lines: &Range<usize>, profile: &BandProfile) -> f64 {
    let strongest = |f: usize| {
        let values = frfs.values[f][lines.clone()]
            .iter()
            .zip(&profile.noise_profile);
        let powers = values.map(|(h, factor)| h.norm_sqr() / (factor * factor));
        powers.fold(0.0, f64::max) / profile.level[f].powi(2)
    };
    let functions = (0..frfs.functions()).into_par_iter();
    let over_noise = functions.map(strongest).reduce(|| 1.0, f64::max).sqrt();
    (MAX_TRUNCATION_OVER_NOISE / over_noise)
        .cbrt()
        .clamp(EXPANSION_DECAY_RATES[0], EXPANSION_DECAY_RATES[1])
}

/// Powers of the line shape of each pole: lines × powers of all.
fn line_shape_powers(
    line_shape: LineShape,
    omega: &[f64],
    expansion_points: &[Complex64],
) -> ComplexMatrix {
    linalg::complex_matrix(omega.len(), POWERS * expansion_points.len(), |k, column| {
        let lambda = expansion_points[column / POWERS];
        line_shape.power(lambda.re.abs(), omega[k], lambda, column % POWERS + 1)
    })
}

/// Columns divided by a profile over the lines.
fn divide_by_profile(columns: &ComplexMatrix, profile: &[f64]) -> ComplexMatrix {
    linalg::complex_matrix(columns.nrows(), columns.ncols(), |k, c| {
        columns[(k, c)] / profile[k]
    })
}

fn stack(upper: &ComplexMatrix, lower: &ComplexMatrix) -> ComplexMatrix {
    let rows = upper.nrows();
    linalg::complex_matrix(rows + lower.nrows(), upper.ncols(), |i, j| {
        match i.checked_sub(rows) {
            None => upper[(i, j)],
            Some(i) => lower[(i, j)],
        }
    })
}
