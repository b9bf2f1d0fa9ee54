//! Poles of the fitted model, with participation factors and residues.

use num_complex::Complex64;

/// Number of residue estimates before a pole iterates: residues of neighbours that depend on each
/// other have converged by then.
const RESIDUE_ESTIMATES: u8 = 2;

/// Damping ratio above which a pole is no resonance: it represents out-of-band terms.
const MAX_RESONANCE_DAMPING_RATIO: f64 = 0.3;
/// Maximum damping ratio of any step of a fit: wider poles overlap all others and replace them.
const MAX_STEP_DAMPING_RATIO: f64 = 0.5;
/// Participation factor, over that of the pivot, above which its input becomes the pivot.
const MAX_FACTOR_OVER_PIVOT: f64 = 2.0;

/// Pole of the model, of one mode or of several.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct ModelPole {
    /// λ as in the data, rad/s.
    pub lambda: Complex64,
    /// Participation factors of each of its modes: one value per input, 1 at the mode's own pivot
    /// and 0 at the pivots of the others.
    pub parts: Vec<Vec<Complex64>>,
    /// Input that is 1 for each mode.
    pub pivots: Vec<usize>,
    /// Residue of each FRF, m/(N s).
    pub residues: Vec<Complex64>,
    /// `E|δA|²` of each in white noise, except for a factor common to all, m²/(N s)²; empty for a
    /// pole that was not fitted yet.
    pub residue_variances: Vec<f64>,
    /// Uncertainty and significance.
    pub quality: PoleQuality,
    /// State of its iteration.
    pub progress: FitState,
    /// Whether a criterion indicates that it is no mode.
    pub suspect: bool,
    /// Whether a peak of the FRFs and its recurrence over model orders show that it is a mode
    /// ([`peak_columns`](crate::identify::mdof::peak_columns)).
    pub is_peak_column: bool,
    /// Whether it describes the amplitude dependence of another pole and is no mode
    /// ([`companions`](crate::identify::ml::amplitude_dependence)).
    pub is_companion: bool,
    /// Number shared with the close pole from which it was separated by the residual of a fit of
    /// one pole for both.
    pub pair: Option<u32>,
}

/// Uncertainty and significance of a pole.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct PoleQuality {
    /// Cramér-Rao standard deviation of the real and of the imaginary part of λ, rad/s, in noise
    /// that is white over the lines and independent between FRFs.
    pub pole_bound: f64,
    /// The same in the estimated noise, with its line correlation and its force noise.
    pub pole_std: f64,
    /// From the pole to the maximum of the likelihood as a Gauss-Newton step predicts it, rad/s,
    /// for a pole that is kept fixed.
    pub offset: Complex64,
    /// Error of λ by the modes outside the lines as far as the data determine it, rad/s; `None`
    /// where the out-of-band model is unconstrained.
    pub bias: Option<Complex64>,
    /// `2 Σ|ψ|²/var ψ` over outputs of each independent combination of its modes, ascending:
    /// without a mode chi-squared with two degrees of freedom per output.
    pub strengths: Vec<f64>,
    /// Participation factors of these combinations.
    pub combinations: Vec<Vec<Complex64>>,
    /// The largest term of one output.
    pub largest: f64,
    /// Factor by which line correlation and force noise raise `strengths` and the square of
    /// `largest` where there is no mode.
    pub amplitude_noise_factor: f64,
}

/// Whether the damping ratio of a pole is that of a resonance.
pub(in crate::identify) fn is_resonance(lambda: Complex64) -> bool {
    -lambda.re < MAX_RESONANCE_DAMPING_RATIO * lambda.norm()
}

/// Whether a step of a fit may move a pole there.
pub(in crate::identify) fn is_allowed_pole(lambda: Complex64) -> bool {
    lambda.re < 0.0 && -lambda.re < MAX_STEP_DAMPING_RATIO * lambda.norm()
}

