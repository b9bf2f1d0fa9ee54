//! The datasets of every group, by their paths.
//!
//! Only hard links are followed: the reader passes over soft and external links. Hard links can
//! still lead back to a group that is being listed, so that depth, number and the bytes that are
//! read are limited.

use hdf5_pure::{Dataset, Error, File, Group, Object};

use super::item::{Item, Unusable};
use super::stream::Stream;
use crate::io::{ArrayInfo, IoError};

/// Groups and cells in each other.
const MAX_NESTING: usize = 32;

/// Cells of one array of MATLAB.
const MAX_CELLS: usize = 10_000;

/// The listing reads at most so many times the file's length.
const MAX_READS_OVER_LENGTH: u64 = 16;

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
    stream.allow(MAX_READS_OVER_LENGTH);
    let file = File::from_source(stream.clone()).map_err(|error| IoError::Binary {
        path: path.to_owned(),
        byte: 0,
        what: "HDF5 superblock",
        got: error.to_string(),
        expected: "a whole HDF5 file".to_owned(),
    })?;
    let mut walk = Walk {
        path,
        of_matlab,
        listing: Listing::default(),
        name_bytes: stream
            .bytes()
            .saturating_mul(MAX_READS_OVER_LENGTH)
            .saturating_add(1 << 16),
    };
    walk.group(&file.root(), "", 0);
    Ok(walk.listing)
}

struct Walk<'a> {
    path: &'a str,
    of_matlab: bool,
    listing: Listing,
    /// Bytes of names that may still be made.
    name_bytes: u64,
}

impl Walk<'_> {
    fn group(&mut self, group: &Group, name: &str, depth: usize) {
        if depth > MAX_NESTING {
            return self.damage(name, format!("groups in groups, {depth} deep"));
        }
        let datasets = match group.iter_datasets() {
            Ok(datasets) => datasets,
            // The groups would fail with the same error.
            Err(error) => return self.damage(name, error.to_string()),
        };
        for (member, dataset) in datasets {
            let path = joined(name, &member);
            self.dataset(dataset, path.clone(), Some(path), depth);
        }
        let groups = match group.iter_groups() {
            Ok(groups) => groups,
            Err(error) => return self.damage(name, error.to_string()),
        };
        for (member, group) in groups {
            let hidden = self.of_matlab && depth == 0 && HIDDEN_GROUPS.contains(&member.as_str());
            if !hidden {
                self.group(&group, &joined(name, &member), depth + 1);
            }
        }
    }

    /// Lists a dataset; `path` is absent for a dataset that only references reach.
    fn dataset(&mut self, dataset: Dataset, name: String, path: Option<String>, depth: usize) {
        // An entry of the list takes memory beside its name.
        let Some(left) = self.name_bytes.checked_sub(name.len() as u64 + 64) else {
            return self.listing_too_long();
        };
        self.name_bytes = left;
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
                Object::Group(group) => self.group(&group, &name, depth + 1),
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

    fn listing_too_long(&mut self) {
        let said = self.name_bytes == 0;
        self.name_bytes = 0;
        if !said {
            self.damage("", "more names than a file of its size can hold".to_owned());
        }
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
