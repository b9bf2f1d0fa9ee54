//! `modes.json`, schema `modalign-modes/1`: the modal model as a file.

use std::collections::BTreeMap;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::Finding;
use crate::modal::{Grade, InputFile, ModalModel, Mode, ModeShape, Pole, Quality, Scaling};
use crate::printable::{one_line, printable_json};

use crate::io::IoError;
use crate::io::formats::damping_ratios::{StatedMode, correct_damping_ratios};
use crate::linalg::sort_ascending_by;

/// The schema text.
pub const MODES_SCHEMA: &str = "modalign-modes/1";

/// Frequency or damping and pole of one mode may differ by this fraction before the file
/// contradicts itself.
const REDUNDANCY: f64 = 1e-6;

#[derive(Serialize, Deserialize)]
struct ModesFile {
    schema: String,
    #[serde(default)]
    producer: String,
    #[serde(default)]
    inputs: Vec<InputJson>,
    band_hz: Option<[f64; 2]>,
    #[serde(default)]
    references: Vec<Dof>,
    added_damping_rad_s: Option<f64>,
    modes: Vec<ModeJson>,
    #[serde(default)]
    findings: Vec<Finding>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    synthetic: Option<serde_json::Value>,
}

#[derive(Serialize, Deserialize)]
struct InputJson {
    path: String,
    sha256: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    dofs: Vec<Dof>,
}

#[derive(Serialize, Deserialize)]
struct ModeJson {
    frequency_hz: Option<f64>,
    damping_ratio: Option<f64>,
    pole_rad_s: Option<[f64; 2]>,
    frequency_std_hz: Option<f64>,
    damping_std: Option<f64>,
    frequency_damping_correlation: Option<f64>,
    group: Option<u32>,
    #[serde(default)]
    shape: BTreeMap<Dof, [f64; 2]>,
    /// Of identified modes alone.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    other_shapes: BTreeMap<String, BTreeMap<Dof, [f64; 2]>>,
    shape_std: Option<BTreeMap<Dof, f64>>,
    #[serde(default)]
    residues: BTreeMap<PairKey, [f64; 2]>,
    modal_mass_kg: Option<f64>,
    scaling: Option<String>,
    mpc: Option<f64>,
    method: Option<String>,
    order: Option<usize>,
    mean_phase_rad: Option<f64>,
    mean_phase_deviation_rad: Option<f64>,
    modal_overlap: Option<f64>,
    half_power_lines: Option<f64>,
    frequency_bias_hz: Option<f64>,
    damping_bias: Option<f64>,
    /// Of identified modes alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    quality: Option<QualityJson>,
}

#[derive(Serialize, Deserialize)]
struct QualityJson {
    verdict: String,
    frequency: Option<String>,
    damping: Option<String>,
    shape: Option<String>,
    #[serde(default)]
    reasons: Vec<String>,
}

/// `response|reference`.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct PairKey(Dof, Dof);

impl Serialize for PairKey {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{}|{}", self.0, self.1))
    }
}

impl<'de> Deserialize<'de> for PairKey {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let text = String::deserialize(deserializer)?;
        let (response, reference) = text.split_once('|').ok_or_else(|| {
            D::Error::custom(format!(
                "residue key `{text}` in place of RESPONSE|REFERENCE"
            ))
        })?;
        Ok(PairKey(
            response.parse().map_err(D::Error::custom)?,
            reference.parse().map_err(D::Error::custom)?,
        ))
    }
}

fn parts(value: Complex64) -> [f64; 2] {
    [value.re, value.im]
}

fn complex([re, im]: [f64; 2]) -> Complex64 {
    Complex64::new(re, im)
}

