//! Poles of one resonance that move from run to run: where they begin, and Gauss-Newton steps from
//! there.

use num_complex::Complex64;

use crate::identify::run_variation::resonance::{Resonance, STILL};
use crate::identify::run_variation::run_fit::{Best, Line, Run, Step};

/// Turns at most.
const TURNS: usize = 30;
/// Longest step, decay rates.
const LONGEST: f64 = 0.5;
/// Part of what is known of a frequency in the mean from which a run counts.
const COUNTS: f64 = 0.1;
/// Poles that are tried as beginnings: this many decay rates apart, so far beyond the outermost
/// root, and no more than these.
const APART: f64 = 1.0;
const BEYOND: f64 = 2.0;
const MOST_TRIED: usize = 64;
/// Energy over that of noise, and over that of both, which a pole or a second one explains where
/// there is one.
const SECOND: f64 = 20.0;
const LEAST_SECOND: f64 = 1e-3;

/// Poles in each run, pole by pole.
pub(super) type Poles = Vec<Vec<Complex64>>;

/// Where one pole moves to.
pub(super) struct Track {
    /// In each run.
    pub poles: Vec<Complex64>,
    /// κ: real part over imaginary part of a shift.
    pub slope: f64,
    /// Of each frequency, in noise of unit variance, (rad/s)².
    pub variances: Vec<f64>,
    /// Over the noise.
    pub amplitudes: Vec<Complex64>,
}

/// Where the poles of a resonance move to.
pub(super) struct Fitted {
    pub tracks: Vec<Track>,
    /// `Σ|rest|²`.
    pub left: f64,
}

/// One pole on its way: in each run, and the line of its decay rates.
struct Path {
    poles: Vec<Complex64>,
    line: Line,
}

