//! Blocks of the report cut to a screen: rows, columns, notes and whole tables are omitted, and
//! each place says so.

use crate::report::terminal::{table_width, wrapping};
use crate::report::{Align, Block, Cell, Column, Renderer, Table, Terminal};

use super::{MAX_ROWS, counted, omit_column};

/// Lines of a screen, without the names of omitted tables and a note of the verb below.
const MAX_LINES: usize = 32;
/// Rows of a table that is cut to the room that is left, at least.
const MIN_ROWS: usize = 4;
/// Notes below a table.
const MAX_NOTES: usize = 2;
/// Omitted columns that a note names.
const MAX_NAMED_COLUMNS: usize = 4;
/// Characters to which texts in cells are wrapped where a table is too wide, the others where no
/// column of numbers is left to omit.
const TEXT_CELL_WIDTHS: [usize; 4] = [30, 20, 14, 12];

/// Omitted tables that a text names.
const MAX_NAMED_TABLES: usize = 4;

/// A table without its columns of percentages that are 100 in every row, as of a single body; a
/// text where no other column of percentages remains.
pub fn without_whole_shares(block: Block) -> Block {
    let Block::Table(mut table) = block else {
        return block;
    };
    let is_whole = |cell: &Cell| match cell {
        Cell::Number { value, .. } => (value - 100.0).abs() < 0.5e-3,
        _ => false,
    };
    let mut names = Vec::new();
    for index in (1..table.columns.len()).rev() {
        let share = table.columns[index].head.strip_suffix(" (%)");
        let share = share.map(str::to_owned);
        let all_whole =
            !table.rows.is_empty() && table.rows.iter().all(|row| is_whole(&row[index]));
        if let Some(name) = share.filter(|_| all_whole) {
            omit_column(&mut table, index);
            names.insert(0, name);
        }
    }
    if names.is_empty() {
        return Block::Table(table);
    }
    let sentence = format!("100 % in every mode: {}.", names.join(", "));
    let mut columns = table.columns.iter().skip(1);
    if columns.any(|column| column.head.ends_with("(%)")) {
        table.footnotes.push(sentence);
        return Block::Table(table);
    }
    Block::Text(format!("{}: {sentence}", table.caption))
}

/// The blocks without tables of which no row has a value beside its label; a text counts them.
pub fn tables_with_values(blocks: Vec<Block>) -> Vec<Block> {
    let is_empty = |cell: &Cell| matches!(cell.display().trim(), "" | "—");
    let has_value = |block: &Block| match block {
        Block::Table(table) => {
            let mut cells = table.rows.iter().flat_map(|row| row.iter().skip(1));
            cells.any(|cell| !is_empty(cell))
        }
        _ => true,
    };
    let all = blocks.len();
    let mut kept: Vec<Block> = blocks.into_iter().filter(has_value).collect();
    let omitted = all - kept.len();
    if omitted > 0 {
        let tables = counted(omitted, "table");
        kept.push(Block::Text(format!("Without a value: {tables} (--full).")));
    }
    kept
}

/// The blocks as far as a screen of this width has room for them, in their order.
pub fn abridged(blocks: Vec<Block>, width: usize) -> Vec<Block> {
    let mut shown: Vec<Block> = Vec::new();
    let mut omitted: Vec<String> = Vec::new();
    let mut lines = 0;
    let is_table = |block: &Block| matches!(block, Block::Table(_));
    let mut tables = blocks.iter().filter(|block| is_table(block)).count();
    for block in blocks {
        let block = match block {
            Block::Table(table) => {
                let caption = table.caption.clone();
                // Half of the room remains for the tables that follow.
                let room = MAX_LINES.saturating_sub(lines) / tables.clamp(1, 2);
                tables -= 1;
                match abridged_table(table, width, room, shown.is_empty()) {
                    Some(table) => Block::Table(table),
                    None => {
                        omitted.push(caption);
                        continue;
                    }
                }
            }
            other => other,
        };
        lines += line_count(&block, width) + 1;
        shown.push(block);
    }
    if !omitted.is_empty() {
        let further = omitted.len().saturating_sub(MAX_NAMED_TABLES);
        omitted.truncate(MAX_NAMED_TABLES);
        omitted.extend((further > 0).then(|| format!("{further} more")));
        shown.push(Block::Text(format!(
            "Further tables (--full): {}.",
            omitted.join("; ")
        )));
    }
    shown
}

