//! Time records become hits: which records belong together, which is the force, where the hammer hit.
//!
//! The header decides: records of one file with the same version number, load case and ID lines belong together, and a
//! further force record (or a response that is already there) opens the next hit. Where headers do not say, the order
//! in the file, the length and the sampling decide, and a finding says so. Nothing is guessed beyond that: a unit, a
//! response point or a hit point that neither file nor scene states is an error.

use std::collections::BTreeMap;

use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::quantity::{FrfUnit, Quantity, Unit};
use crate::record::{Channel, Hit, Role, Samples};

use super::{Block, Entry, EntryAxis, FunctionType, IoError, Source};

/// How hits are told apart within a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum HitGrouping {
    /// By the records' identification and order.
    #[default]
    Records,
    /// Each file is one hit.
    Files,
}

impl HitGrouping {
    /// The grouping of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "records" => Some(HitGrouping::Records),
            "files" => Some(HitGrouping::Files),
            _ => None,
        }
    }
}

/// What the scene says of one record of every hit, where the file does not.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ChannelOverride {
    /// Number of the record within its hit, from 1.
    pub number: usize,
    /// What it is.
    pub role: Option<Role>,
    /// Where it measures.
    pub dof: Option<Dof>,
    /// Unit of its numbers; its quantity is the channel's.
    pub unit: Option<Unit>,
    /// Calibration: value in the stated unit = `scale` × number in the file.
    pub scale: Option<f64>,
}

/// One opened file with what the scene says of it.
pub struct HitFile {
    /// The file.
    pub source: Box<dyn Source>,
    /// The scene's word for its response.
    pub response: Option<Dof>,
    /// The scene's word for its hit point.
    pub reference: Option<Dof>,
    /// The scene's word for the unit of FRFs that do not state it.
    pub frf_unit: Option<FrfUnit>,
}

/// Hits with what was said on the way.
#[derive(Clone, Debug, Default)]
pub struct HitSet {
    /// Hits in file order.
    pub hits: Vec<Hit>,
    /// Findings.
    pub findings: Vec<Finding>,
}

/// Whether a file holds time records.
pub fn has_time_records(source: &dyn Source) -> bool {
    source
        .catalog()
        .entries
        .iter()
        .any(|entry| entry.function_type == FunctionType::Time)
}

/// Groups the time records of files into hits and reads their samples.
///
/// # Errors
/// [`IoError::Grouping`] for records that cannot make a hit; [`IoError::NotStated`] for a unit, a quantity, a response
/// or a hit point that neither file nor scene states; reading errors with their place.
pub fn group_hits(
    files: &mut [HitFile],
    grouping: HitGrouping,
    overrides: &[ChannelOverride],
) -> Result<HitSet, IoError> {
    let mut set = HitSet::default();
    for file in files {
        let roles = Roles { overrides, file };
        let groups = match grouping {
            HitGrouping::Files => roles.one_hit()?,
            HitGrouping::Records => roles.hits(&mut set.findings)?,
        };
        for group in groups {
            let hit = read_hit(file, &group, overrides, &mut set.findings)?;
            set.hits.push(hit);
        }
    }
    Ok(set)
}

/// Entries of one hit, by their index in the catalogue, in file order.
type Group = Vec<usize>;

struct Roles<'a> {
    overrides: &'a [ChannelOverride],
    file: &'a HitFile,
}

