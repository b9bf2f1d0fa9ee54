//! The screen of `run`: verdict, comparison, published results, and what to do next.

use crate::report::{Block, before_you_leave_line};
use crate::scene::{Scene, SceneResult, TestResult};

use super::MAX_ROWS;
use super::comparison::{comparison_tables, reasons};
use super::modes::{modes_and_advice, roots_screen};
use super::sentences::{
    assumptions, common_error, limits, next_points, pairs, published, synthetic, verdict_warnings,
};

/// What to try where a test has no modes.
const ADVICE: &str = "Try another band (band_hz of [[test]]) or method or order ([identify]); check units and coherence.";
/// Modes that are listed of each of many tests.
const MIN_MODES_OF_TEST: usize = 5;

/// The result of a scene: limits, synthetic data and assumptions; the comparison, or the modes of
/// the tests, or the roots of the model; published results; what each test needs; recommended
/// points.
pub fn run_screen(scene: &Scene, result: &SceneResult, width: usize) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(scene.title.clone())];
    let verdict = [
        result.table.as_ref().map(|_| limits(&result.limits)),
        result.table.as_ref().map(pairs),
        result.table.as_ref().and_then(common_error),
        synthetic(&result.tests),
        assumptions(&result.theory),
    ];
    let warnings = verdict_warnings(&result.findings_by_test());
    let verdict: Vec<String> = verdict.into_iter().flatten().chain(warnings).collect();
    blocks.push(Block::Text(verdict.join("\n")));
    match &result.table {
        Some(table) => blocks.extend(comparison_tables(table, width)),
        None if result.tests.is_empty() => {
            let sentence = "The scene has no test, so that nothing is compared. Next, a test: modalign new DIR FILE... --model MODEL.";
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
            let sentence =
                "Modes of the test; a [model] in scene.toml would be compared with them.";
            blocks.push(Block::Text(sentence.to_owned()));
            let most = (MAX_ROWS / result.tests.len()).max(MIN_MODES_OF_TEST);
            let of_test =
                |test: &TestResult| modes_and_advice(&test.name, &test.modes, ADVICE, width, most);
            blocks.extend(result.tests.iter().flat_map(of_test));
        }
    }
    let lists = result.tests.iter();
    let lists = lists.filter_map(|test| {
        // A computed structure cannot be hit again.
        let measured = (!test.is_synthetic()).then_some(test);
        let list = measured?.before_you_leave.as_ref()?;
        Some(before_you_leave_line(&test.name, list))
    });
    let published = result.expected.iter().flat_map(published);
    let points = result.placements.iter();
    let points = points.filter_map(|placed| next_points(placed, result.table.as_ref()));
    let reasons = result.table.iter().flat_map(reasons);
    let last = reasons.chain(published).chain(lists).chain(points);
    let last: Vec<String> = last.collect();
    blocks.push(Block::Text(last.join("\n")));
    blocks
}
