//! Where to hit or put a sensor next, as tables.

use crate::correlate::{ComparisonTable, Placement, PlannedRoot, RankedHit, Step};
use crate::scene::PlacedTest;

use super::{Block, Cell, Column, Table};

/// The points that a test should have, what they make of every root, and what every point that can
/// be hit is worth.
pub fn placement_blocks(placed: &PlacedTest, table: Option<&ComparisonTable>) -> Vec<Block> {
    match &placed.placement {
        Ok(placement) => vec![
            steps_block(placed, placement, table),
            roots_block(placed, placement, table),
            ranking_block(placed, placement),
        ],
        Err(why) => vec![Block::Text(format!(
            "Where to hit next, {}: not known, {why}.",
            placed.test
        ))],
    }
}

/// `f9`, as the comparison calls the root.
fn label(root: &PlannedRoot, table: Option<&ComparisonTable>) -> String {
    let numbers: Vec<usize> = root.modes.iter().map(|j| j + 1).collect();
    let rows = table.iter().flat_map(|table| &table.rows);
    let is_row_of_root = |row: &&crate::correlate::Row| {
        row.theory
            .as_ref()
            .is_some_and(|theory| theory.modes == numbers)
    };
    let row = rows.into_iter().find(is_row_of_root);
    row.map_or_else(|| format!("{:.1} Hz", root.hz), |row| row.label.clone())
}

fn steps_block(
    placed: &PlacedTest,
    placement: &Placement,
    table: Option<&ComparisonTable>,
) -> Block {
    let row = |(number, step): (usize, &Step)| {
        let shown = step.shown.iter().map(|(root, modes)| {
            let root = &placement.roots[*root];
            match root.modes.len() {
                1 => label(root, table),
                all => format!("{modes} of {all} of {}", label(root, table)),
            }
        });
        let dof = |dof: &Option<crate::dof::Dof>| {
            dof.as_ref()
                .map_or(Cell::Missing, |dof| Cell::text(dof.to_string()))
        };
        vec![
            Cell::text(number.to_string()),
            dof(&step.hit),
            dof(&step.sensor),
            Cell::text(shown.collect::<Vec<_>>().join(", ")),
        ]
    };
    let modes = |count: fn(&PlannedRoot) -> usize| placement.roots.iter().map(count).sum::<usize>();
    Block::Table(Table {
        caption: format!("Where to hit or put a sensor next: {}", placed.test),
        columns: vec![
            Column::number("step"),
            Column::text("hit"),
            Column::text("sensor"),
            Column::text("shows beside what is seen"),
        ],
        rows: (1..).zip(&placement.steps).map(row).collect(),
        footnotes: vec![
            if placement.steps.is_empty() {
                format!(
                    "Of {} modes of the model in the band the test's points see {}; no further point shows another.",
                    modes(|root| root.modes.len()),
                    modes(|root| root.seen)
                )
            } else {
                format!(
                    "Of {} modes of the model in the band the test's points see {}, with these {}.",
                    modes(|root| root.modes.len()),
                    modes(|root| root.seen),
                    modes(|root| root.planned)
                )
            },
            format!(
                "Out of {} points that can be hit and {} that can carry a sensor; each step is the point that shows most, a hit and a sensor together where neither does alone.",
                placed.candidates.hits.len(),
                placed.candidates.sensors.len()
            ),
            "Seen: the peak stands 10 dB over the noise of the test's functions, for each mode of a repeated root by itself, and all pairs together tell the frequency to a quarter of the distance to the next root. A new hit goes with every sensor; with a new sensor the points that were hit are hit again.".to_owned(),
        ],
    })
}

fn remark(root: &PlannedRoot) -> &'static str {
    let whole = root.modes.len();
    match root.still {
        _ if root.seen == whole => "seen",
        _ if root.planned == whole => "seen with these points",
        [true, _] => "every point that can be hit stands still",
        [_, true] => "every point that can carry a sensor stands still",
        _ if root.planned > 0 => "seen in part; no point shows the rest",
        _ => "every point shows too little of it",
    }
}

fn roots_block(
    placed: &PlacedTest,
    placement: &Placement,
    table: Option<&ComparisonTable>,
) -> Block {
    let row = |root: &PlannedRoot| {
        let count = |modes: usize| Cell::text(modes.to_string());
        vec![
            Cell::text(label(root, table)),
            Cell::number(Some(root.hz), 2),
            count(root.modes.len()),
            count(root.seen),
            count(root.planned),
            Cell::number(root.peak_over_noise_db, 1),
            Cell::text(remark(root)),
        ]
    };
    Block::Table(Table {
        caption: format!("What the points see: {}", placed.test),
        columns: vec![
            Column::text("root"),
            Column::number("theory (Hz)"),
            Column::number("M"),
            Column::number("seen"),
            Column::number("planned"),
            Column::number("peak over noise (dB)"),
            Column::text("remark"),
        ],
        rows: placement.roots.iter().map(row).collect(),
        footnotes: vec![
            "M: multiplicity; seen: modes that the test's points see; planned: with the points above. Peak over noise: with every point there is, of the last mode that is seen, else of the next.".to_owned(),
        ],
    })
}

fn ranking_block(placed: &PlacedTest, placement: &Placement) -> Block {
    let row = |hit: &RankedHit| {
        vec![
            Cell::text(hit.dof.to_string()),
            Cell::text(hit.shown.to_string()),
            Cell::number(Some(hit.driving_point_residue), 3),
            Cell::number(hit.independence, 3),
        ]
    };
    Block::Table(Table {
        caption: format!("What one hit is worth: {}", placed.test),
        columns: vec![
            Column::text("hit"),
            Column::number("modes shown"),
            Column::number("driving-point residue"),
            Column::number("independence"),
        ],
        rows: placement.ranking.iter().map(row).collect(),
        footnotes: vec![
            "Modes shown: by this hit alone, with the sensors there are. Driving-point residue: mean of φ²/(2ωm) over the roots, as a part of the largest (Ewins 2000). Independence: the part of its row of the mode matrix that no other point has (Kammer 1991); none where there are no more points than that takes.".to_owned(),
        ],
    })
}
