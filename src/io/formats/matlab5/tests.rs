use std::io::Cursor;

use num_complex::Complex64;
use proptest::prelude::*;

use super::file_builder::{BOTH, Builder};
use super::{Matlab5, open_store, store};
use crate::io::formats::arrays::schema::drawn_sources::{assert_same, drawn};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray};
use crate::io::{
    ArrayInfo, Block, ColumnName, ColumnRole, Format, Hints, Source, TableColumn, TableSpec,
    WriteOptions, detect,
};

/// Every array of a file, and the whole list.
fn read_all(builder: Builder, elements: &[Vec<u8>]) -> (Vec<ArrayInfo>, Vec<NamedArray>) {
    let bytes = builder.file(elements);
    assert_eq!(detect(&bytes, "x").unwrap().name(), "matlab5");
    let mut store = store::open(Box::new(Cursor::new(bytes)), builder.big_endian, "x.mat").unwrap();
    let damage = store.take_damage();
    assert!(damage.is_empty(), "{damage:?}");
    let list = store.list().to_vec();
    let readable = (0..list.len())
        .filter(|index| store.can_read(*index))
        .collect::<Vec<_>>();
    let arrays = readable
        .into_iter()
        .map(|index| store.read(index).unwrap())
        .collect();
    (list, arrays)
}

/// The one array of a file with one, plain and deflated.
fn read_one(builder: Builder, element: Vec<u8>) -> NamedArray {
    let (_, deflated) = read_all(builder, &[builder.deflated(&element)]);
    let (_, plain) = read_all(builder, &[element]);
    assert_eq!((plain.len(), &plain), (1, &deflated));
    plain.into_iter().next().unwrap()
}

#[test]
fn numbers_of_every_class_are_read_in_every_storage() {
    for builder in BOTH {
        let short = |values: [i16; 2]| values.map(|v| builder.turned(v.to_le_bytes())).concat();
        let cases: [(u32, u32, Vec<u8>, [f64; 2]); 9] = [
            (6, 2, vec![3, 255], [3.0, 255.0]),
            (6, 1, vec![3, 255], [3.0, -1.0]),
            (6, 3, short([-2, 300]), [-2.0, 300.0]),
            (8, 1, vec![1, 0x80], [1.0, -128.0]),
            (9, 2, vec![1, 0x80], [1.0, 128.0]),
            (10, 3, short([-300, 5]), [-300.0, 5.0]),
            (12, 1, vec![1, 2], [1.0, 2.0]),
            (14, 3, short([7, -7]), [7.0, -7.0]),
            (15, 2, vec![9, 8], [9.0, 8.0]),
        ];
        for (class, kind, bytes, expected) in cases {
            let data = match bytes.len() {
                1..=4 => builder.small(kind, &bytes),
                _ => builder.element(kind, &bytes),
            };
            let array = read_one(builder, builder.matrix(class, &[2, 1], "x", &[data]));
            assert_eq!((array.name.as_str(), array.shape), ("x", vec![2, 1]));
            assert_eq!(
                array.elements,
                Elements::F64(expected.to_vec()),
                "class {class}"
            );
        }
        let single = [1.5_f32, -0.25]
            .map(|v| builder.turned(v.to_le_bytes()))
            .concat();
        let single = builder.matrix(7, &[1, 2], "single", &[builder.element(7, &single)]);
        assert_eq!(
            read_one(builder, single).elements,
            Elements::F32(vec![1.5, -0.25])
        );
        let narrow = builder.matrix(7, &[1, 2], "single", &[builder.small(2, &[1, 2])]);
        assert_eq!(
            read_one(builder, narrow).elements,
            Elements::F32(vec![1.0, 2.0])
        );
    }
}

