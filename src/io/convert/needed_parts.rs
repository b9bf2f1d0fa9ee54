//! A result needs parts of a file: damage of a part that it does not need is a finding and never
//! stops it.
//!
//! Frequencies, damping and shapes need FRFs or mode shapes; neither trace lines, titles, coherence
//! and spectra, nor, without local directions, nodes.

use crate::geometry::CoordinateSystem;
use crate::io::{Catalog, Damage, IoError, Part, Source};

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
pub(in crate::io) fn directions_lost(lost: &[Part], catalog: &Catalog) -> bool {
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
