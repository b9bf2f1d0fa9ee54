//! Links of groups: names that lead to an object of the file (hard), to a path (soft) or to another
//! file (external).
//!
//! The reader follows hard links alone. It fails on a group of version 1 with a soft link, whose
//! entry has no address, and passes over those of newer groups. Here the links of all groups are
//! read, whatever their form, so that a soft link can be followed to the path of hard links that it
//! stands for, and the entries of version 1 that the reader fails on can be kept from it.
//!
//! # Reference
//! HDF5 File Format Specification, version 3.0.

use std::collections::{BTreeMap, BTreeSet};

use hdf5_pure::{Source, Superblock};

use super::stream::{Replacements, Stream};

mod dense;
mod fields;

use fields::Fields;

/// Soft links on the way to one object. The limit is that of the HDF5 library (`H5Pset_nlinks`);
/// it ends circles of links.
const MAX_SOFT_LINKS: usize = 16;

/// Characters of a path that are shown; a damaged file can state one as long as itself.
const MAX_SHOWN_CHARACTERS: usize = 200;

/// Memory of a link, a message or a record of a B-tree in addition to its bytes. Links that lead
/// back to bytes that were read take this again and again; the bytes of the names limit them, too.
const LINK_BYTES: u64 = 64;

/// Object header messages.
const LINK_INFO: u64 = 0x02;
const LINK: u64 = 0x06;
const CONTINUATION: u64 = 0x10;
const SYMBOL_TABLE: u64 = 0x11;

/// Cache type of a soft link in a symbol table node.
const SOFT_ENTRY: u64 = 2;

/// Where a link leads.
#[derive(Debug)]
enum Target {
    /// To the object whose header is at this address.
    Hard(u64),
    /// To the object of a path.
    Soft(String),
    /// To an object of another file.
    External {
        /// Name of the file.
        file: String,
        /// Path of the object in it.
        object: String,
    },
}

/// The links of a group by their names.
type GroupLinks = BTreeMap<String, Target>;

/// The links of all groups that hard links lead to.
pub(super) struct Links {
    /// By the address of the group.
    groups: BTreeMap<u64, GroupLinks>,
    /// Addresses of the groups with soft or external links.
    with_soft: BTreeSet<u64>,
    root: u64,
    /// Symbol table nodes without their soft links.
    nodes: Replacements,
}

/// An object: its path of hard links, and its address where a known group leads to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub path: String,
    pub address: Option<u64>,
}

impl Place {
    /// The object of a name in this group.
    pub fn member(&self, name: &str, address: Option<u64>) -> Self {
        let mut member = self.clone();
        member.enter(name, address);
        member
    }

    /// Goes from a group to the object of a name in it.
    fn enter(&mut self, name: &str, address: Option<u64>) {
        if !self.path.is_empty() {
            self.path.push('/');
        }
        self.path.push_str(name);
        self.address = address;
    }
}

/// Work of following soft links, which is limited for a whole file: many links can lead through the
/// same long path.
#[derive(Debug)]
pub(super) struct Following {
    /// Bytes of paths that may still be followed.
    pub path_bytes: u64,
    /// Soft links that were looked at.
    pub links: u64,
}

impl Following {
    /// With so many bytes of paths.
    pub fn new(path_bytes: u64) -> Self {
        Self {
            path_bytes,
            links: 0,
        }
    }

    /// Takes the bytes of a path and those of a link.
    fn take(&mut self, path: &str) -> Result<(), String> {
        let left = self.path_bytes.checked_sub(path.len() as u64 + LINK_BYTES);
        self.path_bytes = left.unwrap_or(0);
        self.links += 1;
        left.map(drop).ok_or_else(|| {
            "more bytes of paths than soft links of a file of its size have".to_owned()
        })
    }
}

/// A path for messages.
fn shown(path: &str) -> String {
    let mut characters = path.chars();
    let start: String = characters.by_ref().take(MAX_SHOWN_CHARACTERS).collect();
    match characters.next() {
        Some(_) => format!("{start}... ({} bytes)", path.len()),
        None => start,
    }
}

