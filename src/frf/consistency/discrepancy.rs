//! The difference of two functions that should be equal is compared with their noise.

use num_complex::Complex64;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::finding::{Code, Finding, Severity};

use super::driving_point::CLEAR_PEAK_OVER_NOISE;
use super::mobility::Mobilities;
use crate::frf::peaks::clear_peaks;

/// Probability that noise alone is taken for a difference: a set of a hundred pairs is then wrong
/// once in a hundred.
const FALSE_ALARM_PROBABILITY: f64 = 1e-4;

/// The relative difference of two functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference {
    /// `sqrt((Σ|a − b|² − Σ(v_a + v_b)) / (½ Σ(|a|² + |b|²)))`, 0 when noise explains all of it.
    pub relative: f64,
    /// The same of the largest sum that noise makes.
    pub of_noise: f64,
}

/// Over all lines of the band, as the kind of `a`, in which its noise was measured.
///
/// One number for what a frequency response assurance criterion and an amplitude ratio `r` say: of
/// functions that are proportional it is `|1 − r|√(2/(1 + r²))`; of equal energies and a real
/// product, `√(2(1 − √FRAC))`. Two signs give 2. The sum of squares of noise is near `Σv` times an
/// F of `2N` and `2N(n − 1)` degrees of freedom, `n` averages, `N = (Σv)²/Σv²` lines that hold the
/// noise (the match of mean and variance of Welch and Satterthwaite).
pub(super) fn difference(data: &Mobilities, a: usize, b: usize) -> Difference {
    let kind = data.functions()[a].kind;
    let (of_a, of_b) = (data.values_as(a, kind), data.values_as(b, kind));
    let (mut apart, mut energy) = (0.0, 0.0);
    for (a, b) in of_a.iter().zip(&of_b) {
        apart += (a - b).norm_sqr();
        energy += 0.5 * (a.norm_sqr() + b.norm_sqr());
    }
    let (mut mean, mut square) = (0.0, 0.0);
    let variances = data.variance_as(a, kind).into_iter();
    for (a, b) in variances.zip(data.variance_as(b, kind)) {
        mean += a + b;
        square += (a + b) * (a + b);
    }
    let relative = |sum: f64| {
        if energy > 0.0 {
            (sum.max(0.0) / energy).sqrt()
        } else {
            0.0
        }
    };
    let averages = data.averages(a).min(data.averages(b));
    let beyond = mean * (noise_quantile(mean * mean / square, averages) - 1.0);
    Difference {
        relative: relative(apart - mean),
        of_noise: if mean > 0.0 { relative(beyond) } else { 0.0 },
    }
}

/// The quantile of F that noise passes by chance.
fn noise_quantile(lines: f64, averages: f64) -> f64 {
    let freedom = 2.0 * lines;
    let ratio = FisherSnedecor::new(freedom, freedom * (averages - 1.0));
    ratio.map_or(f64::INFINITY, |f| {
        f.inverse_cdf(1.0 - FALSE_ALARM_PROBABILITY)
    })
}

/// Relative difference at clear resonances that no calibration makes.
const MAX_CALIBRATION_DIFFERENCE: f64 = 0.3;
/// Lines between the half-power points of a resonance at which functions are compared.
const MIN_LINES_PER_BANDWIDTH: f64 = 3.0;

/// A finding about function `b` when it differs from `a` grossly at the clear peaks of `a`'s
/// mobility.
pub(super) fn gross_difference_finding(
    data: &Mobilities,
    a: usize,
    b: usize,
    code: Code,
) -> Option<Finding> {
    let (of_a, of_b) = (data.values(a), data.values(b));
    let power: Vec<f64> = of_a.iter().map(Complex64::norm_sqr).collect();
    let floor: Vec<f64> = data
        .noise(a)
        .iter()
        .map(|noise| CLEAR_PEAK_OVER_NOISE * noise)
        .collect();
    let (mut apart, mut energy) = (0.0, 0.0);
    for peak in clear_peaks(&power, &floor, MIN_LINES_PER_BANDWIDTH) {
        for k in peak.inside() {
            apart += (of_a[k] - of_b[k]).norm_sqr();
            energy += 0.5 * (of_a[k].norm_sqr() + of_b[k].norm_sqr());
        }
    }
    let relative = (apart / energy).sqrt();
    (relative > MAX_CALIBRATION_DIFFERENCE).then(|| {
        Finding::new(Severity::Warning, code, data.location(b))
            .value(relative, "")
            .limit(MAX_CALIBRATION_DIFFERENCE)
    })
}

/// A finding about function `b` when it differs from `a` by more than a stated limit and more than
/// noise does.
pub(super) fn difference_finding(
    data: &Mobilities,
    a: usize,
    b: usize,
    code: Code,
    limit: f64,
) -> Option<Finding> {
    let difference = difference(data, a, b);
    let limit = limit.max(difference.of_noise);
    (difference.relative > limit).then(|| {
        Finding::new(Severity::Warning, code, data.location(b))
            .value(difference.relative, "")
            .limit(limit)
    })
}
