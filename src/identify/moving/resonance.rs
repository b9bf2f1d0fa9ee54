//! One resonance of which every run has a pole of its own, and whether that describes the data better than several roots for all runs.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use super::super::far::{Rest, courses, residues};
use super::super::noise_profile::Profile;
use super::super::receptance::Receptances;
use super::super::roots::Root;
use super::super::standing::lines_around;
use super::run::{Line, Run, Step, without};
use super::{Moved, Moving, pole};

/// Half-power widths on either side in which a pole is looked at.
const REACH: f64 = 3.0;
/// Lines on either side, at least: a narrow resonance is told by the lines of its flanks as well.
const SIDE: f64 = 10.0;
/// Constant, slope and curvature of what is farther away.
const BACKGROUND: usize = 3;
/// Largest shift of a run, half-power widths: the mass of a sensor or a drift moves no mode farther, but two modes look so.
const MOST_SHIFT: f64 = 1.0;
/// Least scatter between runs, half-power widths: noise of the force that neighbouring lines share makes as much.
const LEAST_SCATTER: f64 = 0.005;
/// Energy that rounding leaves over.
const ROUNDING: f64 = 1e-14;
/// Deviation of the frequency of a run, half-power widths, up to which the run says whether it moved.
const CLEAR: f64 = 0.1;
/// What a known mode leaves over, over what roots leave or noise, from which on it is not told anew.
const POOR: f64 = 2.0;
/// Part of what the criterion asks for, from which on a single root is looked at.
const ENOUGH: f64 = 0.3;
/// Turns at most, and the step that ends them, decay rates.
const TURNS: usize = 30;
pub(super) const STILL: f64 = 1e-6;
/// Steps of halving for the variance between runs.
const HALVINGS: usize = 60;
/// Longest step, decay rates.
const LONGEST: f64 = 0.5;
/// Part of what is known of all frequencies from which a run counts.
const COUNTS: f64 = 0.01;

/// The lines around a strong root and the roots of its group, with what roots farther away explain taken away.
pub(super) struct Resonance<'a> {
    data: &'a Receptances,
    pub(super) omega: Vec<f64>,
    pub(super) profile: Profile,
    /// Over the noise, as runs are brought together: lines × functions.
    straight: ComplexMatrix,
    /// The same as measured.
    values: ComplexMatrix,
    group: Vec<&'a Root>,
    /// All other roots.
    others: Vec<Complex64>,
}

/// A mode that moves.
pub(super) struct Told {
    pub mode: Moving,
    /// Whether it says so beyond doubt, were it the only one.
    pub alone: bool,
    /// Whether it was known before.
    pub known: bool,
}

impl Told {
    /// What is known already.
    pub fn as_known(known: Option<&Moving>) -> Option<Option<Self>> {
        let mode = known?.clone();
        Some(Some(Self {
            mode,
            alone: true,
            known: true,
        }))
    }
}

/// What one look at a resonance says of its pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FirstLook {
    /// Too few runs can tell.
    Unclear,
    /// It is the same in all runs.
    Still,
    /// It may move.
    Worthwhile,
}

/// Where a pole moves to.
pub(super) struct Fitted {
    /// In each run.
    pub poles: Vec<Complex64>,
    /// κ: real part over imaginary part of a shift.
    slope: f64,
    /// Of each frequency, in noise of unit variance, (rad/s)².
    variances: Vec<f64>,
    /// Over the noise.
    amplitudes: Vec<Complex64>,
    /// `Σ|rest|²`.
    left: f64,
}

