//! How much of what lies outside the lines a fit must reckon with, and what leaving the rest away
//! does to its poles.
//!
//! Poles that may take any mixture in every function follow modes outside wherever they are, and
//! cost what is known of modes near the ends of the lines. What such modes put into the lines is a
//! few courses that all functions share, and as few are kept as leave no more of their kind than
//! noise.

use num_complex::Complex64;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::model_pole::{Quality, Root};
use crate::identify::data::out_of_band_basis::{Course, Outside};
use crate::identify::data::residual::Far;
use crate::identify::fit::block_descent::{Stop, unsettle};
use crate::identify::ml::estimator::Fit;

/// Rounds in which courses and roots follow each other, most.
const ROUNDS: usize = 12;
/// Movement of a pole from round to round, in its deviations, below which they have found each
/// other.
const STILL: f64 = 0.05;
/// Ratio of a squared error to its mean that noise exceeds once in twenty times: it is exponential.
const BY_CHANCE: f64 = 3.0;
/// Courses for each function, most: more are hardly fewer numbers than the poles.
const COURSES_PER_FUNCTION: f64 = 0.5;

impl Fit {
    /// Lets the background have no more of what is outside the lines than the data show: nothing
    /// where, without it, what the roots leave over has no more of its kind than noise, else the
    /// courses that all functions share. What they explained may have been a wide mode inside: it
    /// is searched for without them.
    pub fn look_outside(&mut self) {
        let shared = self.strongest(usize::MAX);
        let few = (1..=most_courses(self.data.functions())).contains(&shared.len());
        if !self.suffices(Vec::new()) && few {
            self.suffices(shared);
        }
    }

    /// Whether so many courses describe what is outside; nothing changes where they do not.
    fn suffices(&mut self, courses: Vec<Course>) -> bool {
        let (before, drops_before) = (self.roots.clone(), self.dropped.len());
        self.follow(courses);
        if self.needs_outside() && self.search().is_some() {
            self.settle(Stop::Judging);
        }
        let enough = !self.needs_outside() && self.roots.len() >= before.len();
        if !enough {
            self.data.set_outside(Outside::Anywhere);
            self.roots = before;
            self.dropped.truncate(drops_before);
        }
        enough
    }

