//! The LaTeX renderer writes tables with `booktabs` rules that fit the page of a paper.
//!
//! A table that is too wide is set in smaller type, its texts are wrapped, and then columns are
//! omitted in the order of the screen. A table that is longer than a page is a `longtable`.

mod characters;
mod layout;

use super::{Align, Block, Language, Renderer, Table};

use characters::{escaped, escaped_paragraph, is_set_by_pdflatex};
use layout::{COLUMN_GAP_EM, ColumnLayout, Layout, fitted, line_count};

/// Renders LaTeX. The document needs `\usepackage{array,booktabs,longtable}`.
pub struct Latex;

/// Lines of a table with its caption and notes that fit a page; more lines make a `longtable`. With
/// more, a table runs off a page of 12 pt; with fewer, tables break that need not.
const MAX_LINES: usize = 42;
/// Width of a line of notes, em.
const NOTE_WIDTH_EM: f64 = 38.0;

impl Renderer for Latex {
    fn name(&self) -> &'static str {
        "latex"
    }

    fn extension(&self) -> &'static str {
        "tex"
    }

    fn render(&self, blocks: &[Block]) -> String {
        let parts: Vec<String> = blocks
            .iter()
            .map(block_text)
            .filter(|text| !text.is_empty())
            .collect();
        let text = parts.join("\n\n") + "\n";
        let head = "% \\usepackage{array,booktabs,longtable}\n";
        if text.chars().all(is_set_by_pdflatex) {
            format!("{head}{text}")
        } else if blocks.iter().any(is_chinese) {
            format!("{head}% Chinese text: XeLaTeX or LuaLaTeX, \\usepackage{{ctex}}\n{text}")
        } else {
            format!("{head}{UNICODE_COMMAND}{}", with_unicode_commands(&text))
        }
    }
}

/// The command of a character that pdflatex lacks, by its number: the character where the font has
/// it, else the number.
const UNICODE_COMMAND: &str = "% pdflatex prints the numbers of characters that it lacks; XeLaTeX and LuaLaTeX print them.\n\
     \\providecommand{\\unicodechar}[1]{\\ifdefined\\Umathcode\\char\"#1\\relax\\else\\texttt{U+#1}\\fi}\n";

/// A title in another language must not keep a document from pdflatex.
fn with_unicode_commands(text: &str) -> String {
    let mut written = String::with_capacity(text.len());
    for c in text.chars() {
        match is_set_by_pdflatex(c) {
            true => written.push(c),
            false => written += &format!("\\unicodechar{{{:04X}}}", u32::from(c)),
        }
    }
    written
}

/// Whether most heads of a table, which are the program's, are Chinese.
fn is_chinese(block: &Block) -> bool {
    let is_chinese = |text: &str| text.contains(|c| ('\u{4e00}'..='\u{9fff}').contains(&c));
    match block {
        Block::Heading(_) | Block::Text(_) => false,
        Block::Table(table) => {
            let heads = table
                .columns
                .iter()
                .filter(|column| is_chinese(&column.head));
            2 * heads.count() > table.columns.len()
        }
        Block::Findings { language, .. } => *language == Language::Chinese,
    }
}

fn block_text(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("\\section*{{\\raggedright {}}}", escaped_paragraph(text)),
        Block::Text(text) => format!("{{\\raggedright {}\\par}}", escaped_paragraph(text)),
        Block::Table(table) => table_text(table),
        Block::Findings { findings, .. } if findings.is_empty() => String::new(),
        Block::Findings { findings, language } => {
            let items: Vec<String> = findings
                .iter()
                .map(|f| format!("  \\item {}", escaped_paragraph(&language.finding(f))))
                .collect();
            format!(
                "\\begin{{itemize}}\\raggedright\n{}\n\\end{{itemize}}",
                items.join("\n")
            )
        }
    }
}