impl Resonance<'_> {
    /// The functions of each run, where the others have the poles `beside`.
    pub fn runs<'a>(
        &'a self,
        runs: &'a [Vec<usize>],
        beside: impl Fn(usize) -> Vec<Complex64>,
    ) -> Vec<Run<'a>> {
        (0..runs.len())
            .map(|run| Run::new(self, (self.values(), &runs[run]), &beside(run)))
            .collect()
    }

    /// Poles with a frequency of their own in every run, by Gauss-Newton steps; `None` where one
    /// leaves the lines or damping.
    pub fn fitted(&self, runs: &[Run], poles: Poles) -> Option<Fitted> {
        let line = Line {
            middle: self.strong(),
            slope: 0.0,
        };
        let path = |poles| Path { poles, line };
        let mut paths: Vec<Path> = poles.into_iter().map(path).collect();
        for _ in 0..TURNS {
            let steps = steps(runs, &paths);
            let pairs = paths.iter().zip(&steps);
            let moved = pairs.map(|(path, steps)| self.moved(&path.poles, steps));
            let now = moved.collect::<Option<Vec<Path>>>()?;
            let mut all = paths.iter().zip(&now).zip(&steps);
            let still = all.all(|((before, now), steps)| now.stays(before, steps));
            paths = now;
            if still {
                break;
            }
        }
        Some(self.evaluate(runs, paths))
    }

    /// What the runs say of poles where they are.
    fn evaluate(&self, runs: &[Run], paths: Vec<Path>) -> Fitted {
        let track = |path: Path| Track {
            variances: Vec::with_capacity(runs.len()),
            amplitudes: vec![Complex64::ZERO; self.functions()],
            slope: path.line.slope,
            poles: path.poles,
        };
        let mut fitted = Fitted {
            tracks: paths.into_iter().map(track).collect(),
            left: 0.0,
        };
        for (number, run) in runs.iter().enumerate() {
            let poles: Vec<Complex64> = (fitted.tracks.iter())
                .map(|track| track.poles[number])
                .collect();
            let look = run.look(&poles);
            fitted.left += look.left;
            let steps = look.steps(0..run.functions.len());
            for (j, (track, step)) in fitted.tracks.iter_mut().zip(steps).enumerate() {
                track.variances.push(0.5 / step.weight);
                for (index, f) in run.functions.iter().enumerate() {
                    track.amplitudes[*f] = look.amplitudes[(j, index)];
                }
            }
        }
        fitted
    }

    /// Where one pole and where two of each run may begin; none where no run has so many.
    ///
    /// A run of which one pole says no more than where it is in most runs has it there. Of two, a
    /// run that has only one says nothing of the other, which begins at the median of the runs that
    /// have both; the one that it has is that whose median is nearer.
    pub fn beginnings(&self, runs: &[Run]) -> Vec<Poles> {
        let tried = self.tried();
        let best: Vec<Best> = runs.iter().map(|run| run.best(&tried)).collect();
        let one = |(best, run): (&Best, &Run)| {
            let clear = best.by_one > SECOND * run.functions.len() as f64;
            clear.then_some(best.one)
        };
        let ones: Vec<Option<Complex64>> = best.iter().zip(runs).map(one).collect();
        let mut beginnings = Vec::new();
        if let Some(median) = median(ones.iter().flatten().copied()) {
            let at = |pole: &Option<Complex64>| pole.unwrap_or(median);
            beginnings.push(vec![ones.iter().map(at).collect()]);
        }
        let both = |(best, run): (&Best, &Run)| {
            let (pair, by_two) = best.two?;
            let least = (SECOND * run.functions.len() as f64).max(LEAST_SECOND * by_two);
            (by_two - best.by_one > least).then_some(pair)
        };
        let pairs: Vec<Option<[Complex64; 2]>> = best.iter().zip(runs).map(both).collect();
        let median = |j: usize| median(pairs.iter().flatten().map(|pair| pair[j]));
        let (Some(first), Some(second)) = (median(0), median(1)) else {
            return beginnings;
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
        beginnings.push(vec![of(0), of(1)]);
        beginnings
    }

    /// Poles of the strong root's decay rate over the lines of the group.
    fn tried(&self) -> Vec<Complex64> {
        let decay = -self.strong().re;
        let (lo, hi) = self.span();
        let lo = (lo - BEYOND * decay).max(self.omega[1]);
        let hi = (hi + BEYOND * decay).min(self.omega[self.omega.len() - 2]);
        let count = (((hi - lo) / (APART * decay)).ceil() as usize).clamp(1, MOST_TRIED - 1);
        let at = |n: usize| lo + (hi - lo) * n as f64 / count as f64;
        (0..=count).map(|n| Complex64::new(-decay, at(n))).collect()
    }

    /// Poles after a step of each, their decay rates on one line; `None` where they leave the lines
    /// or damping.
    fn moved(&self, poles: &[Complex64], steps: &[Step]) -> Option<Path> {
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        if !weights.is_finite() || weights <= 0.0 {
            return None;
        }
        let (lo, hi) = (self.omega[0], self.omega[self.omega.len() - 1]);
        let longest = -LONGEST * poles.iter().map(|pole| pole.re).sum::<f64>() / poles.len() as f64;
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
        // One that hardly counts may be far off.
        let damped = |decay: f64| if decay < 0.0 { decay } else { line.middle.re };
        let on_line = |pole: &Complex64| Complex64::new(damped(line.at(pole.im)), pole.im);
        let poles: Vec<Complex64> = stepped.iter().map(on_line).collect();
        let strays = |(pole, step): (&Complex64, &Step)| {
            let counts = step.weight > COUNTS * weights / poles.len() as f64;
            counts && (pole.im <= lo || pole.im >= hi || pole.re >= 0.0)
        };
        let stray = poles.iter().zip(steps).any(strays);
        (!stray).then_some(Path { poles, line })
    }
}

/// The pole of the median frequency.
fn median(poles: impl Iterator<Item = Complex64>) -> Option<Complex64> {
    let mut poles: Vec<Complex64> = poles.collect();
    poles.sort_by(|a, b| a.im.total_cmp(&b.im));
    poles.get(poles.len() / 2).copied()
}

/// Of each pole, the step in each run.
fn steps(runs: &[Run], paths: &[Path]) -> Vec<Vec<Step>> {
    let mut steps = vec![Vec::with_capacity(runs.len()); paths.len()];
    for (number, run) in runs.iter().enumerate() {
        let poles: Vec<Complex64> = paths.iter().map(|path| path.poles[number]).collect();
        let run_steps = run.look(&poles).steps(0..run.functions.len());
        for (pole_steps, step) in steps.iter_mut().zip(run_steps) {
            pole_steps.push(step);
        }
    }
    steps
}

impl Path {
    /// Whether the last steps were hardly any; runs near a node may wander.
    fn stays(&self, before: &Self, steps: &[Step]) -> bool {
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        let moved = |((now, before), step): ((&Complex64, &Complex64), &Step)| {
            (step.weight / weights).sqrt() * (now - before).norm()
        };
        let moved = self.poles.iter().zip(&before.poles).zip(steps).map(moved);
        moved.fold(0.0, f64::max) < STILL * self.line.middle.re.abs()
    }
}
