//! The recordings of the family are reproducible, and agree with the truth where they are clean.

use modalign::dof::Dof;
use modalign::frf::{EstimateOptions, FrfSet, estimate, truncation_bounds};
use modalign::modal::Mode;
use modalign::synth::{HalfSine, HammerTest, LowPass, Noise};
use num_complex::Complex64;
use rayon::prelude::*;

use super::members;
use super::pipeline::family;
use crate::population::Member;

#[test]
fn every_member_is_recorded_and_the_same_member_gives_the_same_samples_again() {
    let family = family();
    let members = members();
    assert_eq!(
        members.len(),
        family.members.iter().map(|m| m.count).sum::<usize>()
    );
    members.par_iter().for_each(|member| {
        let mut numbers = member
            .name
            .rsplit('-')
            .map(|part| part.parse::<usize>().unwrap());
        let number = numbers.next().unwrap();
        let again = family.draw(numbers.next().unwrap(), number).unwrap();
        assert!(again == *member, "{}", member.name);
        let hits = member.test.generate().unwrap();
        assert_eq!(hits.len(), member.test.hit_count());
        for (i, hit) in hits.iter().enumerate() {
            assert!(
                again.test.generate_hit(i).unwrap() == *hit,
                "{} hit {i}",
                member.name
            );
        }
    });
}

/// Residual aliasing of images above half the sampling rate, over the largest |H|: the filter is
/// 111 dB down where they fall into the band, and the force there may be 20 dB down.
const MAX_ALIASING_ERROR: f64 = 3e-5;
/// Largest rms error over the stated bound. The bound is exact for one mode; two that beat may hold
/// it to 0.55 of the truth, and a slower mode that is hidden in the last quarter makes it smaller
/// yet. Measured: 2.01.
const MAX_ERROR_OVER_BOUND: f64 = 3.0;

/// Errors of the FRFs of a clean member.
struct Clean {
    name: String,
    /// Error at the worst line over the tail that the record cuts off there, from the true poles.
    line: f64,
    /// Rms error over the band, weighted by the force, over the rms of H and the stated bound.
    stated: f64,
}

#[test]
fn h1_of_clean_members_is_the_truth_but_for_the_tail_that_the_record_cuts_off() {
    let members = members();
    let clean: Vec<Clean> = members.par_iter().map(clean).collect();
    let worst =
        |of: fn(&Clean) -> f64| clean.iter().max_by(|a, b| of(a).total_cmp(&of(b))).unwrap();
    let (line, stated) = (worst(|c| c.line), worst(|c| c.stated));
    println!("worst line {:.3} ({})", line.line, line.name);
    println!(
        "worst over the stated bound {:.3} ({})",
        stated.stated, stated.name
    );
    // A lone mode attains the limit; measured: 0.994.
    assert!(line.line < 1.0, "{}: {}", line.name, line.line);
    assert!(
        stated.stated < MAX_ERROR_OVER_BOUND,
        "{}: {}",
        stated.name,
        stated.stated
    );
}

fn clean(member: &Member) -> Clean {
    let test = HammerTest {
        noise: Noise::default(),
        ..member.test.clone()
    };
    let hits = test.generate().unwrap();
    let options = EstimateOptions::default();
    let set = estimate(&hits, &options).unwrap();
    let bounds = truncation_bounds(&hits, &options).unwrap();
    let mut worst = Clean {
        name: member.name.clone(),
        line: 0.0,
        stated: 0.0,
    };
    for (index, function) in set.functions().iter().enumerate() {
        let pair = (function.response.clone(), function.reference.clone());
        let (line, weighted) = Truth::new(&test, &pair).compare(&set, index);
        worst.line = worst.line.max(line);
        worst.stated = worst
            .stated
            .max(bounds[&pair].bound.map_or(0.0, |bound| weighted / bound));
    }
    worst
}

/// The true FRF of one pair of response and reference.
struct Truth {
    modes: Vec<Term>,
    rigid_per_kg: f64,
    filter: LowPass,
    pulses: Vec<HalfSine>,
    step_s: f64,
}

