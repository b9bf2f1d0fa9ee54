//! Mode indicator functions, which show modes from the FRFs alone.
//!
//! With the receptances `R(ω)` as a matrix of responses × references (an FRF that was not measured
//! is 0):
//!
//! | indicator | definition | at a mode |
//! |---|---|---|
//! | sum of FRFs | `Σ ω |R|` over all FRFs: magnitudes of mobilities | a peak |
//! | NMIF | `1 − Σ |Re R| |R| / Σ |R|²` over all FRFs | near 1 |
//! | CMIF | singular values of `ω R`, descending, one per reference or response, whichever is fewer | the first peaks; several peak at a repeated root |
//! | MvMIF | eigenvalues of `Re RᵀRe R` against `Re RᵀRe R + Im RᵀIm R`, ascending, one per reference | the first falls towards 0; several fall at a repeated root |
//!
//! References: Allemang and Brown (2006), A complete review of the complex mode indicator function
//! (CMIF) with applications, ISMA; Williams, Crowley and Vold (1985), The multivariate mode
//! indicator function in modal analysis, IMAC 3.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::frf::{FrfSet, Function};
use crate::linalg::{self, ThinQr};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::prepare::{Chosen, chosen};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::IdentifyOptions;

/// Minimum diagonal entry of the triangle of a line, over its largest value, with which its
/// references are independent: the root of the roundoff, below which the squares of the smaller
/// singular values are rounding.
const MIN_DIAGONAL_RATIO: f64 = 1e-8;

/// Mode indicator functions on the lines of a band.
#[derive(Clone, Debug, PartialEq)]
pub struct Indicators {
    /// Frequency of each line, Hz.
    pub frequency_hz: Vec<f64>,
    /// Sum of the magnitudes of all FRFs as mobilities, m/(N s).
    pub sum_of_frfs: Vec<f64>,
    /// Normal mode indicator function, 0 to 1; `None` where all FRFs are 0.
    pub nmif: Vec<Option<f64>>,
    /// Complex mode indicator functions, m/(N s): the values of each line, descending.
    pub cmif: Vec<Vec<f64>>,
    /// Multivariate mode indicator functions, 0 to 1: the values of each line, ascending; `None`
    /// where the references do not differ enough.
    pub mvmif: Vec<Option<Vec<f64>>>,
}

/// The mode indicator functions of a set, in the band and for the references of the options.
///
/// # Errors
/// [`IdentifyError`] when set, band and references do not match, or singular values do not
/// converge.
pub fn indicators(set: &FrfSet, options: &IdentifyOptions) -> Result<Indicators, IdentifyError> {
    let Chosen { set, band, .. } = chosen(set, options)?;
    let set = set.as_ref();
    let data = BandFrfs::new(set, band)?;
    let matrix = Matrix::new(set);
    let mut indicators = Indicators {
        frequency_hz: Vec::with_capacity(data.lines()),
        sum_of_frfs: Vec::with_capacity(data.lines()),
        nmif: Vec::with_capacity(data.lines()),
        cmif: Vec::with_capacity(data.lines()),
        mvmif: Vec::with_capacity(data.lines()),
    };
    for (k, omega) in data.omega.iter().enumerate() {
        let line = (0..data.functions()).map(|f| data.values.at(f, k));
        let line: Vec<Complex64> = line.collect();
        indicators.frequency_hz.push(omega / std::f64::consts::TAU);
        let magnitudes = line.iter().map(|r| r.norm());
        indicators.sum_of_frfs.push(omega * magnitudes.sum::<f64>());
        indicators.nmif.push(nmif(&line));
        indicators.cmif.push(matrix.cmif(&line, *omega)?);
        indicators.mvmif.push(matrix.mvmif(&line));
    }
    Ok(indicators)
}

