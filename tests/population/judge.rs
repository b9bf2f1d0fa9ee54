//! A judge compares the modes found in a member of the family with its observable modes.
//!
//! - **Observable**: at one pair the root's peak stands 10 dB over the noise of the FRF at its
//!   half-power lines, and the Cramér-Rao deviation of its frequency is under a quarter of the
//!   distance to the next root.
//! - **Separated**: every other root is at least 10 half-power bandwidths (of the wider of the two)
//!   away.
//! - **Found**: a mode within the larger of three Cramér-Rao deviations and a quarter of the
//!   half-power bandwidth, whose shape has a MAC of 0.9 or more with the root's (a repeated root:
//!   with its subspace).
//! - **Spurious**: a found mode without such a root.

use std::f64::consts::TAU;

use modalign::correlate::subspace_mac;
use modalign::dof::Dof;
use modalign::frf::EstimateOptions;
use modalign::linalg::{ComplexMatrix, complex_matrix, least_squares};
use modalign::modal::{ModalModel, Mode};
use modalign::quantity::FrfKind;
use modalign::record::{Channel, Hit};
use modalign::synth::{HalfSine, HammerTest, LowPass, Noise};
use num_complex::Complex64;

use crate::population::Member;

/// Peak over noise, as a power: 10 dB.
const MIN_PEAK_POWER_RATIO: f64 = 10.0;
/// Smallest separation of separated roots in half-power bandwidths.
const MIN_SEPARATION_BANDWIDTHS: f64 = 10.0;
/// Smallest MAC of a found mode.
const MIN_MAC: f64 = 0.9;

/// One root of the truth.
pub struct Root {
    /// Its modes in the truth, more than one where it is repeated.
    pub modes: Vec<usize>,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Half-power bandwidth, Hz.
    pub width_hz: f64,
    /// Cramér-Rao deviation of the frequency, Hz; `None` under the noise.
    pub std_hz: Option<f64>,
    /// See the head.
    pub observable: bool,
    /// See the head.
    pub separated: bool,
    /// How many found modes belong to it.
    pub found: usize,
}

/// A judged member.
pub struct Verdict {
    /// Every root in ascending frequency.
    pub roots: Vec<Root>,
    /// Spurious modes.
    pub spurious: usize,
}

/// Judges the modes found in the recording of a member.
pub fn judge(member: &Member, options: &EstimateOptions, found: &ModalModel) -> Verdict {
    let mut roots = roots(member, &FrfNoise::new(&member.test, options));
    let spurious = assign(member, &mut roots, &found.modes);
    Verdict { roots, spurious }
}

/// Assigns found modes to roots, nearest first, each root as many as it has modes; the remaining
/// modes are spurious.
fn assign(member: &Member, roots: &mut [Root], found: &[Mode]) -> usize {
    let mut offers = Vec::new();
    for (r, root) in roots.iter().enumerate() {
        let reach = root
            .std_hz
            .map_or(0.0, |std| 3.0 * std)
            .max(0.25 * root.width_hz);
        for (f, mode) in found.iter().enumerate() {
            let distance = (mode.frequency_hz - root.frequency_hz).abs();
            if distance <= reach && mac(member, root, mode) >= MIN_MAC {
                offers.push((distance, r, f));
            }
        }
    }
    offers.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken = vec![false; found.len()];
    for (_, r, f) in offers {
        if !taken[f] && roots[r].found < roots[r].modes.len() {
            taken[f] = true;
            roots[r].found += 1;
        }
    }
    taken.iter().filter(|taken| !**taken).count()
}

/// Share of a found shape in the span of a root's shapes, over the responses; 0 where a component
/// is missing.
fn mac(member: &Member, root: &Root, mode: &Mode) -> f64 {
    let responses = &member.test.hits[0].responses;
    let at = |mode: &Mode| -> Option<Vec<Complex64>> {
        let shape = responses.iter().map(|dof| mode.shape.along_positive(dof));
        shape.collect()
    };
    let truth = &member.test.truth.model.modes;
    let span: Option<Vec<_>> = root.modes.iter().map(|&j| at(&truth[j])).collect();
    let value = at(mode)
        .zip(span)
        .and_then(|(shape, span)| subspace_mac(&shape, &span));
    value.unwrap_or(0.0)
}

