//! A synthetic test is computed from its spec and written as a measurement system exports it.

use std::path::Path;

use serde_json::json;

use crate::io::{FileLabel, Precision, modes_to_json, write_time_records};
use crate::modal::ModalModel;
use crate::quantity::Quantity;
use crate::synth::{HammerTest, HitPlan, LowPassOptions, Noise, Pulse, roving_hammer};

use super::SceneError;
use super::error::value_error;
use super::faults::{Faults, parse_checked};
use super::model::sensors;
use super::synth_spec::{SYNTH_SCHEMA, SynthFile};
use super::synth_truth::truth;
use super::toml_text::{check_schema, read_text};

/// A synthetic recording with its truth.
#[derive(Clone, Debug)]
pub struct SyntheticRecording {
    /// Title of the spec.
    pub title: String,
    /// The universal file, byte for byte.
    pub uff: Vec<u8>,
    /// The truth as `modes.json`.
    pub truth_json: String,
    /// The truth.
    pub truth: ModalModel,
}

/// Reads a spec.
///
/// # Errors
/// [`SceneError`] with file, line and column.
pub fn load_synth(path: &Path) -> Result<SynthFile, SceneError> {
    let name = path.display().to_string();
    let check = |spec: SynthFile, _| {
        let mut faults = Faults::default();
        faults.take(check_schema(&spec.schema, SYNTH_SCHEMA, &name));
        faults.take(sensors(&spec.sensor, &name));
        faults.take(response_quantity(&spec.record.response, &name));
        faults.take(precision(&spec, &name));
        for fault in spec_faults(&spec) {
            faults.add(value_error(&name, fault.key, &fault.got, fault.expected));
        }
        faults.into_result().map(|()| spec)
    };
    parse_checked(&read_text(path)?, &name, check)
}

/// A number of a spec outside its range.
struct SpecFault {
    key: &'static str,
    got: String,
    expected: &'static str,
}

/// The numbers of a spec that no test can have.
fn spec_faults(spec: &SynthFile) -> Vec<SpecFault> {
    let SynthFile { record, pulse, .. } = spec;
    let is_above_0 = |value: f64| value.is_finite() && value > 0.0;
    let (above_0, from_0) = ("a finite number above 0", "a finite number of 0 or more");
    let is_from_0 = |value: f64| value.is_finite() && value >= 0.0;
    let (is_fraction, fraction) = (|value: f64| (0.0..1.0).contains(&value), "0 up to below 1");
    let damping = spec.truth.damping_ratio.unwrap_or(0.0);
    let checks = [
        (
            "[record] sampling_rate_hz",
            record.sampling_rate_hz,
            is_above_0(record.sampling_rate_hz),
            above_0,
        ),
        (
            "[record] samples",
            record.samples as f64,
            record.samples >= 2,
            "2 or more",
        ),
        (
            "[record] pretrigger_s",
            record.pretrigger_s,
            is_from_0(record.pretrigger_s),
            from_0,
        ),
        (
            "[pulse] duration_s",
            pulse.duration_s,
            is_above_0(pulse.duration_s),
            above_0,
        ),
        (
            "[pulse] peak_n",
            pulse.peak_n,
            is_above_0(pulse.peak_n),
            above_0,
        ),
        (
            "[pulse] duration_spread",
            pulse.duration_spread,
            is_fraction(pulse.duration_spread),
            fraction,
        ),
        (
            "[pulse] peak_spread",
            pulse.peak_spread,
            is_fraction(pulse.peak_spread),
            fraction,
        ),
        (
            "averages",
            spec.averages as f64,
            spec.averages > 0,
            "1 or more",
        ),
        (
            "[truth] damping_ratio",
            damping,
            is_fraction(damping),
            fraction,
        ),
    ];
    let faulty = checks.into_iter().filter(|(_, _, is_valid, _)| !is_valid);
    let fault = |(key, got, _, expected): (_, f64, _, _)| SpecFault {
        key,
        got: got.to_string(),
        expected,
    };
    faulty.map(fault).collect()
}

