//! Detection threshold: the strength of a pole that noise alone exceeds with a given false-alarm
//! probability.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;

/// Minimum probability whose complement differs from 1.
const MIN_PROBABILITY: f64 = 1e-14;

/// Significance of a pole with the threshold that noise exceeds at one pole with the false-alarm
/// probability `false_alarm`, for some participation factors.
///
/// Whitened noise over outputs × inputs has a largest singular value below `√o + √i + √(−ln p)`
/// except with a probability p (Davidson and Szarek 2001); with one input its square is chi-squared
/// with two degrees of freedom per output.
pub(in crate::identify) fn significance(
    root: &ModelPole,
    frf_matrix: &FrfMatrix,
    false_alarm: f64,
) -> (f64, f64) {
    let outputs = frf_matrix.outputs.len();
    let quality = &root.quality;
    let whole = (quality.significance(), limit(root, frf_matrix, false_alarm));
    // A single output does not determine the number of modes.
    let one_output = (
        quality.largest,
        quality.amplitude_noise_factor * upper_quantile(2.0, false_alarm / outputs as f64),
    );
    let output_is_better = one_output.0 / one_output.1 > whole.0 / whole.1;
    if output_is_better && root.multiplicity() == 1 {
        one_output
    } else {
        whole
    }
}

/// Number of independent modes of a pole above the noise.
pub(in crate::identify) fn modes_above_noise(
    root: &ModelPole,
    frf_matrix: &FrfMatrix,
    false_alarm: f64,
) -> usize {
    let limit = limit(root, frf_matrix, false_alarm);
    root.quality
        .strengths
        .iter()
        .filter(|s| **s > limit)
        .count()
}

fn limit(root: &ModelPole, frf_matrix: &FrfMatrix, false_alarm: f64) -> f64 {
    let white = match frf_matrix.inputs {
        1 => upper_quantile(2.0 * frf_matrix.outputs.len() as f64, false_alarm),
        _ => 2.0 * noise_norm_quantile(frf_matrix, false_alarm).powi(2),
    };
    root.quality.amplitude_noise_factor * white
}

/// Value that the largest singular value of outputs × inputs of noise of unit variance exceeds with
/// at most this probability.
pub(in crate::identify) fn noise_norm_quantile(frf_matrix: &FrfMatrix, false_alarm: f64) -> f64 {
    let (outputs, inputs) = (frf_matrix.outputs.len() as f64, frf_matrix.inputs as f64);
    outputs.sqrt() + inputs.sqrt() + (-false_alarm.ln()).sqrt()
}

/// The same for noise with a standard deviation by output and input: the largest norms of a row and
/// of a column of standard deviations, and the largest one, replace `√i`, `√o` and 1 (Bandeira and
/// van Handel 2016, without their term of the logarithm of the size, which is small where standard
/// deviations are nearly equal).
pub(in crate::identify) fn uneven_noise_norm_quantile(
    outputs: usize,
    inputs: usize,
    deviation: impl Fn(usize, usize) -> f64,
    false_alarm: f64,
) -> f64 {
    let square = |o: usize, i: usize| deviation(o, i).powi(2);
    let row = |o: usize| (0..inputs).map(|i| square(o, i)).sum::<f64>();
    let column = |i: usize| (0..outputs).map(|o| square(o, i)).sum::<f64>();
    let largest = (0..outputs).flat_map(|o| (0..inputs).map(move |i| (o, i)));
    let largest = largest.map(|(o, i)| square(o, i)).fold(0.0, f64::max);
    let rows = (0..outputs).map(row).fold(0.0, f64::max);
    let columns = (0..inputs).map(column).fold(0.0, f64::max);
    rows.sqrt() + columns.sqrt() + (-false_alarm.ln() * largest).sqrt()
}

/// Value that chi-squared with `freedom` degrees of freedom exceeds with this probability.
pub(in crate::identify) fn upper_quantile(freedom: f64, false_alarm: f64) -> f64 {
    let distribution = ChiSquared::new(freedom);
    let false_alarm = false_alarm.max(MIN_PROBABILITY);
    distribution.map_or(f64::INFINITY, |chi_squared| {
        chi_squared.inverse_cdf(1.0 - false_alarm)
    })
}
