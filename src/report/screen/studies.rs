//! The screens of the studies: the method to use, one table that shows why, and where it fails.

use crate::report::json::BreakdownFile;
use crate::report::{Block, Cell, Column, Renderer, Table, Terminal};
use crate::study::breakdown::{SliceResult, breakdown_verdict, ranges_text, short_number};
use crate::study::{
    Condition, DataRow, LowestOrder, SceneNeeds, SpeedAccuracy, TestNeeds, TestStudy,
    method_sentences, method_verdicts, needs_of_model,
};

use super::abridged::narrowed;
use super::{MAX_ROWS, counted, without_empty_columns};

/// Maximum number of rows of which every method of every test has one; beyond it only methods
/// without missed and spurious modes have a row.
const MAX_ROWS_OF_METHODS: usize = 16;

/// Lines of the screen of a study without the note on the rest.
const MAX_LINES: usize = 36;

/// Speed against accuracy: a verdict for each test, and a row for each method on the FRFs of the
/// scene. Where they do not fit a screen, rows of methods are omitted, then tests.
pub fn speed_accuracy_screen(study: &SpeedAccuracy, width: usize) -> Vec<Block> {
    let terminal = Terminal { width: Some(width) };
    let rows = (0..=MAX_ROWS).rev().map(|rows| (rows, study.tests.len()));
    let tests = (1..study.tests.len()).rev().map(|tests| (0, tests));
    let mut blocks = Vec::new();
    for (rows, tests) in rows.chain(tests) {
        blocks = speed_accuracy_in(study, width, rows, tests);
        if terminal.render(&blocks).lines().count() <= MAX_LINES {
            break;
        }
    }
    blocks
}

/// The verdicts of so many tests, and so many rows of methods.
fn speed_accuracy_in(
    study: &SpeedAccuracy,
    width: usize,
    max_rows: usize,
    max_tests: usize,
) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(format!(
        "{}: speed against accuracy",
        study.title
    ))];
    let mut verdicts = method_verdicts(study);
    let further = verdicts.len().saturating_sub(max_tests);
    verdicts.truncate(max_tests);
    verdicts
        .extend((further > 0).then(|| format!("{}: --full.", counted(further, "further test"))));
    blocks.push(Block::Text(verdicts.join("\n")));
    let recommended = |test: &TestStudy, row: &DataRow| {
        let best = test.recommended(&study.options);
        best.is_some_and(|best| best.method == row.method)
    };
    let all = study.tests.iter().flat_map(|test| {
        let rows = test.scene_rows();
        rows.filter(|row| row.method.order.is_none() || recommended(test, row))
            .map(move |row| (test, row))
    });
    let all: Vec<(&TestStudy, &DataRow)> = all.collect();
    let has_no_mistakes = |row: &DataRow| row.is_reference || row.counts.mistakes() == 0;
    let mut shown: Vec<(&TestStudy, &DataRow)> = all
        .iter()
        .filter(|(_, row)| all.len() <= MAX_ROWS_OF_METHODS || has_no_mistakes(row))
        .copied()
        .collect();
    let with_mistakes = all.len() - shown.len();
    // The recommended methods and ml come first, then the others in their order.
    let rank =
        |(test, row): &(&TestStudy, &DataRow)| match (recommended(test, row), row.is_reference) {
            (true, _) => 0,
            (false, true) => 1,
            (false, false) => 2,
        };
    let mut ranked: Vec<usize> = (0..shown.len()).collect();
    ranked.sort_by_key(|row| rank(&shown[*row]));
    ranked.truncate(max_rows);
    ranked.sort_unstable();
    let without_room = shown.len() - ranked.len();
    shown = ranked.into_iter().map(|row| shown[row]).collect();
    let rows: Vec<Vec<Cell>> = shown
        .iter()
        .map(|(test, row)| method_row(test, row))
        .collect();
    let omitted = with_mistakes + without_room;
    let mut footnotes = vec![
        "Errors: largest difference to the modes of ml. Noise floor: rms standard deviation of the frequencies of ml. Times the bound: rms \
         frequency error on the synthetic twin over its Cramér-Rao bound in white noise, the largest of all noise levels. CPU time: all \
         threads of this machine."
            .to_owned(),
    ];
    if with_mistakes > 0 {
        let methods = counted(with_mistakes, "further row");
        footnotes.push(format!(
            "{methods} of methods that miss or invent modes: --full."
        ));
    }
    footnotes.extend(
        (without_room > 0).then(|| format!("{}: --full.", counted(without_room, "further row"))),
    );
    let numbers = [
        "CPU time\n(s)",
        "frequency\nerror (%)",
        "times the\nnoise floor",
        "damping\nerror (%)",
        "missed",
        "spurious",
        "times the\nbound",
    ];
    let text = ["test", "method"].map(Column::text);
    let mut table = Table {
        caption: "Methods on the FRFs of the scene".to_owned(),
        columns: text
            .into_iter()
            .chain(numbers.map(Column::number))
            .collect(),
        rows,
        footnotes,
    };
    if study.tests.len() == 1 {
        super::omit_column(&mut table, 0);
    }
    let columns = table.columns.len();
    let mut table = without_empty_columns(table, &["missed", "spurious"]);
    if omitted == 0 && !table.rows.is_empty() && table.columns.len() + 2 == columns {
        let sentence = "Every method finds all modes of ml and no other.";
        table.footnotes.insert(0, sentence.to_owned());
    }
    if !table.rows.is_empty() {
        blocks.push(Block::Table(narrowed(table, width)));
    }
    blocks
}

