//! The roots of a fit: poles with participation factors, and the residues that belong to them.

use num_complex::Complex64;

/// Residues are found so often before a pole moves: neighbours that lean on each other know each
/// other's by then.
const FRESH: u8 = 2;

/// Damping ratio from which on a pole is no resonance any more: what it would explain is
/// background.
const MOST_DAMPING: f64 = 0.3;
/// Damping ratio that no step of a fit exceeds: wide roots overlap all others and take their place.
const LARGEST_DAMPING: f64 = 0.5;
/// A factor this many times the pivot's takes its place.
const OUTGROWN: f64 = 2.0;

/// One root of the model: a pole that one mode or several share.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Root {
    /// λ as in the data, rad/s.
    pub lambda: Complex64,
    /// Participation factors of each of its modes: one value per input, 1 at the mode's own pivot
    /// and 0 at the pivots of the others.
    pub parts: Vec<Vec<Complex64>>,
    /// Input that is 1 for each mode.
    pub pivots: Vec<usize>,
    /// Residue of each function, m/(N s).
    pub residues: Vec<Complex64>,
    /// `E|δA|²` of each in white noise but for a factor that all have in common, m²/(N s)²; empty
    /// for a root that was not fitted yet.
    pub residue_variances: Vec<f64>,
    /// How well it is known.
    pub quality: Quality,
    /// How far its fit is.
    pub progress: Progress,
    /// Whether something speaks against its being a mode.
    pub suspect: bool,
    /// Whether it describes the amplitude dependence of another ([`companions`](crate::identify::ml::amplitude_dependence))
    /// and is no mode.
    pub is_companion: bool,
    /// Number that it shares with the root beside it from which it was told by what one alone
    /// leaves over.
    pub pair: Option<u32>,
}

/// What a fit says of one root besides its numbers.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Quality {
    /// Cramér-Rao deviation of real and of imaginary part of λ, rad/s, in noise that is white over
    /// the lines and every function's own.
    pub pole_bound: f64,
    /// The same in the noise that there is.
    pub pole_std: f64,
    /// From the pole to the maximum of the likelihood as a Gauss-Newton step sees it, rad/s, for
    /// one that stays where it was put.
    pub offset: Complex64,
    /// Error that what lies outside the lines leaves in λ as far as the data tell, rad/s; `None`
    /// where anything may lie there.
    pub bias: Option<Complex64>,
    /// `2 Σ|ψ|²/var ψ` over outputs of each independent combination of its modes, ascending:
    /// chi-squared of two degrees of freedom per output where there is no mode.
    pub strengths: Vec<f64>,
    /// Participation factors of these combinations.
    pub combinations: Vec<Vec<Complex64>>,
    /// The largest of one output.
    pub largest: f64,
    /// Factor by which noise that hangs together over the lines, or that functions share, raises
    /// both where there is no mode.
    pub by_lines: f64,
}

/// Whether a pole makes a resonance.
pub(in crate::identify) fn resonates(lambda: Complex64) -> bool {
    -lambda.re < MOST_DAMPING * lambda.norm()
}

/// Whether a fit may put a pole there.
pub(in crate::identify) fn in_reach(lambda: Complex64) -> bool {
    lambda.re < 0.0 && -lambda.re < LARGEST_DAMPING * lambda.norm()
}

impl Quality {
    /// Of a root that was not fitted yet.
    pub const UNKNOWN: Self = Self {
        pole_bound: f64::INFINITY,
        pole_std: f64::INFINITY,
        offset: Complex64::ZERO,
        bias: None,
        strengths: Vec::new(),
        combinations: Vec::new(),
        largest: 0.0,
        by_lines: 1.0,
    };

    /// How far λ may be from where it belongs, rad/s: what noise does, and how far it was left from
    /// its place.
    pub fn pole_error(&self) -> f64 {
        self.pole_std.hypot(self.offset.norm())
    }

    /// Strength of the weakest combination of modes.
    pub fn significance(&self) -> f64 {
        self.strengths.first().copied().unwrap_or(0.0)
    }
}

/// How far the fit of a root is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Progress {
    /// Its residues must be found this many times before its pole moves.
    Fresh(u8),
    /// It moves.
    Moving,
    /// It stays where it is.
    Settled,
}

