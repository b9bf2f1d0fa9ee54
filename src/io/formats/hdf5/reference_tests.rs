//! Files that h5py made (`tests/reference/hdf5_files.py`), whose structure differs from that of the
//! writer used here.

use std::io::{Cursor, Read};

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::list::list_here;
use super::open_store;
use super::store::Hdf5Store;
use super::stream::Stream;
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray};

const H5PY: &[u8] = include_bytes!("../../../../tests/reference/h5py.h5.gz");
const MATLAB: &[u8] = include_bytes!("../../../../tests/reference/matlab73.mat.gz");
const NEWER: &[u8] = include_bytes!("../../../../tests/reference/newer.h5.gz");

fn unpacked(packed: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut unpacked = flate2::read::GzDecoder::new(packed);
    unpacked.read_to_end(&mut bytes).unwrap();
    bytes
}

fn open(packed: &[u8]) -> Hdf5Store {
    open_store(Box::new(Cursor::new(unpacked(packed))), "test.h5").unwrap()
}

fn read(store: &mut Hdf5Store, name: &str) -> NamedArray {
    let index = store.list().iter().position(|info| info.name == name);
    store
        .read(index.unwrap_or_else(|| panic!("{name}")))
        .unwrap()
}

fn expect(store: &mut Hdf5Store, name: &str, shape: &[usize], elements: Elements) {
    let array = read(store, name);
    assert_eq!(
        (array.shape.as_slice(), array.elements),
        (shape, elements),
        "{name}"
    );
}

fn texts(values: &[&str]) -> Elements {
    Elements::Text(values.iter().map(|value| (*value).to_owned()).collect())
}

fn damage(store: &mut Hdf5Store) -> Vec<String> {
    let damage = store.take_damage();
    damage.iter().map(ToString::to_string).collect()
}

