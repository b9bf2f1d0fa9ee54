//! The page blocks hold the tables of a paper: the columns of the screen, with all rows and without
//! the notes that only a reader of the data needs.

use crate::correlate::{ComparisonTable, Footnote};
use crate::modal::ModalModel;
use crate::report::comparison::{all_tests, headlines};
use crate::report::modes::synthetic_note;
use crate::report::{Block, Cell, Table, TableGroup, parameters_block};
use crate::scene::Theory;

use super::comparison::{Form, ModeTables, counts_table};
use super::modes::{ModesRoom, listed_modes};

/// Characters in a line of a page: a table of this width has no smaller type than footnotes, or
/// little smaller. With more, tables have columns that do not fit; with fewer, pages lack columns
/// that do.
const PAGE_WIDTH: usize = 94;

/// The tables of a validation section as [`crate::report::comparison_blocks`], with the essential
/// columns.
pub fn comparison_page(
    table: &ComparisonTable,
    groups: &[TableGroup<'_>],
    theory: &Theory,
) -> Vec<Block> {
    let mut blocks = Vec::new();
    for group in groups {
        let tests: Vec<&str> = group.tests.iter().map(String::as_str).collect();
        let tables = ModeTables {
            table,
            width: PAGE_WIDTH,
            form: Form::Page,
            most: usize::MAX,
        };
        for mut modes in tables.of(&tests) {
            remove_notes_on_the_screen(&mut modes);
            modes.caption = group.caption.to_owned();
            let synthetic = table.footnotes.iter().filter(
                |note| matches!(note, Footnote::Synthetic(test) if group.tests.contains(test)),
            );
            modes.footnotes.extend(synthetic.map(ToString::to_string));
            modes.footnotes.extend_from_slice(group.notes);
            blocks.push(Block::Table(modes));
        }
    }
    blocks.extend(headlines(table));
    let mut counts = counts_table(table, PAGE_WIDTH);
    remove_notes_on_the_screen(&mut counts);
    counts.caption = "Summary".to_owned();
    // LaTeX wraps names itself.
    for (row, summary) in counts.rows.iter_mut().zip(&table.summary) {
        row[0] = Cell::text(&summary.test);
    }
    blocks.push(Block::Table(counts));
    blocks.extend(parameters_block(&theory.parameters));
    blocks
}

/// As [`comparison_page`], with all tests in one table where they fit.
pub fn comparison_page_of_all_tests(table: &ComparisonTable, theory: &Theory) -> Vec<Block> {
    let tests = all_tests(table);
    comparison_page(table, &[TableGroup::of_all(&tests)], theory)
}

/// Identified modes of a test with the essential columns.
pub fn modes_page(test: &str, model: &ModalModel) -> Vec<Block> {
    let room = ModesRoom {
        width: PAGE_WIDTH,
        rows: usize::MAX,
        remark_lines: usize::MAX,
    };
    let mut blocks = listed_modes(test, model, "", room);
    for block in &mut blocks {
        if let Block::Table(table) = block {
            remove_notes_on_the_screen(table);
            table.footnotes.extend(synthetic_note(model));
        }
    }
    blocks
}

/// Removes the notes that name an option of the command line.
fn remove_notes_on_the_screen(table: &mut Table) {
    table.footnotes.retain(|note| !note.ends_with("--full."));
}
