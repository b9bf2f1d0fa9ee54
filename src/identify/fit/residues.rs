//! Residues of given poles, by linear least squares around each mode.
//!
//! Around mode `j` the receptance of one FRF is `A_j/(iω − λ_j) + Σ_near A_i/(iω − λ_i) + c_0 + c_1
//! (ω − ω_j)` plus the contributions of farther poles and of all conjugates. Constant and slope are
//! the local form of the mass line and the stiffness line, the modes below and above the band; the
//! coefficients are complex, so that the modes may be complex. Near poles, whose skirts the two
//! terms cannot represent, are fitted jointly; farther ones and the conjugates are subtracted with
//! the residues of the previous iteration (Jacobi). All FRFs have one matrix and one QR in common.

use std::borrow::Cow;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, RowProduct};

use crate::identify::data::band_frfs::BandFrfs;

/// Iterations of the subtraction; each gains the coupling of separate modes, a factor of ten or
/// more.
const ITERATIONS: usize = 6;
/// Change of the residues of a mode, over the largest of them, below which no further iteration is
/// needed.
const CONVERGED_CHANGE: f64 = 1e-9;
/// Maximum distance of poles that are fitted jointly, mean half-power bandwidths.
const JOINT_FIT_BANDWIDTHS: f64 = 6.0;

/// Residues, m/(N s), by mode, then by FRF, for poles λ (rad/s) with the lines around each.
pub(in crate::identify) fn residues(
    frfs: &BandFrfs,
    poles: &[Complex64],
    windows: &[Range<usize>],
) -> Vec<Vec<Complex64>> {
    let mut residues = vec![vec![Complex64::ZERO; frfs.functions()]; poles.len()];
    for _ in 0..ITERATIONS {
        let before = residues;
        residues = (0..poles.len())
            .into_par_iter()
            .map(|j| residues_of_one_mode(frfs, poles, &before, j, windows[j].clone()))
            .collect();
        if before.iter().zip(&residues).all(has_converged) {
            break;
        }
    }
    residues
}

/// Whether an iteration hardly changed the residues of a mode; never where one is no number.
fn has_converged((before, now): (&Vec<Complex64>, &Vec<Complex64>)) -> bool {
    let largest = now.iter().map(Complex64::norm_sqr).fold(0.0, f64::max);
    let limit = CONVERGED_CHANGE * CONVERGED_CHANGE * largest;
    let mut pairs = before.iter().zip(now);
    pairs.all(|(a, b)| (a - b).norm_sqr() <= limit)
}

/// `E|δA|²` of the residue of a single pole in white noise of unit variance, with constant and
/// slope fitted on the same lines.
pub(in crate::identify) fn variance_factor(omega: &[f64], lambda: Complex64) -> f64 {
    let qr = linalg::ThinQr::or_not_a_number(&pole_columns(omega, lambda, 3));
    let inverse = linalg::inverse_upper(&qr.r);
    let sum: f64 = (0..inverse.ncols())
        .map(|k| inverse[(0, k)].norm_sqr())
        .sum();
    sum * lambda.re * lambda.re
}

fn residues_of_one_mode(
    frfs: &BandFrfs,
    poles: &[Complex64],
    before: &[Vec<Complex64>],
    mode: usize,
    lines: Range<usize>,
) -> Vec<Complex64> {
    let together = jointly_fitted_modes(poles, mode, lines.len());
    let remaining = remainder(frfs, poles, before, &together, lines.clone());
    let first = lines.start;
    let omega = |i: usize| frfs.omega[first + i];
    let (center, span) = (poles[mode].im, omega(lines.len() - 1) - omega(0));
    let columns = linalg::complex_matrix(lines.len(), together.len() + 2, |i, c| {
        match together.get(c) {
            Some(j) => poles[*j].re.abs() / (Complex64::new(0.0, omega(i)) - poles[*j]),
            None if c == together.len() => Complex64::ONE,
            None => Complex64::from((omega(i) - center) / span),
        }
    });
    let right = linalg::complex_matrix(lines.len(), frfs.functions(), |i, f| remaining[f][i]);
    let solution = linalg::least_squares(&columns, &right)
        .unwrap_or_else(|_| linalg::not_a_number(columns.ncols(), right.ncols()));
    (0..frfs.functions())
        .map(|f| solution[(0, f)] * poles[mode].re.abs())
        .collect()
}

