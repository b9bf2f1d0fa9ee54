//! The tables of a modified model list its modes before and after stated changes, and the smallest
//! changes of parameters that move natural frequencies to targets.

use std::f64::consts::TAU;

use crate::axis::Band;
use crate::printable::counted;
use crate::theory::{ModeChange, ModeChanges, RootState};
use crate::update::{Design, DesignMode, FreeParameter, Proposal, frequency_interval_95};

use super::table::significant;
use super::{Block, Cell, Column, Table};

/// Maximum number of proposals of a single parameter in the table.
const MAX_SINGLE: usize = 6;
/// Smallest change that a proposal lists, as a part of the value.
const MIN_LISTED_CHANGE: f64 = 1e-4;

/// A model before and after stated changes.
#[derive(Clone, Debug)]
pub struct ModifiedModes<'a> {
    /// The changes as stated.
    pub changes: &'a [String],
    /// Its modes.
    pub modes: &'a ModeChanges,
    /// Relative standard deviation of each frequency after by the updated parameters, in the order
    /// of the modes; `None` where no uncertainty is known.
    pub relative_stds: Option<Vec<f64>>,
    /// Source of the uncertainty, or why there is none.
    pub uncertainty: String,
    /// Number of the first elastic mode in labels.
    pub first_root: usize,
    /// The band of the modes that are shown.
    pub band: Option<Band>,
}

/// A mode of [`ModifiedModes`] as tables and files show it.
#[derive(Clone, Debug)]
pub struct ModifiedMode<'a> {
    /// Label of the mode before; `new` for one without a partner there.
    pub label: String,
    /// The mode.
    pub change: &'a ModeChange,
    /// Frequency before, Hz.
    pub before_hz: Option<f64>,
    /// Frequency after, Hz.
    pub after_hz: Option<f64>,
    /// Change of the frequency, percent.
    pub change_percent: Option<f64>,
    /// 95 % interval of the frequency after, Hz.
    pub interval_95_hz: Option<(f64, f64)>,
}

impl ModifiedModes<'_> {
    /// The modes inside the band before or after.
    pub fn rows(&self) -> Vec<ModifiedMode<'_>> {
        let hz = |state: &Option<RootState>| state.as_ref().map(|s| s.omega_rad_s / TAU);
        let rigid = self
            .modes
            .modes
            .iter()
            .any(|change| hz(&change.before) == Some(0.0));
        let row = |(k, change): (usize, &'_ ModeChange)| {
            let (before_hz, after_hz) = (hz(&change.before), hz(&change.after));
            let label = match &change.before {
                None => "new".to_owned(),
                Some(state) => root_label(state.root, rigid, self.first_root),
            };
            let ends = before_hz.filter(|hz| *hz > 0.0).zip(after_hz);
            let stds = self.relative_stds.as_ref().map(|stds| stds[k]);
            ModifiedMode {
                label,
                before_hz,
                after_hz,
                change_percent: ends.map(|(before, after)| 100.0 * (after / before - 1.0)),
                interval_95_hz: after_hz
                    .filter(|hz| *hz > 0.0)
                    .zip(stds)
                    .map(|(hz, std)| frequency_interval_95(hz, std)),
                // The same lifetime as the modes.
                change: &self.modes.modes[k],
            }
        };
        let inside = |row: &ModifiedMode<'_>| {
            let ends = [row.before_hz, row.after_hz];
            self.band
                .is_none_or(|band| ends.iter().flatten().any(|hz| band.contains(*hz)))
        };
        let rows = self.modes.modes.iter().enumerate().map(row);
        rows.filter(inside).collect()
    }
}

/// Label of a root of the initial model by its number from 0.
pub(super) fn root_label(root: usize, has_rigid: bool, first_root: usize) -> String {
    match (root, has_rigid) {
        (0, true) => "rigid body".to_owned(),
        (root, true) => format!("f{}", root - 1 + first_root),
        (root, false) => format!("f{}", root + first_root),
    }
}

