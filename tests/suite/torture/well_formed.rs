//! Odd but readable files: expected values to the bit, no error.

use super::build::{
    Binary, binary, changed, doubles, header, lines, rows, singles, survivor, text, uneven,
};
use super::{converted, deliver};

struct Case {
    what: &'static str,
    bytes: Vec<u8>,
    values: Vec<f64>,
    /// First and last abscissa, where it is not 0, 1 ms, 2 ms, ...
    ends: Option<(f64, f64)>,
}

fn case(what: &'static str, bytes: Vec<u8>, values: &[f64]) -> Case {
    Case {
        what,
        bytes,
        values: values.to_vec(),
        ends: None,
    }
}

fn over(what: &'static str, bytes: Vec<u8>, values: &[f64], ends: (f64, f64)) -> Case {
    Case {
        ends: Some(ends),
        ..case(what, bytes, values)
    }
}

const FOUR: [f64; 4] = [1.0, -2.0, 0.5, 1.5];

fn text_cases() -> Vec<Case> {
    let plain = header("test", 4, 4);
    let all = ["1.0 -2.0 0.5 1.5"];
    let long = format!("1.0 -2.0{}0.5 1.5", " ".repeat(70_000));
    let wide = format!("{}\n", vec!["1.25"; 40_000].join(" "));
    let huge = vec![1.25; 40_000];
    vec![
        case("one row", rows(4, 4, &all), &FOUR),
        case("CRLF", text(&plain, &all, "\r\n"), &FOUR),
        case("CR CR LF", text(&plain, &all, "\r\r\n"), &FOUR),
        case(
            "a number to a row",
            rows(4, 4, &["1.0", "-2.0", "0.5", "1.5"]),
            &FOUR,
        ),
        case(
            "a short last row",
            rows(2, 4, &["1.0 -2.0 0.5", "1.5"]),
            &FOUR,
        ),
        case(
            "blank lines between rows",
            rows(2, 4, &["1.0 -2.0", "", "   ", "0.5 1.5"]),
            &FOUR,
        ),
        case(
            "zeros that fill the last row",
            rows(2, 4, &["1.0 -2.0 0.5 1.5 0.0 0.0"]),
            &FOUR,
        ),
        case(
            "blanks behind a row",
            rows(2, 4, &["1.0 -2.0 0.5 1.5          "]),
            &FOUR,
        ),
        case("tabulators", rows(2, 4, &["\t1.0\t-2.0\t0.5\t1.5"]), &FOUR),
        case(
            "D exponents",
            rows(4, 4, &["1.0D+00 -2.0d0 5.0D-01 15.D-1"]),
            &FOUR,
        ),
        case(
            "three-digit exponents",
            rows(4, 4, &["1.0E+000 -2.0E+000 5.0E-001 1.5E+000"]),
            &FOUR,
        ),
        case(
            "exponents without a letter",
            rows(4, 4, &["1.0+000 -2.0+000 0.05+001 1.5-000"]),
            &FOUR,
        ),
        case(
            "numbers that touch by their signs",
            rows(2, 4, &["1.0E+00-2.0E+00+5.0E-01 1.5"]),
            &FOUR,
        ),
        case(
            "full columns of thirteen",
            rows(
                2,
                4,
                &[" 1.00000E+000-2.00000E+0005.000000E-0011.500000E+000"],
            ),
            &FOUR,
        ),
        case("whole numbers", rows(2, 2, &["1 -2"]), &[1.0, -2.0]),
        case(
            "a denormal and a zero",
            rows(4, 2, &["4.9E-324 -0.0"]),
            &[5e-324, -0.0],
        ),
        case("a row of 70 kB", rows(4, 4, &[&long]), &FOUR),
        case(
            "a row of 200 kB",
            rows(4, 40_000, &[wide.trim_end()]),
            &huge,
        ),
        case("nothing", rows(4, 0, &[]), &[]),
        case(
            "a minus one among the data",
            rows(2, 2, &["-1 2"]),
            &[-1.0, 2.0],
        ),
        case(
            "delimiters in ID lines",
            text(&changed(plain.clone(), 3, "    -1"), &all, "\n"),
            &FOUR,
        ),
        case(
            "a dataset number in an ID line",
            text(&changed(plain.clone(), 3, "    58"), &all, "\n"),
            &FOUR,
        ),
        case("complex, 64 bits", rows(6, 2, &all), &FOUR),
        case("complex, 32 bits", rows(5, 2, &all), &FOUR),
        case(
            "fields of record 6 off their columns",
            text(
                &changed(plain.clone(), 6, "1 0 1 1 NONE 12 -3 NONE 4 1"),
                &all,
                "\n",
            ),
            &FOUR,
        ),
        case(
            "record 7 without trailing fields",
            text(
                &changed(
                    plain.clone(),
                    7,
                    "         4         4         1  0.00000E+00  1.00000E-03",
                ),
                &all,
                "\n",
            ),
            &FOUR,
        ),
        case(
            "delimiter with blanks behind it",
            [b"    -1    \n".to_vec(), rows(4, 4, &all)[7..].to_vec()].concat(),
            &FOUR,
        ),
        case(
            "blank lines before the first delimiter",
            [b"\n  \n".to_vec(), rows(4, 4, &all)].concat(),
            &FOUR,
        ),
        case(
            "no line end behind the last delimiter",
            trimmed(rows(4, 4, &all), 1),
            &FOUR,
        ),
        case("no last delimiter", trimmed(rows(4, 4, &all), 7), &FOUR),
        case("half a last delimiter", trimmed(rows(4, 4, &all), 2), &FOUR),
    ]
}

