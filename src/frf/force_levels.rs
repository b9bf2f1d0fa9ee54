//! Hits of different force levels at one point show whether the structure is linear.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::Finding;
use crate::record::Recording;
use crate::signal::{Outcome, Rule};

use super::consistency::force_level::{HitLevel, MIN_LEVEL_RANGE_DB, SingleHits, findings};
use super::estimate::estimate_recording;
use super::few_responses::FewResponses;
use super::hit_report::HitReport;
use super::selection::Selection;
use super::{EstimateOptions, FrfSet};

/// Fewest hits of a series: a slope and a mean leave one degree of freedom.
pub(super) const MIN_HITS: usize = 3;

/// Resonances whose frequency or damping depends on the force; nothing where no series of hits, at
/// one point with the same sensors, has levels that differ by 3 dB or more.
///
/// Hits that were rejected only for their level or because their FRF differs from the others are
/// used here: that is what a nonlinear structure does. Of many responses four of each hit are used.
pub(super) fn force_level_findings(
    recording: &mut dyn Recording,
    hits: &[HitReport],
    averaged: &FrfSet,
    selection: &Selection,
    options: &EstimateOptions,
) -> Vec<Finding> {
    let mut recording = FewResponses::new(recording);
    let series = series_of_hits(hits, &recording);
    if series.is_empty() {
        return Vec::new();
    }
    let pairs = recording.pairs();
    let functions = averaged.functions().iter().enumerate();
    let functions = functions.filter(|(_, function)| {
        pairs.contains(&(function.response.clone(), function.reference.clone()))
    });
    let functions: Vec<usize> = functions.map(|(index, _)| index).collect();
    // At most one hit of each excitation point at a time, so that no function is an average.
    let mut by_point: BTreeMap<&Dof, Vec<(usize, &HitReport)>> = BTreeMap::new();
    for (number, hits) in series.iter().enumerate() {
        let hits = hits.iter().map(|hit| (number, *hit));
        by_point
            .entry(&series[number][0].reference)
            .or_default()
            .extend(hits);
    }
    let turns = by_point.values().map(Vec::len).max().unwrap_or(0);
    let single_hits = (0..turns).filter_map(|turn| {
        let chosen = || by_point.values().filter_map(|hits| hits.get(turn));
        let selection = Selection {
            hits: chosen().map(|(_, hit)| hit.number - 1).collect(),
            ..selection.clone()
        };
        let level = |(series, hit): &(usize, &HitReport)| {
            let level_db = 20.0 * hit.peak_n.map_or(0.0, f64::abs).log10();
            let series = *series;
            (hit.reference.clone(), HitLevel { level_db, series })
        };
        // A hit that gives no FRF alone shows no frequency.
        let estimated = estimate_recording(&mut recording, &selection, options).ok()?;
        Some(SingleHits {
            set: estimated.set,
            levels: chosen().map(level).collect(),
        })
    });
    findings(&averaged.part(&functions), single_hits)
}

/// The series of hits at one point with the same responses whose levels differ enough.
fn series_of_hits<'h>(hits: &'h [HitReport], recording: &FewResponses) -> Vec<Vec<&'h HitReport>> {
    let mut series: BTreeMap<(&Dof, Vec<&Dof>), Vec<&HitReport>> = BTreeMap::new();
    for hit in hits.iter().filter(|hit| is_sound(hit)) {
        let responses = recording.hits()[hit.number - 1].responses.iter();
        let key = (
            &hit.reference,
            responses.map(|response| &response.dof).collect(),
        );
        series.entry(key).or_default().push(hit);
    }
    let min_ratio = 10_f64.powf(MIN_LEVEL_RANGE_DB / 20.0);
    let differ = |hits: &Vec<&HitReport>| {
        let peaks = || hits.iter().filter_map(|hit| hit.peak_n).map(f64::abs);
        let (weakest, strongest) = (
            peaks().fold(f64::INFINITY, f64::min),
            peaks().fold(0.0, f64::max),
        );
        hits.len() >= MIN_HITS && strongest >= min_ratio * weakest
    };
    series.into_values().filter(differ).collect()
}

