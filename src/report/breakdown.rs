//! The tables of breakdown maps list the counts of every cell, the failure boundaries and the CPU
//! times.

use crate::study::breakdown::{
    BreakdownResults, FAILURE_MODES, Factor, MethodTime, SliceResult, Stability, SuccessRange,
    UserMode, UserModePosition, breakdown_verdict, ranges_text, short_number, wilson_interval,
};

use super::json::BreakdownFile;
use super::{Block, Cell, Column, Table};

/// Counts of every cell, by slice and method: detection rate with its interval, and the number of
/// draws with each failure mode.
pub fn breakdown_cells(slices: &[SliceResult]) -> Block {
    let heads = [
        "slice",
        "x_factor",
        "x",
        "y_factor",
        "y",
        "method",
        "draws",
        "good",
        "share",
        "share_lower",
        "share_upper",
    ];
    let mut columns: Vec<Column> = heads.iter().map(|head| Column::text(*head)).collect();
    columns.extend(
        FAILURE_MODES
            .iter()
            .map(|failure| Column::number(failure.name())),
    );
    let rows = slices.iter().flat_map(cell_rows);
    Block::Table(Table {
        columns,
        rows: rows.collect(),
        ..Table::default()
    })
}

fn cell_rows(result: &SliceResult) -> Vec<Vec<Cell>> {
    let slice = &result.slice;
    let number = |value: f64| Cell::number(Some(value), 6);
    let mut rows = Vec::new();
    for cell in &result.cells {
        let counted = slice.methods.iter().zip(&cell.counts);
        for (method, count) in counted.filter_map(|(name, count)| Some((name, count.as_ref()?))) {
            let (lower, upper) = wilson_interval(count.good, count.draws);
            let mut row = vec![
                Cell::text(&slice.name),
                Cell::text(slice.x.factor.name()),
                number(cell.x),
                Cell::text(slice.y.factor.name()),
                number(cell.y),
                Cell::text(method),
                number(f64::from(count.draws)),
                number(f64::from(count.good)),
                number(count.success_rate()),
                number(lower),
                number(upper),
            ];
            row.extend(count.failures.iter().map(|draws| number(f64::from(*draws))));
            rows.push(row);
        }
    }
    rows
}

/// The verdict, failure boundaries of every slice, and the digits lost by order.
pub fn breakdown_blocks(file: &BreakdownFile) -> Vec<Block> {
    let slices = file.slices.iter();
    let slices = slices.map(|slice| slice_block(slice, &file.user_modes));
    let verdict = breakdown_verdict(&file.slices, &file.user_modes).map(Block::Text);
    verdict
        .into_iter()
        .chain(slices)
        .chain(file.stability.as_ref().map(stability_block))
        .collect()
}

