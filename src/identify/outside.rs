//! How much of what lies outside the lines a fit must reckon with, and what leaving the rest away does to its poles.
//!
//! Poles that may take any mixture in every function follow modes outside wherever they are, and cost what is known of modes near the
//! ends of the lines. What such modes put into the lines is a few courses that all functions share, and as few are kept as leave no
//! more of their kind than noise.

use num_complex::Complex64;

use super::automatic::{Fit, measured};
use super::background::Outside;
use super::block::Measured;
use super::refine::{Far, Stop, unsettle};
use super::roots::Root;

/// Rounds in which courses and roots follow each other, most.
const ROUNDS: usize = 12;
/// Movement of a pole from round to round, in its deviations, below which they have found each other.
const STILL: f64 = 0.05;
/// Courses for each function, most: more are hardly fewer numbers than the poles.
const COURSES_PER_FUNCTION: f64 = 0.5;

impl Fit {
    /// Lets the background have no more of what is outside the lines than the data show: nothing where, without it, what the roots
    /// leave over has no more of its kind than noise, else the courses that all functions share. What they explained may have been a
    /// wide mode inside: it is searched for without them.
    pub fn look_outside(&mut self) {
        let shared = self.strongest(usize::MAX);
        let few = (1..=most_courses(self.data.functions())).contains(&shared.len());
        if !self.suffices(Vec::new()) && few {
            self.suffices(shared);
        }
    }

    /// Whether so many courses describe what is outside; nothing changes where they do not.
    fn suffices(&mut self, courses: Vec<Vec<Complex64>>) -> bool {
        let (before, told) = (self.roots.clone(), self.dropped.len());
        self.follow(courses);
        if self.needs_outside() && self.search().is_some() {
            self.settle(Stop::Judging);
        }
        let enough = !self.needs_outside() && self.roots.len() >= before.len();
        if !enough {
            self.data.outside = Outside::Anywhere;
            self.roots = before;
            self.dropped.truncate(told);
        }
        enough
    }

    /// Roots with so many courses, where each is best with the other: a course found beside roots that leaned on it is not its best.
    fn follow(&mut self, mut courses: Vec<Vec<Complex64>>) {
        let mut count = courses.len();
        for _ in 0..ROUNDS {
            let before: Vec<Complex64> = self.roots.iter().map(|root| root.lambda).collect();
            self.data.outside = Outside::Courses(courses);
            unsettle(&mut self.roots);
            self.refine(Stop::Judging);
            let moved = |(root, before): (&Root, &Complex64)| {
                (root.lambda - before).norm() > STILL * root.quality.pole_std
            };
            let same = self.roots.len() == before.len();
            if count == 0 || same && !self.roots.iter().zip(&before).any(moved) {
                return;
            }
            courses = self.strongest(count);
            count = courses.len();
        }
    }

    /// Courses of what the roots leave over: as many as noise does not explain, and so many at most.
    fn strongest(&self, most: usize) -> Vec<Vec<Complex64>> {
        let own = Measured {
            outside: &Outside::Anywhere,
            ..measured(&self.data, &self.sides)
        };
        let far = Far::new(&self.data, &own);
        far.strongest((&own, &self.roots), self.data.correlation.alike(), most)
    }

    /// Whether poles outside explain more of what the roots leave over than they would of noise.
    fn needs_outside(&self) -> bool {
        let (more, unknowns) = self.left_outside();
        more > unknowns + unknowns.sqrt()
    }

    /// Energy that free poles outside explain more of what the roots leave over than the background does, over the noise, and what they
    /// would of noise: their complex unknowns, each of two real numbers of variance 1/2.
    fn left_outside(&self) -> (f64, f64) {
        let explained = |outside: &Outside| {
            let own = Measured {
                outside,
                ..measured(&self.data, &self.sides)
            };
            Far::new(&self.data, &own).explained(&own, &self.roots)
        };
        let (with, many) = explained(&Outside::Anywhere);
        let (without, few) = explained(&self.data.outside);
        (with - without, (many - few) as f64)
    }

    /// Deviations count that courses are known from the same data, and each root is told what leaving the rest away does to it.
    ///
    /// With free poles outside, of `c` numbers in each of `F` functions, a pole has the deviation `σ_f`; with `r` known courses, `σ`.
    /// The `r(c − r)` numbers of the courses make up the part `r/F` of what `σ_f²` has more. With free poles the pole would move by
    /// `δ`, by noise and by what was left away; of the energy `E` that free poles explain more, noise makes `n` of so many numbers,
    /// and the error is `δ √(1 − n/E)`, 0 where that is noise alone.
    pub fn reckon_with_outside(&mut self) {
        let Outside::Courses(courses) = &self.data.outside else {
            return;
        };
        let part = courses.len() as f64 / self.data.functions() as f64;
        let (more, unknowns) = self.left_outside();
        let signal = (1.0 - unknowns / more.max(unknowns)).sqrt();
        let free = self.with_free_poles();
        if free.len() != self.roots.len() {
            return;
        }
        for (root, free) in self.roots.iter_mut().zip(&free) {
            let quality = &mut root.quality;
            let (bound, all) = (quality.pole_bound, free.quality.pole_bound);
            let raised = (bound * bound + part * (all * all - bound * bound).max(0.0)).sqrt();
            quality.pole_std *= raised / bound;
            quality.pole_bound = raised;
            quality.bias = Some(free.quality.offset * signal);
        }
    }

