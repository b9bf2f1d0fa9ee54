//! Small intact files of every format are the seeds of damaged ones, written by the library or made
//! of text here.

use std::io::{Cursor, Read};

use modalign::Dof;
use modalign::axis::{FrequencyAxis, TimeAxis};
use modalign::geometry::{Node, TraceLine};
use modalign::io::{
    Block, Domain, Encoding, Entry, EntryAxis, FORMATS, FunctionType, GeneralAxis, MemorySource,
    ModeEntry, SampleFormat, WriteOptions,
};
use modalign::linalg::Vector3;
use modalign::modal::{Mode, ModeShape, Scaling};
use num_complex::Complex64;

const H5PY: &[u8] = include_bytes!("../reference/h5py.h5.gz");
const LINKS: &[u8] = include_bytes!("../reference/links.h5.gz");
const MATLAB_73: &[u8] = include_bytes!("../reference/matlab73.mat.gz");
const NEWER: &[u8] = include_bytes!("../reference/newer.h5.gz");

fn dof(text: &str) -> Option<Dof> {
    Some(text.parse().unwrap())
}

/// A record, an FRF, its coherence, a function over an uneven axis, and nodes.
pub fn source() -> MemorySource {
    let mut source = MemorySource::default();
    let time = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 1e-3,
        len: 60,
    });
    let mut record = Entry::new(FunctionType::Time, time, SampleFormat::RealF32);
    (record.response, record.to_si) = (dof("1:+Z"), Some(1.0));
    let values = (0..60_u8).map(|i| f32::from(i).sin()).collect();
    source.push(record, Block::F32(values), Vec::new());
    let lines = EntryAxis::Frequency(FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.5,
        len: 33,
    });
    let mut frf = Entry::new(FunctionType::Frf, lines, SampleFormat::ComplexF64);
    (frf.response, frf.reference) = (dof("1:+Z"), dof("2:-X"));
    let values = (0..33_u8)
        .map(|i| Complex64::new(f64::from(i).cos(), 0.1))
        .collect();
    source.push(frf.clone(), Block::Complex(values), Vec::new());
    frf.function_type = FunctionType::Coherence;
    frf.format = SampleFormat::RealF64;
    source.push(frf, Block::F64(vec![0.5; 33]), Vec::new());
    let uneven = EntryAxis::General(GeneralAxis {
        domain: Domain::Frequency,
        even: None,
        len: 5,
    });
    let mut other = Entry::new(FunctionType::from_code(2), uneven, SampleFormat::RealF64);
    other.response = dof("3:+Y");
    let abscissa = vec![1.0, 2.0, 4.0, 8.0, 16.0];
    source.push(other, Block::F64(vec![1.5; 5]), abscissa);
    let geometry = &mut source.catalog.geometry;
    geometry
        .nodes
        .push(Node::new("1", Vector3::new(0.1, 0.2, 0.3)));
    geometry
        .nodes
        .push(Node::new("2", Vector3::new(-0.1, 0.0, 1e3)));
    let points = ["1", "2"].map(|point| Some(point.to_owned())).to_vec();
    geometry.lines.push(TraceLine {
        name: "frame".to_owned(),
        points,
    });
    source.catalog.title = vec!["A machine".to_owned()];
    let shape = ModeShape::new([("1:+Z".parse().unwrap(), Complex64::new(1.0, 0.1))]);
    let mode = Mode::new(12.5, Some(0.01), shape, Scaling::UnitMax);
    source.catalog.modes.push(ModeEntry::new(mode));
    source
}

/// The source as this format writes it; nothing for a format that is only read.
fn written(format: &str, encoding: Encoding) -> Option<Vec<u8>> {
    let format = FORMATS
        .iter()
        .find(|candidate| candidate.name() == format)
        .unwrap();
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions {
        encoding,
        ..WriteOptions::default()
    };
    let write = format.write(&mut out, &mut source(), &options);
    write.ok().map(|_| out.into_inner())
}

/// A dataset of a universal file.
fn dataset(text: &str) -> String {
    format!("    -1\n{text}    -1\n")
}

