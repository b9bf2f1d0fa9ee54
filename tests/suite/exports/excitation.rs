//! Random, burst random and sine excitation: FRFs by averages over blocks.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::universal_file::{
    DAMPING, FREQUENCY_HZ, Function, OneFile, Ran, accelerance_at, file_of, finds_the_mode, on_file,
};
use crate::command::write;

const RATE_HZ: f64 = 256.0;

/// A mass of 1 kg on its spring, by displacement and velocity.
struct Oscillator {
    state: [f64; 2],
}

/// Steps per sample at which the force is given; two of them are one of the integration.
const STEPS: usize = 8;
/// Time of a step.
const STEP_S: f64 = 1.0 / (RATE_HZ * STEPS as f64);

impl Oscillator {
    /// Acceleration at the samples of a force that is given at the steps.
    fn respond(&mut self, force: &[f64]) -> Vec<f64> {
        let natural = TAU * FREQUENCY_HZ;
        let rate =
            |f: f64, [x, v]: [f64; 2]| [v, f - 2.0 * DAMPING * natural * v - natural * natural * x];
        let mut out = Vec::with_capacity(force.len() / STEPS);
        for n in (0..force.len()).step_by(2) {
            let at = |ahead: usize| force.get(n + ahead).copied().unwrap_or_default();
            let (first, middle, last) = (at(0), at(1), at(2));
            if n.is_multiple_of(STEPS) {
                out.push(rate(first, self.state)[1]);
            }
            let state = self.state;
            let moved = |by: [f64; 2], share: f64| {
                [
                    state[0] + 2.0 * share * STEP_S * by[0],
                    state[1] + 2.0 * share * STEP_S * by[1],
                ]
            };
            let k1 = rate(first, state);
            let k2 = rate(middle, moved(k1, 0.5));
            let k3 = rate(middle, moved(k2, 0.5));
            let k4 = rate(last, moved(k3, 1.0));
            for (i, value) in self.state.iter_mut().enumerate() {
                *value += 2.0 * STEP_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        }
        out
    }
}

/// Noise up to some 60 Hz at the steps of this number of samples.
fn smooth_noise(samples: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    const HALF: usize = 128;
    let cutoff = 2.0 * 60.0 * STEP_S;
    let kernel: Vec<f64> = (0..=2 * HALF)
        .map(|n| {
            let at = n as f64 - HALF as f64;
            let window = (0.5 * std::f64::consts::PI * at / (HALF as f64 + 1.0))
                .cos()
                .powi(2);
            let angle = std::f64::consts::PI * cutoff * at;
            let sinc = if n == HALF { 1.0 } else { angle.sin() / angle };
            3.0 * cutoff.sqrt() * sinc * window
        })
        .collect();
    let steps = samples * STEPS;
    let white: Vec<f64> = (0..steps + 2 * HALF)
        .map(|_| random.sample(StandardNormal))
        .collect();
    let sum = |n: usize| kernel.iter().zip(&white[n..]).map(|(k, w)| k * w).sum();
    (0..steps).map(sum).collect()
}

/// Of values at the steps those at the samples.
fn sampled(force: &[f64]) -> Vec<f64> {
    force.iter().step_by(STEPS).copied().collect()
}

fn pair(version: i64, force: Vec<f64>, response: Vec<f64>) -> [Function; 2] {
    let of = |node, is_force, values| Function {
        version,
        axis: (0.0, 1.0 / RATE_HZ),
        ..Function::record(node, is_force, values)
    };
    [of(1, true, force), of(2, false, response)]
}

/// Records of bursts that have decayed when they end.
fn bursts(records: i64, samples: usize, noise: f64) -> Vec<Function> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let record = |version: i64| {
        let mut force = smooth_noise(samples, &mut random);
        for (n, value) in force.iter_mut().enumerate() {
            // Half a second each way, from 0.25 to 3 s.
            let time_s = n as f64 * STEP_S;
            let ramp = ((time_s - 0.25).min(3.0 - time_s) / 0.5).clamp(0.0, 1.0);
            *value *= 10.0 * (0.5 * std::f64::consts::PI * ramp).sin().powi(2);
        }
        let mut response = Oscillator { state: [0.0; 2] }.respond(&force);
        for value in &mut response {
            *value += noise * random.sample::<f64, _>(StandardNormal);
        }
        pair(version, sampled(&force), response)
    };
    (1..=records).flat_map(record).collect()
}

/// One long record of steady noise.
fn steady(samples: usize) -> Vec<Function> {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let force = smooth_noise(samples + 4096, &mut random);
    let mut response = Oscillator { state: [0.0; 2] }.respond(&force);
    for value in &mut response {
        *value += 1e-3 * random.sample::<f64, _>(StandardNormal);
    }
    pair(
        1,
        sampled(&force)[4096..].to_vec(),
        response[4096..].to_vec(),
    )
    .into()
}

