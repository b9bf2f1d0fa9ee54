//! The joint fit of all runs gives one resonance a pole in each run: initial poles, and a
//! Gauss-Newton iteration over all runs together.

use std::rc::Rc;

use num_complex::Complex64;

use crate::identify::run_variation::resonance::{CONVERGED_STEP_DECAY_RATES, Resonance};
use crate::identify::run_variation::run_fit::{Best, Line, Run, Step};
use crate::linalg::{ComplexMatrix, sort_ascending_by};

/// Maximum number of iterations.
const MAX_ITERATIONS: usize = 30;
/// Maximum step, decay rates.
const MAX_STEP_DECAY_RATES: f64 = 0.5;
/// Weight of a run over the mean weight, above which its pole must stay within the lines.
const MIN_RELATIVE_WEIGHT: f64 = 0.1;
/// Trial poles for the initial poles: their spacing in decay rates, their margin beyond the
/// outermost pole in decay rates, and their maximum number.
const TRIAL_SPACING_DECAY_RATES: f64 = 1.0;
const TRIAL_MARGIN_DECAY_RATES: f64 = 2.0;
const MAX_TRIAL_POLES: usize = 64;
/// Minimum energy that a pole or a second pole explains, over that of noise, and over that of both
/// poles.
const MIN_ENERGY_OVER_NOISE: f64 = 20.0;
const MIN_SECOND_ENERGY_FRACTION: f64 = 1e-3;

/// Poles in each run, pole by pole.
pub(super) type Poles = Vec<Vec<Complex64>>;

/// One pole in all runs.
pub(super) struct Track {
    /// Pole in each run.
    pub poles: Vec<Complex64>,
    /// κ: real part over imaginary part of a shift.
    pub slope: f64,
    /// Variance of each frequency, in noise of unit variance, (rad/s)².
    pub variances: Vec<f64>,
    /// Residue of each FRF over the noise.
    pub amplitudes: Vec<Complex64>,
}

/// Poles of a resonance in all runs.
pub(super) struct Fitted {
    pub tracks: Vec<Track>,
    /// Residual energy `Σ|r|²`.
    pub residual_energy: f64,
}

/// One pole during the iteration: in each run, and the line of its decay rates.
struct Path {
    poles: Vec<Complex64>,
    line: Line,
}

