//! The truth of a synthetic test: modes of a model, some at stated frequencies, or modes from a
//! file.

use std::collections::BTreeSet;
use std::path::Path;

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::io::modes_from_json;
use crate::linalg::sort_ascending_by;
use crate::modal::{ModalModel, Mode, ModeShape};
use crate::synth::{HitPlan, Truth};
use crate::theory::ModeOptions;

use super::SceneError;
use super::error::value_error;
use super::model::theory;
use super::synth_spec::{SynthFile, TruthModeTable, TruthTable, folder_of};
use super::toml_text::read_text;

pub(super) fn truth(
    spec: &SynthFile,
    path: &Path,
    plans: &[HitPlan],
    sensors: &[Sensor],
) -> Result<Truth, SceneError> {
    let name = path.display().to_string();
    let table = &spec.truth;
    let hits: BTreeSet<Dof> = plans.iter().map(|plan| plan.hit.clone()).collect();
    let responses: BTreeSet<Dof> = plans
        .iter()
        .flat_map(|plan| plan.responses.iter().cloned())
        .collect();
    let (hits, responses): (Vec<_>, Vec<_>) =
        (hits.into_iter().collect(), responses.into_iter().collect());
    let folder = folder_of(path);
    if let Some(file) = &table.modes {
        let model = table.name.is_some() || table.file.is_some() || !table.parameters.is_empty();
        let has_options = table.damping_ratio.is_some() || table.highest_hz.is_some();
        if model || has_options || !table.mode.is_empty() {
            let got = "name, file, parameters, damping_ratio, highest_hz or mode beside `modes`";
            return Err(value_error(&name, "[truth]", got, "`modes` alone"));
        }
        let full = folder.join(file);
        let model = modes_from_json(&read_text(&full)?, &full.display().to_string())?;
        return modes_truth(model, &responses, &hits);
    }
    let damping = table.damping_ratio;
    if damping.is_none() {
        return Err(value_error(
            &name,
            "[truth] damping_ratio",
            "nothing",
            "a fraction; damping has no default",
        ));
    }
    let options = ModeOptions {
        band: truth_band(table, &name)?,
        count: None,
        damping_ratio: damping,
    };
    let mut model = theory(&table.model(), folder, &name, sensors, &options)?.modes;
    if !table.mode.is_empty() {
        model.modes = modes_at_stated_frequencies(&model, &table.mode, &name)?;
    }
    Ok(Truth::from_real_shapes(&model, &responses, &hits)?)
}

/// The rigid-body modes of the model, and of its elastic roots those that are named, at their new
/// frequencies.
fn modes_at_stated_frequencies(
    model: &ModalModel,
    wanted: &[TruthModeTable],
    path: &str,
) -> Result<Vec<Mode>, SceneError> {
    let (rigid, roots): (Vec<Vec<usize>>, Vec<Vec<usize>>) = model
        .roots()
        .into_iter()
        .partition(|root| model.modes[root[0]].frequency_hz <= 0.0);
    let mode_of_model = |index: &usize| model.modes[*index].clone();
    let mut modes: Vec<Mode> = rigid.iter().flatten().map(mode_of_model).collect();
    let mut taken = BTreeSet::new();
    for table in wanted {
        let key = format!("[[truth.mode]] root {}", table.root);
        let error = |got: &str, expected: &str| value_error(path, &key, got, expected);
        let number = table.root.checked_sub(1);
        let root = number.and_then(|index| roots.get(index)).ok_or_else(|| {
            let expected = format!("1 to {}, the elastic roots of the model", roots.len());
            error("no such root", &expected)
        })?;
        if !taken.insert(table.root) {
            return Err(error("the same root twice", "each one once"));
        }
        if !(table.frequency_hz.is_finite() && table.frequency_hz > 0.0) {
            let got = format!("frequency_hz {}", table.frequency_hz);
            return Err(error(&got, "a finite frequency above 0 Hz"));
        }
        let moved = |index: &usize| Mode {
            frequency_hz: table.frequency_hz,
            ..mode_of_model(index)
        };
        if table.shape.is_empty() {
            modes.extend(root.iter().map(moved));
            continue;
        }
        let given = table.shape.iter();
        let shape = given.map(|(dof, value)| (dof.clone(), Complex64::from(*value)));
        modes.push(Mode {
            group: None,
            shape: ModeShape::new(shape),
            ..moved(&root[0])
        });
    }
    sort_ascending_by(&mut modes, |mode| mode.frequency_hz);
    Ok(modes)
}

/// Modes with residues are taken as they are; real shapes of known modal mass make residues.
fn modes_truth(model: ModalModel, responses: &[Dof], hits: &[Dof]) -> Result<Truth, SceneError> {
    if model.modes.iter().all(|mode| !mode.residues.is_empty()) {
        return Ok(Truth {
            model,
            ..Truth::default()
        });
    }
    Ok(Truth::from_real_shapes(&model, responses, hits)?)
}

fn truth_band(table: &TruthTable, path: &str) -> Result<Option<Band>, SceneError> {
    let band = table.highest_hz.map(|hi| Band::new(0.0, hi)).transpose();
    band.map_err(|error| {
        value_error(
            path,
            "[truth] highest_hz",
            &format!("{:?}", table.highest_hz),
            &error.to_string(),
        )
    })
}
