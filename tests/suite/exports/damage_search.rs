//! Damaged binary functions whose block holds text that looks like datasets: the search for the
//! next dataset begins behind the block.

use super::inspected::inspect;
use super::universal_file::{Function, OneFile};

/// Values of the record behind the damaged one.
const VALUES: usize = 12;

/// A block of 176 bytes with delimiters and dataset numbers inside.
fn misleading_block() -> Vec<u8> {
    let mut block = vec![0x3f; 70];
    block.extend(b"\n    -1\n    58\n");
    block.resize(120, 0x41);
    block.extend(b"\n    -1\n    15\n    -1\n    -1\n    58b     1     2\n");
    block.resize(176, 0x42);
    block
}

/// The head of a record of 44 values at 1:+Z, without its delimiter.
fn record_head(binary_line: &str) -> Vec<String> {
    let mut lines = Function::record(1, false, vec![0.0; 44]).lines()[..13].to_vec();
    lines[1] = binary_line.to_owned();
    lines
}

fn binary_line(byte_order: i32, float_format: i32, header_lines: i32, bytes: usize) -> String {
    format!(
        "    58b{byte_order:>6}{float_format:>6}{header_lines:>12}{bytes:>12}     0     0           0           0"
    )
}

/// Exactly one place of damage, and the record of node 77 behind it with its values.
fn only_the_first_is_lost(head: &[String]) {
    let mut bytes = (head.join("\n") + "\n").into_bytes();
    bytes.extend(misleading_block());
    bytes.extend(b"    -1\n");
    let values = (0..VALUES).map(|sample| (sample as f64).sin());
    bytes.extend(Function::record(77, false, values.collect()).text().bytes());
    let file = OneFile::new("damaged.uff", bytes);
    let inspected = inspect(&file);
    assert_eq!(inspected.code, Some(1), "{inspected:?}");
    let entries = inspected.items("entries");
    assert_eq!(entries.len(), 1, "{head:?}: {inspected:?}");
    assert_eq!(entries[0]["response"], "77:+Z", "{inspected:?}");
    assert_eq!(entries[0]["values"], VALUES, "{inspected:?}");
    assert_eq!(
        inspected.count_of("bad-dataset"),
        1,
        "{head:?}: {inspected:?}"
    );
}

#[test]
fn a_block_of_an_unknown_number_format_is_passed_over_by_its_byte_count() {
    for (byte_order, float_format) in [(1, 1), (2, 3), (1, 7), (0, 2), (9, 0)] {
        only_the_first_is_lost(&record_head(&binary_line(
            byte_order,
            float_format,
            11,
            176,
        )));
    }
}

#[test]
fn a_block_of_an_unknown_number_format_is_passed_over_by_its_points() {
    for stated_bytes in [0, 44, 9999] {
        only_the_first_is_lost(&record_head(&binary_line(1, 1, 11, stated_bytes)));
    }
}

#[test]
fn a_block_behind_an_unreadable_record_is_passed_over() {
    for (record, text) in [
        (7, "nothing"),
        (8, "nothing"),
        (9, "nothing"),
        (10, "nothing"),
    ] {
        let mut head = record_head(&binary_line(1, 2, 11, 176));
        head[record] = text.to_owned();
        only_the_first_is_lost(&head);
    }
    // The byte count is wrong, but the number of points is right.
    for record in [7, 9, 10] {
        let mut head = record_head(&binary_line(1, 2, 11, 4));
        head[record] = "nothing".to_owned();
        only_the_first_is_lost(&head);
    }
}

#[test]
fn a_block_behind_a_wrong_number_of_header_lines_is_passed_over() {
    for header_lines in [3, 500] {
        only_the_first_is_lost(&record_head(&binary_line(1, 2, header_lines, 176)));
    }
}
