//! The tables of a parameter sweep list the eigenvalue loci, and their crossings and veerings.

use std::f64::consts::TAU;

use crate::axis::Band;
use crate::theory::{Locus, LocusEvent, Sweep, SweepRange};

use super::table::seven_digits;
use super::{Block, Cell, Column, Table};

/// The loci of a sweep that enter a band, and the crossings and veerings in it, where modes are
/// tracked.
pub fn sweep_blocks(model: &str, sweep: &Sweep, band: Option<Band>) -> Vec<Block> {
    let inside = |hz: f64| band.is_none_or(|band| band.contains(hz));
    let shown: Vec<(usize, &Locus)> = (1..)
        .zip(&sweep.loci)
        .filter(|(_, locus)| {
            locus
                .omega_rad_s
                .iter()
                .flatten()
                .any(|omega| inside(omega / TAU))
        })
        .collect();
    let events = sweep.events.iter();
    let events: Vec<&LocusEvent> = events
        .filter(|event| event.frequency_hz.iter().any(|hz| inside(*hz)))
        .collect();
    let mut blocks = vec![loci_block(model, sweep, &shown)];
    if sweep.followed {
        blocks.push(events_block(model, sweep, &events));
    }
    blocks
}

/// Multiplicity of a locus, if it is more than one: `, 3 modes`; `, 9 10 11 modes` where it varies.
fn multiplicity(locus: &Locus) -> String {
    let mut counts: Vec<String> = locus.multiplicity.iter().map(usize::to_string).collect();
    if counts.windows(2).all(|pair| pair[0] == pair[1]) {
        counts.truncate(1);
    }
    match counts.join(" ") {
        one if one == "1" => String::new(),
        all => format!(", {all} modes"),
    }
}

fn parameter(sweep: &Sweep) -> String {
    format!("{} ({})", sweep.parameter.name, sweep.parameter.unit)
}

fn loci_block(model: &str, sweep: &Sweep, shown: &[(usize, &Locus)]) -> Block {
    let mut columns = vec![Column::number(parameter(sweep))];
    columns.extend(shown.iter().map(|(number, locus)| {
        let word = if sweep.followed { "locus" } else { "root" };
        Column::number(format!("{word} {number}{} (Hz)", multiplicity(locus)))
    }));
    let row = |(i, value): (usize, &f64)| {
        let cells = shown.iter();
        let cells =
            cells.map(|(_, locus)| Cell::number(locus.omega_rad_s[i].map(|omega| omega / TAU), 4));
        let value = match sweep.followed {
            true => seven_digits(*value),
            false => format!("{value}"),
        };
        std::iter::once(Cell::text(value)).chain(cells).collect()
    };
    let mut footnotes = vec![if sweep.followed {
        format!(
            "Loci are tracked by mode shape; {} eigenproblems. Values in equal {}.",
            sweep.solved,
            if is_geometric(&sweep.values) {
                "ratios"
            } else {
                "steps"
            }
        )
    } else {
        format!(
            "{} is an integer that changes the coordinates; roots are numbered from the lowest and not tracked by mode shape. {} eigenproblems.",
            sweep.parameter.name, sweep.solved
        )
    }];
    let word = if sweep.followed { "Locus" } else { "Root" };
    let classes = shown.iter();
    let classes = classes.filter_map(|(number, locus)| Some((number, locus.class.as_ref()?)));
    footnotes.extend(
        classes.map(|(number, class)| format!("{word} {number}, at the first value: {class}.")),
    );
    Block::Table(Table {
        caption: format!("Loci of the roots of {model} over {}", sweep.parameter.name),
        columns,
        rows: sweep.values.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

fn is_geometric(values: &[f64]) -> bool {
    let (lower, upper) = (values[0], values[values.len() - 1]);
    let count = values.len();
    SweepRange {
        lower,
        upper,
        count,
    }
    .is_geometric()
}

fn events_block(model: &str, sweep: &Sweep, events: &[&LocusEvent]) -> Block {
    let columns = vec![
        Column::text("event"),
        Column::text("loci"),
        Column::number(parameter(sweep)),
        Column::number("f lower (Hz)"),
        Column::number("f upper (Hz)"),
        Column::number("gap (Hz)"),
        Column::number("coupling"),
        Column::number(format!("width ({})", sweep.parameter.unit)),
    ];
    let row = |event: &&LocusEvent| {
        let [a, b] = event.loci.map(|locus| locus + 1);
        let width = event.width;
        vec![
            Cell::text(event.kind.name()),
            Cell::text(format!("{a} {b}")),
            Cell::text(seven_digits(event.place)),
            Cell::number(Some(event.frequency_hz[0]), 6),
            Cell::number(Some(event.frequency_hz[1]), 6),
            Cell::number(Some(event.gap_hz), 6),
            Cell::number(Some(event.coupling), 6),
            width.map_or(Cell::Missing, |width| Cell::text(seven_digits(width))),
        ]
    };
    Block::Table(Table {
        caption: format!("Crossings and veerings of {model} over {}", sweep.parameter.name),
        columns,
        rows: events.iter().map(row).collect(),
        footnotes: vec![
            "Crossing: the frequencies coincide and the shapes are unchanged. Veering: the frequencies approach each other without coinciding, and the shapes are exchanged. Coupling: c²/(c² + (s_a − s_b)²/4), c = φ_aᵀ(dK/dp − λ dM/dp)φ_b, s = dλ/dp. Width: gap in λ over 2c.".to_owned(),
        ],
    })
}