fn table_text(table: &Table) -> String {
    let (table, layout) = fitted(with_short_heads(table.without_missing_columns()));
    let caption = match table.caption.is_empty() {
        true => String::new(),
        false => format!("\\caption{{{}}}", escaped_paragraph(&table.caption)),
    };
    let columns = column_commands(&layout);
    let gap = format!("\\setlength{{\\tabcolsep}}{{{:.2}em}}", COLUMN_GAP_EM / 2.0);
    let size = layout.size;
    let heads = head_rows(&layout).join("\n");
    let rows: Vec<String> = table
        .rows
        .iter()
        .map(|fields| {
            let cells = fields.iter().zip(&layout.columns);
            row(cells.map(|(cell, column)| cell_text(&cell.display(), column.is_wrapped)))
        })
        .collect();
    let rows = match has_wrapped_texts(&layout) {
        true => rows.join("\n  \\addlinespace\n"),
        false => rows.join("\n"),
    };
    let notes = notes(&table.footnotes);
    if height(&table, &layout) <= MAX_LINES {
        let lines = [
            "\\begin{table}[htbp]",
            "  \\centering",
            &format!("  {caption}\\smallskip"),
            &format!("  {size}{gap}"),
            &format!("  \\begin{{tabular}}{{{columns}}}"),
            "  \\toprule",
            &heads,
            "  \\midrule",
            &rows,
            "  \\bottomrule",
            "  \\end{tabular}",
            &notes,
            "\\end{table}",
        ];
        return joined(&lines);
    }
    let caption = match caption.is_empty() {
        true => caption,
        false => format!("{caption} \\\\"),
    };
    joined(&[
        &format!("{{{size}{gap}"),
        &format!("\\begin{{longtable}}{{{columns}}}"),
        &format!("  {caption}"),
        "  \\toprule",
        &heads,
        "  \\midrule",
        "  \\endfirsthead",
        "  \\toprule",
        &heads,
        "  \\midrule",
        "  \\endhead",
        "  \\bottomrule",
        "  \\endfoot",
        &rows,
        "\\end{longtable}",
        &notes,
        "}",
    ])
}

/// Heads of errors in the tables of other formats, and the note that defines them here.
const ERROR_HEADS: [(&str, &str); 2] = [
    (
        "(test−theory)/theory (%)",
        "Error = (test - theory)/theory.",
    ),
    ("(theory−test)/test (%)", "Error = (theory - test)/test."),
];

/// The table with the definition of its errors in a note instead of its heads.
fn with_short_heads(mut table: Table) -> Table {
    for (long, note) in ERROR_HEADS {
        let mut is_defined = table.footnotes.iter().any(|text| text.contains(note));
        for column in &mut table.columns {
            if let Some(name) = column.head.strip_suffix(long) {
                column.head = format!("{name}error (%)");
                if !is_defined {
                    table.footnotes.push(note.to_owned());
                    is_defined = true;
                }
            }
        }
    }
    table
}

fn has_wrapped_texts(layout: &Layout) -> bool {
    layout.columns.iter().any(|column| column.is_wrapped)
}

fn joined(lines: &[&str]) -> String {
    let lines: Vec<&str> = lines
        .iter()
        .copied()
        .filter(|line| !line.trim().is_empty())
        .collect();
    lines.join("\n")
}

/// Lines of a table with its caption, heads and notes.
fn height(table: &Table, layout: &Layout) -> usize {
    let rows = table.rows.iter().map(|row| {
        let cells = row.iter().zip(&layout.columns);
        let lines = cells.map(|(cell, column)| match column.is_wrapped {
            true => line_count(&cell.display(), column.width_em),
            false => 1,
        });
        lines.max().unwrap_or(1)
    });
    let notes = table.footnotes.iter();
    let notes = notes.map(|note| line_count(note, NOTE_WIDTH_EM));
    // The space between rows of several lines is about half a line.
    let spaces = usize::from(has_wrapped_texts(layout)) * table.rows.len() / 2;
    rows.sum::<usize>() + spaces + notes.sum::<usize>() + head_rows(layout).len() + 3
}

fn column_commands(layout: &Layout) -> String {
    let command = |column: &ColumnLayout| match (column.is_wrapped, column.align) {
        (true, _) => format!(
            ">{{\\raggedright\\arraybackslash}}p{{{:.2}em}}",
            column.width_em
        ),
        (false, Align::Left) => "l".to_owned(),
        (false, Align::Right) => "r".to_owned(),
    };
    let columns: Vec<String> = layout.columns.iter().map(command).collect();
    format!("@{{}}{}@{{}}", columns.concat())
}

