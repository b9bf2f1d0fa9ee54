//! Files that are cut off, spoiled or built to harm.

use std::io::Cursor;

use proptest::prelude::*;

use super::file_builder::{BOTH, Builder};
use super::{Matlab5, store};
use crate::finding::Code;
use crate::io::formats::arrays::schema::drawn_sources::drawn;
use crate::io::formats::arrays::store::ArrayStore;
use crate::io::{Format, Hints, IoError, WriteOptions};

/// Lists and reads everything that can be read; the damage.
fn read_all(builder: Builder, bytes: Vec<u8>) -> (Vec<String>, Vec<IoError>) {
    let store = store::open(Box::new(Cursor::new(bytes)), builder.big_endian, "x.mat");
    let mut store = store.unwrap();
    let mut damage = store.take_damage();
    let names = store.list().iter().map(|info| info.name.clone()).collect();
    for index in 0..store.list().len() {
        damage.extend(store.read(index).err());
    }
    (names, damage)
}

#[test]
fn variables_before_a_cut_are_read() {
    for builder in BOTH {
        let first = builder.doubles(&[1, 2], "first", &[1.0, 2.0]);
        for second in [
            builder.doubles(&[1, 2], "second", &[3.0, 4.0]),
            builder.deflated(&builder.doubles(&[1, 2], "second", &[3.0, 4.0])),
        ] {
            let whole = builder.file(&[first.clone(), second.clone()]);
            let cut = whole.len() - second.len() + 1..whole.len();
            for length in cut {
                let (names, damage) = read_all(builder, whole[..length].to_vec());
                assert_eq!((names, damage.len()), (vec!["first".to_owned()], 1));
                let IoError::Truncated { byte, .. } = &damage[0] else {
                    panic!("{}", damage[0])
                };
                assert_eq!(*byte, length as u64);
            }
        }
    }
}

#[test]
fn variables_after_a_bad_variable_are_read() {
    let builder = BOTH[0];
    let good = builder.doubles(&[1, 1], "good", &[1.0]);
    let mut spoiled = builder.deflated(&builder.doubles(&[1, 1], "x", &[1.0]));
    spoiled[8..].fill(0xff);
    let bad = [
        spoiled,
        builder.element(99, &[0; 16]),
        builder.element(14, &builder.words(6, &[6, 0])),
        builder.matrix(1, &[1, 1], "cell", &[builder.element(9, &[0; 8])]),
        builder.matrix(1, &[u32::MAX >> 1, 4], "cells", &[]),
    ];
    for bad in bad {
        let bytes = builder.file(&[bad, good.clone()]);
        let source = Matlab5
            .open(Box::new(Cursor::new(bytes)), &Hints::default())
            .unwrap();
        let catalog = source.catalog();
        assert_eq!(
            (catalog.arrays.len(), catalog.damage.len()),
            (1, 1),
            "{:?}",
            catalog.damage
        );
        assert_eq!(catalog.arrays[0].name, "good");
        assert_eq!(catalog.findings[0].code, Code::BadDataset);
    }
}

#[test]
fn counts_contradicting_the_bytes_are_errors() {
    let builder = BOTH[0];
    let long = u32::MAX >> 1;
    let wrong = [
        builder.matrix(6, &[long, long], "x", &[builder.element(9, &[0; 8])]),
        builder.matrix(6, &[2, 1], "x", &[builder.element(9, &[0; 8])]),
        builder.matrix(6, &[1, 1], "x", &[builder.element(14, &[0; 8])]),
        builder.matrix(6, &[1, 1], "x", &[]),
        builder.matrix(4, &[2, 3], "x", &[builder.small(2, b"abc")]),
        builder.matrix(4, &[1, 1], "x", &[builder.element(9, &[0; 8])]),
        builder.matrix(
            5,
            &[1, 2],
            "x",
            &[
                builder.words(5, &[5]),
                builder.words(5, &[0, 1, 1]),
                builder.small(2, &[1]),
            ],
        ),
        builder.matrix(
            5,
            &[1, 2],
            "x",
            &[
                builder.words(5, &[0]),
                builder.words(5, &[0, long]),
                builder.small(2, &[1]),
            ],
        ),
        // Columns that go back would visit the same values again and again.
        builder.matrix(
            5,
            &[1, 3],
            "x",
            &[
                builder.words(5, &[0]),
                builder.words(5, &[0, 1, 0, 1]),
                builder.small(2, &[1]),
            ],
        ),
    ];
    for wrong in wrong {
        let (_, damage) = read_all(builder, builder.file(&[wrong]));
        assert_eq!(damage.len(), 1, "{damage:?}");
    }
}

#[test]
fn structs_within_structs_end_somewhere() {
    let builder = BOTH[0];
    let mut nested = builder.doubles(&[1, 1], "", &[1.0]);
    for level in 0..40 {
        let name = if level == 39 { "deep" } else { "" };
        nested = builder.matrix(1, &[1, 1], name, &[nested]);
    }
    let (_, damage) = read_all(builder, builder.file(&[nested]));
    assert_eq!(damage.len(), 1);
    assert!(damage[0].to_string().contains("32 levels"), "{}", damage[0]);
}