impl Resonance<'_> {
    /// The FRFs of each run, with the `other_poles` fitted as well.
    pub fn runs<'a>(
        &'a self,
        runs: &'a [Vec<usize>],
        other_poles: impl Fn(usize) -> Vec<Complex64>,
    ) -> Vec<Run<'a>> {
        // Poles that do not shift have the same profiles in all runs.
        let mut last: Option<(Vec<Complex64>, Rc<ComplexMatrix>)> = None;
        let mut run = |(run, functions): (usize, &'a Vec<usize>)| {
            let poles = other_poles(run);
            let basis = match last.take() {
                Some((same, basis)) if same == poles => basis,
                _ => Rc::new(self.basis(&poles)),
            };
            last = Some((poles, Rc::clone(&basis)));
            Run::new(self, self.values(), functions, basis)
        };
        runs.iter().enumerate().map(&mut run).collect()
    }

    /// Fits poles with an individual frequency in every run by Gauss-Newton steps; `None` where a
    /// pole leaves the lines or its damping becomes negative.
    pub fn fit_poles(&self, runs: &[Run], poles: Poles) -> Option<Fitted> {
        let line = Line {
            middle: self.strong(),
            slope: 0.0,
        };
        let path = |poles| Path { poles, line };
        let mut paths: Vec<Path> = poles.into_iter().map(path).collect();
        for _ in 0..MAX_ITERATIONS {
            let steps = steps(runs, &paths);
            let pairs = paths.iter().zip(&steps);
            let moved = pairs.map(|(path, steps)| self.step_poles(&path.poles, steps));
            let now = moved.collect::<Option<Vec<Path>>>()?;
            let mut all = paths.iter().zip(&now).zip(&steps);
            let converged = all.all(|((before, now), steps)| now.is_converged(before, steps));
            paths = now;
            if converged {
                break;
            }
        }
        Some(self.evaluate(runs, paths))
    }

    /// Variances, amplitudes and residual energy at given poles.
    fn evaluate(&self, runs: &[Run], paths: Vec<Path>) -> Fitted {
        let track = |path: Path| Track {
            variances: Vec::with_capacity(runs.len()),
            amplitudes: vec![Complex64::ZERO; self.functions()],
            slope: path.line.slope,
            poles: path.poles,
        };
        let mut fitted = Fitted {
            tracks: paths.into_iter().map(track).collect(),
            residual_energy: 0.0,
        };
        for (number, run) in runs.iter().enumerate() {
            let poles: Vec<Complex64> = (fitted.tracks.iter())
                .map(|track| track.poles[number])
                .collect();
            let fit = run.fit_amplitudes(&poles);
            fitted.residual_energy += fit.residual_energy;
            let steps = fit.steps(0..run.functions.len());
            for (j, (track, step)) in fitted.tracks.iter_mut().zip(steps).enumerate() {
                track.variances.push(0.5 / step.weight);
                for (index, f) in run.functions.iter().enumerate() {
                    track.amplitudes[*f] = fit.amplitudes[(j, index)];
                }
            }
        }
        fitted
    }

    /// Initial values of one pole and of two poles in each run; none where no run shows as many.
    ///
    /// A run with a weak response begins at the median of the runs. With two poles, a run that
    /// shows one only begins with the other at its median over the runs that show both; the visible
    /// pole is the one with the nearer median.
    pub fn initial_poles(&self, runs: &[Run]) -> Vec<Poles> {
        let trial_poles = self.trial_poles();
        let best: Vec<Best> = runs.iter().map(|run| run.best(&trial_poles)).collect();
        let one = |(best, run): (&Best, &Run)| {
            let clear = best.by_one > MIN_ENERGY_OVER_NOISE * run.functions.len() as f64;
            clear.then_some(best.one)
        };
        let ones: Vec<Option<Complex64>> = best.iter().zip(runs).map(one).collect();
        let mut initial_poles = Vec::new();
        if let Some(median) = median(ones.iter().flatten().copied()) {
            let at = |pole: &Option<Complex64>| pole.unwrap_or(median);
            initial_poles.push(vec![ones.iter().map(at).collect()]);
        }
        let both = |(best, run): (&Best, &Run)| {
            let (pair, by_two) = best.two?;
            let least = (MIN_ENERGY_OVER_NOISE * run.functions.len() as f64)
                .max(MIN_SECOND_ENERGY_FRACTION * by_two);
            (by_two - best.by_one > least).then_some(pair)
        };
        let pairs: Vec<Option<[Complex64; 2]>> = best.iter().zip(runs).map(both).collect();
        let median = |j: usize| median(pairs.iter().flatten().map(|pair| pair[j]));
        let (Some(first), Some(second)) = (median(0), median(1)) else {
            return initial_poles;
        };
        let medians = [first, second];
        let pair = |(pair, one): (&Option<[Complex64; 2]>, &Option<Complex64>)| {
            let mut beginning = pair.unwrap_or(medians);
            if let (None, Some(one)) = (pair, one) {
                let distance = |j: usize| (one.im - medians[j].im).abs();
                beginning[usize::from(distance(1) < distance(0))] = *one;
            }
            beginning
        };
        let pairs: Vec<[Complex64; 2]> = pairs.iter().zip(&ones).map(pair).collect();
        let of = |j: usize| pairs.iter().map(|pair| pair[j]).collect();
        initial_poles.push(vec![of(0), of(1)]);
        initial_poles
    }

    /// Trial poles with the decay rate of the strong pole, over the lines of the group.
    fn trial_poles(&self) -> Vec<Complex64> {
        let decay = -self.strong().re;
        let (lo, hi) = self.span();
        let lo = (lo - TRIAL_MARGIN_DECAY_RATES * decay).max(self.omega[1]);
        let hi = (hi + TRIAL_MARGIN_DECAY_RATES * decay).min(self.omega[self.omega.len() - 2]);
        let count = (((hi - lo) / (TRIAL_SPACING_DECAY_RATES * decay)).ceil() as usize)
            .clamp(1, MAX_TRIAL_POLES - 1);
        let at = |n: usize| lo + (hi - lo) * n as f64 / count as f64;
        (0..=count).map(|n| Complex64::new(-decay, at(n))).collect()
    }

    /// Poles after a step of each, with their decay rates on one line; `None` where a pole leaves
    /// the lines or its damping becomes negative.
    fn step_poles(&self, poles: &[Complex64], steps: &[Step]) -> Option<Path> {
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        if !weights.is_finite() || weights <= 0.0 {
            return None;
        }
        let (lo, hi) = (self.omega[0], self.omega[self.omega.len() - 1]);
        let longest = -MAX_STEP_DECAY_RATES * poles.iter().map(|pole| pole.re).sum::<f64>()
            / poles.len() as f64;
        let stepped = |(pole, step): (&Complex64, &Step)| {
            let change = |part: f64| part.clamp(-longest, longest);
            Complex64::new(
                pole.re + change(step.change.re),
                (pole.im + change(step.change.im)).clamp(lo, hi),
            )
        };
        let stepped: Vec<Complex64> = poles.iter().zip(steps).map(stepped).collect();
        let line = Line::through(&stepped, steps);
        if line.middle.re.is_nan() || line.middle.re >= 0.0 {
            return None;
        }
        // A run of low weight may be far off.
        let damped = |decay: f64| if decay < 0.0 { decay } else { line.middle.re };
        let on_line = |pole: &Complex64| Complex64::new(damped(line.at(pole.im)), pole.im);
        let poles: Vec<Complex64> = stepped.iter().map(on_line).collect();
        let strays = |(pole, step): (&Complex64, &Step)| {
            let counts = step.weight > MIN_RELATIVE_WEIGHT * weights / poles.len() as f64;
            counts && (pole.im <= lo || pole.im >= hi || pole.re >= 0.0)
        };
        let stray = poles.iter().zip(steps).any(strays);
        (!stray).then_some(Path { poles, line })
    }
}