fn row(fields: impl Iterator<Item = String>) -> String {
    format!("  {} \\\\", fields.collect::<Vec<_>>().join(" & "))
}

/// The text of a cell; blanks at its end, which align the marks of a column, as room.
fn cell_text(text: &str, is_wrapped: bool) -> String {
    let kept = text.trim_end_matches(' ');
    let blanks = text.len() - kept.len();
    let room = match blanks {
        0 => String::new(),
        _ => format!("\\hphantom{{{}}}", "?".repeat(blanks)),
    };
    // A bracket after the end of a row would be its option.
    let bracket = if kept.starts_with(['[', '*']) {
        "{}"
    } else {
        ""
    };
    let kept = match is_wrapped {
        true => escaped_paragraph(kept),
        false => escaped(kept),
    };
    format!("{bracket}{kept}{room}")
}

/// The rows of the heads, those of groups first; the last line of every head is in the last row.
fn head_rows(layout: &Layout) -> Vec<String> {
    let mut rows = Vec::new();
    let group_lines = layout.groups.iter().map(|group| group.lines.len()).max();
    let group_lines = group_lines.unwrap_or(0);
    for number in 0..group_lines {
        let cells = layout.groups.iter().map(|group| {
            let text = line_from_below(&group.lines, group_lines, number);
            match group.lines.is_empty() {
                true => vec![String::new(); group.count].join(" & "),
                false => format!("\\multicolumn{{{}}}{{c}}{{{text}}}", group.count),
            }
        });
        rows.push(row(cells));
    }
    if group_lines > 0 {
        let named = layout.groups.iter().filter(|group| !group.lines.is_empty());
        let rules = named.map(|group| {
            let (first, last) = (group.first + 1, group.first + group.count);
            format!("\\cmidrule(lr){{{first}-{last}}}")
        });
        rows.push(format!("  {}", rules.collect::<Vec<_>>().concat()));
    }
    let lines = layout.columns.iter().map(|column| column.head.len()).max();
    let lines = lines.unwrap_or(0);
    for number in 0..lines {
        let cells = layout
            .columns
            .iter()
            .map(|column| line_from_below(&column.head, lines, number));
        rows.push(row(cells));
    }
    rows
}

/// A line of a head of which the last line is the last of all.
fn line_from_below(lines: &[String], all: usize, number: usize) -> String {
    let index = (number + lines.len()).checked_sub(all);
    let line = index.and_then(|index| lines.get(index));
    line.map_or_else(String::new, |line| cell_text(line, false))
}