impl Roles<'_> {
    fn entries(&self) -> &[Entry] {
        &self.file.source.catalog().entries
    }

    fn path(&self) -> &str {
        &self.file.source.catalog().path
    }

    fn times(&self) -> Vec<usize> {
        let entries = self.entries().iter().enumerate();
        entries
            .filter(|(_, entry)| entry.function_type == FunctionType::Time)
            .map(|(index, _)| index)
            .collect()
    }

    /// The role of an entry that is record `number` of its hit.
    fn role(&self, index: usize, number: usize) -> Role {
        let entry = &self.entries()[index];
        let stated = channel_override(self.overrides, number);
        let by_quantity = |quantity| {
            if quantity == Quantity::Force {
                Role::Force
            } else {
                Role::Response
            }
        };
        let stated_role =
            stated.and_then(|own| own.role.or(own.unit.map(|unit| by_quantity(unit.quantity))));
        stated_role
            .or(entry.role)
            .unwrap_or_else(|| entry.quantity.map_or(Role::Response, by_quantity))
    }

    fn one_hit(&self) -> Result<Vec<Group>, IoError> {
        let group = self.times();
        self.check(&group)?;
        Ok(vec![group])
    }

    /// By identification; where its ID lines tell channels apart instead of hits, by version number and load case; where
    /// these do not change either, by order.
    fn hits(&self, findings: &mut Vec<Finding>) -> Result<Vec<Group>, IoError> {
        let by_order = self.split(&self.times());
        let numbers =
            |entry: &Entry| (entry.identification.version, entry.identification.load_case);
        let by_lines = self.keyed(|entry| entry.identification.clone());
        let is_whole = |groups: &[Group]| groups.iter().all(|group| self.is_hit(group));
        let numbered = self
            .times()
            .iter()
            .any(|index| numbers(&self.entries()[*index]) != numbers(&self.entries()[0]));
        let (mut groups, told) = if is_whole(&by_lines) {
            (by_lines, !self.says_nothing() || by_order.len() < 2)
        } else if numbered {
            (self.keyed(numbers), true)
        } else {
            (by_order, false)
        };
        groups.sort();
        groups.iter().try_for_each(|group| self.check(group))?;
        if !told {
            let place = Place::File {
                path: self.path().to_owned(),
                line: None,
                byte: None,
            };
            let finding = Finding::new(Severity::Info, Code::GroupedByOrder, place);
            findings.push(finding.value(groups.len() as f64, "hits"));
        }
        Ok(groups)
    }

    /// Records of equal key together, each such run cut where the next hit begins.
    fn keyed<K: Ord>(&self, key: impl Fn(&Entry) -> K) -> Vec<Group> {
        let mut keyed: BTreeMap<K, Vec<usize>> = BTreeMap::new();
        for index in self.times() {
            keyed
                .entry(key(&self.entries()[index]))
                .or_default()
                .push(index);
        }
        keyed
            .values()
            .flat_map(|indices| self.split(indices))
            .collect()
    }

    /// Whether no header names a version, a load case or a reference.
    fn says_nothing(&self) -> bool {
        let nothing = |entry: &Entry| {
            entry.identification.version == 0
                && entry.identification.load_case == 0
                && entry.reference.is_none()
        };
        self.times()
            .iter()
            .all(|index| nothing(&self.entries()[*index]))
    }

    /// Cuts a run of records where a second force, a response that is already there, or another axis begins.
    fn split(&self, indices: &[usize]) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for &index in indices {
            match groups.last_mut() {
                Some(group) if self.belongs(group, index) => group.push(index),
                _ => groups.push(vec![index]),
            }
        }
        groups
    }

    fn belongs(&self, group: &Group, index: usize) -> bool {
        let entries = self.entries();
        let role = self.role(index, group.len() + 1);
        let numbered = group
            .iter()
            .enumerate()
            .map(|(place, own)| (*own, self.role(*own, place + 1)));
        let repeats = numbered
            .clone()
            .any(|(own, own_role)| match (role, own_role) {
                (Role::Force, Role::Force) => true,
                (Role::Response, Role::Response) => {
                    entries[own].response.is_some()
                        && entries[own].response == entries[index].response
                }
                _ => false,
            });
        // Overrides number the records of a hit: past the last one, a complete hit is closed.
        let beyond = self
            .overrides
            .iter()
            .map(|own| own.number)
            .max()
            .is_some_and(|last| group.len() >= last && self.is_hit(group));
        entries[group[0]].axis == entries[index].axis && !repeats && !beyond
    }

    fn is_hit(&self, group: &Group) -> bool {
        let forces = group
            .iter()
            .enumerate()
            .filter(|(place, index)| self.role(**index, place + 1) == Role::Force)
            .count();
        forces == 1 && group.len() > 1
    }

    fn check(&self, group: &Group) -> Result<(), IoError> {
        let forces = group
            .iter()
            .enumerate()
            .filter(|(place, index)| self.role(**index, place + 1) == Role::Force)
            .count();
        let responses = group.len() - forces;
        if forces == 1 && responses > 0 {
            return Ok(());
        }
        let from = group.first().map_or(0, |index| index + 1);
        Err(IoError::Grouping {
            path: self.path().to_owned(),
            what: "grouping time records into hits",
            got: format!("{forces} force and {responses} response records in the hit that starts with record {from}"),
            expected: "one force record (ordinate type 13, or role = \"force\" in [[test.channel]]) and one response or more".to_owned(),
        })
    }
}

