//! Small intact files of every format are the seeds of damaged ones, written by the library or made
//! of text here.

use std::io::{Cursor, Write};

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

use crate::mutation::unpacked;

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

/// Universal files: what the library writes, and datasets that it reads alone.
pub fn uff() -> Vec<Vec<u8>> {
    let dataset = |text: &str| format!("    -1\n{text}    -1\n");
    let head = |number: &str, data_type: u8, points: u8| {
        let none = "NONE\n".repeat(4);
        format!(
            "{number}\ntitle\n{none}    1         0    3         7 NONE              12  -3 NONE               4   1\n\
             {data_type:>10}{points:>10}         1  0.00000E+00  1.95313E-05  0.00000E+00\n\
             \x20       17    0    0    0 Time                 s                   \n\
             \x20       12    0    0    0 Acceleration         g                   \n\
             \x20        0    0    0    0 NONE                 NONE                \n\
             \x20        0    0    0    0 NONE                 NONE                \n"
        )
    };
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
        dataset(&format!("{}{numbers}", head("    58", 2, 24))),
    ];
    let block: Vec<u8> = (0..200_u8)
        .flat_map(|i| f32::from(i).to_le_bytes())
        .collect();
    let first = "    58b     1     2          11         800     0     0           0           0";
    let binary = [
        format!("    -1\n{}", head(first, 2, 200)).into_bytes(),
        block,
        b"\n    -1\n".to_vec(),
    ];
    let written_files = [Encoding::Binary, Encoding::Text].map(|encoding| written("uff", encoding));
    let text = text.concat();
    let utf_16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let seeds = [
        text.replace('\n', "\r").into_bytes(),
        text.replace("    -1\n    -1\n", "    -1    -1\n")
            .into_bytes(),
        text.into_bytes(),
        utf_16,
        binary.concat(),
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

/// A 40 x 2 array `a`, a text and a sparse matrix in version 4, in both orders of bytes.
pub fn matlab4() -> Vec<Vec<u8>> {
    let file = |big_endian: bool| {
        let word = |value: u32| match big_endian {
            true => value.to_be_bytes(),
            false => value.to_le_bytes(),
        };
        let matrix = |kind: u32, lengths: [u32; 2], name: u8, values: &[f64]| {
            // The thousands digit is the order of the bytes.
            let kind = kind + 1000 * u32::from(big_endian);
            let header = [kind, lengths[0], lengths[1], 0, 2].map(word);
            let numbers = values.iter().flat_map(|value| match big_endian {
                true => value.to_be_bytes(),
                false => value.to_le_bytes(),
            });
            let numbers: Vec<u8> = numbers.collect();
            [header.concat(), vec![name, 0], numbers].concat()
        };
        let values: Vec<f64> = (0..80_u8).map(f64::from).collect();
        let sparse = [1.0, 3.0, 2.0, 4.0, 0.5, 0.0];
        [
            matrix(0, [40, 2], b'a', &values),
            matrix(1, [2, 2], b't', &[97.0, 98.0, 99.0, 32.0]),
            matrix(2, [2, 3], b's', &sparse),
        ]
        .concat()
    };
    vec![file(false), file(true)]
}

/// A 40 x 2 array `a` in a compressed element, as MATLAB saves it.
pub fn matlab_array() -> Vec<Vec<u8>> {
    let element = |kind: u32, content: &[u8]| {
        let size = content.len() as u32;
        let padding = vec![0; content.len().next_multiple_of(8) - content.len()];
        [
            &kind.to_le_bytes()[..],
            &size.to_le_bytes(),
            content,
            &padding,
        ]
        .concat()
    };
    let class_double: [u8; 8] = [6, 0, 0, 0, 0, 0, 0, 0];
    let lengths: Vec<u8> = [40_i32, 2].iter().flat_map(|n| n.to_le_bytes()).collect();
    let values: Vec<u8> = (0..80_u8)
        .flat_map(|i| f64::from(i).to_le_bytes())
        .collect();
    let parts = [
        element(6, &class_double),
        element(5, &lengths),
        element(1, b"a"),
        element(9, &values),
    ];
    let matrix = element(14, &parts.concat());
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(&matrix).unwrap();
    let packed = packed.finish().unwrap();
    let mut file = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    file.extend([0x00, 0x01, b'I', b'M']);
    file.extend(15_u32.to_le_bytes());
    file.extend((packed.len() as u32).to_le_bytes());
    file.extend(packed);
    vec![file]
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
