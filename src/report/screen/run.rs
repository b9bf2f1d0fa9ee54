//! The screen of `run`: verdict, comparison, published results, and what to do next.

use crate::report::Block;
use crate::scene::SceneResult;

use super::comparison::comparison_screen;
use super::modes::{modes_screen, roots_screen};
use super::sentences::{assumptions, limits, next_points, published, synthetic};

/// The result of a scene: limits, synthetic data and assumptions; the comparison, or the modes of
/// the tests, or the roots of the model; published results; recommended points.
pub fn run_screen(title: &str, result: &SceneResult, width: usize) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(title.to_owned())];
    let verdict = [
        result.table.as_ref().map(|_| limits(&result.limits)),
        synthetic(&result.tests),
        assumptions(&result.theory),
    ];
    let verdict: Vec<String> = verdict.into_iter().flatten().collect();
    blocks.push(Block::Text(verdict.join("\n")));
    match &result.table {
        Some(table) => blocks.extend(comparison_screen(table, width)),
        None if result.tests.is_empty() => {
            let roots = &result.theory.roots;
            blocks.extend(roots_screen("Roots of the model", roots, None, width));
        }
        None => {
            let tests = result.tests.iter();
            blocks.extend(tests.flat_map(|test| modes_screen(&test.name, &test.modes, width)));
        }
    }
    let published = result.expected.iter().flat_map(published);
    let points = result.placements.iter().filter_map(next_points);
    let last: Vec<String> = published.chain(points).collect();
    blocks.push(Block::Text(last.join("\n")));
    blocks
}