    /// Roots with so many courses, where each is best with the other: a course found beside roots
    /// that leaned on it is not its best.
    fn follow(&mut self, mut courses: Vec<Course>) {
        let mut count = courses.len();
        for _ in 0..ROUNDS {
            let before: Vec<Complex64> = self.roots.iter().map(|root| root.lambda).collect();
            self.data.set_outside(Outside::Courses(courses));
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

    /// Courses of what the roots leave over: as many as noise does not explain, and so many at
    /// most.
    fn strongest(&self, most: usize) -> Vec<Course> {
        let far = Far::new(&self.data, &Outside::Anywhere);
        far.strongest(&self.roots, self.data.correlation.alike(), most)
    }

    /// Whether free poles outside explain more of what the roots leave over than they would of
    /// white noise: where lines share noise they do, and stay, and the deviations count them.
    fn needs_outside(&self) -> bool {
        let all = Far::new(&self.data, &Outside::Anywhere);
        let (with, many) = all.explained(&self.roots);
        let (without, few) = self.data.far().explained(&self.roots);
        // Two real numbers of variance 1/2 for each unknown.
        let unknowns = (many - few) as f64;
        with - without > unknowns + unknowns.sqrt()
    }

    /// Deviations count that courses are known from the same data, and each root is told what
    /// leaving the rest away does to it.
    ///
    /// With free poles outside a pole has the information `1/σ_f²`, with known courses `1/σ²`. What
    /// courses may be beside what they are takes from it in the functions that hold them: the part
    /// `p = Σ_r |v_rᴴψ|²/|ψ|²` of `1/σ² − 1/σ_f²`, with the residues `ψ` and what the functions
    /// hold of the courses, `v_r`, over the noise.
    ///
    /// With free poles the pole would move by `δ`: by noise, `E|δ|² = 2(σ_f² − σ²)`, and by what
    /// was left away. Beyond what noise does once in twenty times the error is `√(|δ|² − E|δ|²)`
    /// along `δ`, else none is told.
    pub fn reckon_with_outside(&mut self) {
        let Outside::Courses(courses) = self.data.outside().clone() else {
            return;
        };
        let free = self.with_free_poles();
        if free.len() != self.roots.len() {
            // A pole that free poles outside do not leave in its place leans on them.
            self.data.set_outside(Outside::Anywhere);
            self.settle(Stop::Fine);
            return;
        }
        for (root, free) in self.roots.iter_mut().zip(&free) {
            let part = held(&self.data, root, &courses);
            root.quality.reckon_with(&free.quality, part);
        }
    }

    /// The roots where they are, as a fit with free poles outside sees them.
    fn with_free_poles(&mut self) -> Vec<Root> {
        let terms = self.data.set_outside(Outside::Anywhere);
        let roots = self.roots.clone();
        unsettle(&mut self.roots);
        self.refine(Stop::Residues);
        self.data.set_outside(terms);
        std::mem::replace(&mut self.roots, roots)
    }
}

impl Quality {
    /// Takes in what a fit with free poles outside says; courses hold so large a part of the
    /// residues.
    fn reckon_with(&mut self, free: &Self, part: f64) {
        let (bound, all) = (self.pole_bound, free.pole_bound);
        // Where free poles leave a pole unknown, nothing is known of it but by what is known of the
        // courses.
        if !(bound > 0.0 && bound <= all && bound.is_finite()) {
            return;
        }
        let [known, least] = [bound, all].map(|deviation| deviation.powi(-2));
        let raised = (known - part * (known - least)).sqrt().recip();
        let by_noise = self.pole_std / bound;
        let expected = 2.0 * by_noise.powi(2) * (all * all - bound * bound);
        let moved = free.offset.norm_sqr();
        let error = if moved > BY_CHANCE * expected {
            free.offset * (1.0 - expected / moved).sqrt()
        } else {
            Complex64::ZERO
        };
        self.bias = Some(error);
        self.pole_std *= raised / bound;
        self.pole_bound = raised;
    }
}

/// The part of a root's residues that goes along what the functions hold of some courses, over the
/// noise.
fn held(data: &Receptances, root: &Root, courses: &[Course]) -> f64 {
    let line = data.line_of(root.lambda);
    let over = |f: usize| root.residues[f] / data.deviation(f, line);
    let residues: Vec<Complex64> = (0..data.functions()).map(over).collect();
    let all: f64 = residues.iter().map(Complex64::norm_sqr).sum();
    let along = |course: &Course| {
        let terms = course
            .shares
            .iter()
            .zip(&residues)
            .map(|(v, a)| v.conj() * a);
        terms.sum::<Complex64>().norm_sqr()
    };
    if all > 0.0 {
        (courses.iter().map(along).sum::<f64>() / all).min(1.0)
    } else {
        1.0
    }
}

fn most_courses(functions: usize) -> usize {
    (COURSES_PER_FUNCTION * functions as f64) as usize
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::data::band_frfs::Receptances;
    use crate::identify::data::frf_matrix::Sides;
    use crate::identify::estimator::MethodOptions;
    use crate::identify::ml::out_of_band::*;
    use crate::identify::synthetic::{Measurement, Structure};
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
        fit.data.set_outside(outside);
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
            let bias = root.quality.bias.unwrap();
            // Noise moves a pole by its deviation, free poles outside by several.
            assert!(made.norm() > 20.0 * root.quality.pole_bound);
            assert!((bias - made).norm() < 0.2 * made.norm(), "{bias} {made}");
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
        let relative_bias =
            |root: &Root| root.quality.bias.unwrap().norm() / root.quality.pole_bound;
        assert!(free.roots.iter().all(|root| relative_bias(root) < 1.0));
    }

    #[test]
    fn a_mode_outside_is_a_course_that_all_functions_share() {
        let mut fit = fitted(50.0, 3, Outside::Anywhere);
        let free: Vec<f64> = fit.roots.iter().map(|r| r.quality.pole_bound).collect();
        fit.look_outside();
        let Outside::Courses(courses) = fit.data.outside() else {
            panic!("free poles stay");
        };
        assert!((1..=2).contains(&courses.len()), "{}", courses.len());
        fit.refine(Stop::Fine);
        let known: Vec<f64> = fit.roots.iter().map(|r| r.quality.pole_bound).collect();
        fit.reckon_with_outside();
        for ((root, free), known) in fit.roots.iter().zip(free).zip(known) {
            let std = root.quality.pole_bound;
            assert!(known < std && std < free, "{known} {std} {free}");
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
