//! Text from a file becomes text that a terminal, an editor or a browser shows and never obeys.
//!
//! Titles, names and units come from other people's files. Control characters in them can retitle
//! a terminal, clear it, or print over a verdict; marks of writing direction reorder a line.

use std::borrow::Cow;
use std::fmt::Write;

/// Maximum number of characters of a word that is shown, such as of a value that a message quotes.
/// Longer: a single cell fills the terminal. Shorter: paths are cut.
const MAX_WORD_CHARS: usize = 400;
/// Maximum number of characters of a line. Longer: a text with blanks fills the terminal. Shorter:
/// lists of files and faults are cut.
const MAX_LINE_CHARS: usize = 20_000;
/// Maximum number of characters of a cell of a table. Longer: no table fits a page. Shorter:
/// reasons and explanations are cut.
const MAX_CELL_CHARS: usize = 1000;

/// Whether the character is a command rather than a sign: C0, DEL and C1 of ISO 6429, marks of
/// writing direction and invisible characters of Unicode. The end of a line is one, too; joiners,
/// which some scripts need within words, are not.
pub fn is_control(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}')
}

/// The text with control characters written as `\x1b` or `\u{202e}`. Ends of lines and tabs stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |c| !matches!(c, '\n' | '\t') && is_control(c))
}

/// As [`printable`], on one line and without tabs.
pub fn printable_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_control)
}

/// A count with its noun, which takes an s: `1 mode`, `3 modes`.
pub(crate) fn counted(number: usize, noun: &str) -> String {
    match (number, noun.split_once(" of ")) {
        (1, _) => format!("1 {noun}"),
        (_, Some((noun, of))) => format!("{number} {noun}s of {of}"),
        (_, None) => format!("{number} {noun}s"),
    }
}

/// Names in a list; in quotation marks where one of them has a comma or a semicolon.
pub(crate) fn listed(names: &[&str]) -> String {
    if !names.iter().any(|name| name.contains([',', ';'])) {
        return names.join(", ");
    }
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    quoted.join(", ")
}

/// The text with blanks in place of the ends of its lines: a title prints no line behind it.
pub fn one_line(text: &str) -> Cow<'_, str> {
    match text.contains(['\n', '\r']) {
        true => Cow::Owned(text.split_whitespace().collect::<Vec<_>>().join(" ")),
        false => Cow::Borrowed(text),
    }
}

fn escaped(text: &str, is_hidden: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match c {
            '\n' if is_hidden(c) => shown.push_str("\\n"),
            '\t' if is_hidden(c) => shown.push_str("\\t"),
            '\r' if is_hidden(c) => shown.push_str("\\r"),
            // A string takes all that is written.
            c if is_hidden(c) && u32::from(c) < 0x100 => {
                let _ = write!(shown, "\\x{:02x}", u32::from(c));
            }
            c if is_hidden(c) => {
                let _ = write!(shown, "\\u{{{:x}}}", u32::from(c));
            }
            c => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// A cell of a table: [`printable`], at most 1000 characters long.
pub fn printable_cell(text: &str) -> Cow<'_, str> {
    match shortened(text, MAX_CELL_CHARS) {
        Cow::Borrowed(text) => printable(text),
        Cow::Owned(text) => Cow::Owned(printable(&text).into_owned()),
    }
}

/// A message or paragraph: [`printable`], with words of at most 400 characters and lines of at most
/// 20,000.
pub fn printable_message(text: &str) -> Cow<'_, str> {
    let line = |line: &str| {
        let words = line.split(' ');
        let words = words.map(|word| shortened(word, MAX_WORD_CHARS));
        let line = words.collect::<Vec<_>>().join(" ");
        shortened(&line, MAX_LINE_CHARS).into_owned()
    };
    if text.len() <= MAX_WORD_CHARS {
        return printable(text);
    }
    let lines = text.split('\n').map(line).collect::<Vec<_>>().join("\n");
    Cow::Owned(printable(&lines).into_owned())
}

