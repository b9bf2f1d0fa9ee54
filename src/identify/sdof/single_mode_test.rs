//! Is there one mode under a peak? Two tests on what the single-mode model leaves over in the lines
//! around it.
//!
//! *Rank.* With the other modes subtracted, functions whitened by their noise, and constant and
//! slope in frequency projected off, one mode leaves a functions × lines matrix of rank one,
//! whatever its pole. Noise alone has a largest singular value near `√n + √L`. A second singular
//! value above that is a second shape, or functions that disagree on the frequency: a test that
//! drifted while it was measured leaves the same trace as two modes a fraction of a half-power
//! width apart, and no single reference can tell them.
//!
//! *Misfit.* Two modes of similar shape leave rank one, but not the frequency dependence of one
//! pole. Every function is fitted with `1/(iω − λ)`, its derivative `1/(iω − λ)²` (a pole of its
//! own, so that a small error of λ or mass loading by a moved sensor does not count), constant,
//! slope and curvature; what is left is compared with the noise by its chi-squared.
//!
//! Both must exceed the noise *and* a share of the resonance, because far modes outside the band
//! bend the background by some parts in a thousand of the peak, which shows as soon as there is
//! little noise.

use num_complex::Complex64;

use crate::linalg::{self, LinalgError};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::peak_detection::noise_limit;
use crate::identify::sdof::estimator::Resonance;

/// Second over first singular value that far neighbours can explain.
const RANK_LIMIT: f64 = 0.02;
/// Root mean square misfit over peak that far neighbours can explain.
const MISFIT_LIMIT: f64 = 0.002;
/// Largest singular value of noise: room above `√n + √L` for its scatter and for the scatter of the
/// variances.
const NOISE_ROOM: f64 = 1.3;
/// False alarms of the misfit test per mode.
const FALSE_ALARM: f64 = 1e-5;
/// Lines are averaged to this many before the singular values are taken.
const MOST_LINES: usize = 64;

/// What a failed test found, with the most that one mode explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Excess {
    /// What was found.
    pub value: f64,
    /// What it was held against.
    pub limit: f64,
}

/// Second over first singular value of the values around one mode where it is too much for one
/// shape; `None` where it is not, and for a single function.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub(in crate::identify) fn second_shape(
    rest: &[Vec<Complex64>],
    variance: &[f64],
) -> Result<Option<Excess>, LinalgError> {
    let lines = rest.first().map_or(0, Vec::len);
    let bin = lines.div_ceil(MOST_LINES).max(1);
    let rows: Vec<Vec<Complex64>> = rest
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
    let noise = NOISE_ROOM * (((n - 1) as f64).sqrt() + ((l - 3) as f64).sqrt());
    let excess = Excess {
        value: s[1] / s[0],
        limit: RANK_LIMIT.max(noise / s[0]),
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

/// Misfit of one pole over the peak, for the values around one mode where it is too much; `None`
/// where it is not, and with too few lines to judge.
pub(in crate::identify) fn second_pole(
    data: &Receptances,
    resonance: &Resonance,
    residues: &[Complex64],
    (rest, variance): (&[Vec<Complex64>], &[f64]),
) -> Option<Excess> {
    const COLUMNS: usize = 5;
    let omega = &data.omega[resonance.lines.clone()];
    if omega.len() < COLUMNS + 3 {
        return None;
    }
    let (lambda, decay) = (resonance.lambda, -resonance.lambda.re);
    let reach = omega[omega.len() - 1] - omega[0];
    let columns = linalg::complex_matrix(omega.len(), COLUMNS, |i, c| {
        let pole = decay / (Complex64::new(0.0, omega[i]) - lambda);
        let x = (omega[i] - lambda.im) / reach;
        match c {
            0 => pole,
            1 => pole * pole,
            _ => Complex64::from(x.powi(c as i32 - 2)),
        }
    });
    let right = linalg::complex_matrix(omega.len(), rest.len(), |i, f| rest[f][i]);
    let left_over = &right - &columns * linalg::least_squares(&columns, &right).ok()?;
    let energy: f64 = (0..rest.len())
        .map(|f| {
            left_over
                .col(f)
                .iter()
                .map(Complex64::norm_sqr)
                .sum::<f64>()
                / variance[f]
        })
        .sum();
    let peak: f64 = residues
        .iter()
        .zip(variance)
        .map(|(a, v)| a.norm_sqr() / (decay * decay * v))
        .sum();
    let freedom = rest.len() * (omega.len() - COLUMNS);
    let noise = 0.5 * noise_limit(freedom, 1, FALSE_ALARM);
    let share = |energy: f64| (energy / omega.len() as f64 / peak).sqrt();
    let excess = Excess {
        value: share(energy),
        limit: MISFIT_LIMIT.max(share(noise)),
    };
    (excess.value > excess.limit).then_some(excess)
}
