//! Functions of every type and abscissa.

use num_complex::Complex64;

use super::file_builder::{Form, all, binary_58, dataset, doubles, header, open, singles, text_58};
use super::write::{abscissa, general, written};
use crate::axis::TimeAxis;
use crate::finding::Code;
use crate::io::{Block, Domain, Encoding, EntryAxis, FunctionType, GeneralAxis, Window};

/// A header with an uneven abscissa of a type and unit.
fn uneven(data_type: i32, points: u64, code: i32, unit: &str) -> Vec<String> {
    let mut head = header(data_type, points);
    head[6] =
        format!("{data_type:>10}{points:>10}         0  0.00000E+00  0.00000E+00  0.00000E+00");
    head[7] = format!("{code:>10}    0    0    0 Label                {unit:<20}");
    head
}

#[test]
fn every_function_type_is_kept() {
    for code in (0..=27).chain([99, -7]) {
        let mut head = header(2, 1);
        head[5].replace_range(..5, &format!("{code:>5}"));
        let mut source = open(text_58(&head, &["1.5"], "\n")).expect("a universal file");
        let entry = &source.catalog().entries[0];
        assert_eq!(entry.function_type, FunctionType::from_code(code));
        assert_eq!(
            all(source.as_mut(), 0).expect("the values of the first function"),
            Block::F64(vec![1.5])
        );
        let (bytes, _) = written(source.as_mut(), Encoding::Binary, None)
            .expect("functions that the format holds");
        let again = open(bytes).expect("a universal file");
        assert_eq!(again.catalog().entries[0].function_type.code(), Some(code));
    }
}

#[test]
fn uneven_abscissae_are_read_in_every_form() {
    let x = [0.0, 100.5, 250.25];
    let real = Block::F64(vec![1.0, 2.0, 3.0]);
    let complex = Block::Complex(vec![
        Complex64::new(1.0, -1.0),
        Complex64::new(2.0, -2.0),
        Complex64::new(3.0, -3.0),
    ]);
    let text_real = ["0.0 1.0 1.005E+02 2.0", "2.5025E+02 3.0"];
    let text_complex = ["0.0 1.0 -1.0 1.005E+02 2.0-2.0", "2.5025E+02 3.0 -3.0"];
    let head = |data_type| uneven(data_type, 3, 19, "rpm");
    let pairs = [0.0, 1.0, 100.5, 2.0, 250.25, 3.0];
    let threes = [0.0, 1.0, -1.0, 100.5, 2.0, -2.0, 250.25, 3.0, -3.0];
    let narrow = |all: &[f64]| all.iter().map(|v| *v as f32).collect::<Vec<f32>>();
    let mut files = vec![
        (text_58(&head(2), &text_real, "\n"), real.clone()),
        (text_58(&head(4), &text_real, "\r\n"), real.clone()),
        (text_58(&head(5), &text_complex, "\n"), complex.clone()),
        (text_58(&head(6), &text_complex, "\n"), complex.clone()),
    ];
    for little in [true, false] {
        let form = Form {
            little_endian: little,
            ..Form::default()
        };
        let mixed: Vec<u8> = pairs
            .chunks(2)
            .flat_map(|pair| {
                [
                    singles(&[pair[0] as f32], little),
                    doubles(&pair[1..], little),
                ]
                .concat()
            })
            .collect();
        let f32_real = Block::F32(vec![1.0, 2.0, 3.0]);
        files.extend([
            (
                binary_58(&head(2), &singles(&narrow(&pairs), little), form),
                f32_real,
            ),
            (
                binary_58(&head(4), &doubles(&pairs, little), form),
                real.clone(),
            ),
            (binary_58(&head(4), &mixed, form), real.clone()),
            (
                binary_58(&head(5), &singles(&narrow(&threes), little), form),
                complex.clone(),
            ),
            (
                binary_58(&head(6), &doubles(&threes, little), form),
                complex.clone(),
            ),
        ]);
    }
    for (i, (bytes, expected)) in files.into_iter().enumerate() {
        let mut source = open(bytes).expect("a universal file");
        let catalog = source.catalog();
        assert!(catalog.damage.is_empty(), "{i}: {:?}", catalog.damage);
        assert_eq!(
            catalog.entries[0].axis,
            general(Domain::Other(19), 3),
            "{i}"
        );
        assert_eq!(catalog.entries[0].axis_label, "rpm");
        assert_eq!(
            catalog.findings.last().map(|f| f.code),
            Some(Code::UnevenAxis)
        );
        assert_eq!(
            all(source.as_mut(), 0).expect("the values of the first function"),
            expected,
            "{i}"
        );
        assert_eq!(abscissa(source.as_mut(), 0), x, "{i}");
        let mut part = Vec::new();
        source
            .abscissa(0, 1..2, &mut part)
            .expect("the second abscissa");
        assert_eq!(part, [100.5]);
    }
}

