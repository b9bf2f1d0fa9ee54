//! Rational fraction polynomials with orthogonal bases give the poles around every peak from one
//! denominator that all FRFs share.
//!
//! On the lines around a peak, `x = (ω − ω_c)/r ∈ [−1, 1]`, every receptance is `H_f =
//! N_f(x)/D(x)`. Both polynomials are sums of orthonormal ones: the numerators under the weight of
//! the equations, the denominator under the weight of the noise in the equations, so that the ill
//! conditioned powers of frequency never appear. The equation error `w_f (H_f D − N_f)` is
//! projected off the numerators; a QR of all FRFs gives a triangle `R`, and `D` is the right
//! singular vector of its smallest singular value. In this basis the noise of all coefficients is
//! white, but for the fraction that the projection of the numerators removes, which falls as lines
//! per unknown grow: it is the generalised total least squares estimate in that limit, consistent
//! there, where least squares with one coefficient fixed is not. Lower orders are leading blocks of
//! `R`.
//!
//! Numerators of [`EXTRA_NUMERATOR_DEGREES`] degrees more than the denominator, and poles outside
//! the lines, model out-of-band and conjugate modes. The numerators keep their degree for all
//! orders. The roots are the eigenvalues of the Hessenberg matrix of the basis with its last row
//! changed (comrade matrix); `λ = i(ω_c + r x)`: nothing is shifted and nothing approximated
//! between `x` and `s`, so that without noise the poles are exact to round-off.
//!
//! A second estimate weights lines by one over the product of their distances to the poles of the
//! first one, the factor that a denominator applies to the noise of its line.
//!
//! References: Richardson and Formenti (1982), Parameter estimation from frequency response
//! measurements using rational fraction polynomials, IMAC 1; Forsythe (1957), J. SIAM 5(2); Van
//! Huffel and Vandewalle (1991), The Total Least Squares Problem; Sanathanan and Koerner (1963),
//! IEEE Trans. Automatic Control 8(1); Brubeck, Nakatsukasa and Trefethen (2021), Vandermonde with
//! Arnoldi, SIAM Review 63(2).

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, sort_ascending_by};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::detection_spectrum::DetectionSpectrum;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::peak_detection::{self, DetectedPeaks};
use crate::identify::error::IdentifyError;
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::pole_tracks::{GlobalPole, MIN_TRACK_ORDERS, OrderPoles};
use crate::identify::mdof::stabilization::{BandSegment, MultiModeMethod};
use crate::identify::noise::band_profile::BandProfile;

/// Lines on either side of a peak: half-power bandwidths, and minimum number.
const HALF_WINDOW_BANDWIDTHS: f64 = 20.0;
const MIN_SIDE_LINES: usize = 24;
/// Degrees of the numerators beyond the highest order.
const EXTRA_NUMERATOR_DEGREES: usize = 6;
/// Highest order: a number for each peak on the lines, and additional ones.
const ORDERS_PER_PEAK: usize = 2;
const ADDITIONAL_ORDERS: usize = 8;
/// Minimum number of lines per unknown of an FRF.
const MIN_LINES_PER_UNKNOWN: usize = 3;
/// Minimum leading coefficient over the largest; a smaller one counts as zero.
const MIN_LEADING_RATIO: f64 = 1e-12;

/// Global rational fraction polynomials.
pub(in crate::identify) struct RationalFractions {
    /// Highest order; without it the number of peaks determines it.
    pub max_order: Option<usize>,
}

impl MultiModeMethod for RationalFractions {
    fn name(&self) -> &'static str {
        "rfp"
    }

    fn gives_participation(&self) -> bool {
        false
    }

    fn weights_lines(&self) -> bool {
        true
    }

    fn segments(
        &self,
        data: &FitData,
        _frf_matrix: &FrfMatrix,
        found: &DetectedPeaks,
        weight_poles: &[Complex64],
    ) -> Result<Vec<BandSegment>, IdentifyError> {
        let indicator = DetectionSpectrum::new(&data.frfs, data.noise.stated_noise());
        let all_peaks = found.of_any_direction();
        let tops: Vec<f64> = all_peaks.iter().map(|p| data.frfs.omega[p.line]).collect();
        let segment_of = |(j, peak): (usize, &peak_detection::Peak)| {
            let first = peak_detection::first_pole(&data.frfs, &indicator, found, peak);
            let lines = around(&data.frfs, first);
            let inside = data.frfs.omega[lines.start]..data.frfs.omega[lines.end - 1];
            let peaks = tops.iter().filter(|top| inside.contains(top)).count();
            let window = FitLines::new(data, lines, weight_poles);
            let highest = self
                .max_order
                .unwrap_or(ORDERS_PER_PEAK * peaks + ADDITIONAL_ORDERS);
            let middle = |other: Option<&f64>| other.map(|other| 0.5 * (tops[j] + other));
            let before = j.checked_sub(1).and_then(|i| tops.get(i));
            Ok(BandSegment {
                from_rad_s: middle(before).unwrap_or(0.0),
                to_rad_s: middle(tops.get(j + 1)).unwrap_or(f64::INFINITY),
                tables: window.tables(&data.frfs, peaks, highest)?,
            })
        };
        let peaks: Vec<(usize, &peak_detection::Peak)> = all_peaks.iter().enumerate().collect();
        let segments: Vec<Result<BandSegment, IdentifyError>> =
            peaks.into_par_iter().map(segment_of).collect();
        segments.into_iter().collect()
    }
}

