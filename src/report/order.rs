//! The order selection report states the number of modes that the data of a scene support, the
//! lowest model order of every method, and where single-mode methods are sufficient.

use crate::identify::OrderStep;
use crate::study::{
    LowestOrder, ModeNeeds, SceneNeeds, SingleMode, TestNeeds, TriedOrder, method_sentences,
    summarise_needs,
};

use super::test_title::test_title;
use super::{Block, Cell, Column, Table};

/// The verdicts and conclusions, then the tables that support them.
pub fn order_blocks(needs: &SceneNeeds) -> Vec<Block> {
    let heading = format!("{}: model orders and methods that it needs", needs.title);
    let mut blocks = vec![Block::Heading(heading)];
    blocks.push(Block::Text(method_sentences(needs).join("\n")));
    blocks.extend(summarise_needs(needs).into_iter().map(Block::Text));
    for test in &needs.tests {
        blocks.push(supported_modes_block(test));
        blocks.extend((!test.orders.is_empty()).then(|| lowest_orders_block(test)));
        blocks.extend((!test.single.is_empty()).then(|| single_mode_block(test, needs)));
    }
    blocks
}

/// A multiple of the noise level: with three decimals near it, with none far above it.
fn noise_ratio_cell(value: f64) -> Cell {
    Cell::number(Some(value), if value < 100.0 { 3 } else { 0 })
}