fn trimmed(mut bytes: Vec<u8>, lost: usize) -> Vec<u8> {
    bytes.truncate(bytes.len() - lost);
    bytes
}

fn binary_cases() -> Vec<Case> {
    let f32s = singles(&[1.0, -2.0, 0.5, 1.5], true);
    let f64s = doubles(&FOUR, true);
    let form = Binary::default();
    let head = |data_type, points| header("test", data_type, points);
    let counted = |count| Binary {
        count: Some(count),
        ..form
    };
    let tail = |tail| Binary { tail, ..form };
    let big = Binary { order: 2, ..form };
    let marks = b"\n    -1\n    58\n    -1\n  -1\n  -1\n";
    let marks_f32: Vec<f64> = marks
        .as_chunks::<4>()
        .0
        .iter()
        .map(|bytes| f64::from(f32::from_le_bytes(*bytes)))
        .collect();
    vec![
        case("real, 32 bits", binary(&head(2, 4), &f32s, form), &FOUR),
        case("real, 64 bits", binary(&head(4, 4), &f64s, form), &FOUR),
        case("complex, 32 bits", binary(&head(5, 2), &f32s, form), &FOUR),
        case("complex, 64 bits", binary(&head(6, 2), &f64s, form), &FOUR),
        case(
            "big endian, 32 bits",
            binary(&head(2, 4), &singles(&[1.0, -2.0, 0.5, 1.5], false), big),
            &FOUR,
        ),
        case(
            "big endian, 64 bits",
            binary(&head(6, 2), &doubles(&FOUR, false), big),
            &FOUR,
        ),
        case(
            "CRLF in the header",
            binary(
                &head(2, 4),
                &f32s,
                Binary {
                    end: "\r\n",
                    ..form
                },
            ),
            &FOUR,
        ),
        case(
            "LF before the delimiter",
            binary(&head(2, 4), &f32s, tail("\n    -1\n")),
            &FOUR,
        ),
        case(
            "CRLF before the delimiter",
            binary(&head(2, 4), &f32s, tail("\r\n    -1\r\n")),
            &FOUR,
        ),
        case(
            "CR CR LF before the delimiter",
            binary(&head(2, 4), &f32s, tail("\r\r\n    -1\r\r\n")),
            &FOUR,
        ),
        case(
            "a delimiter of 80 columns",
            binary(&head(2, 4), &f32s, tail(PADDED)),
            &FOUR,
        ),
        case(
            "no delimiter at the end",
            binary(&head(2, 4), &f32s, tail("")),
            &FOUR,
        ),
        case(
            "byte count zero",
            binary(&head(2, 4), &f32s, counted(0)),
            &FOUR,
        ),
        case(
            "byte count halved",
            binary(&head(6, 2), &f64s, counted(16)),
            &FOUR,
        ),
        case(
            "byte count doubled",
            binary(&head(2, 4), &f32s, counted(32)),
            &FOUR,
        ),
        case(
            "byte count beyond the file",
            binary(&head(2, 4), &f32s, counted(999_999_999_999)),
            &FOUR,
        ),
        case(
            "points zero, byte count right",
            binary(&head(2, 0), &f32s, form),
            &FOUR,
        ),
        case(
            "points wrong, byte count right",
            binary(&head(2, 5), &f32s, form),
            &FOUR,
        ),
        case(
            "delimiters in the block",
            binary(&head(2, 8), marks, form),
            &marks_f32,
        ),
        case(
            "delimiters in ID lines",
            binary(&changed(head(2, 4), 2, "    -1"), &f32s, form),
            &FOUR,
        ),
        case(
            "NaN and infinity",
            binary(&head(2, 1), &singles(&[f32::INFINITY], true), form),
            &[f64::INFINITY],
        ),
        case("nothing", binary(&head(2, 0), &[], form), &[]),
    ]
}

const PADDED: &str =
    "    -1                                                                          \n";