/// Complex mode indicator functions at some lines of a set's axis, none of them at 0 Hz, as in
/// [`Indicators::cmif`].
///
/// # Errors
/// [`IdentifyError::Linalg`] when singular values do not converge.
///
/// # Panics
/// When a line is not of the axis.
pub fn cmif_at(set: &FrfSet, lines: &[usize]) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let set = set.motions();
    let matrix = Matrix::new(&set);
    let at = |k: &usize| {
        let omega = set.axis().rad_s(*k);
        let s = Complex64::new(set.added_damping_rad_s, omega);
        let functions = set.functions().iter().enumerate();
        let receptance =
            |(i, f): (usize, &Function)| set.values(i)[*k] / s.powi(f.kind.derivative_order());
        let line: Vec<Complex64> = functions.map(receptance).collect();
        matrix.cmif(&line, omega)
    };
    lines.iter().map(at).collect()
}

/// `1 − Σ |Re R| |R| / Σ |R|²`.
fn nmif(line: &[Complex64]) -> Option<f64> {
    let power: f64 = line.iter().map(Complex64::norm_sqr).sum();
    let real: f64 = line.iter().map(|r| r.re.abs() * r.norm()).sum();
    (power > 0.0).then(|| 1.0 - real / power)
}

/// Position of each FRF in the matrix of responses × references.
struct Matrix {
    responses: usize,
    references: usize,
    positions: Vec<(usize, usize)>,
}

impl Matrix {
    fn new(set: &FrfSet) -> Self {
        let (responses, references) = (set.responses(), set.references());
        let index = |all: &[Dof], dof: &Dof| all.binary_search(dof).unwrap_or(0);
        let functions = set.functions().iter();
        let positions = functions.map(|f| {
            let row = index(&responses, &f.response);
            (row, index(&references, &f.reference))
        });
        Self {
            positions: positions.collect(),
            responses: responses.len(),
            references: references.len(),
        }
    }

    fn cmif(&self, line: &[Complex64], omega: f64) -> Result<Vec<f64>, IdentifyError> {
        let mut matrix =
            linalg::complex_matrix(self.responses, self.references, |_, _| Complex64::ZERO);
        for (position, value) in self.positions.iter().zip(line) {
            matrix[*position] += omega * value;
        }
        Ok(linalg::singular_values(&matrix)?)
    }

    fn mvmif(&self, line: &[Complex64]) -> Option<Vec<f64>> {
        // Scaled to the largest value, so that the square root of the smallest exceeds rounding.
        let largest = line.iter().map(|r| r.norm()).fold(0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        // [Re H; Im H] = Q R: the values are the squared singular values of the rows of Q that
        // belong to Re H.
        let (rows, columns) = (self.responses.max(self.references), self.references);
        let mut stacked = linalg::complex_matrix(2 * rows, columns, |_, _| Complex64::ZERO);
        for (&(row, column), value) in self.positions.iter().zip(line) {
            stacked[(row, column)] += value.re / largest;
            stacked[(rows + row, column)] += value.im / largest;
        }
        let ThinQr { q, r } = linalg::thin_qr(&stacked).ok()?;
        let diagonal = (0..columns).map(|j| r[(j, j)].norm());
        if diagonal.fold(f64::INFINITY, f64::min) < MIN_DIAGONAL_RATIO {
            return None;
        }
        let real = linalg::complex_matrix(rows, columns, |i, j| q[(i, j)]);
        let mut values = linalg::singular_values(&real).ok()?;
        values.reverse();
        Some(values.iter().map(|s| (s * s).min(1.0)).collect())
    }
}

#[cfg(test)]
mod tests {
    use crate::axis::FrequencyAxis;
    use crate::identify::mode_indicators::*;
    use crate::identify::synthetic::{Measurement, Structure};

    fn set_of(modes: Vec<(f64, f64, Vec<f64>)>, references: usize) -> FrfSet {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.1,
            len: 2001,
        };
        let mut how = Measurement::of_sensors(3, axis);
        let pairs = how.pairs.clone();
        for reference in 2..=references {
            let dof: Dof = format!("{reference}:+Z").parse().unwrap();
            how.pairs
                .extend(pairs.iter().map(|(r, _)| (r.clone(), dof.clone())));
        }
        Structure { modes }.measured(&how)
    }

    fn of(modes: Vec<(f64, f64, Vec<f64>)>, references: usize) -> (Indicators, FrequencyAxis) {
        let set = set_of(modes, references);
        let result = indicators(&set, &IdentifyOptions::default()).unwrap();
        (result, *set.axis())
    }

