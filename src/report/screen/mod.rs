//! The screen blocks hold what a verb prints by default: the verdict, one table of the essential
//! columns and rows, and what to do next.
//!
//! `--full` prints the blocks of the report in their place; files and JSON never depend on this
//! choice. A screen is at most as wide as the terminal where its content allows. It omits columns
//! and rows in a stated order, and says so. LaTeX, whose pages are narrow, has the columns of a
//! screen of a fixed width.

mod abridged;
mod agreement;
mod comparison;
mod frequency_ratio;
mod hits;
mod modes;
mod next_step;
mod page;
mod regression_check;
mod run;
mod sentences;
mod studies;
mod update;

use super::terminal::table_width;
use super::{Cell, Table};
use crate::printable::counted;

pub use abridged::{abridged, tables_with_values, without_whole_shares};
pub(super) use abridged::{omissible_column, omitted_columns};
pub use comparison::{comparison_screen, counts_block};
pub use hits::hits_screen;
pub use modes::{modes_screen, roots_screen};
pub use next_step::{next_step, step_after_update, step_to_check};
pub use page::{comparison_page, comparison_page_of_all_tests, modes_page};
pub use regression_check::regression_check_screen;
pub use run::run_screen;
pub use studies::{breakdown_screen, order_screen, speed_accuracy_screen};
pub use update::update_screen;

/// Decimals of MAC, MPC and coherence on the screen.
const MAC_DECIMALS: usize = 3;
/// Maximum number of rows of a table on the screen.
const MAX_ROWS: usize = 30;

/// The table without the columns of these heads, omitted one after the other until it has the
/// width; a note names them.
fn fitted(mut table: Table, omissible: &[&str], width: usize) -> Table {
    let all = table.columns.clone();
    for head in omissible {
        if table_width(&table) <= width {
            break;
        }
        let index = table.columns.iter().position(|column| column.head == *head);
        if let Some(index) = index {
            omit_column(&mut table, index);
        }
    }
    let omitted = omitted_columns(&all, &table.columns);
    let note = omitted.map(|omitted| format!("{omitted}: --full."));
    table.footnotes.extend(note);
    table
}

/// Removes one column by its index.
pub(super) fn omit_column(table: &mut Table, index: usize) {
    table.columns.remove(index);
    for row in &mut table.rows {
        row.remove(index);
    }
}

/// The table without its columns of these heads that hold no value or, as counts, only zeros.
fn without_empty_columns(mut table: Table, heads: &[&str]) -> Table {
    let is_empty = |cell: &Cell| match cell {
        Cell::Missing => true,
        Cell::Text(text) => text.trim().is_empty() || text == "0",
        Cell::Number { .. } => cell.display() == "0",
        _ => false,
    };
    for index in (0..table.columns.len()).rev() {
        let is_named = heads.contains(&table.columns[index].head.as_str());
        if is_named && table.rows.iter().all(|row| is_empty(&row[index])) {
            omit_column(&mut table, index);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Column;

    fn table() -> Table {
        Table {
            columns: ["mode", "std (Hz)", "MAC"].map(Column::number).to_vec(),
            rows: vec![
                vec![Cell::text("f1"), Cell::text("0.12"), Cell::text("0")],
                vec![Cell::text("f2"), Cell::Missing, Cell::text("0")],
            ],
            ..Table::default()
        }
    }

    fn heads(table: &Table) -> Vec<&str> {
        table.columns.iter().map(|c| c.head.as_str()).collect()
    }

    #[test]
    fn columns_are_omitted_in_the_stated_order_until_the_table_fits() {
        let width = table_width(&table());
        for (width, expected) in [
            (width, &["mode", "std (Hz)", "MAC"][..]),
            (width - 1, &["mode", "MAC"]),
            (1, &["mode"]),
        ] {
            let fitted = fitted(table(), &["std (Hz)", "MAC"], width);
            assert_eq!(heads(&fitted), expected);
            assert_eq!(fitted.footnotes.is_empty(), expected.len() == 3);
            assert!(fitted.rows.iter().all(|row| row.len() == expected.len()));
        }
    }

    #[test]
    fn only_named_columns_without_values_are_omitted() {
        let shown = without_empty_columns(table(), &["std (Hz)", "MAC"]);
        assert_eq!(heads(&shown), ["mode", "std (Hz)"]);
        let shown = without_empty_columns(table(), &["std (Hz)"]);
        assert_eq!(heads(&shown).len(), 3);
    }
}
