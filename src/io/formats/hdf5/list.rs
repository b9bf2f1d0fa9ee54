//! The datasets of every group, by their paths.
//!
//! The object of a soft link is listed under the name of the link, too; a link that leads to no
//! object of the file, or back to a group that holds it, is a finding. Links can list a group many
//! times, so that depth, bytes of names and the bytes that are read are limited.

use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use hdf5_pure::{Dataset, Error, File, Group, Object};

use super::item::{Item, Unusable};
use super::links::{Following, Links, Place};
use super::stream::Stream;
use crate::finding::{Code, Finding, Location, Severity};
use crate::io::{ArrayInfo, IoError};

/// Groups and cells in each other.
const MAX_NESTING: usize = 32;

/// Cells of one array of MATLAB.
const MAX_CELLS: usize = 10_000;

/// The listing reads at most so many times the file's length.
const MAX_READS_OVER_LENGTH: u64 = 16;

/// Memory of an entry of the list, a link or a finding in addition to its texts.
const ENTRY_BYTES: u64 = 64;

/// Stack of the listing, for datatypes in datatypes.
const STACK_BYTES: usize = 128 << 20;

/// Groups of MATLAB that hold what others refer to.
const HIDDEN_GROUPS: [&str; 2] = ["#refs#", "#subsystem#"];

/// The contents of a file.
#[derive(Default)]
pub(super) struct Listing {
    /// The datasets for people.
    pub infos: Vec<ArrayInfo>,
    /// The same datasets.
    pub items: Vec<Item>,
    /// Parts that cannot be listed or read.
    pub damage: Vec<IoError>,
    /// Links that lead nowhere.
    pub findings: Vec<Finding>,
    /// Soft links that were looked at.
    #[cfg(test)]
    pub links_followed: u64,
}

/// Lists an HDF5 file.
///
/// The reader parses datatypes in datatypes by recursion without a limit, and a message of 64 KiB
/// holds 8,000 of them; the listing therefore runs on a stack on which they fit, and what is nested
/// deep is refused before it is read.
///
/// # Errors
/// [`IoError::Binary`] when the superblock or the root group cannot be read; [`IoError::System`]
/// without a thread.
pub(super) fn list(stream: &Stream, of_matlab: bool, path: &str) -> Result<Listing, IoError> {
    let listing = std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().stack_size(STACK_BYTES);
        let thread = builder.spawn_scoped(scope, || list_here(stream, of_matlab, path))?;
        Ok(thread
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    listing.map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "start a thread to read",
        source,
    })?
}

/// [`list`] on the caller's stack.
pub(super) fn list_here(stream: &Stream, of_matlab: bool, path: &str) -> Result<Listing, IoError> {
    let open = || {
        File::from_source(stream.clone()).map_err(|error| IoError::Binary {
            path: path.to_owned(),
            byte: 0,
            what: "HDF5 superblock",
            got: error.to_string(),
            expected: "a whole HDF5 file".to_owned(),
        })
    };
    let name_bytes = stream
        .bytes()
        .saturating_mul(MAX_READS_OVER_LENGTH)
        .saturating_add(1 << 16);
    stream.allow(MAX_READS_OVER_LENGTH);
    let mut links = Links::read(stream, open()?.superblock(), name_bytes);
    stream.replace(links.take_nodes());
    stream.allow(MAX_READS_OVER_LENGTH);
    let file = open()?;
    let mut walk = Walk {
        path,
        of_matlab,
        file: &file,
        links: &links,
        open: Vec::new(),
        known: BTreeMap::new(),
        pending: VecDeque::new(),
        listing: Listing::default(),
        name_bytes,
        is_cut: false,
        following: Following::new(name_bytes),
    };
    walk.group(&file.root(), &links.root(), "", 0);
    walk.soft_links();
    #[cfg(test)]
    {
        walk.listing.links_followed = walk.following.links;
    }
    Ok(walk.listing)
}

struct Walk<'a> {
    path: &'a str,
    of_matlab: bool,
    file: &'a File,
    links: &'a Links,
    /// Addresses of the groups that are being listed, each in the one before it.
    open: Vec<u64>,
    /// Members of listed groups by the path of the group, in a file with soft links.
    known: BTreeMap<String, Rc<Members>>,
    /// Groups whose soft links are not listed yet.
    pending: VecDeque<Pending>,
    listing: Listing,
    /// Bytes of names that may still be made.
    name_bytes: u64,
    /// Whether more names would have to be made: the listing ends.
    is_cut: bool,
    following: Following,
}

/// A group that was listed but for its soft links.
struct Pending {
    group: Place,
    /// The name it is listed under.
    name: String,
    depth: usize,
    /// Addresses of the groups that it was listed in.
    open: Vec<u64>,
}

/// The datasets and groups of a group.
#[derive(Default)]
struct Members {
    objects: Vec<(String, Object)>,
    /// Place in `objects` by the name.
    numbers: BTreeMap<String, usize>,
}