#[test]
fn an_uneven_abscissa_on_a_grid_is_an_even_axis() {
    let mut rows: Vec<String> = (0..2_000)
        .map(|i| {
            format!(
                "{:13.5E}{:13.5E}",
                -0.01 + f64::from(i) / 51_200.0 * 1.0,
                f64::from(i)
            )
        })
        .collect();
    let text: Vec<&str> = rows.iter().map(String::as_str).collect();
    let mut source =
        open(text_58(&uneven(2, 2_000, 17, "s"), &text, "\n")).expect("a universal file");
    let expected = TimeAxis {
        start_s: -0.01,
        step_s: 1.0 / 51_200.0,
        len: 2_000,
    };
    assert_eq!(source.catalog().entries[0].axis, EntryAxis::Time(expected));
    assert_eq!(abscissa(source.as_mut(), 0)[..1], [-0.01]);
    let Block::F64(values) = all(source.as_mut(), 0).expect("the values of the first function")
    else {
        panic!("text is read in double precision")
    };
    assert_eq!((values.len(), values[39]), (2_000, 39.0));
    rows[20] = format!("{:13.5E}{:13.5E}", -0.01 + 20.1 / 51_200.0, 20.0);
    let text: Vec<&str> = rows.iter().map(String::as_str).collect();
    let mut source =
        open(text_58(&uneven(2, 2_000, 17, "ms"), &text, "\n")).expect("a universal file");
    assert_eq!(
        source.catalog().entries[0].axis,
        general(Domain::Time, 2_000)
    );
    assert_eq!(abscissa(source.as_mut(), 0)[..1], [-0.01 * 1e-3]);
}

/// The axis and its label of three values at 0, 2 and 4 of a unit, and the codes of the findings.
fn axis_of(code: i32, unit: &str) -> (EntryAxis, String, Vec<Code>, Vec<f64>) {
    let mut lines = header(4, 3);
    lines[6] = "         4         3         1  0.00000E+00  2.00000E+00  0.00000E+00".to_owned();
    lines[7] = format!("{code:>10}    0    0    0 NONE                 {unit:<20}");
    let mut source = open(text_58(&lines, &["1. 2. 3."], "\n")).expect("a universal file");
    let (entry, x) = (
        source.catalog().entries[0].clone(),
        abscissa(source.as_mut(), 0),
    );
    let codes = source.catalog().findings.iter().map(|f| f.code).collect();
    (entry.axis, entry.axis_label, codes, x)
}

#[test]
fn the_unit_of_an_abscissa_is_known_or_nothing_is_guessed() {
    for (code, unit, scale) in [
        (17, "s", 1.0),
        (17, "NONE", 1.0),
        (17, "(sec)", 1.0),
        (17, "ms", 1e-3),
        (17, "msec", 1e-3),
        (17, "usec", 1e-6),
        (17, "\u{b5}s", 1e-6),
        (17, "\u{3bc}s", 1e-6),
        (17, "min", 60.0),
        (1, "msec", 1e-3),
        (18, "Hz", 1.0),
        (18, "HZ", 1.0),
        (18, "kHz", 1e3),
        (18, "MHz", 1e6),
        (18, "mHz", 1e-3),
        (18, "rad/s", 1.0 / std::f64::consts::TAU),
        (18, "rpm", 1.0 / 60.0),
        (18, "CPM", 1.0 / 60.0),
        (0, "kHz", 1e3),
    ] {
        let (axis, label, codes, x) = axis_of(code, unit);
        assert!(
            (x[1] / (2.0 * scale) - 1.0).abs() < 1e-12,
            "{code} {unit}: {x:?}"
        );
        let time = code == 17 || unit == "msec";
        let (domain, expected) = match time {
            true => (Domain::Time, "s"),
            false => (Domain::Frequency, "Hz"),
        };
        assert_eq!(axis.domain(), domain, "{code} {unit}");
        assert_eq!(label, expected, "{unit}: the label of what is delivered");
        assert_eq!(codes, [], "{unit}");
    }
    for (code, unit) in [
        (17, "fortnight"),
        (17, "Hz"),
        (18, "s"),
        (18, "MHZ"),
        (18, "orders"),
    ] {
        let (axis, label, codes, x) = axis_of(code, unit);
        let even = Some((0.0, 2.0));
        let (domain, len) = (Domain::Other(code), 3);
        assert_eq!(
            axis,
            EntryAxis::General(GeneralAxis { domain, even, len }),
            "{unit}"
        );
        assert_eq!((label.as_str(), x), (unit, vec![0.0, 2.0, 4.0]));
        assert_eq!(codes, [Code::AxisUnitUnknown], "{unit}");
    }
}

#[test]
fn qualifiers_belong_to_the_function_beside_them() {
    let function = text_58(&header(2, 1), &["1.5"], "\n");
    let bad = text_58(&header(3, 1), &["1.5"], "\n");
    let window = |code: i32| {
        let types = format!("{:6}{code:6}{}", 1, "     0".repeat(10));
        dataset(&["  1858", "1 0 0 0 0 0", &types, "0. 0. 0. 0. 0."], "\n")
    };
    for (parts, expected) in [
        (
            vec![&function, &window(4), &function, &window(6)],
            vec![4, 6],
        ),
        (
            vec![&window(5), &function, &window(1), &function],
            vec![5, 1],
        ),
        (vec![&function, &bad, &window(4), &function], vec![0, 0]),
        (vec![&window(4), &bad, &function], vec![0]),
        (vec![&function, &window(0)], vec![0]),
    ] {
        let bytes: Vec<u8> = parts.into_iter().flatten().copied().collect();
        let source = open(bytes).expect("a universal file");
        let got: Vec<Option<Window>> = source
            .catalog()
            .entries
            .iter()
            .map(|e| e.note.window)
            .collect();
        let expected: Vec<_> = expected.into_iter().map(Window::from_code).collect();
        assert_eq!(got, expected);
    }
    let broken = dataset(&["  1858", "1", "x y"], "\n");
    let source = open([function, broken].concat()).expect("a universal file");
    let error = source.catalog().damage[0].to_string();
    assert!(
        error.starts_with("built.uff:19: qualifiers of dataset 1858"),
        "{error}"
    );
}
