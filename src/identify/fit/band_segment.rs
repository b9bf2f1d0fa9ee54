//! One segment of a compressed band: an orthonormal basis for the line shapes of poles and for the
//! out-of-band terms on its lines, and the coordinates of the measured values in it.
//!
//! A pole farther from the middle of the segment than [`REACH`] half-lengths is a smooth function
//! on its lines: a polynomial, found from the values at Chebyshev nodes
//! ([`chebyshev`](crate::identify::data::chebyshev)). A nearer pole λ has the first three powers of
//! `x = |σ_0|/(iω − λ_0)` at an expansion point λ_0. With `ε = (λ − λ_0)/|σ_0|`
//!
//! ```text
//! |σ|/(iω − λ) = |σ/σ_0| (x + ε x² + ε² x³ + …)
//! ```
//!
//! (for a smoothed pole, xⁿ is its derivative of order n − 1 by λ, times `|σ_0|ⁿ/(n − 1)!`; between
//! the lines it has a ripple that no polynomial represents, 1e-8 of its value under a Hann window).

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ComplexView, ThinQr};

use crate::identify::data::chebyshev::Chebyshev;
use crate::identify::data::line_shape::LineShape;
use crate::identify::fit::fit_data::FitData;
use crate::identify::noise::band_profile::BandProfile;

/// Powers of the line shape at an expansion point.
pub(super) const POWERS: usize = 3;
/// Distance from the middle, in half-lengths, within which a pole has an expansion point.
pub(super) const REACH: f64 = 3.0;
/// Factor by which one more degree of the polynomials lowers their error at that distance: 3 + √8.
const ERROR_RATIO: f64 = 5.83;
/// Minimum and maximum number of polynomials: with 8 the error is 1e-6, with 18 it is rounding.
const POLYNOMIALS: [usize; 2] = [8, 18];

/// Polynomials with which the strongest response has an error below a given one, over the noise.
pub(super) fn polynomials(max_error_over_noise: f64, response_over_noise: f64) -> usize {
    let needed = (response_over_noise / max_error_over_noise).ln() / ERROR_RATIO.ln();
    (needed.ceil() as usize).clamp(POLYNOMIALS[0], POLYNOMIALS[1])
}

/// Which poles a segment has to represent, and how exactly.
pub(super) struct Demand<'a> {
    /// Poles and conjugates that are evaluated.
    pub poles: &'a [Complex64],
    pub polynomials: usize,
    /// Out-of-band terms on the lines of the band.
    pub out_of_band_terms: &'a ComplexMatrix,
    /// Out-of-band terms on the lines of the segment that are no polynomials there: near an end of
    /// the data.
    pub end_terms: ComplexView<'a>,
}

/// A segment of a compressed band.
pub(super) struct Segment {
    /// Lines, by their numbers in the data, and the first in the band.
    lines: Range<usize>,
    offset: usize,
    /// Middle, as iω, and the distance from it within which a pole has an expansion point, rad/s.
    middle: Complex64,
    reach: f64,
    /// Frequencies at which smooth functions are evaluated, and the coordinates of their values:
    /// coordinates × nodes.
    nodes: Vec<f64>,
    from_nodes: ComplexMatrix,
    /// Whether the nodes are the lines, so that every pole is exact.
    is_on_lines: bool,
    /// Expansion points λ_0, the distance of each from the nearest line in decay rates, and the
    /// coordinates of its powers.
    expansion_points: Vec<Complex64>,
    line_distances: Vec<f64>,
    powers: ComplexMatrix,
    /// Weights that yield coordinates: lines × coordinates.
    weights: ComplexMatrix,
    /// Coordinates of the out-of-band terms of the band.
    pub out_of_band_terms: ComplexMatrix,
    /// Coordinates of the out-of-band terms of all lines.
    pub out_of_band_columns: ComplexMatrix,
    /// Coordinates of the measured values, by FRF.
    pub values: ComplexMatrix,
    /// Energy over the noise of the measured values that the coordinates do not have.
    pub energy_outside: f64,
}

impl Segment {
    /// A segment of the lines of a band that begins at `first`, with the profile of its noise.
    pub fn new(
        data: &FitData,
        profile: &BandProfile,
        first: usize,
        lines: Range<usize>,
        demand: &Demand,
    ) -> Self {
        let (middle, half_length) = middle(data, &lines);
        let mut segment = Self {
            offset: lines.start - first,
            lines,
            middle,
            reach: REACH * half_length,
            nodes: Vec::new(),
            from_nodes: zeros(0, 0),
            is_on_lines: false,
            expansion_points: Vec::new(),
            line_distances: Vec::new(),
            powers: zeros(0, 0),
            weights: zeros(0, 0),
            out_of_band_terms: zeros(0, 0),
            out_of_band_columns: zeros(0, 0),
            values: zeros(0, 0),
            energy_outside: 0.0,
        };
        segment.renew(data, profile, demand);
        segment
    }

