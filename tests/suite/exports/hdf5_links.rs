//! HDF5 files of the oldest structure with soft links in their groups.

use super::containers::{arrays, findings, inspected, values};

/// A member of a group.
#[derive(Clone, Copy, Debug)]
enum Member<'a> {
    /// The object whose header is at this address.
    Object(u64),
    /// A soft link to this path.
    Soft(&'a str),
}

/// A file that is being written; its groups follow their members.
struct File {
    bytes: Vec<u8>,
}

const UNDEFINED: u64 = u64::MAX;

/// Bytes of the superblock, which is written last.
const SUPERBLOCK_BYTES: usize = 96;

fn words(values: &[u64]) -> Vec<u8> {
    values.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// A message of an object header, filled up to 8 bytes.
fn message(kind: u16, mut data: Vec<u8>) -> Vec<u8> {
    data.resize(data.len().next_multiple_of(8), 0);
    let size = data.len() as u16;
    [&kind.to_le_bytes()[..], &size.to_le_bytes(), &[0; 4], &data].concat()
}

impl File {
    fn new() -> Self {
        Self {
            bytes: vec![0; SUPERBLOCK_BYTES],
        }
    }

    /// Adds bytes; their address.
    fn add(&mut self, bytes: &[u8]) -> u64 {
        let address = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        address as u64
    }

    fn object(&mut self, messages: &[Vec<u8>]) -> u64 {
        let body = messages.concat();
        let (count, size) = (messages.len() as u16, body.len() as u32);
        let mut header = vec![1, 0];
        header.extend(count.to_le_bytes());
        header.extend(1_u32.to_le_bytes());
        header.extend(size.to_le_bytes());
        header.extend([0; 4]);
        header.extend(body);
        self.add(&header)
    }

    /// Doubles in one dimension.
    fn dataset(&mut self, values: &[f64]) -> Member<'static> {
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let data_at = self.add(&data);
        let count = values.len() as u64;
        let space = [vec![1, 1, 0, 0, 0, 0, 0, 0], words(&[count])].concat();
        // Little-endian IEEE 754 of 64 bits.
        let mut double = vec![0x11, 0x20, 0x3f, 0, 8, 0, 0, 0];
        double.extend([0, 0, 64, 0, 52, 11, 0, 52, 0xff, 3, 0, 0]);
        let layout = [vec![3, 1], words(&[data_at, 8 * count])].concat();
        let messages = [message(1, space), message(3, double), message(8, layout)];
        Member::Object(self.object(&messages))
    }

    /// A group with members in the order of their names.
    fn group(&mut self, members: &[(&str, Member)]) -> Member<'static> {
        let mut heap = vec![0; 8];
        let mut text = |text: &str| {
            let start = heap.len() as u64;
            heap.extend(text.as_bytes());
            heap.resize((heap.len() + 1).next_multiple_of(8), 0);
            start
        };
        let mut node = b"SNOD\x01\0".to_vec();
        node.extend((members.len() as u16).to_le_bytes());
        for (name, member) in members {
            let name = text(name);
            let entry = match member {
                Member::Object(address) => words(&[name, *address, 0, 0, 0]),
                Member::Soft(path) => words(&[name, UNDEFINED, 2, text(path), 0]),
            };
            node.extend(entry);
        }
        let names_at = self.add(&heap);
        let heap_head = [
            b"HEAP\0\0\0\0".to_vec(),
            words(&[heap.len() as u64, 1, names_at]),
        ];
        let heap_at = self.add(&heap_head.concat());
        let node_at = self.add(&node);
        let tree = [
            b"TREE\0\0\x01\0".to_vec(),
            words(&[UNDEFINED, UNDEFINED, 0, node_at, heap.len() as u64]),
        ];
        let tree_at = self.add(&tree.concat());
        let table = message(0x11, words(&[tree_at, heap_at]));
        Member::Object(self.object(&[table]))
    }

    /// The file whose root group this is.
    fn finish(mut self, root: Member) -> Vec<u8> {
        let Member::Object(root) = root else {
            panic!("a group")
        };
        let mut superblock = b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0\x04\0\x10\0\0\0\0\0".to_vec();
        let end = self.bytes.len() as u64;
        superblock.extend(words(&[0, UNDEFINED, end, UNDEFINED, 0, root, 0, 0, 0]));
        self.bytes[..SUPERBLOCK_BYTES].copy_from_slice(&superblock);
        self.bytes
    }
}

