//! Two tests on the lines around a peak detect a second mode under it.
//!
//! *Rank.* With the other modes subtracted, functions whitened by their noise, and constant and
//! slope in frequency projected off, one mode leaves a functions × lines matrix of rank one,
//! whatever its pole. Noise alone has a largest singular value near `√n + √L`. A second singular
//! value above that is a second shape, or FRFs that disagree on the frequency: a structure that
//! drifts during the test has the same effect as two modes a fraction of a half-power bandwidth
//! apart, and a single reference cannot separate the two causes.
//!
//! *Misfit.* Two modes of similar shape leave rank one, but not the frequency dependence of one
//! pole. Every FRF is fitted with `1/(iω − λ)`, its derivative `1/(iω − λ)²` (which absorbs a small
//! error of λ in each FRF, as mass loading by a moved sensor causes it), constant, slope and
//! curvature; the residual is compared with the noise by its chi-squared.
//!
//! Both must exceed the noise *and* a fraction of the resonance, because modes far outside the band
//! bend the out-of-band terms by some parts in a thousand of the peak, which shows where there is
//! little noise.

use num_complex::Complex64;

use crate::linalg::{self, LinalgError};

use crate::identify::data::peak_detection::noise_limit;

/// Maximum ratio of the second to the first singular value that modes far outside the band explain.
const MAX_SINGULAR_VALUE_RATIO: f64 = 0.02;
/// Maximum root mean square residual over the peak that modes far outside the band explain.
const MAX_RELATIVE_RESIDUAL: f64 = 0.002;
/// Factor on the largest singular value of noise, `√n + √L`, for its scatter and for the scatter of
/// the variances.
const NOISE_NORM_MARGIN: f64 = 1.3;
/// False-alarm probability of the misfit test, per mode.
const FALSE_ALARM_PROBABILITY: f64 = 1e-5;
/// Maximum number of lines, by averaging, before the singular values are taken.
const MAX_AVERAGED_LINES: usize = 64;

/// Value of a failed test, with the limit that one mode explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Excess {
    /// Value of the statistic.
    pub value: f64,
    /// Limit of the statistic.
    pub limit: f64,
}

/// Ratio of the second to the first singular value of the FRFs around one mode where it exceeds the
/// limit of one shape; `None` below, and for a single FRF.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub(in crate::identify) fn second_shape(
    values: &[Vec<Complex64>],
    variance: &[f64],
) -> Result<Option<Excess>, LinalgError> {
    let lines = values.first().map_or(0, Vec::len);
    let bin = lines.div_ceil(MAX_AVERAGED_LINES).max(1);
    let rows: Vec<Vec<Complex64>> = values
        .iter()
        .zip(variance)
        .map(|(row, v)| without_line(&averaged(row, bin, (bin as f64 / v).sqrt())))
        .collect();
    let (n, l) = (rows.len(), rows.first().map_or(0, Vec::len));
    if n < 2 || l < 4 {
        return Ok(None);
    }
    let matrix = linalg::complex_matrix(n, l, |f, k| rows[f][k]);
    let s = linalg::singular_values(&matrix)?;
    let noise = NOISE_NORM_MARGIN * (((n - 1) as f64).sqrt() + ((l - 3) as f64).sqrt());
    let excess = Excess {
        value: s[1] / s[0],
        limit: MAX_SINGULAR_VALUE_RATIO.max(noise / s[0]),
    };
    Ok((excess.value > excess.limit).then_some(excess))
}

fn averaged(row: &[Complex64], bin: usize, scale: f64) -> Vec<Complex64> {
    row.chunks_exact(bin)
        .map(|part| part.iter().sum::<Complex64>() * (scale / bin as f64))
        .collect()
}

/// A row without its mean and its slope.
fn without_line(row: &[Complex64]) -> Vec<Complex64> {
    let count = row.len() as f64;
    let x = |k: usize| k as f64 - 0.5 * (count - 1.0);
    let mean = row.iter().sum::<Complex64>() / count;
    let square: f64 = (0..row.len()).map(|k| x(k) * x(k)).sum();
    let slope = row
        .iter()
        .enumerate()
        .map(|(k, v)| x(k) * v)
        .sum::<Complex64>()
        / square;
    row.iter()
        .enumerate()
        .map(|(k, v)| v - mean - x(k) * slope)
        .collect()
}

/// Root mean square residual of one pole over the peak where it exceeds its limit; `None` below,
/// and with too few lines for the test.
pub(in crate::identify) fn second_pole(
    omega: &[f64],
    lambda: Complex64,
    residues: &[Complex64],
    values: &[Vec<Complex64>],
    variance: &[f64],
) -> Option<Excess> {
    const COLUMNS: usize = 5;
    if omega.len() < COLUMNS + 3 {
        return None;
    }
    let decay = -lambda.re;
    let span = omega[omega.len() - 1] - omega[0];
    let columns = linalg::complex_matrix(omega.len(), COLUMNS, |i, c| {
        let pole = decay / (Complex64::new(0.0, omega[i]) - lambda);
        let x = (omega[i] - lambda.im) / span;
        match c {
            0 => pole,
            1 => pole * pole,
            _ => Complex64::from(x.powi(c as i32 - 2)),
        }
    });
    let right = linalg::complex_matrix(omega.len(), values.len(), |i, f| values[f][i]);
    let residual = &right - &columns * linalg::least_squares(&columns, &right).ok()?;
    let energy: f64 = (0..values.len())
        .map(|f| residual.col(f).iter().map(Complex64::norm_sqr).sum::<f64>() / variance[f])
        .sum();
    let peak: f64 = residues
        .iter()
        .zip(variance)
        .map(|(a, v)| a.norm_sqr() / (decay * decay * v))
        .sum();
    let freedom = values.len() * (omega.len() - COLUMNS);
    let noise = 0.5 * noise_limit(freedom, 1, FALSE_ALARM_PROBABILITY);
    let relative_rms = |energy: f64| (energy / omega.len() as f64 / peak).sqrt();
    let excess = Excess {
        value: relative_rms(energy),
        limit: MAX_RELATIVE_RESIDUAL.max(relative_rms(noise)),
    };
    (excess.value > excess.limit).then_some(excess)
}