/// The text of `modes.json`, ending in a newline; `synthetic` tells how a synthetic truth was made.
pub fn modes_to_json(model: &ModalModel, synthetic: Option<serde_json::Value>) -> String {
    let file = ModesFile {
        schema: MODES_SCHEMA.to_owned(),
        producer: model.producer.clone(),
        inputs: model
            .inputs
            .iter()
            .map(|i| InputJson {
                path: i.path.clone(),
                sha256: i.sha256.clone(),
                dofs: i.dofs.clone(),
            })
            .collect(),
        band_hz: model.band.map(|band| [band.lo_hz, band.hi_hz]),
        references: model.references.clone(),
        added_damping_rad_s: model.added_damping_rad_s,
        modes: model.modes.iter().map(mode_json).collect(),
        findings: model.findings.clone(),
        synthetic,
    };
    let text = serde_json::to_string_pretty(&file)
        .expect("every key is text and every number finite or null");
    printable_json(text) + "\n"
}

fn mode_json(mode: &Mode) -> ModeJson {
    ModeJson {
        frequency_hz: Some(mode.frequency_hz),
        damping_ratio: mode.damping_ratio,
        pole_rad_s: mode.pole().map(|pole| parts(pole.lambda)),
        frequency_std_hz: mode.frequency_std_hz,
        damping_std: mode.damping_std,
        frequency_damping_correlation: mode.frequency_damping_correlation,
        group: mode.group,
        shape: shape_parts(&mode.shape),
        other_shapes: mode
            .other_shapes
            .iter()
            .map(|(unit, shape)| (unit.clone(), shape_parts(shape)))
            .collect(),
        shape_std: mode.shape_std.clone(),
        residues: mode
            .residues
            .iter()
            .map(|((p, q), value)| (PairKey(p.clone(), q.clone()), parts(*value)))
            .collect(),
        modal_mass_kg: mode.modal_mass_kg,
        scaling: Some(mode.scaling.name().to_owned()),
        mpc: mode.mpc,
        method: mode.method.clone(),
        order: mode.order,
        mean_phase_rad: mode.mean_phase_rad,
        mean_phase_deviation_rad: mode.mean_phase_deviation_rad,
        modal_overlap: mode.modal_overlap,
        half_power_lines: mode.half_power_lines,
        frequency_bias_hz: mode.frequency_bias_hz,
        damping_bias: mode.damping_bias,
        quality: mode.quality.as_ref().map(quality_json),
    }
}

fn shape_parts(shape: &ModeShape) -> BTreeMap<Dof, [f64; 2]> {
    let components = shape.iter();
    components
        .map(|(dof, value)| (dof.clone(), parts(value)))
        .collect()
}

fn shape_of_parts(shape: BTreeMap<Dof, [f64; 2]>) -> ModeShape {
    let components = shape.into_iter();
    ModeShape::new(components.map(|(dof, value)| (dof, complex(value))))
}

fn quality_json(quality: &Quality) -> QualityJson {
    let name = |grade: Grade| grade.name().to_owned();
    QualityJson {
        verdict: name(quality.verdict),
        frequency: quality.frequency.map(name),
        damping: quality.damping.map(name),
        shape: quality.shape.map(name),
        reasons: quality.reasons.clone(),
    }
}

