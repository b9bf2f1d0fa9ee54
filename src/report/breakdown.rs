//! Breakdown maps as tables: every cell, every contour in words, times.

use crate::study::breakdown::{
    Factor, Finished, MethodTime, OwnMode, OwnPoint, Reach, SYMPTOMS, SliceResult, Stability,
    short, told, wilson,
};

use super::json::BreakdownFile;
use super::{Block, Cell, Column, Table};

/// Every cell of every slice and method: the counted share with its interval, and how often each
/// symptom was seen.
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
    columns.extend(SYMPTOMS.iter().map(|own| Column::number(own.name())));
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
        for (method, count) in counted.filter_map(|(name, own)| Some((name, own.as_ref()?))) {
            let (lower, upper) = wilson(count.good, count.draws);
            let mut row = vec![
                Cell::text(&slice.name),
                Cell::text(slice.x.factor.name()),
                number(cell.x),
                Cell::text(slice.y.factor.name()),
                number(cell.y),
                Cell::text(method),
                number(f64::from(count.draws)),
                number(f64::from(count.good)),
                number(count.share()),
                number(lower),
                number(upper),
            ];
            row.extend(count.symptoms.iter().map(|own| number(f64::from(*own))));
            rows.push(row);
        }
    }
    rows
}

/// Every slice in words, and the digits lost by order.
pub fn breakdown_blocks(own: &BreakdownFile) -> Vec<Block> {
    let slices = own.slices.iter();
    let slices = slices.map(|slice| breakdown_block(slice, &own.own_modes));
    slices
        .chain(own.stability.as_ref().map(stability_block))
        .collect()
}