impl Links {
    /// Reads the links of every group, but those that are damaged: the reader reports these.
    /// `name_bytes` limits the bytes of all names and paths.
    pub fn read(stream: &Stream, superblock: &Superblock, name_bytes: u64) -> Self {
        // Stored addresses count from the base; the reader states that of the root from the start.
        let base = superblock.base_address.get();
        let mut walk = Walk {
            file: Bytes {
                stream,
                base,
                address_bytes: superblock.offset_size.into(),
                length_bytes: superblock.length_size.into(),
            },
            name_bytes,
            nodes: Replacements::default(),
        };
        let root = superblock.root_group_address.saturating_sub(base);
        let mut groups = BTreeMap::new();
        let mut seen = BTreeSet::from([root]);
        let mut open = vec![root];
        while let Some(address) = open.pop() {
            let Some(links) = walk.group(address) else {
                continue;
            };
            for target in links.values() {
                if let Target::Hard(member) = target
                    && seen.insert(*member)
                {
                    open.push(*member);
                }
            }
            groups.insert(address, links);
        }
        let nodes = walk.nodes;
        Self {
            with_soft: with_soft(&groups),
            groups,
            root,
            nodes,
        }
    }

    /// Takes the symbol table nodes without their soft links.
    pub fn take_nodes(&mut self) -> Replacements {
        std::mem::take(&mut self.nodes)
    }

    /// The root group.
    pub fn root(&self) -> Place {
        Place {
            path: String::new(),
            address: Some(self.root),
        }
    }

    /// Whether any group has soft or external links.
    pub fn any_soft(&self) -> bool {
        !self.with_soft.is_empty()
    }

    /// Whether a group has soft or external links.
    pub fn has_soft(&self, group: &Place) -> bool {
        let address = group.address;
        address.is_some_and(|address| self.with_soft.contains(&address))
    }

    /// Names of the soft and external links of a group.
    pub fn soft(&self, group: &Place) -> Vec<String> {
        let links = group.address.and_then(|address| self.groups.get(&address));
        let links = links.into_iter().flatten();
        let soft = links.filter(|(_, target)| !matches!(target, Target::Hard(_)));
        soft.map(|(name, _)| name.clone()).collect()
    }

    /// The address that a hard link of a group leads to.
    pub fn hard(&self, group: &Place, name: &str) -> Option<u64> {
        match self.groups.get(&group.address?)?.get(name)? {
            Target::Hard(address) => Some(*address),
            _ => None,
        }
    }

    /// Follows a link of a group to its object.
    ///
    /// # Errors
    /// Why it leads to none in this file.
    pub fn follow(
        &self,
        group: &Place,
        name: &str,
        following: &mut Following,
    ) -> Result<Place, String> {
        let mut place = group.clone();
        let stepped = self.step(&mut place, name, &mut 0, following);
        let links = group.address.and_then(|address| self.groups.get(&address));
        match links.and_then(|links| links.get(name)) {
            Some(Target::Soft(path)) => {
                stepped.map_err(|why| format!("soft link to {}: {why}", shown(path)))?;
            }
            _ => stepped?,
        }
        Ok(place)
    }

    /// Goes from a group to the object of a name, through `soft_links` so far.
    fn step(
        &self,
        place: &mut Place,
        name: &str,
        soft_links: &mut usize,
        following: &mut Following,
    ) -> Result<(), String> {
        let links = place.address.and_then(|address| self.groups.get(&address));
        let path = match (links, links.and_then(|links| links.get(name))) {
            (_, Some(Target::Soft(path))) => path,
            (_, Some(Target::Hard(address))) => {
                place.enter(name, Some(*address));
                return Ok(());
            }
            (_, Some(Target::External { file, object })) => {
                let (file, object) = (shown(file), shown(object));
                return Err(format!("external link to {object} of the file {file}"));
            }
            // The links of this group are damaged: the reader may find the name.
            (None, None) => {
                place.enter(name, None);
                return Ok(());
            }
            (Some(_), None) => {
                place.enter(name, None);
                return Err(format!("/{} is missing", shown(&place.path)));
            }
        };
        *soft_links += 1;
        if *soft_links > MAX_SOFT_LINKS {
            return Err(format!("more than {MAX_SOFT_LINKS} soft links in a row"));
        }
        following.take(path)?;
        if path.starts_with('/') {
            *place = self.root();
        }
        for name in path.split('/').filter(|name| !matches!(*name, "" | ".")) {
            self.step(place, name, soft_links, following)?;
        }
        Ok(())
    }
}