/// The modes before and after.
pub fn modification_block(model: &str, modified: &ModifiedModes<'_>) -> Block {
    let rows = modified.rows();
    let damping = |state: &Option<RootState>| state.as_ref().and_then(|state| state.damping_ratio);
    let damped = rows.iter().any(|row| {
        let ends = [&row.change.before, &row.change.after];
        ends.into_iter()
            .any(|state| damping(state).is_some_and(|ratio| ratio != 0.0))
    });
    let mut columns = vec![Column::text("mode")];
    let heads = [
        "modes",
        "f before (Hz)",
        "f after (Hz)",
        "change (%)",
        "MAC",
    ];
    columns.extend(heads.map(Column::number));
    if damped {
        columns.extend(["ζ before (%)", "ζ after (%)"].map(Column::number));
    }
    if modified.relative_stds.is_some() {
        columns.push(Column::text("95 % interval of f after (Hz)"));
    }
    let cells = |row: &ModifiedMode<'_>| {
        let change = row.change;
        let state = change.after.as_ref().or(change.before.as_ref());
        let mut cells = vec![
            Cell::text(&row.label),
            Cell::count(state.map_or(0, |state| state.vectors.ncols())),
            Cell::measured(row.before_hz, None),
            Cell::measured(row.after_hz, None),
            Cell::signed(row.change_percent, 3),
            Cell::mac(change.mac, 3),
        ];
        if damped {
            let percent = |state| Cell::number(damping(state).map(|ratio| 100.0 * ratio), 3);
            cells.extend([&change.before, &change.after].map(percent));
        }
        if modified.relative_stds.is_some() {
            let text = row.interval_95_hz.map(|(lower, upper)| {
                let half = Some(0.25 * (upper - lower));
                let cell = |hz| Cell::measured(Some(hz), half).display();
                format!("{} to {}", cell(lower), cell(upper))
            });
            cells.push(text.map_or(Cell::Missing, Cell::Text));
        }
        cells
    };
    let pairing = match modified.modes.tracked {
        true => "Modes are tracked by shape; in a veering f follows its locus and the MAC falls.",
        false => "Modes are paired by MAC alone: not all could be tracked by shape.",
    };
    let damping = "ζ is of first order in the damping matrix; --damped: exact.";
    let footnotes = [
        Some(pairing),
        Some(modified.uncertainty.as_str()),
        damped.then_some(damping),
    ];
    Block::Table(Table {
        caption: format!(
            "Modes of {model} before and after {}",
            modified.changes.join(", ")
        ),
        rows: rows.iter().map(cells).collect(),
        columns,
        footnotes: footnotes.into_iter().flatten().map(str::to_owned).collect(),
    })
}

/// Targets and the proposals that meet them.
#[derive(Clone, Debug)]
pub struct DesignResult<'a> {
    /// The targets as stated.
    pub targets: &'a [String],
    /// The parameters that may change.
    pub free: &'a [FreeParameter],
    /// The proposals.
    pub design: &'a Design,
    /// Whether costs are in prior standard deviations of `[update]` and not in logarithms.
    pub by_prior: bool,
    /// Number of the first elastic mode in labels.
    pub first_root: usize,
    /// The band of the modes that are shown.
    pub band: Option<Band>,
}

impl DesignResult<'_> {
    /// Label of a mode.
    pub fn label(&self, mode: &DesignMode) -> String {
        let modes = &self.design.combined.modes;
        let has_rigid = modes
            .iter()
            .any(|mode| mode.root == 0 && mode.before_hz == 0.0);
        root_label(mode.root, has_rigid, self.first_root)
    }

    fn changes(&self, proposal: &Proposal) -> String {
        let listed = self
            .free
            .iter()
            .zip(&proposal.free_values)
            .filter(|(p, value)| (**value - p.initial).abs() > MIN_LISTED_CHANGE * p.initial.abs());
        let text = |(parameter, value): (&FreeParameter, &f64)| {
            let value = significant(*value, 5);
            match parameter.initial == 0.0 {
                true => format!("{} = {value}", parameter.name),
                false => {
                    let percent = 100.0 * (proposal_ratio(parameter, proposal, self.free) - 1.0);
                    format!("{} = {value} ({percent:+.2} %)", parameter.name)
                }
            }
        };
        let all: Vec<String> = listed.map(text).collect();
        match all.is_empty() {
            true => "no change".to_owned(),
            false => all.join(", "),
        }
    }
}