/// The lines around a pole.
fn around(data: &BandFrfs, lambda: Complex64) -> Range<usize> {
    let side = (HALF_WINDOW_BANDWIDTHS * 2.0 * lambda.re.abs() / data.step).ceil() as usize;
    let side = side.max(MIN_SIDE_LINES);
    let top = data.line_of(lambda);
    top.saturating_sub(side)..(top + side + 1).min(data.lines())
}

/// Some lines with their noise.
struct FitLines {
    lines: Range<usize>,
    center: f64,
    half: f64,
    /// Lines from −1 to 1.
    x: Vec<f64>,
    profile: BandProfile,
    /// Root of the weight of every line by the denominator of given poles.
    denominator_weight: Vec<f64>,
}

impl FitLines {
    fn new(data: &FitData, lines: Range<usize>, weight_poles: &[Complex64]) -> Self {
        let omega = &data.frfs.omega[lines.clone()];
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        let (center, half) = (0.5 * (first + last), 0.5 * (last - first));
        let x: Vec<f64> = omega.iter().map(|w| (w - center) / half).collect();
        let inside = |pole: &&Complex64| pole.im > first && pole.im < last;
        let to_x = |pole: &Complex64| (-Complex64::I * pole - center) / half;
        let weight_poles: Vec<Complex64> = weight_poles.iter().filter(inside).map(to_x).collect();
        let product = |x: &f64| {
            weight_poles
                .iter()
                .map(|pole| (x - pole).norm())
                .product::<f64>()
        };
        Self {
            denominator_weight: x.iter().map(|x| product(x).recip()).collect(),
            profile: BandProfile::new(&data.noise, lines.clone()),
            lines,
            center,
            half,
            x,
        }
    }

    /// Stable poles by order, from the number of peaks to the highest that the lines can carry.
    fn tables(
        &self,
        data: &BandFrfs,
        lowest: usize,
        highest: usize,
    ) -> Result<Vec<OrderPoles>, IdentifyError> {
        let max_order =
            (self.x.len() / MIN_LINES_PER_UNKNOWN).saturating_sub(EXTRA_NUMERATOR_DEGREES) / 2;
        let highest = highest.min(max_order).max(1);
        let of_noise = OrthogonalBasis::new(&self.x, &self.denominator_weight, highest);
        let triangle = self.triangle(data, &of_noise, highest)?;
        let table = |order: usize| {
            let poles = self.poles(&triangle, &of_noise, order)?;
            Ok((order, poles))
        };
        // Where the lines support few orders, the lowest order is low enough for a pole track.
        let lowest = lowest
            .min(highest.saturating_sub(MIN_TRACK_ORDERS - 1))
            .max(1);
        (lowest..=highest).map(table).collect()
    }

    /// The triangle of the equations of all functions, numerators projected out.
    fn triangle(
        &self,
        data: &BandFrfs,
        of_noise: &OrthogonalBasis,
        highest: usize,
    ) -> Result<ComplexMatrix, IdentifyError> {
        let weight = self
            .denominator_weight
            .iter()
            .zip(&self.profile.noise_profile);
        let weight: Vec<f64> = weight
            .map(|(denominator, noise)| denominator / noise)
            .collect();
        let of_equations =
            OrthogonalBasis::new(&self.x, &weight, highest + EXTRA_NUMERATOR_DEGREES);
        let numerators = linalg::complex_matrix(
            self.x.len(),
            highest + EXTRA_NUMERATOR_DEGREES + 1,
            |k, j| Complex64::from(of_equations.columns[j][k]),
        );
        let size = highest + 1;
        let mut triangle = linalg::complex_matrix(0, size, |_, _| Complex64::ZERO);
        for (f, level) in self.profile.level.iter().enumerate() {
            let values = data.values.of(f, self.lines.clone());
            let scaled = |k: usize| values[k] / (level * self.profile.noise_profile[k]);
            let mut columns = linalg::complex_matrix(self.x.len(), size, |k, j| {
                scaled(k) * of_noise.columns[j][k]
            });
            // Twice, to remove the round-off of the first projection.
            for _ in 0..2 {
                let explained = numerators.adjoint() * &columns;
                columns -= &numerators * explained;
            }
            let rows = triangle.nrows();
            let stacked = linalg::complex_matrix(rows + self.x.len(), size, |i, j| {
                match i.checked_sub(rows) {
                    None => triangle[(i, j)],
                    Some(line) => columns[(line, j)],
                }
            });
            triangle = linalg::thin_qr(&stacked)?.r;
        }
        Ok(triangle)
    }