/// Addresses of the groups with soft or external links.
fn with_soft(groups: &BTreeMap<u64, GroupLinks>) -> BTreeSet<u64> {
    let is_soft = |target: &Target| !matches!(target, Target::Hard(_));
    let groups = groups
        .iter()
        .filter(|(_, links)| links.values().any(is_soft));
    groups.map(|(address, _)| *address).collect()
}

/// The bytes of the file.
struct Bytes<'a> {
    stream: &'a Stream,
    /// Addresses count from here.
    base: u64,
    address_bytes: usize,
    length_bytes: usize,
}

impl Bytes<'_> {
    /// `count` bytes at an address; nothing where the file does not hold them, or where too much of
    /// it was read.
    fn read(&self, address: u64, count: u64) -> Option<Vec<u8>> {
        let at = address.checked_add(self.base)?;
        let end = at.checked_add(count)?;
        // Memory is asked for only where the bytes are there.
        if end > self.stream.bytes() {
            return None;
        }
        let mut bytes = vec![0; usize::try_from(count).ok()?];
        self.stream.read_at(at, &mut bytes).ok()?;
        Some(bytes)
    }

    /// The undefined address.
    fn is_undefined(&self, address: u64) -> bool {
        address == u64::MAX >> (64 - 8 * self.address_bytes.clamp(1, 8))
    }
}

/// A message of an object header.
struct Message {
    kind: u64,
    data: Vec<u8>,
}

struct Walk<'a> {
    file: Bytes<'a>,
    /// Bytes of names and paths that may still be made.
    name_bytes: u64,
    nodes: Replacements,
}