/// The header of a record in a dataset 58.
fn header_58(number: &str, data_type: u8, points: u8) -> String {
    let none = "NONE\n".repeat(4);
    format!(
        "{number}\ntitle\n{none}    1         0    3         7 NONE              12  -3 NONE               4   1\n\
         {data_type:>10}{points:>10}         1  0.00000E+00  1.95313E-05  0.00000E+00\n\
         \x20       17    0    0    0 Time                 s                   \n\
         \x20       12    0    0    0 Acceleration         g                   \n\
         \x20        0    0    0    0 NONE                 NONE                \n\
         \x20        0    0    0    0 NONE                 NONE                \n"
    )
}

/// A dataset 58b of 200 samples.
fn binary_58() -> Vec<u8> {
    let block = (0..200_u8).flat_map(|i| f32::from(i).to_le_bytes());
    let first = "    58b     1     2          11         800     0     0           0           0";
    [
        format!("    -1\n{}", header_58(first, 2, 200)).into_bytes(),
        block.collect(),
        b"\n    -1\n".to_vec(),
    ]
    .concat()
}

/// Universal files in text.
pub fn text_uff() -> Vec<Vec<u8>> {
    let numbers = " 1.0000E+00-2.5000E+00 3.0000E+00 4.0000E+00 5.0000E+00 6.0000E+00\n".repeat(4);
    let text = [
        dataset("   151\nMachine\nNONE\n"),
        dataset(
            "   164\n         5SI: mm (newton)             2\n  1.00000D+03  1.00000D+00  1.00000D+00\n  2.73150D+02\n",
        ),
        dataset(
            "  2411\n         7         1         0         1\n  -1.5D+00   2.5D+00   3.5D+00\n",
        ),
        dataset(
            "    15\n         8         1         0         1  1.00000E+00  2.00000E+00  3.00000E+00\n",
        ),
        dataset("    82\n         1         3         8\nFrame\n         7         8         0\n"),
        dataset(
            "  2412\n         1        21         1         1         7         2\n         0         0         0\n         7         8\n",
        ),
        dataset(&format!(
            "    55\n{}         1         3         3         8         5         3\n         2         6         1         1\n  -1.5E+00   6.3E+01   1.0E+00   0.0E+00   1.0E+00   0.0E+00\n         7\n  1.00000E+00  0.0E+00 -2.00000E+00  1.0E-01  3.00000E+00  0.0E+00\n",
            "NONE\n".repeat(5)
        )),
        dataset(&format!(
            "  2414\n         1\nmodes\n         1\n{}         1         3         2         8         5         3\n         0         0         0         0         0         1         0         0\n         0         0\n  0.0E+00  0.0E+00  1.0E+02  1.0E+00  1.2E+00  1.0E-01\n  1.0E+00  1.0E+01  0.0E+00  0.0E+00  0.0E+00  0.0E+00\n         7\n  0.0E+00  0.0E+00  0.0E+00  0.0E+00  5.0E+00  6.0E+00\n",
            "NONE\n".repeat(5)
        )),
        dataset(&format!("{}{numbers}", header_58("    58", 2, 24))),
    ];
    vec![text.concat().into_bytes()]
}

/// Files joined as programs join them: ends of lines by carriage returns, the mark of the end of
/// DOS, marks of a byte order between the files, and no numbers.
pub fn joined_uff() -> Vec<Vec<u8>> {
    let text = text_uff().concat();
    let missing = "-1.#IND0E+00 nan(ind)  1.#QNAN  1.#INF   NaN\n1.0 2.0 3.0\n";
    let missing = dataset(&format!("{}{missing}", header_58("    58", 2, 8)));
    let old = text.iter().map(|byte| match byte {
        b'\n' => b'\r',
        byte => *byte,
    });
    let old: Vec<u8> = old.collect();
    vec![
        [&old[..], b"\x1a", &binary_58(), missing.as_bytes()].concat(),
        [
            &b"\xef\xbb\xbf"[..],
            missing.as_bytes(),
            b"\xef\xbb\xbf",
            &old,
        ]
        .concat(),
        [&binary_58()[..], b"\x1a\0\0", &text, missing.as_bytes()].concat(),
    ]
}

