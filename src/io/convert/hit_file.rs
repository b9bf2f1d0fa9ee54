//! An opened file carries the scene's statements about it; hits are grouped by a rule of the test.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::frf::Window;
use crate::quantity::{FrfUnit, Unit};
use crate::record::Role;

use super::entry_quantity::is_other_quantity;
use crate::io::{Catalog, Entry, IoError, Source};

/// The rule that groups the records of a test into hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum HitGrouping {
    /// As records, cut by trigger where each record plainly holds several hits.
    #[default]
    Auto,
    /// By the records' identification and order.
    Records,
    /// Each file is one hit.
    Files,
    /// As records, but each is a continuous recording of several hits.
    Trigger,
}

impl HitGrouping {
    /// The grouping of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "records" => Some(HitGrouping::Records),
            "files" => Some(HitGrouping::Files),
            "trigger" => Some(HitGrouping::Trigger),
            _ => None,
        }
    }
}

/// Properties that the scene states for one record of every hit.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ChannelOverride {
    /// Number of the record within its hit, from 1.
    pub number: usize,
    /// Its role.
    pub role: Option<Role>,
    /// Where it measures.
    pub dof: Option<Dof>,
    /// Unit of its numbers; its quantity is the channel's.
    pub unit: Option<Unit>,
    /// Unit where the file states none.
    pub missing_unit: Option<Unit>,
    /// Calibration: value in the stated unit = `scale` × number in the file.
    pub scale: Option<f64>,
    /// Largest magnitude that the converter can hold, in the stated unit.
    pub full_scale: Option<f64>,
}

impl ChannelOverride {
    /// No statement on a record of this number.
    pub fn of_record(number: usize) -> Self {
        Self {
            number,
            role: None,
            dof: None,
            unit: None,
            missing_unit: None,
            scale: None,
            full_scale: None,
        }
    }
}

/// A unit that the scene states for FRFs.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedFrfUnit {
    /// The response that it is stated for, along the positive axis; `None` for every FRF of its
    /// quantity.
    pub response: Option<Dof>,
    /// The unit.
    pub unit: FrfUnit,
}

impl StatedFrfUnit {
    /// The one that is stated for an entry: that of its response before that of its quantity.
    pub(super) fn of_entry(stated: &[Self], entry: &Entry, response: &Dof) -> Option<FrfUnit> {
        let of_response = |unit: &&Self| unit.response.is_some() && unit.is_of(entry, response);
        let of_quantity = |unit: &&Self| unit.response.is_none() && unit.is_of(entry, response);
        let found = stated.iter().find(of_response);
        Some(found.or_else(|| stated.iter().find(of_quantity))?.unit)
    }

    /// Whether it is that of an entry with this response. A motion over force is not put on an
    /// entry that states another quantity, and another quantity only on entries that state it.
    fn is_of(&self, entry: &Entry, response: &Dof) -> bool {
        let of_header = || FrfUnit::of_any_response(&entry.unit_label).map(|unit| unit.kind);
        match (&self.response, self.unit.kind.is_motion()) {
            (Some(stated), _) => *stated == response.positive().with_repeat(1),
            (None, true) => !is_other_quantity(entry),
            (None, false) => of_header() == Ok(self.unit.kind),
        }
    }
}

/// One opened file with what the scene says of it.
pub struct HitFile {
    /// The file.
    pub source: Box<dyn Source>,
    /// The scene's word for its response.
    pub response: Option<Dof>,
    /// The scene's word for its excitation point.
    pub reference: Option<Dof>,
    /// The scene's word for the units of FRFs; precedes that of a header.
    pub frf_units: Vec<StatedFrfUnit>,
    /// The unit of FRFs that do not state it.
    pub missing_frf_unit: Option<FrfUnit>,
    /// The scene's word for the number of averages of FRFs that do not state it.
    pub averages: Option<u32>,
    /// The scene's word for the window of FRFs that do not state it.
    pub window: Option<Window>,
    /// Whether hits of which records are missing may be left out.
    pub partial: bool,
}

impl HitFile {
    /// A file of which the scene says nothing.
    pub fn new(source: Box<dyn Source>) -> Self {
        Self {
            source,
            response: None,
            reference: None,
            frf_units: Vec::new(),
            missing_frf_unit: None,
            averages: None,
            window: None,
            partial: false,
        }
    }
}

/// Checks that a point that is stated for a whole file replaces one channel, not several.
///
/// # Errors
/// [`IoError::Grouping`] with the channels.
pub fn check_stated_points(
    catalog: &Catalog,
    response: Option<&Dof>,
    reference: Option<&Dof>,
) -> Result<(), IoError> {
    let channels = |of: fn(&Entry) -> Option<&Dof>| -> BTreeSet<&Dof> {
        catalog.entries.iter().filter_map(of).collect()
    };
    let responses = channels(|entry| {
        let response = entry.response.as_ref();
        response.filter(|_| entry.response_is_channel)
    });
    let references = channels(|entry| {
        let reference = entry.reference.as_ref();
        reference.filter(|_| entry.reference_is_channel)
    });
    let sides = [
        ("stating the response of a file", response, responses),
        ("stating the reference of a file", reference, references),
    ];
    for (what, stated, channels) in sides {
        let Some(stated) = stated.filter(|_| channels.len() > 1) else {
            continue;
        };
        let names: Vec<String> = channels.iter().map(ToString::to_string).collect();
        return Err(IoError::Grouping {
            path: catalog.path.clone(),
            what,
            got: format!("{stated} for the channels {}", names.join(", ")),
            expected: "a file with one such channel; else name the channels by their points, such \
                       as 12+Z, before the export, or describe the columns in [[test.channel]]"
                .to_owned(),
        });
    }
    Ok(())
}
