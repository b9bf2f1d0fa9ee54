//! Mobilities of a set in its band, turned to the positive axes, with their noise.

use std::ops::Range;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::Location;
use crate::frf::{FrfSet, Function};
use crate::quantity::FrfKind;

/// Lines on each side over which the noise is taken together: 17 lines of three hits have 68
/// degrees of freedom, which know a variance to 17 %.
const NOISE_HALF_WIDTH_LINES: usize = 8;
/// Fewest lines of a checked set: one resonance of five lines with as many on each side.
const MIN_BAND_LINES: usize = 15;
/// Mean power of a third difference of white noise over its variance, `1 + 9 + 9 + 1`.
const THIRD_DIFFERENCE: f64 = 20.0;

/// A set as its mobilities, computed function by function when asked for.
pub(super) struct Mobilities<'a> {
    set: &'a FrfSet,
    lines: Range<usize>,
    /// Angular frequency of the lines, rad/s.
    pub omega: Vec<f64>,
}

impl<'a> Mobilities<'a> {
    /// The mobilities at the lines above 0 Hz in the valid band; `None` when these are too few.
    pub fn new(set: &'a FrfSet) -> Option<Self> {
        let axis = set.axis();
        let band = set.valid_band.or_else(|| axis.band())?;
        let mut lines = axis.lines(&band);
        lines.start += usize::from(!lines.is_empty() && axis.rad_s(lines.start) <= 0.0);
        let omega = lines.clone().map(|k| axis.rad_s(k)).collect();
        (lines.len() >= MIN_BAND_LINES).then_some(Self { set, lines, omega })
    }

    /// The functions of the set.
    pub fn functions(&self) -> &'a [Function] {
        self.set.functions()
    }

    /// Highest frequency of the whole axis, Hz: half the sampling rate when nothing was cut.
    pub fn last_hz(&self) -> f64 {
        self.set.axis().hz(self.set.axis().len - 1)
    }

    /// The lines of the set that are the lines of the mobilities.
    pub fn lines(&self) -> Range<usize> {
        self.lines.clone()
    }

    /// `s^d` that turns function `i` into another kind, and the line of the set, for every line of
    /// the band.
    fn factors(&self, i: usize, kind: FrfKind) -> impl Iterator<Item = (usize, Complex64)> + '_ {
        let order = kind.derivative_order() - self.set.functions()[i].kind.derivative_order();
        let damping = self.set.added_damping_rad_s;
        let factor = move |w: &f64| Complex64::new(damping, *w).powi(order);
        self.lines.clone().zip(self.omega.iter().map(factor))
    }

    /// Mobility of function `i`, (m/s)/N, turned to the positive axes.
    pub fn values(&self, i: usize) -> Vec<Complex64> {
        self.values_as(i, FrfKind::Mobility)
    }

    /// The same as any kind, SI.
    pub fn values_as(&self, i: usize, kind: FrfKind) -> Vec<Complex64> {
        let function = &self.set.functions()[i];
        let sign = function.response.sign() * function.reference.sign();
        let values = self.set.values(i);
        self.factors(i, kind)
            .map(|(k, factor)| sign * factor * values[k])
            .collect()
    }

    /// `E|Y - E Y|²` of function `i`: what the set states, else from the roughness of the values.
    pub fn variance(&self, i: usize) -> Vec<f64> {
        self.variance_as(i, FrfKind::Mobility)
    }

    /// The same as any kind, SI.
    pub fn variance_as(&self, i: usize, kind: FrfKind) -> Vec<f64> {
        match self.set.variance(i) {
            Some(variance) => self
                .factors(i, kind)
                .map(|(k, factor)| variance[k] * factor.norm_sqr())
                .collect(),
            None => variance_from_roughness(&self.values_as(i, kind)),
        }
    }

    /// The variance of function `i` as the mean over neighbouring lines.
    pub fn noise(&self, i: usize) -> Vec<f64> {
        let variance = self.variance(i);
        let mean = |k: usize| {
            let near = &variance[noise_lines(k, variance.len())];
            near.iter().sum::<f64>() / near.len() as f64
        };
        (0..variance.len()).map(mean).collect()
    }

    /// Number of averages behind the variance of function `i`; 2, the fewest that have one, when it
    /// is not known.
    pub fn averages(&self, i: usize) -> f64 {
        f64::from(self.functions()[i].averages.unwrap_or(2).max(2))
    }

    /// Where a finding about function `i` belongs.
    pub fn location(&self, i: usize) -> Location {
        let function = &self.functions()[i];
        Location::Function {
            response: Some(function.response.clone()),
            reference: Some(function.reference.clone()),
        }
    }

    /// Functions between the same points along the same axes, whatever the signs and repeats, as
    /// lists by pair.
    pub fn functions_by_dofs(&self) -> std::collections::BTreeMap<(Dof, Dof), Vec<usize>> {
        let mut pairs = std::collections::BTreeMap::<_, Vec<usize>>::new();
        for (i, function) in self.functions().iter().enumerate() {
            let pair = (
                function.response.without_sign_and_repeat(),
                function.reference.without_sign_and_repeat(),
            );
            pairs.entry(pair).or_default().push(i);
        }
        pairs
    }
}

fn noise_lines(k: usize, len: usize) -> Range<usize> {
    k.saturating_sub(NOISE_HALF_WIDTH_LINES)..(k + NOISE_HALF_WIDTH_LINES + 1).min(len)
}

/// Noise of smooth values: the median power of their third differences over neighbouring lines (of
/// an exponential distribution, mean times ln 2) over that of white noise. A resonance of few lines
/// counts as noise in part, so that what is judged against it is judged mildly.
fn variance_from_roughness(values: &[Complex64]) -> Vec<f64> {
    let differences: Vec<f64> = values
        .windows(4)
        .map(|y| (y[3] - 3.0 * y[2] + 3.0 * y[1] - y[0]).norm_sqr())
        .collect();
    let of = |k: usize| {
        let centre = k.saturating_sub(1).min(differences.len() - 1);
        let mut near = differences[noise_lines(centre, differences.len())].to_vec();
        let middle = near.len() / 2;
        let median = *near.select_nth_unstable_by(middle, f64::total_cmp).1;
        median / (THIRD_DIFFERENCE * std::f64::consts::LN_2)
    };
    (0..values.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, add_noise};

    #[test]
    fn the_roughness_of_noise_is_its_variance() {
        let mut set = Beam::default().set(&[("1:+Z", "1:+Z")]);
        add_noise(&mut set, 30.0, 7);
        let data = Mobilities::new(&set).unwrap();
        let stated = data.variance(0);
        let rough = variance_from_roughness(&data.values(0));
        // Away from the resonances, where the third difference of the mode itself is small.
        let ratio: f64 = (500..1000).map(|k| rough[k] / stated[k]).sum::<f64>() / 500.0;
        assert!((0.8..1.3).contains(&ratio), "{ratio}");
    }

    #[test]
    fn signs_are_turned_and_zero_hz_is_left_out() {
        let plus = Beam::default().set(&[("1:+Z", "1:+Z")]);
        let minus = Beam::default().set(&[("1:-Z", "1:+Z")]);
        let (plus, minus) = (
            Mobilities::new(&plus).unwrap(),
            Mobilities::new(&minus).unwrap(),
        );
        assert_eq!(plus.values(0), minus.values(0));
        assert!(plus.omega[0] > 0.0);
    }
}