/// A slice in words: where each method does, what is seen where it does not, and how far the own
/// modes are from that.
fn breakdown_block(result: &SliceResult, own: &[OwnMode]) -> Block {
    let slice = &result.slice;
    let reaches: Vec<Vec<Reach>> = (0..slice.methods.len())
        .map(|method| result.reaches(method))
        .collect();
    let words = |factor: Factor| factor.name().replace('_', " ");
    let (x, y) = (words(slice.x.factor), words(slice.y.factor));
    let mut columns = vec![Column::text("method")];
    columns.extend(reaches[0].iter().map(|reach| {
        let unit = match slice.y.factor.unit() {
            "dB" => " dB",
            _ => "",
        };
        Column::text(format!("{x} at {y} {}{unit}", short(reach.held)))
    }));
    columns.push(Column::number("share of the slice"));
    columns.push(Column::text("seen beyond"));
    let row = |(method, reaches): (usize, &Vec<Reach>)| {
        let mut cells = vec![Cell::text(&slice.methods[method])];
        cells.extend(
            reaches
                .iter()
                .map(|reach| Cell::text(reach_text(reach, result))),
        );
        cells.push(Cell::text(format!("{:.0} %", 100.0 * result.area(method))));
        let symptom = result.common_symptom(method);
        cells.push(symptom.map_or(Cell::Missing, |(own, share)| {
            Cell::text(format!("{} ({:.0} %)", own.sentence(), 100.0 * share))
        }));
        cells
    };
    let mut footnotes = vec![format!(
        "Where {x} is as stated, the method meets the stated error in 95 % of {} draws; in brackets between which ends \
         the 95 % interval of the share leaves that open (Wilson; ?: so few draws cannot tell). {}",
        slice.draws,
        stated_text(result)
    )];
    footnotes.extend(own_sentences(&result.points(own)));
    Block::Table(Table {
        caption: format!("Where methods fail: {}", slice.name),
        columns,
        rows: reaches.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

/// Modes of which a sentence is printed.
const TOLD: usize = 6;

/// The modes nearest to where a method fails, each in a sentence, and how many there are beside
/// them.
fn own_sentences(points: &[OwnPoint]) -> Vec<String> {
    let (inside, outside): (Vec<&OwnPoint>, Vec<&OwnPoint>) =
        points.iter().partition(|point| point.inside());
    let mut told: Vec<String> = inside.iter().take(TOLD).map(|own| own.sentence()).collect();
    let more = inside.len().saturating_sub(TOLD);
    let rest = [
        (more, "lie no nearer to where a method fails"),
        (outside.len(), "lie outside this slice"),
    ];
    for (count, what) in rest.into_iter().filter(|(count, _)| *count > 0) {
        told.push(format!("{count} more of the own modes {what}."));
    }
    told
}

/// Every own mode in every slice and for every method, for programs.
pub fn breakdown_own_modes(slices: &[SliceResult], own: &[OwnMode]) -> Block {
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
    for (slice, point) in slices
        .iter()
        .flat_map(|slice| slice.points(own).into_iter().map(move |own| (slice, own)))
    {
        for margin in &point.margins {
            let distance = margin.distance;
            rows.push(vec![
                Cell::text(&slice.slice.name),
                Cell::text(&point.mode.test),
                Cell::number(Some(point.mode.number as f64), 0),
                Cell::number(Some(point.mode.frequency_hz), 3),
                Cell::number(Some(point.place[0]), 4),
                Cell::number(Some(point.place[1]), 4),
                Cell::text(&margin.method),
                Cell::text(if margin.inside { "yes" } else { "no" }),
                Cell::number(distance.map(|own| own.value()), 4),
                distance.map_or(Cell::Missing, |own| Cell::text(own.unit())),
            ]);
        }
    }
    Block::Table(Table {
        columns: heads.iter().map(|head| Column::text(*head)).collect(),
        rows,
        ..Table::default()
    })
}

fn stated_text(result: &SliceResult) -> String {
    let stated = &result.slice.stated;
    let percent = stated.frequency_percent;
    let percent = percent.map_or(String::new(), |own| format!(" and {own} %"));
    let residue = stated.residue_percent;
    let residue = residue.map_or(String::new(), |own| format!(", residues to {own} %"));
    format!(
        "Stated error: all modes found and no other, frequencies to {} half-power widths{percent}, damping to {} %, MAC {}{residue}.",
        stated.frequency_widths, stated.damping_percent, stated.mac
    )
}

/// `from 2.6 (2.2 to 3.3)`: the interval where there is one inner end.
fn reach_text(reach: &Reach, result: &SliceResult) -> String {
    let axis = &result.slice.x;
    let text = told(&reach.inside, axis);
    let inner = |stretches: &[(f64, f64)]| match stretches {
        [(a, b)] if *a > axis.lo && *b >= axis.hi => Some(*a),
        [(a, b)] if *a <= axis.lo && *b < axis.hi => Some(*b),
        _ => None,
    };
    let Some(at) = inner(&reach.inside) else {
        return text;
    };
    // Failing for certain lies outside of what may be inside; too few draws leave one of both ends
    // open.
    let ends = [inner(&reach.not_outside), inner(&reach.known_inside)];
    let end = |value: Option<f64>| value.map_or("?".to_owned(), short);
    let rising = reach.inside.first().is_some_and(|(a, _)| *a >= at);
    match (ends, rising) {
        ([None, None], _) => text,
        ([failing, doing], true) => format!("{text} ({} to {})", end(failing), end(doing)),
        ([failing, doing], false) => format!("{text} ({} to {})", end(doing), end(failing)),
    }
}

/// Draws per second of processor time, by method over all slices that were measured.
pub fn breakdown_rates(finished: &Finished) -> Option<Block> {
    let mut total: Vec<MethodTime> = Vec::new();
    for own in finished.times.iter().flat_map(|(_, times)| times) {
        let Some(seconds) = own.cpu_s else { continue };
        let known = total.iter_mut().find(|all| all.method == own.method);
        match known {
            Some(all) => {
                all.draws += own.draws;
                all.cpu_s = all.cpu_s.map(|sum| sum + seconds);
            }
            None => total.push(own.clone()),
        }
    }
    let row = |own: &MethodTime| {
        let seconds = own.cpu_s.filter(|own| *own > 0.0);
        let rate = seconds.map(|seconds| f64::from(own.draws) / seconds);
        vec![
            Cell::text(&own.method),
            Cell::number(Some(f64::from(own.draws)), 0),
            Cell::number(own.cpu_s, 1),
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
    let rows = times.iter().flat_map(|(slice, own)| {
        own.iter().map(move |own| {
            vec![
                Cell::text(slice),
                Cell::text(&own.method),
                Cell::number(Some(f64::from(own.draws)), 0),
                Cell::number(own.cpu_s, 3),
            ]
        })
    });
    Block::Table(Table {
        columns: heads.iter().map(|head| Column::text(*head)).collect(),
        rows: rows.collect(),
        ..Table::default()
    })
}

/// Digits lost and errors by order, for programs.
pub fn stability_cells(own: &Stability) -> Block {
    let heads = [
        "method",
        "order",
        "condition",
        "digits_lost",
        "pole_error_widths",
        "pole_error_widths_f32_data",
        "pole_error_widths_f32_data_and_equations",
    ];
    let rows = own.courses.iter().flat_map(|course| {
        course.points.iter().map(move |point| {
            vec![
                Cell::text(&course.method),
                Cell::number(Some(point.order as f64), 0),
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

/// A pole is lost where it is off by this share of its half-power width.
const LOST: f64 = 0.1;

/// The highest order up to which each method keeps its poles, in f64 and in f32.
fn stability_block(own: &Stability) -> Block {
    let row = |course: &crate::study::breakdown::StabilityCourse| {
        let upto = |value: fn(&crate::study::breakdown::StabilityPoint) -> Option<f64>| {
            let good = course.points.iter();
            let good = good.take_while(|point| value(point).is_some_and(|own| own < LOST));
            Cell::number(Some(good.last().map_or(0, |point| point.order) as f64), 0)
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
            upto(|point| point.error),
            upto(|point| point.error_f32_data),
            upto(|point| point.error_f32_matrix),
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
        rows: own.courses.iter().map(row).collect(),
        footnotes: vec![
            "Data without noise of half as many modes as the order, 1 % damping, spread evenly over the band. Digits: log₁₀ of the condition number of the \
             equations, as each method is published; modalign's own rfp never forms them, its lscf and lsce do. In f32 are rounded the data, or the data \
             and the matrix, which is then solved in f64."
                .to_owned(),
        ],
    })
}
