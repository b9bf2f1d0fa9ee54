//! Texts that C and Fortran libraries print for values that are no finite numbers.

use super::inspected::inspect;
use super::universal_file::{Function, OneFile, accelerances, file_of, finds_the_mode, on_file};

/// What the libraries print.
const NO_NUMBERS: [&str; 16] = [
    "-1.#IND0E+00",
    "1.#QNAN0E+00",
    "1.#QNAN",
    "1.#SNAN0",
    "1.#INF",
    "-1.#INF0E+000",
    "-1.#J",
    "1.#IO",
    "-nan(ind)",
    "nan(snan)",
    "-nan",
    "NaN",
    "NaNQ",
    "inf",
    "-Infinity",
    "+Inf",
];

/// The file with this text as the first value of each function, in 13 columns where it fits.
fn with_first_value(text: &str) -> String {
    let replaced = |function: &Function| {
        let mut lines = function.lines();
        let row = lines[13].clone();
        lines[13] = format!("{text:>13}{text:>13}{}", &row[26..]);
        lines.join("\n") + "\n"
    };
    accelerances().iter().map(replaced).collect()
}

#[test]
fn a_missing_first_line_costs_that_line_alone_however_it_is_printed() {
    for text in NO_NUMBERS {
        let file = OneFile::new("missing.uff", with_first_value(text));
        let ran = finds_the_mode(&file.path(), &[]);
        assert_eq!(ran.code, Some(0), "{text}: {ran:?}");
    }
}

#[test]
fn a_missing_value_inside_the_band_is_named_however_it_is_printed() {
    let whole = file_of(&accelerances());
    for text in NO_NUMBERS {
        let mut lines: Vec<String> = whole.lines().map(str::to_owned).collect();
        let row = lines[33].clone();
        lines[33] = format!("{}{text:>13}{}", &row[..26], &row[39..]);
        let file = OneFile::new("missing.uff", lines.join("\n") + "\n");
        let ran = on_file("identify", &file.path(), &[]);
        assert_eq!(ran.code, Some(2), "{text}: {ran:?}");
        assert!(
            ran.error.contains("expected a finite value"),
            "{text}: {ran:?}"
        );
    }
}

#[test]
fn a_table_with_values_that_are_no_numbers_is_listed_whole() {
    for text in NO_NUMBERS {
        let rows = (0..20).map(|row| format!("{},{text},{}\n", row, 0.5 * f64::from(row)));
        let table = format!("f,a,b\n{}", rows.collect::<String>());
        let file = OneFile::new("table.csv", table);
        let inspected = inspect(&file);
        assert_eq!(inspected.code, Some(0), "{text}: {inspected:?}");
        let arrays = inspected.items("arrays").iter();
        let kinds: Vec<&str> = arrays
            .map(|array| array["kind"].as_str().unwrap())
            .collect();
        assert_eq!(kinds, ["f64"; 3], "{text}: {inspected:?}");
    }
}