fn channel_override(overrides: &[ChannelOverride], number: usize) -> Option<&ChannelOverride> {
    overrides.iter().find(|own| own.number == number)
}

fn read_hit(
    file: &mut HitFile,
    group: &Group,
    overrides: &[ChannelOverride],
    findings: &mut Vec<Finding>,
) -> Result<Hit, IoError> {
    let roles: Vec<Role> = {
        let judge = Roles { overrides, file };
        group
            .iter()
            .enumerate()
            .map(|(place, index)| judge.role(*index, place + 1))
            .collect()
    };
    let axis = common_axis(
        file.source.catalog().entries.as_slice(),
        group,
        &file.source.catalog().path,
    )?;
    let hit_point = hit_point(file, group, &roles, overrides, findings)?;
    let (mut force, mut responses) = (None, Vec::new());
    for (place, (&index, &role)) in group.iter().zip(&roles).enumerate() {
        let own = channel_override(overrides, place + 1);
        let dof = match role {
            Role::Force => hit_point.clone(),
            Role::Response => response_point(file, index, own)?,
        };
        let channel = read_channel(file, index, role, dof, own)?;
        match role {
            Role::Force => force = Some(channel),
            Role::Response => responses.push(channel),
        }
    }
    let origin = format!("{} record {}", file.source.catalog().path, group[0] + 1);
    Ok(Hit {
        axis,
        force: force.expect("every group was checked to hold one force"),
        responses,
        origin,
    })
}

/// Channels may begin apart by this fraction of a sample.
const START_AGREEMENT: f64 = 1e-3;

fn common_axis(entries: &[Entry], group: &Group, path: &str) -> Result<TimeAxis, IoError> {
    let error = |got: String| IoError::Grouping {
        path: path.to_owned(),
        what: "sampling of the channels of one hit",
        got,
        expected: "one length, spacing and start in time".to_owned(),
    };
    let described = |axis: &TimeAxis| {
        format!(
            "{} samples by {} s from {} s",
            axis.len, axis.step_s, axis.start_s
        )
    };
    let mut common: Option<TimeAxis> = None;
    for index in group {
        let EntryAxis::Time(axis) = entries[*index].axis else {
            return Err(error(format!("record {} on a frequency axis", index + 1)));
        };
        let first = *common.get_or_insert(axis);
        let same = axis.len == first.len
            && (axis.step_s - first.step_s).abs() <= 1e-9 * first.step_s
            && (axis.start_s - first.start_s).abs() <= START_AGREEMENT * first.step_s;
        if !same {
            return Err(error(format!(
                "{} and {}",
                described(&first),
                described(&axis)
            )));
        }
    }
    common.ok_or_else(|| error("no record".to_owned()))
}

