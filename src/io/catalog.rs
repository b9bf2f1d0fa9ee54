//! What the headers of a file say, in types that every format shares.

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::finding::Finding;
use crate::geometry::Geometry;
use crate::quantity::Quantity;
use crate::record::Role;

use super::IoError;

/// What an entry holds; the numbers are those of universal file dataset 58.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionType {
    /// 1, a time history.
    Time,
    /// 4, a frequency response function.
    Frf,
    /// 6, ordinary coherence.
    Coherence,
    /// Any other number (0 general, 2 auto spectrum, 3 cross spectrum, ...).
    Other(i32),
}

impl FunctionType {
    /// From the dataset-58 number.
    pub fn from_code(code: i32) -> Self {
        match code {
            1 => FunctionType::Time,
            4 => FunctionType::Frf,
            6 => FunctionType::Coherence,
            other => FunctionType::Other(other),
        }
    }

    /// The dataset-58 number.
    pub fn code(self) -> i32 {
        match self {
            FunctionType::Time => 1,
            FunctionType::Frf => 4,
            FunctionType::Coherence => 6,
            FunctionType::Other(code) => code,
        }
    }
}

/// Abscissa of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EntryAxis {
    /// Even time axis.
    Time(TimeAxis),
    /// Even frequency axis.
    Frequency(FrequencyAxis),
}

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleFormat {
    /// Real, single precision.
    RealF32,
    /// Real, double precision (and numbers written as text).
    RealF64,
    /// Complex, single precision.
    ComplexF32,
    /// Complex, double precision (and numbers written as text).
    ComplexF64,
}

/// What a header says about which records belong together.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Identification {
    /// Version (sequence) number.
    pub version: i64,
    /// Load case.
    pub load_case: i64,
    /// The five ID lines, trimmed; `NONE` is empty.
    pub lines: [String; 5],
}

/// One record or function of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it is.
    pub function_type: FunctionType,
    /// Identification as the header gives it.
    pub identification: Identification,
    /// Response degree of freedom; `None` when the header names none.
    pub response: Option<Dof>,
    /// Reference degree of freedom; `None` when the header names none.
    pub reference: Option<Dof>,
    /// Quantity of the ordinate (of the numerator for an FRF); `None` when the header does not say.
    pub quantity: Option<Quantity>,
    /// Quantity of the ordinate's denominator (for an FRF); `None` when the header does not say.
    pub denominator: Option<Quantity>,
    /// SI value = `to_si` × stored value; `None` when the unit is not stated.
    pub to_si: Option<f64>,
    /// The unit text as the header gives it, for messages.
    pub unit_label: String,
    /// What a scene's table says the channel is; `None` for formats whose quantity decides.
    pub role: Option<Role>,
    /// Abscissa, with the number of values.
    pub axis: EntryAxis,
    /// How the values are stored.
    pub format: SampleFormat,
    /// Line (from 1) where the entry's header starts, for text.
    pub line: Option<u64>,
    /// Byte (from 0) where the entry's header starts.
    pub byte: Option<u64>,
}

impl Entry {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self.axis {
            EntryAxis::Time(axis) => axis.len,
            EntryAxis::Frequency(axis) => axis.len,
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a file holds, from its headers.
#[derive(Debug, Default)]
pub struct Catalog {
    /// Format name.
    pub format: &'static str,
    /// Path as given.
    pub path: String,
    /// Records and functions in file order.
    pub entries: Vec<Entry>,
    /// Nodes and trace lines.
    pub geometry: Geometry,
    /// Title lines of the file (universal dataset 151), trimmed, without empty ones.
    pub title: Vec<String>,
    /// Parts that could not be read, each with its place. A chain stops at the first unless part of a file will do.
    pub damage: Vec<IoError>,
    /// What the headers say besides.
    pub findings: Vec<Finding>,
}