/// Whether a hit is used, or was rejected only for its level or its difference from others.
pub(super) fn is_sound(hit: &HitReport) -> bool {
    let rejects = |rule: Rule| {
        let mut checks = hit.checks.iter();
        checks.any(|check| check.rule == rule && check.outcome == Outcome::Rejected)
    };
    let of_level = [Rule::Level, Rule::InconsistentHit];
    let by_level = of_level.into_iter().any(rejects);
    let mut checks = hit.checks.iter();
    let is_rejected_otherwise =
        checks.any(|check| hit.rejects(check) && !of_level.contains(&check.rule));
    hit.peak_n.is_some() && (hit.used || (by_level && !hit.stated && !is_rejected_otherwise))
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use crate::axis::TimeAxis;
    use crate::finding::Code;
    use crate::frf::{HammerOptions, ResponseWindow, evaluate_hammer_test};
    use crate::quantity::Quantity;
    use crate::record::{Channel, Hit, InMemory, Role, Samples};

    const STEP_S: f64 = 1.0 / 1024.0;
    const LEN: usize = 8192;
    const ONSET: usize = 100;
    const OMEGA: f64 = std::f64::consts::TAU * 50.0;
    /// Steps of the integration for each sample.
    const STEPS: usize = 8;

    /// One mode of 1 kg and 50 Hz, 1.5 % damping.
    #[derive(Clone, Copy, Default)]
    struct Oscillator {
        /// `k₃/k`, 1/m².
        cubic_stiffness: f64,
        /// `c₂/c`, s/m: damping force `c v (1 + c₂/c |v|)`.
        quadratic_damping: f64,
    }

    impl Oscillator {
        fn acceleration(self, force: f64, x: f64, v: f64) -> f64 {
            let stiffness = OMEGA * OMEGA * x * (1.0 + self.cubic_stiffness * x * x);
            let damping = 2.0 * 0.015 * OMEGA * v * (1.0 + self.quadratic_damping * v.abs());
            force - stiffness - damping
        }

        /// Velocity under a half sine of 4 ms (fourth-order Runge-Kutta).
        /// `noise`: m/s.
        fn hit(self, peak_n: f64, noise: f64, random: &mut ChaCha8Rng) -> Hit {
            let force = |t: f64| match t {
                t if (0.0..0.004).contains(&t) => peak_n * (std::f64::consts::PI * t / 0.004).sin(),
                _ => 0.0,
            };
            let onset = ONSET + random.random_range(0..40);
            let h = STEP_S / STEPS as f64;
            let (mut x, mut v) = (0.0, 0.0);
            let (mut forces, mut velocities) = (Vec::new(), Vec::new());
            for n in 0..LEN {
                let time = (n as f64 - onset as f64) * STEP_S;
                forces.push(force(time));
                velocities.push(v);
                for step in 0..STEPS {
                    let t = time + step as f64 * h;
                    let a = |dt: f64, x: f64, v: f64| self.acceleration(force(t + dt), x, v);
                    let a1 = a(0.0, x, v);
                    let (x2, v2) = (x + 0.5 * h * v, v + 0.5 * h * a1);
                    let a2 = a(0.5 * h, x2, v2);
                    let (x3, v3) = (x + 0.5 * h * v2, v + 0.5 * h * a2);
                    let a3 = a(0.5 * h, x3, v3);
                    let (x4, v4) = (x + h * v3, v + h * a3);
                    let a4 = a(h, x4, v4);
                    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
                    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
                }
            }
            let normal = Normal::new(0.0, 1.0).unwrap();
            let mut noisy = |samples: Vec<f64>, level: f64| {
                let noisy = samples.iter().map(|x| x + level * normal.sample(random));
                Samples::F64(noisy.collect())
            };
            let channel = |role, quantity, samples| Channel {
                role,
                dof: "1:+Z".parse().unwrap(),
                quantity,
                to_si: 1.0,
                samples,
            };
            Hit {
                axis: TimeAxis {
                    start_s: 0.0,
                    step_s: STEP_S,
                    len: LEN,
                },
                force: channel(Role::Force, Quantity::Force, noisy(forces, 1e-3)),
                responses: vec![channel(
                    Role::Response,
                    Quantity::Velocity,
                    noisy(velocities, noise),
                )],
                origin: String::new(),
            }
        }
    }

    /// Findings of force levels for hits of these peaks; `noise`: of the velocity, m/s.
    fn found(oscillator: Oscillator, peaks_n: &[f64], noise: f64, seed: u64) -> Vec<Finding> {
        found_with(&HammerOptions::default(), oscillator, peaks_n, noise, seed)
    }

    fn found_with(
        options: &HammerOptions,
        oscillator: Oscillator,
        peaks_n: &[f64],
        noise: f64,
        seed: u64,
    ) -> Vec<Finding> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let peaks = peaks_n.iter();
        let hits: Vec<Hit> = peaks
            .map(|peak| oscillator.hit(*peak, noise, &mut random))
            .collect();
        let result = evaluate_hammer_test(&mut InMemory::new(&hits), options);
        let findings = result.unwrap().estimated.set.findings.into_iter();
        findings
            .filter(|f| f.code == Code::ForceLevelDependent)
            .collect()
    }

    const LEVELS_N: [f64; 6] = [10.0, 13.0, 16.0, 20.0, 25.0, 31.0];

    #[test]
    fn stiffness_and_damping_that_depend_on_the_amplitude_are_named() {
        // At the amplitude a the frequency differs by 3/8 k₃/k a², 7 % after the strongest hit;
        // most of a decay has smaller amplitudes.
        let softening = Oscillator {
            cubic_stiffness: -3e6,
            ..Oscillator::default()
        };
        let findings = found(softening, &LEVELS_N, 5e-5, 1);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert!(findings[0].value < Some(-0.1), "{findings:?}");
        let rubbing = Oscillator {
            quadratic_damping: 40.0,
            ..Oscillator::default()
        };
        let findings = found(rubbing, &LEVELS_N, 5e-5, 2);
        assert_eq!(findings.len(), 1, "{findings:?}");
        let detail = findings[0].detail.as_deref().unwrap();
        assert!(
            detail.contains("damping +") && detail.contains("6 hits"),
            "{detail}"
        );
        // Hits of one force show nothing, nor does a linear structure.
        assert_eq!(
            found(softening, &[20.0, 21.0, 22.0, 23.0, 24.0], 5e-5, 3),
            []
        );
        assert_eq!(found(Oscillator::default(), &LEVELS_N, 0.0, 4), []);
    }

    #[test]
    #[ignore = "long: in release by .ci/run"]
    fn noise_at_different_levels_is_no_dependence() {
        // With an exponential window the records begin at their pulses and differ in length.
        let windowed = HammerOptions {
            response_window: ResponseWindow::End(0.01),
            ..HammerOptions::default()
        };
        let options = [HammerOptions::default(), windowed];
        let named = (0..100).filter(|seed| {
            let options = &options[*seed as usize % 2];
            // The strongest hit gives about 0.08 m/s, the weakest a third.
            let noise = [2e-4, 8e-4, 2.4e-3][*seed as usize % 3];
            let linear = Oscillator::default();
            !found_with(options, linear, &LEVELS_N, noise, 10 + seed).is_empty()
        });
        assert_eq!(named.count(), 0);
    }
}