/// The precision of the records in the file.
fn precision(spec: &SynthFile, path: &str) -> Result<Precision, SceneError> {
    match spec.record.precision.as_deref() {
        None | Some("single") => Ok(Precision::Single),
        Some("double") => Ok(Precision::Double),
        Some(other) => Err(value_error(
            path,
            "[record] precision",
            &format!("{other:?}"),
            "\"single\" or \"double\"",
        )),
    }
}

/// The test that a spec means; relative paths are taken from the spec's folder.
///
/// # Errors
/// [`SceneError`] for a value that cannot be meant, or the model's or the synthetic test's
/// reason.
pub fn hammer_test(spec: &SynthFile, path: &Path) -> Result<HammerTest, SceneError> {
    let name = path.display().to_string();
    let sensors = sensors(&spec.sensor, &name)?;
    let plans: Vec<HitPlan> = spec
        .hit
        .iter()
        .flat_map(|hit| roving_hammer(&hit.dofs, &hit.responses))
        .collect();
    let test = HammerTest {
        truth: truth(spec, path, &plans, &sensors)?,
        hits: plans,
        averages_per_point: spec.averages,
        sampling_rate_hz: spec.record.sampling_rate_hz,
        samples: spec.record.samples,
        pretrigger_s: spec.record.pretrigger_s,
        quantity: response_quantity(&spec.record.response, &name)?,
        pulse: Pulse {
            peak_n: spec.pulse.peak_n,
            peak_spread: spec.pulse.peak_spread,
            duration_s: spec.pulse.duration_s,
            duration_spread: spec.pulse.duration_spread,
        },
        filter: filter(spec),
        noise: Noise {
            force_snr_db: spec.noise.force_snr_db,
            response_snr_db: spec.noise.response_snr_db,
        },
        faults: crate::synth::Faults::default(),
        seed: spec.seed,
    };
    test.validate()?;
    Ok(test)
}

fn filter(spec: &SynthFile) -> LowPassOptions {
    let mut options = LowPassOptions::default();
    options.order = spec.filter.order.unwrap_or(options.order);
    options.ripple_db = spec.filter.ripple_db.unwrap_or(options.ripple_db);
    options.edge_over_sampling_rate = spec.filter.edge.unwrap_or(options.edge_over_sampling_rate);
    options
}

fn response_quantity(name: &str, path: &str) -> Result<Quantity, SceneError> {
    [
        Quantity::Acceleration,
        Quantity::Velocity,
        Quantity::Displacement,
    ]
    .into_iter()
    .find(|quantity| quantity.to_string() == name)
    .ok_or_else(|| {
        value_error(
            path,
            "[record] response",
            &format!("{name:?}"),
            "acceleration, velocity or displacement",
        )
    })
}

/// Generates the recording and writes it as a universal file, the truth as `modes.json` with the
/// filter beside.
///
/// # Errors
/// The errors of the synthetic test, or a degree of freedom that a universal file cannot name.
pub fn record(
    spec: &SynthFile,
    test: &HammerTest,
    path: &Path,
) -> Result<SyntheticRecording, SceneError> {
    let hits = test.generate()?;
    let name = path.display().to_string();
    let precision = precision(spec, &name)?;
    let mut uff = Vec::new();
    write_time_records(
        &mut uff,
        &FileLabel {
            path: &name,
            title: &spec.title,
        },
        &hits,
        precision,
    )?;
    let truth = test.truth_model();
    let low_pass = test.low_pass()?;
    let poles: Vec<[f64; 2]> = low_pass
        .poles_rad_s
        .iter()
        .map(|pole| [pole.re, pole.im])
        .collect();
    let synthetic = json!({
        "seed": spec.seed,
        "sampling_rate_hz": test.sampling_rate_hz,
        "filter": {
            "kind": "chebyshev-1 low-pass on every channel",
            "order": test.filter.order,
            "ripple_db": test.filter.ripple_db,
            "edge_hz": test.filter.edge_over_sampling_rate * test.sampling_rate_hz,
            "poles_rad_s": poles,
        },
    });
    Ok(SyntheticRecording {
        title: spec.title.clone(),
        uff,
        truth_json: modes_to_json(&truth, Some(synthetic)),
        truth,
    })
}
