//! Rational fraction polynomials with orthogonal bases: poles of the lines around every peak, from
//! one denominator that all functions share.
//!
//! On the lines around a peak, `x = (ω − ω_c)/r ∈ [−1, 1]`, every receptance is `H_f =
//! N_f(x)/D(x)`. Both polynomials are sums of orthonormal ones: the numerators' under the weight of
//! the equations, the denominator's under that which the noise gets in them, so that powers of
//! frequency and their conditioning never appear. The equation error `w_f (H_f D − N_f)` is
//! projected on what the numerators cannot explain; a QR of all functions leaves a triangle `R`,
//! and `D` is the right singular vector of its smallest singular value. In this basis the noise of
//! all coefficients is white, but for the share that the numerators' projection takes out of it,
//! which falls as lines per unknown grow: it is the generalised total least squares estimate in
//! that limit, consistent there, where least squares with one coefficient fixed is not. Lower
//! orders are leading blocks of `R`.
//!
//! Modes and conjugates outside the lines are followed by numerators of [`EXTRA`] degrees more than
//! the denominator and by its own roots outside. The numerators keep their degree for all orders.
//! The roots are the eigenvalues of the Hessenberg matrix of the basis with its last row changed
//! (comrade matrix); `λ = i(ω_c + r x)`: nothing is shifted and nothing approximated between `x`
//! and `s`, so that without noise the poles come back to rounding.
//!
//! Once poles are known, lines are weighted by one over their product, which is what a denominator
//! makes of the noise of its line.
//!
//! References: Richardson and Formenti (1982), Parameter estimation from frequency response
//! measurements using rational fraction polynomials, IMAC 1; Forsythe (1957), J. SIAM 5(2); Van
//! Huffel and Vandewalle (1991), The Total Least Squares Problem; Sanathanan and Koerner (1963),
//! IEEE Trans. Automatic Control 8(1); Brubeck, Nakatsukasa and Trefethen (2021), Vandermonde with
//! Arnoldi, SIAM Review 63(2).

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::detection_spectrum::Indicator;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::peak_detection::{self, Found};
use crate::identify::error::IdentifyError;
use crate::identify::mdof::pole_tracks::{FEWEST_ORDERS, GlobalPole, Table};
use crate::identify::mdof::stabilization::{MultiModeMethod, Part};
use crate::identify::noise::band_profile::Profile;

/// Lines on either side of a peak: half-power widths, and fewest.
const REACH: f64 = 20.0;
const FEWEST_SIDE: usize = 24;
/// Degrees of the numerators beyond the highest order.
const EXTRA: usize = 6;
/// Highest order: so many for each peak on the lines, and beyond.
const ORDERS_PER_PEAK: usize = 2;
const ORDERS_BEYOND: usize = 8;
/// Lines for each unknown of a function, fewest.
const LINES_PER_UNKNOWN: usize = 3;
/// A leading coefficient below this part of the largest is none.
const LEADING: f64 = 1e-12;

/// Global rational fraction polynomials.
pub(in crate::identify) struct RationalFractions {
    /// Highest order, where it is not chosen by the number of peaks.
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

    fn parts(
        &self,
        (data, _): (&Receptances, &Sides),
        (found, known): (&Found, &[Complex64]),
    ) -> Result<Vec<Part>, IdentifyError> {
        let indicator = Indicator::new(data);
        let tops: Vec<f64> = found.peaks.iter().map(|p| data.omega[p.line]).collect();
        let part = |(j, peak): (usize, &peak_detection::Peak)| {
            let first = peak_detection::first_pole(data, &indicator, found, peak);
            let lines = around(data, first);
            let inside = data.omega[lines.start]..data.omega[lines.end - 1];
            let peaks = tops.iter().filter(|top| inside.contains(top)).count();
            let window = Window::new(data, lines, known);
            let highest = self
                .max_order
                .unwrap_or(ORDERS_PER_PEAK * peaks + ORDERS_BEYOND);
            let middle = |other: Option<&f64>| other.map(|other| 0.5 * (tops[j] + other));
            let before = j.checked_sub(1).and_then(|i| tops.get(i));
            Ok(Part {
                from_rad_s: middle(before).unwrap_or(0.0),
                to_rad_s: middle(tops.get(j + 1)).unwrap_or(f64::INFINITY),
                tables: window.tables(data, (peaks, highest))?,
            })
        };
        let peaks: Vec<(usize, &peak_detection::Peak)> = found.peaks.iter().enumerate().collect();
        let parts: Vec<Result<Part, IdentifyError>> = peaks.into_par_iter().map(part).collect();
        parts.into_iter().collect()
    }
}

/// The lines around a pole.
fn around(data: &Receptances, lambda: Complex64) -> Range<usize> {
    let side = (REACH * 2.0 * lambda.re.abs() / data.step).ceil() as usize;
    let side = side.max(FEWEST_SIDE);
    let top = data.line_of(lambda);
    top.saturating_sub(side)..(top + side + 1).min(data.lines())
}

