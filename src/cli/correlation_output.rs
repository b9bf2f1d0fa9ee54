//! The output of a correlation renders its blocks as text, its tables as files.

use std::path::{Path, PathBuf};

use crate::report::{Block, abridged, renderer_for_extension};

use super::args::CorrelateArgs;
use super::output::Output;
use super::targets::numbered_path;

/// A result as text and as JSON.
pub(super) struct CorrelationOutput {
    blocks: Vec<Block>,
    /// Blocks of a LaTeX file, where these are others.
    page: Option<Vec<Block>>,
    /// Indices of the blocks that become a CSV file each.
    tables: Vec<usize>,
    json: String,
    /// What to do next.
    next: Option<String>,
}

impl CorrelationOutput {
    /// Blocks of which the first is the table.
    pub(super) fn of_blocks(blocks: Vec<Block>, json: String) -> Self {
        let tables = vec![0];
        Self {
            blocks,
            page: None,
            tables,
            json,
            next: None,
        }
    }

    /// With the next step.
    pub(super) fn with_next(mut self, next: Option<String>) -> Self {
        self.next = next;
        self
    }

    /// With other blocks for a LaTeX file.
    pub(super) fn with_page(mut self, page: Vec<Block>) -> Self {
        self.page = Some(page);
        self
    }

    /// Blocks of several tests, of each of which the first is the table.
    pub(super) fn of_tests(tests: Vec<Vec<Block>>, json: String) -> Self {
        let (mut blocks, mut tables) = (Vec::new(), Vec::new());
        for of_test in tests {
            tables.push(blocks.len());
            blocks.extend(of_test);
        }
        Self {
            blocks,
            page: None,
            tables,
            json,
            next: None,
        }
    }

    /// The files at a path: these blocks in the chosen language; CSV, which programs read, in
    /// English, with a file for each table.
    fn files(&self, path: &Path, blocks: &[Block]) -> Vec<(PathBuf, String)> {
        let extension = path
            .extension()
            .and_then(|extension| extension.to_str())
            .unwrap_or("")
            .to_lowercase();
        let Some(renderer) = renderer_for_extension(&extension) else {
            return vec![(path.to_owned(), self.json.clone())];
        };
        if renderer.name() != "csv" {
            return vec![(path.to_owned(), renderer.render(blocks))];
        }
        let table = |at: usize| renderer.render(&self.blocks[at..=at]);
        if let [only] = self.tables.as_slice() {
            return vec![(path.to_owned(), table(*only))];
        }
        let tables = (1..).zip(&self.tables);
        tables
            .map(|(number, at)| (numbered_path(path, number), table(*at)))
            .collect()
    }
}

/// Prints a result, and writes it with `-o`; the tables of several tests as CSV to a file each,
/// `x-1.csv`, `x-2.csv`. Without blocks for the screen, it has the first of all.
pub(super) fn print(
    args: &CorrelateArgs,
    printed: CorrelationOutput,
    screen: Option<&dyn Fn(usize) -> Vec<Block>>,
    output: &mut Output,
) {
    if let Some(path) = &args.output {
        let is_latex = path
            .extension()
            .is_some_and(|kind| kind.eq_ignore_ascii_case("tex"));
        let page = printed.page.as_ref().filter(|_| is_latex);
        let blocks = page.unwrap_or(&printed.blocks).clone();
        let translated = output.language().translated(blocks);
        let blocks = format_blocks(args, translated);
        for (path, text) in printed.files(path, &blocks) {
            output.add_file(path, text);
        }
    }
    let (blocks, format) = (printed.blocks, |blocks| format_blocks(args, blocks));
    let first_of_all = |width: usize| abridged(blocks.clone(), width);
    output.add_formatted_result(screen.unwrap_or(&first_of_all), || blocks.clone(), format);
    let rest = match args.output {
        Some(_) => "All columns and notes: --full.",
        None => "All columns and notes: --full; tables to a file: -o FILE.",
    };
    output.add_closing(printed.next.into_iter().collect(), Some(rest));
    output.add_json(|| printed.json);
}

/// Blocks with the caption and the number format that were chosen.
fn format_blocks(args: &CorrelateArgs, mut blocks: Vec<Block>) -> Vec<Block> {
    let tables = blocks.iter_mut().filter_map(|block| match block {
        Block::Table(table) => Some(table),
        _ => None,
    });
    for (number, table) in tables.enumerate() {
        if let Some(caption) = args.caption.as_ref().filter(|_| number == 0) {
            table.caption = caption.clone();
        }
        if let Some(digits) = args.digits {
            *table = std::mem::take(table).with_decimals(digits.into());
        }
    }
    blocks
}
