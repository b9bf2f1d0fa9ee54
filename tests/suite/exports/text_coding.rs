//! Universal files in UTF-16, with a byte order mark, and with the line ends of old Macintosh
//! systems.

use super::inspected::inspect;
use super::universal_file::{Function, OneFile, Values, accelerances, file_of, finds_the_mode};

const MARK: &str = "\u{feff}";

fn utf_16(text: &str, big_endian: bool) -> Vec<u8> {
    let bytes = |unit: u16| match big_endian {
        true => unit.to_be_bytes(),
        false => unit.to_le_bytes(),
    };
    text.encode_utf16().flat_map(bytes).collect()
}

fn reads_three_functions(bytes: impl AsRef<[u8]>) {
    let file = OneFile::new("coded.uff", bytes);
    let inspected = inspect(&file);
    assert_eq!(inspected.code, Some(0), "{inspected:?}");
    assert_eq!(inspected.listing["format"], "uff", "{inspected:?}");
    assert_eq!(inspected.items("entries").len(), 3, "{inspected:?}");
    finds_the_mode(&file.path(), &[]);
}

/// The accelerances as little-endian doubles, with this line end in the headers.
fn binary_file(line_end: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for function in accelerances() {
        bytes.extend(binary(&function, line_end));
    }
    bytes
}

fn binary(function: &Function, line_end: &str) -> Vec<u8> {
    let Values::Complex(values) = &function.values else {
        panic!("an accelerance has complex values")
    };
    let mut lines = function.lines()[..13].to_vec();
    lines[1] = format!(
        "    58b     1     2          11{:>12}     0     0           0           0",
        16 * values.len()
    );
    lines[8] = lines[8].replacen("         5", "         6", 1);
    let mut bytes = (lines.join(line_end) + line_end).into_bytes();
    let parts = values.iter().flat_map(|value| [value.re, value.im]);
    bytes.extend(parts.flat_map(f64::to_le_bytes));
    bytes.extend(format!("    -1{line_end}").bytes());
    bytes
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_first_line() {
    let text = file_of(&accelerances());
    reads_three_functions(format!("{MARK}{text}"));
    reads_three_functions(format!("{MARK}\r\n{}", text.replace('\n', "\r\n")));
    // Each of the joined files has its mark.
    let marked = accelerances()
        .into_iter()
        .map(|function| format!("{MARK}{}", function.text()));
    reads_three_functions(marked.collect::<String>());
}

#[test]
fn utf_16_is_read_with_and_without_its_mark() {
    let text = file_of(&accelerances());
    for big_endian in [false, true] {
        for mark in ["", MARK] {
            reads_three_functions(utf_16(&format!("{mark}{text}"), big_endian));
            let dos = text.replace('\n', "\r\n");
            reads_three_functions(utf_16(&format!("{mark}{dos}\u{1a}"), big_endian));
        }
    }
}

#[test]
fn a_carriage_return_alone_ends_a_line() {
    let text = file_of(&accelerances()).replace('\n', "\r");
    reads_three_functions(&text);
    reads_three_functions(format!("{MARK}\r\r{text}"));
    reads_three_functions(utf_16(&text, true));
}

#[test]
fn joined_files_of_different_line_ends_are_read() {
    let texts: Vec<String> = accelerances().iter().map(Function::text).collect();
    for ends in [
        ["\r", "\n", "\r\n"],
        ["\n", "\r", "\r\n"],
        ["\r\n", "\n", "\r"],
    ] {
        let joined = texts
            .iter()
            .zip(ends)
            .map(|(text, end)| text.replace('\n', end));
        reads_three_functions(joined.collect::<String>());
    }
}

#[test]
fn binary_blocks_keep_their_bytes_behind_any_mark_and_line_end() {
    for line_end in ["\n", "\r\n", "\r", "\r\r\n"] {
        let plain = binary_file(line_end);
        reads_three_functions(&plain);
        reads_three_functions([MARK.as_bytes(), &plain].concat());
    }
}