fn supported_modes_block(test: &TestNeeds) -> Block {
    let support = &test.support;
    let functions = match support.functions {
        1 => "1 FRF".to_owned(),
        count => format!("{count} FRFs"),
    };
    let mut footnotes = vec![
        "Modes are added one at a time, by decreasing contribution: first the identified modes, then further stable poles; poles are fixed \
         at their fit of all lines. BIC: relative to that of the out-of-band terms alone. Held-out lines: negative log-likelihood of lines \
         predicted from the others, −ln p − ln π for each value, 1 for noise alone; * the minimum number of modes within one standard error \
         of the minimum. Reduced chi-square: residual energy over noise variance and degrees of freedom, below 1 where force noise is \
         common to lines; * the minimum number of modes within a tenth of the minimum, up to that of BIC."
            .to_owned(),
        match support.segment_lines {
            1 => format!("{functions} of {} lines; each line is held out separately.", support.lines),
            segment_lines => format!(
                "{functions} of {} lines; {segment_lines} lines predicted at a time, with as many on either side held out, as the noise of neighbouring lines is correlated.",
                support.lines
            ),
        },
    ];
    if !support.noise_stated {
        footnotes.push(
            "The data have no variances: the noise is estimated from the fit residual.".to_owned(),
        );
    }
    footnotes.extend(test.notes.iter().map(|note| format!("Not done: {note}.")));
    let supported = [
        Some(support.by_bic()),
        support.by_prediction(),
        Some(support.by_residual()),
    ];
    let row = |(number, tried): (usize, &OrderStep)| {
        let star = |which: usize| {
            Cell::text(if supported[which] == Some(number) {
                "*"
            } else {
                ""
            })
        };
        let what = match (tried.pole, tried.identified) {
            (None, _) => "out-of-band terms alone",
            (_, true) => "identified",
            (_, false) => "stable pole",
        };
        vec![
            Cell::count(number),
            Cell::text(what),
            Cell::number(tried.pole.map(|pole| pole.natural_frequency_hz()), 3),
            Cell::number(tried.pole.map(|pole| 100.0 * pole.damping_ratio()), 4),
            tried
                .pole
                .map_or(Cell::Missing, |_| Cell::count(tried.holding)),
            Cell::number(Some(tried.bic), 0),
            star(0),
            tried
                .predicted
                .map_or(Cell::Missing, |score| noise_ratio_cell(score.mean)),
            star(1),
            noise_ratio_cell(tried.rest),
            star(2),
        ]
    };
    Block::Table(Table {
        caption: format!(
            "{}: number of modes that the data support",
            test_title(&test.name, test.synthetic)
        ),
        columns: vec![
            Column::number("modes"),
            Column::text("last mode added"),
            Column::number("f (Hz)"),
            Column::number("ζ (%)"),
            Column::number("FRFs that need it"),
            Column::number("BIC"),
            Column::text(""),
            Column::number("held-out lines"),
            Column::text(""),
            Column::number("reduced chi-square"),
            Column::text(""),
        ],
        rows: support.tried.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

fn lowest_orders_block(test: &TestNeeds) -> Block {
    let row = |method: &LowestOrder| {
        let tried = |tried: &TriedOrder| match tried.is_correct() {
            true => format!("{}: right", tried.order),
            false => format!("{}: −{} +{}", tried.order, tried.missed, tried.spurious),
        };
        let all: Vec<String> = method.tried.iter().map(tried).collect();
        vec![
            Cell::text(method.method),
            method.lowest().map_or(Cell::Missing, Cell::count),
            method
                .chosen
                .map_or(Cell::Missing, |tried| Cell::count(tried.order)),
            method
                .chosen
                .map_or(Cell::Missing, |tried| Cell::count(tried.missed)),
            method
                .chosen
                .map_or(Cell::Missing, |tried| Cell::count(tried.spurious)),
            Cell::text(all.join(", ")),
        ]
    };
    Block::Table(Table {
        caption: format!("{}: lowest order of every method", test_title(&test.name, test.synthetic)),
        columns: vec![
            Column::text("method"),
            Column::number("lowest"),
            Column::number("automatic"),
            Column::number("missed"),
            Column::number("spurious"),
            Column::text("tried"),
        ],
        rows: test.orders.iter().map(row).collect(),
        footnotes: vec![
            "Compared with the modes of `ml`: a mode is found within a quarter of the half-power bandwidth or three standard deviations, with a MAC \
             of 0.9. Tried: highest order, modes missed (−) and spurious (+); orders that a method refuses are not listed, and modes that it \
             drops count as missed. Missed and spurious: with the automatic order of the method. An order is the number of poles for some \
             methods, of coefficients or of initial poles for others: orders of different methods are not comparable."
                .to_owned(),
        ],
    })
}

fn single_mode_block(test: &TestNeeds, needs: &SceneNeeds) -> Block {
    let mut columns = vec![Column::number("f (Hz)"), Column::number("ζ (%)")];
    for method in test.single.iter().take(1).flat_map(|mode| &mode.single) {
        columns.push(Column::number(format!("{} Δf (%)", method.method)));
        columns.push(Column::number(format!("{} Δζ (%)", method.method)));
    }
    columns.push(Column::text("enough"));
    let row = |mode: &ModeNeeds| {
        let errors = |single: &SingleMode| {
            let percent = single
                .errors
                .map(|errors| errors.map(|error| 100.0 * error));
            [
                Cell::signed(percent.map(|errors| errors[0]), 4),
                Cell::signed(percent.map(|errors| errors[1]), 2),
            ]
        };
        let mut cells = vec![
            Cell::number(Some(mode.frequency_hz), 3),
            Cell::number(Some(100.0 * mode.damping_ratio), 4),
        ];
        cells.extend(mode.single.iter().flat_map(errors));
        cells.push(Cell::text(mode.simplest().unwrap_or("none alone")));
        cells
    };
    Block::Table(Table {
        caption: format!(
            "{}: where one mode at a time is enough",
            test_title(&test.name, test.synthetic)
        ),
        columns,
        rows: test.single.iter().map(row).collect(),
        footnotes: vec![format!(
            "Errors relative to `ml`; enough: within {} % in frequency and {} % in damping, or within two standard deviations. —: missed, or with a MAC below 0.9.",
            needs.options.frequency_percent, needs.options.damping_percent
        )],
    })
}

/// All numbers of modes of every test, as `order.csv` and `order.json` hold them.
pub fn order_table(needs: &SceneNeeds) -> Block {
    let yes = |value: bool| Cell::text(if value { "yes" } else { "no" });
    let of_test = |test: &TestNeeds| {
        let row = |(number, tried): (usize, &OrderStep)| {
            vec![
                Cell::text(test.name.as_str()),
                Cell::count(number),
                Cell::number(tried.pole.map(|pole| pole.natural_frequency_hz()), 6),
                Cell::number(tried.pole.map(|pole| pole.damping_ratio()), 9),
                tried.pole.map_or(Cell::Missing, |_| yes(tried.identified)),
                tried
                    .pole
                    .map_or(Cell::Missing, |_| Cell::count(tried.holding)),
                Cell::number(Some(tried.bic), 6),
                Cell::number(tried.predicted.map(|score| score.mean), 9),
                Cell::number(tried.predicted.map(|score| score.std), 9),
                Cell::number(Some(tried.rest), 9),
            ]
        };
        let rows = test.support.tried.iter().enumerate().map(row);
        rows.collect::<Vec<_>>()
    };
    let numbers = ["roots", "frequency_hz", "damping_ratio", "identified"];
    let more = ["holding", "bic", "predicted", "predicted_std", "rest"];
    let columns = [Column::text("test")].into_iter();
    Block::Table(Table {
        caption: "Roots".to_owned(),
        columns: columns
            .chain(numbers.into_iter().chain(more).map(Column::number))
            .collect(),
        rows: needs.tests.iter().flat_map(of_test).collect(),
        footnotes: Vec::new(),
    })
}
