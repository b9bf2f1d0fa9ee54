//! Texts of the command line in lines of the width of the terminal.

/// Width of a text for a reader that is no terminal.
pub const DEFAULT_WIDTH: usize = 100;
/// Width of the narrowest terminal that is used as it is.
const MIN_WIDTH: usize = 60;

/// Characters in a line of the terminal behind standard output; `None` where it is none.
pub fn output_width() -> Option<usize> {
    usable(terminal_size::terminal_size_of(std::io::stdout()))
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
        let options = textwrap::Options::new(width).subsequent_indent(indent);
        textwrap::fill(line, options.break_words(false))
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_their_indent_and_long_names_stay_whole() {
        let text = "error: 2 faults\n  a.toml:1:1: one two three\nhint: /a/folder/of/a/long/name";
        let expected =
            "error: 2 faults\n  a.toml:1:1: one\n  two three\nhint:\n/a/folder/of/a/long/name";
        assert_eq!(wrapped(text, 18), expected);
    }
}