/// Universal files: what the library writes, and datasets that it reads alone.
pub fn uff() -> Vec<Vec<u8>> {
    let written_files = [Encoding::Binary, Encoding::Text].map(|encoding| written("uff", encoding));
    let text = String::from_utf8_lossy(&text_uff().concat()).into_owned();
    let utf_16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let seeds = [
        text.replace('\n', "\r").into_bytes(),
        text.replace("    -1\n    -1\n", "    -1    -1\n")
            .into_bytes(),
        text.into_bytes(),
        utf_16,
        binary_58(),
    ];
    let written_files = written_files.into_iter().flatten();
    seeds.into_iter().chain(written_files).collect()
}

/// Modes in JSON.
pub fn modes() -> Vec<Vec<u8>> {
    written("modes", Encoding::Text).into_iter().collect()
}

/// Modes as a table.
pub fn modes_csv() -> Vec<Vec<u8>> {
    written("modes-csv", Encoding::Text).into_iter().collect()
}

/// A matrix of doubles, row by row and column by column, as NumPy writes it.
pub fn npy() -> Vec<Vec<u8>> {
    let values: Vec<u8> = (0..120_u8)
        .flat_map(|i| f64::from(i).to_le_bytes())
        .collect();
    let file = |order: &str| {
        let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (60, 2), }}");
        let header = format!("{header:117}\n");
        [b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes(), &values].concat()
    };
    vec![file("False"), file("True")]
}

/// Records of a mark, padding and a structure of two numbers, in both orders.
pub fn structured_npy() -> Vec<Vec<u8>> {
    let records = (0..120_u8).flat_map(|i| {
        let numbers = [f64::from(i), 0.5].map(f64::to_be_bytes).concat();
        [vec![i], vec![0; 7], numbers].concat()
    });
    let records: Vec<u8> = records.collect();
    let file = |order: &str| {
        let description = "[('mark', '|u1'), ('', '|V7'), ('s', [('x', '>f8'), ('y', '>f8')])]";
        let header =
            format!("{{'descr': {description}, 'fortran_order': {order}, 'shape': (60, 2), }}\n");
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), &records].concat()
    };
    vec![file("False"), file("True")]
}

/// Everything as a NumPy archive.
pub fn npz() -> Vec<Vec<u8>> {
    written("npz", Encoding::Binary).into_iter().collect()
}

/// A structured array, an FRF with its frequency and a coherence, one after the other.
pub fn npz_members() -> Vec<Vec<u8>> {
    let [run, _] = structured_npy().try_into().unwrap();
    let columns = |kind: &str, value: fn(u8) -> Vec<f64>| {
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (30, 2), }}\n");
        let length = (header.len() as u16).to_le_bytes();
        let values = (0..30_u8).flat_map(value).flat_map(f64::to_le_bytes);
        let values: Vec<u8> = values.collect();
        [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), &values].concat()
    };
    let frf = columns("<c16", |line| vec![f64::from(line), 0.0, 0.5, 0.25]);
    let coherence = columns("<f8", |line| vec![f64::from(line), 0.75]);
    vec![[run.clone(), frf, coherence].concat(), run]
}

/// Everything as HDF5, and files of other programs, whose structure has no checksums.
pub fn hdf5() -> Vec<Vec<u8>> {
    let others = [H5PY, MATLAB_73, NEWER].map(unpacked);
    let written_file = written("hdf5", Encoding::Binary);
    written_file.into_iter().chain(others).collect()
}

/// What h5py writes, without checksums.
pub fn hdf5_of_h5py() -> Vec<Vec<u8>> {
    vec![unpacked(H5PY)]
}

/// Soft and external links in groups of every structure, without checksums in the oldest.
pub fn hdf5_of_links() -> Vec<Vec<u8>> {
    vec![unpacked(LINKS)]
}

/// What MATLAB writes.
pub fn hdf5_of_matlab() -> Vec<Vec<u8>> {
    vec![unpacked(MATLAB_73)]
}

/// A table as the library writes it.
pub fn table() -> Vec<Vec<u8>> {
    written("table", Encoding::Text).into_iter().collect()
}