/// Residues of one mode by FRF with an individual frequency near that of `λ` for every FRF, for
/// FRFs that were measured one after the other while the frequency drifted (temperature, a moved
/// sensor): the column `1/(iω − λ)²` estimates the shift (Gauss-Newton), then the residue is fitted
/// at the shifted pole. The decay rate is common: the height of a resonance is determined far
/// better than its width.
pub(in crate::identify) fn residues_at_individual_frequencies(
    frfs: &BandFrfs,
    lambda: Complex64,
    residuals: &[Vec<Complex64>],
    lines: Range<usize>,
) -> Vec<Complex64> {
    let omega = &frfs.omega[lines];
    let fit_frf = |values: &Vec<Complex64>| {
        let values = std::slice::from_ref(values);
        let mut shifted = lambda;
        for _ in 0..ITERATIONS {
            let solution = one_pole(omega, values, shifted, 4);
            let shift = (solution[(3, 0)] / solution[(0, 0)]).im * lambda.re.abs();
            if shift.is_finite() {
                let shift = (shifted.im + shift - lambda.im).clamp(lambda.re, -lambda.re);
                shifted.im = lambda.im + shift;
            }
        }
        one_pole(omega, values, shifted, 3)[(0, 0)] * lambda.re.abs()
    };
    residuals.iter().map(fit_frf).collect()
}

/// Coefficients of `|σ|/(iω − λ)`, constant, slope and, as the fourth of `count`, `σ²/(iω − λ)²`; a
/// column for every FRF.
pub(in crate::identify) fn one_pole(
    omega: &[f64],
    values: &[Vec<Complex64>],
    lambda: Complex64,
    count: usize,
) -> ComplexMatrix {
    let columns = pole_columns(omega, lambda, count);
    let right = linalg::complex_matrix(omega.len(), values.len(), |i, f| values[f][i]);
    linalg::least_squares(&columns, &right)
        .unwrap_or_else(|_| linalg::not_a_number(columns.ncols(), right.ncols()))
}

/// The columns of [`one_pole`].
pub(in crate::identify) fn pole_columns(
    omega: &[f64],
    lambda: Complex64,
    count: usize,
) -> ComplexMatrix {
    let span = omega[omega.len() - 1] - omega[0];
    linalg::complex_matrix(omega.len(), count, |i, c| {
        let pole = lambda.re.abs() / (Complex64::new(0.0, omega[i]) - lambda);
        match c {
            0 => pole,
            1 => Complex64::ONE,
            2 => Complex64::from((omega[i] - lambda.im) / span),
            _ => pole * pole,
        }
    })
}

/// The mode itself, then the modes near it, nearest first, as many as the lines allow.
fn jointly_fitted_modes(poles: &[Complex64], mode: usize, lines: usize) -> Vec<usize> {
    let distance = |i: &usize| (poles[*i].im - poles[mode].im).abs();
    let width = |i: &usize| (poles[*i].re + poles[mode].re).abs();
    let mut near: Vec<usize> = (0..poles.len())
        .filter(|i| *i == mode || distance(i) < JOINT_FIT_BANDWIDTHS * width(i))
        .collect();
    near.sort_by(|a, b| {
        distance(a)
            .total_cmp(&distance(b))
            .then((*b == mode).cmp(&(*a == mode)))
    });
    near.truncate(lines.saturating_sub(5).max(1));
    near
}

/// The values of all FRFs on some lines minus the conjugate terms of all modes and the terms of all
/// modes except the kept ones.
pub(in crate::identify) fn remainder(
    frfs: &BandFrfs,
    poles: &[Complex64],
    residues: &[Vec<Complex64>],
    kept: &[usize],
    lines: Range<usize>,
) -> Vec<Vec<Complex64>> {
    let columns = linalg::complex_matrix(lines.len(), 2 * poles.len(), |i, column| {
        let lambda = poles[column / 2];
        let s = Complex64::new(0.0, frfs.omega[lines.start + i]);
        match column % 2 {
            0 if kept.contains(&(column / 2)) => Complex64::ZERO,
            0 => (s - lambda).inv(),
            _ => (s - lambda.conj()).inv(),
        }
    });
    let amplitudes = linalg::complex_matrix(2 * poles.len(), frfs.functions(), |row, f| {
        let residue = residues[row / 2][f];
        match row % 2 {
            0 => residue,
            _ => residue.conj(),
        }
    });
    let product = RowProduct {
        rows: lines,
        a: columns,
        c: Cow::Owned(amplitudes),
    };
    let copy = |_, _, values: &[Complex64], all: &mut Vec<Complex64>| all.extend_from_slice(values);
    frfs.values.subtract_products(&[product], copy)
}