fn line_count(block: &Block, width: usize) -> usize {
    let terminal = Terminal { width: Some(width) };
    terminal.render(std::slice::from_ref(block)).lines().count()
}

/// The table with as many notes, columns and rows as there is room for, and no digits finer than
/// 0.001 % of a value; `None` where few rows are
/// left, unless it `is_first`.
fn abridged_table(mut table: Table, width: usize, room: usize, is_first: bool) -> Option<Table> {
    for row in &mut table.rows {
        for (cell, column) in row.iter_mut().zip(&table.columns) {
            let is_number = column.align == Align::Right;
            *cell = std::mem::replace(cell, Cell::Missing).without_fine_digits(is_number);
        }
    }
    let notes = table.footnotes.len().saturating_sub(MAX_NOTES);
    if notes > 0 {
        table.footnotes.truncate(MAX_NOTES);
        let notes = counted(notes, "further note");
        table.footnotes.push(format!("{notes}: --full."));
    }
    let mut table = narrowed(table, width);
    let rows = std::mem::take(&mut table.rows);
    let overhead = line_count(&Block::Table(table.clone()), width) + 1;
    table.rows = rows;
    let room = room.saturating_sub(overhead);
    let mut used = 0;
    let fitting = table.rows.iter().take(MAX_ROWS).take_while(|row| {
        used += row_lines(row);
        used <= room
    });
    let fitting = fitting.count();
    if table.rows.len() <= fitting {
        return Some(table);
    }
    // A line says how many rows are omitted.
    match (fitting > MIN_ROWS, is_first) {
        (true, _) => Some(cut_rows(table, fitting - 1)),
        (false, true) => Some(cut_rows(table, MIN_ROWS)),
        (false, false) => None,
    }
}

fn row_lines(row: &[Cell]) -> usize {
    let lines = row.iter().map(|cell| cell.display().lines().count());
    lines.max().unwrap_or(0).max(1)
}

/// The first rows of a table, with the number of the others.
pub(super) fn cut_rows(mut table: Table, most: usize) -> Table {
    let further = table.rows.len().saturating_sub(most);
    if further > 0 {
        table.rows.truncate(most);
        let further = counted(further, "further row");
        table.footnotes.push(format!("{further}: --full."));
    }
    table
}

/// The table in this width: its texts wrapped, then its columns of numbers omitted, those of
/// percentages with the smallest numbers first, others from the right. Names of omitted columns
/// are in a note.
pub(super) fn narrowed(mut table: Table, width: usize) -> Table {
    if table_width(&table) <= width {
        return table;
    }
    wrap_texts(&mut table, TEXT_CELL_WIDTHS[0]);
    let all = table.columns.clone();
    while table_width(&table) > width {
        let Some(column) = omissible_column(&table) else {
            break;
        };
        omit_column(&mut table, column);
    }
    for cell_width in &TEXT_CELL_WIDTHS[1..] {
        if table_width(&table) > width {
            wrap_texts(&mut table, *cell_width);
        }
    }
    let omitted = omitted_columns(&all, &table.columns);
    let note = omitted.map(|omitted| format!("{omitted}: --full."));
    table.footnotes.extend(note);
    table
}

/// Number and names of the columns that are not kept: `2 further columns (std (Hz), MAC)`.
pub(in crate::report) fn omitted_columns(all: &[Column], kept: &[Column]) -> Option<String> {
    let mut kept = kept.iter().peekable();
    let is_omitted = |column: &&Column| kept.next_if(|kept| *kept == *column).is_none();
    let omitted = all.iter().filter(is_omitted);
    let name = |column: &Column| column.head.replace("-\n", "").replace('\n', " ");
    let mut omitted: Vec<String> = omitted.map(name).collect();
    let further = counted(omitted.len(), "further column");
    let more = match omitted.len() > MAX_NAMED_COLUMNS {
        true => ", ...",
        false => "",
    };
    omitted.truncate(MAX_NAMED_COLUMNS);
    let names = omitted.join(", ");
    (!omitted.is_empty()).then(|| format!("{further} ({names}{more})"))
}

fn wrap_texts(table: &mut Table, cell_width: usize) {
    for cell in table.rows.iter_mut().flatten() {
        if let Cell::Text(text) = cell {
            *text = textwrap::fill(text, wrapping(cell_width));
        }
    }
}

