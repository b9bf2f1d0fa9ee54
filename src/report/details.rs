//! The detail tables compare models of increasing detail and name the simplest sufficient one.

use std::f64::consts::TAU;

use crate::theory::{DetailComparison, ModelRoot, SimplerModel, TimeResponse, simplest_detail};

use super::modes::root_labels;
use super::{Block, Cell, Column, Table};

/// Errors of every natural frequency in every model, with the simplest model within an error; and
/// detail and cost of the models.
pub fn details_blocks(
    model: &str,
    comparison: &DetailComparison,
    first_root: usize,
    within: f64,
) -> Vec<Block> {
    let labels = root_labels(&comparison.roots, first_root);
    let mut columns = vec![Column::text("mode"), Column::number("f (Hz)")];
    let head =
        |simpler: &SimplerModel| Column::number(format!("{} coordinates (%)", simpler.coordinates));
    columns.extend(comparison.models.iter().map(head));
    columns.push(Column::number(format!(
        "simplest within {} %",
        100.0 * within
    )));
    let row = |(i, root): (usize, &ModelRoot)| {
        let errors = (0..comparison.models.len())
            .map(|model| Cell::signed(comparison.error(model, i).map(|error| 100.0 * error), 4));
        let simplest = comparison.simplest(i, within);
        let mut cells = vec![
            Cell::text(&labels[i]),
            Cell::number(Some(root.omega_rad_s / TAU), 4),
        ];
        cells.extend(errors);
        cells.push(simplest.map_or(Cell::Missing, |simplest| {
            Cell::text(simplest.coordinates.to_string())
        }));
        cells
    };
    let errors = Block::Table(Table {
        caption: format!("Natural frequencies of simpler models of {model}"),
        columns,
        rows: comparison.roots.iter().enumerate().map(row).collect(),
        footnotes: vec![
            "Error = (simpler − whole)/whole, matched by shape. —: the model has no such mode."
                .to_owned(),
        ],
    });
    vec![errors, models_block(model, comparison, within)]
}

fn models_block(model: &str, comparison: &DetailComparison, within: f64) -> Block {
    let whole = comparison
        .models
        .last()
        .map_or(1, |model| model.coordinates);
    let accurate_up_to_hz = |i: usize| {
        let is_within_error = |root: &usize| {
            comparison
                .error(i, *root)
                .is_some_and(|error| error.abs() <= within)
        };
        let all = 0..comparison.roots.len();
        all.take_while(is_within_error)
            .last()
            .map(|root| comparison.roots[root].omega_rad_s / TAU)
    };
    let row = |(i, simpler): (usize, &SimplerModel)| {
        vec![
            Cell::text(&simpler.name),
            Cell::text(simpler.coordinates.to_string()),
            Cell::number(Some(100.0 * simpler.cost(whole)), 1),
            Cell::number(accurate_up_to_hz(i), 4),
        ]
    };
    Block::Table(Table {
        caption: format!("Detail and cost of the models of {model}"),
        columns: vec![
            Column::text("model"),
            Column::number("coordinates"),
            Column::number("cost (%)"),
            Column::number(format!(
                "all frequencies within {} % up to (Hz)",
                100.0 * within
            )),
        ],
        rows: comparison.models.iter().enumerate().map(row).collect(),
        footnotes: vec![
            "Cost: third power of the number of coordinates, as of an eigenproblem.".to_owned(),
        ],
    })
}

/// For each signal of a response the simplest detail within an error, with its evaluations.
pub fn simplest_details_block(model: &str, response: &TimeResponse, within: f64) -> Block {
    let signals = response
        .details
        .last()
        .map_or(&[][..], |detail| &detail.signals);
    let rows = signals.iter().map(|signal| {
        let found = simplest_detail(response, signal.name, within);
        let detail = found.and_then(|name| response.detail(name));
        vec![
            Cell::text(signal.name),
            Cell::text(signal.meaning),
            found.map_or(Cell::Missing, Cell::text),
            detail.map_or(Cell::Missing, |detail| {
                Cell::text(detail.coordinates.to_string())
            }),
        ]
    });
    Block::Table(Table {
        caption: format!(
            "The simplest model of {model} within {} % of the most detailed",
            100.0 * within
        ),
        columns: vec![
            Column::text("signal"),
            Column::text("meaning"),
            Column::text("simplest model"),
            Column::number("coordinates"),
        ],
        rows: rows.collect(),
        footnotes: vec![
            "By |a − b|/|b| over the recorded periods; the costs are in the table of details."
                .to_owned(),
        ],
    })
}
