//! One dataset as the list shows it: what its elements are, its shape, and how MATLAB presents it.

use std::collections::HashMap;

use hdf5_pure::{AttrValue, ChunkIndex, Dataset, Datatype, Error, FormatError, Layout};

use super::element::{Content, describe};

/// Datatypes nested deeper are refused.
const MAX_DATATYPE_NESTING: usize = 32;

/// Filters that the reader undoes: deflate, shuffle, Fletcher-32, scale-offset, LZF.
const FILTERS: [u16; 5] = [1, 2, 3, 6, 32000];

/// How the stored elements make the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Presentation {
    /// As they are stored.
    AsStored,
    /// MATLAB stores column by column, so that the lengths are stored in reverse order.
    ColumnMajor,
    /// Character codes of MATLAB, a text for each row.
    Characters,
    /// Nothing: MATLAB stores the lengths in place of the elements where there are none.
    Empty,
}

/// A dataset with the contents of its header.
pub(super) struct Item {
    /// The dataset.
    pub dataset: Dataset,
    /// Its path in the file; `None` where only a reference leads to it.
    pub path: Option<String>,
    /// The content of its elements.
    pub content: Content,
    /// The name of their type.
    pub kind: String,
    /// Bytes of one element.
    pub stride: usize,
    /// Lengths as stored, slowest first.
    pub stored: Vec<usize>,
    /// How the array is presented.
    pub presentation: Presentation,
    /// Why the elements cannot be read with the default reader although the format allows them.
    pub refusal: Option<String>,
    /// Whether the size was found to fit the file.
    pub size_checked: bool,
}

/// Why a dataset cannot be used at all.
pub(super) enum Unusable {
    /// The reader's complaint.
    Reader(Error),
    /// Ours.
    Shape(String),
}

impl From<Error> for Unusable {
    fn from(error: Error) -> Self {
        Unusable::Reader(error)
    }
}

impl Item {
    /// Reads the header; `of_matlab`: the file is MATLAB's.
    pub fn of(dataset: Dataset, path: Option<String>, of_matlab: bool) -> Result<Self, Unusable> {
        let datatype = dataset.datatype()?;
        if nesting(&datatype) > MAX_DATATYPE_NESTING {
            let got = format!("a datatype nested deeper than {MAX_DATATYPE_NESTING} levels");
            return Err(Unusable::Shape(got));
        }
        let (content, kind, stride, added) = describe(&datatype);
        let mut stored = Vec::new();
        for length in dataset.shape()? {
            let length = usize::try_from(length);
            stored.push(length.map_err(|_| Unusable::Shape("a length above 2^64".to_owned()))?);
        }
        let dimensions = stored.len();
        stored.extend(added);
        if bytes_of(&stored, stride).is_none() {
            return Err(Unusable::Shape(format!(
                "{stored:?} elements of {stride} bytes"
            )));
        }
        let refusal = refusal(&dataset, &content)?;
        let mut item = Self {
            dataset,
            path,
            content,
            kind,
            stride,
            stored,
            presentation: Presentation::AsStored,
            refusal,
            size_checked: false,
        };
        // Attributes of other programs say nothing here, so that a bad one does no harm.
        if of_matlab && dimensions == item.stored.len() {
            let attributes = item.dataset.attrs()?;
            item.as_matlab(&attributes)?;
        }
        Ok(item)
    }

    fn as_matlab(&mut self, attributes: &HashMap<String, AttrValue>) -> Result<(), Unusable> {
        let class = attributes.get("MATLAB_class").and_then(AttrValue::as_str);
        let class = class.map(|class| class.trim_end_matches('\0'));
        let empty = attributes.get("MATLAB_empty").and_then(AttrValue::as_u64);
        self.presentation = Presentation::ColumnMajor;
        if empty.is_some_and(|flag| flag != 0) {
            self.presentation = Presentation::Empty;
            // The lengths are stored slowest last.
            let few = self.stored.iter().product::<usize>() <= 32;
            let lengths = if few {
                self.dataset.read_u64()?
            } else {
                Vec::new()
            };
            let lengths = lengths.iter().rev();
            self.stored = lengths
                .map(|&length| usize::try_from(length).unwrap_or(0))
                .collect();
            if bytes_of(&self.stored, self.stride).is_none() {
                let got = format!("{:?} elements of an empty array", self.stored);
                return Err(Unusable::Shape(got));
            }
            if self.stored.iter().all(|&length| length > 0) {
                return Err(Unusable::Shape(
                    "an empty array without a length of 0".to_owned(),
                ));
            }
        }
        match class {
            Some("char") if self.presentation != Presentation::Empty => {
                self.presentation = Presentation::Characters;
            }
            Some("logical") => self.kind = "bool".to_owned(),
            Some("cell") => self.kind = "cell".to_owned(),
            _ => {}
        }
        if class == Some("char") {
            self.kind = "text".to_owned();
        }
        Ok(())
    }

