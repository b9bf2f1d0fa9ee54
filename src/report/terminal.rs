//! The terminal renderer writes plain text with aligned columns, whose paragraphs may be wrapped at
//! the width of the terminal.

use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

use crate::printable::{printable, printable_message};

use super::{Align, Block, Column, Renderer, Table};

/// Renders for a terminal, without colour.
pub struct Terminal {
    /// Characters in a line of a paragraph; `None` for one line each. Tables are as wide as their
    /// columns.
    pub width: Option<usize>,
}

impl Renderer for Terminal {
    fn name(&self) -> &'static str {
        "terminal"
    }

    fn extension(&self) -> &'static str {
        "txt"
    }

    fn render(&self, blocks: &[Block]) -> String {
        let parts: Vec<String> = blocks
            .iter()
            .map(|block| self.block_text(block))
            .filter(|text| !text.is_empty())
            .collect();
        printable(&parts.join("\n\n")).into_owned() + "\n"
    }
}

impl Terminal {
    fn block_text(&self, block: &Block) -> String {
        match block {
            Block::Heading(text) => {
                let text = self.wrapped(text);
                let width = text.lines().map(UnicodeWidthStr::width).max();
                format!("{text}\n{}", "=".repeat(width.unwrap_or(0)))
            }
            Block::Text(text) => self.wrapped(text),
            Block::Table(table) => self.table_text(table),
            Block::Findings { findings, language } => findings
                .iter()
                .map(|finding| {
                    let severity = language.severity(finding.severity);
                    let sentence = language.finding(finding);
                    let line = format!("{severity}: {sentence} [{}]", finding.code.name());
                    self.wrapped(&line)
                })
                .collect::<Vec<_>>()
                .join("\n"),
        }
    }

    fn wrapped(&self, text: &str) -> String {
        let text = printable_message(text);
        let Some(width) = self.width else {
            return text.into_owned();
        };
        // Continuation lines of an indented line are indented twice as far.
        let line = |line: &str| {
            let indented = line.len() - line.trim_start_matches(' ').len();
            let indent = " ".repeat(2 * indented);
            textwrap::fill(line, wrapping(width).subsequent_indent(&indent))
        };
        text.split('\n').map(line).collect::<Vec<_>>().join("\n")
    }

    fn table_text(&self, table: &Table) -> String {
        let grid = grid_lines(table);
        let width = grid.lines().map(UnicodeWidthStr::width).max().unwrap_or(0);
        let rule = "-".repeat(width);
        let head_lines = head_line_count(table);
        let caption = self.wrapped(&table.caption);
        let mut lines: Vec<&str> = Vec::new();
        if !caption.is_empty() {
            lines.push(&caption);
        }
        lines.push(&rule);
        lines.extend(grid.lines().take(head_lines));
        lines.push(&rule);
        lines.extend(grid.lines().skip(head_lines));
        lines.push(&rule);
        let mut text = lines.join("\n");
        for note in &table.footnotes {
            text += &format!("\n{}", self.wrapped(note));
        }
        text
    }
}

/// Words, such as paths, commands and codes, stay whole, even where they are longer than a line,
/// and numbers with their units.
pub(crate) fn wrapping(width: usize) -> textwrap::Options<'static> {
    textwrap::Options::new(width)
        .break_words(false)
        .word_separator(textwrap::WordSeparator::Custom(whole_words))
        .word_splitter(textwrap::WordSplitter::NoHyphenation)
}

/// Units that follow a number behind a blank.
const UNITS: [&str; 16] = [
    "%", "Hz", "kHz", "dB", "kg", "g", "N", "m", "mm", "s", "ms", "rad", "rad/s", "Pa", "°C", "MiB",
];

/// The words of a line, as they are broken at blanks and beside wide characters, such as Chinese
/// ones; a number and its unit are one word.
fn whole_words(line: &str) -> Box<dyn Iterator<Item = textwrap::core::Word<'_>> + '_> {
    let mut starts = vec![0];
    let breaks = line.char_indices().map(|(at, _)| at).skip(1);
    starts.extend(breaks.filter(|at| may_break(line, *at)));
    let ends: Vec<usize> = starts.iter().copied().skip(1).chain([line.len()]).collect();
    let words = starts.into_iter().zip(ends);
    Box::new(words.map(|(start, end)| textwrap::core::Word::from(&line[start..end])))
}