/// The pole of the median frequency.
fn median(poles: impl Iterator<Item = Complex64>) -> Option<Complex64> {
    let mut poles: Vec<Complex64> = poles.collect();
    sort_ascending_by(&mut poles, |pole| pole.im);
    poles.get(poles.len() / 2).copied()
}

/// Step of each pole in each run.
fn steps(runs: &[Run], paths: &[Path]) -> Vec<Vec<Step>> {
    let mut steps = vec![Vec::with_capacity(runs.len()); paths.len()];
    for (number, run) in runs.iter().enumerate() {
        let poles: Vec<Complex64> = paths.iter().map(|path| path.poles[number]).collect();
        let run_steps = run.fit_amplitudes(&poles).steps(0..run.functions.len());
        for (pole_steps, step) in steps.iter_mut().zip(run_steps) {
            pole_steps.push(step);
        }
    }
    steps
}

impl Path {
    /// Whether the last weighted steps are below the limit; runs near a node may wander.
    fn is_converged(&self, before: &Self, steps: &[Step]) -> bool {
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        let moved = |((now, before), step): ((&Complex64, &Complex64), &Step)| {
            (step.weight / weights).sqrt() * (now - before).norm()
        };
        let moved = self.poles.iter().zip(&before.poles).zip(steps).map(moved);
        moved.fold(0.0, f64::max) < CONVERGED_STEP_DECAY_RATES * self.line.middle.re.abs()
    }
}
