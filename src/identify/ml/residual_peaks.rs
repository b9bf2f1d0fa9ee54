//! What a fit leaves over beyond the noise, and roots to try there.

use num_complex::Complex64;

use crate::linalg;
use crate::modal::mac;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::{Root, resonates};
use crate::identify::data::residual::Rest;
use crate::identify::fit::detection_threshold::{norm_of_noise, upper_quantile};

/// Widest stretch of lines that is looked at, as a share of all.
const WIDEST: usize = 8;
/// Stretches that are tried must be so many of their lengths apart.
const CLEAR: usize = 4;

/// Distance of a pole from one that is there already, in decay rates, below which there is nothing
/// to try.
const SAME: f64 = 0.1;
/// And the likeness of participation factors above which.
const SAME_PARTICIPATION: f64 = 0.95;

/// Modes of one root that are tried together are at least this strong, relative to the strongest.
const ALIKE: f64 = 0.1;

/// A stretch of lines with more power than noise has.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    top: usize,
    width: usize,
    /// Power beyond that of noise, in its standard deviations.
    excess: f64,
}

/// Roots to try, at most so many: the highest of the smoothed power of what is left over (over the
/// noise of each function), where noise reaches it with less than this probability anywhere in the
/// band.
pub(in crate::identify) fn roots_to_try(
    (data, sides): (&Receptances, &Sides),
    roots: &[Root],
    rest: &Rest,
    (chance, most): (f64, usize),
) -> Vec<Root> {
    let functions = data.functions();
    let power = data.shared.held_by_line(data, rest);
    let stretches = stretches(&power, functions, (chance, data.correlation.alike()));
    let left = LeftOver {
        data,
        sides,
        rest,
        chance: chance / data.lines() as f64,
    };
    let root = |stretch: &Stretch| left.root(stretch, roots);
    stretches.iter().filter_map(root).take(most).collect()
}

struct LeftOver<'a> {
    data: &'a Receptances,
    sides: &'a Sides,
    rest: &'a Rest,
    /// Of a false alarm at one line.
    chance: f64,
}

impl LeftOver<'_> {
    /// A root for a stretch: at the pole of a root that is there already, with as many modes as
    /// noise does not explain and that root does not have, or else in the middle of the stretch.
    fn root(&self, stretch: &Stretch, roots: &[Root]) -> Option<Root> {
        let decay = 0.5 * stretch.width.max(2) as f64 * self.data.step;
        let middle = Complex64::new(-decay, self.data.omega[stretch.top]);
        let distance = |root: &&Root| (root.lambda - middle).norm();
        let there = roots
            .iter()
            .filter(|root| distance(root) < root.decay().max(decay));
        let there = there.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let more = there.and_then(|existing| {
            let most = self.room(existing.lambda, roots);
            self.root_at((existing.lambda, most), stretch, roots)
        });
        more.or_else(|| self.root_at((middle, 1), stretch, roots))
            .filter(|root| resonates(root.lambda))
    }

    /// Modes that a pole can have beside those that are there: inputs and outputs tell no more
    /// apart.
    fn room(&self, lambda: Complex64, roots: &[Root]) -> usize {
        let there = roots.iter().filter(|existing| same_pole(existing, lambda));
        let modes: usize = there.map(Root::multiplicity).sum();
        let most = self.sides.inputs.min(self.sides.outputs.len());
        most.saturating_sub(modes)
    }

    /// A root at a pole, of so many modes at most.
    fn root_at(
        &self,
        (lambda, most): (Complex64, usize),
        stretch: &Stretch,
        roots: &[Root],
    ) -> Option<Root> {
        let lines = stretch.top.saturating_sub(stretch.width)
            ..(stretch.top + stretch.width + 1).min(self.data.lines());
        let course = |k: usize| self.data.line_shape.pole(self.data.omega[k], lambda);
        let size = lines
            .clone()
            .map(|k| course(k).norm_sqr())
            .sum::<f64>()
            .sqrt();
        let amplitude = |f: usize| -> Complex64 {
            let matched = |k: usize| self.rest.at(f, k) * course(k).conj() / size;
            lines.clone().map(matched).sum()
        };
        let amplitudes: Vec<Complex64> = (0..self.data.functions()).map(amplitude).collect();
        let by_lines = self
            .data
            .correlation
            .of_amplitude(-lambda.re, self.data.step);
        let limit = by_lines.sqrt() * norm_of_noise(self.sides, self.chance);
        let strengths = linalg::singular_values(&self.sides.matrix(|f| amplitudes[f]));
        let strengths = strengths.unwrap_or_default();
        let limit = limit.max(ALIKE * strengths.first().copied().unwrap_or(0.0));
        let above = strengths.iter().filter(|s| **s > limit).count();
        let physical = |f: usize| amplitudes[f] * self.data.deviation(f, stretch.top);
        let mut parts = strongest_inputs(self.sides, above.max(1), physical);
        parts.retain(|part| !roots.iter().any(|existing| repeats(existing, lambda, part)));
        parts.truncate(most);
        let first = parts.first()?;
        let mut root = Root::single(lambda, first, self.data.functions());
        root.join(parts.split_off(1));
        Some(root)
    }
}