#[test]
fn a_soft_link_beside_arrays_is_followed() {
    let mut file = File::new();
    let (h, freq) = (
        file.dataset(&[1.0, 2.0, 3.0]),
        file.dataset(&[5.0, 6.0, 7.0]),
    );
    let members = [("H", h), ("freq", freq), ("latest", Member::Soft("/H"))];
    let root = file.group(&members);
    let bytes = file.finish(root);
    let ran = inspected("link.h5", &bytes);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(
        arrays(&ran),
        ["H (3 f64)", "freq (3 f64)", "latest (3 f64)"]
    );
    assert!(findings(&ran).is_empty(), "{ran:?}");
    for name in ["H", "latest"] {
        let expected = [1.0, 2.0, 3.0];
        assert_eq!(values("link.h5", &bytes, name).unwrap(), expected);
    }
}

#[test]
fn links_that_lead_nowhere_are_findings_and_lose_no_array() {
    let mut file = File::new();
    let h = file.dataset(&[1.0]);
    let members = [
        ("H", h),
        ("a", Member::Soft("/b")),
        ("b", Member::Soft("a")),
        ("gone", Member::Soft("/nothing/here")),
        ("self", Member::Soft("self")),
        ("through", Member::Soft("H/x")),
    ];
    let root = file.group(&members);
    let ran = inspected("link.h5", &file.finish(root));
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(arrays(&ran), ["H (1 f64)"]);
    assert_eq!(findings(&ran), ["link-not-followed"; 5]);
    let text = ran.json()["files"][0]["findings"].to_string();
    for part in [
        "/nothing is missing",
        "16 soft links in a row",
        "soft link to /H/x",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn links_of_inner_groups_and_to_groups_are_followed() {
    let mut file = File::new();
    let y = file.dataset(&[1.0, 2.0]);
    let inner = [
        ("again", Member::Soft("y")),
        ("chain", Member::Soft("/first/again")),
        ("up", Member::Soft("/run")),
        ("y", y),
    ];
    let run = file.group(&inner);
    let members = [("first", Member::Soft("run")), ("run", run)];
    let root = file.group(&members);
    let bytes = file.finish(root);
    let ran = inspected("link.h5", &bytes);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let expected = [
        "run/y (2 f64)",
        "run/again (2 f64)",
        "run/chain (2 f64)",
        "first/y (2 f64)",
        "first/again (2 f64)",
        "first/chain (2 f64)",
    ];
    assert_eq!(arrays(&ran), expected);
    assert_eq!(findings(&ran), ["link-not-followed"; 2], "{ran:?}");
    let chain = values("link.h5", &bytes, "first.chain").unwrap();
    assert_eq!(chain, [1.0, 2.0]);
}

#[test]
fn a_group_of_links_alone_and_an_empty_one_are_no_damage() {
    let mut file = File::new();
    let x = file.dataset(&[4.0]);
    let links = file.group(&[("a", Member::Soft("/x")), ("b", Member::Soft("/x"))]);
    let empty = file.group(&[]);
    let root = file.group(&[("empty", empty), ("links", links), ("x", x)]);
    let ran = inspected("link.h5", &file.finish(root));
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let expected = ["x (1 f64)", "links/a (1 f64)", "links/b (1 f64)"];
    assert_eq!(arrays(&ran), expected);
}

#[test]
fn groups_that_links_double_again_and_again_end_as_damage() {
    // 25 groups, each with two links to the next one: 2^25 groups without an array.
    let names: Vec<String> = (10..36).map(|number| format!("g{number}")).collect();
    let paths: Vec<String> = names.iter().map(|name| format!("/{name}")).collect();
    let mut file = File::new();
    let mut members = Vec::new();
    for (number, name) in names.iter().enumerate() {
        let links: Vec<(&str, Member)> = match paths.get(number + 1) {
            Some(next) => vec![("a", Member::Soft(next)), ("b", Member::Soft(next))],
            None => Vec::new(),
        };
        members.push((name.as_str(), file.group(&links)));
    }
    let x = file.dataset(&[1.0]);
    members.push(("x", x));
    let root = file.group(&members);
    let ran = inspected("link.h5", &file.finish(root));
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert_eq!(arrays(&ran), ["x (1 f64)"]);
}
