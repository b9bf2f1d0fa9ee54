//! Roving hammer and roving accelerometer, estimators and windows, from a recording to shapes with
//! their signs.

use std::path::Path;

use modalign::dof::Dof;
use modalign::io::modes_from_json;
use modalign::modal::{ModalModel, Mode};
use num_complex::Complex64;

use crate::command::{succeed, write};

const SHAPES: [[f64; 4]; 3] = [
    [1.0, 0.8, 0.3, -0.5],
    [0.9, -0.3, -0.8, 0.6],
    [0.7, -0.9, 0.4, 0.8],
];
const FREQUENCIES_HZ: [f64; 3] = [60.0, 145.0, 290.0];
const DAMPING: f64 = 0.01;

fn truth() -> String {
    let mode = |(hz, shape): (f64, [f64; 4])| {
        let values: Vec<String> = shape
            .iter()
            .enumerate()
            .map(|(i, v)| format!("\"{}:+Z\": [{v}, 0]", i + 1))
            .collect();
        format!(
            "{{\"frequency_hz\": {hz}, \"damping_ratio\": {DAMPING}, \"modal_mass_kg\": 2.0, \"shape\": {{{}}}}}",
            values.join(", ")
        )
    };
    let modes: Vec<String> = FREQUENCIES_HZ.into_iter().zip(SHAPES).map(mode).collect();
    format!(
        "{{\"schema\": \"modalign-modes/1\", \"modes\": [{}]}}",
        modes.join(", ")
    )
}

fn spec(samples: usize, hits: &str) -> String {
    format!(
        "schema = \"modalign-synth/1\"\ntitle = \"roving\"\nseed = 11\naverages = 4\n\
         truth = {{ modes = \"truth.json\" }}\n\
         record = {{ sampling_rate_hz = 1024, samples = {samples}, pretrigger_s = 0.02, response = \"acceleration\" }}\n\
         pulse = {{ duration_s = 2e-3, peak_n = 100, peak_spread = 0.2 }}\n\
         noise = {{ force_snr_db = 60, response_snr_db = 60 }}\n{hits}"
    )
}

const ROVING_SENSOR: &str = "[[hit]]\ndofs = [\"1:-Z\"]\nresponses = [\"1:+Z\", \"2:+Z\"]\n\
                             [[hit]]\ndofs = [\"1:-Z\"]\nresponses = [\"3:-Z\", \"4:+Z\"]\n";
const ROVING_HAMMER: &str =
    "[[hit]]\ndofs = [\"1:+Z\", \"2:+Z\", \"3:-Z\", \"4:+Z\"]\nresponses = [\"1:+Z\"]\n";

/// Recording to modes with these options of `frf`.
fn identify(folder: &Path, spec: &str, options: &[&str]) -> ModalModel {
    write(folder, &[("truth.json", &truth()), ("spec.toml", spec)]);
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    succeed(["synth", &path("spec.toml"), "-o", &path("hits.uff")]);
    let (hits, frfs, modes) = (path("hits.uff"), path("frf.uff"), path("modes.json"));
    succeed(["frf", &hits, "-o", &frfs].iter().chain(options));
    succeed(["identify", &frfs, "--band", "20:400", "-o", &modes]);
    modes_from_json(&std::fs::read_to_string(modes).unwrap(), "modes.json").unwrap()
}

/// Frequencies, damping and, on positive axes, real shapes of unit modal mass (truth: shape /
/// sqrt(2 kg)).
fn assert_truth(model: &ModalModel, damping_tolerance: f64) {
    assert_eq!(
        model.modes.len(),
        3,
        "{:?}",
        model
            .modes
            .iter()
            .map(|m| m.frequency_hz)
            .collect::<Vec<_>>()
    );
    for (index, mode) in model.modes.iter().enumerate() {
        let hz = FREQUENCIES_HZ[index];
        assert!(
            (mode.frequency_hz / hz - 1.0).abs() < 5e-4,
            "{} {hz}",
            mode.frequency_hz
        );
        let zeta = mode.damping_ratio.unwrap();
        assert!(
            (zeta / DAMPING - 1.0).abs() < damping_tolerance,
            "{hz} Hz: damping {zeta}"
        );
        assert_shape(mode, index);
    }
}

fn assert_shape(mode: &Mode, index: usize) {
    let scale = 2.0f64.sqrt();
    let value = |point: usize| {
        let dof: Dof = format!("{}:+Z", point + 1).parse().unwrap();
        scale * mode.shape.along_positive(&dof).unwrap()
    };
    let sign = value(0).re.signum();
    for (point, wanted) in SHAPES[index].iter().enumerate() {
        let error = (sign * value(point) - Complex64::from(*wanted)).norm();
        assert!(
            error < 0.03,
            "mode {} point {}: {} {wanted}",
            index + 1,
            point + 1,
            sign * value(point)
        );
    }
}

#[test]
fn a_roving_accelerometer_and_a_roving_hammer_give_the_same_signed_shapes() {
    for hits in [ROVING_SENSOR, ROVING_HAMMER] {
        let folder = tempfile::tempdir().unwrap();
        let model = identify(folder.path(), &spec(4096, hits), &["--force-window", "0.2"]);
        assert_truth(&model, 0.03);
    }
}

#[test]
fn every_estimator_finds_the_truth() {
    for options in [
        &["--estimator", "h2"][..],
        &["--estimator", "hv"],
        &["--estimator", "hv", "--noise-ratio", "1e4"],
    ] {
        let folder = tempfile::tempdir().unwrap();
        let all: Vec<&str> = ["--force-window", "0.2"]
            .iter()
            .chain(options)
            .copied()
            .collect();
        assert_truth(
            &identify(folder.path(), &spec(4096, ROVING_HAMMER), &all),
            0.05,
        );
    }
}

#[test]
fn a_force_window_that_cuts_the_filter_ringing_is_reported() {
    for (hold, reported) in [("0.005", true), ("0.2", false)] {
        let folder = tempfile::tempdir().unwrap();
        write(
            folder.path(),
            &[
                ("truth.json", &truth()),
                ("spec.toml", &spec(4096, ROVING_HAMMER)),
            ],
        );
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        succeed(["synth", &path("spec.toml"), "-o", &path("hits.uff")]);
        let summary = succeed(["frf", &path("hits.uff"), "--force-window", hold, "--json"]);
        assert_eq!(summary.contains("force-window-cuts"), reported, "{hold}");
    }
}

/// 0.5 s hold 1.9 time constants of the lowest mode: without a window its damping is far off, with
/// one it is not.
#[test]
fn the_damping_that_an_exponential_window_adds_is_taken_out() {
    let folder = tempfile::tempdir().unwrap();
    let short = spec(512, ROVING_HAMMER);
    let windowed = identify(
        folder.path(),
        &short,
        &["--force-window", "0.2", "--response-window", "0.005"],
    );
    let lowest = windowed.modes[0].damping_ratio.unwrap();
    assert!((lowest / DAMPING - 1.0).abs() < 0.1, "{lowest}");
    assert!(windowed.added_damping_rad_s.unwrap() > 10.0);
}
