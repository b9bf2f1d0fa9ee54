//! Complex numbers in text tables, as NumPy, MATLAB, LabVIEW, Fortran and C++ write them.

use num_complex::Complex64;

use super::inspected::inspect;
use super::universal_file::{
    LINES, OneFile, even_lines, finds_the_mode, noisy_accelerance, on_file,
};

/// A notation of complex numbers.
type Notation = fn(Complex64) -> String;

const NUMPY: Notation = |value| format!(" ({:.18e}{:+.18e}j)", value.re, value.im);

const NOTATIONS: [Notation; 11] = [
    NUMPY,
    |value| format!("({:e}+{:e}j)", value.re, value.im),
    |value| format!("{:e}{:+e}j", value.re, value.im),
    |value| format!("{:.4} {} {:.4}i", value.re, sign(value.im), value.im.abs()),
    |value| format!("{:.4}{:+.4}i", value.re, value.im),
    |value| format!("{:.6e} + {:.6e}*1i", value.re, value.im),
    |value| format!("{:.6e} + {:.6e}*i", value.re, value.im),
    |value| format!("{:.6E} {:+.6E} i", value.re, value.im),
    |value| format!("({:.6E},{:.6E})", value.re, value.im),
    |value| format!("{:.6e}{:+.6e}J", value.re, value.im),
    |value| format!("{:.6}{:+.6}*j", value.re, value.im),
];

fn sign(number: f64) -> char {
    if number < 0.0 { '-' } else { '+' }
}

fn values(seed: u64) -> Vec<Complex64> {
    noisy_accelerance(&even_lines(), 1.0, seed)
}

/// Kinds and lengths of the arrays of a table, as `inspect` lists them.
fn arrays(text: &str) -> Vec<(String, u64)> {
    let file = OneFile::new("h.txt", text);
    let inspected = inspect(&file);
    assert_eq!(inspected.code, Some(0), "{text}: {inspected:?}");
    let arrays = inspected.items("arrays").iter();
    let listed = arrays.map(|array| {
        let kind = array["kind"].as_str().unwrap().to_owned();
        (kind, array["shape"][0].as_u64().unwrap())
    });
    listed.collect()
}

#[test]
fn one_column_of_complex_numbers_is_one_complex_array() {
    for (index, notation) in NOTATIONS.iter().enumerate() {
        let rows = values(1).into_iter().map(|value| notation(value) + "\n");
        let found = arrays(&rows.collect::<String>());
        assert_eq!(found, [("complex f64".to_owned(), LINES as u64)], "{index}");
    }
}

#[test]
fn complex_columns_stand_beside_real_ones_with_every_separator() {
    for (index, notation) in NOTATIONS.iter().enumerate() {
        for separator in [" ", "   ", ",", ", ", "\t", ";"] {
            let rows = even_lines().into_iter().zip(values(1)).zip(values(2));
            let rows = rows.map(|((frequency, one), two)| {
                [
                    format!("{frequency}"),
                    notation(one),
                    format!("{}", frequency / 3.0),
                    notation(two),
                ]
                .join(separator)
                    + "\n"
            });
            let rows: String = rows.collect();
            let kinds: Vec<String> = arrays(&rows).into_iter().map(|(kind, _)| kind).collect();
            let expected = ["f64", "complex f64", "f64", "complex f64"];
            assert_eq!(kinds, expected, "{index} {separator:?}");
        }
    }
}

#[test]
fn a_complex_column_with_a_missing_or_real_value_stays_complex() {
    let text = |odd: &str| {
        let rows = values(1)
            .into_iter()
            .enumerate()
            .map(|(row, value)| match row {
                0 => format!("{odd}\n"),
                _ => NUMPY(value) + "\n",
            });
        rows.collect::<String>()
    };
    for odd in [
        "(nan+nanj)",
        "(inf-infj)",
        "0",
        " (0e+00+0e+00j)",
        "NaN",
        "2.5j",
    ] {
        assert_eq!(
            arrays(&text(odd)),
            [("complex f64".to_owned(), LINES as u64)],
            "{odd}"
        );
    }
}

/// A scene whose FRFs are the complex columns 2 and 3 of a table.
fn scene(delimiter: &str) -> String {
    let column = |number: usize, role: &str, rest: &str| {
        format!("[[test.channel]]\ncolumn = {number}\nrole = \"{role}\"\n{rest}")
    };
    let frf = |point: usize| format!("dof = \"{point}:+Z\"\nunit = \"(m/s2)/N\"\n");
    [
        "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"t\"\nfiles = [\"h.txt\"]\n".to_owned(),
        format!("delimiter = \"{delimiter}\"\n"),
        "[[test.file]]\npath = \"h.txt\"\nreference = \"1:+Z\"\n".to_owned(),
        column(1, "frequency", ""),
        column(2, "complex", &frf(1)),
        column(3, "complex", &frf(2)),
    ]
    .concat()
}

#[test]
fn the_frfs_of_complex_columns_show_the_mode() {
    for (delimiter, separator) in [
        ("blank", " "),
        ("comma", ", "),
        ("semicolon", ";"),
        ("tab", "\t"),
    ] {
        let rows = even_lines().into_iter().zip(values(1)).zip(values(2));
        // NumPy prints a table with one complex column as complex numbers throughout.
        let rows = rows.map(|((frequency, one), two)| {
            let frequency = Complex64::from(frequency);
            [frequency, one, two].map(NUMPY).join(separator) + "\n"
        });
        let file = OneFile::new("h.txt", rows.collect::<String>());
        std::fs::write(file.folder().join("scene.toml"), scene(delimiter)).unwrap();
        let frfs = file.folder().join("frfs.uff");
        let options = ["-o", frfs.to_str().unwrap()];
        let converted = on_file("convert", file.folder(), &options);
        assert_eq!(converted.code, Some(0), "{converted:?}");
        finds_the_mode(&frfs, &[]);
    }
}