    /// Whether the elements are references to the cells of MATLAB.
    pub fn is_cell(&self) -> bool {
        self.content == Content::References && self.presentation == Presentation::ColumnMajor
    }

    /// Whether its elements can be read.
    pub fn is_readable(&self) -> bool {
        let known = !matches!(
            self.content,
            Content::Other | Content::References | Content::NativeComplex
        );
        let empty = self.presentation == Presentation::Empty;
        (empty && self.kind != "cell")
            || (known && self.refusal.is_none())
            || (cfg!(feature = "libhdf5") && self.refusal.is_some() && self.path.is_some())
    }

    /// Lengths as the array is presented, slowest first.
    pub fn shape(&self) -> Vec<usize> {
        match self.presentation {
            Presentation::AsStored => self.stored.clone(),
            Presentation::ColumnMajor | Presentation::Empty => {
                self.stored.iter().rev().copied().collect()
            }
            Presentation::Characters => match self.stored.last() {
                Some(&rows) if rows != 1 && !self.stored.contains(&0) => vec![rows],
                _ => Vec::new(),
            },
        }
    }
}

/// Number of bytes of elements of `stride` bytes; `None` when it is out of range.
pub(super) fn bytes_of(lengths: &[usize], stride: usize) -> Option<usize> {
    // Without the zeros first, which would hide what overflows.
    let all = lengths.iter().filter(|&&length| length > 0);
    let bytes = all.copied().try_fold(stride, usize::checked_mul)?;
    let none = lengths.contains(&0);
    (bytes <= isize::MAX as usize).then_some(if none { 0 } else { bytes })
}

/// How many levels of datatypes lie in each other.
fn nesting(datatype: &Datatype) -> usize {
    let mut deepest = 0;
    let mut open = vec![(datatype, 1)];
    while let Some((datatype, level)) = open.pop() {
        deepest = deepest.max(level);
        match datatype {
            Datatype::Compound { members, .. } => {
                open.extend(members.iter().map(|member| (&member.datatype, level + 1)));
            }
            Datatype::Enumeration { base_type, .. }
            | Datatype::VariableLength { base_type, .. }
            | Datatype::Array { base_type, .. } => open.push((base_type, level + 1)),
            _ => {}
        }
    }
    deepest
}

/// The part of the dataset that the default reader cannot read.
fn refusal(dataset: &Dataset, content: &Content) -> Result<Option<String>, Error> {
    if *content == Content::NativeComplex {
        return Ok(Some("complex numbers of datatype class 11".to_owned()));
    }
    let layout = match dataset.layout() {
        Err(error) => return newer_format(&error).map(Some).ok_or(error),
        Ok(layout) => layout,
    };
    let unknown = dataset
        .filters()
        .into_iter()
        .find(|id| !FILTERS.contains(id));
    Ok(match layout {
        Layout::Virtual => Some("a virtual dataset".to_owned()),
        Layout::Chunked {
            index: ChunkIndex::BTreeV2,
            ..
        } => Some("chunks in a version 2 B-tree".to_owned()),
        _ => unknown.map(|id| format!("compression with filter {}", filter_name(id))),
    })
}

fn filter_name(id: u16) -> String {
    let name = match id {
        4 => "szip",
        5 => "nbit",
        307 => "bzip2",
        32001 => "blosc",
        32004 => "lz4",
        32008 => "bitshuffle",
        32013 => "zfp",
        32015 => "zstd",
        32026 => "blosc2",
        _ => return id.to_string(),
    };
    format!("{id} ({name})")
}

/// The error of the default reader for an unknown part of the format.
pub(super) fn newer_format(error: &Error) -> Option<String> {
    let Error::Format(error) = error else {
        return None;
    };
    Some(match error {
        FormatError::InvalidLayoutVersion(version) => format!("a data layout of version {version}"),
        FormatError::InvalidDatatypeClass(class) => format!("a datatype of class {class}"),
        FormatError::InvalidReferenceType(kind) => format!("references of type {kind}"),
        FormatError::UnsupportedFilter(id) => {
            format!("compression with filter {}", filter_name(*id))
        }
        FormatError::UnsupportedVirtualLayout => "a virtual dataset".to_owned(),
        FormatError::UnsupportedExternalStorage => "values in other files".to_owned(),
        _ => return None,
    })
}