/// The first three quarters and the last quarter of a text that is longer than `max` characters:
/// what a message expects stands at its end.
fn shortened(text: &str, max: usize) -> Cow<'_, str> {
    // A character has a byte at least, so that a short text need not be counted.
    if text.len() <= max || text.chars().nth(max).is_none() {
        return Cow::Borrowed(text);
    }
    let tail = max / 4;
    let head: String = text.chars().take(max - tail).collect();
    let start = text.char_indices().rev().nth(tail - 1);
    let end = &text[start.map_or(0, |(at, _)| at)..];
    let count = text.chars().count();
    Cow::Owned(format!("{head} … ({count} characters) … {end}"))
}

/// Maximum length of a text in a file name. Longer: with what stands before and behind it a name
/// exceeds the 255 bytes of a file system. Shorter: usual names of tests are cut.
const MAX_FILE_NAME_BYTES: usize = 120;

/// The beginning of a text that has room in a file name.
pub fn file_name_part(text: &str) -> &str {
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
    let end = ends.take_while(|end| *end <= MAX_FILE_NAME_BYTES).last();
    &text[..end.unwrap_or(0)]
}

/// JSON with the control characters in its texts as `\u` escapes: JSON itself escapes only C0.
pub fn printable_json(json: String) -> String {
    let is_hidden = |c: char| c >= '\u{7f}' && is_control(c);
    if !json.contains(is_hidden) {
        return json;
    }
    let mut written = String::with_capacity(json.len() + 8);
    for c in json.chars() {
        if is_hidden(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                let _ = write!(written, "\\u{unit:04x}");
            }
        } else {
            written.push(c);
        }
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_control_character_is_printed_as_it_is() {
        for (text, expected) in [
            ("plain φ² 中文 😀", "plain φ² 中文 😀"),
            ("\u{1b}]0;title\u{7}\u{1b}[2J", "\\x1b]0;title\\x07\\x1b[2J"),
            ("\u{9b}31m\u{7f}", "\\x9b31m\\x7f"),
            ("a\rb\0", "a\\rb\\x00"),
            ("safe\u{202e}txt.exe", "safe\\u{202e}txt.exe"),
            ("a\u{2028}b\u{feff}", "a\\u{2028}b\\u{feff}"),
            ("two\nlines\tand tab", "two\nlines\tand tab"),
        ] {
            assert_eq!(printable(text), expected);
        }
        assert_eq!(printable_line("two\nlines\t"), "two\\nlines\\t");
    }

    #[test]
    fn long_values_are_cut_with_their_length() {
        assert_eq!(shortened("abcdefghij", 8), "abcdef … (10 characters) … ij");
        assert_eq!(shortened("abcdefgh", 8), "abcdefgh");
        let message = format!("got {}, expected a number", "x".repeat(400_000));
        let shown = printable_message(&message);
        assert!(shown.chars().count() < MAX_WORD_CHARS + 100);
        assert!(shown.contains(" (400001 characters) "), "{shown}");
        assert!(shown.ends_with(", expected a number"), "{shown}");
        let message = format!("got {}, expected a number", "x ".repeat(400_000));
        let shown = printable_message(&message);
        assert!(shown.chars().count() < MAX_LINE_CHARS + 40);
        assert!(shown.ends_with(", expected a number"));
        let cell = "é".repeat(MAX_CELL_CHARS + 1);
        assert!(printable_cell(&cell).contains("(1001 characters)"));
        assert_eq!(printable_cell(&cell[..2000]), cell[..2000]);
    }

    #[test]
    fn json_remains_the_same_data() {
        let text = "C1 \u{9b}, DEL \u{7f}, bidi \u{202e}, tag \u{e0001}, \u{1b}";
        let json = serde_json::to_string(text).unwrap();
        let written = printable_json(json);
        assert!(!written.contains(is_control), "{written}");
        assert_eq!(serde_json::from_str::<String>(&written).unwrap(), text);
    }
}
