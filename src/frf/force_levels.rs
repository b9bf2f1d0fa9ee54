//! Hits of different force levels at one point show whether the structure is linear.

use std::collections::{BTreeMap, BTreeSet};

use crate::dof::Dof;
use crate::finding::Finding;
use crate::record::{ChannelPlace, ChannelSegment, HitInfo, ReadError, Recording, Samples};
use crate::signal::{Outcome, Rule};

use super::consistency::force_level::{SingleHits, findings};
use super::estimate::estimate_recording;
use super::hit_report::{HitReport, MAX_ASSESSED_RESPONSES};
use super::selection::Selection;
use super::{EstimateOptions, FrfSet};

/// Smallest difference of the force levels at one point from which dependence on the force is
/// estimated, dB.
const MIN_LEVEL_RANGE_DB: f64 = 3.0;

/// Resonances whose frequency or damping depends on the force; nothing where no point has hits that
/// differ by 3 dB or more.
///
/// Hits that were rejected only for their level or because their FRF differs from the others are
/// used here: that is what a nonlinear structure does. Of many responses four of each hit are used.
pub(super) fn force_level_findings(
    recording: &mut dyn Recording,
    hits: &[HitReport],
    averaged: &FrfSet,
    options: &EstimateOptions,
) -> Vec<Finding> {
    let points = hits_by_level(hits);
    if points.is_empty() {
        return Vec::new();
    }
    let mut recording = FewResponses::new(recording);
    let pairs = recording.pairs();
    let functions = averaged.functions().iter().enumerate();
    let functions = functions.filter(|(_, function)| {
        pairs.contains(&(function.response.clone(), function.reference.clone()))
    });
    let functions: Vec<usize> = functions.map(|(index, _)| index).collect();
    let rounds = points.values().map(Vec::len).max().unwrap_or(0);
    let single_hits = (0..rounds).filter_map(|round| {
        let chosen = || {
            points
                .iter()
                .filter_map(|(point, hits)| Some((point, hits.get(round)?)))
        };
        let selection = Selection {
            hits: chosen().map(|(_, hit)| hit.number - 1).collect(),
            overloads: None,
            accepted: BTreeSet::new(),
        };
        let level = |hit: &HitReport| 20.0 * hit.peak_n.abs().log10();
        // A hit that gives no FRF alone shows no frequency.
        let estimated = estimate_recording(&mut recording, &selection, options).ok()?;
        Some(SingleHits {
            set: estimated.set,
            levels_db: chosen()
                .map(|(point, hit)| ((*point).clone(), level(hit)))
                .collect(),
        })
    });
    findings(&averaged.part(&functions), single_hits)
}

/// The hits of every excitation point whose levels differ enough, the weakest first.
fn hits_by_level(hits: &[HitReport]) -> BTreeMap<&Dof, Vec<&HitReport>> {
    let mut points: BTreeMap<&Dof, Vec<&HitReport>> = BTreeMap::new();
    for hit in hits.iter().filter(|hit| is_sound(hit)) {
        points.entry(&hit.reference).or_default().push(hit);
    }
    for hits in points.values_mut() {
        hits.sort_by(|a, b| a.peak_n.abs().total_cmp(&b.peak_n.abs()));
    }
    let min_ratio = 10_f64.powf(MIN_LEVEL_RANGE_DB / 20.0);
    points.retain(|_, hits| match (hits.first(), hits.last()) {
        (Some(weakest), Some(strongest)) => {
            strongest.peak_n.abs() >= min_ratio * weakest.peak_n.abs()
        }
        _ => false,
    });
    points
}

fn is_sound(hit: &HitReport) -> bool {
    let rejects = |rule: Rule| {
        let mut checks = hit.checks.iter();
        checks.any(|check| check.rule == rule && check.outcome == Outcome::Rejected)
    };
    let of_level = [Rule::Level, Rule::InconsistentHit];
    let by_level = of_level.into_iter().any(rejects);
    let mut checks = hit.checks.iter();
    let is_rejected_otherwise =
        checks.any(|check| hit.rejects(check) && !of_level.contains(&check.rule));
    hit.peak_n != 0.0 && (hit.used || (by_level && !hit.stated && !is_rejected_otherwise))
}

/// A recording with at most four responses of each hit, spread over its channels.
struct FewResponses<'a> {
    recording: &'a mut dyn Recording,
    hits: Vec<HitInfo>,
    /// The number of each response in the recording.
    numbers: Vec<Vec<usize>>,
}

