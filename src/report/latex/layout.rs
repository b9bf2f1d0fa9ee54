//! The layout of a table chooses its size of type, the lines of its heads, the widths of its texts
//! and the columns that fit a page.

use crate::report::screen::{omissible_column, omit_column, omitted_columns};
use crate::report::{Align, Column, Table};

use super::characters::{pieces, width_em};

/// Space between two columns, em.
pub(super) const COLUMN_GAP_EM: f64 = 0.7;
/// Heads are not wrapped to less than this width where there is room, em.
const HEAD_WIDTH_EM: f64 = 5.0;
/// Texts are not wrapped to less than this width, em.
const MIN_TEXT_WIDTH_EM: f64 = 5.5;

/// A size of type and what is wrapped in it.
struct Setting {
    size: &'static str,
    /// Width of the text of a page in this size, em: the smallest of the classes `article` with 10,
    /// 11 and 12 pt on A4. A larger number makes tables wider than such a page.
    page_width_em: f64,
    wraps_heads: bool,
    wraps_texts: bool,
}

/// From the most legible to the narrowest.
const SETTINGS: [Setting; 4] = [
    Setting {
        size: "\\small",
        page_width_em: 35.4,
        wraps_heads: false,
        wraps_texts: false,
    },
    Setting {
        size: "\\footnotesize",
        page_width_em: 38.4,
        wraps_heads: true,
        wraps_texts: false,
    },
    Setting {
        size: "\\footnotesize",
        page_width_em: 38.4,
        wraps_heads: true,
        wraps_texts: true,
    },
    Setting {
        size: "\\scriptsize",
        page_width_em: 42.0,
        wraps_heads: true,
        wraps_texts: true,
    },
];

/// A column of a table on a page.
pub(super) struct ColumnLayout {
    /// Alignment.
    pub align: Align,
    /// Width, em.
    pub width_em: f64,
    /// Whether its texts are wrapped to this width.
    pub is_wrapped: bool,
    /// Lines of its head.
    pub head: Vec<String>,
}

/// Columns that follow each other, with a common head above them.
pub(super) struct HeadGroup {
    /// Index of the first.
    pub first: usize,
    /// Number of columns.
    pub count: usize,
    /// The common head in lines; empty for a column alone.
    pub lines: Vec<String>,
}

/// A table on a page.
pub(super) struct Layout {
    /// Command of the size of type.
    pub size: &'static str,
    /// The columns.
    pub columns: Vec<ColumnLayout>,
    /// All columns in groups.
    pub groups: Vec<HeadGroup>,
}

/// The table with the columns that fit a page, and its layout. A note says which columns are
/// omitted.
pub(super) fn fitted(mut table: Table) -> (Table, Layout) {
    let all = table.columns.clone();
    loop {
        let mut layouts = SETTINGS.iter().map(|setting| layout(&table, setting));
        let fitting = layouts.find_map(|(layout, fits)| fits.then_some(layout));
        let next = next_omitted(&table);
        match (fitting, next) {
            (None, Some(index)) => omit_column(&mut table, index),
            (fitting, _) => {
                let columns = omitted_columns(&all, &table.columns);
                let note = columns.map(|columns| format!("{columns}: in the other formats."));
                table.footnotes.extend(note);
                let narrowest = || layout(&table, &SETTINGS[SETTINGS.len() - 1]).0;
                let layout = fitting.unwrap_or_else(narrowest);
                return (table, layout);
            }
        }
    }
}

/// The next column to omit: the last of several long texts, or of three or more texts with a long
/// one; then, as on a screen, columns of numbers; then the last column of text.
fn next_omitted(table: &Table) -> Option<usize> {
    let is_text = |index: &usize| table.columns[*index].align == Align::Left;
    let is_long = |index: &&usize| {
        texts(table, **index).any(|text| width_em(text.trim_end()) > MIN_TEXT_WIDTH_EM)
    };
    let of_text: Vec<usize> = (1..table.columns.len()).filter(is_text).collect();
    let long_count = of_text.iter().filter(is_long).count();
    let last = of_text.last().copied();
    if long_count >= 2 || long_count == 1 && of_text.len() >= 3 {
        return last;
    }
    omissible_column(table).or(last)
}