/// Reads `modes.json`; keys that it does not know are passed over.
///
/// # Errors
/// [`IoError::Json`] with line and column, or with the mode whose values contradict each other.
pub fn modes_from_json(text: &str, path: &str) -> Result<ModalModel, IoError> {
    let error = |line, column, got| IoError::Json {
        path: path.to_owned(),
        line,
        column,
        got,
        expected: "schema modalign-modes/1",
    };
    let file: ModesFile =
        serde_json::from_str(text).map_err(|e| error(e.line(), e.column(), e.to_string()))?;
    if file.schema != MODES_SCHEMA {
        return Err(error(1, 1, format!("schema {:?}", file.schema)));
    }
    let band = file
        .band_hz
        .map(|[lo, hi]| Band::new(lo, hi))
        .transpose()
        .map_err(|e| error(1, 1, e.to_string()))?;
    // A pole states frequency and damping a second time, so that both are as they are.
    let have_pole: Vec<bool> = file.modes.iter().map(|m| m.pole_rad_s.is_some()).collect();
    let numbered = file.modes.into_iter().enumerate();
    let modes = numbered.map(|(index, mode)| {
        read_mode(mode).map_err(|got| error(1, 1, format!("mode {}: {got}", index + 1)))
    });
    let mut modes: Vec<Mode> = modes.collect::<Result<_, _>>()?;
    let without_pole = modes
        .iter_mut()
        .zip(have_pole)
        .filter(|(_, has_pole)| !has_pole);
    let stated = without_pole.map(|(mode, _)| StatedMode { mode, line: None });
    let mut findings = file.findings;
    findings.extend(correct_damping_ratios(
        &mut stated.collect::<Vec<_>>(),
        path,
    ));
    sort_ascending_by(&mut modes, |mode| mode.frequency_hz);
    Ok(ModalModel {
        producer: one_line(&file.producer).into_owned(),
        inputs: file
            .inputs
            .into_iter()
            .map(|i| InputFile {
                path: i.path,
                sha256: i.sha256,
                dofs: i.dofs,
            })
            .collect(),
        band,
        references: file.references,
        added_damping_rad_s: file.added_damping_rad_s,
        modes,
        findings,
    })
}

/// Frequency and damping, from the pole where they are null.
fn frequency_and_damping(mode: &ModeJson) -> Result<(f64, Option<f64>), String> {
    let pole = mode.pole_rad_s.map(|value| Pole {
        lambda: complex(value),
    });
    let frequency = mode
        .frequency_hz
        .or_else(|| pole.map(|p| p.natural_frequency_hz()));
    let damping = mode
        .damping_ratio
        .or_else(|| pole.map(|p| p.damping_ratio()));
    let frequency = frequency.ok_or("neither frequency_hz nor pole_rad_s")?;
    if frequency.is_nan() || frequency < 0.0 {
        return Err(format!(
            "frequency_hz {frequency}, which is below 0 or no number"
        ));
    }
    if let (Some(pole), Some(zeta)) = (pole, damping) {
        let computed = Pole::from_frequency(frequency, zeta);
        if (computed.lambda - pole.lambda).norm() > REDUNDANCY * computed.lambda.norm() {
            return Err(format!(
                "pole_rad_s {} where frequency_hz and damping_ratio make it {}",
                pole.lambda, computed.lambda
            ));
        }
    }
    Ok((frequency, damping))
}

/// Maximum magnitude of a component of a shape or of a residue, whose square is a number with room
/// for sums.
const MAX_SIZE: f64 = 1e100;

/// Checks that no standard deviation is below 0.
fn check_stds(mode: &ModeJson) -> Result<(), String> {
    let stated = [
        ("frequency_std_hz", mode.frequency_std_hz),
        ("damping_std", mode.damping_std),
    ];
    let shape = mode.shape_std.iter().flatten();
    let shape = shape.map(|(_, std)| ("shape_std", Some(*std)));
    for (key, std) in stated.into_iter().chain(shape) {
        if let Some(std) = std.filter(|std| *std < 0.0) {
            return Err(format!("{key} {std}, which is below 0"));
        }
    }
    Ok(())
}

/// Checks that squares of the values of shapes and residues are numbers: a MAC of one that is none
/// would pass every limit.
fn check_sizes(mode: &ModeJson) -> Result<(), String> {
    let shape = mode.shape.values().map(|value| ("shape", value));
    let residues = mode.residues.values().map(|value| ("residues", value));
    for (key, value) in shape.chain(residues) {
        let size = complex(*value).norm();
        if size.is_nan() || size > MAX_SIZE {
            return Err(format!("{key} {size:e}, which is above {MAX_SIZE:e}"));
        }
    }
    if let Some(mpc) = mode.mpc.filter(|mpc| !(0.0..=1.0 + 1e-9).contains(mpc)) {
        return Err(format!("mpc {mpc}, which is not from 0 to 1"));
    }
    Ok(())
}

