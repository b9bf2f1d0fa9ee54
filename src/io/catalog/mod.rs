//! The headers of a file are listed in types common to every format.
//!
//! An entry is one record or function (FRF, coherence, ...) with its axis, degrees of freedom and
//! sample format; its samples stay in the file. Nothing here knows a file format, a source or a
//! scene.

mod damage;
pub(in crate::io) mod function_metadata;
mod function_type;
pub(in crate::io) mod sample_range;

use num_complex::Complex64;

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location};
use crate::geometry::Geometry;
use crate::io::IoError;
use crate::modal::Mode;
use crate::quantity::Quantity;
use crate::record::Role;

pub use damage::{Damage, Part};
pub use function_metadata::FunctionMetadata;
pub use function_type::FunctionType;

/// Abscissa of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EntryAxis {
    /// Even time axis.
    Time(TimeAxis),
    /// Even frequency axis.
    Frequency(FrequencyAxis),
    /// Anything else: uneven, or over something that is neither time nor frequency.
    General(GeneralAxis),
}

impl EntryAxis {
    /// First value and spacing of an even axis.
    pub fn even(&self) -> Option<(f64, f64)> {
        match self {
            EntryAxis::Time(axis) => Some((axis.start_s, axis.step_s)),
            EntryAxis::Frequency(axis) => Some((axis.start_hz, axis.step_hz)),
            EntryAxis::General(axis) => axis.even,
        }
    }

    /// The quantity of the axis.
    pub fn domain(&self) -> Domain {
        match self {
            EntryAxis::Time(_) => Domain::Time,
            EntryAxis::Frequency(_) => Domain::Frequency,
            EntryAxis::General(axis) => axis.domain,
        }
    }
}

/// The quantity of an abscissa.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Time, s.
    Time,
    /// Frequency, Hz.
    Frequency,
    /// The specific data type of dataset 58 (19 rotational speed, ...; 0 unknown), in the unit of
    /// the file.
    Other(i32),
}

/// An abscissa that is uneven or measures neither time nor frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralAxis {
    /// The measured quantity.
    pub domain: Domain,
    /// First value and spacing; `None` when it is uneven ([`crate::io::Source::abscissa`] gives the
    /// values).
    pub even: Option<(f64, f64)>,
    /// Number of values.
    pub len: usize,
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

/// The identification in a header that groups records into hits.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Identification {
    /// Version (sequence) number.
    pub version: i64,
    /// Load case.
    pub load_case: i64,
    /// The five ID lines, trimmed; `NONE` is empty.
    pub lines: [String; 5],
}

impl Identification {
    /// A title as the first ID line.
    pub(in crate::io) fn with_title(title: &str) -> Self {
        let mut identification = Self::default();
        title.trim().clone_into(&mut identification.lines[0]);
        identification
    }
}

/// One record or function of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The type of the function.
    pub function_type: FunctionType,
    /// Identification as the header gives it.
    pub identification: Identification,
    /// Response degree of freedom; `None` when the header names none.
    pub response: Option<Dof>,
    /// Reference degree of freedom; `None` when the header names none.
    pub reference: Option<Dof>,
    /// Whether the response is the name of a channel, because the file names no point; a stated
    /// point replaces it.
    pub response_is_channel: bool,
    /// Whether the reference is the name of a channel, as the response may be.
    pub reference_is_channel: bool,
    /// Quantity of the ordinate (of the numerator for an FRF); `None` when the header does not say.
    pub quantity: Option<Quantity>,
    /// Quantity of the ordinate's denominator (for an FRF); `None` when the header does not say.
    pub denominator: Option<Quantity>,
    /// Whether the header states a quantity other than force and motion by its code, as of
    /// numerator or denominator: pressure, strain, temperature.
    pub has_other_quantity: bool,
    /// SI value = `to_si` × stored value; `None` when the unit is not stated.
    pub to_si: Option<f64>,
    /// The unit text as the header gives it, for messages.
    pub unit_label: String,
    /// The role of the channel in a scene's table; `None` for formats whose quantity decides.
    pub role: Option<Role>,
    /// Abscissa, with the number of values.
    pub axis: EntryAxis,
    /// The unit text of the abscissa as the header gives it; empty when it gives none.
    pub axis_label: String,
    /// The description in the file of how the function was made.
    pub note: FunctionMetadata,
    /// How the values are stored.
    pub format: SampleFormat,
    /// Line (from 1) where the entry's header starts, for text.
    pub line: Option<u64>,
    /// Byte (from 0) where the entry's header starts.
    pub byte: Option<u64>,
}

