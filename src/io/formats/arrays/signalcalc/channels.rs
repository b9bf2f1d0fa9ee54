//! Channels and signals as the texts of a SignalCalc file describe them.

use std::collections::{BTreeMap, BTreeSet};

use crate::dof::{Axis, Dof};
use crate::io::formats::arrays::store::bytes::doubles;
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray};
use crate::io::formats::text::{StatedUnit, printed_dof, ratio_unit};
use crate::io::{ArrayInfo, Catalog, Part};

/// Names and units of the channels, and units of the signals.
#[derive(Debug, Default)]
pub(super) struct Channels {
    /// Names of the channels by their number.
    names: BTreeMap<u32, String>,
    /// Units of the channels by their number.
    units: BTreeMap<u32, String>,
    /// Units of the signals by their name, such as `(g)(N)` of `H1_2`.
    signal_units: BTreeMap<String, String>,
    /// Whether every channel has a name that a point may have, and no two have the same.
    are_named: bool,
}

/// The point of a channel.
pub(super) struct ChannelPoint {
    /// The point, or the channel as a scalar.
    pub dof: Option<Dof>,
    /// Whether it is the channel, because its name is no point with a direction.
    pub is_channel: bool,
}

impl Channels {
    /// Reads the texts; one that cannot be read is damage of the catalogue.
    pub fn read(store: &mut dyn ArrayStore, catalog: &mut Catalog) -> Self {
        let numbers = read_array(store, "ChanNum", catalog).map(|array| doubles(array.elements));
        let numbers = numbers.unwrap_or_default();
        let mut of_channels = |name: &str| -> BTreeMap<u32, String> {
            let rows = read_rows(store, name, catalog);
            let numbers = numbers.iter().map(|number| *number as u32);
            let stated = numbers.zip(rows).filter(|(_, text)| !text.is_empty());
            stated.collect()
        };
        let (names, units) = (of_channels("ChanName"), of_channels("Unit"));
        let distinct: BTreeSet<&String> = names.values().collect();
        let is_name = |name: &&String| Dof::new(name, Axis::S, false).is_ok();
        let is_usable = |name: &String| is_name(&name) || point_of(name).is_some();
        let are_named = names.len() == numbers.len()
            && distinct.len() == names.len()
            && names.values().all(is_usable);
        Self {
            names,
            units,
            signal_units: signal_units(&read_rows(store, "DP_Info", catalog)),
            are_named,
        }
    }

    /// The point of a channel: its name where that is a point with a direction, else the channel as
    /// a scalar, by its name or, where not all names are usable, by its number.
    pub fn point(&self, channel: u32) -> ChannelPoint {
        let name = self.names.get(&channel);
        let point = name.and_then(|name| point_of(name));
        let name = name.filter(|_| self.are_named);
        let label = name.cloned().unwrap_or_else(|| channel.to_string());
        ChannelPoint {
            is_channel: point.is_none(),
            dof: point.or_else(|| Dof::new(&label, Axis::S, false).ok()),
        }
    }

    /// The unit of an FRF: of its signal, else of its channels.
    pub fn frf_unit(&self, info: &ArrayInfo, reference: u32, response: u32) -> StatedUnit {
        if let Some(unit) = self.signal_units.get(&info.name) {
            return ratio_unit(unit);
        }
        match (self.units.get(&response), self.units.get(&reference)) {
            (Some(response), Some(reference)) => ratio_unit(&format!("({response})({reference})")),
            _ => StatedUnit::default(),
        }
    }
}

/// The point that a name states: `12+Z`, `12 +Z` or `wing.12:+Z`.
fn point_of(name: &str) -> Option<Dof> {
    let name: String = name.split_whitespace().collect();
    name.parse().ok().or_else(|| printed_dof(&name))
}

/// Units by the name of the signal: behind a row `Signal H1_2` a row `Real/Imag (g)(N)`, or
/// `Real EU g` and `Mag EU g` for engineering units.
fn signal_units(rows: &[String]) -> BTreeMap<String, String> {
    let (pairs, _) = rows.as_chunks::<2>();
    let unit = |[signal, stored]: &[String; 2]| {
        let name = signal.strip_prefix("Signal ")?.trim().to_owned();
        let formats = ["Real/Imag", "Real EU", "Mag EU"];
        let unit = formats
            .iter()
            .find_map(|format| stored.strip_prefix(format))?;
        let unit = unit.trim().to_owned();
        (!unit.is_empty()).then_some((name, unit))
    };
    pairs.iter().filter_map(unit).collect()
}

/// Rows of a text array without the blanks and zero characters that fill them; none where there is
/// no such array.
fn read_rows(store: &mut dyn ArrayStore, name: &str, catalog: &mut Catalog) -> Vec<String> {
    match read_array(store, name, catalog).map(|array| array.elements) {
        Some(Elements::Text(rows)) => {
            let is_filling = |c: char| c == '\0' || c.is_whitespace();
            let trimmed = rows
                .iter()
                .map(|row| row.trim_matches(is_filling).to_owned());
            trimmed.collect()
        }
        _ => Vec::new(),
    }
}

fn read_array(store: &mut dyn ArrayStore, name: &str, catalog: &mut Catalog) -> Option<NamedArray> {
    let index = store.list().iter().position(|info| info.name == name)?;
    match store.read(index) {
        Ok(array) => Some(array),
        Err(error) => {
            catalog.note_damage(error, Part::Units);
            None
        }
    }
}