    #[test]
    fn single_lines_have_the_values_of_the_whole_band() {
        let modes = vec![(60.0, 0.01, vec![1.0, 0.5, -0.7])];
        let set = set_of(modes.clone(), 2);
        let (indicators, axis) = of(modes, 2);
        let lines = [600, 1300];
        for (line, values) in lines.iter().zip(cmif_at(&set, &lines).unwrap()) {
            let whole = &indicators.cmif[at(&indicators, axis.hz(*line))];
            for (a, b) in values.iter().zip(whole) {
                assert!((a - b).abs() <= 1e-12 * whole[0], "{a} {b}");
            }
        }
    }

    fn at(indicators: &Indicators, hz: f64) -> usize {
        let distance = |k: &usize| (indicators.frequency_hz[*k] - hz).abs();
        (0..indicators.frequency_hz.len())
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap()
    }

    #[test]
    fn every_indicator_shows_every_mode() {
        let modes = vec![
            (60.0, 0.01, vec![1.0, 0.5, -0.7]),
            (130.0, 0.01, vec![0.8, -0.9, 0.6]),
        ];
        let (indicators, _) = of(modes, 1);
        let between = at(&indicators, 90.0);
        for hz in [60.0, 130.0] {
            let k = at(&indicators, hz);
            assert!(indicators.nmif[k].unwrap() > 0.9 && indicators.nmif[between].unwrap() < 0.1);
            assert!(indicators.sum_of_frfs[k] > 5.0 * indicators.sum_of_frfs[between]);
            assert!(
                indicators.cmif[k].len() == 1
                    && indicators.cmif[k][0] > 5.0 * indicators.cmif[between][0]
            );
            let first = indicators.mvmif[k].as_ref().unwrap()[0];
            assert!(first < 0.1 && indicators.mvmif[between].as_ref().unwrap()[0] > 0.9);
        }
    }

    #[test]
    fn a_repeated_root_shows_in_two_values_of_cmif_and_mvmif() {
        let modes = vec![
            (60.0, 0.01, vec![1.0, 0.5, -0.7]),
            (60.0, 0.01, vec![0.3, -0.9, 0.6]),
            (130.0, 0.01, vec![0.8, -0.9, 0.6]),
        ];
        let (indicators, _) = of(modes, 2);
        let (double, single) = (at(&indicators, 60.0), at(&indicators, 130.0));
        let ratio = |k: usize| indicators.cmif[k][1] / indicators.cmif[k][0];
        assert!(ratio(double) > 0.1 && ratio(single) < 0.05);
        let second = |k: usize| indicators.mvmif[k].as_ref().unwrap()[1];
        assert!(second(double) < 0.1 && second(single) > 0.5);
        // A matrix of rank one, ψLᵀ, has the singular value |ψ||L|, and Σ|ψ|Σ|L| is its sum of
        // magnitudes; the second value bounds what the other modes change of that.
        let ratio = indicators.cmif[single][0] / indicators.sum_of_frfs[single];
        let norm = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
        let expected = norm(&[0.8, -0.9, 0.6]) * norm(&[0.8, -0.9]) / (2.3 * 1.7);
        let others = indicators.cmif[single][1] / indicators.cmif[single][0];
        assert!(
            (ratio / expected - 1.0).abs() < others,
            "{ratio} {expected}"
        );
    }

    #[test]
    fn values_of_one_reference_follow_from_their_definitions() {
        let line = [Complex64::new(3.0, 4.0), Complex64::new(0.0, -2.0)];
        // 1 − (3 · 5 + 0)/(25 + 4).
        assert!((nmif(&line).unwrap() - (1.0 - 15.0 / 29.0)).abs() < 1e-15);
        assert_eq!(nmif(&[Complex64::ZERO]), None);
        let matrix = Matrix {
            responses: 2,
            references: 1,
            positions: vec![(0, 0), (1, 0)],
        };
        let cmif = matrix.cmif(&line, 2.0).unwrap();
        assert!((cmif[0] - 2.0 * 29.0f64.sqrt()).abs() < 1e-12);
        // 9/(9 + 16 + 4).
        let mvmif = matrix.mvmif(&line).unwrap();
        assert!((mvmif[0] - 9.0 / 29.0).abs() < 1e-12);
    }
}