impl Entry {
    /// An entry of which nothing is known but what it holds, over which axis, and how it is stored.
    pub fn new(function_type: FunctionType, axis: EntryAxis, format: SampleFormat) -> Self {
        Self {
            function_type,
            identification: Identification::default(),
            response: None,
            reference: None,
            response_is_channel: false,
            reference_is_channel: false,
            quantity: None,
            denominator: None,
            has_other_quantity: false,
            to_si: None,
            unit_label: String::new(),
            role: None,
            axis,
            axis_label: String::new(),
            note: FunctionMetadata::default(),
            format,
            line: None,
            byte: None,
        }
    }

    /// The response: of the header, or the stated one where the header names none or a channel.
    pub fn response_point(&self, stated: Option<&Dof>) -> Option<Dof> {
        stated_point(self.response.as_ref(), self.response_is_channel, stated)
    }

    /// The reference: of the header, or the stated one where the header names none or a channel.
    pub fn reference_point(&self, stated: Option<&Dof>) -> Option<Dof> {
        stated_point(self.reference.as_ref(), self.reference_is_channel, stated)
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self.axis {
            EntryAxis::Time(axis) => axis.len,
            EntryAxis::Frequency(axis) => axis.len,
            EntryAxis::General(axis) => axis.len,
        }
    }

    /// Whether it is a force, by its quantity or the scene's role.
    pub fn is_force(&self) -> bool {
        self.quantity == Some(Quantity::Force) || self.role == Some(Role::Force)
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

fn stated_point(header: Option<&Dof>, is_channel: bool, stated: Option<&Dof>) -> Option<Dof> {
    let (first, second) = match is_channel {
        true => (stated, header),
        false => (header, stated),
    };
    first.or(second).cloned()
}

/// One mode of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeEntry {
    /// The mode, its shape in the global frame.
    pub mode: Mode,
    /// Text that names it, trimmed, without empty lines.
    pub title: Vec<String>,
    /// Modal A of dataset 55 (Σ φφᵀ/(modal A (s − λ)) + conj.), when the file gives it.
    pub modal_a: Option<Complex64>,
    /// Modal B of dataset 55, when the file gives it.
    pub modal_b: Option<Complex64>,
    /// Line (from 1) where its header starts, for text.
    pub line: Option<u64>,
}

impl ModeEntry {
    /// A mode of which the file says nothing more.
    pub fn new(mode: Mode) -> Self {
        Self {
            mode,
            title: Vec::new(),
            modal_a: None,
            modal_b: None,
            line: None,
        }
    }
}

/// A named array or column of a file that does not say what it means; a scene may.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArrayInfo {
    /// Its name, with `/` or `.` between levels as the format writes it; a column's heading.
    pub name: String,
    /// Lengths, slowest first as NumPy prints them; empty for one value.
    pub shape: Vec<usize>,
    /// The type of its elements: `f64`, `f32`, `i16`, `complex f64`, `text`, `struct`, ...
    pub kind: String,
}

/// The contents of a file, from its headers.
#[derive(Debug, Default)]
pub struct Catalog {
    /// Format name.
    pub format: &'static str,
    /// Path as given.
    pub path: String,
    /// Records and functions in file order.
    pub entries: Vec<Entry>,
    /// Modes, in file order.
    pub modes: Vec<ModeEntry>,
    /// Arrays and columns that the file does not say the meaning of.
    pub arrays: Vec<ArrayInfo>,
    /// Nodes, trace lines and what else describes the points.
    pub geometry: Geometry,
    /// Title lines of the file (universal dataset 151), trimmed, without empty ones.
    pub title: Vec<String>,
    /// Parts that could not be read. A chain stops at the first that it needs, unless the good part
    /// of a file is sufficient.
    pub damage: Vec<Damage>,
    /// Findings of the headers.
    pub findings: Vec<Finding>,
}

impl Catalog {
    /// Keeps the damage of a part of the file, with the finding that reports it.
    pub(in crate::io) fn note_damage(&mut self, error: IoError, part: Part) {
        let (line, byte) = match &error {
            IoError::Text { line, .. } => (Some(*line), None),
            IoError::Binary { byte, .. } | IoError::Truncated { byte, .. } => (None, Some(*byte)),
            _ => (None, None),
        };
        let location = Location::File {
            path: self.path.clone(),
            line,
            byte,
        };
        self.note_damage_at(error, part, location);
    }

    /// As [`Catalog::note_damage`], for damage that is noticed at a position.
    pub(in crate::io) fn note_damage_at(&mut self, error: IoError, part: Part, location: Location) {
        let finding = Finding::new(part.severity(), Code::BadDataset, location);
        self.findings.push(finding.detail(error.without_place()));
        self.damage.push(Damage { error, part });
    }
}