fn method_row(test: &TestStudy, row: &DataRow) -> Vec<Cell> {
    let percent = |value: Option<f64>| match row.is_reference {
        true => Cell::Missing,
        false => Cell::std(value.map(|value| 100.0 * value), 0),
    };
    let over_bound = test
        .twin
        .iter()
        .filter(|twin| twin.condition == Condition::White && twin.method == row.method);
    let over_bound = over_bound.filter_map(|twin| twin.counts.frequency_over_bound());
    let counts = &row.counts;
    vec![
        Cell::text(test.name.as_str()),
        Cell::text(row.method.to_string()),
        Cell::std(row.timing.median_s, 0),
        percent(counts.largest_frequency()),
        Cell::std(test.largest_error_over_std(row), 0),
        percent(counts.largest_damping()),
        Cell::count(counts.observable - counts.found),
        Cell::count(counts.spurious),
        Cell::std(over_bound.reduce(f64::max), 0),
    ]
}

/// Where methods fail: the verdict, and for each method and slice the range of the first factor in
/// which it meets the stated error, at the middle of the second.
pub fn breakdown_screen(file: &BreakdownFile, width: usize) -> Vec<Block> {
    let heading = match &file.title {
        Some(title) => format!("{title}: where methods fail"),
        None => "Where methods fail".to_owned(),
    };
    let mut blocks = vec![Block::Heading(heading)];
    blocks.extend(breakdown_verdict(&file.slices, &file.user_modes).map(Block::Text));
    let mut methods: Vec<&str> = Vec::new();
    for method in file.slices.iter().flat_map(|slice| &slice.slice.methods) {
        if !methods.contains(&method.as_str()) {
            methods.push(method);
        }
    }
    let row = |method: &&str| {
        let ranges = file.slices.iter().map(|slice| middle_range(slice, method));
        std::iter::once(Cell::text(*method)).chain(ranges).collect()
    };
    let head = |result: &SliceResult| {
        let (x, y) = (&result.slice.x, &result.slice.y);
        let unit = match y.factor.unit() {
            "dB" => " dB",
            _ => "",
        };
        Column::text(format!(
            "{}\nat {}\n{}{unit}",
            x.factor.name().replace('_', " "),
            y.factor.name().replace('_', " "),
            short_number(y.at(MIDDLE)),
        ))
    };
    let heads = file.slices.iter().map(head);
    let draws = file.slices.iter().map(|slice| slice.slice.draws).min();
    let mut footnotes = vec![format!(
        "Ranges in which the method meets the stated error in 95 % of the draws ({} for each cell), with the second factor in the middle of \
         its range. They hold for the structure of the study; for others they show roughly where a method fails.",
        draws.unwrap_or(0)
    )];
    if !file.user_modes.is_empty() {
        footnotes.push("Distances of each mode of the scene from these limits: --full.".to_owned());
    }
    let table = Table {
        caption: "Where each method meets the stated error".to_owned(),
        columns: std::iter::once(Column::text("method"))
            .chain(heads)
            .collect(),
        rows: methods.iter().map(row).collect(),
        footnotes,
    };
    blocks.push(Block::Table(narrowed(table, width)));
    blocks
}

/// Position on the second axis of the ranges on the screen.
const MIDDLE: f64 = 0.5;

fn middle_range(result: &SliceResult, method: &str) -> Cell {
    let slice = &result.slice;
    let Some(index) = slice.methods.iter().position(|name| name == method) else {
        return Cell::Missing;
    };
    let middle = slice.y.at(MIDDLE);
    let ranges = result.success_ranges(index);
    let range = ranges
        .iter()
        .find(|range| range.at_y.total_cmp(&middle).is_eq());
    range.map_or(Cell::Missing, |range| {
        Cell::text(ranges_text(&range.inside, &slice.x))
    })
}

