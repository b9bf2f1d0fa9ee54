//! What a fit leaves over beyond the noise, and roots to try there.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use super::receptance::Receptances;
use super::roots::Root;
use super::sides::Sides;
use super::significance::upper_quantile;

/// Widest stretch of lines that is looked at, as a share of all.
const WIDEST: usize = 8;
/// Stretches that are tried must be so many of their lengths apart.
const CLEAR: usize = 4;

/// Distance of a pole from one that is there already, in decay rates, below which there is nothing to try.
const SAME: f64 = 0.1;

/// A stretch of lines with more power than noise has.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    top: usize,
    width: usize,
    /// Power beyond that of noise, in its standard deviations.
    excess: f64,
}

/// Roots to try, at most so many: the highest of the smoothed power of what is left over (over the level of each function's noise),
/// where noise reaches it with less than this probability anywhere in the band.
pub(super) fn roots_to_try(
    (data, sides): (&Receptances, &Sides),
    roots: &[Root],
    (rest, level): (&ComplexMatrix, &[f64]),
    (chance, most): (f64, usize),
) -> Vec<Root> {
    let functions = data.functions();
    let power: Vec<f64> = (0..data.lines())
        .map(|k| (0..functions).map(|f| rest[(k, f)].norm_sqr()).sum::<f64>())
        .collect();
    let mut stretches = stretches(&power, functions, chance);
    let new = |stretch: &Stretch| {
        let lambda = pole(data, stretch);
        let far = |root: &Root| (root.lambda - lambda).norm() > SAME * root.decay();
        roots.iter().all(far)
    };
    stretches.retain(new);
    stretches.truncate(most);
    let root = |stretch: &Stretch| {
        let lambda = pole(data, stretch);
        let row = |f: usize| rest[(stretch.top, f)] * level[f];
        let participation = &strongest_inputs(sides, 1, row)[0];
        Root::single(lambda, participation, functions)
    };
    stretches.iter().map(root).collect()
}

fn pole(data: &Receptances, stretch: &Stretch) -> Complex64 {
    let decay = 0.5 * stretch.width.max(2) as f64 * data.step;
    Complex64::new(-decay, data.omega[stretch.top])
}

/// Stretches of doubling widths that noise does not explain, the highest first, none near a higher one.
fn stretches(power: &[f64], functions: usize, chance: f64) -> Vec<Stretch> {
    let lines = power.len();
    let mut sums = vec![0.0; lines + 1];
    for (k, p) in power.iter().enumerate() {
        sums[k + 1] = sums[k] + p;
    }
    let mut found: Vec<Stretch> = Vec::new();
    let mut width = 1;
    while width <= lines / WIDEST {
        let freedom = 2 * functions * width;
        let limit = upper_quantile(freedom, chance / lines as f64);
        for start in (0..=lines - width).step_by(width.div_ceil(2)) {
            let value = 2.0 * (sums[start + width] - sums[start]);
            if value > limit {
                found.push(Stretch {
                    top: start + width / 2,
                    width,
                    excess: (value - freedom as f64) / (2.0 * freedom as f64).sqrt(),
                });
            }
        }
        width *= 2;
    }
    found.sort_by(|a, b| b.excess.total_cmp(&a.excess));
    let mut chosen: Vec<Stretch> = Vec::new();
    for stretch in found {
        let clear = |other: &Stretch| {
            let reach = stretch.width.max(other.width).max(2);
            stretch.top.abs_diff(other.top) > CLEAR * reach
        };
        if chosen.iter().all(clear) {
            chosen.push(stretch);
        }
    }
    chosen
}

/// Participation factors of the strongest so many parts of a value per function: right singular vectors over the inputs.
pub(super) fn strongest_inputs(
    sides: &Sides,
    count: usize,
    value: impl Fn(usize) -> Complex64,
) -> Vec<Vec<Complex64>> {
    let inputs = sides.inputs;
    let matrix = linalg::complex_matrix(sides.outputs.len(), inputs, |o, i| {
        value(sides.outputs[o][i].1)
    });
    let vector = |rank: usize| match linalg::singular_vectors(&matrix) {
        // A = U S Vᴴ, so that the row space is that of conj(V).
        Ok(svd) if rank < svd.values.len() => {
            (0..inputs).map(|i| svd.right[(i, rank)].conj()).collect()
        }
        _ => vec![Complex64::ONE; inputs],
    };
    (0..count).map(vector).collect()
}
