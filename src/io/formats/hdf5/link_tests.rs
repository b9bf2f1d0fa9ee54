//! Soft and external links in files that h5py made (`tests/reference/hdf5_files.py`): in groups of
//! the oldest structure, in newer ones with few links, and in one with a heap of links.

use std::io::{Cursor, Read};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::list::list_here;
use super::open_store;
use super::store::Hdf5Store;
use super::stream::Stream;
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

/// An HDF5 file of the oldest structure that is being written.
struct OldFile {
    bytes: Vec<u8>,
}

/// A member of a group: its name, and the path of a soft link or the address of an object.
enum Member<'a> {
    Soft(String, &'a str),
    Object(String, u64),
}

fn words(values: &[u64]) -> Vec<u8> {
    values.iter().flat_map(|word| word.to_le_bytes()).collect()
}

impl OldFile {
    fn add(&mut self, bytes: &[u8]) -> u64 {
        let address = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        address as u64
    }

    /// The address of a group with these members.
    fn group(&mut self, members: &[Member]) -> u64 {
        let mut heap = vec![0; 8];
        let mut text = |text: &str| {
            let start = heap.len() as u64;
            heap.extend(text.as_bytes());
            heap.push(0);
            start
        };
        let mut node = b"SNOD\x01\0".to_vec();
        node.extend((members.len() as u16).to_le_bytes());
        for member in members {
            node.extend(match member {
                Member::Object(name, address) => words(&[text(name), *address, 0, 0, 0]),
                Member::Soft(name, path) => words(&[text(name), u64::MAX, 2, text(path), 0]),
            });
        }
        let names = self.add(&heap);
        let length = heap.len() as u64;
        let head = [b"HEAP\0\0\0\0".to_vec(), words(&[length, 1, names])];
        let heap = self.add(&head.concat());
        let node = self.add(&node);
        let limits = words(&[u64::MAX, u64::MAX, 0, node, length]);
        let tree = self.add(&[b"TREE\0\0\x01\0".to_vec(), limits].concat());
        // An object header of one message, the symbol table.
        let header = [1, 0, 1, 0, 1, 0, 0, 0, 24, 0, 0, 0, 0, 0, 0, 0];
        let message = [0x11, 0, 16, 0, 0, 0, 0, 0];
        self.add(&[&header[..], &message, &words(&[tree, heap])].concat())
    }

    fn finish(mut self, root: u64) -> Vec<u8> {
        let mut superblock = b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0\x04\0\x10\0\0\0\0\0".to_vec();
        let end = self.bytes.len() as u64;
        superblock.extend(words(&[0, u64::MAX, end, u64::MAX, 0, root, 0, 0, 0]));
        self.bytes[..96].copy_from_slice(&superblock);
        self.bytes
    }
}

#[test]
fn a_listing_ends_at_its_limit() {
    // 300 links to a group of 300 links that lead nowhere: 90,000 names.
    let mut file = OldFile { bytes: vec![0; 96] };
    let nowhere: Vec<Member> = (0..300)
        .map(|number| Member::Soft(format!("n{number:03}"), "/x"))
        .collect();
    let inner = file.group(&nowhere);
    let links = (0..300).map(|number| Member::Soft(format!("a{number:03}"), "/z"));
    let last = std::iter::once(Member::Object("z".to_owned(), inner));
    let members: Vec<Member> = links.chain(last).collect();
    let root = file.group(&members);
    let bytes = file.finish(root);
    let length = bytes.len();
    let stream = Stream::new(Box::new(Cursor::new(bytes))).unwrap();
    let listing = list_here(&stream, false, "links.h5").unwrap();
    let damage = listing.damage.iter().map(ToString::to_string);
    let damage: Vec<String> = damage.collect();
    assert!(
        damage.len() == 1 && damage[0].contains("more names"),
        "{damage:?}"
    );
    // Each takes 64 bytes of 16 times the file, and of 64 KiB.
    let most = (16 * length as u64 + (1 << 16)) / 64;
    assert!(
        most < 20_000 && listing.links_followed <= most,
        "{}",
        listing.links_followed
    );
}
