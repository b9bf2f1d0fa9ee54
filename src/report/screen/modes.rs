//! Identified modes and the roots of a model on the screen.

use std::f64::consts::TAU;

use crate::axis::Band;
use crate::finding::{Code, Location, format_hz};
use crate::modal::{Grade, ModalModel, Mode};
use crate::report::modes::{largest_energy_fractions, remarks, root_labels};
use crate::report::{Block, Cell, Column, Table};
use crate::theory::ModelRoot;

use super::{MAC_DECIMALS, MAX_ROWS, counted, fitted, without_empty_columns};

/// Number of roots on the screen where no band is stated.
const MAX_ROOTS: usize = 20;
/// Frequencies that a line of advice names.
const MAX_NAMED_FREQUENCIES: usize = 4;
/// Widths at which remarks are wrapped, without and with a column of uncertain values.
const REMARK_WIDTHS: [usize; 2] = [32, 20];
/// Width at which the uncertain values are wrapped.
const UNCERTAIN_WIDTH: usize = 9;

/// Identified modes of a test: frequency, damping, their standard deviations, MPC and remarks, of
/// at most so many modes. Without modes the advice says what to try.
pub fn modes_screen(test: &str, model: &ModalModel, advice: &str, width: usize) -> Vec<Block> {
    let room = ModesRoom {
        width,
        rows: MAX_ROWS,
        remark_lines: usize::MAX,
    };
    modes_and_advice(test, model, advice, room)
}

/// The room of a table of modes.
#[derive(Clone, Copy)]
pub(super) struct ModesRoom {
    /// Characters in a line.
    pub width: usize,
    /// Maximum number of modes.
    pub rows: usize,
    /// Maximum number of lines of the remarks on a mode; the others are counted.
    pub remark_lines: usize,
}

/// As [`modes_screen`], in this room.
pub(super) fn modes_and_advice(
    test: &str,
    model: &ModalModel,
    advice: &str,
    room: ModesRoom,
) -> Vec<Block> {
    let mut blocks = listed_modes(test, model, advice, room);
    let on_band = advice_on_band(model);
    blocks.extend((!on_band.is_empty()).then(|| Block::Text(on_band.join("\n"))));
    blocks
}

/// What to try where a mode depends on the band.
fn advice_on_band(model: &ModalModel) -> Vec<String> {
    let edge = frequencies(model, Code::NearBandEdge).map(|hz| {
        format!(
            "Near the edge of the band: {hz}. Widen the band: --band LO:HI, or band_hz of the scene."
        )
    });
    let peaks = peak_frequencies(model).map(|hz| peaks_sentence(&hz));
    edge.into_iter().chain(peaks).collect()
}

/// The frequencies of the peaks without a mode, the first of many.
pub(super) fn peak_frequencies(model: &ModalModel) -> Option<String> {
    frequencies(model, Code::PeakWithoutMode)
}

pub(super) fn peaks_sentence(peaks: &str) -> String {
    format!("Peaks without a mode: {peaks}. Reasons: --explain peak-without-mode.")
}

/// The frequencies of the findings of a code, the first of many.
fn frequencies(model: &ModalModel, code: Code) -> Option<String> {
    let findings = model.findings.iter();
    let of_code = findings.filter(|finding| finding.code == code);
    let mut hz: Vec<String> = of_code
        .filter_map(|finding| match finding.location {
            Location::Mode(hz) => Some(format_hz(hz)),
            _ => None,
        })
        .collect();
    let further = hz.len().saturating_sub(MAX_NAMED_FREQUENCIES);
    hz.truncate(MAX_NAMED_FREQUENCIES);
    hz.extend((further > 0).then(|| format!("{further} more")));
    (!hz.is_empty()).then(|| hz.join(", "))
}

/// Remarks on a mode in lines of this width, the first ones and the number of the others.
fn remark_text(model: &ModalModel, mode: &Mode, width: usize, lines: usize) -> String {
    let all = remarks(model, mode);
    let parts: Vec<&str> = all.split(", ").collect();
    let text = |count: usize| {
        let further = parts.len() - count;
        let further = (further > 0).then(|| format!("{further} more"));
        let shown = parts[..count].iter().map(ToString::to_string);
        let shown: Vec<String> = shown.chain(further).collect();
        textwrap::fill(&shown.join(", "), width)
    };
    let fits = |count: &usize| text(*count).lines().count() <= lines;
    let count = (1..=parts.len()).rev().find(fits);
    text(count.unwrap_or(parts.len().min(1)))
}