impl PoleQuality {
    /// Of a pole that was not fitted yet.
    pub const UNKNOWN: Self = Self {
        pole_bound: f64::INFINITY,
        pole_std: f64::INFINITY,
        offset: Complex64::ZERO,
        bias: None,
        strengths: Vec::new(),
        combinations: Vec::new(),
        largest: 0.0,
        amplitude_noise_factor: 1.0,
    };

    /// Error of λ, rad/s: its standard deviation and its distance from the maximum of the
    /// likelihood.
    pub fn pole_error(&self) -> f64 {
        self.pole_std.hypot(self.offset.norm())
    }

    /// Strength of the weakest combination of modes.
    pub fn significance(&self) -> f64 {
        self.strengths.first().copied().unwrap_or(0.0)
    }
}

/// State of the iteration of a pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum FitState {
    /// Its residues are estimated this many times before it iterates.
    Fresh(u8),
    /// It iterates.
    Moving,
    /// It has converged and is kept fixed.
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

impl ModelPole {
    /// A pole of one mode, scaled to 1 at its largest factor.
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
            quality: PoleQuality::UNKNOWN,
            progress: FitState::Fresh(RESIDUE_ESTIMATES),
            suspect: false,
            is_peak_column: false,
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

    /// Half-power bandwidth, rad/s.
    pub fn width(&self) -> f64 {
        2.0 * self.lambda.re.abs()
    }

    /// Separation from another pole in sums of their half-power bandwidths.
    pub fn separation(&self, other: &Self) -> f64 {
        (self.lambda.im - other.lambda.im).abs() / (self.width() + other.width())
    }

    /// The inputs whose factors are free: all except the pivots.
    pub fn free_inputs(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts[0].len()).filter(|input| !self.pivots.contains(input))
    }

    /// Adds the modes of another pole: the participation factors are reduced to a basis with one
    /// pivot each.
    pub fn join(&mut self, parts: Vec<Vec<Complex64>>) {
        self.parts.extend(parts);
        self.residues.fill(Complex64::ZERO);
        self.refresh();
        self.reduce();
    }

    /// Whether its iteration has converged.
    pub fn has_settled(&self) -> bool {
        self.progress == FitState::Settled
    }

    /// Resets the iteration: residues are estimated again before the pole moves.
    pub fn refresh(&mut self) {
        self.progress = FitState::Fresh(RESIDUE_ESTIMATES);
    }

    /// Keeps `count` of its modes: the strongest combinations or, where these are not estimated,
    /// the first.
    pub fn keep_strongest(&mut self, count: usize) {
        let mut parts = std::mem::take(&mut self.parts);
        let combinations = &mut self.quality.combinations;
        if combinations.len() == parts.len() {
            parts = combinations.split_off(combinations.len() - count);
        } else {
            parts.truncate(count);
        }
        self.join(parts);
    }

    /// Moves pivots to the largest factors, where others exceed them.
    pub fn choose_pivots(&mut self) {
        let outgrown =
            |part: &Vec<Complex64>| part.iter().any(|l| l.norm() > MAX_FACTOR_OVER_PIVOT);
        if self.parts.iter().any(outgrown) {
            self.reduce();
        }
    }

    /// Gauss-Jordan elimination with full pivoting: each vector of factors is 1 at its pivot and 0
    /// at those of the others; linearly dependent vectors are removed.
    fn reduce(&mut self) {
        let inputs = self.parts[0].len();
        self.pivots.clear();
        let mut done = 0;
        while done < self.parts.len() {
            let candidates =
                (done..self.parts.len()).flat_map(|p| (0..inputs).map(move |i| (p, i)));
            let free = candidates.filter(|(_, i)| !self.pivots.contains(i));
            let size = |(p, i): &(usize, usize)| self.parts[*p][*i].norm();
            let best = free.max_by(|a, b| size(a).total_cmp(&size(b)));
            let Some((row, input)) = best.filter(|candidate| size(candidate) > 1e-9) else {
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
                        .for_each(|(l, pivot_factor)| *l -= factor * pivot_factor);
                }
            }
            self.pivots.push(input);
            done += 1;
        }
    }
}