    /// The roots where they are, as a fit with free poles outside sees them.
    fn with_free_poles(&mut self) -> Vec<Root> {
        let (own, roots) = (
            std::mem::replace(&mut self.data.outside, Outside::Anywhere),
            self.roots.clone(),
        );
        unsettle(&mut self.roots);
        self.refine(Stop::Residues);
        self.data.outside = own;
        std::mem::replace(&mut self.roots, roots)
    }
}

fn most_courses(functions: usize) -> usize {
    (COURSES_PER_FUNCTION * functions as f64) as usize
}

#[cfg(test)]
mod tests {
    use super::super::MethodOptions;
    use super::super::receptance::Receptances;
    use super::super::sides::Sides;
    use super::super::synthetic::{Measurement, Structure};
    use super::*;
    use crate::axis::{Band, FrequencyAxis};
    use crate::modal::Pole;

    /// Two modes from 80 to 150 Hz and one above, at eight sensors.
    fn structure() -> Structure {
        let shape = |a: f64| (1..=8).map(|p| (a * f64::from(p)).cos()).collect();
        Structure {
            modes: vec![
                (100.0, 0.01, shape(0.3)),
                (130.0, 0.012, shape(0.7)),
                (175.0, 0.01, shape(1.3)),
            ],
        }
    }

    /// A fit of the two modes, from where they are, with so much known of what is outside.
    fn fitted(snr_db: f64, seed: u64, outside: Outside) -> Fit {
        let axis = FrequencyAxis {
            start_hz: 80.0,
            step_hz: 0.1,
            len: 701,
        };
        let how = Measurement {
            snr_db: Some(snr_db),
            seed,
            ..Measurement::of_sensors(8, axis)
        };
        let set = structure().measured(&how);
        let data = Receptances::guarded(&set, Band::new(80.0, 150.0).unwrap()).unwrap();
        let sides = Sides::new(set.functions());
        let mut fit = Fit::new(data, sides, MethodOptions::default());
        let one = [Complex64::ONE];
        fit.roots = truth().map(|lambda| Root::single(lambda, &one, 8)).to_vec();
        fit.data.outside = outside;
        fit.refine(Stop::Fine);
        fit
    }

    fn truth() -> [Complex64; 2] {
        let modes = structure().modes;
        [0, 1].map(|j| Pole::from_frequency(modes[j].0, modes[j].1).lambda)
    }

    #[test]
    fn the_error_told_is_what_leaving_a_mode_outside_away_makes() {
        let mut fit = fitted(70.0, 1, Outside::Courses(Vec::new()));
        fit.reckon_with_outside();
        for (root, truth) in fit.roots.iter().zip(truth()) {
            let made = truth - root.lambda;
            let told = root.quality.bias.unwrap();
            // Noise moves a pole by its deviation, free poles outside by several.
            assert!(made.norm() > 20.0 * root.quality.pole_bound);
            assert!((told - made).norm() < 0.2 * made.norm(), "{told} {made}");
        }
    }

    #[test]
    fn where_nothing_is_left_away_no_error_is_told() {
        let mut free = fitted(50.0, 2, Outside::Anywhere);
        free.reckon_with_outside();
        assert!(free.roots.iter().all(|root| root.quality.bias.is_none()));
        free.look_outside();
        free.refine(Stop::Fine);
        free.reckon_with_outside();
        let told = |root: &Root| root.quality.bias.unwrap().norm() / root.quality.pole_bound;
        assert!(free.roots.iter().all(|root| told(root) < 1.0));
    }

    #[test]
    fn a_mode_outside_is_a_course_that_all_functions_share() {
        let mut fit = fitted(50.0, 3, Outside::Anywhere);
        let free: Vec<f64> = fit.roots.iter().map(|r| r.quality.pole_bound).collect();
        fit.look_outside();
        let Outside::Courses(courses) = &fit.data.outside else {
            panic!("free poles stay");
        };
        assert!((1..=2).contains(&courses.len()), "{}", courses.len());
        fit.refine(Stop::Fine);
        let known: Vec<f64> = fit.roots.iter().map(|r| r.quality.pole_bound).collect();
        fit.reckon_with_outside();
        for ((root, free), known) in fit.roots.iter().zip(free).zip(known) {
            let own = root.quality.pole_bound;
            assert!(known < own && own < free, "{known} {own} {free}");
        }
        for (root, truth) in fit.roots.iter().zip(truth()) {
            // Four deviations of each part: six parts in 100,000 seeds are beyond.
            let error = root.lambda - truth;
            assert!(error.re.abs().max(error.im.abs()) < 4.0 * root.quality.pole_bound);
        }
    }

    #[test]
    fn few_functions_keep_free_poles_outside() {
        assert_eq!([1, 2, 20].map(most_courses), [0, 1, 10]);
    }
}
