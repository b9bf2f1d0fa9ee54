//! The finding of a misfit against the errors that it makes: hardening resonances, whose frequency
//! rises with the response.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use crate::command::{succeed, write};

const LINES: usize = 700;
const STEP_HZ: f64 = 0.1;
/// Noise of an FRF over its rms.
const NOISE: f64 = 1e-4;
/// Natural frequency, damping ratio and shape.
const MODES: [(f64, f64, [f64; 4]); 2] = [
    (20.0, 0.01, [1.0, 0.7, -0.5, 0.9]),
    (45.0, 0.015, [0.8, -0.6, 1.0, 0.5]),
];

fn hz(line: usize) -> f64 {
    STEP_HZ * (line + 1) as f64
}

/// Receptance of a mode of unit mass whose frequency rises by `hardening` half bandwidths at its
/// peak, by fixed-point iteration.
fn hardened(natural_hz: f64, zeta: f64, hardening: f64, omega: f64) -> Complex64 {
    let omega_n = TAU * natural_hz;
    let receptance = |rise: f64| {
        let stiffness = (omega_n * (1.0 + rise)).powi(2);
        Complex64::new(stiffness - omega * omega, 2.0 * zeta * omega_n * omega).inv()
    };
    let mut response = receptance(0.0);
    for _ in 0..60 {
        let over_peak = (response.norm() * 2.0 * zeta * omega_n * omega_n).min(1.5);
        response = 0.5 * response + 0.5 * receptance(hardening * zeta * over_peak * over_peak);
    }
    response
}

fn dataset(kind: usize, point: usize, values: &[f64], columns: [&str; 2]) -> String {
    let code = if kind == 4 { 6 } else { 4 };
    let mut text = format!(
        "    -1\n    58\n{}{kind:>5}         0    0         0 NONE      {point:>10}   3 NONE               1   3\n\
         {code:>10}{LINES:>10}         1{:>13.5e}{STEP_HZ:>13.5e}{:>13.5e}\n\
        \x20       18    0    0    0 Frequency            Hz                  \n{}\n{}\n\
        \x20        0    0    0    0 NONE                 NONE                \n",
        "NONE\n".repeat(5),
        hz(0),
        0.0,
        columns[0],
        columns[1],
    );
    for row in values.chunks(4) {
        let row: String = row.iter().map(|value| format!("{value:>20.12e}")).collect();
        writeln!(text, "{row}").unwrap();
    }
    text + "    -1\n"
}

/// Accelerances of four sensors with the coherence that their noise leaves of two averages.
fn file(hardening: f64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut draw = || Distribution::<f64>::sample(&StandardNormal, &mut random);
    let none = "         0    0    0    0 NONE                 NONE                ";
    let ratio = [
        "        12    0    0    0 Acceleration         m/s2                ",
        "        13    0    0    0 Excit Force          N                   ",
    ];
    let mut text = String::new();
    for point in 0..4 {
        let value = |line: usize| {
            let omega = TAU * hz(line);
            let of_mode = |mode: &(f64, f64, [f64; 4])| {
                mode.2[point] * mode.2[0] * hardened(mode.0, mode.1, hardening, omega)
            };
            -omega * omega * MODES.iter().map(of_mode).sum::<Complex64>()
        };
        let clean: Vec<Complex64> = (0..LINES).map(value).collect();
        let power = clean.iter().map(Complex64::norm_sqr).sum::<f64>() / LINES as f64;
        let variance = NOISE * NOISE * power;
        let scale = (0.5 * variance).sqrt();
        let noisy = clean
            .iter()
            .map(|h| h + scale * Complex64::new(draw(), draw()));
        let noisy: Vec<Complex64> = noisy.collect();
        let parts: Vec<f64> = noisy.iter().flat_map(|h| [h.re, h.im]).collect();
        let coherence = noisy
            .iter()
            .map(|h| h.norm_sqr() / (h.norm_sqr() + variance));
        let coherence: Vec<f64> = coherence.collect();
        text += &dataset(4, point + 1, &parts, ratio);
        text += &dataset(6, point + 1, &coherence, [none, none]);
    }
    text
}

/// Largest error of the frequencies over the half-power bandwidth, and the finding of the misfit.
fn identified(hardening: f64) -> (f64, Option<Value>) {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("frfs.uff", &file(hardening))]);
    let path = folder.path().join("frfs.uff").display().to_string();
    let text = succeed(["identify", &path, "--averages", "2", "--json"]);
    let result: Value = serde_json::from_str(&text).unwrap();
    let found = result["modes"].as_array().unwrap();
    let error = |(hz, zeta, _): &(f64, f64, [f64; 4])| {
        let apart = found
            .iter()
            .map(|mode| (mode["frequency_hz"].as_f64().unwrap() - hz).abs());
        apart.fold(f64::MAX, f64::min) / (2.0 * zeta * hz)
    };
    let missed = |finding: &&Value| finding["code"] == "model-misfit";
    let findings = result["findings"].as_array().unwrap();
    let finding = findings.iter().find(missed).cloned();
    (MODES.iter().map(error).fold(0.0, f64::max), finding)
}

#[test]
fn hardening_is_reported_where_it_changes_the_modes() {
    // The misfit is three to seven times the noise, and no frequency is off by a twentieth of its
    // bandwidth.
    for hardening in [0.02, 0.1] {
        let (error, finding) = identified(hardening);
        assert!(error < 0.05, "{error}");
        assert_eq!(finding, None, "{hardening}");
    }
    let (error, finding) = identified(0.5);
    assert!(error > 0.05, "{error}");
    let finding = finding.expect("a finding of the misfit");
    let detail = finding["detail"].as_str().unwrap();
    // The residual, what it does, and the worst FRFs of all four.
    for part in [
        " % of the FRF, std × ",
        "σ(f)/Δf₃dB",
        "σ(ζ)/ζ",
        "|1:+Z × ",
        "4 of 4 FRFs",
    ] {
        assert!(detail.contains(part), "{part}: {detail}");
    }
}