fn proposal_ratio(of: &FreeParameter, proposal: &Proposal, free: &[FreeParameter]) -> f64 {
    let mut all = free.iter().zip(&proposal.free_values);
    let value = all.find(|(parameter, _)| parameter.index == of.index);
    value.map_or(1.0, |(_, value)| value / of.initial)
}

/// The ranked proposals, and all modes with the best one.
pub fn design_blocks(model: &str, result: &DesignResult<'_>) -> Vec<Block> {
    let design = result.design;
    let mut ranked: Vec<(String, &Proposal)> = vec![("combination".to_owned(), &design.combined)];
    let met = design.single.iter().filter(|(_, proposal)| proposal.is_met);
    let missed = design.single.len() - met.clone().count();
    let named = |(j, proposal): &'_ (usize, Proposal)| {
        (format!("{} alone", result.free[*j].name), proposal.clone())
    };
    let shown: Vec<(String, Proposal)> = match met.clone().count() {
        0 => design.single.iter().take(1).map(named).collect(),
        _ => met.take(MAX_SINGLE).map(named).collect(),
    };
    ranked.extend(
        shown
            .iter()
            .map(|(name, proposal)| (name.clone(), proposal)),
    );
    let unit = match result.by_prior {
        true => "squared changes in prior standard deviations",
        false => "squared logarithms of the ratios of the values",
    };
    let row = |(name, proposal): &(String, &Proposal)| {
        vec![
            Cell::text(name),
            Cell::text(if proposal.is_met { "met" } else { "not met" }),
            Cell::text(significant(proposal.cost, 4)),
            Cell::number(Some(100.0 * proposal.violation), 3),
            Cell::text(result.changes(proposal)),
        ]
    };
    let mut columns = ["proposal", "target"].map(Column::text).to_vec();
    columns.extend(["cost", "short by (%)"].map(Column::number));
    columns.push(Column::text("values"));
    let mut footnotes = vec![format!("Cost: sum of {unit}. Short by: of the frequency.")];
    footnotes.extend((missed > 0).then(|| {
        format!(
            "Not within the bounds alone: {missed} of {}.",
            counted(design.single.len(), "parameter")
        )
    }));
    let proposals = Table {
        caption: format!("Changes of {model} for {}", result.targets.join(", ")),
        columns,
        rows: ranked.iter().map(row).collect(),
        footnotes,
    };
    let modes = design.combined.modes.iter().filter(|mode| {
        let inside = |hz: f64| result.band.is_none_or(|band| band.contains(hz));
        inside(mode.before_hz) || inside(mode.after_hz)
    });
    let row = |mode: &DesignMode| {
        let change = (mode.before_hz > 0.0).then(|| mode.after_hz / mode.before_hz - 1.0);
        let error = (mode.after_hz > 0.0).then(|| mode.first_order_hz / mode.after_hz - 1.0);
        vec![
            Cell::text(result.label(mode)),
            Cell::count(mode.multiplicity),
            Cell::measured(Some(mode.before_hz), None),
            Cell::measured(Some(mode.after_hz), None),
            Cell::signed(change.map(|part| 100.0 * part), 3),
            Cell::measured(Some(mode.first_order_hz), None),
            Cell::signed(error.map(|part| 100.0 * part), 3),
        ]
    };
    let mut columns = vec![Column::text("mode")];
    let heads = [
        "modes",
        "f before (Hz)",
        "f after (Hz)",
        "change (%)",
        "first order (Hz)",
        "its error (%)",
    ];
    columns.extend(heads.map(Column::number));
    let modes = Table {
        caption: "Modes with the combination".to_owned(),
        columns,
        rows: modes.map(row).collect(),
        footnotes: vec![
            "First order: by the sensitivities of the model as it is; f after is solved again."
                .to_owned(),
        ],
    };
    let verdict = match design.combined.is_met {
        true => None,
        false => Some(Block::Text(
            "The targets cannot be met within the bounds; the combination comes nearest."
                .to_owned(),
        )),
    };
    let tables = [Block::Table(proposals), Block::Table(modes)];
    verdict.into_iter().chain(tables).collect()
}
