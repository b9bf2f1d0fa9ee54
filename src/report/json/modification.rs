//! Modified models and designs are written with the schema `modalign-modification/1`.

use serde::Serialize;

use crate::report::{DesignResult, ModifiedModes};
use crate::theory::RootState;
use crate::update::{DesignMode, Proposal};

use super::schema::json_text;

/// The schema of [`modification_to_json`].
pub const MODIFICATION_SCHEMA: &str = "modalign-modification/1";

#[derive(Serialize)]
struct ModificationFile<'a> {
    schema: &'static str,
    /// `null` without `--modify`.
    modified: Option<ModifiedFile<'a>>,
    /// `null` without `--target`.
    design: Option<DesignFile<'a>>,
}

#[derive(Serialize)]
struct ModifiedFile<'a> {
    changes: &'a [String],
    /// Whether the modes are tracked by shape; otherwise they are paired by MAC.
    tracked: bool,
    /// Whether `interval_95_hz` is known.
    uncertainty_known: bool,
    modes: Vec<ModeFile>,
}

#[derive(Serialize)]
struct ModeFile {
    mode: String,
    multiplicity: usize,
    before_hz: Option<f64>,
    after_hz: Option<f64>,
    change_percent: Option<f64>,
    mac: Option<f64>,
    damping_before: Option<f64>,
    damping_after: Option<f64>,
    interval_95_hz: Option<(f64, f64)>,
}

#[derive(Serialize)]
struct DesignFile<'a> {
    targets: &'a [String],
    met: bool,
    cost_in_prior_stds: bool,
    free: Vec<FreeFile<'a>>,
    combined: ProposalFile<'a>,
    /// By cost; those that do not meet the targets after them.
    single: Vec<ProposalFile<'a>>,
}

#[derive(Serialize)]
struct FreeFile<'a> {
    name: &'a str,
    unit: &'a str,
    value: f64,
    lower: f64,
    upper: f64,
}

#[derive(Serialize)]
struct ProposalFile<'a> {
    met: bool,
    cost: f64,
    short_by_percent: f64,
    parameters: Vec<ValueFile<'a>>,
    modes: Vec<DesignModeFile>,
}

#[derive(Serialize)]
struct ValueFile<'a> {
    name: &'a str,
    value: f64,
}

#[derive(Serialize)]
struct DesignModeFile {
    mode: String,
    multiplicity: usize,
    before_hz: f64,
    first_order_hz: f64,
    after_hz: f64,
}

/// The text of a modification, of a design or of both, ending in a newline.
pub fn modification_to_json(
    modified: Option<&ModifiedModes<'_>>,
    design: Option<&DesignResult<'_>>,
) -> String {
    json_text(&ModificationFile {
        schema: MODIFICATION_SCHEMA,
        modified: modified.map(modified_file),
        design: design.map(design_file),
    })
}

fn modified_file<'a>(modified: &'a ModifiedModes<'_>) -> ModifiedFile<'a> {
    let damping = |state: &Option<RootState>| state.as_ref().and_then(|state| state.damping_ratio);
    let rows = modified.rows();
    let mode = rows.iter().map(|row| {
        let change = row.change;
        let state = change.after.as_ref().or(change.before.as_ref());
        ModeFile {
            mode: row.label.clone(),
            multiplicity: state.map_or(0, |state| state.vectors.ncols()),
            before_hz: row.before_hz,
            after_hz: row.after_hz,
            change_percent: row.change_percent,
            mac: change.mac,
            damping_before: damping(&change.before),
            damping_after: damping(&change.after),
            interval_95_hz: row.interval_95_hz,
        }
    });
    ModifiedFile {
        changes: modified.changes,
        tracked: modified.modes.tracked,
        uncertainty_known: modified.relative_stds.is_some(),
        modes: mode.collect(),
    }
}

fn design_file<'a>(result: &'a DesignResult<'_>) -> DesignFile<'a> {
    let free = result.free.iter().map(|parameter| FreeFile {
        name: &parameter.name,
        unit: &parameter.unit,
        value: parameter.initial,
        lower: parameter.lower,
        upper: parameter.upper,
    });
    let proposal = |proposal: &'a Proposal| {
        let values = result.free.iter().zip(&proposal.free_values);
        let mode = |mode: &DesignMode| DesignModeFile {
            mode: result.label(mode),
            multiplicity: mode.multiplicity,
            before_hz: mode.before_hz,
            first_order_hz: mode.first_order_hz,
            after_hz: mode.after_hz,
        };
        ProposalFile {
            met: proposal.is_met,
            cost: proposal.cost,
            short_by_percent: 100.0 * proposal.violation,
            parameters: values
                .filter(|(parameter, value)| parameter.initial.to_bits() != value.to_bits())
                .map(|(parameter, value)| ValueFile {
                    name: &parameter.name,
                    value: *value,
                })
                .collect(),
            modes: proposal.modes.iter().map(mode).collect(),
        }
    };
    DesignFile {
        targets: result.targets,
        met: result.design.combined.is_met,
        cost_in_prior_stds: result.by_prior,
        free: free.collect(),
        combined: proposal(&result.design.combined),
        single: result
            .design
            .single
            .iter()
            .map(|(_, p)| proposal(p))
            .collect(),
    }
}
