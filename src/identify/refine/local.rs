//! Narrower windows for poles that wide windows move.
//!
//! Where the model is right, fewer lines around a resonance give the same pole with more variance. Where it is not (a mode that no
//! pole stands for, a stiffness that depends on the amplitude), the residual far from the resonance moves the pole, and the lines near
//! it tell it better, as circle fit and peak-picking do. Of nested windows a pole keeps the widest in which it lies within the
//! confidence region of every narrower one.
//!
//! Reference: Lepski (1991), On a problem of adaptive estimation in Gaussian white noise, Theory of Probability and its
//! Applications 35(3).

use super::{Stop, unsettle};
use crate::identify::automatic::Fit;
use crate::identify::roots::Root;

/// Half of the narrower windows, half-power bandwidths. 3 is where constant, slope and pole of one function are still told apart: the
/// standard deviation is twice that of the widest window.
const NARROWER_HALF_POWER_WIDTHS: [f64; 2] = [8.0, 3.0];
/// Reduced chi-square of a window above which the model misses the data: a window of 50 lines of one function exceeds it by chance
/// once in 1e6 times. Below it all windows agree but for noise.
const MIN_MISFIT: f64 = 2.0;
/// Squared distance over `2σ²` outside of which a pole contradicts a narrower window: by chance once in 1e4 times. At 3 every
/// twentieth pole would lose its window without need.
const MAX_DISTANCE: f64 = 9.2;

impl Fit {
    /// Fits the poles again that a window of misfit moves away from where narrower windows see them.
    pub fn narrow_windows(&mut self) {
        if !self.roots.iter().any(misses) {
            return;
        }
        let wide = self.roots.clone();
        let narrower = NARROWER_HALF_POWER_WIDTHS.map(|reach| self.in_windows(reach));
        let mut changed = false;
        for (root, fitted) in self.roots.iter_mut().zip(&wide) {
            let reach = reach(fitted, &narrower);
            changed |= reach < root.reach;
            root.reach = reach;
        }
        if changed {
            unsettle(&mut self.roots);
            self.settle(Stop::Fine);
        }
    }

    /// The roots as windows of one reach give them; the fit stays as it is.
    fn in_windows(&mut self, reach: f64) -> Vec<Root> {
        let before = self.roots.clone();
        for root in &mut self.roots {
            root.reach = reach.min(root.reach);
        }
        unsettle(&mut self.roots);
        self.refine(Stop::Judging);
        std::mem::replace(&mut self.roots, before)
    }
}

fn misses(root: &Root) -> bool {
    root.quality.misfit > MIN_MISFIT
}

/// The widest reach in which a root lies within the confidence regions of all narrower ones.
fn reach(wide: &Root, narrower: &[Vec<Root>]) -> f64 {
    if !misses(wide) {
        return wide.reach;
    }
    let same = |roots: &Vec<Root>| -> Option<Root> {
        let distance = |root: &&Root| (root.lambda - wide.lambda).norm();
        let nearest = roots
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (distance(&nearest) < wide.width()).then(|| nearest.clone())
    };
    let mut nested = vec![wide.clone()];
    nested.extend(narrower.iter().filter_map(same));
    let agrees = |place: &usize| {
        let own = &nested[*place];
        nested[place + 1..]
            .iter()
            .all(|other| !contradicts(own, other))
    };
    let chosen = (0..nested.len()).find(agrees);
    chosen.map_or(wide.reach, |place| nested[place].reach)
}

/// Whether a pole lies outside the confidence region of one of a narrower window.
fn contradicts(wide: &Root, narrow: &Root) -> bool {
    let variance = narrow.quality.pole_std.powi(2) * narrow.quality.misfit.max(1.0);
    let distance = (wide.lambda - narrow.lambda).norm_sqr();
    distance > MAX_DISTANCE * 2.0 * variance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::MethodOptions;
    use crate::identify::receptance::Receptances;
    use crate::identify::roots::REACH;
    use crate::identify::sides::Sides;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;
    use num_complex::Complex64;

    /// A fit of a mode at 100 Hz; the data have another at 112 Hz, of so large a shape.
    fn fitted(other: f64, seed: u64) -> Fit {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.1,
            len: 2001,
        };
        let structure = Structure {
            modes: vec![
                (100.0, 0.01, vec![1.0, -0.6]),
                (112.0, 0.01, vec![other, other]),
            ],
        };
        let how = Measurement {
            snr_db: Some(40.0),
            seed,
            ..Measurement::of_sensors(2, axis)
        };
        let set = structure.measured(&how);
        let data = Receptances::guarded(&set, Band::new(60.0, 160.0).unwrap()).unwrap();
        let sides = Sides::new(set.functions());
        let mut fit = Fit::new(data, sides, MethodOptions::default());
        let lambda = Pole::from_frequency(100.0, 0.01).lambda;
        fit.roots = vec![Root::single(lambda, &[Complex64::ONE], 2)];
        fit.refine(Stop::Fine);
        fit
    }

    #[test]
    fn a_mode_that_no_pole_stands_for_does_not_move_its_neighbour() {
        let truth = Pole::from_frequency(100.0, 0.01).lambda;
        let error = |fit: &Fit| (fit.roots[0].lambda - truth).norm();
        for seed in 1..=5 {
            let mut fit = fitted(0.7, seed);
            let before = error(&fit);
            fit.narrow_windows();
            assert!(fit.roots[0].reach < REACH);
            assert!(error(&fit) < 0.2 * before, "{} {before}", error(&fit));
        }
    }

    #[test]
    fn where_the_model_is_right_windows_stay() {
        for seed in 1..=20 {
            let mut fit = fitted(0.0, seed);
            let before = fit.roots.clone();
            fit.narrow_windows();
            assert_eq!(fit.roots, before);
        }
    }
}
