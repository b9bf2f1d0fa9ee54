//! Colours of words: severities on standard error, verdicts on standard output.

use std::io::IsTerminal;

use clap::ValueEnum;

/// When words are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ColorChoice {
    /// On a terminal, unless NO_COLOR is set.
    #[default]
    Auto,
    /// Everywhere.
    Always,
    /// Nowhere.
    Never,
}

impl ColorChoice {
    /// Whether what is written to a stream is coloured. NO_COLOR counts when it is set and not
    /// empty (no-color.org); a terminal that calls itself `dumb` has no colours.
    pub fn is_enabled_on(self, stream: &impl IsTerminal) -> bool {
        let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        match self {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => stream.is_terminal() && !set("NO_COLOR") && !is_dumb(),
        }
    }
}

/// Whether the terminal says that it knows no escapes.
pub fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|value| value == "dumb")
}

const RED: &str = "31";
const YELLOW: &str = "33";
const GREEN: &str = "32";

/// Verdicts that a table of results may end with.
const VERDICTS: [(&str, &str); 2] = [("MISSED", RED), ("met", GREEN)];

fn paint(text: &str, color: &str) -> String {
    format!("\u{1b}[1;{color}m{text}\u{1b}[0m")
}

/// A message with its severity, the word before the first colon, in colour.
pub fn color_message(line: &str) -> String {
    let color = |word: &str| match word {
        "error" | "错误" => Some(RED),
        "warning" | "警告" => Some(YELLOW),
        _ => None,
    };
    match line.split_once(':') {
        Some((word, rest)) => match color(word) {
            Some(color) => format!("{}:{rest}", paint(word, color)),
            None => line.to_owned(),
        },
        None => line.to_owned(),
    }
}

/// A result with its verdicts in colour. Whole words alone are coloured, so that columns stay
/// aligned.
pub fn color_result(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let mut remaining = line;
        while let Some((at, word, color)) = next_verdict(remaining) {
            out += &remaining[..at];
            out += &paint(word, color);
            remaining = &remaining[at + word.len()..];
        }
        out += remaining;
    }
    out
}

/// The first verdict that stands between blanks, or before a mark of punctuation.
fn next_verdict(text: &str) -> Option<(usize, &'static str, &'static str)> {
    let found = VERDICTS.iter().flat_map(|&(word, color)| {
        let places = text.match_indices(word).map(|(at, _)| at);
        let alone = places.filter(move |&at| {
            let before = text[..at].chars().next_back();
            let after = text[at + word.len()..].chars().next();
            before.is_none_or(char::is_whitespace)
                && !text[..at].ends_with("not ")
                && after.is_none_or(|c| c.is_whitespace() || c.is_ascii_punctuation())
        });
        alone.map(move |at| (at, word, color))
    });
    found.min_by_key(|(at, _, _)| *at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_coloured_and_the_text_is_unchanged() {
        assert_eq!(
            color_message("error: x: y"),
            "\u{1b}[1;31merror\u{1b}[0m: x: y"
        );
        assert_eq!(color_message("info: x"), "info: x");
        let text = " f1  MISSED  metre \n 2 of 2 met, on f2\n f3 not met\n";
        let plain = color_result(text)
            .replace("\u{1b}[1;31m", "")
            .replace("\u{1b}[1;32m", "")
            .replace("\u{1b}[0m", "");
        assert_eq!(plain, text);
        assert_eq!(color_result(text).matches("\u{1b}[1;").count(), 2);
    }
}
