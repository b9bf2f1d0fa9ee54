use std::io::Cursor;

use num_complex::Complex64;
use proptest::prelude::*;

use super::header::{Header, written};
use super::items::{description, encode};
use super::record::Record;
use super::{Npy, Npz};
use crate::io::formats::arrays::schema::drawn_sources::{assert_same, drawn};
use crate::io::formats::arrays::store::Elements;
use crate::io::{
    Block, ColumnName, ColumnRole, Confidence, Dimension, EntryAxis, Format, Hints, IoError,
    Source, TableColumn, TableSpec, WriteOptions, detect,
};

fn npy(version: u8, description: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text =
        format!("{{'descr': {description}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((text.len() as u16).to_le_bytes()),
        _ => bytes.extend((text.len() as u32).to_le_bytes()),
    }
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

fn elements(bytes: &[u8]) -> Result<Elements, IoError> {
    let mut input = Cursor::new(bytes);
    let header = Header::read(&mut input, "x.npy")?;
    let available = bytes.len() as u64 - header.data;
    header.read_column(0, input, available, "x.npy")
}

#[test]
fn every_type_is_read_in_both_orders_of_bytes() {
    let cases: [(&str, &[u8], Elements); 9] = [
        ("'|b1'", &[1, 0], Elements::F64(vec![1.0, 0.0])),
        ("'|i1'", &[0xff, 2], Elements::F64(vec![-1.0, 2.0])),
        ("'<u2'", &[1, 2, 0, 1], Elements::F64(vec![513.0, 256.0])),
        ("'>u2'", &[1, 2, 0, 1], Elements::F64(vec![258.0, 1.0])),
        (
            "'>f4'",
            &[0x3f, 0x80, 0, 0, 0xbf, 0, 0, 0],
            Elements::F32(vec![1.0, -0.5]),
        ),
        ("'<f2'", &[0, 0x3c, 0, 0xb8], Elements::F64(vec![1.0, -0.5])),
        (
            "'|S3'",
            b"ab\0xyz",
            Elements::Text(vec!["ab".to_owned(), "xyz".to_owned()]),
        ),
        (
            "'<U1'",
            &[0xb2, 0, 0, 0, 0, 0, 0, 0],
            Elements::Text(vec!["²".to_owned(), String::new()]),
        ),
        (
            "'>U1'",
            &[0, 0, 0, 0xb2, 0, 0, 0, b'a'],
            Elements::Text(vec!["²".to_owned(), "a".to_owned()]),
        ),
    ];
    for (description, data, expected) in cases {
        for version in [1, 2, 3] {
            let bytes = npy(version, description, "False", "(2,)", data);
            assert_eq!(elements(&bytes).unwrap(), expected, "{description}");
        }
    }
    let parts = [1.5_f64, -2.0, 0.25, 4.0].map(f64::to_be_bytes).concat();
    let complex = elements(&npy(1, "'>c16'", "False", "(2L,)", &parts)).unwrap();
    let expected = vec![Complex64::new(1.5, -2.0), Complex64::new(0.25, 4.0)];
    assert_eq!(complex, Elements::Complex(expected));
}

#[test]
fn fortran_order_is_turned() {
    let data: Vec<u8> = vec![0, 10, 1, 11, 2, 12];
    let read = elements(&npy(1, "'|u1'", "True", "(2, 3)", &data)).unwrap();
    assert_eq!(read, Elements::F64(vec![0.0, 1.0, 2.0, 10.0, 11.0, 12.0]));
}

#[test]
fn unread_arrays_are_listed_with_their_kind() {
    for (description, kind) in [
        ("'|O'", "object"),
        ("'<M8[ns]'", "date"),
        ("'<f16'", "long double"),
        ("[('t, \\'(', '<f8'), ('x', '|O')]", "struct"),
        ("'|V4'", "bytes"),
        ("'é'", "unknown"),
    ] {
        let bytes = npy(1, description, "False", "(1,)", &[0; 32]);
        let source = Npy
            .open(Box::new(Cursor::new(bytes)), &Hints::default())
            .unwrap();
        let catalog = source.catalog();
        assert_eq!(catalog.arrays[0].kind, kind);
        assert_eq!(catalog.findings.len(), 1, "{description}");
    }
}

#[test]
fn headers_larger_than_their_data_are_refused() {
    let refused = [
        npy(1, "'<f8'", "False", "(1000000000000,)", &[0; 16]),
        npy(
            1,
            "'<f8'",
            "False",
            "(18446744073709551615, 18446744073709551615)",
            &[],
        ),
        npy(1, "'|S0'", "False", "(1000000000000,)", &[]),
        npy(1, "'<U4611686018427387904'", "False", "(4,)", &[0; 16]),
        npy(1, "'<f8'", "False", "(-3,)", &[0; 16]),
        npy(1, "'<f8'", "False", "3", &[0; 24]),
        npy(9, "'<f8'", "False", "(2,)", &[0; 16]),
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(),
        [b"\x93NUMPY\x01\x00\xff\xff".to_vec(), vec![b'('; 0xffff]].concat(),
        b"\x93NUMPY".to_vec(),
    ];
    for bytes in refused {
        assert!(elements(&bytes).is_err());
    }
}

#[test]
fn a_written_header_is_the_one_of_the_format() {
    let header = written("<f8", &[3, 4]);
    assert_eq!(header.len() % 64, 0);
    assert!(header.ends_with(b" \n"));
    let read = Header::read(header.as_slice(), "x").unwrap();
    assert_eq!((read.shape, read.data), (vec![3, 4], header.len() as u64));
    assert_eq!(read.record, Record::from_description("'<f8'"));
    for shape in [vec![], vec![7]] {
        let header = written("<U3", &shape);
        assert_eq!(Header::read(header.as_slice(), "x").unwrap().shape, shape);
    }
}

fn write_npz(source: &mut dyn Source) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let findings = Npz
        .write(&mut out, source, &WriteOptions::default())
        .unwrap();
    assert!(findings.is_empty(), "{findings:?}");
    out.into_inner()
}

