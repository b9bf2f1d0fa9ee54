//! Basis functions of the out-of-band terms: the contribution of modes outside a range of lines, in
//! any mixture in every FRF.
//!
//! Constant and slope represent modes that are farther from the range than its length. Where the
//! range ends with the data, modes outside can be arbitrarily near and unobserved: poles clustered
//! towards that end represent them, at distances from the end that double from pole to pole and
//! equally far from the axis (rational approximation with clustered poles converges exponentially
//! in their number: Gopal and Trefethen 2019, SIAM J. Numer. Anal. 57(5)).

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ThinQr};

/// Distance of the nearest pole from the end, lines.
const NEAREST_POLE_LINES: f64 = 1.5;
/// Ratio of the distances of successive poles.
const DISTANCE_RATIO: f64 = 2.0;
/// Distance of the farthest pole, in lengths of the range.
const FARTHEST_POLE_LENGTHS: f64 = 1.0;

/// Columns of every basis: constant and slope.
pub(in crate::identify) const MIN_OUT_OF_BAND_COLUMNS: usize = 2;
/// Minimum number of lines for each pole.
const MIN_LINES_PER_POLE: usize = 3;

/// Model of the modes outside the lines of a band.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) enum OutOfBandTerms {
    /// Unconstrained: they may lie anywhere.
    Anywhere,
    /// Their contribution has these basis functions; none where the data show no such modes.
    BasisFunctions(Vec<OutOfBandTerm>),
}

/// Out-of-band term: a rank-one contribution of modes outside the lines, common to all FRFs.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct OutOfBandTerm {
    /// Basis function: one value per line.
    pub values: Vec<Complex64>,
    /// Amplitude in each FRF, over its noise: a vector of length 1.
    pub frf_amplitudes: Vec<Complex64>,
}

/// Basis of the out-of-band terms on a range of lines.
#[derive(Clone, Debug)]
pub(in crate::identify) struct OutOfBandBasis<'a> {
    poles: Vec<Complex64>,
    /// Basis functions on the lines of the range.
    functions: Vec<&'a [Complex64]>,
}

impl<'a> OutOfBandBasis<'a> {
    /// Basis for lines of a band that has `omega` in all. Modes outside the band count where the
    /// range ends with the band.
    pub fn new(omega: &[f64], lines: &Range<usize>, outside: &'a OutOfBandTerms) -> Self {
        let (below, above) = (lines.start == 0, lines.end == omega.len());
        match outside {
            OutOfBandTerms::Anywhere => Self {
                poles: clustered(omega, lines, below, above),
                functions: Vec::new(),
            },
            OutOfBandTerms::BasisFunctions(functions) => {
                let terms = functions.iter().filter(|_| below || above);
                Self {
                    poles: Vec::new(),
                    functions: terms.map(|term| &term.values[lines.clone()]).collect(),
                }
            }
        }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        MIN_OUT_OF_BAND_COLUMNS + self.poles.len() + self.functions.len()
    }

    /// Value of a column at a line of the range.
    pub fn value(&self, column: usize, omega: &[f64], k: usize) -> Complex64 {
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        match column {
            0 => Complex64::ONE,
            1 => Complex64::from((2.0 * omega[k] - first - last) / (last - first)),
            _ => match self.poles.get(column - MIN_OUT_OF_BAND_COLUMNS) {
                Some(pole) => pole.re.abs() / (Complex64::new(0.0, omega[k]) - pole),
                None => self.functions[column - MIN_OUT_OF_BAND_COLUMNS - self.poles.len()][k],
            },
        }
    }

    /// Orthonormal columns, divided by the profile of the noise.
    pub fn basis(&self, omega: &[f64], noise_profile: &[f64]) -> ComplexMatrix {
        let columns = linalg::complex_matrix(omega.len(), self.columns(), |k, c| {
            self.value(c, omega, k) / noise_profile[k]
        });
        ThinQr::or_not_a_number(&columns).q
    }
}

/// Poles clustered towards those ends of a range that are ends of the band.
fn clustered(omega: &[f64], lines: &Range<usize>, below: bool, above: bool) -> Vec<Complex64> {
    let step = omega[1] - omega[0];
    // Few lines cannot determine many poles.
    let max_columns = lines.len() / MIN_LINES_PER_POLE;
    let length = FARTHEST_POLE_LENGTHS * lines.len() as f64 * step;
    let mut poles = Vec::new();
    let mut distance = NEAREST_POLE_LINES * step;
    while distance < length && poles.len() + MIN_OUT_OF_BAND_COLUMNS <= max_columns {
        if below {
            poles.push(Complex64::new(-distance, omega[0] - distance));
        }
        if above {
            poles.push(Complex64::new(-distance, omega[omega.len() - 1] + distance));
        }
        distance *= DISTANCE_RATIO;
    }
    poles
}
