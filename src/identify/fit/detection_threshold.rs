//! Whether a root is above what noise makes.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::Root;

/// Least probability whose complement differs from 1.
const LEAST_CHANCE: f64 = 1e-14;

/// Significance of a root with the limit that it must exceed to be above what noise makes for some
/// participation factors, but for the chance of a false alarm at one pole.
///
/// Whitened noise over outputs × inputs has a largest singular value below `√o + √i + √(−ln p)` but
/// for a probability p (Davidson and Szarek 2001); with one input its square is a chi-squared of
/// two degrees of freedom per output.
pub(in crate::identify) fn significance(root: &Root, sides: &Sides, chance: f64) -> (f64, f64) {
    let outputs = sides.outputs.len();
    let quality = &root.quality;
    let whole = (quality.significance(), limit(root, sides, chance));
    // What one output shows says nothing of how many modes there are.
    let alone = (
        quality.largest,
        quality.by_lines * upper_quantile(2.0, chance / outputs as f64),
    );
    let better = alone.0 / alone.1 > whole.0 / whole.1;
    if better && root.multiplicity() == 1 {
        alone
    } else {
        whole
    }
}

/// Number of independent modes of a root that are above the noise.
pub(in crate::identify) fn modes_above_noise(root: &Root, sides: &Sides, chance: f64) -> usize {
    let limit = limit(root, sides, chance);
    root.quality
        .strengths
        .iter()
        .filter(|s| **s > limit)
        .count()
}

fn limit(root: &Root, sides: &Sides, chance: f64) -> f64 {
    let alone = match sides.inputs {
        1 => upper_quantile(2.0 * sides.outputs.len() as f64, chance),
        _ => 2.0 * norm_of_noise(sides, chance).powi(2),
    };
    root.quality.by_lines * alone
}

/// What the largest singular value of outputs × inputs of noise of unit variance exceeds with less
/// than this probability.
pub(in crate::identify) fn norm_of_noise(sides: &Sides, chance: f64) -> f64 {
    let (outputs, inputs) = (sides.outputs.len() as f64, sides.inputs as f64);
    outputs.sqrt() + inputs.sqrt() + (-chance.ln()).sqrt()
}

/// The same for noise of a deviation by output and input: the largest norms of a row and of a
/// column of deviations, and the largest deviation, take the places of `√i`, `√o` and 1 (Bandeira
/// and van Handel 2016, without their term of the logarithm of the size, which is small where
/// deviations are nearly even).
pub(in crate::identify) fn norm_of_uneven_noise(
    (outputs, inputs): (usize, usize),
    deviation: impl Fn(usize, usize) -> f64,
    chance: f64,
) -> f64 {
    let square = |o: usize, i: usize| deviation(o, i).powi(2);
    let row = |o: usize| (0..inputs).map(|i| square(o, i)).sum::<f64>();
    let column = |i: usize| (0..outputs).map(|o| square(o, i)).sum::<f64>();
    let largest = (0..outputs).flat_map(|o| (0..inputs).map(move |i| (o, i)));
    let largest = largest.map(|(o, i)| square(o, i)).fold(0.0, f64::max);
    let rows = (0..outputs).map(row).fold(0.0, f64::max);
    let columns = (0..inputs).map(column).fold(0.0, f64::max);
    rows.sqrt() + columns.sqrt() + (-chance.ln() * largest).sqrt()
}

/// What a chi-squared of so many degrees of freedom exceeds with this probability.
pub(in crate::identify) fn upper_quantile(freedom: f64, chance: f64) -> f64 {
    let distribution = ChiSquared::new(freedom);
    let chance = chance.max(LEAST_CHANCE);
    distribution.map_or(f64::INFINITY, |own| own.inverse_cdf(1.0 - chance))
}