fn axis_cases() -> Vec<Case> {
    let record_7 = |text: &str| text_with(7, text);
    let pairs = ["0.0 1.0 100.5 -2.0", "250.25 0.5 300.0 1.5"];
    let ends = (0.0, 300.0);
    let numbers = [0.0, 1.0, 100.5, -2.0, 250.25, 0.5, 300.0, 1.5];
    let narrow: Vec<f32> = numbers.iter().map(|v| *v as f32).collect();
    let uneven_text = |data_type| text(&uneven(data_type, 4, 19, "rpm"), &pairs, "\n");
    let form = Binary::default();
    let threes = ["0.0 1.0 -2.0", "300.0 0.5 1.5"];
    let grid = ["0.0 1.0 0.25 -2.0", "0.5 0.5 0.75 1.5"];
    let mixed: Vec<u8> = numbers
        .as_chunks::<2>()
        .0
        .iter()
        .flat_map(|[x, y]| [singles(&[*x as f32], true), doubles(&[*y], true)].concat())
        .collect();
    vec![
        over("uneven rpm, 32 bits", uneven_text(2), &FOUR, ends),
        over("uneven rpm, 64 bits", uneven_text(4), &FOUR, ends),
        over(
            "uneven complex",
            text(&uneven(6, 2, 20, "order"), &threes, "\n"),
            &FOUR,
            ends,
        ),
        over(
            "uneven 58b, 32 bits",
            binary(&uneven(2, 4, 19, "rpm"), &singles(&narrow, true), form),
            &FOUR,
            ends,
        ),
        over(
            "uneven 58b, 64 bits",
            binary(&uneven(4, 4, 19, "rpm"), &doubles(&numbers, true), form),
            &FOUR,
            ends,
        ),
        over(
            "uneven 58b, abscissa of 32 bits",
            binary(&uneven(4, 4, 19, "rpm"), &mixed, form),
            &FOUR,
            ends,
        ),
        over(
            "uneven on a grid",
            text(&uneven(4, 4, 18, "Hz"), &grid, "\n"),
            &FOUR,
            (0.0, 0.75),
        ),
        over(
            "uneven in milliseconds",
            text(&uneven(4, 4, 17, "ms"), &grid, "\n"),
            &FOUR,
            (0.0, 0.75e-3),
        ),
        over(
            "a step below zero",
            record_7("4 4 1 3.0 -1.0 0.0"),
            &FOUR,
            (3.0, 0.0),
        ),
        over("one point without a step", one_point(), &[1.0], (3.0, 3.0)),
        over(
            "frequency in kHz",
            text_with(8, "        18    0    0    0 Frequency            kHz"),
            &FOUR,
            (0.0, 3.0),
        ),
        over(
            "rotational speed",
            text_with(8, "        19    0    0    0 Speed                rpm"),
            &FOUR,
            (0.0, 0.003),
        ),
        over(
            "a step printed short",
            record_7("4 4 1 0.0 1.95313E-05 0.0"),
            &FOUR,
            (0.0, 3.0 / 51_200.0),
        ),
    ]
}

fn text_with(line: usize, record: &str) -> Vec<u8> {
    text(
        &changed(header("test", 4, 4), line, record),
        &["1.0 -2.0 0.5 1.5"],
        "\n",
    )
}

fn one_point() -> Vec<u8> {
    text(
        &changed(header("test", 4, 1), 7, "4 1 1 3.0 0.0 0.0"),
        &["1.0"],
        "\n",
    )
}

#[test]
fn odd_files_deliver_their_values() {
    let cases = [text_cases(), binary_cases(), axis_cases()].concat_cases();
    assert!(cases.len() >= 60, "{}", cases.len());
    for Case {
        what,
        bytes,
        values,
        ends,
    } in cases
    {
        let (written, code) = converted(&bytes);
        let (delivered, errors) = deliver(bytes);
        assert_eq!(errors, [""; 0], "{what}");
        assert_eq!((code, &written), (Some(0), &delivered), "{what}");
        assert_eq!(delivered.len(), 1, "{what}");
        assert_eq!(delivered[0].name, "test", "{what}");
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
        assert_eq!(bits(&delivered[0].values), bits(&values), "{what}");
        if let Some((first, last)) = ends {
            let got = delivered[0]
                .ends
                .unwrap_or_else(|| panic!("{what}: no abscissa"));
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-15 * b.abs();
            assert!(near(got.0, first) && near(got.1, last), "{what}: {got:?}");
        }
    }
}

trait ConcatCases {
    fn concat_cases(self) -> Vec<Case>;
}

impl<const N: usize> ConcatCases for [Vec<Case>; N] {
    fn concat_cases(self) -> Vec<Case> {
        self.into_iter().flatten().collect()
    }
}

#[test]
fn an_unclosed_text_hides_nothing_behind_it() {
    let unclosed = trimmed(rows(4, 4, &["1.0 -2.0 0.5 1.5"]), 7);
    let (delivered, errors) = deliver([unclosed, survivor()].concat());
    let names: Vec<&str> = delivered
        .iter()
        .map(|function| function.name.as_str())
        .collect();
    assert_eq!((names, errors.len()), (vec!["test", "survivor"], 0));
}

#[test]
fn a_latin_1_byte_in_a_header_changes_no_value() {
    let mut bytes = rows(4, 1, &["1.0"]);
    let at = bytes
        .windows(4)
        .position(|w| w == b"m/s2")
        .unwrap_or_default()
        + 3;
    bytes[at] = 0xB2;
    let title = lines(&["    -1", "   151", "a title", "    -1"], "\n");
    let (delivered, errors) = deliver([title, bytes].concat());
    assert_eq!(
        (delivered[0].values.as_slice(), errors.len()),
        (&[1.0][..], 0)
    );
}