/// Failure boundaries of a slice: the range in which each method meets the stated error, its most
/// frequent failure mode, and the distance of the user's modes to the boundary.
fn slice_block(result: &SliceResult, user_modes: &[UserMode]) -> Block {
    let slice = &result.slice;
    let ranges: Vec<Vec<SuccessRange>> = (0..slice.methods.len())
        .map(|method| result.success_ranges(method))
        .collect();
    let words = |factor: Factor| factor.name().replace('_', " ");
    let (x, y) = (words(slice.x.factor), words(slice.y.factor));
    let mut columns = vec![Column::text("method")];
    columns.extend(ranges[0].iter().map(|range| {
        let unit = match slice.y.factor.unit() {
            "dB" => " dB",
            _ => "",
        };
        Column::text(format!("{x} at {y} {}{unit}", short_number(range.at_y)))
    }));
    columns.push(Column::number("share of the slice"));
    columns.push(Column::text("failure mode beyond"));
    let row = |(method, ranges): (usize, &Vec<SuccessRange>)| {
        let mut cells = vec![Cell::text(&slice.methods[method])];
        cells.extend(
            ranges
                .iter()
                .map(|range| Cell::text(success_range_text(range, result))),
        );
        cells.push(Cell::text(format!("{:.0} %", 100.0 * result.area(method))));
        let failure = result.most_frequent_failure(method);
        cells.push(failure.map_or(Cell::Missing, |(failure, share)| {
            Cell::text(format!("{} ({:.0} %)", failure.sentence(), 100.0 * share))
        }));
        cells
    };
    let mut footnotes = vec![format!(
        "Where {x} is as stated, the method meets the stated error in 95 % of {} draws; in brackets the limits of that value by \
         the 95 % interval of the share (Wilson; ?: too few draws). {}",
        slice.draws,
        stated_error_text(result)
    )];
    footnotes.extend(user_mode_sentences(&result.locate_modes(user_modes)));
    Block::Table(Table {
        caption: format!("Where methods fail: {}", slice.name),
        columns,
        rows: ranges.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

/// Maximum number of modes that the footnotes describe one by one.
const MAX_MODE_SENTENCES: usize = 6;

/// A sentence for each of the user's modes nearest to a contour, and the number of the other modes.
fn user_mode_sentences(points: &[UserModePosition]) -> Vec<String> {
    let (inside, outside): (Vec<&UserModePosition>, Vec<&UserModePosition>) =
        points.iter().partition(|point| point.is_inside());
    let mut sentences: Vec<String> = inside
        .iter()
        .take(MAX_MODE_SENTENCES)
        .map(|point| point.sentence())
        .collect();
    let more = inside.len().saturating_sub(MAX_MODE_SENTENCES);
    let remainders = [
        (more, "are farther from a failure boundary"),
        (outside.len(), "are outside this slice"),
    ];
    for (count, what) in remainders.into_iter().filter(|(count, _)| *count > 0) {
        sentences.push(format!("{count} more of the user's modes {what}."));
    }
    sentences
}

/// Location of every mode of the user in every slice, and its distance to each method's contour.
pub fn breakdown_user_modes(slices: &[SliceResult], user_modes: &[UserMode]) -> Block {
    let heads = [
        "slice",
        "test",
        "mode",
        "frequency_hz",
        "x_share",
        "y_share",
        "method",
        "inside",
        "distance",
        "distance_unit",
    ];
    let mut rows = Vec::new();
    for (slice, point) in slices.iter().flat_map(|slice| {
        slice
            .locate_modes(user_modes)
            .into_iter()
            .map(move |point| (slice, point))
    }) {
        for margin in &point.margins {
            let distance = margin.distance;
            rows.push(vec![
                Cell::text(&slice.slice.name),
                Cell::text(&point.mode.test),
                Cell::count(point.mode.number),
                Cell::number(Some(point.mode.frequency_hz), 3),
                Cell::number(Some(point.place[0]), 4),
                Cell::number(Some(point.place[1]), 4),
                Cell::text(&margin.method),
                Cell::text(if margin.inside { "yes" } else { "no" }),
                Cell::number(distance.map(|distance| distance.value()), 4),
                distance.map_or(Cell::Missing, |distance| Cell::text(distance.unit())),
            ]);
        }
    }
    Block::Table(Table {
        columns: heads.iter().map(|head| Column::text(*head)).collect(),
        rows,
        ..Table::default()
    })
}

fn stated_error_text(result: &SliceResult) -> String {
    let stated = &result.slice.stated;
    let percent = stated.frequency_percent;
    let percent = percent.map_or(String::new(), |limit| format!(" and {limit} %"));
    let residue = stated.residue_percent;
    let residue = residue.map_or(String::new(), |limit| format!(", residues to {limit} %"));
    format!(
        "Stated error: all modes found and no other, frequencies to {} half-power bandwidths{percent}, damping to {} %, MAC {}{residue}.",
        stated.frequency_widths, stated.damping_percent, stated.mac
    )
}

/// `from 2.6 (2.2 to 3.3)`: the interval where there is one inner end.
fn success_range_text(range: &SuccessRange, result: &SliceResult) -> String {
    let axis = &result.slice.x;
    let text = ranges_text(&range.inside, axis);
    let inner = |stretches: &[(f64, f64)]| match stretches {
        [(a, b)] if *a > axis.lo && *b >= axis.hi => Some(*a),
        [(a, b)] if *a <= axis.lo && *b < axis.hi => Some(*b),
        _ => None,
    };
    let Some(at) = inner(&range.inside) else {
        return text;
    };
    // The outer end bounds where the method certainly fails, the inner end where it certainly meets
    // the stated error; with too few draws an end stays undetermined.
    let ends = [inner(&range.possibly_inside), inner(&range.surely_inside)];
    let end = |value: Option<f64>| value.map_or("?".to_owned(), short_number);
    let rising = range.inside.first().is_some_and(|(a, _)| *a >= at);
    match (ends, rising) {
        ([None, None], _) => text,
        ([failing, doing], true) => format!("{text} ({} to {})", end(failing), end(doing)),
        ([failing, doing], false) => format!("{text} ({} to {})", end(doing), end(failing)),
    }
}

/// Draws per second of processor time, by method over all measured slices.
pub fn breakdown_rates(finished: &BreakdownResults) -> Option<Block> {
    let mut total: Vec<MethodTime> = Vec::new();
    for time in finished.times.iter().flat_map(|(_, times)| times) {
        let Some(seconds) = time.cpu_s else { continue };
        let same_method = total.iter_mut().find(|all| all.method == time.method);
        match same_method {
            Some(all) => {
                all.draws += time.draws;
                all.cpu_s = all.cpu_s.map(|sum| sum + seconds);
            }
            None => total.push(time.clone()),
        }
    }
    let row = |time: &MethodTime| {
        let seconds = time.cpu_s.filter(|seconds| *seconds > 0.0);
        let rate = seconds.map(|seconds| f64::from(time.draws) / seconds);
        vec![
            Cell::text(&time.method),
            Cell::number(Some(f64::from(time.draws)), 0),
            Cell::number(time.cpu_s, 1),
            Cell::number(rate, 0),
        ]
    };
    (!total.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Draws per second".to_owned(),
            columns: vec![
                Column::text("method"),
                Column::number("draws"),
                Column::number("processor time (s)"),
                Column::number("draws per second"),
            ],
            rows: total.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    })
}

/// Times of every slice and method.
pub fn breakdown_times(times: &[(String, Vec<MethodTime>)]) -> Block {
    let heads = ["slice", "method", "draws", "cpu_s"];
    let rows = times.iter().flat_map(|(slice, slice_times)| {
        slice_times.iter().map(move |time| {
            vec![
                Cell::text(slice),
                Cell::text(&time.method),
                Cell::number(Some(f64::from(time.draws)), 0),
                Cell::number(time.cpu_s, 3),
            ]
        })
    });
    Block::Table(Table {
        columns: heads.iter().map(|head| Column::text(*head)).collect(),
        rows: rows.collect(),
        ..Table::default()
    })
}

/// Digits lost and pole errors by order, in full precision.
pub fn stability_cells(stability: &Stability) -> Block {
    let heads = [
        "method",
        "order",
        "condition",
        "digits_lost",
        "pole_error_widths",
        "pole_error_widths_f32_data",
        "pole_error_widths_f32_data_and_equations",
    ];
    let rows = stability.curves.iter().flat_map(|course| {
        course.points.iter().map(move |point| {
            vec![
                Cell::text(&course.method),
                Cell::count(point.order),
                Cell::number(Some(point.condition), 0),
                Cell::number(Some(point.digits_lost()), 2),
                Cell::number(point.error, 6),
                Cell::number(point.error_f32_data, 6),
                Cell::number(point.error_f32_matrix, 6),
            ]
        })
    });
    Block::Table(Table {
        columns: heads.iter().map(|head| Column::text(*head)).collect(),
        rows: rows.collect(),
        ..Table::default()
    })
}

/// Maximum error of an accurate pole, in half-power bandwidths.
const MAX_POLE_ERROR_BANDWIDTHS: f64 = 0.1;

/// The highest order up to which all poles of each method are accurate, in f64 and in f32.
fn stability_block(stability: &Stability) -> Block {
    let row = |course: &crate::study::breakdown::StabilityCurve| {
        let highest_order = |value: fn(&crate::study::breakdown::StabilityPoint) -> Option<f64>| {
            let good = course.points.iter();
            let good = good.take_while(|point| {
                value(point).is_some_and(|error| error < MAX_POLE_ERROR_BANDWIDTHS)
            });
            Cell::count(good.last().map_or(0, |point| point.order))
        };
        let digits = |order: usize| {
            let point = course.points.iter().find(|point| point.order == order);
            Cell::number(point.map(|point| point.digits_lost()), 1)
        };
        vec![
            Cell::text(&course.method),
            digits(10),
            digits(20),
            digits(30),
            highest_order(|point| point.error),
            highest_order(|point| point.error_f32_data),
            highest_order(|point| point.error_f32_matrix),
        ]
    };
    Block::Table(Table {
        caption: "Numerical stability: digits lost by order, and the highest order with all poles to a tenth of their half-power width"
            .to_owned(),
        columns: vec![
            Column::text("method"),
            Column::number("digits, order 10"),
            Column::number("20"),
            Column::number("30"),
            Column::number("order, f64"),
            Column::number("data in f32"),
            Column::number("data and equations in f32"),
        ],
        rows: stability.curves.iter().map(row).collect(),
        footnotes: vec![
            "Data without noise of half as many modes as the order, 1 % damping, spread evenly over the band. Digits: log₁₀ of the condition number of the \
             equations, as each method is published; modalign's rfp never forms them, its lscf and lsce do. f32: the data, or the data and the matrix, are \
             rounded to f32; the equations are solved in f64."
                .to_owned(),
        ],
    })
}