impl<'a> Resonance<'a> {
    /// `None` where too few lines tell the roots around apart.
    pub fn new(
        data: &'a Receptances,
        (roots, group): (&'a [Root], &[usize]),
        (rest, moved): (&Rest, &Moved),
    ) -> Option<Self> {
        let strong = &roots[group[0]];
        let lines = lines_around(data, strong, REACH.max(SIDE * data.step / strong.width()));
        let omega = data.omega[lines.clone()].to_vec();
        let near = |lambda: Complex64| beside(&omega, lambda);
        let roots_near: Vec<Root> = (roots.iter())
            .filter(|root| near(root.lambda))
            .cloned()
            .collect();
        // The background, the pole with its derivative, and as many rows again to tell a misfit.
        if omega.len() < 2 * (roots_near.len() + BACKGROUND + 2) {
            return None;
        }
        let profile = Profile::new(data, lines.clone());
        let over = |k: usize, f: usize| profile.course[k] * profile.level[f];
        let explained = courses(&omega, &roots_near) * residues(&roots_near, data.functions());
        let straight = linalg::complex_matrix(omega.len(), data.functions(), |k, f| {
            let line = lines.start + k;
            let value = rest.at(f, line) * data.deviation(f, line) + explained[(k, f)];
            value / over(k, f)
        });
        let modes_near: Vec<&Moving> = (moved.modes.iter())
            .filter(|mode| near(mode.lambda))
            .collect();
        let mut values = straight.clone();
        for (run, functions) in moved.runs.iter().enumerate() {
            for (f, k) in functions
                .iter()
                .flat_map(|f| (0..omega.len()).map(move |k| (*f, k)))
            {
                let own = modes_near
                    .iter()
                    .map(|mode| mode.correction((f, run), omega[k]));
                values[(k, f)] -= own.sum::<Complex64>() / over(k, f);
            }
        }
        let other = |j: &usize| !group.contains(j);
        Some(Self {
            straight,
            values,
            group: group.iter().map(|j| &roots[*j]).collect(),
            others: (0..roots.len())
                .filter(other)
                .map(|j| roots[j].lambda)
                .collect(),
            data,
            omega,
            profile,
        })
    }

    /// An orthonormal basis of the background and the courses of those poles that are near, over the course of the noise.
    pub(super) fn basis(&self, poles: &[Complex64]) -> ComplexMatrix {
        let near: Vec<Complex64> = (poles.iter().copied())
            .filter(|lambda| beside(&self.omega, *lambda))
            .collect();
        let middle = 0.5 * self.omega.len() as f64;
        let columns = near.len() + BACKGROUND;
        let columns = linalg::complex_matrix(self.omega.len(), columns, |k, column| {
            let value = match near.get(column) {
                Some(lambda) => pole(self.omega[k], *lambda) * lambda.re,
                None => {
                    let power = (column - near.len()) as i32;
                    Complex64::from((k as f64 / middle - 1.0).powi(power))
                }
            };
            value / self.profile.course[k]
        });
        linalg::thin_qr(&columns).q
    }

    /// What one step tells of a pole of its own in every run; where several roots are, that must be tried.
    pub fn first_look(&self, runs: &[Vec<usize>]) -> FirstLook {
        let [root] = self.group[..] else {
            return FirstLook::Worthwhile;
        };
        let functions: Vec<usize> = (0..self.data.functions()).collect();
        let run = Run::new(self, (&self.straight, &functions), &self.others);
        let look = run.look(root.lambda);
        let changes: Vec<(Complex64, f64)> = (runs.iter())
            .map(|run| look.change(run.iter().copied()))
            .collect();
        let values = (self.omega.len() * functions.len()) as f64;
        let alike = self.data.shared.of_pole(self.data, root);
        let noise = alike * (look.without_derivative() / values).min(1.0);
        let variances = changes.iter().map(|(_, weight)| 0.5 / weight);
        if !tells(variances, self.clear(root.decay(), noise)) {
            return FirstLook::Unclear;
        }
        let gained = changes.iter().map(|(d, weight)| weight * d.im * d.im);
        let wanted = runs.len() as f64 * (2.0 * values / alike).ln();
        match 2.0 * gained.sum::<f64>() / noise > ENOUGH * wanted {
            true => FirstLook::Worthwhile,
            false => FirstLook::Still,
        }
    }

    /// Variance of a frequency in noise of unit variance up to which a run says whether it moved.
    fn clear(&self, decay: f64, noise: f64) -> f64 {
        (CLEAR * 2.0 * decay).powi(2) / noise
    }

    /// The mode, where its pole moves or is `known` to; `None` where too few runs could tell it.
    pub fn judged(
        &self,
        fitted: Option<&Fitted>,
        (runs, factors): (&[Vec<usize>], usize),
        known: Option<&Moving>,
    ) -> Option<Option<Told>> {
        let Some(fitted) = fitted else {
            return Told::as_known(known);
        };
        let functions = self.data.functions();
        let own = self.group.iter().map(|root| root.lambda);
        let all: Vec<Complex64> = own.chain(self.others.iter().copied()).collect();
        let held = without(&self.basis(&all), &self.straight).squared_norm_l2();
        let values = (self.omega.len() * functions) as f64;
        let alike = self.data.shared.of_pole(self.data, self.group[0]);
        // Where the data do not state the noise, what the better of both leaves over tells it.
        let rounding = ROUNDING * self.straight.squared_norm_l2();
        let left = held.min(fitted.left).max(rounding).max(f64::MIN_POSITIVE);
        let noise = alike * (left / values).min(1.0);
        let mode = self.merged(fitted, noise);
        let decay = -mode.lambda.re;
        let most = self.clear(decay, noise);
        if known.is_none() && !tells(fitted.variances.iter().copied(), most) {
            return None;
        }
        let far =
            |(shift, v): (&Complex64, &f64)| *v < most && shift.im.abs() > MOST_SHIFT * 2.0 * decay;
        let little = mode.scatter < LEAST_SCATTER * 2.0 * decay;
        if little || mode.shifts.iter().zip(&fitted.variances).any(far) {
            return Some(None);
        }
        let numbers = 2.0 * values / alike;
        let criterion =
            |left: f64, unknowns: usize| 2.0 * left / noise + unknowns as f64 * numbers.ln();
        // Residues, frequencies, and the straight line of the decay rates.
        let of_runs = criterion(fitted.left, 2 * functions + runs.len() + 2);
        // Residues of each function by itself, or as products of shapes and participation factors.
        let of_roots = criterion(held, 2 * self.group.len() * (functions + 1));
        let modes: usize = self.group.iter().map(|root| root.multiplicity()).sum();
        let unknowns = 2 * modes * factors;
        let of_products = criterion(self.left_by_roots(), unknowns);
        if let Some(known) = known {
            // Brought together it is one root, unless it never was one mode.
            if self.group.len() > 1 && of_runs >= of_roots {
                return Some(None);
            }
            let fits = fitted.left < POOR * held.max(values);
            return Told::as_known(Some(if fits { &mode } else { known }));
        }
        Some((of_runs < of_roots).then_some(Told {
            alone: of_runs < of_products,
            known: false,
            mode,
        }))
    }

    /// `Σ|rest|²` of the roots of the group as they were fitted, beside others and background fitted here.
    fn left_by_roots(&self) -> f64 {
        let own: Vec<Root> = self.group.iter().map(|root| (*root).clone()).collect();
        let explained = courses(&self.omega, &own) * residues(&own, self.data.functions());
        let Profile { course, level } = &self.profile;
        let (lines, functions) = (self.omega.len(), self.data.functions());
        let rest = linalg::complex_matrix(lines, functions, |k, f| {
            self.straight[(k, f)] - explained[(k, f)] / (course[k] * level[f])
        });
        without(&self.basis(&self.others), &rest).squared_norm_l2()
    }

    /// The pole with a frequency of its own in every run, by Gauss-Newton steps from `start` or from the strong root, where the others have
    /// the poles `beside`; `None` where it leaves the lines or damping.
    pub fn fitted(
        &self,
        runs: &[Vec<usize>],
        start: Option<Vec<Complex64>>,
        beside: impl Fn(usize) -> Vec<Complex64>,
    ) -> Option<Fitted> {
        let mut poles = start.unwrap_or_else(|| vec![self.group[0].lambda; runs.len()]);
        let own: Vec<Run> = (0..runs.len())
            .map(|run| Run::new(self, (&self.values, &runs[run]), &beside(run)))
            .collect();
        let mut slope = 0.0;
        for _ in 0..TURNS {
            let steps: Vec<Step> = (own.iter().zip(&poles))
                .map(|(run, pole)| run.step(*pole))
                .collect();
            let (now, line) = self.moved(&poles, &steps)?;
            slope = line.slope;
            // Runs near a node may wander.
            let weights: f64 = steps.iter().map(|step| step.weight).sum();
            let moved = |((now, before), step): ((&Complex64, &Complex64), &Step)| {
                (step.weight / weights).sqrt() * (now - before).norm()
            };
            let most = now.iter().zip(&poles).zip(&steps).map(moved);
            let most = most.fold(0.0, f64::max);
            poles = now;
            if most < STILL * line.middle.re.abs() {
                break;
            }
        }
        let mut fitted = Fitted {
            slope,
            variances: Vec::new(),
            amplitudes: vec![Complex64::ZERO; self.values.ncols()],
            left: 0.0,
            poles,
        };
        for (run, pole) in own.iter().zip(&fitted.poles) {
            let step = run.step(*pole);
            fitted.variances.push(0.5 / step.weight);
            fitted.left += step.look.left;
            for (f, amplitude) in run.functions.iter().zip(step.look.amplitudes) {
                fitted.amplitudes[*f] = amplitude;
            }
        }
        Some(fitted)
    }

    /// Poles after a step of each, their decay rates on one line; `None` where they leave the lines or damping.
    fn moved(&self, poles: &[Complex64], steps: &[Step]) -> Option<(Vec<Complex64>, Line)> {
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        if weights <= 0.0 {
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
        // One that hardly counts may be far off.
        let damped = |decay: f64| if decay < 0.0 { decay } else { line.middle.re };
        let on_line = |pole: &Complex64| Complex64::new(damped(line.at(pole.im)), pole.im);
        let now: Vec<Complex64> = stepped.iter().map(on_line).collect();
        let strays = |(pole, step): (&Complex64, &Step)| {
            let counts = step.weight > COUNTS * weights;
            counts && (pole.im <= lo || pole.im >= hi || pole.re >= 0.0)
        };
        let stray = now.iter().zip(steps).any(strays);
        (!stray).then_some((now, line))
    }

    /// The runs as samples of one mode, in noise of this variance.
    fn merged(&self, fitted: &Fitted, noise: f64) -> Moving {
        let variances: Vec<f64> = fitted.variances.iter().map(|v| v * noise).collect();
        let omegas: Vec<f64> = fitted.poles.iter().map(|pole| pole.im).collect();
        let between = between_runs(&omegas, &variances);
        let weight = |v: &f64| 1.0 / (between + v);
        let weights: f64 = variances.iter().map(weight).sum();
        let weighted = fitted.poles.iter().zip(&variances);
        let weighted = weighted.map(|(pole, v)| pole * weight(v));
        let lambda = weighted.sum::<Complex64>() / weights;
        let direction = Complex64::new(fitted.slope, 1.0);
        let believed =
            |(omega, v): (&f64, &f64)| direction * (omega - lambda.im) * between * weight(v);
        let residues = fitted.amplitudes.iter().zip(&self.profile.level);
        let known: f64 = variances.iter().map(|v| v.recip()).sum();
        Moving {
            lambda,
            scatter: between.sqrt(),
            decay_std: known.recip().sqrt(),
            shifts: omegas.iter().zip(&variances).map(believed).collect(),
            stds: variances.iter().map(|v| v.sqrt()).collect(),
            residues: residues.map(|(a, level)| a * level).collect(),
        }
    }
}

/// Variance between runs beside that of each, by which the weighted scatter is what it should be (Paule and Mandel 1982); 0 where the
/// runs scatter no more than their own variances say.
fn between_runs(values: &[f64], variances: &[f64]) -> f64 {
    let free = values.len() as f64 - 1.0;
    let scatter = |between: f64| {
        let weights: Vec<f64> = variances.iter().map(|v| 1.0 / (between + v)).collect();
        let pairs = || values.iter().zip(&weights);
        let mean = pairs().map(|(value, w)| w * value).sum::<f64>() / weights.iter().sum::<f64>();
        pairs()
            .map(|(value, w)| w * (value - mean).powi(2))
            .sum::<f64>()
    };
    if scatter(0.0) <= free {
        return 0.0;
    }
    // The scatter falls with the variance, to 1 at most at that of the values themselves.
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (mut lo, mut hi) = (0.0, values.iter().map(|value| (value - mean).powi(2)).sum());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (lo + hi);
        if scatter(middle) > free {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    0.5 * (lo + hi)
}

/// Whether enough runs know their frequency to this variance.
fn tells(variances: impl ExactSizeIterator<Item = f64>, most: f64) -> bool {
    let runs = variances.len();
    variances.filter(|v| *v < most).count() >= 2.max(runs / 2)
}

/// Whether a pole lies within some lines, or so near that it is more than the background there.
fn beside(omega: &[f64], lambda: Complex64) -> bool {
    let (lo, hi) = (omega[0], omega[omega.len() - 1]);
    let reach = (hi - lo).max(-2.0 * REACH * lambda.re);
    lambda.im > lo - reach && lambda.im < hi + reach
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_between_runs_is_what_their_own_does_not_explain() {
        // Equal variances: the sample variance less that of each.
        let values = [1.0, 3.0, 5.0, 7.0];
        let sample = 20.0 / 3.0;
        assert!((between_runs(&values, &[0.5; 4]) - (sample - 0.5)).abs() < 1e-12);
        assert!(between_runs(&values, &[10.0; 4]).abs() < 1e-12);
        // However unequal, where they are far less than the scatter.
        let unequal = between_runs(&values, &[1e-3, 1e-9, 1e-6, 1e-9]);
        assert!((unequal - sample).abs() < 1e-2, "{unequal}");
        // A run of which nothing is known scatters as it should: one degree of freedom too many is left to the others.
        let unknown = between_runs(&[1.0, 3.0, 5.0, 7.0, 1e3], &[0.5, 0.5, 0.5, 0.5, 1e12]);
        assert!((unknown - (20.0 / 4.0 - 0.5)).abs() < 1e-2, "{unknown}");
    }
}