#[test]
fn a_file_of_h5py_is_read() {
    let mut store = open(H5PY);
    let pair = vec![Complex64::new(1.0, 2.0), Complex64::new(3.0, -4.0)];
    let cases = [
        ("x", vec![5], Elements::F64(vec![0.0, 0.25, 0.5, 0.75, 1.0])),
        (
            "big",
            vec![2, 3],
            Elements::F32(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
        ),
        ("half", vec![3], Elements::F64(vec![1.5, -0.25, 65504.0])),
        ("long", vec![2], Elements::F64(vec![0.5, -3.0])),
        ("i16", vec![2], Elements::F64(vec![-2.0, 300.0])),
        ("flag", vec![2], Elements::F64(vec![1.0, 0.0])),
        ("one", vec![], Elements::F64(vec![2.5])),
        ("text", vec![], texts(&["12:+Z"])),
        ("fixed", vec![2], texts(&["ab", "cdef"])),
        ("texts", vec![3], texts(&["m/s²", "", "long"])),
        ("complex", vec![2], Elements::Complex(pair)),
        (
            "run/lzf",
            vec![100],
            Elements::F64((0..100).map(f64::from).collect()),
        ),
        ("run/filled", vec![10], Elements::F64(vec![7.0; 10])),
    ];
    for (name, shape, elements) in cases {
        expect(&mut store, name, &shape, elements);
    }
    let Elements::F32(values) = read(&mut store, "run/chunks").elements else {
        panic!("single precision stays single");
    };
    let worst = values
        .iter()
        .zip(0_u8..)
        .map(|(value, i)| (value - f32::from(i).sin()).abs());
    assert!(values.len() == 200 && worst.fold(0.0, f32::max) < 1e-6);
    let soft = Elements::F64(vec![0.0, 0.25, 0.5, 0.75, 1.0]);
    expect(&mut store, "run/soft", &[5], soft);
}

#[test]
fn links_to_another_file_and_to_a_group_around_them_are_findings() {
    let mut store = open(H5PY);
    assert!(store.list().len() < 25, "{}", store.list().len());
    assert_eq!(damage(&mut store), [""; 0]);
    let findings = store.take_findings();
    let details = findings.iter().map(|finding| finding.detail.as_deref());
    let details: Vec<&str> = details.flatten().collect();
    let expected = [
        "hard link to a group, /run/loop, that holds it",
        "external link to /x of the file other.h5",
    ];
    assert_eq!(details, expected);
}

#[test]
fn a_file_of_matlab_is_read() {
    let mut store = open(MATLAB);
    let rows = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let pair = vec![Complex64::new(1.0, 2.0), Complex64::new(3.0, -4.0)];
    let cases = [
        ("a", vec![2, 3], Elements::F64(rows)),
        ("z", vec![1, 2], Elements::Complex(pair)),
        ("text", vec![], texts(&["m/s²"])),
        ("rows", vec![2], texts(&["ab", "cd"])),
        ("flag", vec![1, 1], Elements::F64(vec![1.0])),
        ("empty", vec![0, 3], Elements::F64(vec![])),
        ("c{1}", vec![], texts(&["1:+Z"])),
        ("c{2}", vec![1, 1], Elements::F64(vec![7.0])),
        ("s/fs", vec![1, 1], Elements::F64(vec![51200.0])),
        (
            "s/H",
            vec![2, 3],
            Elements::F32(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        ),
    ];
    for (name, shape, elements) in cases {
        expect(&mut store, name, &shape, elements);
    }
    assert!(store.list().iter().all(|info| !info.name.contains('#')));
    assert_eq!(damage(&mut store), [""; 0]);
}

#[cfg(not(feature = "libhdf5"))]
#[test]
fn datasets_that_need_libhdf5_are_reported_and_the_rest_is_read() {
    let mut store = open(NEWER);
    expect(
        &mut store,
        "plain",
        &[3],
        Elements::F64(vec![0.0, 1.0, 2.0]),
    );
    let said = damage(&mut store);
    for (name, why) in [
        ("btree2", "version 2 B-tree"),
        ("layout5", "layout of version 5"),
        ("native", "datatype class 11"),
    ] {
        let message = said.iter().find(|error| error.contains(name));
        let message = message.unwrap_or_else(|| panic!("{name}: {said:?}"));
        assert!(
            message.contains(why) && message.contains("--features libhdf5"),
            "{message}"
        );
    }
    assert_eq!(said.len(), 3);
}

/// Lists and reads every array, whole and in part.
fn read_everything(bytes: Vec<u8>, of_matlab: bool) -> usize {
    let stream = Stream::new(Box::new(Cursor::new(bytes))).unwrap();
    // On this thread, not a separate one, so that its memory is measured.
    let Ok(listing) = list_here(&stream, of_matlab, "damaged.h5") else {
        return 0;
    };
    let mut store = Hdf5Store::new("damaged.h5".to_owned(), stream, listing);
    let mut read = 0;
    for index in 0..store.list().len() {
        let whole = store.read(index);
        let len = whole.as_ref().map_or(10, |array| array.elements.len());
        let part = store.read_part(index, len / 3..len);
        // Damage elsewhere does not keep a part from being read.
        let part = part.map(|part| part.len());
        assert!(whole.is_err() || part.is_ok_and(|count| count == len - len / 3));
        read += usize::from(whole.is_ok());
    }
    read
}

#[test]
fn damaged_files_are_read_within_bounds() {
    let files = [(H5PY, false), (MATLAB, true), (NEWER, false)];
    let mut read = 0;
    for number in 0..1500_usize {
        let mut random = ChaCha8Rng::seed_from_u64(number as u64);
        let (packed, of_matlab) = files[number % files.len()];
        let mut bytes = unpacked(packed);
        for _ in 0..random.random_range(1..5) {
            let at = random.random_range(0..bytes.len());
            let end = (at + random.random_range(1..9)).min(bytes.len());
            match random.random_range(0..3) {
                0 => bytes[at] ^= 1 << random.random_range(0..8),
                1 => bytes[at] = random.random(),
                _ => bytes[at..end].fill(0xff),
            }
        }
        // The reader reserves memory for as many members as a datatype states, 65,535 at most,
        // before it looks for them.
        let most = 64 * bytes.len() as u64 + (16 << 20);
        let measured = || read += read_everything(bytes, of_matlab);
        let peak = allocation_counter::measure(measured).bytes_max;
        assert!(peak <= most, "file {number}: {peak} bytes");
    }
    assert!(read > 1500, "{read}");
}