fn read_mode(mode: ModeJson) -> Result<Mode, String> {
    check_stds(&mode)?;
    check_sizes(&mode)?;
    let (frequency_hz, damping_ratio) = frequency_and_damping(&mode)?;
    let scaling = mode.scaling.as_deref().unwrap_or("unknown");
    let scaling = Scaling::from_name(scaling).ok_or_else(|| {
        format!("scaling {scaling:?} in place of unit-modal-mass, unit-max or unknown")
    })?;
    Ok(Mode {
        frequency_hz,
        damping_ratio,
        frequency_std_hz: mode.frequency_std_hz,
        damping_std: mode.damping_std,
        frequency_damping_correlation: mode.frequency_damping_correlation,
        group: mode.group,
        shape: shape_of_parts(mode.shape),
        other_shapes: mode
            .other_shapes
            .into_iter()
            .map(|(unit, shape)| (unit, shape_of_parts(shape)))
            .collect(),
        shape_std: mode.shape_std,
        residues: mode
            .residues
            .into_iter()
            .map(|(PairKey(p, q), value)| ((p, q), complex(value)))
            .collect(),
        modal_mass_kg: mode.modal_mass_kg,
        scaling,
        mpc: mode.mpc,
        method: mode.method.map(|method| one_line(&method).into_owned()),
        order: mode.order,
        mean_phase_rad: mode.mean_phase_rad,
        mean_phase_deviation_rad: mode.mean_phase_deviation_rad,
        modal_overlap: mode.modal_overlap,
        half_power_lines: mode.half_power_lines,
        frequency_bias_hz: mode.frequency_bias_hz,
        damping_bias: mode.damping_bias,
        quality: mode.quality.map(read_quality).transpose()?,
    })
}