/// The layout in a setting, and whether it fits the page.
fn layout(table: &Table, setting: &Setting) -> (Layout, bool) {
    let groups = head_groups(&table.columns);
    let mut columns: Vec<ColumnLayout> = Vec::new();
    for group in &groups {
        for (index, column) in table.columns.iter().enumerate() {
            if (group.first..group.first + group.count).contains(&index) {
                let head = match group.lines.is_empty() {
                    true => column.head.as_str(),
                    false => split_head(&column.head).map_or("", |(_, last)| last),
                };
                columns.push(column_layout(table, index, head, setting));
            }
        }
    }
    if setting.wraps_texts {
        wrap_texts(table, &mut columns, setting.page_width_em);
    }
    let groups = groups.into_iter().map(|group| {
        let of_group = &mut columns[group.first..group.first + group.count];
        let span = total_width(of_group);
        let widest = group.lines.iter().flat_map(|line| pieces(line));
        let widest = widest.map(width_em).fold(0.0, f64::max);
        if let Some(last) = of_group.last_mut() {
            last.width_em += (widest - span).max(0.0);
        }
        let lines = group.lines.iter();
        let lines = lines.flat_map(|line| wrapped(line, span.max(widest)));
        HeadGroup {
            lines: lines.collect(),
            ..group
        }
    });
    let groups = groups.collect();
    let fits = total_width(&columns) <= setting.page_width_em;
    let layout = Layout {
        size: setting.size,
        columns,
        groups,
    };
    (layout, fits)
}

fn total_width(columns: &[ColumnLayout]) -> f64 {
    let widths = columns.iter().map(|column| column.width_em);
    widths.sum::<f64>() + COLUMN_GAP_EM * columns.len().saturating_sub(1) as f64
}

/// The texts of a column.
fn texts(table: &Table, index: usize) -> impl Iterator<Item = String> {
    let cells = table.rows.iter().map(move |row| row[index].display());
    cells.map(|text| text.replace('\n', " "))
}

fn column_layout(table: &Table, index: usize, head: &str, setting: &Setting) -> ColumnLayout {
    let body = texts(table, index).map(|text| width_em(text.trim_end()));
    let body = body.fold(0.0, f64::max);
    let lines = head.lines().flat_map(|line| {
        let widest = pieces(line).into_iter().map(width_em).fold(0.0, f64::max);
        let least = if setting.wraps_heads {
            0.0
        } else {
            HEAD_WIDTH_EM
        };
        wrapped(line, body.max(widest).max(least))
    });
    let head: Vec<String> = lines.collect();
    let head_width = head.iter().map(|line| width_em(line)).fold(0.0, f64::max);
    ColumnLayout {
        align: table.columns[index].align,
        width_em: body.max(head_width),
        is_wrapped: false,
        head,
    }
}

/// Gives the columns of long texts the width that the others leave: the same for all that need as
/// much.
fn wrap_texts(table: &Table, columns: &mut [ColumnLayout], page_width_em: f64) {
    let least: Vec<f64> = (0..columns.len())
        .map(|index| {
            let column = &columns[index];
            if column.align == Align::Right {
                return column.width_em;
            }
            let texts: Vec<String> = texts(table, index).collect();
            let all = texts.iter().flat_map(|text| pieces(text));
            let all = all.chain(column.head.iter().map(String::as_str));
            let widest = all.map(width_em).fold(0.0, f64::max);
            widest.max(MIN_TEXT_WIDTH_EM).min(column.width_em)
        })
        .collect();
    let gaps = COLUMN_GAP_EM * columns.len().saturating_sub(1) as f64;
    let of_level = |level: f64| -> Vec<f64> {
        let widths = columns.iter().zip(&least);
        widths
            .map(|(column, least)| column.width_em.min(level).max(*least))
            .collect()
    };
    let (mut low, mut high) = (0.0, page_width_em);
    for _ in 0..40 {
        let middle = f64::midpoint(low, high);
        match of_level(middle).iter().sum::<f64>() + gaps <= page_width_em {
            true => low = middle,
            false => high = middle,
        }
    }
    let widths = of_level(low);
    for (column, width) in columns.iter_mut().zip(widths) {
        column.is_wrapped = width < column.width_em;
        column.width_em = width;
    }
}

/// A line in lines of at most this width, where its pieces allow that.
fn wrapped(line: &str, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    for word in line.split(' ') {
        for (number, piece) in pieces(word).into_iter().enumerate() {
            let last = lines.last_mut().expect("there is a line");
            let gap = if number == 0 && !last.is_empty() {
                " "
            } else {
                ""
            };
            let joined = format!("{last}{gap}{piece}");
            if last.is_empty() || width_em(&joined) <= width {
                *last = joined;
            } else {
                lines.push(piece.to_owned());
            }
        }
    }
    lines
}