#[test]
fn a_small_file_cannot_list_parts_without_end() {
    let builder = BOTH[0];
    // Cells without content are eight bytes each, and a million of them deflate well.
    let count: u32 = 1_000_000;
    let cells = builder.element(14, &[]).repeat(count as usize);
    let bomb = builder.deflated(&builder.matrix(1, &[count, 1], "cells", &[cells]));
    let (names, damage) = read_all(builder, builder.file(&[bomb]));
    assert!(
        names.len() < 20_000 && damage.len() == 1,
        "{} {damage:?}",
        names.len()
    );
}

#[test]
fn an_empty_char_array_has_as_many_texts_as_rows() {
    let builder = BOTH[0];
    let bytes = builder.file(&[builder.matrix(4, &[3, 0], "x", &[builder.element(4, &[])])]);
    let mut store = store::open(Box::new(Cursor::new(bytes)), false, "x.mat").unwrap();
    let shape = store.list()[0].shape.clone();
    let array = store.read(0).unwrap();
    assert_eq!((&array.shape, array.elements.len()), (&shape, 1));
    assert!(store.read_part(0, 0..3).is_err(), "no panic");
}

#[test]
fn imaginary_parts_of_a_sparse_matrix_must_all_be_there() {
    let builder = BOTH[0];
    let matrix = builder.matrix(
        5 | 0x0800,
        &[1, 2],
        "x",
        &[
            builder.words(5, &[0, 0]),
            builder.words(5, &[0, 1, 2]),
            builder.small(2, &[1, 2]),
            builder.small(2, &[1]),
        ],
    );
    let (_, damage) = read_all(builder, builder.file(&[matrix]));
    assert_eq!(damage.len(), 1);
}

#[test]
fn names_cannot_be_repeated_without_end() {
    let builder = BOTH[0];
    let width: u32 = 4000;
    let names = vec![b'n'; width as usize];
    let count: u32 = 20_000;
    let content = [
        builder.small(5, &width.to_le_bytes()),
        builder.element(1, &names),
        builder.element(14, &[]).repeat(count as usize),
    ];
    let bomb = builder.matrix(2, &[count, 1], "s", &content);
    let (names, damage) = read_all(builder, builder.file(&[bomb]));
    let bytes: usize = names.iter().map(String::len).sum();
    assert!(bytes < 5 << 20 && damage.len() == 1, "{bytes} {damage:?}");
}

proptest! {
    #[test]
    fn a_spoiled_file_never_panics(
        seed in 0..6_u64,
        deflated: bool,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut out = Cursor::new(Vec::new());
        Matlab5.write(&mut out, &mut drawn(seed), &WriteOptions::default()).unwrap();
        let mut bytes = out.into_inner();
        let builder = BOTH[0];
        if deflated {
            let nested = bytes.split_off(128);
            let nested = builder.matrix(1, &[1, 1], "all", &[nested]);
            bytes.extend(builder.deflated(&nested));
        }
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        let _ = read_all(builder, bytes);
    }
}

/// A deflated struct with so many fields, the first of which may be larger.
fn deflated_struct(count: usize, first: usize, value: impl Fn(usize) -> f64) -> Vec<u8> {
    let builder = BOTH[0];
    let names: Vec<String> = (0..count).map(|field| format!("f{field}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let fields = (0..count).map(|field| {
        let length = if field == 0 { first } else { 32 };
        let values: Vec<f64> = (0..length).map(|n| value(32 * field + n)).collect();
        builder.doubles(&[1, length as u32], "", &values)
    });
    let fields: Vec<Vec<u8>> = fields.collect();
    let structure = builder.structure(&[1, 1], "s", &names, &fields);
    builder.file(&[builder.deflated(&structure)])
}

/// Reads the fields in reverse; how many could be read.
fn read_in_reverse(bytes: Vec<u8>) -> usize {
    let mut store = store::open(Box::new(Cursor::new(bytes)), false, "x.mat").unwrap();
    let fields = store.list().len();
    (0..fields)
        .rev()
        .filter(|field| store.read(*field).is_ok())
        .count()
}

#[test]
fn fields_of_a_deflated_struct_are_read_in_any_order() {
    // Every third value is new, so that it deflates to about a third.
    let value = |n: usize| (n / 3) as f64 * std::f64::consts::PI;
    let bytes = deflated_struct(800, 32, value);
    assert_eq!(read_in_reverse(bytes), 800);
}

#[test]
fn fields_out_of_order_are_inflated_to_a_limit() {
    // 8 MiB of zeros before 40 small fields, in 10 kB.
    let bytes = deflated_struct(41, 1 << 20, |_| 0.0);
    assert!(bytes.len() < 50_000, "{}", bytes.len());
    let read = read_in_reverse(bytes);
    assert!((1..40).contains(&read), "{read}");
}
