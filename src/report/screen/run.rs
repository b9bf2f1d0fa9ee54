//! The screen of `run`: verdict, comparison, published results, and points to measure.

use crate::frf::HitReport;
use crate::report::{Block, Renderer, Terminal, before_you_leave_line};
use crate::scene::{Scene, SceneResult, TestResult};

use super::agreement::agreement;
use super::comparison::{comparison_tables, reasons};
use super::frequency_ratio::{FrequencyRatio, frequency_ratio};
use super::hits::hit_sentence;
use super::modes::{ModesRoom, modes_and_advice, roots_screen};
use super::sentences::{
    assumptions, common_error, limits, next_points, not_reproduced, pairs, peaks_without_mode,
    published, synthetic, unmoved_sensors, verdict_warnings,
};
use super::{MAX_ROWS, counted};

/// What to try where one of several tests has no modes.
const ADVICE: &str = "Try another band (band_hz of [[test]]) or method or order ([identify]); check units and coherence.";
/// Lines of the screen without the next step and the note on the rest.
const MAX_LINES: usize = 54;
/// Rows of a table of modes, of which the first number that fits is taken.
const ROWS: [usize; 12] = [MAX_ROWS, 24, 20, 18, 16, 14, 12, 10, 8, 7, 6, MIN_ROWS];
/// Minimum number of these rows.
const MIN_ROWS: usize = 5;
/// Published statements of which the first that fits is taken; one has no line alone.
const STATEMENTS: [usize; 8] = [MAX_ROWS, 16, 12, 8, 6, 4, 2, 1];

/// How much of the result a screen has room for.
#[derive(Clone, Copy)]
struct Room {
    /// Modes of a table.
    rows: usize,
    /// Lines of the remarks on a mode.
    remark_lines: usize,
    /// Tests whose modes are listed.
    tests: usize,
    /// Published statements that are not reproduced.
    statements: usize,
}

/// The rooms in the order in which the content is omitted: published statements, lines of remarks,
/// modes, tests.
fn rooms(tests: usize) -> impl Iterator<Item = Room> {
    let all = Room {
        rows: MAX_ROWS,
        remark_lines: usize::MAX,
        tests: usize::MAX,
        statements: MAX_ROWS,
    };
    let few = Room {
        statements: 1,
        ..all
    };
    let statements = STATEMENTS.map(|statements| Room { statements, ..all });
    let remarks = [3, 2, 1].map(|remark_lines| Room {
        remark_lines,
        ..few
    });
    let least = Room {
        rows: MIN_ROWS,
        remark_lines: 1,
        ..few
    };
    let rows = ROWS.map(|rows| Room { rows, ..least });
    let fewer_tests = (1..=tests).rev().map(move |tests| Room { tests, ..least });
    statements
        .into_iter()
        .chain(remarks)
        .chain(rows)
        .chain(fewer_tests)
}

/// The result of a scene: limits, agreement, synthetic data and assumptions; the comparison, or the
/// modes of the tests, or the roots of the model; published results; what each test needs;
/// recommended points. What has no room is omitted in a stated order.
pub fn run_screen(scene: &Scene, result: &SceneResult, width: usize) -> Vec<Block> {
    let terminal = Terminal { width: Some(width) };
    let mut blocks = Vec::new();
    for room in rooms(result.tests.len()) {
        blocks = blocks_in(scene, result, width, room);
        if terminal.render(&blocks).lines().count() <= MAX_LINES {
            break;
        }
    }
    blocks
}

fn blocks_in(scene: &Scene, result: &SceneResult, width: usize, room: Room) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(scene.title.clone())];
    blocks.push(Block::Text(verdict(result).join("\n")));
    match &result.table {
        Some(table) => blocks.extend(comparison_tables(table, width, room.rows, room.tests)),
        None if result.tests.is_empty() => {
            let sentence = "The scene has no test, so that nothing is compared.";
            blocks.push(Block::Text(sentence.to_owned()));
            let roots = &result.theory.roots;
            blocks.extend(roots_screen(
                "Roots of the model",
                roots,
                scene.first_root,
                None,
                width,
            ));
        }
        None => {
            let sentence = "The scene has no model, so that nothing is compared.";
            blocks.push(Block::Text(sentence.to_owned()));
            blocks.extend(modes_of_tests(result, width, room));
        }
    }
    let lists = result.tests.iter();
    let lists = lists.filter_map(|test| {
        // A computed structure cannot be hit again.
        let measured = (!test.is_synthetic()).then_some(test);
        let list = measured?.before_you_leave.as_ref()?;
        Some(before_you_leave_line(&test.name, list))
    });
    let published = result.expected.iter().flat_map(|expected| {
        let statements = not_reproduced(expected, width, room.statements);
        published(expected).into_iter().chain(statements)
    });
    let points = result.placements.iter();
    let points = points.filter_map(|placed| next_points(placed, result.table.as_ref()));
    let reasons = result.table.iter().flat_map(reasons);
    let last = reasons.chain(published).chain(lists).chain(points);
    let last: Vec<String> = last.collect();
    blocks.push(Block::Text(last.join("\n")));
    blocks
}

/// Whether limits are met, how far the model agrees with each test and which way it is off, what
/// the data are, and the warnings that put this in question.
fn verdict(result: &SceneResult) -> Vec<String> {
    let table = result.table.as_ref();
    let limits = table.map(|_| limits(&result.limits));
    let ratio = frequency_ratio(result);
    let hits: Vec<HitReport> = result
        .tests
        .iter()
        .flat_map(|test| test.hits.clone())
        .collect();
    let with_hits = result.tests.iter().filter(|test| !test.hits.is_empty());
    let sentences = [
        ratio.as_ref().and_then(FrequencyRatio::sentence),
        table.map(pairs),
        table.and_then(common_error),
        table.and_then(|_| peaks_without_mode(&result.tests)),
        (!hits.is_empty()).then(|| hit_sentence(&hits, with_hits.count())),
        synthetic(result.tests.iter()),
        assumptions(&result.theory),
        unmoved_sensors(&result.theory),
    ];
    let first = limits
        .into_iter()
        .chain(table.iter().flat_map(|table| agreement(table)));
    first
        .chain(sentences.into_iter().flatten())
        .chain(verdict_warnings(&result.findings_by_test()))
        .collect()
}

/// The modes of the tests of a scene without a model.
fn modes_of_tests(result: &SceneResult, width: usize, room: Room) -> Vec<Block> {
    // Where no test has modes, the next step says so.
    let any = result.tests.iter().any(|test| !test.modes.modes.is_empty());
    let advice = if any { ADVICE } else { "" };
    let modes_room = ModesRoom {
        width,
        rows: room.rows,
        remark_lines: room.remark_lines,
    };
    let of_test = |test: &TestResult| modes_and_advice(&test.name, &test.modes, advice, modes_room);
    let shown = result.tests.iter().take(room.tests);
    let mut blocks: Vec<Block> = shown.flat_map(of_test).collect();
    let further = result.tests.iter().skip(room.tests).map(|test| {
        let modes = counted(test.modes.modes.len(), "mode");
        format!("{} ({modes})", test.name)
    });
    let further: Vec<String> = further.collect();
    let further = (!further.is_empty())
        .then(|| Block::Text(format!("Further tests (--full): {}.", further.join("; "))));
    blocks.extend(further);
    blocks
}