fn open_npz(bytes: Vec<u8>) -> Box<dyn Source> {
    Npz.open(Box::new(Cursor::new(bytes)), &Hints::default())
        .unwrap()
}

proptest! {
    #[test]
    fn everything_comes_back_from_an_archive(seed: u64) {
        let mut source = drawn(seed);
        let bytes = write_npz(&mut source);
        prop_assert_eq!(detect(&bytes[..bytes.len().min(4096)], "x").unwrap().name(), "npz");
        prop_assert_eq!(&bytes, &write_npz(&mut source), "the same bytes each time");
        assert_same(&mut source, open_npz(bytes).as_mut());
    }

    #[test]
    fn a_damaged_archive_never_panics(seed in 0..4_u64, place: prop::sample::Index, value: u8) {
        let mut bytes = write_npz(&mut drawn(seed));
        let place = place.index(bytes.len());
        bytes[place] = value;
        let opened = Npz.open(Box::new(Cursor::new(bytes)), &Hints::default());
        if let Ok(mut source) = opened {
            let mut block = Block::F64(Vec::new());
            for entry in 0..source.catalog().entries.len() {
                let len = source.catalog().entries[entry].len();
                let _ = source.read(entry, 0..len, &mut block);
            }
        }
    }
}

#[test]
fn deflated_members_are_read() {
    use std::io::Write;
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let deflated = options.compression_method(zip::CompressionMethod::Deflated);
    let data: Vec<u8> = (0..600)
        .flat_map(|i| f64::from(i % 7).to_le_bytes())
        .collect();
    archive.start_file("x.npy", deflated).unwrap();
    archive
        .write_all(&npy(1, "'<f8'", "True", "(300, 2)", &data))
        .unwrap();
    archive.start_file("notes.txt", deflated).unwrap();
    archive.write_all(b"by hand").unwrap();
    let bytes = archive.finish().unwrap().into_inner();
    assert_eq!(Npz.detect(&bytes), Confidence::Certain);
    let mut turned = zip::ZipWriter::new(Cursor::new(Vec::new()));
    turned.start_file("notes.txt", deflated).unwrap();
    turned.write_all(b"by hand").unwrap();
    turned.start_file("x.npy", deflated).unwrap();
    let other_first = turned.finish().unwrap().into_inner();
    assert_eq!(Npz.detect(&other_first), Confidence::Certain);
    let listed = open_npz(bytes.clone());
    let names: Vec<&str> = listed
        .catalog()
        .arrays
        .iter()
        .map(|a| a.name.as_str())
        .collect();
    assert_eq!(names, ["x", "notes.txt"]);
    let mut hints = hints(&["x:2"], None);
    hints.path = "x.npz".to_owned();
    let mut source = Npz.open(Box::new(Cursor::new(bytes)), &hints).unwrap();
    let mut block = Block::F64(Vec::new());
    source.read(0, 0..3, &mut block).unwrap();
    assert_eq!(
        block,
        Block::F64(vec![6.0, 0.0, 1.0]),
        "300 leaves 6 over when divided by 7"
    );
}