fn roots(member: &Member, noise: &FrfNoise) -> Vec<Root> {
    let truth = &member.test.truth.model.modes;
    let numbers: Vec<usize> = (0..truth.len()).collect();
    let same =
        |a: &usize, b: &usize| truth[*a].group.is_some() && truth[*a].group == truth[*b].group;
    let mut roots: Vec<Root> = numbers
        .chunk_by(same)
        .map(|modes| {
            let mode = &truth[modes[0]];
            Root {
                modes: modes.to_vec(),
                frequency_hz: mode.frequency_hz,
                width_hz: mode.pole().unwrap().half_power_width_hz(),
                std_hz: None,
                observable: false,
                separated: false,
                found: 0,
            }
        })
        .collect();
    let deviations = deviations_hz(member, &roots, noise);
    let spacings: Vec<f64> = (0..roots.len()).map(|r| spacing_hz(&roots, r)).collect();
    let separated: Vec<bool> = (0..roots.len()).map(|r| is_separated(&roots, r)).collect();
    for (r, root) in roots.iter_mut().enumerate() {
        root.std_hz = deviations[r];
        root.observable = deviations[r].is_some_and(|std| std < 0.25 * spacings[r]);
        root.separated = separated[r];
    }
    roots
}

/// Distance to the next root; to 0 Hz for the only one.
fn spacing_hz(roots: &[Root], r: usize) -> f64 {
    let others = roots.iter().enumerate().filter(|(other, _)| *other != r);
    let distance = |(_, other): (usize, &Root)| (other.frequency_hz - roots[r].frequency_hz).abs();
    others.map(distance).fold(roots[r].frequency_hz, f64::min)
}

fn is_separated(roots: &[Root], r: usize) -> bool {
    let this_root = &roots[r];
    let clear = |(other, root): (usize, &Root)| {
        let wider = root.width_hz.max(this_root.width_hz);
        other == r
            || (root.frequency_hz - this_root.frequency_hz).abs()
                >= MIN_SEPARATION_BANDWIDTHS * wider
    };
    this_root.modes.len() == 1 && roots.iter().enumerate().all(clear)
}

/// Cramér-Rao bound of every root's frequency, `None` for a root below the noise of all pairs.
///
/// For `sum_r R_rp/(i omega - lambda_r)` in white complex noise of variance `v_p` on lines `d
/// omega` apart, with the residues of all pairs unknown too: the information on the poles is
/// `G_rs = sum_p conj(R_rp) R_sp / v_p * S_rs / d omega`, with `S` the projection of the
/// derivatives `1/(i omega - lambda)^2` on the orthogonal complement of the functions `1/(i omega -
/// lambda)`; their scalar products over all frequencies are `-2 pi/(z)`, `2 pi/z^2` and `-4 pi/z^3`
/// with `z = conj(lambda_r) + lambda_s`. The variance of `Im lambda_r` is half of `(G^-1)_rr`; for
/// a lone root `2 sigma^3 d omega / (pi sum_p |R_p|^2/v_p)`.
fn deviations_hz(member: &Member, roots: &[Root], noise: &FrfNoise) -> Vec<Option<f64>> {
    let seen: Vec<(usize, Seen)> = roots
        .iter()
        .enumerate()
        .filter_map(|(r, root)| Some((r, Seen::new(member, root, noise)?)))
        .collect();
    let n = seen.len();
    let mut deviations = vec![None; roots.len()];
    if n == 0 {
        return deviations;
    }
    let z = |r: usize, s: usize| seen[r].1.lambda.conj() + seen[s].1.lambda;
    let plain = complex_matrix(n, n, |r, s| -TAU / z(r, s));
    let mixed = complex_matrix(n, n, |r, s| TAU / z(r, s).powi(2));
    let explained = least_squares(&plain, &mixed).unwrap();
    let left = |r: usize, s: usize| -> Complex64 {
        let part: Complex64 = (0..n)
            .map(|k| mixed[(k, r)].conj() * explained[(k, s)])
            .sum();
        -2.0 * TAU / z(r, s).powi(3) - part
    };
    let step_rad_s = TAU / member.test.record_s();
    let information = complex_matrix(n, n, |r, s| {
        let pairs = seen[r].1.whitened.iter().zip(&seen[s].1.whitened);
        let power: Complex64 = pairs.map(|(a, b)| a.conj() * b).sum();
        power * left(r, s) / step_rad_s
    });
    let covariance = least_squares(&information, &identity(n)).unwrap();
    for (k, (r, _)) in seen.iter().enumerate() {
        let variance = 0.5 * covariance[(k, k)].re;
        let std = variance.max(0.0).sqrt() / TAU;
        deviations[*r] = Some(if variance > 0.0 { std } else { f64::INFINITY });
    }
    deviations
}

fn identity(n: usize) -> ComplexMatrix {
    complex_matrix(n, n, |i, j| f64::from(u8::from(i == j)).into())
}

