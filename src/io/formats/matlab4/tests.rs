use std::io::Cursor;

use proptest::prelude::*;

use super::open_store;
use crate::io::formats::arrays::store::{ArrayStore, Elements};

/// A matrix of doubles of a little-endian machine; `kind` is its type with all digits.
fn matrix(kind: u32, rows: u32, columns: u32, name: &str, values: &[f64]) -> Vec<u8> {
    let complex = u32::from(kind == 0 && values.len() as u32 > rows.saturating_mul(columns));
    let header = [kind, rows, columns, complex, name.len() as u32 + 1];
    let header = header.map(u32::to_le_bytes).concat();
    let numbers: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    [header, name.as_bytes().to_vec(), vec![0], numbers].concat()
}

/// Numbers, texts and a sparse matrix.
fn sound() -> Vec<u8> {
    let codes: Vec<f64> = "acb ".bytes().map(f64::from).collect();
    let triples = [1.0, 2.0, 2.0, 3.0, 1.0, 3.0, 5.0, -1.0, 0.0];
    [
        matrix(0, 2, 2, "z", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]),
        matrix(1, 2, 2, "rows", &codes),
        matrix(2, 3, 3, "s", &triples),
        matrix(0, 3, 1, "x", &[1.0, 2.0, 3.0]),
    ]
    .concat()
}

fn open(bytes: Vec<u8>) -> Box<dyn ArrayStore> {
    open_store(Box::new(Cursor::new(bytes)), "x.mat").unwrap()
}

#[test]
fn rows_of_a_char_matrix_are_texts() {
    let mut store = open(sound());
    let rows = store.read(1).unwrap();
    let texts = ["ab", "c"].map(str::to_owned).to_vec();
    assert_eq!(
        (rows.shape, rows.elements),
        (vec![2], Elements::Text(texts))
    );
    let empty = matrix(1, 2_000_000_000, 0, "none", &[]);
    let empty = open(empty).read(0).unwrap();
    assert_eq!(empty.elements, Elements::Text(vec![String::new()]));
}

#[test]
fn a_sparse_matrix_is_read_full_and_as_its_entries() {
    let mut store = open(sound());
    let full = store.read(2).unwrap();
    let expected = vec![0.0, 0.0, 5.0, -1.0, 0.0, 0.0];
    assert_eq!(
        (full.shape, full.elements),
        (vec![2, 3], Elements::F64(expected))
    );
    let entries = store.read_sparse(2).unwrap().unwrap();
    assert_eq!((entries.rows, entries.columns), (2, 3));
    assert_eq!(entries.entries, [(0, 2, 5.0), (1, 0, -1.0)]);
    assert_eq!(store.read_sparse(0).unwrap(), None);
    // A few entries of a large matrix: listed, and read as entries alone.
    let large = matrix(2, 2, 3, "large", &[7.0, 1e6, 8.0, 1e6, 2.5, 0.0]);
    let mut store = open(large);
    assert!(!store.can_read(0) && store.read(0).is_err());
    assert_eq!(
        store.read_sparse(0).unwrap().unwrap().entries,
        [(6, 7, 2.5)]
    );
}

#[test]
fn an_entry_outside_a_sparse_matrix_is_an_error() {
    for (row, column) in [(0.0, 1.0), (1.5, 1.0), (1.0, 4.0), (f64::NAN, 1.0)] {
        let bytes = matrix(2, 2, 3, "s", &[row, 2.0, column, 3.0, 5.0, 0.0]);
        let error = open(bytes).read(0).unwrap_err().to_string();
        assert!(error.contains("inside [2, 3]"), "{error}");
    }
}

#[test]
fn a_part_of_a_vector_is_read_and_one_outside_is_not() {
    let mut store = open(sound());
    let part = store.read_part(3, 1..3).unwrap();
    assert_eq!(part, Elements::F64(vec![2.0, 3.0]));
    assert!(store.read_part(3, 1..4).is_err());
    assert!(store.read_part(0, 0..5).is_err());
}

#[test]
fn counts_beyond_the_file_are_damage_at_its_end() {
    let long = i32::MAX.unsigned_abs();
    for bytes in [
        matrix(0, long, long, "x", &[1.0]),
        matrix(0, 2, 1, "x", &[1.0]),
        [sound(), vec![0; 7]].concat(),
    ] {
        let length = bytes.len();
        let damage = open(bytes).take_damage();
        assert_eq!(damage.len(), 1);
        let text = damage[0].to_string();
        assert!(text.contains(&format!("at byte {length}")), "{text}");
    }
}

proptest! {
    #[test]
    fn a_damaged_file_never_panics(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut bytes = sound();
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Ok(mut store) = open_store(Box::new(Cursor::new(bytes)), "x.mat") {
            for index in 0..store.list().len() {
                let _ = (store.read(index), store.read_sparse(index));
                let _ = store.read_part(index, 0..1);
            }
        }
    }
}
