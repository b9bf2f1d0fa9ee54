//! Time records of hits as recorders write them: channels that start late, are shorter, idle or
//! come one by one, and continuous records.

use std::f64::consts::TAU;
use std::path::Path;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::universal_file::{
    AxisLabel, DAMPING, FREQUENCY_HZ, Function, OneFile, Ran, Values, file_of, finds_the_mode,
    on_file,
};

const RATE_HZ: f64 = 512.0;
/// Four seconds: 0.7 % of the amplitude is left.
const SAMPLES: usize = 2048;
const NOISE: f64 = 1e-3;
/// Integration steps per sample.
const STEPS: usize = 32;

/// A half sine of 8 ms after 40 ms.
fn force_at(time_s: f64, hits_s: &[f64]) -> f64 {
    let pulse = |hit_s: &f64| {
        let phase = (time_s - hit_s) / 0.008;
        match (0.0..1.0).contains(&phase) {
            true => 100.0 * (std::f64::consts::PI * phase).sin(),
            false => 0.0,
        }
    };
    hits_s.iter().map(pulse).sum()
}

/// The acceleration of a mass of 1 kg on its spring at these times, hit at these.
fn acceleration(hits_s: &[f64], late_s: f64, samples: usize) -> Vec<f64> {
    let natural = TAU * FREQUENCY_HZ;
    let step_s = 1.0 / (RATE_HZ * STEPS as f64);
    let rate = |time_s: f64, [x, v]: [f64; 2]| {
        let a = force_at(time_s, hits_s) - 2.0 * DAMPING * natural * v - natural * natural * x;
        [v, a]
    };
    let offset = (late_s / step_s).round() as usize;
    let mut state = [0.0, 0.0];
    let mut out = Vec::with_capacity(samples);
    for step in 0.. {
        let time_s = step as f64 * step_s;
        if step >= offset && (step - offset).is_multiple_of(STEPS) {
            out.push(rate(time_s, state)[1]);
            if out.len() == samples {
                return out;
            }
        }
        let moved = |by: [f64; 2], share: f64| {
            [
                state[0] + share * step_s * by[0],
                state[1] + share * step_s * by[1],
            ]
        };
        let k1 = rate(time_s, state);
        let k2 = rate(time_s + 0.5 * step_s, moved(k1, 0.5));
        let k3 = rate(time_s + 0.5 * step_s, moved(k2, 0.5));
        let k4 = rate(time_s + step_s, moved(k3, 1.0));
        for (i, value) in state.iter_mut().enumerate() {
            *value += step_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    out
}

fn noisy(mut values: Vec<f64>, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for value in &mut values {
        *value += NOISE * random.sample::<f64, _>(StandardNormal);
    }
    values
}

fn force_record(hits_s: &[f64], samples: usize, version: i64) -> Function {
    let times = (0..samples).map(|n| n as f64 / RATE_HZ);
    let values = times.map(|time_s| force_at(time_s, hits_s)).collect();
    record(1, true, noisy(values, version.unsigned_abs()), version)
}

fn response_record(hits_s: &[f64], late_s: f64, samples: usize, version: i64) -> Function {
    let values = acceleration(hits_s, late_s, samples);
    let mut response = record(
        2,
        false,
        noisy(values, 100 + version.unsigned_abs()),
        version,
    );
    response.axis.0 = late_s;
    response
}

fn record(node: i64, is_force: bool, values: Vec<f64>, version: i64) -> Function {
    Function {
        version,
        axis: (0.0, 1.0 / RATE_HZ),
        ..Function::record(node, is_force, values)
    }
}

/// Three hits of a force and a response, the response this late and of this length.
fn three_hits(late_s: f64, samples: usize) -> Vec<Function> {
    let hit = |version| {
        [
            force_record(&[0.04], SAMPLES, version),
            response_record(&[0.04], late_s, samples, version),
        ]
    };
    (1..=3).flat_map(hit).collect()
}

/// `frf FILE -o FRFs`, then the mode of the FRFs; what `frf` printed.
fn finds_the_mode_of_the_hits(file: &Path, options: &[&str]) -> (Ran, serde_json::Value) {
    let out = file.with_file_name("frfs.h5");
    let mut all = vec!["-o", out.to_str().unwrap()];
    all.extend(options);
    let ran = on_file("frf", file, &all);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let modes = finds_the_mode(&out, &[]).json();
    (ran, modes)
}

fn residue_phase(modes: &serde_json::Value) -> f64 {
    let residues = modes["modes"][0]["residues"].as_object().unwrap();
    let residue = residues.values().next().unwrap();
    let part = |index: usize| residue[index].as_f64().unwrap();
    part(1).atan2(part(0))
}

#[test]
fn a_channel_that_starts_late_has_the_phase_of_one_that_does_not() {
    let file = OneFile::new("hits.uff", file_of(&three_hits(0.0, SAMPLES)));
    let (_, modes) = finds_the_mode_of_the_hits(&file.path(), &[]);
    let phase = residue_phase(&modes);
    // 11 us, half a sample, and a sample and a half.
    for late_s in [1.1e-5, 0.000_976_562_5, 0.002_929_687_5] {
        let file = OneFile::new("late.uff", file_of(&three_hits(late_s, SAMPLES)));
        let (ran, modes) = finds_the_mode_of_the_hits(&file.path(), &[]);
        let error = residue_phase(&modes) - phase;
        assert!(error.abs() < 0.01, "{late_s}: {error}");
        assert!(ran.error.contains("channel-delay-corrected"), "{ran:?}");
    }
}

#[test]
fn a_channel_that_is_a_sample_shorter_shortens_the_hit() {
    for samples in [SAMPLES - 1, SAMPLES + 3] {
        let file = OneFile::new("short.uff", file_of(&three_hits(0.0, samples)));
        finds_the_mode_of_the_hits(&file.path(), &[]);
    }
}

#[test]
fn channels_of_other_records_are_named_with_the_reason() {
    let file = OneFile::new("late.uff", file_of(&three_hits(0.3, SAMPLES)));
    let ran = on_file("frf", &file.path(), &[]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.error.contains("from 0.3 s"), "{ran:?}");
    let file = OneFile::new("short.uff", file_of(&three_hits(0.0, SAMPLES / 2)));
    let ran = on_file("frf", &file.path(), &[]);
    assert!(ran.error.contains("1024 samples"), "{ran:?}");
}

#[test]
fn an_idle_hammer_is_left_out() {
    let idle = |version: i64, other: f64| {
        let mut idle = force_record(&[0.04], SAMPLES, version);
        idle.response.node = 3;
        if let Values::Real(values) = &mut idle.values {
            values.iter_mut().for_each(|value| *value *= other);
        }
        idle
    };
    for (version_of, other) in [(1, 0.0), (1, 0.01), (0, 0.001)] {
        let mut functions = Vec::new();
        for (number, pair) in three_hits(0.0, SAMPLES).chunks(2).enumerate() {
            let version = version_of * (number as i64 + 1);
            let mut hit = vec![pair[0].clone(), idle(version, other), pair[1].clone()];
            hit.iter_mut().for_each(|record| record.version = version);
            functions.extend(hit);
        }
        let file = OneFile::new("two.uff", file_of(&functions));
        let (ran, modes) = finds_the_mode_of_the_hits(&file.path(), &[]);
        assert!(
            ran.error.contains("idle-force") && ran.error.contains("3:+Z"),
            "{ran:?}"
        );
        assert!(modes["modes"][0]["residues"]["2:+Z|1:+Z"].is_array());
    }
    // Both hammers hit: an error that says so.
    let mut functions = three_hits(0.0, SAMPLES);
    functions.insert(1, idle(1, 0.7));
    let file = OneFile::new("two.uff", file_of(&functions));
    let ran = on_file("frf", &file.path(), &[]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.error.contains("2 force"), "{ran:?}");
}

#[test]
fn a_tacho_beside_hits_is_left_out() {
    let mut functions = Vec::new();
    for pair in three_hits(0.0, SAMPLES).chunks(2) {
        let mut tacho = record(9, false, vec![2.5; SAMPLES], pair[0].version);
        (tacho.response.name, tacho.response.direction) = ("Tacho".to_owned(), 0);
        tacho.ordinate = AxisLabel::new(1, "Tacho", "V");
        functions.extend([pair[0].clone(), pair[1].clone(), tacho]);
    }
    let file = OneFile::new("tacho.uff", file_of(&functions));
    let (ran, _) = finds_the_mode_of_the_hits(&file.path(), &[]);
    assert!(ran.error.contains("function-left-out"), "{ran:?}");
}

#[test]
fn channels_that_come_one_by_one_make_hits() {
    for is_numbered in [true, false] {
        let mut functions = three_hits(0.0, SAMPLES);
        let is_force = |record: &Function| record.ordinate.data_type == 13;
        functions.sort_by_key(|record| !is_force(record));
        if !is_numbered {
            functions.iter_mut().for_each(|record| record.version = 0);
        }
        let file = OneFile::new("channels.uff", file_of(&functions));
        finds_the_mode_of_the_hits(&file.path(), &[]);
    }
}

#[test]
fn channels_in_separate_files_make_hits() {
    let functions = three_hits(0.0, SAMPLES);
    let of = |is_force: bool| {
        let records = functions
            .iter()
            .filter(|f| (f.ordinate.data_type == 13) == is_force);
        file_of(&records.cloned().collect::<Vec<_>>())
    };
    let file = OneFile::new("force.uff", of(true));
    let response = file.folder().join("response.uff");
    std::fs::write(&response, of(false)).unwrap();
    finds_the_mode_of_the_hits(&file.path(), &[response.to_str().unwrap()]);
}

#[test]
fn a_continuous_record_is_cut_where_that_is_plain() {
    for hits_s in [&[0.5, 4.5, 8.6][..], &[0.3, 5.0], &[1.0, 5.2, 9.1, 13.0]] {
        let samples = SAMPLES * hits_s.len() + 512;
        let functions = [
            force_record(hits_s, samples, 0),
            response_record(hits_s, 0.0, samples, 0),
        ];
        let file = OneFile::new("long.uff", file_of(&functions));
        let (ran, _) = finds_the_mode_of_the_hits(&file.path(), &[]);
        assert!(ran.error.contains("cut-by-trigger"), "{ran:?}");
        let whole = on_file("frf", &file.path(), &["--hits", "records"]);
        assert!(!whole.error.contains("cut-by-trigger"), "{whole:?}");
    }
}

#[test]
fn a_double_hit_is_no_continuous_record() {
    let double = [0.04, 0.16];
    let mut functions = three_hits(0.0, SAMPLES);
    functions[0] = force_record(&double, SAMPLES, 1);
    functions[1] = response_record(&double, 0.0, SAMPLES, 1);
    let file = OneFile::new("double.uff", file_of(&functions));
    let ran = on_file("frf", &file.path(), &[]);
    assert!(!(ran.out + &ran.error).contains("cut-by-trigger"));
}