/// The table of [`modes_screen`], in this room.
pub(super) fn listed_modes(
    test: &str,
    model: &ModalModel,
    advice: &str,
    room: ModesRoom,
) -> Vec<Block> {
    let ModesRoom {
        width,
        rows: most,
        remark_lines,
    } = room;
    if model.modes.is_empty() {
        let band = model.band.map_or(String::new(), |band| {
            format!(" between {} and {} Hz", band.lo_hz, band.hi_hz)
        });
        let sentence = format!("{test}: no modes were found{band}.");
        let text = format!("{sentence}\n{advice}");
        return vec![Block::Text(text.trim_end().to_owned())];
    }
    let percent = |ratio: Option<f64>| ratio.map(|ratio| 100.0 * ratio);
    let is_uncertain = |mode: &Mode| !uncertain_values(mode).is_empty();
    let has_uncertain = model.modes.iter().take(most).any(is_uncertain);
    let remark_width = REMARK_WIDTHS[usize::from(has_uncertain)];
    let row = |(number, mode): (usize, &Mode)| {
        let (damping, damping_std) = (percent(mode.damping_ratio), percent(mode.damping_std));
        vec![
            Cell::text(number.to_string()),
            Cell::measured(Some(mode.frequency_hz), mode.frequency_std_hz),
            Cell::std(mode.frequency_std_hz, 0),
            Cell::damping(damping, damping_std),
            Cell::std(damping_std, 0),
            Cell::mac(mode.mpc, MAC_DECIMALS),
            mode.quality.as_ref().map_or(Cell::Missing, |quality| {
                // Other words than those of its values, which may be uncertain where it is a mode.
                Cell::text(match quality.verdict {
                    Grade::Good => "yes",
                    Grade::Doubtful => "doubtful",
                    Grade::Bad => "no",
                })
            }),
            Cell::text(textwrap::fill(uncertain_values(mode), UNCERTAIN_WIDTH)),
            Cell::text(remark_text(model, mode, remark_width, remark_lines)),
        ]
    };
    let numbers = [
        "mode",
        "f (Hz)",
        "std (Hz)",
        "damping (%)",
        "std (%)",
        "MPC",
    ];
    let mut columns: Vec<Column> = numbers.map(Column::number).to_vec();
    columns.extend(["is a mode", "uncertain", "remark"].map(Column::text));
    let omitted = model.modes.get(most).map(|first| {
        let modes = counted(model.modes.len() - most, "further mode");
        format!("{modes} from {:.2} Hz: --full.", first.frequency_hz)
    });
    let meaning = has_uncertain.then(|| {
        "is a mode: of the structure, not of noise; uncertain: its values to check before use."
            .to_owned()
    });
    let table = Table {
        caption: format!("Identified modes: {test}"),
        columns,
        rows: (1..).zip(&model.modes).take(most).map(row).collect(),
        footnotes: omitted.into_iter().chain(meaning).collect(),
    };
    let table = without_empty_columns(
        table,
        &[
            "std (Hz)",
            "std (%)",
            "MPC",
            "is a mode",
            "uncertain",
            "remark",
        ],
    );
    vec![Block::Table(fitted(
        table,
        &["std (%)", "std (Hz)", "remark"],
        width,
    ))]
}

/// The values of a mode that need a check before they are used.
fn uncertain_values(mode: &Mode) -> &'static str {
    let Some(quality) = &mode.quality else {
        return "";
    };
    let [f, damping, shape] =
        [quality.frequency, quality.damping, quality.shape].map(|grade| grade > Some(Grade::Good));
    match (f, damping, shape) {
        (false, false, false) => "",
        (true, false, false) => "f",
        (false, true, false) => "damping",
        (false, false, true) => "shape",
        (true, true, false) => "f, damping",
        (true, false, true) => "f, shape",
        (false, true, true) => "damping, shape",
        (true, true, true) => "f, damping, shape",
    }
}

/// Natural frequencies of a model in the band, or the lowest ones, with the bodies that move most.
pub fn roots_screen(
    caption: &str,
    roots: &[ModelRoot],
    first_root: usize,
    band: Option<Band>,
    width: usize,
) -> Vec<Block> {
    let hz = |root: &ModelRoot| root.omega_rad_s / TAU;
    let inside = |root: &ModelRoot| band.is_none_or(|band| band.contains(hz(root)));
    let labels = root_labels(roots, first_root);
    let labelled = labels.iter().zip(roots).filter(|(_, root)| inside(root));
    let labelled: Vec<(&String, &ModelRoot)> = labelled.collect();
    if let (Some(band), true) = (band, labelled.is_empty()) {
        let (lo, hi) = (band.lo_hz, band.hi_hz);
        let sentence = format!("{caption}: none between {lo} and {hi} Hz.");
        return vec![Block::Text(sentence)];
    }
    let most = if band.is_some() { MAX_ROWS } else { MAX_ROOTS };
    let row = |(label, root): &(&String, &ModelRoot)| {
        vec![
            Cell::text(label.as_str()),
            Cell::text(root.modes.len().to_string()),
            Cell::measured(Some(hz(root)), None),
            root.class.clone().map_or(Cell::Missing, Cell::Text),
            Cell::text(largest_energy_fractions(root)),
        ]
    };
    let omitted = labelled.get(most).map(|(_, first)| {
        let more = counted(labelled.len() - most, "further root");
        let from = Cell::measured(Some(hz(first)), None).display();
        format!("{more} from {from} Hz: --full, or --band LO:HI.")
    });
    let mut columns = vec![Column::text("mode")];
    columns.extend(["multiplicity", "f (Hz)"].map(Column::number));
    columns.extend(["class", "kinetic energy"].map(Column::text));
    let table = Table {
        caption: caption.to_owned(),
        columns,
        rows: labelled.iter().take(most).map(row).collect(),
        footnotes: omitted.into_iter().collect(),
    };
    let table = without_empty_columns(table, &["class", "kinetic energy"]);
    vec![Block::Table(fitted(
        table,
        &["class", "kinetic energy"],
        width,
    ))]
}