impl Walk<'_> {
    /// Lists the members of a group under `name`, but for those that its soft links lead to.
    fn group(&mut self, group: &Group, place: &Place, name: &str, depth: usize) {
        // Members that are known are listed without reading, so that bytes read are no limit here.
        if !self.takes(name.len() + place.path.len()) {
            return;
        }
        if depth > MAX_NESTING {
            return self.damage(name, format!("groups in groups, {depth} deep"));
        }
        self.open.extend(place.address);
        let members = self.members(group, place, name);
        for (member, object) in &members.objects {
            if self.is_cut {
                break;
            }
            let name = joined(name, member);
            let place = place.member(member, self.links.hard(place, member));
            match object {
                Object::Dataset(dataset) => {
                    self.dataset((**dataset).clone(), name, Some(place.path), depth);
                }
                Object::Group(_) if self.is_hidden(member, depth) => {}
                Object::Group(_) if self.holds(&place) => {
                    let why = format!("hard link to a group, /{}, that holds it", place.path);
                    self.pass_over(name, why);
                }
                Object::Group(group) => self.group(group, &place, &name, depth + 1),
                _ => {}
            }
        }
        if self.links.has_soft(place) {
            self.put_off(place, name, depth);
        }
        let held = self.open.len() - usize::from(place.address.is_some());
        self.open.truncate(held);
    }

    fn is_hidden(&self, member: &str, depth: usize) -> bool {
        self.of_matlab && depth == 0 && HIDDEN_GROUPS.contains(&member)
    }

    /// Puts the soft links of a group off until all groups that hard links lead to are listed.
    fn put_off(&mut self, place: &Place, name: &str, depth: usize) {
        let texts = place.path.len() + name.len() + size_of_val(self.open.as_slice());
        if self.takes(texts) {
            self.pending.push_back(Pending {
                group: place.clone(),
                name: name.to_owned(),
                depth,
                open: self.open.clone(),
            });
        }
    }

    /// Lists what soft links lead to, which may be groups with soft links.
    fn soft_links(&mut self) {
        while let Some(pending) = self.pending.pop_front() {
            self.open.clone_from(&pending.open);
            for link in self.links.soft(&pending.group) {
                if self.is_cut {
                    return;
                }
                let name = joined(&pending.name, &link);
                if let Err(why) = self.soft_link(&pending, &link, &name) {
                    self.pass_over(name, why);
                }
            }
        }
    }

    /// Lists the object that a soft link of a group leads to under the link's name.
    ///
    /// # Errors
    /// Why it leads to no array or group of the file.
    fn soft_link(&mut self, from: &Pending, link: &str, name: &str) -> Result<(), String> {
        let place = self.links.follow(&from.group, link, &mut self.following)?;
        if self.holds(&place) {
            let path = place.path;
            return Err(format!("soft link to a group, /{path}, that holds it"));
        }
        // A handle holds the path, too.
        if !self.takes(2 * place.path.len()) {
            return Ok(());
        }
        match self.object(&place.path) {
            Ok(Object::Dataset(dataset)) => {
                self.dataset(*dataset, name.to_owned(), Some(place.path), from.depth);
            }
            Ok(Object::Group(group)) => self.group(&group, &place, name, from.depth + 1),
            Ok(_) => return Err(format!("soft link to /{}, which is no array", place.path)),
            Err(error) => return Err(format!("soft link to /{}: {error}", place.path)),
        }
        Ok(())
    }

    /// Whether a group is one of those that are being listed.
    fn holds(&self, group: &Place) -> bool {
        let address = group.address;
        address.is_some_and(|address| self.open.contains(&address))
    }

    /// Datasets and groups of a group. They are kept where soft links may lead to them: the reader
    /// would read the whole group for each member that is looked up.
    fn members(&mut self, group: &Group, place: &Place, name: &str) -> Rc<Members> {
        if let Some(members) = self.known.get(&place.path) {
            return Rc::clone(members);
        }
        let mut members = Members::default();
        match (group.iter_datasets(), group.iter_groups()) {
            (Ok(datasets), Ok(groups)) => {
                let boxed = |dataset| Object::Dataset(Box::new(dataset));
                let datasets = datasets.map(|(name, dataset)| (name, boxed(dataset)));
                let groups = groups.map(|(name, group)| (name, Object::Group(group)));
                members.objects = datasets.chain(groups).collect();
            }
            (Err(error), _) | (_, Err(error)) => self.damage(name, error.to_string()),
        }
        let names = members.objects.iter().map(|(name, _)| name.clone());
        members.numbers = names.zip(0..).collect();
        let members = Rc::new(members);
        if place.address.is_some() && self.links.any_soft() {
            self.known.insert(place.path.clone(), Rc::clone(&members));
        }
        members
    }

    /// The object of a path of hard links.
    fn object(&self, path: &str) -> Result<Object, Error> {
        let (parent, name) = path.rsplit_once('/').unwrap_or(("", path));
        let known = self.known.get(parent).and_then(|members| {
            let number = members.numbers.get(name)?;
            members.objects.get(*number).map(|(_, object)| object)
        });
        match known {
            Some(Object::Dataset(dataset)) => Ok(Object::Dataset(dataset.clone())),
            Some(Object::Group(group)) => Ok(Object::Group(group.clone())),
            _ => match self.file.dataset(path) {
                Err(Error::NotADataset(_)) => self.file.group(path).map(Object::Group),
                dataset => dataset.map(|dataset| Object::Dataset(Box::new(dataset))),
            },
        }
    }

    /// Takes so many bytes, and as many as an entry needs beside its texts, from those that names
    /// may take; whether they were left.
    fn takes(&mut self, bytes: usize) -> bool {
        let left = self.name_bytes.checked_sub(bytes as u64 + ENTRY_BYTES);
        self.name_bytes = left.unwrap_or(0);
        if left.is_none() && !self.is_cut {
            self.is_cut = true;
            self.damage("", "more names than a file of its size can hold".to_owned());
        }
        !self.is_cut
    }

    fn pass_over(&mut self, name: String, why: String) {
        if !self.takes(name.len() + why.len()) {
            return;
        }
        let location = Location::Parameter(name);
        let finding = Finding::new(Severity::Warning, Code::LinkNotFollowed, location);
        self.listing.findings.push(finding.detail(why));
    }

    /// Lists a dataset; `path` is absent for a dataset that only references reach.
    fn dataset(&mut self, dataset: Dataset, name: String, path: Option<String>, depth: usize) {
        if !self.takes(name.len()) {
            return;
        }
        let item = match Item::of(dataset, path, self.of_matlab) {
            Ok(item) => item,
            Err(Unusable::Shape(got)) => return self.damage(&name, got),
            Err(Unusable::Reader(error)) => {
                let refused = super::item::newer_format(&error);
                return match refused {
                    Some(got) => self.refuse(&name, &got),
                    None => self.damage(&name, error.to_string()),
                };
            }
        };
        let cells = item.is_cell().then(|| self.cells(&item, &name)).flatten();
        if !item.is_readable()
            && let Some(got) = &item.refusal
        {
            self.refuse(&name, got);
        }
        self.listing.infos.push(ArrayInfo {
            name: name.clone(),
            shape: item.shape(),
            kind: item.kind.clone(),
        });
        self.listing.items.push(item);
        for (number, cell) in cells.into_iter().flatten().enumerate() {
            let name = format!("{name}{{{}}}", number + 1);
            match cell {
                Object::Dataset(dataset) if depth < MAX_NESTING => {
                    self.dataset(*dataset, name, None, depth + 1);
                }
                Object::Group(group) => {
                    // A reference leads here, not a path, so that links are not followed.
                    let place = Place {
                        path: name.clone(),
                        address: None,
                    };
                    self.group(&group, &place, &name, depth + 1);
                }
                _ => self.damage(&name, format!("a cell, {depth} deep, that is not read")),
            }
        }
    }

    /// The objects that the cells refer to.
    fn cells(&mut self, item: &Item, name: &str) -> Option<Vec<Object>> {
        let count: usize = item.stored.iter().product();
        if count > MAX_CELLS {
            self.damage(name, format!("{count} cells, expected at most {MAX_CELLS}"));
            return None;
        }
        let cells: Result<Vec<Object>, Error> = item.dataset.dereference();
        cells
            .map_err(|error| self.damage(name, error.to_string()))
            .ok()
    }

    fn damage(&mut self, name: &str, got: String) {
        self.listing.damage.push(unreadable(self.path, name, got));
    }

    fn refuse(&mut self, name: &str, got: &str) {
        self.listing.damage.push(refused(self.path, name, got));
    }
}

fn joined(group: &str, name: &str) -> String {
    if group.is_empty() {
        name.to_owned()
    } else {
        format!("{group}/{name}")
    }
}

/// An error of a part of the file.
pub(super) fn unreadable(path: &str, name: &str, got: String) -> IoError {
    IoError::Grouping {
        path: path.to_owned(),
        what: "reading HDF5",
        got: if name.is_empty() {
            got
        } else {
            format!("{name}: {got}")
        },
        expected: "a dataset that the file holds whole".to_owned(),
    }
}

/// An error of a dataset that only the library of The HDF Group reads.
pub(super) fn refused(path: &str, name: &str, got: &str) -> IoError {
    IoError::Grouping {
        path: path.to_owned(),
        what: "reading HDF5",
        got: format!("{name}: {got}"),
        expected: "what the default reader knows: build with --features libhdf5, or rewrite the file with h5repack"
            .to_owned(),
    }
}
