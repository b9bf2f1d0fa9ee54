//! Universal files that were joined without a line end between them, and the padding that DOS
//! programs leave at the end of a file.

use super::inspected::inspect;
use super::universal_file::{Function, OneFile, accelerances, file_of, finds_the_mode};

/// A file without the line end behind its last delimiter.
fn unended(text: &str) -> &str {
    text.strip_suffix('\n').unwrap()
}

/// The three accelerances, parted by this text instead of a line end.
fn parted_by(padding: &str) -> String {
    let texts: Vec<String> = accelerances().iter().map(Function::text).collect();
    let unended: Vec<&str> = texts.iter().map(|text| unended(text)).collect();
    unended.join(padding) + "\n"
}

/// Inspects and identifies; the number of functions must be three, and nothing is damaged.
fn reads_three_functions(bytes: impl AsRef<[u8]>) {
    let file = OneFile::new("joined.uff", bytes);
    let inspected = inspect(&file);
    assert_eq!(inspected.code, Some(0), "{inspected:?}");
    assert_eq!(inspected.items("entries").len(), 3, "{inspected:?}");
    assert!(inspected.items("findings").is_empty(), "{inspected:?}");
    finds_the_mode(&file.path(), &[]);
}

#[test]
fn files_joined_without_a_line_end_keep_every_function() {
    reads_three_functions(parted_by(""));
}

#[test]
fn a_delimiter_padded_to_80_columns_joins_as_well() {
    reads_three_functions(parted_by(&" ".repeat(74)));
}

#[test]
fn files_joined_behind_nodes_and_units_keep_every_function() {
    let head = "    -1\n   164\n         1SI                  2\n  1.0D+00  1.0D+00  1.0D+00\n  0.0D+00\n    -1    \
                -1\n    15\n         1         0         0         1  0.00000E+00  0.00000E+00  0.00000E+00\n    -1";
    let file = OneFile::new("joined.uff", format!("{head}{}", file_of(&accelerances())));
    let inspected = inspect(&file);
    assert_eq!(inspected.code, Some(0), "{inspected:?}");
    assert_eq!(inspected.items("entries").len(), 3, "{inspected:?}");
    assert_eq!(inspected.listing["nodes"], 1, "{inspected:?}");
    finds_the_mode(&file.path(), &[]);
}

#[test]
fn text_before_the_first_dataset_hides_no_universal_file() {
    for title in [
        "==== part2.unv ====\n",
        "C:\\tests\\part2.unv\n",
        "Exported 2024-05-01 12:00\n\n",
        "From: x\nSubject: FRFs\n\n",
    ] {
        let titled = accelerances().into_iter();
        let titled: String = titled.map(|f| format!("{title}{}", f.text())).collect();
        let inspected = inspect(&OneFile::new("titled.uff", titled));
        assert_eq!(inspected.listing["format"], "uff", "{title}: {inspected:?}");
        assert_eq!(
            inspected.items("entries").len(),
            3,
            "{title}: {inspected:?}"
        );
        // The text may be the rest of a damaged dataset.
        let damage = inspected.items("damage");
        assert_eq!(damage.len(), 3, "{title}: {inspected:?}");
        assert!(
            damage[0].to_string().contains(":1: text between datasets"),
            "{inspected:?}"
        );
    }
    let inspected = inspect(&OneFile::new("table.csv", "count\n-1\n3\n5\n"));
    assert_eq!(inspected.listing["format"], "table", "{inspected:?}");
}

#[test]
fn the_end_of_file_mark_of_dos_is_no_damage() {
    let text = file_of(&accelerances());
    for end in ["\u{1a}", "\u{1a}\n", "\0\0\0\0", " \r\n\u{1a}\u{1a}\u{1a}"] {
        reads_three_functions(format!("{text}{end}"));
        reads_three_functions(format!("{}{end}", unended(&text)));
    }
    reads_three_functions(format!("{text}{}", "\0".repeat(70_000)));
}

#[test]
fn the_end_of_file_mark_between_joined_files_is_no_damage() {
    for padding in [
        "\u{1a}",
        "\n\u{1a}",
        "\n\u{1a}\n",
        "\0\0\0",
        "\n\0\0\n",
        "\n    \n",
    ] {
        reads_three_functions(parted_by(padding));
    }
}

#[test]
fn the_end_of_file_mark_of_dos_is_no_row_of_a_table() {
    for end in ["\u{1a}", "\n\u{1a}", "\r\n\u{1a}\r\n", "\n\0\0\0"] {
        let file = OneFile::new("table.csv", format!("a,b\n1,2\n3,4\n5,6{end}"));
        let inspected = inspect(&file);
        assert_eq!(inspected.code, Some(0), "{end:?}: {inspected:?}");
        assert_eq!(inspected.items("arrays")[1]["shape"][0], 3, "{inspected:?}");
    }
}