/// Participation factors of combinations of modes.
pub(in crate::identify) fn combined(
    parts: &[Vec<Complex64>],
    combinations: &[Vec<Complex64>],
) -> Vec<Vec<Complex64>> {
    let inputs = parts.first().map_or(0, Vec::len);
    let factor = |combination: &[Complex64], input: usize| -> Complex64 {
        let terms = combination.iter().zip(parts);
        terms.map(|(c, part)| c * part[input]).sum()
    };
    let one = |combination: &Vec<Complex64>| {
        (0..inputs)
            .map(|input| factor(combination, input))
            .collect()
    };
    combinations.iter().map(one).collect()
}

impl Root {
    /// A root of one mode, scaled to 1 at its largest factor.
    pub fn single(lambda: Complex64, participation: &[Complex64], functions: usize) -> Self {
        let size = |i: &usize| participation[*i].norm();
        let pivot = (0..participation.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let pivot = pivot.unwrap_or(0);
        let scale = participation[pivot].inv();
        Self {
            lambda,
            parts: vec![participation.iter().map(|l| l * scale).collect()],
            pivots: vec![pivot],
            residues: vec![Complex64::ZERO; functions],
            residue_variances: Vec::new(),
            quality: Quality::UNKNOWN,
            progress: Progress::Fresh(FRESH),
            suspect: false,
            is_companion: false,
            pair: None,
        }
    }

    /// Number of its modes.
    pub fn multiplicity(&self) -> usize {
        self.parts.len()
    }

    /// Decay rate −Re λ, rad/s.
    pub fn decay(&self) -> f64 {
        -self.lambda.re
    }

    /// Half-power width, rad/s.
    pub fn width(&self) -> f64 {
        2.0 * self.lambda.re.abs()
    }

    /// The inputs whose factors are free: those that are no pivot.
    pub fn free_inputs(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts[0].len()).filter(|input| !self.pivots.contains(input))
    }

    /// Takes in the modes of another root: a basis of all participation factors with 1 at pivots of
    /// its own.
    pub fn join(&mut self, parts: Vec<Vec<Complex64>>) {
        self.parts.extend(parts);
        self.residues.fill(Complex64::ZERO);
        self.refresh();
        self.reduce();
    }

    /// Its residues are to be found anew before its pole moves.
    pub fn refresh(&mut self) {
        self.progress = Progress::Fresh(FRESH);
    }

    /// Keeps so many of its modes: the strongest combinations or, where these are not known, the
    /// first.
    pub fn keep_strongest(&mut self, count: usize) {
        let mut parts = std::mem::take(&mut self.parts);
        let known = &mut self.quality.combinations;
        if known.len() == parts.len() {
            parts = known.split_off(known.len() - count);
        } else {
            parts.truncate(count);
        }
        self.join(parts);
    }

    /// Pivots at the largest factors again, when others have grown beyond them.
    pub fn choose_pivots(&mut self) {
        let outgrown = |part: &Vec<Complex64>| part.iter().any(|l| l.norm() > OUTGROWN);
        if self.parts.iter().any(outgrown) {
            self.reduce();
        }
    }

    /// Gauss-Jordan elimination with full pivoting: each part 1 at its pivot and 0 at those of the
    /// others; parts without anything of their own go.
    fn reduce(&mut self) {
        let inputs = self.parts[0].len();
        self.pivots.clear();
        let mut done = 0;
        while done < self.parts.len() {
            let places = (done..self.parts.len()).flat_map(|p| (0..inputs).map(move |i| (p, i)));
            let free = places.filter(|(_, i)| !self.pivots.contains(i));
            let size = |(p, i): &(usize, usize)| self.parts[*p][*i].norm();
            let best = free.max_by(|a, b| size(a).total_cmp(&size(b)));
            let Some((row, input)) = best.filter(|place| size(place) > 1e-9) else {
                self.parts.truncate(done);
                break;
            };
            self.parts.swap(done, row);
            let scale = self.parts[done][input].inv();
            self.parts[done].iter_mut().for_each(|l| *l *= scale);
            let pivot = self.parts[done].clone();
            for (other, part) in self.parts.iter_mut().enumerate() {
                if other != done {
                    let factor = part[input];
                    part.iter_mut()
                        .zip(&pivot)
                        .for_each(|(l, own)| *l -= factor * own);
                }
            }
            self.pivots.push(input);
            done += 1;
        }
    }
}