/// Some lines with their noise.
struct Window {
    lines: Range<usize>,
    center: f64,
    half: f64,
    /// Lines from −1 to 1.
    x: Vec<f64>,
    profile: Profile,
    /// Root of the weight that known poles give a line.
    course: Vec<f64>,
}

impl Window {
    fn new(data: &Receptances, lines: Range<usize>, known: &[Complex64]) -> Self {
        let omega = &data.omega[lines.clone()];
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        let (center, half) = (0.5 * (first + last), 0.5 * (last - first));
        let x: Vec<f64> = omega.iter().map(|w| (w - center) / half).collect();
        let inside = |pole: &&Complex64| pole.im > first && pole.im < last;
        let of_pole = |pole: &Complex64| (-Complex64::I * pole - center) / half;
        let known: Vec<Complex64> = known.iter().filter(inside).map(of_pole).collect();
        let product = |x: &f64| known.iter().map(|pole| (x - pole).norm()).product::<f64>();
        Self {
            course: x.iter().map(|x| product(x).recip()).collect(),
            profile: Profile::new(data, lines.clone()),
            lines,
            center,
            half,
            x,
        }
    }

    /// Stable poles by order, from the number of peaks to the highest that the lines can carry.
    fn tables(
        &self,
        data: &Receptances,
        (lowest, highest): (usize, usize),
    ) -> Result<Vec<Table>, IdentifyError> {
        let most = (self.x.len() / LINES_PER_UNKNOWN).saturating_sub(EXTRA) / 2;
        let highest = highest.min(most).max(1);
        let of_noise = OrthogonalBasis::new(&self.x, &self.course, highest);
        let triangle = self.triangle(data, &of_noise, highest)?;
        let table = |order: usize| {
            let poles = self.poles(&triangle, &of_noise, order)?;
            Ok((order, poles))
        };
        // Where the lines carry little more than the peaks, so low that a pole can stay.
        let lowest = lowest.min(highest.saturating_sub(FEWEST_ORDERS - 1)).max(1);
        (lowest..=highest).map(table).collect()
    }

    /// The triangle of the equations of all functions, numerators projected out.
    fn triangle(
        &self,
        data: &Receptances,
        of_noise: &OrthogonalBasis,
        highest: usize,
    ) -> Result<ComplexMatrix, IdentifyError> {
        let weight = self.course.iter().zip(&self.profile.course);
        let weight: Vec<f64> = weight.map(|(known, noise)| known / noise).collect();
        let of_equations = OrthogonalBasis::new(&self.x, &weight, highest + EXTRA);
        let numerators = linalg::complex_matrix(self.x.len(), highest + EXTRA + 1, |k, j| {
            Complex64::from(of_equations.columns[j][k])
        });
        let size = highest + 1;
        let mut triangle = linalg::complex_matrix(0, size, |_, _| Complex64::ZERO);
        for (values, level) in data.values.iter().zip(&self.profile.level) {
            let values = &values[self.lines.clone()];
            let scaled = |k: usize| values[k] / (level * self.profile.course[k]);
            let mut columns = linalg::complex_matrix(self.x.len(), size, |k, j| {
                scaled(k) * of_noise.columns[j][k]
            });
            // Twice, so that rounding of the first projection is gone.
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
        let root = |x: Complex64| GlobalPole {
            lambda: Complex64::I * (self.center + self.half * x),
            participation: vec![Complex64::ONE],
        };
        let roots = basis.roots(&denominator)?.into_iter().map(root);
        let mut poles: Vec<GlobalPole> = roots.filter(|pole| pole.lambda.re < 0.0).collect();
        poles.sort_by(|p, q| p.lambda.im.total_cmp(&q.lambda.im));
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
                for (own, factor) in columns.iter().zip(&mut factors) {
                    let dot: f64 = own.iter().zip(&next).map(|(a, b)| a * b).sum();
                    next.iter_mut().zip(own).for_each(|(v, a)| *v -= dot * a);
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
        if order == 0 || leading.norm() <= LEADING * largest {
            return Ok(Vec::new());
        }
        // Row j says what x φ_j is; φ_n is minus the others over its coefficient where the sum
        // vanishes.
        let comrade = linalg::complex_matrix(order, order, |j, i| {
            let own = self.recurrence[j].get(i).copied().unwrap_or(0.0);
            let over = if j + 1 == order {
                self.recurrence[j][order] * coefficients[i] / leading
            } else {
                Complex64::ZERO
            };
            own - over
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
    fn roots_of_a_sum_of_orthogonal_polynomials_come_back() {
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
                found.iter().any(|own| (own - root).norm() < 1e-11),
                "{root}"
            );
        }
    }
}