fn is_wide(c: char) -> bool {
    c.width().unwrap_or(0) > 1
}

/// Whether a line may end at this byte: behind blanks and beside wide characters, but neither
/// between a number and its unit nor before a closing mark.
fn may_break(line: &str, at: usize) -> bool {
    let (before, after) = line.split_at(at);
    let (Some(last), Some(first)) = (before.chars().last(), after.chars().next()) else {
        return false;
    };
    if first.is_whitespace() || "，。；：、）”".contains(first) || "（“".contains(last) {
        return false;
    }
    if !last.is_whitespace() {
        return is_wide(last) || is_wide(first);
    }
    let is_number = before.trim_end().ends_with(|c: char| c.is_ascii_digit());
    let next = after
        .split(|c: char| c.is_whitespace() || is_wide(c))
        .next();
    let unit = next.unwrap_or_default();
    let unit = unit.trim_end_matches([',', ';', ':', '.', ')', '?', '!']);
    !(is_number && (UNITS.contains(&unit) || is_wide(first)))
}

/// Characters in the widest line of a table.
pub(super) fn table_width(table: &Table) -> usize {
    let grid = grid_lines(table);
    grid.lines().map(UnicodeWidthStr::width).max().unwrap_or(0)
}

fn head_line_count(table: &Table) -> usize {
    let heads = table.columns.iter();
    let lines = heads.map(|column| column.head.lines().count()).max();
    lines.unwrap_or(0).max(1)
}

/// The lines of heads and rows, with aligned columns.
fn grid_lines(table: &Table) -> String {
    let head: Vec<&str> = table.columns.iter().map(|c| c.head.as_str()).collect();
    let rows: Vec<Vec<String>> = table
        .rows
        .iter()
        .map(|row| row.iter().map(|cell| cell.display()).collect())
        .collect();
    let widths = widths(&head, &rows);
    let mut lines = Vec::new();
    push_row(&mut lines, &head, &table.columns, &widths);
    for row in &rows {
        push_row(&mut lines, row, &table.columns, &widths);
    }
    lines.join("\n")
}

/// Width of each column on a screen.
fn widths(head: &[&str], rows: &[Vec<String>]) -> Vec<usize> {
    let widest = |text: &str| text.lines().map(UnicodeWidthStr::width).max().unwrap_or(0);
    let mut widths: Vec<usize> = head.iter().map(|text| widest(text)).collect();
    for row in rows {
        for (width, text) in widths.iter_mut().zip(row) {
            *width = (*width).max(widest(text));
        }
    }
    widths
}

/// Adds the lines of one row, whose cells may have several.
fn push_row<T: AsRef<str>>(
    lines: &mut Vec<String>,
    cells: &[T],
    columns: &[Column],
    widths: &[usize],
) {
    let count = cells.iter().map(|cell| cell.as_ref().lines().count());
    for number in 0..count.max().unwrap_or(0).max(1) {
        let mut line = String::new();
        for ((cell, column), width) in cells.iter().zip(columns).zip(widths) {
            let text = cell.as_ref().lines().nth(number).unwrap_or_default();
            let missing = " ".repeat(width - text.width());
            line += " ";
            match column.align {
                Align::Right => line.extend([&missing, text]),
                Align::Left => line.extend([text, &missing]),
            }
            line += " ";
        }
        line.truncate(line.trim_end().len());
        lines.push(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_file_names_and_numbers_with_units_stay_whole() {
        let text = "at -0.60 % of f1 in a-long/file-name.uff: 4.319 %, 12 Hz [near-band-edge] 28、4 个不可观测";
        for width in 10..60 {
            let printed = Terminal { width: Some(width) }.render(&[Block::Text(text.to_owned())]);
            for whole in [
                "-0.60 %",
                "a-long/file-name.uff:",
                "4.319 %,",
                "12 Hz",
                "[near-band-edge]",
                "4 个",
            ] {
                let is_whole = printed.lines().any(|line| line.contains(whole));
                assert!(is_whole, "{whole} at {width}:\n{printed}");
            }
        }
    }

    #[test]
    fn a_path_longer_than_the_line_stays_whole() {
        let path = "measurements/a-machine-with-a-name/of-more-than-twenty-characters";
        let text = format!("Then: modalign run {path} prints the modes.");
        let printed = Terminal { width: Some(20) }.render(&[Block::Text(text)]);
        assert!(printed.lines().any(|line| line.contains(path)), "{printed}");
    }
}