fn frf(file: &OneFile, options: &[&str]) -> (Ran, std::path::PathBuf) {
    let out = file.folder().join("frfs.h5");
    let mut all = vec!["-o", out.to_str().unwrap()];
    all.extend(options);
    let ran = on_file("frf", &file.path(), &all);
    (ran, out)
}

#[test]
fn records_of_a_shaker_are_no_hits() {
    for functions in [bursts(3, 2048, 0.01), steady(8192)] {
        let file = OneFile::new("random.uff", file_of(&functions));
        let (ran, _) = frf(&file, &[]);
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(ran.error.contains("--excitation random"), "{ran:?}");
    }
}

#[test]
fn burst_random_gives_frfs_without_leakage() {
    let file = OneFile::new("burst.uff", file_of(&bursts(5, 2048, 0.01)));
    let (ran, out) = frf(&file, &["--excitation", "random"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(!ran.error.contains("block-leakage"), "{ran:?}");
    finds_the_mode(&out, &[]);
}

#[test]
fn steady_random_excitation_says_its_leakage_and_gives_the_mode() {
    let file = OneFile::new("steady.uff", file_of(&steady(1 << 16)));
    let (ran, out) = frf(&file, &["--excitation", "random", "--block-length", "4"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.error.contains("block-leakage"), "{ran:?}");
    let ran = on_file("identify", &out, &["--json"]);
    let modes = ran.json()["modes"].clone();
    assert_eq!(modes.as_array().unwrap().len(), 1, "{ran:?}");
    let near = |key: &str, truth: f64, part: f64| {
        let value = modes[0][key].as_f64().unwrap();
        assert!((value / truth - 1.0).abs() < part, "{key}: {value}");
    };
    near("frequency_hz", FREQUENCY_HZ, 1e-3);
    near("damping_ratio", DAMPING, 0.1);
}

#[test]
fn a_swept_sine_is_averaged_in_blocks() {
    let samples = 1 << 14;
    let mut phase = 0.0;
    let sweep = |n: usize| {
        let hz = 8.0 + 40.0 * (n % 16_384) as f64 / 16_384.0;
        phase += TAU * hz * STEP_S;
        10.0 * f64::sin(phase)
    };
    let force: Vec<f64> = (0..samples * STEPS).map(sweep).collect();
    let response = Oscillator { state: [0.0; 2] }.respond(&force);
    let file = OneFile::new("sweep.uff", file_of(&pair(1, sampled(&force), response)));
    let (ran, out) = frf(&file, &["--excitation", "sine"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let ran = on_file("identify", &out, &["--json", "--band", "10:40"]);
    let first = ran.json()["modes"][0]["frequency_hz"].as_f64().unwrap();
    assert!((first / FREQUENCY_HZ - 1.0).abs() < 3e-3, "{ran:?}");
}

#[test]
fn a_scene_states_random_excitation() {
    let file = OneFile::new("burst.uff", file_of(&bursts(4, 2048, 0.01)));
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"random\"\n[frf]\nexcitation = \
                 \"random\"\n[[test]]\nname = \"t\"\nfiles = [\"burst.uff\"]\n";
    write(file.folder(), &[("scene.toml", scene)]);
    let ran = on_file("run", file.folder(), &[]);
    assert!(ran.out.contains("20.0"), "{ran:?}");
    write(
        file.folder(),
        &[("scene.toml", &scene.replace("random\"\n[[", "hum\"\n[["))],
    );
    let ran = on_file("run", file.folder(), &[]);
    assert!(
        ran.error.contains("\"hammer\", \"random\" or \"sine\""),
        "{ran:?}"
    );
}

#[test]
fn burst_random_frfs_are_exact_within_their_variance() {
    let file = OneFile::new("burst.uff", file_of(&bursts(12, 3072, 0.3)));
    let (ran, out) = frf(&file, &["--excitation", "random", "--json"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let source = modalign::io::open_path(&out, &Default::default(), None).unwrap();
    let mut files = [modalign::io::HitFile::new(source)];
    let set = modalign::io::frf_sets(&mut files).unwrap().remove(0);
    let variance = set.variance(0).unwrap();
    let lines = set
        .axis()
        .lines(&modalign::axis::Band::new(10.0, 40.0).unwrap());
    let count = lines.len() as f64;
    let normalised: f64 = lines
        .map(|k| {
            let exact: Complex64 = accelerance_at(set.axis().hz(k), 1.0);
            (set.values(0)[k] - exact).norm_sqr() / variance[k]
        })
        .sum();
    let mean = normalised / count;
    assert!((0.7..1.4).contains(&mean), "{mean}");
}