/// A table that does not say what it is.
pub fn plain_table() -> Vec<Vec<u8>> {
    let rows = |mark: &str| {
        let rows = (0..80).map(|i| format!("{i}e-3{mark}-1.5E+01{mark}{}\n", i * i));
        let heading = ["force", "acceleration", "temperature"].join(mark);
        format!("{heading}\n{}", rows.collect::<String>()).into_bytes()
    };
    vec![rows(","), rows(";"), rows("\t")]
}

/// Complex numbers beside a frequency, as NumPy, MATLAB and Fortran write them.
pub fn complex_table() -> Vec<Vec<u8>> {
    let rows = |row: fn(u8) -> String| (0..80).map(row).collect::<String>().into_bytes();
    vec![
        rows(|i| format!("{i} ({i}.5e+00-{i}.25e-01j)\n")),
        rows(|i| format!("{i}, {i}.5 - {i}.25i\n")),
        rows(|i| format!("{i};({i}.5,-{i}.25)\n")),
    ]
}

/// Everything as MATLAB structs.
pub fn matlab5() -> Vec<Vec<u8>> {
    written("matlab5", Encoding::Binary).into_iter().collect()
}

/// A matrix of version 4; `kind` is 0 for numbers, 1 for text and 2 for a sparse matrix.
fn matlab4_matrix(
    big_endian: bool,
    kind: u32,
    lengths: [u32; 3],
    name: &str,
    values: &[f64],
) -> Vec<u8> {
    let word = |value: u32| match big_endian {
        true => value.to_be_bytes(),
        false => value.to_le_bytes(),
    };
    // The thousands digit is the order of the bytes.
    let kind = kind + 1000 * u32::from(big_endian);
    let [rows, columns, complex] = lengths;
    let header = [kind, rows, columns, complex, name.len() as u32 + 1].map(word);
    let numbers = values.iter().flat_map(|value| match big_endian {
        true => value.to_be_bytes(),
        false => value.to_le_bytes(),
    });
    let numbers: Vec<u8> = numbers.collect();
    [&header.concat(), name.as_bytes(), &[0], &numbers].concat()
}

/// A 40 x 2 array `a`, a text and a sparse matrix in version 4, in both orders of bytes.
pub fn matlab4() -> Vec<Vec<u8>> {
    let file = |big_endian: bool| {
        let matrix = |kind, [rows, columns]: [u32; 2], name, values: &[f64]| {
            matlab4_matrix(big_endian, kind, [rows, columns, 0], name, values)
        };
        let values: Vec<f64> = (0..80_u8).map(f64::from).collect();
        let sparse = [1.0, 3.0, 2.0, 4.0, 0.5, 0.0];
        [
            matrix(0, [40, 2], "a", &values),
            matrix(1, [2, 2], "t", &[97.0, 98.0, 99.0, 32.0]),
            matrix(2, [2, 3], "s", &sparse),
        ]
        .concat()
    };
    vec![file(false), file(true)]
}

/// Names, shapes, values and texts of the arrays of a SignalCalc file of two channels.
struct SignalCalcArrays {
    lines: Vec<f64>,
    times: Vec<f64>,
}

impl SignalCalcArrays {
    fn new() -> Self {
        Self {
            lines: (0..20_u8).map(|line| 0.5 * f64::from(line)).collect(),
            times: (0..32_u8).map(|n| (f64::from(n) - 4.0) / 64.0).collect(),
        }
    }

    /// Names with columns of real numbers.
    fn records(&self) -> Vec<(&'static str, Vec<f64>)> {
        let column = |axis: &[f64], value: fn(f64) -> f64| {
            let values = axis.iter().copied().map(value);
            axis.iter().copied().chain(values).collect()
        };
        vec![
            ("C1_2", column(&self.lines, |_| 0.75)),
            ("X1", column(&self.times, |time| (9.0 * time).sin() + 0.2)),
            ("W1", column(&self.times, |time| (9.0 * time).sin() + 0.2)),
            ("X2", column(&self.times, |time| (5.0 * time).cos())),
            (
                "W2",
                column(&self.times, |time| (5.0 * time).cos() * (-time).exp()),
            ),
        ]
    }

    /// Frequencies and real parts, then imaginary parts.
    fn frf(&self) -> [Vec<f64>; 2] {
        let zeros = vec![0.0; self.lines.len()];
        let real = [self.lines.clone(), vec![0.25; self.lines.len()]].concat();
        [real, [zeros, self.lines.clone()].concat()]
    }
}