fn read_quality(quality: QualityJson) -> Result<Quality, String> {
    let grade = |name: String| {
        let names = Grade::ALL.map(Grade::name).join(", ");
        Grade::from_name(&name).ok_or(format!("quality {name:?} in place of one of {names}"))
    };
    let value = |name: Option<String>| name.map(grade).transpose();
    Ok(Quality {
        verdict: grade(quality.verdict)?,
        frequency: value(quality.frequency)?,
        damping: value(quality.damping)?,
        shape: value(quality.shape)?,
        reasons: quality
            .reasons
            .iter()
            .map(|reason| one_line(reason).into_owned())
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{Code, Location, Severity};
    use proptest::prelude::*;

    fn dof(text: &str) -> Dof {
        text.parse().expect("the modes of this test can be read")
    }

    proptest! {
        #[test]
        fn a_model_comes_back_to_the_bit(f in 0.1..1e5f64, zeta in 1e-6..0.5f64, re in -1e-3..1e3f64, im in -1e9..1e-9f64) {
            let shape = ModeShape::new([(dof("12:+Z"), Complex64::new(re, im)), (dof("2:-X"), Complex64::new(im, re))]);
            let mut mode = Mode::new(f, Some(zeta), shape, Scaling::UnitMax);
            mode.residues.insert((dof("2:-X"), dof("1:+Z")), Complex64::new(im, re));
            mode.other_shapes.insert("Pa".to_owned(), mode.shape.scaled(re.into()));
            mode.frequency_std_hz = Some(re.abs());
            mode.mean_phase_rad = Some(zeta);
            mode.mean_phase_deviation_rad = Some(re.abs());
            mode.modal_overlap = Some(f);
            mode.half_power_lines = Some(f * zeta);
            (mode.frequency_bias_hz, mode.damping_bias) = (Some(1e-3 * f), Some(1e-3 * zeta));
            mode.quality = Some(Quality {
                verdict: Grade::Good,
                frequency: Some(Grade::Doubtful),
                damping: Some(Grade::Bad),
                shape: None,
                reasons: vec!["few-lines: 0.5".to_owned()],
            });
            let finding = Finding::new(Severity::Warning, Code::FewLines, Location::Mode(f)).value(re, "Hz");
            let model = ModalModel {
                producer: "test".to_owned(),
                band: Some(Band { lo_hz: 0.0, hi_hz: f }),
                references: vec![dof("1:+Z")],
                modes: vec![mode],
                findings: vec![finding],
                ..ModalModel::default()
            };
            prop_assert_eq!(modes_from_json(&modes_to_json(&model, None), "m.json").expect("the modes of this test can be read"), model);
        }
    }

    #[test]
    fn a_pole_alone_gives_frequency_and_damping() {
        let text = r#"{"schema": "modalign-modes/1", "modes": [{"pole_rad_s": [-3.0, 4.0], "shape": {"1:+X": [1, 0]}}]}"#;
        let mode = &modes_from_json(text, "m.json")
            .expect("the modes of this test can be read")
            .modes[0];
        assert!((mode.frequency_hz - 5.0 / std::f64::consts::TAU).abs() < 1e-15);
        assert!(
            (mode
                .damping_ratio
                .expect("the modes of this test can be read")
                - 0.6)
                .abs()
                < 1e-15
        );
    }

    #[test]
    fn contradictions_and_other_schemas_are_refused_with_their_place() {
        let message = |text: &str| modes_from_json(text, "m.json").unwrap_err().to_string();
        assert!(message(r#"{"schema": "other/1", "modes": []}"#).contains("schema \"other/1\""));
        let wrong = r#"{"schema": "modalign-modes/1", "modes": [{"frequency_hz": 1.0, "damping_ratio": 0.1, "pole_rad_s": [-1, 6]}]}"#;
        assert!(
            message(wrong).contains("mode 1: pole_rad_s"),
            "{}",
            message(wrong)
        );
        assert!(
            message("{\n  \"modes\": }").starts_with("m.json:2:12:"),
            "{}",
            message("{\n  \"modes\": }")
        );
    }

    #[test]
    fn damping_in_percent_is_judged_in_modes_without_a_pole() {
        let read = |damping: [f64; 2], pole: &str| {
            let modes = damping.map(|ratio| {
                format!(r#"{{"frequency_hz": 10.0, "damping_ratio": {ratio}, "damping_std": 0.5{pole}, "shape": {{"1:+X": [1, 0]}}}}"#)
            });
            let modes = modes.join(",");
            let text = format!(r#"{{"schema": "modalign-modes/1", "modes": [{modes}]}}"#);
            modes_from_json(&text, "m.json").expect("the modes of this test can be read")
        };
        let codes = |model: &ModalModel| -> Vec<Code> {
            model.findings.iter().map(|finding| finding.code).collect()
        };
        let percent = read([1.5, 0.5], "");
        assert_eq!(codes(&percent), [Code::DampingInPercent]);
        assert_eq!(percent.modes[0].damping_ratio, Some(0.015));
        assert_eq!(percent.modes[1].damping_std, Some(0.005));
        assert_eq!(codes(&read([0.3, 0.5], "")), [Code::DampingImplausible]);
        assert_eq!(codes(&read([0.01, -0.02], "")), [Code::NegativeDamping]);
        assert_eq!(codes(&read([0.01, 0.02], "")), []);
        // The pole of a mode that does not vibrate: -2 pi f (zeta +- sqrt(zeta^2 - 1)).
        let mut overdamped = ModalModel::default();
        let shape = ModeShape::new([(dof("1:+X"), Complex64::new(1.0, 0.0))]);
        overdamped.modes = vec![Mode::new(10.0, Some(1.5), shape, Scaling::UnitMax)];
        let text = modes_to_json(&overdamped, None);
        let read = modes_from_json(&text, "m.json").expect("the modes of this test can be read");
        assert_eq!(read, overdamped);
    }
}