    fn poles(
        &self,
        triangle: &ComplexMatrix,
        basis: &OrthogonalBasis,
        order: usize,
    ) -> Result<Vec<GlobalPole>, IdentifyError> {
        let size = order + 1;
        let block = linalg::complex_matrix(size, size, |i, j| triangle[(i, j)]);
        let svd = linalg::singular_vectors(&block)?;
        let denominator: Vec<Complex64> = (0..size).map(|j| svd.right[(j, order)]).collect();
        let to_pole = |x: Complex64| GlobalPole {
            lambda: Complex64::I * (self.center + self.half * x),
            participation: vec![Complex64::ONE],
        };
        let roots = basis.roots(&denominator)?.into_iter().map(to_pole);
        let mut poles: Vec<GlobalPole> = roots.filter(|pole| pole.lambda.re < 0.0).collect();
        sort_ascending_by(&mut poles, |pole| pole.lambda.im);
        Ok(poles)
    }
}

/// Polynomials that are orthonormal on some points under a weight.
struct OrthogonalBasis {
    /// Values times the root of the weight, by degree.
    columns: Vec<Vec<f64>>,
    /// `x φ_j = Σ_i h_ij φ_i`, by j, with i up to j + 1.
    recurrence: Vec<Vec<f64>>,
}

impl OrthogonalBasis {
    /// Up to a degree, for points and roots of their weights: Arnoldi's process with two
    /// projections.
    fn new(x: &[f64], root_weight: &[f64], degree: usize) -> Self {
        let mut columns = vec![normalised(root_weight.to_vec()).0];
        let mut recurrence = Vec::with_capacity(degree);
        for j in 0..degree {
            let last = &columns[j];
            let mut next: Vec<f64> = last.iter().zip(x).map(|(v, x)| v * x).collect();
            let mut factors = vec![0.0; j + 1];
            for _ in 0..2 {
                for (column, factor) in columns.iter().zip(&mut factors) {
                    let dot: f64 = column.iter().zip(&next).map(|(a, b)| a * b).sum();
                    next.iter_mut().zip(column).for_each(|(v, a)| *v -= dot * a);
                    *factor += dot;
                }
            }
            let (next, norm) = normalised(next);
            factors.push(norm);
            columns.push(next);
            recurrence.push(factors);
        }
        Self {
            columns,
            recurrence,
        }
    }

    /// Roots of `Σ d_j φ_j`: eigenvalues of the recurrence with its last row changed.
    fn roots(&self, coefficients: &[Complex64]) -> Result<Vec<Complex64>, IdentifyError> {
        let order = coefficients.len() - 1;
        let largest = coefficients.iter().map(|d| d.norm()).fold(0.0, f64::max);
        let leading = coefficients[order];
        if order == 0 || leading.norm() <= MIN_LEADING_RATIO * largest {
            return Ok(Vec::new());
        }
        // Row j holds the coefficients of x φ_j; at a root, φ_n is minus the sum of the other terms
        // over its coefficient.
        let comrade = linalg::complex_matrix(order, order, |j, i| {
            let entry = self.recurrence[j].get(i).copied().unwrap_or(0.0);
            let correction = if j + 1 == order {
                self.recurrence[j][order] * coefficients[i] / leading
            } else {
                Complex64::ZERO
            };
            entry - correction
        });
        let roots = linalg::complex_eigenvalues(&comrade)?;
        Ok(roots.into_iter().filter(|x| x.is_finite()).collect())
    }
}

fn normalised(mut values: Vec<f64>) -> (Vec<f64>, f64) {
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    values.iter_mut().for_each(|v| *v /= norm);
    (values, norm)
}

#[cfg(test)]
mod tests {
    use crate::identify::mdof::rfp::*;

    #[test]
    fn roots_of_a_sum_of_orthogonal_polynomials_are_exact() {
        let x: Vec<f64> = (0..60).map(|k| k as f64 / 29.5 - 1.0).collect();
        let weight: Vec<f64> = x.iter().map(|x| 1.0 / (0.05 + (x - 0.3).abs())).collect();
        let basis = OrthogonalBasis::new(&x, &weight, 8);
        let roots: Vec<Complex64> = (0..8)
            .map(|j| Complex64::new(0.2 * f64::from(j) - 0.8, 0.01 * f64::from(j + 1)))
            .collect();
        // Coefficients by projection of the product.
        let product = |x: f64| roots.iter().map(|root| x - root).product::<Complex64>();
        let coefficient = |column: &Vec<f64>| -> Complex64 {
            let terms = column.iter().zip(&x).zip(&weight);
            terms.map(|((c, x), w)| c * w * product(*x)).sum()
        };
        let coefficients: Vec<Complex64> = basis.columns.iter().map(coefficient).collect();
        let found = basis.roots(&coefficients).unwrap();
        for root in roots {
            assert!(
                found.iter().any(|value| (value - root).norm() < 1e-11),
                "{root}"
            );
        }
    }
}