fn notes(footnotes: &[String]) -> String {
    if footnotes.is_empty() {
        return String::new();
    }
    let notes = footnotes
        .iter()
        .map(|note| escaped_paragraph(note) + "\\par");
    let notes: Vec<String> = notes.collect();
    format!(
        "  \\par\\smallskip\n  {{\\footnotesize\\raggedright\n  {}}}",
        notes.join("\n  ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Cell, Column};

    /// A table of one column of text and columns of numbers with these heads.
    fn table(heads: &[&str], rows: usize) -> Table {
        let mut columns = vec![Column::text("mode")];
        columns.extend(heads.iter().map(|head| Column::number(*head)));
        let row = |number: usize| {
            let numbers = heads.iter().map(|_| Cell::number(Some(-1234.567), 3));
            std::iter::once(Cell::text(format!("f{number}")))
                .chain(numbers)
                .collect()
        };
        Table {
            caption: "Modes".to_owned(),
            columns,
            rows: (1..=rows).map(row).collect(),
            ..Table::default()
        }
    }

    fn rendered(table: Table) -> String {
        Latex.render(&[Block::Table(table)])
    }

    /// Lines of a text that contain this.
    fn count(text: &str, part: &str) -> usize {
        text.lines().filter(|line| line.contains(part)).count()
    }

    #[test]
    fn pdflatex_sets_all_characters_of_tables() {
        let text =
            "½ arg Σφ² ψᴴMψ |λ|/2π, Δt ≤ 10⁻³ s, ω₁ ± 2σ, µm, 5 °, √2 × 3 → ∞ … – — − \u{a0}é";
        let written = Latex.render(&[Block::Text(text.to_owned())]);
        assert!(written.chars().all(is_set_by_pdflatex), "{written}");
        assert!(!written.contains("XeLaTeX"), "{written}");
        // Texts of files in other scripts.
        let title = Latex.render(&[Block::Text("模态 😀 a\u{301}\u{1b}[2J".to_owned())]);
        assert!(title.chars().all(is_set_by_pdflatex), "{title}");
        let parts = "\\unicodechar{6A21}\\unicodechar{6001} \\unicodechar{1F600} a\\unicodechar{0301}\\textbackslash{}x1b[2J";
        assert!(title.contains(parts), "{title}");
        let chinese = rendered(Table {
            columns: vec![Column::text("阶次"), Column::text("模态")],
            ..Table::default()
        });
        assert!(chinese.contains("\\usepackage{ctex}"), "{chinese}");
        assert!(
            chinese.contains("模态") && !chinese.contains("unicodechar"),
            "{chinese}"
        );
    }

    #[test]
    fn wide_tables_omit_columns_and_name_them() {
        let few = rendered(table(&["theory (Hz)", "test (Hz)"], 3));
        assert!(few.contains("\\small"), "{few}");
        assert!(!few.contains("further column"), "{few}");
        let heads: Vec<String> = (1..=14).map(|n| format!("column {n} (Hz)")).collect();
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        let many = rendered(table(&heads, 3));
        assert!(
            many.contains("7 further columns (column 8 (Hz), "),
            "{many}"
        );
        assert!(many.contains("...): in the other formats."), "{many}");
    }

    #[test]
    fn long_texts_are_wrapped_to_the_page() {
        let mut wide = table(&["value"], 2);
        wide.columns.push(Column::text("meaning"));
        for row in &mut wide.rows {
            row.push(Cell::text("a long sentence about the value ".repeat(6)));
        }
        let text = rendered(wide);
        assert!(
            text.contains("lr>{\\raggedright\\arraybackslash}p{"),
            "{text}"
        );
    }

    #[test]
    fn a_table_longer_than_a_page_repeats_its_head() {
        let short = rendered(table(&["f (Hz)"], 10));
        assert_eq!(count(&short, "\\begin{tabular}"), 1);
        let long = rendered(table(&["f (Hz)"], 100));
        assert_eq!(count(&long, "\\begin{longtable}"), 1);
        assert_eq!(count(&long, "mode & f (Hz) \\\\"), 2);
    }

    #[test]
    fn the_name_of_a_test_is_above_its_columns() {
        let heads = ["virtual, discs\n(Hz)", "virtual, discs\nerror (%)", "MAC"];
        let text = rendered(table(&heads, 2));
        assert!(
            text.contains("\\multicolumn{2}{c}{virtual, discs}"),
            "{text}"
        );
        assert!(text.contains("\\cmidrule(lr){2-3}"), "{text}");
        assert!(
            text.contains("mode & (Hz) & error (\\%) & MAC \\\\"),
            "{text}"
        );
    }

    #[test]
    fn the_definition_of_an_error_is_a_note() {
        let text = rendered(table(&["a: (test−theory)/theory (%)", "a: (Hz)"], 2));
        assert!(text.contains("mode & error (\\%) & (Hz)"), "{text}");
        assert_eq!(
            count(&text, "Error = (test - theory)/\\allowbreak{}theory."),
            1
        );
    }

    #[test]
    fn a_table_without_a_caption_has_no_empty_one() {
        let text = rendered(Table {
            caption: String::new(),
            ..table(&["f (Hz)"], 2)
        });
        assert!(!text.contains("\\caption"), "{text}");
    }

    #[test]
    fn a_cell_in_brackets_is_no_option_of_the_row_before() {
        let mut bracketed = table(&["f (Hz)"], 2);
        bracketed.rows[1][0] = Cell::text("[2]");
        assert!(rendered(bracketed).contains("  {}[2] &"));
    }
}