/// A root that stands over the noise.
struct Seen {
    lambda: Complex64,
    /// Residue of the accelerance over the deviation of its noise, by pair.
    whitened: Vec<Complex64>,
}

impl Seen {
    fn new(member: &Member, root: &Root, noise: &FrfNoise) -> Option<Self> {
        let truth = &member.test.truth.model.modes;
        let lambda = truth[root.modes[0]].pole().unwrap().lambda;
        let mut whitened = Vec::new();
        for (entry, plan) in member.test.hits.iter().enumerate() {
            for (k, response) in plan.responses.iter().enumerate() {
                let pair = (response.clone(), plan.hit.clone());
                let residue: Complex64 = root.modes.iter().map(|&j| truth[j].residues[&pair]).sum();
                let sides = [-0.5, 0.5].map(|side| {
                    let omega = TAU * (root.frequency_hz + side * root.width_hz);
                    noise.variance((entry, k), &pair, Complex64::new(0.0, omega))
                });
                whitened.push(lambda * lambda * residue / (0.5 * (sides[0] + sides[1])).sqrt());
            }
        }
        let peak = |a: &Complex64| (a / lambda.re).norm_sqr();
        let over = whitened.iter().any(|a| peak(a) >= MIN_PEAK_POWER_RATIO);
        over.then_some(Self { lambda, whitened })
    }
}

/// The expected noise of H1, from the plan alone.
struct FrfNoise<'a> {
    test: &'a HammerTest,
    filter: LowPass,
    /// Samples of the force that its window leaves, by energy.
    force_samples: f64,
    hits: Vec<HitNoise>,
}

/// Pulse and noise of one hit.
struct HitNoise {
    pulse: HalfSine,
    /// Rms of the noise of the force.
    force_rms: f64,
    /// Rms of the noise of every response.
    response_rms: Vec<f64>,
}

impl<'a> FrfNoise<'a> {
    fn new(test: &'a HammerTest, options: &EstimateOptions) -> Self {
        let clean = HammerTest {
            noise: Noise::default(),
            ..test.clone()
        };
        let hits = clean.generate().unwrap();
        let of_hit = |(i, hit)| HitNoise::new(test, i, hit);
        // The window is 1 up to the end of the pulse and its guard, and the mean square of a cosine
        // flank is 3/8.
        let window = options.force_window.map(|window| {
            test.pretrigger_s + test.pulse.duration_s + window.hold_s + 0.375 * window.flank_s
        });
        Self {
            test,
            filter: test.low_pass().unwrap(),
            force_samples: window.unwrap_or(test.record_s()) * test.sampling_rate_hz,
            hits: hits.iter().enumerate().map(of_hit).collect(),
        }
    }

    /// Variance of the accelerance H1 of a pair at s: `sum_h |F_h|^2 (N s_x^2 + |H|^2 W s_f^2) /
    /// (sum_h |F_h|^2)^2`.
    fn variance(&self, (entry, response): (usize, usize), pair: &(Dof, Dof), s: Complex64) -> f64 {
        let test = self.test;
        let kind = FrfKind::Accelerance;
        let h = test.truth.transfer(&pair.0, &pair.1, kind, s).unwrap();
        let gain = self.filter.transfer(s) * test.sampling_rate_hz;
        let first = entry * test.averages_per_point;
        let (mut excited, mut noisy) = (0.0, 0.0);
        for hit in &self.hits[first..first + test.averages_per_point] {
            let force = (hit.pulse.transform(s) * gain).norm_sqr();
            let from_force = h.norm_sqr() * self.force_samples * hit.force_rms.powi(2);
            let from_response = test.samples as f64 * hit.response_rms[response].powi(2);
            excited += force;
            noisy += force * (from_response + from_force);
        }
        (noisy / (excited * excited)).max(f64::MIN_POSITIVE)
    }
}

impl HitNoise {
    fn new(test: &HammerTest, i: usize, clean: &Hit) -> Self {
        let rms = |level: f64, db: Option<f64>| db.map_or(0.0, |db| level / 10f64.powf(db / 20.0));
        let force = clean.force.si();
        let peak = force.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let response = |channel: &Channel| {
            let samples = channel.si();
            let power: f64 = samples.iter().map(|v| v * v).sum();
            let level = (power / samples.len() as f64).sqrt();
            rms(level, test.noise.response_snr_db)
        };
        Self {
            pulse: test.pulses(i).unwrap()[0],
            force_rms: rms(peak, test.noise.force_snr_db),
            response_rms: clean.responses.iter().map(response).collect(),
        }
    }
}
