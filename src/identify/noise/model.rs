//! What is known of the noise of receptances, and what a fit leaves over tells of it.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::residual::Rest;
use crate::identify::noise::force_noise::Shared;
use crate::identify::noise::line_correlation::Correlation;
use crate::identify::noise::residual_variance::{self, LeftOver, Source};
use crate::identify::noise::variance_model::Smooth;

/// Fewest functions whose own courses tell noise that lines share from modes.
const FEWEST_FUNCTIONS: usize = 3;
/// Mean power of what is left over, over the noise, from which on it is more.
const MORE_THAN_NOISE: f64 = 2.0;

/// What of what a fit leaves over tells the noise of data that bring no variances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum ToldFrom {
    /// Its second differences: noise is even over the record.
    Differences,
    /// Its level, as lines share noise.
    LevelOfNoise,
    /// Its level, as no sum of few modes describes the data better.
    LevelOfMisfit,
}

/// What is known of the noise at some time.
pub(in crate::identify) struct KnownNoise {
    variance: Vec<Vec<f64>>,
    by_force: Vec<Vec<f64>>,
    correlation: Correlation,
    shared: Shared,
    told_from: ToldFrom,
}

impl Receptances {
    /// Whether lines share noise that the data say nothing of; with the rate at which it decays
    /// over the record, 1/s, where it does.
    pub fn unstated_decay(&self) -> Option<Option<f64>> {
        let shared =
            self.told_from == ToldFrom::LevelOfNoise && self.correlation.differences_hold_little();
        shared.then(|| self.correlation.decay(self.step))
    }

    /// The noise of all functions and how lines share it, from what a fit leaves over, which is
    /// then over that noise. To variances that came with the data it adds noise of the force that
    /// they do not tell.
    pub fn tell_noise(&mut self, rest: &mut Rest) {
        self.measure_noise(rest);
        if let Some(own) = Correlation::of_rest(rest) {
            self.correlation = own;
        }
    }

    /// Whether what the fit leaves over is noise that lines share, where it is more than second
    /// differences make of it: every function has its own, lines that are next to each other share
    /// most of it and those far apart nothing. Missing modes leave the same course in all
    /// functions. Such noise is told from its level from then on. Records under a window of which
    /// the data say nothing have it.
    pub fn lines_share_noise(&mut self, rest: &mut Rest) -> bool {
        let stated = self.stated.iter().any(Option::is_some);
        let few = self.functions() < FEWEST_FUNCTIONS;
        let more_than_noise = rest.mean_power() > MORE_THAN_NOISE;
        let little = self.correlation.differences_hold_little();
        if self.told_from != ToldFrom::Differences || stated || few || !more_than_noise && !little {
            return false;
        }
        let before = (self.noise(), self.variance.clone());
        self.told_from = ToldFrom::LevelOfNoise;
        self.measure_noise(rest);
        if let Some(own) = Correlation::of_own_noise(rest) {
            self.correlation = own;
            self.measure_noise(rest);
            return true;
        }
        let (noise, variance) = before;
        rest.over(&self.variance, &variance);
        self.set_noise(noise);
        false
    }

    /// From now on what the fit leaves over counts as noise whatever it is, where the data do not
    /// state the noise.
    pub fn count_misfit_as_noise(&mut self) {
        // The level of noise that lines share holds it already.
        if self.told_from == ToldFrom::Differences {
            self.told_from = ToldFrom::LevelOfMisfit;
        }
    }

    fn measure_noise(&mut self, rest: &mut Rest) {
        let by_lines = self.correlation.of_second_difference();
        let alike = self.correlation.alike();
        let mut now = vec![Smooth::default(); self.functions()];
        for group in self.shared.groups() {
            let left = |f: &usize| self.left_over(*f, rest, (by_lines, alike));
            let told = residual_variance::of_rest(group.par_iter().map(left).collect());
            let own = |(f, told): (&usize, Smooth)| (*f, self.as_receptance(*f, told));
            let own: Vec<(usize, Smooth)> = group.par_iter().zip(told).map(own).collect();
            for (f, own) in own {
                now[f] = own;
            }
        }
        let (now, by_force) = now
            .into_iter()
            .map(|own| (own.variance, own.by_force))
            .unzip();
        let before = std::mem::replace(&mut self.variance, now);
        self.by_force = by_force;
        self.raise_variances();
        rest.over(&before, &self.variance);
        self.renew();
    }

    /// What is known of the noise.
    pub fn noise(&self) -> KnownNoise {
        KnownNoise {
            variance: self.variance.clone(),
            by_force: self.by_force.clone(),
            correlation: self.correlation.clone(),
            shared: self.shared.clone(),
            told_from: self.told_from,
        }
    }

    /// Takes back what was known of the noise before.
    pub fn set_noise(&mut self, known: KnownNoise) {
        self.variance = known.variance;
        self.by_force = known.by_force;
        self.correlation = known.correlation;
        self.shared = known.shared;
        self.told_from = known.told_from;
        self.renew();
    }

    /// Of function f, as measured.
    fn left_over(&self, f: usize, rest: &Rest, (by_lines, alike): (f64, f64)) -> LeftOver {
        let scale = &self.measured_scale[f];
        let values = self.values[f].iter().zip(scale.iter());
        let deviations = self.variance[f].iter().zip(scale.iter());
        let own = rest.of(f, 0..self.lines()).iter().zip(deviations);
        let own: Vec<Complex64> = own.map(|(rest, (v, s))| rest * (v.sqrt() * s)).collect();
        let squared = |(v, s): (&f64, &f64)| v * s * s;
        let source = match &self.stated[f] {
            Some(own) => {
                Source::Stated(own.variance.iter().zip(scale.iter()).map(squared).collect())
            }
            None if self.told_from == ToldFrom::Differences => Source::SecondDifferences(by_lines),
            None => Source::Level,
        };
        let measured: Vec<Complex64> = values.map(|(h, s)| h * s).collect();
        LeftOver::new(&measured, &own, (source, alike))
    }

    /// Variances of function f as it was measured as those of its receptance.
    fn as_receptance(&self, f: usize, told: Smooth) -> Smooth {
        let variance = told.variance.iter().zip(self.measured_scale[f].iter());
        let variance: Vec<f64> = variance.map(|(v, s)| v / (s * s)).collect();
        Smooth {
            by_force: match &self.stated[f] {
                Some(stated) => force_part(stated, &variance),
                None => told.by_force,
            },
            variance,
        }
    }
}

/// The part of variances that the force makes, where all that they have more than what the data
/// state is its own.
fn force_part(stated: &Smooth, variance: &[f64]) -> Vec<f64> {
    let own = stated.variance.iter().zip(&stated.by_force).zip(variance);
    own.map(|((before, part), v)| 1.0 - (1.0 - part) * before / v)
        .collect()
}
