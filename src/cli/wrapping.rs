//! Texts of the command line in lines of the width of the terminal.

use crate::report::wrapping;

/// Width of a text for a reader that is no terminal.
pub const DEFAULT_WIDTH: usize = 100;
/// Width of the narrowest terminal that is used as it is.
const MIN_WIDTH: usize = 60;

/// Characters in a line of standard output: those of COLUMNS where it is set, else of the terminal
/// behind it; `None` where it is none.
pub fn output_width() -> Option<usize> {
    let stated = std::env::var("COLUMNS").ok();
    stated_width(stated.as_deref())
        .or_else(|| usable(terminal_size::terminal_size_of(std::io::stdout())))
}

/// The width that COLUMNS states; `None` where it states no positive number.
fn stated_width(columns: Option<&str>) -> Option<usize> {
    let columns: usize = columns?.trim().parse().ok()?;
    (columns > 0).then(|| columns.max(MIN_WIDTH))
}

/// Characters in a line of the terminal behind standard error; `None` where it is none.
pub fn error_width() -> Option<usize> {
    usable(terminal_size::terminal_size_of(std::io::stderr()))
}

fn usable(size: Option<(terminal_size::Width, terminal_size::Height)>) -> Option<usize> {
    size.map(|(width, _)| usize::from(width.0).max(MIN_WIDTH))
}

/// A text whose lines are at most this wide; further lines of one are indented as it is.
pub fn wrapped(text: &str, width: usize) -> String {
    let lines = text.lines().map(|line| {
        let indent = &line[..line.len() - line.trim_start().len()];
        textwrap::fill(line, wrapping(width).subsequent_indent(indent))
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_state_the_width_where_they_are_a_number() {
        assert_eq!(stated_width(Some("80")), Some(80));
        assert_eq!(stated_width(Some("20")), Some(MIN_WIDTH));
        for none in [None, Some(""), Some("0"), Some("wide")] {
            assert_eq!(stated_width(none), None);
        }
    }

    #[test]
    fn lines_keep_their_indent_and_long_names_stay_whole() {
        let text = "error: 2 faults\n  a.toml:1:1: one two three\nhint: /a/folder/of/a/long/name";
        let expected =
            "error: 2 faults\n  a.toml:1:1: one\n  two three\nhint:\n/a/folder/of/a/long/name";
        assert_eq!(wrapped(text, 18), expected);
    }
}