/// Rows of texts.
const SIGNALCALC_TEXTS: [(&str, [&str; 2]); 3] = [
    ("ChanName", ["1:+Z", "2:+Z"]),
    ("Unit", ["N   ", "g   "]),
    ("DP_Info", ["Signal H1_2     ", "Real/Imag (g)(N)"]),
];

/// The characters of rows, column after column.
fn characters(rows: [&str; 2]) -> Vec<u8> {
    let columns = rows[0].bytes().zip(rows[1].bytes());
    columns.flat_map(|(a, b)| [a, b]).collect()
}

/// SignalCalc arrays in version 4, in both orders of bytes.
pub fn matlab4_signalcalc() -> Vec<Vec<u8>> {
    let file = |big_endian: bool| {
        let arrays = SignalCalcArrays::new();
        let mut file = matlab4_matrix(big_endian, 0, [2, 1, 0], "ChanNum", &[1.0, 2.0]);
        for (name, rows) in SIGNALCALC_TEXTS {
            let codes: Vec<f64> = characters(rows).into_iter().map(f64::from).collect();
            let lengths = [2, rows[0].len() as u32, 0];
            file.extend(matlab4_matrix(big_endian, 1, lengths, name, &codes));
        }
        for (name, values) in arrays.records() {
            let lengths = [values.len() as u32 / 2, 2, 0];
            file.extend(matlab4_matrix(big_endian, 0, lengths, name, &values));
        }
        let lengths = [arrays.lines.len() as u32, 2, 1];
        let frf = arrays.frf().concat();
        file.extend(matlab4_matrix(big_endian, 0, lengths, "H1_2", &frf));
        file
    };
    vec![file(false), file(true)]
}

/// A data element of version 5.
fn matlab5_element(kind: u32, content: &[u8]) -> Vec<u8> {
    let tag = [kind, content.len() as u32].map(u32::to_le_bytes).concat();
    let padding = vec![0; content.len().next_multiple_of(8) - content.len()];
    [&tag[..], content, &padding].concat()
}

/// A matrix of version 5 of two dimensions; the class holds the flags.
fn matlab5_matrix(class: u32, lengths: [u32; 2], name: &str, content: &[Vec<u8>]) -> Vec<u8> {
    let flags = [class, 0].map(u32::to_le_bytes).concat();
    let lengths = lengths.map(u32::to_le_bytes).concat();
    let parts = [
        matlab5_element(6, &flags),
        matlab5_element(5, &lengths),
        matlab5_element(1, name.as_bytes()),
        content.concat(),
    ];
    matlab5_element(14, &parts.concat())
}

fn matlab5_doubles(values: &[f64]) -> Vec<u8> {
    let bytes = values.iter().flat_map(|value| value.to_le_bytes());
    matlab5_element(9, &bytes.collect::<Vec<u8>>())
}

/// SignalCalc arrays as data elements of version 5.
pub fn matlab_signalcalc() -> Vec<Vec<u8>> {
    let arrays = SignalCalcArrays::new();
    let mut file = matlab5_matrix(6, [2, 1], "ChanNum", &[matlab5_doubles(&[1.0, 2.0])]);
    for (name, rows) in SIGNALCALC_TEXTS {
        let units: Vec<u8> = characters(rows).into_iter().flat_map(|c| [c, 0]).collect();
        let lengths = [2, rows[0].len() as u32];
        file.extend(matlab5_matrix(
            4,
            lengths,
            name,
            &[matlab5_element(4, &units)],
        ));
    }
    for (name, values) in arrays.records() {
        let lengths = [values.len() as u32 / 2, 2];
        file.extend(matlab5_matrix(
            6,
            lengths,
            name,
            &[matlab5_doubles(&values)],
        ));
    }
    let parts = arrays.frf().map(|part| matlab5_doubles(&part));
    let lengths = [arrays.lines.len() as u32, 2];
    file.extend(matlab5_matrix(6 | 0x800, lengths, "H1_2", &parts));
    vec![file]
}