/// One mode at one pair.
struct Term {
    lambda: Complex64,
    /// Residue of the accelerance, `lambda^2 A`.
    residue: Complex64,
    /// Magnitude of its motion at the end of the record, by hit: `|lambda^2 A F(lambda)| e^(-sigma
    /// T)`.
    at_end: Vec<f64>,
}

impl Truth {
    fn new(test: &HammerTest, pair: &(Dof, Dof)) -> Self {
        let entry = test
            .hits
            .iter()
            .position(|plan| plan.hit == pair.1)
            .unwrap();
        let first = entry * test.averages_per_point;
        let hits = first..first + test.averages_per_point;
        let pulses: Vec<HalfSine> = hits.map(|i| test.pulses(i).unwrap()[0]).collect();
        let filter = test.low_pass().unwrap();
        let term = |mode: &Mode| {
            let lambda = mode.pole().unwrap().lambda;
            let residue = lambda * lambda * mode.residues[pair];
            let decay = (lambda * test.record_s()).exp().norm();
            let excited =
                |pulse: &HalfSine| (pulse.transform(lambda) * filter.transfer(lambda)).norm();
            Term {
                lambda,
                residue,
                at_end: pulses
                    .iter()
                    .map(|pulse| residue.norm() * decay * excited(pulse))
                    .collect(),
            }
        };
        Self {
            modes: test.truth.model.modes.iter().map(term).collect(),
            rigid_per_kg: test
                .truth
                .rigid_accelerance
                .get(pair)
                .copied()
                .unwrap_or(0.0),
            step_s: 1.0 / test.sampling_rate_hz,
            filter,
            pulses,
        }
    }

    /// The true accelerance.
    fn accelerance(&self, s: Complex64) -> Complex64 {
        let term = |mode: &Term| {
            let a = mode.residue / (mode.lambda * mode.lambda);
            s * s * (a / (s - mode.lambda) + a.conj() / (s - mode.lambda.conj()))
        };
        self.rigid_per_kg + self.modes.iter().map(term).sum::<Complex64>()
    }

    /// Largest error of H1 from what comes after the record: `sum_n>=N x(n) e^(-s n)` is a
    /// geometric series for every pole, `e^((lambda - s) T) / (1 - e^((lambda - s) dt))`, over the
    /// spectrum of the force; the worst hit counts.
    fn tail(&self, s: Complex64, force: &[f64]) -> f64 {
        let series =
            |pole: Complex64| self.step_s / (1.0 - ((pole - s) * self.step_s).exp()).norm();
        let mut tails = vec![0.0; force.len()];
        for mode in &self.modes {
            let both = series(mode.lambda) + series(mode.lambda.conj());
            let terms = tails.iter_mut().zip(&mode.at_end);
            terms.for_each(|(tail, at_end)| *tail += both * at_end);
        }
        tails
            .iter()
            .zip(force)
            .map(|(tail, force)| tail / force)
            .fold(0.0, f64::max)
    }

    /// Error over tail at the worst line, and rms error over rms of H weighted by the force, in the
    /// usable band.
    fn compare(&self, set: &FrfSet, index: usize) -> (f64, f64) {
        let lines = set.axis().lines(&set.valid_band.unwrap());
        let values = &set.values(index)[lines.clone()];
        let largest = values.iter().map(|h| h.norm()).fold(0.0, f64::max);
        let (mut worst, mut error_power, mut power) = (0.0f64, 0.0, 0.0);
        for (k, h) in lines.zip(values) {
            let s = Complex64::new(0.0, set.axis().rad_s(k));
            let gain = self.filter.transfer(s);
            let force = self
                .pulses
                .iter()
                .map(|pulse| (pulse.transform(s) * gain).norm());
            let force: Vec<f64> = force.collect();
            let error = (h - self.accelerance(s)).norm();
            worst = worst.max(error / (self.tail(s, &force) + MAX_ALIASING_ERROR * largest));
            let weight = force[0] * force[0];
            error_power += weight * error * error;
            power += weight * h.norm_sqr();
        }
        (worst, (error_power / power).sqrt())
    }
}