impl Walk<'_> {
    /// The links of the object at an address; nothing where it is no group, or a damaged one.
    fn group(&mut self, address: u64) -> Option<GroupLinks> {
        let messages = self.messages(address)?;
        let mut links = GroupLinks::new();
        let mut is_group = false;
        for Message { kind, data } in messages {
            match kind {
                SYMBOL_TABLE => self.symbol_table(&data, &mut links)?,
                LINK_INFO => self.dense_links(&data, &mut links)?,
                LINK => self.link(&data, &mut links)?,
                _ => continue,
            }
            is_group = true;
        }
        is_group.then_some(links)
    }

    fn add(&mut self, name: &[u8], target: Target, links: &mut GroupLinks) -> Option<()> {
        let name = String::from_utf8_lossy(name).into_owned();
        let path_bytes = match &target {
            Target::Hard(_) => 0,
            Target::Soft(path) => path.len(),
            Target::External { file, object } => file.len() + object.len(),
        };
        let added = (name.len() + path_bytes) as u64 + LINK_BYTES;
        self.name_bytes = self.name_bytes.checked_sub(added)?;
        links.insert(name, target);
        Some(())
    }

    /// The messages of an object header that tell of links.
    fn messages(&mut self, address: u64) -> Option<Vec<Message>> {
        let start = self.file.read(address, 16)?;
        if start.starts_with(b"OHDR") {
            return self.messages_of_version_2(address);
        }
        let mut fields = Fields::new(&start);
        if fields.number(1)? != 1 {
            return None;
        }
        fields.skip(7)?;
        let length = fields.number(4)?;
        let mut blocks = vec![(address.checked_add(16)?, length)];
        let mut messages = Vec::new();
        while let Some((address, length)) = blocks.pop() {
            let bytes = self.file.read(address, length)?;
            let mut fields = Fields::new(&bytes);
            while let Some(kind) = fields.number(2) {
                let (size, flags) = (fields.number(2)?, fields.number(1)?);
                fields.skip(3)?;
                let data = fields.bytes(size)?;
                self.message(kind, flags, data, &mut messages, &mut blocks)?;
            }
        }
        Some(messages)
    }

    fn messages_of_version_2(&mut self, address: u64) -> Option<Vec<Message>> {
        // Signature, version, flags, times, limits of attributes, and the size in up to 8 bytes.
        const MAX_PREFIX_BYTES: u64 = 34;
        let held = self.file.stream.bytes().checked_sub(self.file.base)?;
        let held = held.checked_sub(address)?;
        let start = self.file.read(address, held.min(MAX_PREFIX_BYTES))?;
        let mut fields = Fields::new(&start);
        fields.skip(4)?;
        if fields.number(1)? != 2 {
            return None;
        }
        let flags = fields.number(1)?;
        fields.skip(if flags & 0x20 != 0 { 16 } else { 0 })?;
        fields.skip(if flags & 0x10 != 0 { 4 } else { 0 })?;
        let length = fields.number(1 << (flags & 3))?;
        let creation_order = if flags & 0x04 != 0 { 2 } else { 0 };
        let mut messages = Vec::new();
        let mut blocks = Vec::new();
        let first = address.checked_add(fields.position())?;
        let mut block = Some(self.file.read(first, length)?);
        while let Some(bytes) = block.take() {
            let mut fields = Fields::new(&bytes);
            // Fewer bytes than a message needs are a gap.
            while fields.left() >= 4 + creation_order {
                let (kind, size, flags) = (fields.number(1)?, fields.number(2)?, fields.number(1)?);
                fields.skip(creation_order)?;
                let data = fields.bytes(size)?;
                self.message(kind, flags, data, &mut messages, &mut blocks)?;
            }
            if let Some((address, length)) = blocks.pop() {
                // A signature before the messages, and a check sum behind them.
                let mut bytes = self.file.read(address, length)?;
                bytes.truncate(bytes.len().checked_sub(4)?);
                block = Some(bytes.split_off(4.min(bytes.len())));
            }
        }
        Some(messages)
    }

    /// Keeps a message that tells of links; a continuation is added to `blocks`.
    fn message(
        &mut self,
        kind: u64,
        flags: u64,
        data: &[u8],
        messages: &mut Vec<Message>,
        blocks: &mut Vec<(u64, u64)>,
    ) -> Option<()> {
        const SHARED: u64 = 0x02;
        match kind {
            CONTINUATION => {
                let mut fields = Fields::new(data);
                let address = fields.number(self.file.address_bytes)?;
                blocks.push((address, fields.number(self.file.length_bytes)?));
            }
            LINK_INFO | LINK | SYMBOL_TABLE if flags & SHARED == 0 => {
                self.name_bytes = self.name_bytes.checked_sub(LINK_BYTES)?;
                let data = data.to_vec();
                messages.push(Message { kind, data });
            }
            _ => {}
        }
        Some(())
    }

    /// A link message.
    fn link(&mut self, data: &[u8], links: &mut GroupLinks) -> Option<()> {
        let mut fields = Fields::new(data);
        fields.skip(1)?;
        let flags = fields.number(1)?;
        let kind = if flags & 0x08 != 0 {
            fields.number(1)?
        } else {
            0
        };
        fields.skip(if flags & 0x04 != 0 { 8 } else { 0 })?;
        fields.skip(if flags & 0x10 != 0 { 1 } else { 0 })?;
        let name_length = fields.number(1 << (flags & 3))?;
        let name = fields.bytes(name_length)?;
        let target = match kind {
            0 => Target::Hard(fields.number(self.file.address_bytes)?),
            1 => {
                let length = fields.number(2)?;
                Target::Soft(text(fields.bytes(length)?))
            }
            64 => {
                let length = fields.number(2)?;
                // A byte of version and flags, then two texts that a zero ends.
                let value = fields.bytes(length)?.get(1..)?;
                let mut texts = value.split(|byte| *byte == 0);
                Target::External {
                    file: text(texts.next()?),
                    object: text(texts.next()?),
                }
            }
            // The meaning of user-defined links is not in the file.
            _ => return Some(()),
        };
        self.add(name, target, links)
    }

    /// The links of a group of version 1: a B-tree of nodes, and a heap of names.
    fn symbol_table(&mut self, data: &[u8], links: &mut GroupLinks) -> Option<()> {
        let mut fields = Fields::new(data);
        let tree = fields.number(self.file.address_bytes)?;
        let heap = fields.number(self.file.address_bytes)?;
        let names = self.local_heap(heap)?;
        let mut open = vec![tree];
        while let Some(address) = open.pop() {
            let start = self.file.read(address, 8)?;
            let mut fields = Fields::new(&start);
            if fields.bytes(4)? != b"TREE" || fields.number(1)? != 0 {
                return None;
            }
            let (level, count) = (fields.number(1)?, fields.number(2)?);
            let (key, child) = (self.file.length_bytes, self.file.address_bytes);
            let length = 8 + 2 * child as u64 + count * (key + child) as u64;
            let node = self.file.read(address, length)?;
            let mut fields = Fields::new(&node);
            fields.skip(8 + 2 * child)?;
            for _ in 0..count {
                fields.skip(key)?;
                let address = fields.number(child)?;
                match level {
                    0 => self.symbol_node(address, &names, links)?,
                    _ => open.push(address),
                }
            }
        }
        Some(())
    }

    fn local_heap(&self, address: u64) -> Option<Vec<u8>> {
        let length = 8 + 2 * self.file.length_bytes + self.file.address_bytes;
        let heap = self.file.read(address, length as u64)?;
        let mut fields = Fields::new(&heap);
        if fields.bytes(4)? != b"HEAP" {
            return None;
        }
        fields.skip(4)?;
        let size = fields.number(self.file.length_bytes)?;
        fields.skip(self.file.length_bytes)?;
        self.file
            .read(fields.number(self.file.address_bytes)?, size)
    }

    fn symbol_node(&mut self, address: u64, names: &[u8], links: &mut GroupLinks) -> Option<()> {
        let start = self.file.read(address, 8)?;
        let mut fields = Fields::new(&start);
        if fields.bytes(4)? != b"SNOD" {
            return None;
        }
        fields.skip(2)?;
        let count = fields.number(2)?;
        let entry = 2 * self.file.address_bytes + 24;
        let node = self.file.read(address, 8 + count * entry as u64)?;
        let mut kept = start.clone();
        for bytes in node[8..].chunks_exact(entry) {
            let mut fields = Fields::new(bytes);
            let name = text_at(names, fields.number(self.file.address_bytes)?)?;
            let address = fields.number(self.file.address_bytes)?;
            let kind = fields.number(4)?;
            fields.skip(4)?;
            let target = match kind {
                SOFT_ENTRY => Target::Soft(text(text_at(names, fields.number(4)?)?)),
                _ => {
                    kept.extend_from_slice(bytes);
                    Target::Hard(address)
                }
            };
            self.add(name, target, links)?;
        }
        if kept.len() < node.len() {
            let kept_count = (kept.len() - 8) / entry;
            kept[6..8].copy_from_slice(&(kept_count as u16).to_le_bytes());
            kept.resize(node.len(), 0);
            self.nodes.add(address.checked_add(self.file.base)?, kept);
        }
        Some(())
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The bytes of a heap from `start` up to the next zero.
fn text_at(heap: &[u8], start: u64) -> Option<&[u8]> {
    let from = heap.get(usize::try_from(start).ok()?..)?;
    from.split(|byte| *byte == 0).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A root group that leads to itself, with so many soft links to one path.
    fn circle(path: &str, count: usize) -> Links {
        let mut links: GroupLinks = (0..count)
            .map(|number| (format!("s{number}"), Target::Soft(path.to_owned())))
            .collect();
        links.insert("b".to_owned(), Target::Hard(96));
        let groups = BTreeMap::from([(96, links)]);
        Links {
            with_soft: with_soft(&groups),
            groups,
            root: 96,
            nodes: Replacements::default(),
        }
    }

    #[test]
    fn a_long_path_is_followed_once_for_each_link() {
        let path = "b/".repeat(10_000);
        let links = circle(&path, 1);
        let mut following = Following::new(100_000);
        let place = links.follow(&links.root(), "s0", &mut following).unwrap();
        assert_eq!((place.path.len(), place.address), (19_999, Some(96)));
        assert_eq!(following.path_bytes, 100_000 - 20_000 - LINK_BYTES);
    }

    #[test]
    fn many_links_through_long_paths_end_at_the_limit() {
        // Each link leads to one link of a long path, so that the bytes of names are few.
        let mut links = circle("/long", 1_000);
        let long = Target::Soft("b/".repeat(10_000));
        let root = links.groups.get_mut(&96).unwrap();
        root.insert("long".to_owned(), long);
        let mut following = Following::new(200_000);
        let results = (0..1_000).map(|number| {
            let name = format!("s{number}");
            links.follow(&links.root(), &name, &mut following)
        });
        let followed = results.filter(Result::is_ok).count();
        assert_eq!(followed, 9);
        assert_eq!(following.path_bytes, 0);
        let error = links.follow(&links.root(), "s999", &mut following);
        assert!(error.unwrap_err().contains("more bytes of paths"));
    }

    #[test]
    fn a_long_path_is_shortened_in_messages() {
        let links = circle(&format!("gone/{}", "b/".repeat(10_000)), 1);
        let mut following = Following::new(100_000);
        let error = links.follow(&links.root(), "s0", &mut following);
        let error = error.unwrap_err();
        assert!(
            error.len() < 300 && error.contains("/gone is missing"),
            "{error}"
        );
    }
}
