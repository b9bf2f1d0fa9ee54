//! Estimation on real recordings, against numbers computed elsewhere. Skipped where the recordings
//! are absent.

use std::io::Write;
use std::path::PathBuf;

use num_complex::Complex64;
use serde_json::Value;

use super::*;
use crate::axis::TimeAxis;
use crate::finding::Code;
use crate::quantity::Quantity;
use crate::record::{Channel, Hit, Role, Samples};
use crate::signal::{ONSET_FRACTION, Pulse};

/// The folder of the private recordings, when it is there.
fn recordings() -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let found = ["../shared/data", "../../shared/data"]
        .map(|folder| root.join(folder))
        .into_iter()
        .find(|folder| folder.is_dir());
    if found.is_none() {
        // Straight to the stream: the test harness must not swallow it.
        let _ = writeln!(std::io::stderr(), "skipped: no reference data");
    }
    found
}

fn read(path: PathBuf) -> Hit {
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let (force, response): (Vec<f64>, Vec<f64>) = reader
        .deserialize()
        .map(|row| row.unwrap())
        .map(|(force, response): (f64, f64)| (force, response))
        .unzip();
    let channel = |role, quantity, samples| Channel {
        role,
        dof: "1:+Z".parse().unwrap(),
        quantity,
        to_si: 1.0,
        samples: Samples::F64(samples),
    };
    Hit {
        axis: TimeAxis {
            start_s: 0.0,
            step_s: 1.0 / 48_000.0,
            len: force.len(),
        },
        force: channel(Role::Force, Quantity::Force, force),
        responses: vec![channel(Role::Response, Quantity::Acceleration, response)],
        origin: path.display().to_string(),
    }
}

fn plate() -> Option<(Vec<Hit>, Value)> {
    let folder = recordings()?;
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let name = |n: usize| folder.join(format!("tonewood-plate1/plate_1_frf_{n}.csv"));
    let hits = (1..=5).map(|n| read(name(n))).collect();
    Some((hits, expected["tonewood-plate1"].clone()))
}

fn complex(value: &Value) -> Complex64 {
    Complex64::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
}

#[test]
fn the_plate_has_the_listed_h1_h2_and_coherence() {
    let Some((hits, expected)) = plate() else {
        return;
    };
    let run = |estimator| {
        let options = EstimateOptions {
            estimator,
            ..EstimateOptions::default()
        };
        estimate(&hits, &options).unwrap()
    };
    let (h1, h2) = (run(Estimator::H1), run(Estimator::H2));
    assert_eq!(h1.axis().len, 48_001);
    let rows = expected["rect_window_full_record"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let k = row["index"].as_u64().unwrap() as usize;
        assert!((h1.axis().hz(k) - row["f_hz"].as_f64().unwrap()).abs() < 1e-9);
        for (set, name) in [(&h1, "H1"), (&h2, "H2")] {
            let expected = complex(&row[name]);
            let got = set.values(0)[k];
            assert!(
                (got - expected).norm() < 1e-6 * expected.norm(),
                "{name} {k}: {got} {expected}"
            );
        }
        let coherence = row["coh"].as_f64().unwrap();
        let got = h1.coherence(0).unwrap()[k];
        assert!((got / coherence - 1.0).abs() < 1e-6, "{k}: {got}");
    }
}

#[test]
fn the_pulses_of_the_plate_are_at_their_samples() {
    let Some((hits, expected)) = plate() else {
        return;
    };
    for (n, hit) in hits.iter().enumerate() {
        let pulse = Pulse::locate(&hit.force.si(), ONSET_FRACTION).unwrap();
        assert_eq!(
            Some(pulse.peak as u64),
            expected["force_peak_index"][n].as_u64()
        );
        assert!((50..=51).contains(&pulse.onset) && pulse.pretrigger_samples().len() >= 30);
        let peak = expected["force_peak"][n].as_f64().unwrap();
        assert!((pulse.height_n + pulse.level_n - peak).abs() < 1e-9);
    }
}

#[test]
fn the_plate_still_rings_when_its_record_ends() {
    let Some((hits, _)) = plate() else {
        return;
    };
    let bounds = truncation_bounds(&hits, &EstimateOptions::default()).unwrap();
    let truncation = bounds.values().next().unwrap();
    // Energies of the last two quarters, computed elsewhere: 936 and 223.2 over the five hits.
    let bound = truncation.bound.unwrap();
    assert!(
        (bound / (223.2f64 / 936.0).powi(2) - 1.0).abs() < 0.02,
        "{bound}"
    );
    let set = estimate(&hits, &EstimateOptions::default()).unwrap();
    assert_eq!(set.findings.last().unwrap().code, Code::Truncated);
    let band = usable_band(&hits, &EstimateOptions::default()).unwrap();
    assert!(
        (band.lo_hz - 0.5).abs() < 1e-9 && (1000.0..5000.0).contains(&band.hi_hz),
        "{band:?}"
    );
}
