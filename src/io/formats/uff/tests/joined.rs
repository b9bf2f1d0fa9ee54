//! Delimiters that stand directly behind numbers or blocks, and padding around them.

use super::file_builder::{Form, all, binary_58, dataset, header, open, singles, text_58};
use crate::finding::Code;
use crate::io::{Block, Source};

/// A text function of two values whose last row is followed by `end`.
fn ended_by(end: &str) -> Vec<u8> {
    let whole = text_58(&header(2, 2), &["  1.00000E+00  2.50000E+00"], "\n");
    let row_end = whole.len() - "\n    -1\n".len();
    [&whole[..row_end], end.as_bytes()].concat()
}

fn opened(parts: &[&[u8]]) -> (Box<dyn Source>, usize, usize) {
    let source = open(parts.concat()).unwrap();
    let catalog = source.catalog();
    let counts = (catalog.entries.len(), catalog.damage.len());
    (source, counts.0, counts.1)
}

#[test]
fn a_delimiter_directly_behind_the_last_number_ends_a_text_block() {
    let next = text_58(&header(2, 1), &["4.5"], "\n");
    for end in ["    -1\n", "    -1", "    -1  \n\u{1a}"] {
        let (mut source, entries, damage) = opened(&[&next, &ended_by(end)]);
        assert_eq!((entries, damage), (2, 0), "{end:?}");
        assert_eq!(all(source.as_mut(), 1).unwrap(), Block::F64(vec![1.0, 2.5]));
    }
    let (mut source, entries, damage) = opened(&[&ended_by("    -1\n"), &next]);
    assert_eq!((entries, damage), (2, 0));
    assert_eq!(all(source.as_mut(), 0).unwrap(), Block::F64(vec![1.0, 2.5]));
    assert_eq!(all(source.as_mut(), 1).unwrap(), Block::F64(vec![4.5]));
    // The delimiter is that of the next dataset.
    let joined = String::from_utf8(next.clone()).unwrap();
    let (mut source, entries, damage) = opened(&[&ended_by(&joined)]);
    assert_eq!((entries, damage), (2, 0));
    let mut findings = source.catalog().findings.iter();
    assert!(findings.any(|finding| finding.code == Code::NotClosed));
    assert_eq!(all(source.as_mut(), 1).unwrap(), Block::F64(vec![4.5]));
}

#[test]
fn a_last_number_of_minus_one_is_no_delimiter() {
    for rows in [
        &["  1.5", "  2.5    -1"][..],
        &["  1.5  2.5    -1"],
        &["  1.5    -1", "    58"],
        &["    -1    -1   -1"],
        &["    -1    -1", "     7.0"],
    ] {
        let (mut source, entries, damage) = opened(&[&text_58(&header(2, 3), rows, "\n")]);
        assert_eq!((entries, damage), (1, 0), "{rows:?}");
        let block = all(source.as_mut(), 0).unwrap();
        let numbers: Vec<f64> = rows
            .join(" ")
            .split_whitespace()
            .map(|word| word.parse().unwrap())
            .collect();
        assert_eq!(block, Block::F64(numbers));
    }
}

#[test]
fn files_joined_behind_a_binary_block_are_both_read() {
    let text = text_58(&header(2, 1), &["4.5"], "\n");
    for newline_behind_block in [false, true] {
        let form = Form {
            newline_behind_block,
            ..Form::default()
        };
        let block = binary_58(&header(2, 2), &singles(&[1.0, 2.5], true), form);
        let unended = &block[..block.len() - "  \n".len()];
        for second in [&text, &block, &dataset(&["   151", "Machine"], "\n")] {
            for padding in ["", "\u{1a}", "\0\0\0", "\u{feff}"] {
                let (source, _, damage) = opened(&[unended, padding.as_bytes(), second, &text]);
                assert_eq!(
                    (source.catalog().entries.len(), damage),
                    (
                        if second.starts_with(b"    -1\n   151") {
                            2
                        } else {
                            3
                        },
                        0
                    ),
                    "{padding:?}"
                );
            }
        }
    }
}

#[test]
fn padding_behind_a_last_block_without_delimiter_is_none_of_its_values() {
    let block = binary_58(&header(2, 2), &singles(&[1.0, 2.5], true), Form::default());
    let bare = &block[..block.len() - "    -1  \n".len()];
    for padding in [
        "\0".repeat(4096),
        "\u{1a}".to_owned(),
        "\n\u{1a}\n".to_owned(),
    ] {
        let (mut source, entries, damage) = opened(&[bare, padding.as_bytes()]);
        assert_eq!((entries, damage), (1, 0), "{padding:?}");
        assert_eq!(all(source.as_mut(), 0).unwrap(), Block::F32(vec![1.0, 2.5]));
        let (mut source, entries, damage) = opened(&[&ended_by("\n"), padding.as_bytes()]);
        assert_eq!((entries, damage), (1, 0), "{padding:?}");
        assert_eq!(all(source.as_mut(), 0).unwrap(), Block::F64(vec![1.0, 2.5]));
    }
}

#[test]
fn a_binary_dataset_of_another_number_is_passed_over_by_its_byte_count() {
    let block = b"\n    -1\n    58\nNONE\n    -1\n    -1\n    58b\n";
    let mut unknown = binary_58(&header(2, 8), block, Form::default());
    unknown[7..13].copy_from_slice(b"  3000");
    let text = text_58(&header(2, 1), &["4.5"], "\n");
    let (source, entries, damage) = opened(&[&unknown, &text]);
    assert_eq!((entries, damage), (1, 0), "{:?}", source.catalog());
}