/// Whether a root has a pole and participation factors already.
fn repeats(existing: &Root, lambda: Complex64, part: &[Complex64]) -> bool {
    let alike = |other: &Vec<Complex64>| mac(other, part) > Some(SAME_PARTICIPATION);
    same_pole(existing, lambda) && existing.parts.iter().any(alike)
}

fn same_pole(existing: &Root, lambda: Complex64) -> bool {
    (existing.lambda - lambda).norm() < SAME * existing.decay()
}

/// Stretches of doubling widths that noise does not explain, the highest first, none near a higher
/// one.
///
/// Lines of correlated noise that count for one: `alike`.
fn stretches(power: &[f64], functions: usize, (chance, alike): (f64, f64)) -> Vec<Stretch> {
    let lines = power.len();
    let mut sums = vec![0.0; lines + 1];
    for (k, p) in power.iter().enumerate() {
        sums[k + 1] = sums[k] + p;
    }
    let mut found: Vec<Stretch> = Vec::new();
    let mut width = 1;
    while width <= lines / WIDEST {
        let freedom = 2 * functions * width;
        let independent = freedom as f64 / alike.min(width as f64);
        let limit =
            freedom as f64 / independent * upper_quantile(independent, chance / lines as f64);
        for start in (0..=lines - width).step_by(width.div_ceil(2)) {
            let value = 2.0 * (sums[start + width] - sums[start]);
            if value > limit {
                found.push(Stretch {
                    top: start + width / 2,
                    width,
                    excess: (value / freedom as f64 - 1.0) * (0.5 * independent).sqrt(),
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

/// Participation factors of the strongest so many parts of a value per function: right singular
/// vectors over the inputs.
pub(in crate::identify) fn strongest_inputs(
    sides: &Sides,
    count: usize,
    value: impl Fn(usize) -> Complex64,
) -> Vec<Vec<Complex64>> {
    let inputs = sides.inputs;
    let matrix = sides.matrix(value);
    let svd = linalg::singular_vectors(&matrix);
    let vector = |rank: usize| match &svd {
        // A = U S Vᴴ, so that the row space is that of conj(V).
        Ok(svd) if rank < svd.values.len() => {
            (0..inputs).map(|i| svd.right[(i, rank)].conj()).collect()
        }
        _ => vec![Complex64::ONE; inputs],
    };
    (0..count).map(vector).collect()
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::ml::residual_peaks::*;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    #[test]
    fn a_pole_is_tried_with_no_more_modes_than_inputs_tell_apart() {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.1,
            len: 1500,
        };
        let structure = Structure {
            modes: vec![(100.0, 0.01, vec![1.0, 0.6, -0.5, 0.3])],
        };
        let mut how = Measurement::of_sensors(4, axis);
        for i in 0..4 {
            how.pairs
                .push((how.pairs[i].0.clone(), how.pairs[1].0.clone()));
        }
        let set = structure.measured(&how);
        let data = Receptances::guarded(&set, Band::new(80.0, 120.0).unwrap()).unwrap();
        let sides = Sides::new(set.functions());
        assert_eq!(sides.inputs, 2);
        let lambda = Pole::from_frequency(100.0, 0.01).lambda;
        let fitted = Root::single(lambda, &[Complex64::ONE, Complex64::ZERO], set.len());
        // Beside a fit of one mode two independent ones stand out, far above the noise.
        let rest = linalg::complex_matrix(data.lines(), set.len(), |k, f| {
            let course = fitted.decay() / (Complex64::new(0.0, data.omega[k]) - lambda);
            1e3 * (1.0 + (f * f) as f64).sin() * course
        });
        let rest = Rest::of_all(rest);
        let tried = |roots: &[Root]| {
            let found = roots_to_try((&data, &sides), roots, &rest, (1e-3, 4));
            let at_pole = |root: &&Root| (root.lambda - lambda).norm() < 1e-9 * lambda.norm();
            found.iter().find(at_pole).map(Root::multiplicity)
        };
        assert_eq!(tried(std::slice::from_ref(&fitted)), Some(1));
        // None where both are there.
        let other = Root::single(lambda, &[Complex64::ZERO, Complex64::ONE], set.len());
        assert_eq!(tried(&[fitted.clone(), other]), None);
    }
}
