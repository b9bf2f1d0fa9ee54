//! The delimiter `    -1` of datasets, alone on its line, padded, or joined with another one where
//! files were put together without a line end. No I/O.

/// The delimiter in its six columns.
const DELIMITER: &[u8] = b"    -1";
/// Columns of a line that is padded with blanks.
const LINE_COLUMNS: usize = 80;
/// A byte order mark of UTF-8, which stands at the start of each of several joined files.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
/// End of file of DOS and CP/M, Ctrl-Z.
const END_OF_FILE: u8 = 0x1a;

/// A line without the padding around its text: blanks, NUL, Ctrl-Z and byte order marks.
pub(in crate::io::formats::uff) fn without_padding(line: &[u8]) -> &[u8] {
    let fills = |byte: &u8| byte.is_ascii_whitespace() || matches!(*byte, 0 | END_OF_FILE);
    let mut text = line;
    loop {
        let before = text.len();
        text = &text[text.iter().take_while(|byte| fills(byte)).count()..];
        let behind = text.iter().rev().take_while(|byte| fills(byte)).count();
        text = &text[..text.len() - behind];
        text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        text = text.strip_suffix(BYTE_ORDER_MARK).unwrap_or(text);
        if text.len() == before {
            return text;
        }
    }
}

/// Whether a line is the mark that opens and closes datasets.
pub(in crate::io::formats::uff) fn is_delimiter(line: &[u8]) -> bool {
    // Most lines are numbers, whose last character decides.
    line.contains(&b'-') && without_padding(line) == b"-1"
}

/// Where the second of two delimiters on one line begins: the last line of a file without line end
/// and the first line of the file that was joined to it.
///
/// Both stand in their six columns, one directly behind the other, or with padding between them
/// that no row of numbers has: up to column 80, or with NUL, Ctrl-Z or a byte order mark. So a row
/// of numbers `-1 -1` is never taken for delimiters.
pub(in crate::io::formats::uff) fn second_delimiter(line: &[u8]) -> Option<usize> {
    let first_end = line.windows(2).position(|pair| pair == b"-1")? + 2;
    let behind = &line[first_end..];
    let gap = behind.windows(2).position(|pair| pair == b"-1")?;
    let gap = (gap + 2).checked_sub(DELIMITER.len())?;
    let (padding, second) = behind.split_at(gap);
    let is_joined = line[..first_end].ends_with(DELIMITER)
        && without_padding(&line[..first_end - DELIMITER.len()]).is_empty()
        && second.starts_with(DELIMITER)
        && without_padding(&second[DELIMITER.len()..]).is_empty()
        && without_padding(padding).is_empty();
    let is_parted = padding.is_empty()
        || first_end + padding.len() == LINE_COLUMNS
        || !padding.iter().all(u8::is_ascii_whitespace);
    (is_joined && is_parted).then_some(first_end + gap)
}

/// Where a delimiter begins that stands directly behind the numbers of a row, without the line end
/// between them. Only the number of numbers can show that it is not one of them.
pub(in crate::io::formats::uff) fn appended_delimiter(row: &[u8]) -> Option<usize> {
    let numbers = row.trim_ascii_end().strip_suffix(DELIMITER)?;
    (!without_padding(numbers).is_empty()).then_some(numbers.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_padded_delimiter_is_one_delimiter() {
        for line in [
            "    -1",
            "-1",
            "    -1\0\0",
            "\u{feff}    -1",
            "\u{1a}    -1 \u{1a}",
        ] {
            assert!(is_delimiter(line.as_bytes()), "{line:?}");
            assert_eq!(second_delimiter(line.as_bytes()), None, "{line:?}");
        }
        for line in ["", "\0", "-1 -1", "-10", "    -1x", "    -1    -1"] {
            assert!(!is_delimiter(line.as_bytes()), "{line:?}");
        }
    }

    #[test]
    fn joined_delimiters_are_two_and_rows_of_numbers_are_none() {
        let padded = format!("    -1{}    -1  ", " ".repeat(74));
        for (line, second) in [
            ("    -1    -1", 6),
            ("    -1    -1   \0", 6),
            ("    -1\u{1a}    -1", 7),
            ("\u{feff}    -1\u{feff}    -1", 12),
            ("    -1\0\0\0  \0    -1", 12),
            (padded.as_str(), 80),
        ] {
            assert_eq!(second_delimiter(line.as_bytes()), Some(second), "{line:?}");
        }
        for line in [
            "-1 -1",
            "  -1  -1",
            "        -1        -1",
            "    -1        -1",
            "    -1    -1    -1",
            "    -1    -1     0",
            "    -1.    -1.",
            "   1    -1    -1",
            "    -1   -1",
        ] {
            assert_eq!(second_delimiter(line.as_bytes()), None, "{line:?}");
        }
    }

    #[test]
    fn a_delimiter_behind_numbers_is_found_at_its_column() {
        assert_eq!(appended_delimiter(b"  1.0  2.0    -1 "), Some(10));
        for row in ["    -1", "  1.0   -1", "  1.0    -1 2", "  1.0    -11"] {
            assert_eq!(appended_delimiter(row.as_bytes()), None, "{row}");
        }
    }
}