/// The force record's response, else the responses' common reference, else the scene's word.
fn hit_point(
    file: &HitFile,
    group: &Group,
    roles: &[Role],
    overrides: &[ChannelOverride],
    findings: &mut Vec<Finding>,
) -> Result<Dof, IoError> {
    let catalog = file.source.catalog();
    let place = roles
        .iter()
        .position(|role| *role == Role::Force)
        .expect("every group was checked to hold one force");
    let stated = channel_override(overrides, place + 1).and_then(|own| own.dof.clone());
    if let Some(dof) = stated.or_else(|| catalog.entries[group[place]].response.clone()) {
        return Ok(dof);
    }
    let responses = group
        .iter()
        .zip(roles)
        .filter(|(_, role)| **role == Role::Response);
    let references: Vec<&Option<Dof>> = responses
        .map(|(index, _)| &catalog.entries[*index].reference)
        .collect();
    let common = references.first().and_then(|first| {
        references
            .iter()
            .all(|other| other == first)
            .then(|| (*first).clone())?
    });
    let found = common.or_else(|| file.reference.clone()).ok_or_else(|| IoError::NotStated {
        path: catalog.path.clone(),
        what: format!("the hit point of the hit that starts with record {}", group[0] + 1),
        expected: "a response node in the force record, a common reference of the responses, or `reference` in [[test.file]] (--reference)".to_owned(),
    })?;
    let place = Place::File {
        path: catalog.path.clone(),
        line: None,
        byte: None,
    };
    let finding = Finding::new(Severity::Info, Code::HitPointAssumed, place);
    if !findings.contains(&finding) {
        findings.push(finding);
    }
    Ok(found)
}

fn response_point(
    file: &HitFile,
    index: usize,
    own: Option<&ChannelOverride>,
) -> Result<Dof, IoError> {
    let stated = own.and_then(|own| own.dof.clone());
    let catalog = file.source.catalog();
    stated.or_else(|| catalog.entries[index].response.clone()).or_else(|| file.response.clone()).ok_or_else(|| IoError::NotStated {
        path: catalog.path.clone(),
        what: format!("the response point of record {}", index + 1),
        expected: "a response node in its header, `dof` in [[test.channel]] or `response` in [[test.file]]".to_owned(),
    })
}

fn read_channel(
    file: &mut HitFile,
    index: usize,
    role: Role,
    dof: Dof,
    own: Option<&ChannelOverride>,
) -> Result<Channel, IoError> {
    let entry = file.source.catalog().entries[index].clone();
    let path = file.source.catalog().path.clone();
    let (quantity, to_si) = calibration(&entry, role, own).ok_or_else(|| {
        let label = if entry.unit_label.is_empty() {
            "an empty unit label".to_owned()
        } else {
            format!("unit label {:?}", entry.unit_label)
        };
        IoError::NotStated {
            path: place(&path, &entry),
            what: format!("quantity and unit of record {} ({label})", index + 1),
            expected: format!(
                "a {} unit in the file or `unit` in [[test.channel]]",
                if role == Role::Force {
                    "force"
                } else {
                    "response"
                }
            ),
        }
    })?;
    let mut block = Block::F64(Vec::new());
    file.source.read(index, 0..entry.len(), &mut block)?;
    let samples = match block {
        Block::F32(values) => Samples::F32(values),
        Block::F64(values) => Samples::F64(values),
        Block::Complex(_) => {
            return Err(IoError::Grouping {
                path: place(&path, &entry),
                what: "reading a time record",
                got: "complex values".to_owned(),
                expected: "real values".to_owned(),
            });
        }
    };
    Ok(Channel {
        role,
        dof,
        quantity,
        to_si,
        samples,
    })
}

/// Quantity and factor to SI; the scene's word goes before the file's. `None` when they are unknown or do not suit the role.
fn calibration(
    entry: &Entry,
    role: Role,
    own: Option<&ChannelOverride>,
) -> Option<(Quantity, f64)> {
    let scale = own.and_then(|own| own.scale).unwrap_or(1.0);
    let (quantity, to_si) = match own.and_then(|own| own.unit) {
        Some(unit) => (unit.quantity, unit.to_si),
        None => (entry.quantity?, entry.to_si?),
    };
    ((quantity == Quantity::Force) == (role == Role::Force)).then_some((quantity, scale * to_si))
}

fn place(path: &str, entry: &Entry) -> String {
    entry
        .line
        .map_or_else(|| path.to_owned(), |line| format!("{path}:{line}"))
}
