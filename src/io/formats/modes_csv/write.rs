//! A table of modes as text, what it leaves out and what cannot be written.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::finding::Finding;
use crate::modal::{Mode, Scaling};

use super::column::{Column, FIRST, NAMED};
use super::read::FRACTIONS;
use crate::io::formats::damping_ratios::{LargeRatios, large_ratios};
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::{Catalog, IoError, ModeEntry};

/// A column with its cells.
type Cells<'a> = (String, Box<dyn Fn(&Mode) -> Option<String> + 'a>);

/// The table of these modes: columns that no mode has a value of are left out.
pub(super) fn text(modes: &[&Mode]) -> String {
    let mut columns: Vec<Cells<'_>> = NAMED
        .iter()
        .map(|(name, column)| -> Cells<'_> {
            (
                (*name).to_owned(),
                Box::new(|mode| named_cell(mode, column)),
            )
        })
        .filter(|(name, cell)| {
            FIRST.contains(&name.as_str()) || modes.iter().any(|mode| cell(mode).is_some())
        })
        .collect();
    let shapes = || modes.iter().flat_map(|mode| mode.shape.iter());
    let complex = shapes().any(|(_, value)| value.im.abs() > 0.0);
    let dofs: BTreeSet<Dof> = shapes().map(|(dof, _)| dof.clone()).collect();
    for dof in dofs {
        let shape_dof = dof.clone();
        let real: Cells<'_> = (
            if complex {
                format!("{dof} re")
            } else {
                dof.to_string()
            },
            Box::new(move |mode| mode.shape.get(&shape_dof).map(|value| value.re.to_string())),
        );
        columns.push(real);
        if complex {
            let name = format!("{dof} im");
            let imaginary = move |mode: &Mode| mode.shape.get(&dof).map(|v| v.im.to_string());
            columns.push((name, Box::new(imaginary)));
        }
    }
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let ratios = modes.iter().filter_map(|mode| mode.damping_ratio);
    let look_like_percent = large_ratios(ratios).is_some_and(LargeRatios::are_percent);
    let mut text = String::new();
    if look_like_percent {
        text += FRACTIONS;
        text.push('\n');
    }
    text += &names.join(",");
    text.push('\n');
    for mode in modes {
        let cells = columns
            .iter()
            .map(|(_, cell)| cell(mode).unwrap_or_default());
        text += &cells.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

fn named_cell(mode: &Mode, column: &Column) -> Option<String> {
    let number = |value: Option<f64>| value.map(|value| value.to_string());
    match column {
        Column::Frequency => number(Some(mode.frequency_hz)),
        Column::Damping => number(mode.damping_ratio),
        Column::FrequencyStd => number(mode.frequency_std_hz),
        Column::DampingStd => number(mode.damping_std),
        Column::ModalMass => number(mode.modal_mass_kg),
        Column::Group => mode.group.map(|group| group.to_string()),
        Column::Scaling => {
            let known = mode.scaling != Scaling::Unknown;
            known.then(|| mode.scaling.name().to_owned())
        }
        Column::Number | Column::Shape(..) => None,
    }
}

pub(super) fn dropped_content(catalog: &Catalog) -> Vec<Finding> {
    let mut lost = DroppedContent::default();
    lost.add("records and functions", catalog.entries.len());
    lost.add("geometry", catalog.geometry.len());
    lost.add("arrays without a meaning", catalog.arrays.len());
    let modal = |entry: &&ModeEntry| entry.modal_a.or(entry.modal_b).is_some();
    lost.add("modal A or B", catalog.modes.iter().filter(modal).count());
    let titled = |entry: &&ModeEntry| !entry.title.is_empty();
    lost.add(
        "titles of modes",
        catalog.modes.iter().filter(titled).count(),
    );
    let count = |has: fn(&Mode) -> bool| catalog.modes.iter().filter(|m| has(&m.mode)).count();
    lost.add("residues", count(|mode| !mode.residues.is_empty()));
    lost.add(
        "shapes of other quantities",
        count(|mode| !mode.other_shapes.is_empty()),
    );
    lost.add(
        "deviations of shapes",
        count(|mode| mode.shape_std.is_some()),
    );
    lost.add("biases of frequency and damping", count(has_bias));
    let with_method = count(|mode| {
        mode.order.is_some()
            || mode
                .method
                .as_ref()
                .is_some_and(|method| method != "theory")
    });
    lost.add("methods and orders of modes", with_method);
    lost.findings()
}

fn has_bias(mode: &Mode) -> bool {
    mode.frequency_bias_hz.or(mode.damping_bias).is_some()
}

/// The reader's error of a text that was not written.
pub(super) fn unwritable(error: IoError, path: &str) -> IoError {
    match error {
        IoError::Text {
            what,
            got,
            expected,
            ..
        } => IoError::Unwritable {
            path: path.to_owned(),
            what,
            got,
            expected,
        },
        other => other,
    }
}