/// Number of lines of a text in a column of this width.
pub(super) fn line_count(text: &str, width: f64) -> usize {
    text.lines()
        .map(|line| wrapped(line, width).len())
        .sum::<usize>()
        .max(1)
}

/// The common part of a head, the name of a test before a colon or the last line, and the other.
fn split_head(head: &str) -> Option<(&str, &str)> {
    head.rsplit_once('\n').or_else(|| head.split_once(": "))
}

/// Columns that follow each other and have a common part of their heads.
fn head_groups(columns: &[Column]) -> Vec<HeadGroup> {
    let common = |column: &Column| split_head(&column.head).map(|(common, _)| common.to_owned());
    let mut groups: Vec<HeadGroup> = Vec::new();
    let mut first = 0;
    while let Some(column) = columns.get(first) {
        let name = common(column);
        let same = columns[first..]
            .iter()
            .take_while(|column| name.is_some() && common(column) == name);
        let count = same.count().max(1);
        let lines = name.filter(|_| count > 1);
        groups.push(HeadGroup {
            first,
            count,
            lines: lines.map_or_else(Vec::new, |name| {
                let lines: Vec<&str> = name.lines().collect();
                vec![lines.join(" ")]
            }),
        });
        first += count;
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Cell;

    /// A table of texts of this length and of numbers.
    fn table(texts: usize, length: usize, numbers: usize) -> Table {
        let text = "word ".repeat(length / 5);
        let mut columns = vec![Column::text("mode")];
        columns.extend((0..numbers).map(|n| Column::number(format!("number {n}"))));
        columns.extend((0..texts).map(|n| Column::text(format!("text {n}"))));
        let mut row = vec![Cell::text("f1")];
        row.extend((0..numbers).map(|_| Cell::number(Some(142_414.893), 3)));
        row.extend((0..texts).map(|_| Cell::text(text.trim_end())));
        Table {
            columns,
            rows: vec![row],
            ..Table::default()
        }
    }

    fn page_width(size: &str) -> f64 {
        let setting = SETTINGS.iter().find(|setting| setting.size == size);
        setting.expect("the size of a setting").page_width_em
    }

    #[test]
    fn every_table_fits_the_page() {
        for (texts, length, numbers) in [
            (0, 0, 3),
            (0, 0, 30),
            (1, 200, 4),
            (4, 60, 0),
            (4, 60, 8),
            (20, 10, 0),
        ] {
            let (fitted, layout) = fitted(table(texts, length, numbers));
            let width = total_width(&layout.columns);
            let message = format!("{texts} of {length}, {numbers}: {width} in {}", layout.size);
            assert!(width <= page_width(layout.size), "{message}");
            assert_eq!(layout.columns.len(), fitted.columns.len(), "{message}");
        }
    }

    #[test]
    fn type_is_smaller_before_columns_are_omitted() {
        let sizes = [3, 7].map(|numbers| {
            let (fitted, layout) = fitted(table(0, 0, numbers));
            assert_eq!(fitted.columns.len(), numbers + 1);
            layout.size
        });
        assert_eq!(sizes[0], "\\small");
        assert_eq!(sizes[1], "\\scriptsize");
    }

    #[test]
    fn of_several_long_texts_the_last_is_omitted_before_numbers() {
        let (fitted, _) = fitted(table(4, 60, 4));
        let heads: Vec<&str> = fitted.columns.iter().map(|c| c.head.as_str()).collect();
        assert!(heads.contains(&"number 3"), "{heads:?}");
        assert!(!heads.contains(&"text 3"), "{heads:?}");
        assert!(fitted.footnotes[0].contains("text 3): in the other formats."));
    }

    #[test]
    fn a_verdict_is_kept_beside_a_unit() {
        let mut table = table(2, 60, 10);
        let unit = table.columns.len() - 2;
        table.rows[0][unit] = Cell::text("N/m");
        let (fitted, _) = fitted(table);
        let heads: Vec<&str> = fitted.columns.iter().map(|c| c.head.as_str()).collect();
        assert_eq!(heads.last(), Some(&"text 1"), "{heads:?}");
    }

    #[test]
    fn a_head_is_wrapped_before_its_column_is_wider_than_its_values() {
        let lines = wrapped("(test−theory)/theory (%)", 7.0);
        assert_eq!(lines, ["(test−theory)/", "theory (%)"]);
        assert_eq!(wrapped("MAC", 0.1), ["MAC"]);
    }
}