/// The next column to omit: of columns in percent, but not the first of the table, that with the
/// smallest largest magnitude; else the last column of numbers.
pub(in crate::report) fn omissible_column(table: &Table) -> Option<usize> {
    let numbers = (1..table.columns.len())
        .filter(|column| table.columns[*column].align == Align::Right)
        .collect::<Vec<usize>>();
    let percent = numbers
        .iter()
        .copied()
        .filter(|column| table.columns[*column].head.ends_with("(%)"));
    let percent: Vec<usize> = percent.collect();
    if percent.len() + 1 < numbers.len() || percent.len() < 3 {
        return numbers.last().copied();
    }
    let largest = |column: usize| {
        let cells = table.rows.iter().map(|row| &row[column]);
        let values = cells.filter_map(|cell| match cell {
            Cell::Number { value, .. } => Some(value.abs()),
            _ => None,
        });
        values.fold(0.0, f64::max)
    };
    percent.into_iter().min_by(|&i, &j| {
        let by_magnitude = largest(i).total_cmp(&largest(j));
        by_magnitude.then(j.cmp(&i))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: usize, columns: usize) -> Table {
        let cell = |row: usize, column: usize| Cell::number(Some((row + 10 * column) as f64), 1);
        Table {
            caption: format!("{rows} by {columns}"),
            columns: (0..columns)
                .map(|c| Column::number(format!("column {c} (%)")))
                .collect(),
            rows: (0..rows)
                .map(|r| (0..columns).map(|c| cell(r, c)).collect())
                .collect(),
            footnotes: (1..=4).map(|n| format!("Note {n}.")).collect(),
        }
    }

    #[test]
    fn a_screen_has_its_lines_and_width_and_says_what_it_omits() {
        let tables = [table(100, 3), table(5, 40), table(8, 2)];
        let blocks = abridged(tables.into_iter().map(Block::Table).collect(), 80);
        let text = Terminal { width: Some(80) }.render(&blocks);
        assert!(text.lines().count() <= MAX_LINES + 2, "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        for said in [
            "further rows: --full.",
            "2 further notes: --full.",
            "8 by 2",
        ] {
            assert!(text.contains(said), "{said}: {text}");
        }
    }

    #[test]
    fn shares_of_a_single_body_are_a_sentence() {
        let mut shares = table(2, 2);
        shares.rows = vec![vec![Cell::text("f1"), Cell::number(Some(100.0), 3)]];
        let text = without_whole_shares(Block::Table(shares.clone()));
        let expected = "2 by 2: 100 % in every mode: column 1.";
        assert_eq!(text, Block::Text(expected.to_owned()));
        shares.rows[0][1] = Cell::number(Some(99.0), 3);
        let block = Block::Table(shares);
        assert_eq!(without_whole_shares(block.clone()), block);
    }

    #[test]
    fn every_requested_table_has_room() {
        let tables = [table(60, 3), table(60, 3)].map(Block::Table);
        let shown = abridged(tables.to_vec(), 100);
        let is_table = |block: &&Block| matches!(block, Block::Table(_));
        assert_eq!(shown.iter().filter(is_table).count(), 2, "{shown:?}");
    }

    #[test]
    fn tables_without_a_value_are_counted() {
        let empty = Table {
            rows: vec![vec![Cell::text("1"), Cell::Missing]],
            ..table(1, 2)
        };
        let no_rows = table(0, 2);
        let tables = [empty, table(2, 2), no_rows];
        let shown = tables_with_values(tables.into_iter().map(Block::Table).collect());
        assert_eq!(shown.len(), 2);
        assert_eq!(shown[0], Block::Table(table(2, 2)));
        let text = "Without a value: 2 tables (--full).";
        assert_eq!(shown[1], Block::Text(text.to_owned()));
    }

    #[test]
    fn columns_with_the_smallest_numbers_are_omitted() {
        let Block::Table(shown) = &abridged(vec![Block::Table(table(5, 12))], 60)[0] else {
            panic!("a table stays one");
        };
        let heads: Vec<&str> = shown.columns.iter().map(|c| c.head.as_str()).collect();
        assert_eq!(heads[0], "column 0 (%)");
        assert_eq!(heads.last(), Some(&"column 11 (%)"));
        assert!(
            shown
                .footnotes
                .iter()
                .any(|note| note.contains("further columns (column 1 (%), "))
        );
    }

    #[test]
    fn a_table_that_fits_is_unchanged() {
        let mut small = table(3, 3);
        small.footnotes.truncate(2);
        let blocks = vec![Block::Table(small)];
        assert_eq!(abridged(blocks.clone(), 80), blocks);
    }
}