/// A spec of responses in N at 100 Hz.
fn hints(columns: &[&str], dimensions: Option<&[Dimension]>) -> Hints {
    let column = |name: &&str| TableColumn {
        column: match name.parse() {
            Ok(number) => ColumnName::Number(number),
            Err(_) => ColumnName::Heading((*name).to_owned()),
        },
        role: ColumnRole::Response {
            dof: None,
            unit: "N".parse().unwrap(),
        },
        scale: 1.0,
    };
    Hints {
        path: "F1.npy".to_owned(),
        table: Some(TableSpec {
            dimensions: dimensions.map(<[Dimension]>::to_vec),
            sampling_rate_hz: Some(100.0),
            columns: columns.iter().map(column).collect(),
            ..TableSpec::default()
        }),
    }
}

fn three_dimensions() -> Vec<u8> {
    // Hit h, channel c, sample s holds 100 h + 10 c + s.
    let value = |i: usize| 100 * (i / 12) + 10 * (i / 4 % 3) + i % 4;
    let data: Vec<u8> = (0..24).map(|i| value(i) as u8).collect();
    npy(1, "'|u1'", "False", "(2, 3, 4)", &data)
}

fn open(bytes: Vec<u8>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
    Npy.open(Box::new(Cursor::new(bytes)), hints)
}

#[test]
fn stated_dimensions_make_hits_of_channels() {
    use Dimension::{Channel, Hit, Sample};
    let hints = hints(&["3", "F1:1"], Some(&[Hit, Channel, Sample]));
    let mut source = open(three_dimensions(), &hints).unwrap();
    let versions: Vec<i64> = source
        .catalog()
        .entries
        .iter()
        .map(|entry| entry.identification.version)
        .collect();
    assert_eq!(versions, [1, 1, 2, 2]);
    let mut block = Block::F64(Vec::new());
    source.read(2, 0..4, &mut block).unwrap();
    assert_eq!(block, Block::F64(vec![120.0, 121.0, 122.0, 123.0]));
    source.read(1, 0..4, &mut block).unwrap();
    assert_eq!(block, Block::F64(vec![0.0, 1.0, 2.0, 3.0]));
    let EntryAxis::Time(axis) = source.catalog().entries[0].axis else {
        panic!("time")
    };
    assert_eq!(axis.sampling_rate_hz().to_bits(), 100_f64.to_bits());
}

#[test]
fn missing_or_wrong_statements_of_the_scene_are_errors() {
    let message = |hints: &Hints| open(three_dimensions(), hints).err().unwrap().to_string();
    let unstated = message(&hints(&["1"], None));
    assert!(
        unstated.contains("dimensions = [\"hit\", \"channel\", \"sample\"]"),
        "{unstated}"
    );
    use Dimension::{Channel, Hit, Sample};
    let stated: Option<&[Dimension]> = Some(&[Hit, Channel, Sample]);
    let absent = message(&hints(&["F2"], stated));
    assert!(
        absent.contains("arrays F1 (2 x 3 x 4 u8)") && absent.contains("\"F2\""),
        "{absent}"
    );
    let outside = message(&hints(&["4"], stated));
    assert!(
        outside.contains("F1 with 3 channels") && outside.contains("F1:4"),
        "{outside}"
    );
    let open_number = message(&hints(&["F1"], stated));
    assert!(open_number.contains("F1:NUMBER"), "{open_number}");
    let twice = message(&hints(&["1"], Some(&[Hit, Hit, Sample])));
    assert!(twice.contains("once each"), "{twice}");
    assert!(message(&hints(&["0"], stated)).contains("NAME:0"));
}

