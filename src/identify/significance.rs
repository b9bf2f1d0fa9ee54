//! Whether a root is above what noise makes.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::roots::Root;
use super::sides::Sides;

/// Least probability whose complement differs from 1.
const LEAST_CHANCE: f64 = 1e-14;

/// Significance of a root with the limit that it must exceed to be above what noise makes for some participation factors, but
/// for the chance of a false alarm at one pole.
///
/// Whitened noise over outputs × inputs has a largest singular value below `√o + √i + √(−ln p)` but for a probability p
/// (Davidson and Szarek 2001); with one input its square is a chi-squared of two degrees of freedom per output.
pub(super) fn significance(root: &Root, sides: &Sides, chance: f64) -> (f64, f64) {
    let (outputs, inputs) = (sides.outputs.len(), sides.inputs);
    let limit = |outputs: usize, chance: f64| match inputs {
        1 => upper_quantile(2 * outputs, chance),
        _ => {
            let norm = (outputs as f64).sqrt() + (inputs as f64).sqrt() + (-chance.ln()).sqrt();
            2.0 * norm * norm
        }
    };
    let quality = &root.quality;
    let whole = (quality.significance, limit(outputs, chance));
    // What one output shows says nothing of how many modes there are.
    let alone = (quality.largest, limit(1, chance / outputs as f64));
    let better = alone.0 / alone.1 > whole.0 / whole.1;
    if better && root.multiplicity() == 1 {
        alone
    } else {
        whole
    }
}

/// What a chi-squared of so many degrees of freedom exceeds with this probability.
pub(super) fn upper_quantile(freedom: usize, chance: f64) -> f64 {
    let distribution = ChiSquared::new(freedom as f64);
    let chance = chance.max(LEAST_CHANCE);
    distribution.map_or(f64::INFINITY, |own| own.inverse_cdf(1.0 - chance))
}
