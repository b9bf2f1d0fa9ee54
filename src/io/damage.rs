//! Damaged parts of a file: the error of each, and what it holds, which decides whose answer needs
//! it.
//!
//! A part that an answer does not need never stops it: its damage is a finding. Frequencies,
//! damping and shapes need FRFs or mode shapes; neither trace lines, titles, coherence and spectra,
//! nor, without local directions, nodes.

use std::fmt;

use super::{Catalog, FunctionType, IoError, Source};
use crate::finding::{Code, Finding, Place, Severity};
use crate::geometry::CoordinateSystem;

/// A part of a file that cannot be read.
#[derive(Debug)]
pub struct Damage {
    /// The cause, with the position in the file.
    pub error: IoError,
    /// The contents of the part.
    pub part: Part,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

/// The contents of a part of a file, or its possible contents where its header is unreadable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Anything.
    Any,
    /// A record or function of unknown type.
    Function,
    /// A time record.
    Record,
    /// A frequency response function.
    Frf,
    /// A coherence, a variance, a spectrum or another function that modes are not computed from.
    Auxiliary,
    /// A mode shape.
    Mode,
    /// Nodes.
    Nodes,
    /// Coordinate systems.
    Systems,
    /// Units of the file; a value whose unit is lost with them is of unknown unit.
    Units,
    /// Trace lines, elements, groups, titles: no result depends on them.
    Other,
}

impl Part {
    /// The part that a function of a type is.
    pub fn of_function(function_type: FunctionType) -> Self {
        match function_type {
            FunctionType::Time => Part::Record,
            FunctionType::Frf => Part::Frf,
            FunctionType::Coherence | FunctionType::Variance | FunctionType::Other(_) => {
                Part::Auxiliary
            }
        }
    }

    /// The severity of the loss of the part.
    fn severity(self) -> Severity {
        match self {
            Part::Auxiliary | Part::Other => Severity::Warning,
            _ => Severity::Error,
        }
    }
}

/// The data that a result is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Time records.
    Records,
    /// Frequency response functions.
    Frfs,
    /// Mode shapes in the global frame.
    Modes,
    /// Positions of nodes.
    Positions,
}

impl Need {
    /// Whether an answer needs a part of the file of this catalogue; `lost` are all parts that are
    /// damaged.
    fn includes(self, part: Part, lost: &[Part], catalog: &Catalog) -> bool {
        match (self, part) {
            (_, Part::Any)
            | (Need::Records, Part::Function | Part::Record)
            | (Need::Frfs, Part::Function | Part::Frf)
            | (Need::Modes, Part::Mode)
            | (Need::Positions, Part::Nodes | Part::Systems | Part::Units) => true,
            (Need::Modes, Part::Nodes | Part::Systems) => directions_lost(lost, catalog),
            _ => false,
        }
    }
}

/// Whether the directions of shape values at some node are lost with these parts. Nodes name their
/// displacement systems, and systems describe them: where both are damaged, neither shows that no
/// value was local.
pub(super) fn directions_lost(lost: &[Part], catalog: &Catalog) -> bool {
    let geometry = &catalog.geometry;
    let is_lost = |part: Part| lost.contains(&part);
    let is_local = |system: &CoordinateSystem| !system.is_aligned();
    let of_nodes = || geometry.systems.iter().any(is_local);
    let of_systems = || {
        let mut named = (geometry.nodes.iter()).filter_map(|node| node.displacement_system);
        named.any(|label| geometry.system(label).is_none())
    };
    match (is_lost(Part::Nodes), is_lost(Part::Systems)) {
        (true, true) => true,
        (true, false) => of_nodes(),
        (false, true) => of_systems(),
        (false, false) => false,
    }
}

/// Takes the damage of a source: whether part of the file is damaged.
///
/// # Errors
/// The first damage that one of `needs` includes, unless the good part of the file is sufficient
/// (`partial`).
pub fn check_damage(
    source: &mut dyn Source,
    needs: &[Need],
    partial: bool,
) -> Result<bool, IoError> {
    let damage = source.take_damage();
    let is_damaged = !damage.is_empty();
    let catalog = source.catalog();
    let lost: Vec<Part> = damage.iter().map(|damaged| damaged.part).collect();
    let is_needed = |damaged: &Damage| {
        let mut needs = needs.iter();
        needs.any(|need| need.includes(damaged.part, &lost, catalog))
    };
    let needed = damage
        .into_iter()
        .find(|damaged| !partial && is_needed(damaged));
    needed.map_or(Ok(is_damaged), |damaged| Err(damaged.error))
}

impl Catalog {
    /// Keeps the damage of a part of the file, with the finding that reports it.
    pub(in crate::io) fn note_damage(&mut self, error: IoError, part: Part) {
        let (line, byte) = match &error {
            IoError::Text { line, .. } => (Some(*line), None),
            IoError::Binary { byte, .. } | IoError::Truncated { byte, .. } => (None, Some(*byte)),
            _ => (None, None),
        };
        let place = Place::File {
            path: self.path.clone(),
            line,
            byte,
        };
        self.note_damage_at(error, part, place);
    }

    /// As [`Catalog::note_damage`], for damage that is noticed at a position.
    pub(in crate::io) fn note_damage_at(&mut self, error: IoError, part: Part, place: Place) {
        let finding = Finding::new(part.severity(), Code::BadDataset, place);
        self.findings.push(finding.detail(error.without_place()));
        self.damage.push(Damage { error, part });
    }
}