#[test]
fn another_reader_takes_the_written_arrays() {
    let doubles = vec![1.0 / 3.0, -0.0, f64::INFINITY, 5e-324, 1e300, 2.0];
    let singles = vec![0.1_f32, -2.5];
    let bytes = |elements: &Elements, shape: &[usize]| {
        let header = written(&description(elements), shape);
        [header, encode(elements)].concat()
    };
    let file = bytes(&Elements::F64(doubles.clone()), &[2, 3]);
    let read = npyz::NpyFile::new(file.as_slice()).unwrap();
    assert_eq!((read.shape(), read.order()), (&[2, 3][..], npyz::Order::C));
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(read.into_vec::<f64>().unwrap()), bits(doubles));
    let file = bytes(&Elements::F32(singles.clone()), &[2]);
    let read = npyz::NpyFile::new(file.as_slice()).unwrap();
    assert_eq!(read.into_vec::<f32>().unwrap(), singles);
    let file = bytes(&Elements::Text(vec!["m²".to_owned(), String::new()]), &[2]);
    let read = npyz::NpyFile::new(file.as_slice()).unwrap();
    assert_eq!(read.into_vec::<String>().unwrap(), ["m²", ""]);
    let complex = vec![Complex64::new(0.5, -1.5)];
    let file = bytes(&Elements::Complex(complex.clone()), &[]);
    let read = npyz::NpyFile::new(file.as_slice()).unwrap();
    assert!(read.shape().is_empty());
    assert_eq!(read.into_vec::<Complex64>().unwrap(), complex);
}

#[test]
fn fields_of_a_fortran_array_are_turned_with_their_lengths_inside() {
    // Element [i, j] of shape 2 x 3 is 10 i + j, with the pair (value, value + 100) in a field.
    let mut data = Vec::new();
    for j in 0..3_u8 {
        for i in 0..2_u8 {
            data.extend([7, 10 * i + j, 100 + 10 * i + j]);
        }
    }
    let description = "[('mark', '|u1'), ('pair', '|u1', (2,))]";
    let bytes = npy(1, description, "True", "(2, 3)", &data);
    let mut input = Cursor::new(&bytes);
    let header = Header::read(&mut input, "x.npy").unwrap();
    let available = bytes.len() as u64 - header.data;
    let infos = header.infos("x");
    assert_eq!(
        (infos[1].name.as_str(), &infos[1].shape),
        ("x/pair", &vec![2, 3, 2])
    );
    let pairs = header.read_column(1, input, available, "x.npy").unwrap();
    let expected = [0, 100, 1, 101, 2, 102, 10, 110, 11, 111, 12, 112];
    assert_eq!(pairs, Elements::F64(expected.map(f64::from).to_vec()));
}

#[test]
fn elements_without_bytes_are_read_at_once() {
    for shape in ["(1000000000000000000,)", "(1000000000000000000, 0)"] {
        let bytes = npy(1, "[('x', '<f8', (0,))]", "False", shape, &[]);
        assert_eq!(elements(&bytes).unwrap(), Elements::F64(Vec::new()));
    }
}

proptest! {
    #[test]
    fn a_damaged_structured_array_never_panics(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let description = "[('a', '<f8'), ('s', [('p', '>c8'), ('', '|V3')], (2,)), ('t', '<U2')]";
        let mut bytes = npy(1, description, "True", "(2, 3)", &[1; 228]);
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Ok(mut store) = super::open_npy(Box::new(Cursor::new(bytes)), "x.npy") {
            for index in 0..store.list().len() {
                let _ = store.read(index);
            }
        }
    }
}

/// An archive of so many arrays of one value, with headers of so many bytes.
fn archive_of(count: usize, header: usize) -> Vec<u8> {
    use std::io::Write;
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let options = options.compression_method(zip::CompressionMethod::Deflated);
    let text = "{'descr': '|u1', 'fortran_order': False, 'shape': (1,), }";
    let length = ((header - 12) as u32).to_le_bytes();
    let text = text.to_owned() + &" ".repeat(header - 12 - text.len());
    let member = [b"\x93NUMPY\x02\0", &length[..], text.as_bytes(), &[7]].concat();
    for number in 0..count {
        archive
            .start_file(format!("a{number}.npy"), options)
            .unwrap();
        archive.write_all(&member).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn headers_are_read_to_a_limit() {
    let opened = |bytes: Vec<u8>| {
        let mut source = open_npz(bytes);
        (source.catalog().arrays.len(), source.take_damage().len())
    };
    // Headers of half a mebibyte that deflate to some hundred bytes.
    assert_eq!(opened(archive_of(8, 1 << 19)), (2, 1));
    assert_eq!(opened(archive_of(9_000, 128)), (9_000, 0));
}