/// What a scene needs: the method, theory and parameters in a sentence each, and a row of numbers
/// of modes and lowest orders for each test.
pub fn order_screen(needs: &SceneNeeds, width: usize) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(format!(
        "{}: the least model and method that it needs",
        needs.title
    ))];
    let warned = needs.tests.iter().filter(|test| !test.warnings.is_empty());
    let warned = warned.map(|test| {
        let count = counted(test.warnings.len(), "warning");
        format!("{}: {count} of its identification (--full).", test.name)
    });
    let failed = needs.failed.iter();
    let failed = failed.map(|(name, reason)| format!("{name}: not analysed: {reason}."));
    let sentences = method_sentences(needs)
        .into_iter()
        .chain(warned)
        .chain(failed);
    let sentences: Vec<String> = sentences.chain(needs_of_model(needs)).collect();
    blocks.push(Block::Text(sentences.join("\n")));
    if needs.tests.is_empty() {
        return blocks;
    }
    let mut methods: Vec<&str> = Vec::new();
    for method in needs.tests.iter().flat_map(|test| &test.orders) {
        if !methods.contains(&method.method) {
            methods.push(method.method);
        }
    }
    let row = |test: &TestNeeds| {
        let support = &test.support;
        let mut cells = vec![
            Cell::text(test.name.as_str()),
            Cell::count(support.identified),
            Cell::count(support.by_bic()),
            support.by_prediction().map_or(Cell::Missing, Cell::count),
            Cell::count(support.by_residual()),
        ];
        cells.extend(methods.iter().map(|method| {
            let mut orders = test.orders.iter();
            let lowest = orders.find(|order| order.method == *method);
            lowest
                .and_then(LowestOrder::lowest)
                .map_or(Cell::Missing, Cell::count)
        }));
        cells
    };
    let counts = [
        "poles\nidentified",
        "poles\nby BIC",
        "by held-out\nlines",
        "by\nresidual",
    ];
    let orders = methods
        .iter()
        .map(|method| Column::number(format!("order\nof {method}")));
    let options = &needs.options;
    let table = Table {
        caption: "Numbers of poles that the data support, and lowest orders".to_owned(),
        columns: std::iter::once(Column::text("test"))
            .chain(counts.map(Column::number))
            .chain(orders)
            .collect(),
        rows: needs.tests.iter().map(row).collect(),
        footnotes: vec![format!(
            "Lowest order: the least with every observable mode of ml and no other. Enough: within {} % in frequency and {} % in damping of \
             ml, or within two standard deviations.",
            options.frequency_percent, options.damping_percent
        )],
    };
    blocks.push(Block::Table(narrowed(table, width)));
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Language;
    use crate::study::{DetectionCounts, Method, SpeedAccuracyOptions, SpeedLimits, Timing};

    fn study(tests: usize) -> SpeedAccuracy {
        let row = |method: Method| DataRow {
            estimator: Some("h1"),
            step_hz: 0.25,
            method,
            is_reference: method == Method::REFINED,
            counts: DetectionCounts::default(),
            has_close_modes: false,
            timing: Timing::default(),
            on_front: false,
        };
        let test = |number: usize| TestStudy {
            name: format!("roving hammer on the housing, state {number}"),
            inputs: Vec::new(),
            functions: 11,
            lines: 4096,
            refined_modes: 12,
            frequency_std: Some(1e-6),
            damping_std: Some(1e-4),
            twin_of_truth: false,
            twin_modes: 12,
            twin_step_hz: 0.25,
            data: Method::all(&[16, 32]).into_iter().map(row).collect(),
            twin: Vec::new(),
            twin_costs: Vec::new(),
            limits: [SpeedLimits::default(); 2],
            notes: Vec::new(),
        };
        SpeedAccuracy {
            title: "Gear".to_owned(),
            options: SpeedAccuracyOptions::default(),
            tests: (1..=tests).map(test).collect(),
        }
    }

    #[test]
    fn speed_against_accuracy_of_many_tests_fits_a_screen_and_counts_what_is_omitted() {
        for (tests, omitted) in [
            (1, None),
            (5, Some("further rows: --full")),
            (40, Some("further tests: --full")),
        ] {
            for width in [80, 100] {
                let terminal = Terminal { width: Some(width) };
                let text = terminal.render(&speed_accuracy_screen(&study(tests), width));
                assert!(text.lines().count() <= MAX_LINES, "{text}");
                assert!(text.contains("state 1: use ml"), "{text}");
                let blocks = speed_accuracy_screen(&study(tests), width);
                let chinese = terminal.render(&Language::Chinese.translated(blocks));
                let is_word = |word: &str| word.chars().all(|c| c.is_ascii_lowercase());
                let mut lines = chinese.lines().filter(|line| !line.contains("roving"));
                let has_english = lines.any(|line| {
                    let words: Vec<&str> = line.split_whitespace().collect();
                    words
                        .windows(3)
                        .any(|three| three.iter().all(|word| is_word(word)))
                });
                assert!(!has_english && chinese.contains("采用 ml"), "{chinese}");
                match omitted {
                    Some(note) => assert!(text.contains(note), "{text}"),
                    None => assert!(!text.contains("--full"), "{text}"),
                }
            }
        }
    }
}
