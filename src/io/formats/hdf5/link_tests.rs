//! Soft and external links in files that h5py made (`tests/reference/hdf5_files.py`): in groups of
//! the oldest structure, in newer ones with few links, and in one with a heap of links.

use std::io::{Cursor, Read};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::open_store;
use super::store::Hdf5Store;
use crate::io::formats::arrays::store::{ArrayStore, Elements};

const LINKS: &[u8] = include_bytes!("../../../../tests/reference/links.h5.gz");

fn unpacked() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut unpacked = flate2::read::GzDecoder::new(LINKS);
    unpacked.read_to_end(&mut bytes).unwrap();
    bytes
}

fn open(bytes: Vec<u8>) -> Hdf5Store {
    open_store(Box::new(Cursor::new(bytes)), "links.h5").unwrap()
}

fn names(store: &Hdf5Store) -> Vec<&str> {
    let infos = store.list().iter();
    infos.map(|info| info.name.as_str()).collect()
}

#[test]
fn soft_links_are_followed_wherever_they_lead_to_an_object() {
    let mut store = open(unpacked());
    let listed = names(&store);
    let away = ["away/z", "away/soft"];
    let run = ["run/y", "run/inner/through", "run/again", "run/twice"];
    let here = run.map(|name| name.replacen("run", "here", 1));
    let roots = ["H", "freq", "latest"];
    let here = here.iter().map(String::as_str);
    for name in roots.into_iter().chain(away).chain(run).chain(here) {
        let count = listed.iter().filter(|other| **other == name).count();
        assert_eq!(count, 1, "{name} in {listed:?}");
    }
    let many = listed.iter().filter(|name| name.starts_with("many/"));
    assert_eq!(many.count(), 1 + 117, "{listed:?}");
    assert!(store.take_damage().is_empty());
    for (name, expected) in [
        ("here/inner/through", vec![0.0, 1.0, 2.0]),
        ("many/soft119", vec![0.0, 1.0, 2.0, 3.0]),
        ("away/soft", vec![0.0, 1.0]),
    ] {
        let index = names(&store).iter().position(|other| *other == name);
        let array = store.read(index.unwrap()).unwrap();
        assert_eq!(array.elements, Elements::F64(expected), "{name}");
    }
}

#[test]
fn links_that_lead_nowhere_are_findings_with_their_cause() {
    let findings = open(unpacked()).take_findings();
    let detail = |name: &str| {
        let named = |finding: &&crate::Finding| finding.location.to_string().ends_with(name);
        let finding = findings.iter().find(named);
        finding.and_then(|finding| finding.detail.clone()).unwrap()
    };
    assert!(detail("gone").contains("/nothing is missing"));
    assert!(detail("self").contains("more than 16"));
    assert!(detail("run/up").contains("that holds it"));
    assert_eq!(
        detail("away/other"),
        "external link to /x/y of the file other.h5"
    );
    assert!(detail("away/near").contains(".. is missing"));
    assert!(detail("many/soft080").contains("soft link to gone"));
    assert_eq!(findings.len(), 2 + 2 + 2 + 3, "{findings:?}");
}

#[test]
fn a_damaged_file_of_links_never_panics() {
    let whole = unpacked();
    for seed in 0..400 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut bytes = whole.clone();
        for _ in 0..random.random_range(1..6) {
            let place = random.random_range(0..bytes.len());
            bytes[place] = random.random();
        }
        if seed % 8 == 0 {
            bytes.truncate(random.random_range(0..bytes.len()));
        }
        if let Ok(mut store) = open_store(Box::new(Cursor::new(bytes)), "links.h5") {
            for index in 0..store.list().len().min(20) {
                let _ = store.read(index);
            }
        }
    }
}