/// A struct array `s` of two elements with a field `a` of cells and a struct `b`, and a sparse
/// matrix.
pub fn matlab_struct() -> Vec<Vec<u8>> {
    let names = |names: &[&str]| {
        let texts: Vec<u8> = names
            .iter()
            .flat_map(|name| format!("{name:\0<8}").into_bytes())
            .collect();
        [
            matlab5_element(5, &8_u32.to_le_bytes()),
            matlab5_element(1, &texts),
        ]
        .concat()
    };
    let text = |text: &str| {
        let units: Vec<u8> = text.bytes().flat_map(|c| [c, 0]).collect();
        matlab5_matrix(4, [1, text.len() as u32], "", &[matlab5_element(4, &units)])
    };
    let numbers = matlab5_matrix(6, [4, 2], "", &[matlab5_doubles(&[0.5; 8])]);
    let cells = matlab5_matrix(1, [1, 2], "", &[text("one"), text("more")]);
    let mixed = matlab5_matrix(1, [1, 2], "", &[text("one"), numbers.clone()]);
    let inner = matlab5_matrix(2, [1, 1], "", &[names(&["c", "d"]), numbers, cells]);
    let fields = [
        names(&["a", "b"]),
        mixed.clone(),
        inner.clone(),
        mixed,
        inner,
    ];
    let structure = matlab5_matrix(2, [1, 2], "s", &fields);
    let integers = |values: &[u32]| {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        matlab5_element(5, &bytes)
    };
    let content = [
        integers(&[0, 1]),
        integers(&[0, 1, 2]),
        matlab5_doubles(&[1.5, 2.5]),
    ];
    let sparse = matlab5_matrix(5, [2, 2], "k", &content);
    vec![[structure, sparse].concat()]
}

/// A 40 x 2 array `a`.
pub fn matlab_array() -> Vec<Vec<u8>> {
    let values: Vec<f64> = (0..80_u8).map(f64::from).collect();
    vec![matlab5_matrix(6, [40, 2], "a", &[matlab5_doubles(&values)])]
}

/// An FRF as PULSE exports it.
pub fn pulse() -> Vec<Vec<u8>> {
    let head = "Header Size:\t 30\t \t \r\nPulse Version:\t 80\t \t \r\nDecimal Symbol:\t.\t \t \r\n\
                Data Type:\tComplex\t \t \r\nZ-Axis size:\t1\t \t \r\nX-Axis type:\tLinear\t \t \r\n\
                X-Axis size:\t40\t \t \r\nX-Axis unit:\tHz\t \t \r\nX-Axis first value:\t 10.0\t \t \r\n\
                X-Axis delta:\t 0.5\t \t \r\nAmplitudeUnit:\t(m/s^2)/N\t \t \r\n\
                Function:\tFrequency Response\t \t \r\nRef_Signal:\t1+Z\t \t \r\nSignal:\t2+Z\t \t \r\n\
                Z-index:\t \t1\t \r\nZ-axis:\t \t 0.0\t \r\n";
    let row = |i: i32| {
        let hz = 10.0 + 0.5 * f64::from(i);
        format!("{}\t {hz:.10e}\t {}.5e-001\t-2.0e-003\r\n", i + 1, i)
    };
    let rows: String = (0..40).map(row).collect();
    vec![format!("{head}{rows}TagsEnd:\t \t \t \r\n").into_bytes()]
}

/// An FRF as SignalCalc exports it.
pub fn signalcalc() -> Vec<Vec<u8>> {
    let head = "Units: Ratio\r\nRef Chan:Resp Chan\t3+Z:12-X\r\nChannel Name\t : \r\nChannel Comment\t : \r\n\r\n\
                Frequency\t Real\t Imaginary\r\n\r\nUnits:\r\nHz\t(m/s^2)(N)\t \r\n";
    let row = |i: i32| format!("{:.13e}\t  -0.{i}504\t  {i}.25\r\n", 0.25 * f64::from(i));
    let rows: String = (0..60).map(row).collect();
    vec![format!("{head}{rows}").into_bytes()]
}

/// A file that is kept packed.
pub fn unpacked(packed: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut unpacked = flate2::read::GzDecoder::new(packed);
    unpacked.read_to_end(&mut bytes).unwrap();
    bytes
}
