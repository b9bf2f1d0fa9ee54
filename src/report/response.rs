//! The response tables list statistics and harmonics of the signals of a time response for models
//! of increasing detail, and the sufficient detail.

use crate::theory::{DetailResponse, ResponseSignal, TimeResponse};

use super::table::seven_digits;
use super::{Block, Cell, Column, Table};

/// Harmonics in the table; the JSON file has all.
const MAX_TABLE_HARMONICS: usize = 12;

/// Tables of the signals of every detail, of the harmonics of the deflections, and of the distance
/// of every detail from the last.
pub fn response_blocks(model: &str, response: &TimeResponse) -> Vec<Block> {
    vec![
        signals_block(model, response),
        harmonics_block(model, response),
        details_block(model, response),
    ]
}

fn all_signals(
    response: &TimeResponse,
) -> impl Iterator<Item = (&DetailResponse, &ResponseSignal)> {
    let details = response.details.iter();
    details.flat_map(|detail| detail.signals.iter().map(move |signal| (detail, signal)))
}

fn signals_block(model: &str, response: &TimeResponse) -> Block {
    let figures = ["mean", "rms", "std", "largest", "least"];
    let mut columns = vec![
        Column::text("detail"),
        Column::text("signal"),
        Column::text("unit"),
    ];
    columns.extend(figures.map(Column::number));
    let row = |(detail, signal): (&DetailResponse, &ResponseSignal)| {
        let figures = [
            signal.mean(),
            signal.rms(),
            signal.deviation(),
            signal.largest(),
            signal.least(),
        ];
        let names = [detail.detail, signal.name, signal.unit].map(Cell::text);
        let cells = names.into_iter();
        cells
            .chain(figures.map(|figure| Cell::text(seven_digits(figure))))
            .collect()
    };
    let mut footnotes = vec![format!(
        "Excitation at {:.4} Hz; {} periods to settle, {} recorded.",
        response.excitation_hz, response.span.settling_periods, response.span.recorded_periods
    )];
    let mut named: Vec<&str> = Vec::new();
    for (_, signal) in all_signals(response) {
        if !named.contains(&signal.name) {
            named.push(signal.name);
            footnotes.push(format!("{}: {}.", signal.name, signal.meaning));
        }
    }
    Block::Table(Table {
        caption: format!("Steady response of {model}"),
        columns,
        rows: all_signals(response).map(row).collect(),
        footnotes,
    })
}

fn harmonics_block(model: &str, response: &TimeResponse) -> Block {
    let mut columns = vec![Column::text("detail"), Column::text("signal")];
    columns.extend((1..=MAX_TABLE_HARMONICS).map(|k| Column::number(k.to_string())));
    let row = |(detail, signal): (&DetailResponse, &ResponseSignal)| {
        let first = signal.harmonics.iter().take(MAX_TABLE_HARMONICS);
        let harmonics = first.map(|amplitude| Cell::text(format!("{amplitude:.4e}")));
        let names = [detail.detail, signal.name].map(Cell::text);
        names.into_iter().chain(harmonics).collect()
    };
    let deflections = all_signals(response).filter(|(_, signal)| signal.name.starts_with("delta"));
    Block::Table(Table {
        caption: format!("Harmonics of the deflections of {model}"),
        columns,
        rows: deflections.map(row).collect(),
        footnotes: vec![
            "Amplitudes, m, at multiples of the frequency of the excitation.".to_owned(),
        ],
    })
}

fn details_block(model: &str, response: &TimeResponse) -> Block {
    let last = response.details.last().map_or("", |detail| detail.detail);
    let signals = response
        .details
        .last()
        .map_or(&[][..], |detail| &detail.signals);
    let compared: Vec<&str> = signals.iter().map(|signal| signal.name).collect();
    let mut columns = vec![
        Column::text("detail"),
        Column::number("coordinates"),
        Column::number("evaluations per period"),
        Column::number("functions per evaluation"),
    ];
    columns.extend(
        compared
            .iter()
            .map(|name| Column::number(format!("{name} (%)"))),
    );
    let row = |detail: &DetailResponse| {
        let mut cells = vec![
            Cell::text(detail.detail),
            Cell::text(detail.coordinates.to_string()),
            Cell::text(detail.evaluations_per_period.to_string()),
            Cell::text(detail.functions_per_evaluation.to_string()),
        ];
        cells.extend(compared.iter().map(|name| {
            let distance = response.difference(name, detail.detail, last);
            distance.map_or(Cell::Missing, |distance| {
                Cell::text(seven_digits(100.0 * distance))
            })
        }));
        cells
    };
    Block::Table(Table {
        caption: format!("Detail and cost of the models of {model}"),
        columns,
        rows: response.details.iter().map(row).collect(),
        footnotes: vec![format!(
            "Percent: distance from \"{last}\", |a − b|/|b| over the recorded periods. —: the detail has no such signal. Functions: sines, square roots and similar."
        )],
    })
}