#[test]
fn columns_become_rows_and_complex_parts_pairs() {
    for builder in BOTH {
        let real = builder.doubles(&[2, 3], "a", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let array = read_one(builder, real);
        assert_eq!(
            array.elements,
            Elements::F64(vec![1.0, 3.0, 5.0, 2.0, 4.0, 6.0])
        );
        let parts = [builder.small(2, &[1, 2]), builder.small(1, &[0xff, 0])];
        let complex = builder.matrix(6 | 0x0800, &[1, 2], "complex", &parts);
        let expected = vec![Complex64::new(1.0, -1.0), Complex64::new(2.0, 0.0)];
        assert_eq!(
            read_one(builder, complex).elements,
            Elements::Complex(expected)
        );
        let logical = builder.matrix(9 | 0x0200, &[1, 2], "on", &[builder.small(2, &[1, 0])]);
        let (list, arrays) = read_all(builder, &[logical]);
        assert_eq!(list[0].kind, "bool");
        assert_eq!(arrays[0].elements, Elements::F64(vec![1.0, 0.0]));
    }
}

#[test]
fn texts_are_read_in_every_code() {
    for builder in BOTH {
        let utf32: Vec<u8> = "m²"
            .chars()
            .flat_map(|c| builder.turned(u32::from(c).to_le_bytes()))
            .collect();
        let cases = [
            builder.text("unit", "m²"),
            builder.matrix(4, &[1, 2], "unit", &[builder.small(2, &[b'm', 0xb2])]),
            builder.matrix(4, &[1, 2], "unit", &[builder.element(16, "m²".as_bytes())]),
            builder.matrix(4, &[1, 2], "unit", &[builder.element(18, &utf32)]),
        ];
        for case in cases {
            let array = read_one(builder, case);
            assert_eq!(
                (array.shape, array.elements),
                (vec![], Elements::Text(vec!["m²".to_owned()]))
            );
        }
        // Two rows, column after column: "ab" and "c".
        let rows = builder.matrix(4, &[2, 2], "rows", &[builder.small(2, b"acb ")]);
        let array = read_one(builder, rows);
        assert_eq!(array.shape, [2]);
        assert_eq!(
            array.elements,
            Elements::Text(vec!["ab".to_owned(), "c".to_owned()])
        );
    }
}

#[test]
fn fields_and_cells_are_listed_by_path() {
    for builder in BOTH {
        let number = |value: f64| builder.doubles(&[1, 1], "", &[value]);
        let inner = builder.structure(&[1, 1], "", &["hz"], &[number(5.0)]);
        let cells = builder.matrix(1, &[1, 2], "", &[number(7.0), builder.text("", "two")]);
        let texts = builder.matrix(
            1,
            &[2, 1],
            "",
            &[builder.text("", "a"), builder.text("", "b")],
        );
        let outer = builder.structure(
            &[1, 1],
            "test",
            &["mode", "cells", "units"],
            &[inner, cells, texts],
        );
        let several = builder.structure(&[1, 2], "hit", &["n"], &[number(1.0), number(2.0)]);
        let empty = builder.structure(&[0, 0], "none", &["n"], &[]);
        for elements in [
            vec![outer.clone(), several.clone(), empty.clone()],
            [outer, several, empty]
                .map(|element| builder.deflated(&element))
                .to_vec(),
        ] {
            let (list, arrays) = read_all(builder, &elements);
            let names: Vec<&str> = list.iter().map(|info| info.name.as_str()).collect();
            let expected = [
                "test/mode/hz",
                "test/cells{1}",
                "test/cells{2}",
                "test/units",
                "hit(1)/n",
                "hit(2)/n",
                "none",
            ];
            assert_eq!(names, expected);
            assert_eq!(arrays.len(), 6, "an empty struct is listed alone");
            assert_eq!(arrays[0].elements, Elements::F64(vec![5.0]));
            assert_eq!(arrays[2].elements, Elements::Text(vec!["two".to_owned()]));
            let texts = Elements::Text(vec!["a".to_owned(), "b".to_owned()]);
            assert_eq!(
                (&arrays[3].shape, &arrays[3].elements),
                (&vec![2, 1], &texts)
            );
            assert_eq!(arrays[5].elements, Elements::F64(vec![2.0]));
        }
    }
}

#[test]
fn sparse_matrices_are_made_full_when_they_fit() {
    for builder in BOTH {
        // [0 5 0; 7 0 0]: rows of the values, where each column begins, values.
        let sparse = |shape: &[u32]| {
            let values = [7.0_f64, 5.0]
                .map(|v| builder.turned(v.to_le_bytes()))
                .concat();
            let content = [
                builder.words(5, &[1, 0]),
                builder.words(5, &[0, 1, 2, 2]),
                builder.element(9, &values),
            ];
            builder.matrix(5, shape, "s", &content)
        };
        let array = read_one(builder, sparse(&[2, 3]));
        assert_eq!(
            array.elements,
            Elements::F64(vec![0.0, 5.0, 0.0, 7.0, 0.0, 0.0])
        );
        let (list, arrays) = read_all(builder, &[sparse(&[1_000_000, 3])]);
        assert_eq!((list[0].kind.as_str(), arrays.len()), ("sparse", 0));
    }
}

#[test]
fn the_entries_of_a_sparse_matrix_are_read_however_large_it_is() {
    for builder in BOTH {
        let values = [7.0_f64, 5.0].map(|v| builder.turned(v.to_le_bytes()));
        let content = [
            builder.words(5, &[999_999, 0]),
            builder.words(5, &[0, 1, 2, 2]),
            builder.element(9, &values.concat()),
        ];
        let sparse = builder.matrix(5, &[1_000_000, 3], "s", &content);
        for sparse in [sparse.clone(), builder.deflated(&sparse)] {
            let file = builder.file(&[sparse, builder.doubles(&[1, 1], "x", &[1.0])]);
            let mut store = open_store(Box::new(Cursor::new(file)), "x.mat").unwrap();
            let matrix = store.read_sparse(0).unwrap().unwrap();
            assert_eq!((matrix.rows, matrix.columns), (1_000_000, 3));
            assert_eq!(matrix.entries, [(999_999, 0, 7.0), (0, 1, 5.0)]);
            assert_eq!(store.read_sparse(1).unwrap(), None);
        }
    }
}

#[test]
fn arrays_without_numbers_are_listed_with_their_class() {
    let builder = BOTH[0];
    let opaque = [
        builder.words(6, &[17, 0]),
        builder.small(1, b"when"),
        builder.small(1, b"MCOS"),
        builder.element(1, b"datetime"),
    ];
    let elements = [
        builder.element(14, &opaque.concat()),
        builder.matrix(16, &[1, 1], "handle", &[]),
        builder.matrix(3, &[1, 1], "thing", &[builder.element(1, b"class")]),
        builder.matrix(77, &[1, 1], "later", &[]),
        builder.doubles(&[1, 1], "x", &[1.0]),
    ];
    let (list, arrays) = read_all(builder, &elements);
    let listed: Vec<(&str, &str)> = list
        .iter()
        .map(|info| (info.name.as_str(), info.kind.as_str()))
        .collect();
    let expected = [
        ("when", "opaque"),
        ("handle", "function"),
        ("thing", "object"),
        ("later", "class 77"),
        ("x", "f64"),
    ];
    assert_eq!(listed, expected);
    assert_eq!(arrays.len(), 1);
    let source = Matlab5
        .open(
            Box::new(Cursor::new(builder.file(&elements))),
            &Hints::default(),
        )
        .unwrap();
    assert_eq!(source.catalog().findings.len(), 4);
}

fn written(source: &mut dyn Source) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let findings = Matlab5
        .write(&mut out, source, &WriteOptions::default())
        .unwrap();
    assert!(findings.is_empty(), "{findings:?}");
    out.into_inner()
}

