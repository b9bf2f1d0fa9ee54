//! The tables of the speed and accuracy study list CPU time and errors of every method.

use crate::study::{
    DetectionCounts, Method, SpeedAccuracy, TestStudy, Timing, method_verdicts, recommendations,
};

use super::{Block, Cell, Column, Table};

/// Verdicts, methods on the Pareto front of every test, and recommendations.
pub fn speed_accuracy_blocks(study: &SpeedAccuracy) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(format!(
        "{}: speed against accuracy",
        study.title
    ))];
    blocks.extend(method_verdicts(study).into_iter().map(Block::Text));
    blocks.extend(study.tests.iter().map(|test| front_block(study, test)));
    blocks.extend(recommendations(study).into_iter().map(Block::Text));
    blocks
}

fn front_block(study: &SpeedAccuracy, test: &TestStudy) -> Block {
    let on_front = test.data.iter().filter(|row| row.on_front);
    let data = on_front.map(|row| {
        let estimator = row.estimator.unwrap_or("as given");
        front_row(
            "data",
            estimator,
            row.step_hz,
            row.method,
            &row.counts,
            &row.timing,
        )
    });
    let snr_db = study.options.middle_snr_db();
    let twin = test.twin_costs.iter().filter(|cost| cost.on_front);
    let twin = twin.filter_map(|cost| {
        let row = test.twin_row(crate::study::Condition::White, snr_db, cost.method)?;
        let step_hz = test.twin_step_hz;
        Some(front_row(
            "twin",
            "exact",
            step_hz,
            cost.method,
            &row.counts,
            &cost.timing,
        ))
    });
    let heads = [
        "CPU time (ms)",
        "± spread (ms)",
        "memory (MiB)",
        "frequency (%)",
        "damping (%)",
        "shape (%)",
        "found",
        "of",
        "spurious",
    ];
    let text = ["on", "FRFs", "method"].map(Column::text);
    let truth = match test.twin_of_truth {
        true => "the recording's truth",
        false => "its refined modes",
    };
    let mut footnotes = vec![
        "Front: no other row with as few missed and spurious modes has both less CPU time and a smaller frequency error. Errors: rms, \
         relative, of data to the refined solution, of the twin to its truth; shape: √(1−MAC)."
            .to_owned(),
        format!(
            "Twin: {} modes of {truth} in white noise of {snr_db:.0} dB. CPU time on this machine, all threads: {}.",
            test.twin_modes,
            match study.options.repeats {
                1 => "one warm run".to_owned(),
                repeats => format!("median of {repeats} warm runs, longest less shortest"),
            }
        ),
    ];
    let [limit, _] = test.limits;
    footnotes.extend(limit.transform_s.zip(limit.pass_s).map(|(transform, pass)| {
        format!(
            "For comparison: one transform of its {} FRFs takes {:.2} ms, one pass over their values {:.3} ms.",
            test.functions,
            1e3 * transform,
            1e3 * pass
        )
    }));
    footnotes.extend(test.notes.iter().map(|note| format!("Not done: {note}")));
    Block::Table(Table {
        caption: format!("{}: Pareto front of time and error", test.name),
        columns: text.into_iter().chain(heads.map(Column::number)).collect(),
        rows: data.chain(twin).collect(),
        footnotes,
    })
}

fn front_row(
    data: &str,
    estimator: &str,
    step_hz: f64,
    method: Method,
    counts: &DetectionCounts,
    timing: &Timing,
) -> Vec<Cell> {
    let percent = |value: Option<f64>, decimals| Cell::number(value.map(|v| 100.0 * v), decimals);
    vec![
        Cell::text(data),
        Cell::text(format!("{estimator}, {step_hz:.3} Hz")),
        Cell::text(method.to_string()),
        Cell::number(timing.median_s.map(|seconds| 1e3 * seconds), 2),
        Cell::number(timing.spread_s.map(|seconds| 1e3 * seconds), 2),
        Cell::number(timing.peak_bytes.map(|bytes| bytes as f64 / 1_048_576.0), 2),
        Cell::std(counts.frequency().map(|v| 100.0 * v), 6),
        percent(counts.damping(), 4),
        percent(counts.shape(), 4),
        Cell::count(counts.found),
        Cell::count(counts.observable),
        Cell::count(counts.spurious),
    ]
}