impl<'a> FewResponses<'a> {
    fn new(recording: &'a mut dyn Recording) -> Self {
        let mut hits = recording.hits().to_vec();
        let numbers = hits.iter_mut().map(|hit| {
            let step = hit.responses.len().div_ceil(MAX_ASSESSED_RESPONSES).max(1);
            let numbers: Vec<usize> = (0..hit.responses.len()).step_by(step).collect();
            hit.responses = numbers.iter().map(|n| hit.responses[*n].clone()).collect();
            numbers
        });
        let numbers = numbers.collect();
        FewResponses {
            recording,
            hits,
            numbers,
        }
    }

    /// Response and excitation point of its functions.
    fn pairs(&self) -> BTreeSet<(Dof, Dof)> {
        let pairs = self.hits.iter().flat_map(|hit| {
            let responses = hit.responses.iter();
            responses.map(|response| (response.dof.clone(), hit.force.dof.clone()))
        });
        pairs.collect()
    }
}

impl Recording for FewResponses<'_> {
    fn hits(&self) -> &[HitInfo] {
        &self.hits
    }

    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        let channel = match segment.channel {
            ChannelPlace::Force => ChannelPlace::Force,
            ChannelPlace::Response(number) => {
                ChannelPlace::Response(self.numbers[segment.hit][number])
            }
        };
        let segment = ChannelSegment {
            channel,
            ..segment.clone()
        };
        self.recording.read(&segment, samples)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use crate::axis::TimeAxis;
    use crate::finding::Code;
    use crate::frf::{HammerOptions, evaluate_hammer_test};
    use crate::quantity::Quantity;
    use crate::record::{Channel, Hit, InMemory, Role};

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
        fn hit(self, peak_n: f64, noise: f64, random: &mut ChaCha8Rng) -> Hit {
            let force = |t: f64| match t {
                t if (0.0..0.004).contains(&t) => peak_n * (std::f64::consts::PI * t / 0.004).sin(),
                _ => 0.0,
            };
            let h = STEP_S / STEPS as f64;
            let (mut x, mut v) = (0.0, 0.0);
            let (mut forces, mut velocities) = (Vec::new(), Vec::new());
            for n in 0..LEN {
                let time = (n as f64 - ONSET as f64) * STEP_S;
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
            let top = velocities.iter().fold(0.0_f64, |top, v| top.max(v.abs()));
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
                force: channel(Role::Force, Quantity::Force, noisy(forces, 1e-4 * peak_n)),
                responses: vec![channel(
                    Role::Response,
                    Quantity::Velocity,
                    noisy(velocities, noise * top),
                )],
                origin: String::new(),
            }
        }
    }

    /// Findings of force levels for hits of these peaks.
    fn found(oscillator: Oscillator, peaks_n: &[f64], noise: f64, seed: u64) -> Vec<Finding> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let peaks = peaks_n.iter();
        let hits: Vec<Hit> = peaks
            .map(|peak| oscillator.hit(*peak, noise, &mut random))
            .collect();
        let result = evaluate_hammer_test(&mut InMemory::new(&hits), &HammerOptions::default());
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
        let findings = found(softening, &LEVELS_N, 1e-3, 1);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert!(findings[0].value < Some(-0.1), "{findings:?}");
        let rubbing = Oscillator {
            quadratic_damping: 40.0,
            ..Oscillator::default()
        };
        let findings = found(rubbing, &LEVELS_N, 1e-3, 2);
        assert_eq!(findings.len(), 1, "{findings:?}");
        let detail = findings[0].detail.as_deref().unwrap();
        assert!(
            detail.contains("damping +") && detail.contains("6 hits"),
            "{detail}"
        );
        // Hits of one force show nothing, nor does a linear structure.
        assert_eq!(
            found(softening, &[20.0, 21.0, 22.0, 23.0, 24.0], 1e-3, 3),
            []
        );
        assert_eq!(found(Oscillator::default(), &LEVELS_N, 0.0, 4), []);
    }

    #[test]
    fn noise_at_different_levels_is_no_dependence() {
        let named = (0..100).filter(|seed| {
            // Weak hits have the worst signal-to-noise ratio, as in a test.
            let noise = [0.003, 0.01, 0.03][*seed as usize % 3];
            !found(Oscillator::default(), &LEVELS_N, noise, 10 + seed).is_empty()
        });
        assert_eq!(named.count(), 0);
    }
}