proptest! {
    #[test]
    fn everything_comes_back_to_the_bit(seed: u64) {
        let mut source = drawn(seed);
        let bytes = written(&mut source);
        prop_assert_eq!(&bytes, &written(&mut source), "the same bytes each time");
        let mut read = Matlab5.open(Box::new(Cursor::new(bytes)), &Hints::default()).unwrap();
        assert_same(&mut source, read.as_mut());
    }
}

#[test]
fn a_scene_names_fields_and_columns() {
    let builder = BOTH[1];
    let values = [1.0, 2.0, 3.0, 10.0, 20.0, 30.0];
    let structure = builder.structure(
        &[1, 1],
        "test",
        &["data"],
        &[builder.doubles(&[3, 2], "", &values)],
    );
    let hints = |name: &str| Hints {
        path: "x.mat".to_owned(),
        table: Some(TableSpec {
            sampling_rate_hz: Some(10.0),
            columns: vec![TableColumn {
                column: ColumnName::Heading(name.to_owned()),
                role: ColumnRole::Response {
                    dof: None,
                    unit: "m".parse().unwrap(),
                },
                scale: 1.0,
            }],
            ..TableSpec::default()
        }),
    };
    let bytes = builder.file(&[builder.deflated(&structure)]);
    for name in ["test.data:2", "test/data:2"] {
        let input = Box::new(Cursor::new(bytes.clone()));
        let mut source = Matlab5.open(input, &hints(name)).unwrap();
        let mut block = Block::F64(Vec::new());
        source.read(0, 0..3, &mut block).unwrap();
        assert_eq!(block, Block::F64(vec![10.0, 20.0, 30.0]));
    }
    let error = Matlab5.open(Box::new(Cursor::new(bytes)), &hints("test.data:3"));
    let error = error.err().unwrap().to_string();
    assert!(error.contains("test/data with 2 channels"), "{error}");
}