    pub fn lines(&self) -> &Range<usize> {
        &self.lines
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.weights.ncols()
    }

    /// Whether every pole within reach is within the distance of an expansion point. The distance
    /// is that of a pole on the lines, in decay rates; off the lines the powers decrease with the
    /// distance over that from the nearest line.
    pub fn serves(&self, poles: &[Complex64], max_distance: f64) -> bool {
        let is_served = |lambda: &Complex64| {
            let is_close = |(point, offset): (usize, Complex64)| {
                offset.norm() <= max_distance * self.line_distances[point]
            };
            !self.is_expanded(*lambda) || self.expansion_of(*lambda).is_some_and(is_close)
        };
        poles.iter().all(is_served)
    }

    /// Takes new expansion points: those of the poles within reach.
    pub fn renew(&mut self, data: &FitData, profile: &BandProfile, demand: &Demand) {
        let near = demand.poles.iter().filter(|lambda| self.is_near(**lambda));
        let near: Vec<Complex64> = near.copied().collect();
        let ends = demand.end_terms.ncols();
        let columns = demand.polynomials + ends + POWERS * near.len();
        if columns < self.lines.len() {
            self.set_basis(data, profile, demand, near);
        } else {
            self.set_lines(data, profile);
        }
        let terms = demand
            .out_of_band_terms
            .subrows(self.offset, self.lines.len());
        self.out_of_band_terms = self.weights.adjoint() * terms;
        let columns = data.out_of_band_fit().columns();
        let columns = columns.subrows(self.lines.start, self.lines.len());
        self.out_of_band_columns = self.weights.adjoint() * columns;
        let values = &data.frfs.values;
        self.values = values.adjoint_product(&self.weights, self.lines.clone());
        let noise_profile = self.profile(profile).iter();
        let weights: Vec<f64> = noise_profile.map(|u| (u * u).recip()).collect();
        let outside = |f: usize| {
            let values = values.of(f, self.lines.clone());
            let values = values.iter().zip(&weights);
            let whole: f64 = values.map(|(h, weight)| h.norm_sqr() * weight).sum();
            let coordinates = self.values.col_as_slice(f).iter();
            let inside: f64 = coordinates.map(Complex64::norm_sqr).sum();
            (whole - inside) / profile.level[f].powi(2)
        };
        self.energy_outside = (0..self.values.ncols()).map(outside).sum();
    }

    /// Polynomials and powers as the basis.
    fn set_basis(
        &mut self,
        data: &FitData,
        profile: &BandProfile,
        demand: &Demand,
        near: Vec<Complex64>,
    ) {
        let omega = &data.frfs.omega[self.lines.clone()];
        let noise_profile = self.profile(profile);
        let half_length = self.reach / REACH;
        let (count, ends) = (demand.polynomials, demand.end_terms.ncols());
        let chebyshev = Chebyshev::new(self.middle.im, half_length, count);
        let angles = chebyshev.angles(omega);
        let powers = near_powers(data.frfs.line_shape, omega, &near);
        let columns = count + ends + powers.ncols();
        let value = |k: usize, c: usize| {
            let value = match c.checked_sub(count) {
                None => Chebyshev::value(c, angles[k]),
                Some(end) if end < ends => demand.end_terms[(k, end)],
                Some(column) => powers[(k, column - ends)],
            };
            value / noise_profile[k]
        };
        let qr = ThinQr::or_not_a_number(&linalg::complex_matrix(omega.len(), columns, value));
        let weights =
            linalg::complex_matrix(omega.len(), columns, |k, c| qr.q[(k, c)] / noise_profile[k]);
        let of_powers =
            linalg::complex_matrix(columns, powers.ncols(), |i, c| qr.r[(i, count + ends + c)]);
        self.from_nodes = qr.r.subcols(0, count) * chebyshev.coefficients();
        self.nodes = chebyshev.nodes();
        self.weights = weights;
        self.powers = of_powers;
        let line_distance = |lambda: &Complex64| {
            let square = |w: &f64| (Complex64::new(0.0, *w) - lambda).norm_sqr();
            let nearest = omega.iter().map(square).fold(f64::INFINITY, f64::min);
            nearest.sqrt() / lambda.re.abs()
        };
        self.line_distances = near.iter().map(line_distance).collect();
        self.expansion_points = near;
        self.is_on_lines = false;
    }

