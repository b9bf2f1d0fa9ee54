//! The placement tables recommend further excitation points and sensors for a test.

use crate::correlate::{ComparisonTable, Placement, PlannedRoot, RankedHit, SensorSet, Step};
use crate::printable::counted;
use crate::scene::PlacedTest;

use super::measures::matrix_table;
use super::{Block, Cell, Column, Table};

/// The recommended points of a test, the observability of every natural frequency with them, and a
/// ranking of all possible excitation points.
pub fn placement_blocks(placed: &PlacedTest, table: Option<&ComparisonTable>) -> Vec<Block> {
    let mut blocks = match &placed.placement {
        Ok(placement) => vec![
            steps_block(placed, placement, table),
            roots_block(placed, placement, table),
            ranking_block(placed, placement),
        ],
        Err(why) => vec![Block::Text(format!(
            "Recommended excitation points of {}: unknown, {why}.",
            placed.test
        ))],
    };
    let set = placed.sensor_set.as_ref();
    blocks.extend(set.map(|set| sensor_set_block(&placed.test, set)));
    blocks
}

/// The fewest sensors with a diagonal AutoMAC, and that AutoMAC.
fn sensor_set_block(test: &str, set: &SensorSet) -> Block {
    let values = |row: &Vec<f64>| row.iter().copied().map(Some).collect();
    let values: Vec<Vec<Option<f64>>> = set.auto_mac.iter().map(values).collect();
    let caption = format!("AutoMAC at the fewest sensors: {test}");
    let mut table = matrix_table(caption, &set.modes, &set.modes, &values);
    let [first, second] = set.largest_at.map(|at| set.modes[at].mode);
    let names: Vec<String> = set.sensors.iter().map(|dof| dof.to_string()).collect();
    table.footnotes.push(match set.is_met() {
        true => format!(
            "{} of {} possible sensors: {}.",
            names.len(),
            set.candidates,
            names.join(", ")
        ),
        false => format!(
            "No set of the {} possible sensors meets the limit; the values are those of all.",
            set.candidates
        ),
    });
    table.footnotes.push(format!(
        "Largest value between modes of different natural frequencies: {:.3} (modes {first} and {second}), limit {} (max_auto_mac).",
        set.largest, set.limit
    ));
    if !set.at_nodes.is_empty() {
        let modes: Vec<String> = (set.at_nodes.iter())
            .map(|name| name.mode.to_string())
            .collect();
        table.footnotes.push(format!(
            "Not compared, as they move no possible sensor: modes {}.",
            modes.join(", ")
        ));
    }
    table.footnotes.push("Sensors are added one by one, each time the one that lowers the MAC above the limit most; unneeded ones are removed, others exchanged. Each mode has at least a tenth of its mean square at all possible sensors.".to_owned());
    Block::Table(table)
}

/// Label of the natural frequency in the comparison, such as `f9`.
pub(super) fn label(root: &PlannedRoot, table: Option<&ComparisonTable>) -> String {
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
        caption: format!("Recommended excitation points and sensors: {}", placed.test),
        columns: vec![
            Column::number("step"),
            Column::text("hit"),
            Column::text("sensor"),
            Column::text("additionally observable"),
        ],
        rows: (1..).zip(&placement.steps).map(row).collect(),
        footnotes: vec![
            if placement.steps.is_empty() {
                format!(
                    "Of {} of the model in the band, {} are observable at the points of the test; no further point makes another observable.",
                    counted(modes(|root| root.modes.len()), "mode"),
                    modes(|root| root.seen)
                )
            } else {
                format!(
                    "Of {} of the model in the band, {} are observable at the points of the test, {} with these points.",
                    counted(modes(|root| root.modes.len()), "mode"),
                    modes(|root| root.seen),
                    modes(|root| root.planned)
                )
            },
            format!(
                "Selected from {} and {}; each step is the point that makes most modes observable, or an excitation point and a sensor together where neither alone is sufficient.",
                counted(placed.candidates.hits.len(), "possible excitation point"),
                counted(placed.candidates.sensors.len(), "possible sensor")
            ),
            "Observable: the peak exceeds the noise of the FRFs of the test by 10 dB, for each mode of a repeated root separately, and all FRFs together determine the frequency to a quarter of the distance to the next natural frequency. A new excitation point is measured with every sensor; a new sensor is measured with all excitation points again.".to_owned(),
        ],
    })
}

fn remark(root: &PlannedRoot) -> &'static str {
    let whole = root.modes.len();
    match root.at_nodes {
        _ if root.seen == whole => "observable",
        _ if root.planned == whole => "observable with these points",
        [true, _] => "all possible excitation points are at nodes",
        [_, true] => "all possible sensors are at nodes",
        _ if root.planned > 0 => "partly observable; no point makes the other modes observable",
        _ => "response too small at every point",
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
        caption: format!("Observable modes by point: {}", placed.test),
        columns: vec![
            Column::text("root"),
            Column::number("theory (Hz)"),
            Column::number("M"),
            Column::number("observable"),
            Column::number("planned"),
            Column::number("peak over noise (dB)"),
            Column::text("remark"),
        ],
        rows: placement.roots.iter().map(row).collect(),
        footnotes: vec![
            "M: multiplicity; observable: modes that are observable at the points of the test; planned: with the points above. Peak over noise: with all possible points, of the last observable mode, else of the next.".to_owned(),
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
        caption: format!("Ranking of excitation points: {}", placed.test),
        columns: vec![
            Column::text("hit"),
            Column::number("observable modes"),
            Column::number("driving-point residue"),
            Column::number("independence"),
        ],
        rows: placement.ranking.iter().map(row).collect(),
        footnotes: vec![
            "Observable modes: with this excitation point alone and the existing sensors. Driving-point residue: mean of φ²/(2ωm) over the natural frequencies, relative to the largest (Ewins 2000). Independence: contribution of its row of the mode matrix to the rank (effective independence, Kammer 1991); none where there are too few points.".to_owned(),
        ],
    })
}