/// Every row of every test without measured times: the same on every run.
pub fn speed_accuracy_table(study: &SpeedAccuracy) -> Block {
    let mut rows = Vec::new();
    for test in &study.tests {
        rows.extend(test.data.iter().map(|row| {
            let keys = [
                Cell::text(test.name.as_str()),
                Cell::text("data"),
                row.estimator.map_or(Cell::Missing, Cell::text),
                Cell::number(Some(row.step_hz), 6),
                Cell::Missing,
            ];
            let mut cells = accuracy_row(keys, row.method, &row.counts);
            cells.push(Cell::text(if row.is_reference { "yes" } else { "no" }));
            cells
        }));
        rows.extend(test.twin.iter().map(|row| {
            let keys = [
                Cell::text(test.name.as_str()),
                Cell::text(format!("twin, {}", row.condition.name())),
                Cell::Missing,
                Cell::Missing,
                Cell::number(Some(row.snr_db), 1),
            ];
            let mut cells = accuracy_row(keys, row.method, &row.counts);
            cells.push(Cell::Missing);
            cells
        }));
    }
    let text = ["test", "data", "estimator"].map(Column::text);
    let keys = ["step_hz", "snr_db"].map(Column::number);
    let numbers = [
        "order",
        "runs",
        "refused",
        "observable",
        "found",
        "spurious",
        "frequency_rms",
        "damping_rms",
        "shape_rms",
        "frequency_over_bound",
        "damping_over_bound",
        "frequency_bound_rms",
        "damping_bound_rms",
        "refined",
    ];
    let columns = text.into_iter().chain(keys);
    let columns = columns.chain([Column::text("method")]);
    Block::Table(Table {
        caption: "Speed against accuracy".to_owned(),
        columns: columns.chain(numbers.map(Column::number)).collect(),
        rows,
        footnotes: Vec::new(),
    })
}

fn accuracy_row(keys: [Cell; 5], method: Method, counts: &DetectionCounts) -> Vec<Cell> {
    let mut row: Vec<Cell> = keys.into();
    row.push(Cell::text(method.name));
    row.push(Cell::number(method.order.map(|order| order as f64), 0));
    let numbers = [
        counts.runs,
        counts.refused,
        counts.observable,
        counts.found,
        counts.spurious,
    ];
    row.extend(numbers.map(Cell::count));
    let errors = [
        counts.frequency(),
        counts.damping(),
        counts.shape(),
        counts.frequency_over_bound(),
        counts.damping_over_bound(),
        counts.frequency_bound(),
        counts.damping_bound(),
    ];
    row.extend(errors.map(|error| Cell::number(error, 9)));
    row
}

/// Measured times, which differ between runs.
pub fn times_table(study: &SpeedAccuracy) -> Block {
    let mut rows = Vec::new();
    for test in &study.tests {
        let name = || Cell::text(test.name.as_str());
        for row in &test.data {
            let keys = [
                name(),
                Cell::text("data"),
                row.estimator.map_or(Cell::Missing, Cell::text),
                Cell::number(Some(row.step_hz), 6),
            ];
            rows.push(time_row(keys, row.method, &row.timing, row.on_front));
        }
        for cost in &test.twin_costs {
            let keys = [name(), Cell::text("twin"), Cell::Missing, Cell::Missing];
            rows.push(time_row(keys, cost.method, &cost.timing, cost.on_front));
        }
        for (data, limits) in ["data", "twin"].into_iter().zip(&test.limits) {
            let references = [
                ("one transform", limits.transform_s),
                ("one pass", limits.pass_s),
            ];
            rows.extend(references.map(|(what, time)| {
                let mut row = vec![name(), Cell::text(data), Cell::Missing, Cell::Missing];
                row.extend([Cell::text(what), Cell::Missing, Cell::Missing]);
                row.extend([
                    Cell::number(time, 9),
                    Cell::Missing,
                    Cell::Missing,
                    Cell::Missing,
                ]);
                row
            }));
        }
    }
    let heads = [
        "step_hz",
        "method",
        "order",
        "repeats",
        "cpu_s",
        "spread_s",
        "peak_bytes",
        "on_front",
    ];
    let text = ["test", "data", "estimator"].map(Column::text);
    Block::Table(Table {
        caption: "Times".to_owned(),
        columns: text.into_iter().chain(heads.map(Column::number)).collect(),
        rows,
        footnotes: Vec::new(),
    })
}

fn time_row(keys: [Cell; 4], method: Method, timing: &Timing, on_front: bool) -> Vec<Cell> {
    let mut row: Vec<Cell> = keys.into();
    row.extend([
        Cell::text(method.name),
        Cell::number(method.order.map(|order| order as f64), 0),
        Cell::count(timing.repeats),
        Cell::number(timing.median_s, 9),
        Cell::number(timing.spread_s, 9),
        Cell::number(timing.peak_bytes.map(|bytes| bytes as f64), 0),
        Cell::text(if on_front { "yes" } else { "no" }),
    ]);
    row
}