    /// The lines themselves as the basis, where there are few: every pole is evaluated on them.
    fn set_lines(&mut self, data: &FitData, profile: &BandProfile) {
        let noise_profile = self.profile(profile);
        let count = self.lines.len();
        let weights = linalg::complex_matrix(count, count, |i, j| match i == j {
            true => noise_profile[i].recip().into(),
            false => Complex64::ZERO,
        });
        self.nodes = data.frfs.omega[self.lines.clone()].to_vec();
        self.from_nodes = weights.clone();
        self.weights = weights;
        self.powers = zeros(count, 0);
        self.line_distances = Vec::new();
        self.expansion_points = Vec::new();
        self.is_on_lines = true;
    }

    /// Coordinates of `scale/(iω − λ)` (n = 1) or of its square (n = 2), by column.
    pub fn line_shapes(&self, shape: LineShape, poles: &[PoleColumn]) -> ComplexMatrix {
        let is_smooth = |pole: &PoleColumn| !self.is_expanded(pole.lambda);
        let smooth: Vec<usize> = (0..poles.len()).filter(|j| is_smooth(&poles[*j])).collect();
        let at_nodes = linalg::complex_matrix(self.nodes.len(), smooth.len(), |i, c| {
            let PoleColumn { lambda, scale, n } = poles[smooth[c]];
            shape.power(scale, self.nodes[i], lambda, n)
        });
        let of_smooth = &self.from_nodes * at_nodes;
        let mut columns = zeros(self.coordinates(), poles.len());
        for (c, j) in smooth.iter().enumerate() {
            columns.col_mut(*j).copy_from(of_smooth.col(c));
        }
        for (j, pole) in poles
            .iter()
            .enumerate()
            .filter(|(_, pole)| !is_smooth(pole))
        {
            let expansion = self.expansion_of(pole.lambda);
            let (point, offset) = expansion.expect("the segment follows the poles");
            let ratio = pole.scale / self.expansion_points[point].re.abs();
            for i in 0..self.coordinates() {
                let power = |n: usize| self.powers[(i, POWERS * point + n)];
                columns[(i, j)] = match pole.n {
                    1 => ratio * (power(0) + offset * (power(1) + offset * power(2))),
                    _ => ratio * ratio * (power(1) + 2.0 * offset * power(2)),
                };
            }
        }
        columns
    }

    fn is_near(&self, lambda: Complex64) -> bool {
        (lambda - self.middle).norm_sqr() < self.reach * self.reach
    }

    fn is_expanded(&self, lambda: Complex64) -> bool {
        !self.is_on_lines && self.is_near(lambda)
    }

    /// Number of the expansion point nearest to a pole, and ε.
    fn expansion_of(&self, lambda: Complex64) -> Option<(usize, Complex64)> {
        let offset = |point: &Complex64| match lambda - point {
            Complex64::ZERO => Complex64::ZERO,
            difference => difference / point.re.abs(),
        };
        let offsets = self.expansion_points.iter().map(offset).enumerate();
        offsets.min_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))
    }

    fn profile<'a>(&self, profile: &'a BandProfile) -> &'a [f64] {
        &profile.noise_profile[self.offset..][..self.lines.len()]
    }
}

/// A column of a fit: `scale/(iω − λ)` to the power n.
#[derive(Clone, Copy)]
pub(super) struct PoleColumn {
    pub lambda: Complex64,
    pub scale: f64,
    pub n: usize,
}

/// Middle of some lines, as iω, and half of their length, rad/s.
pub(super) fn middle(data: &FitData, lines: &Range<usize>) -> (Complex64, f64) {
    let (first, last) = (data.frfs.omega[lines.start], data.frfs.omega[lines.end - 1]);
    (
        Complex64::new(0.0, 0.5 * (first + last)),
        (0.5 * (last - first)).max(0.5 * data.frfs.step),
    )
}

/// Powers of the line shape at each expansion point: lines × powers of all.
fn near_powers(line_shape: LineShape, omega: &[f64], points: &[Complex64]) -> ComplexMatrix {
    let powers = |lambda: &Complex64| line_shape.powers(lambda.re.abs(), omega, *lambda, POWERS);
    let of_points: Vec<ComplexMatrix> = points.iter().map(powers).collect();
    linalg::complex_matrix(omega.len(), POWERS * points.len(), |k, column| {
        of_points[column / POWERS][(k, column % POWERS)]
    })
}

fn zeros(rows: usize, columns: usize) -> ComplexMatrix {
    linalg::complex_matrix(rows, columns, |_, _| Complex64::ZERO)
}
