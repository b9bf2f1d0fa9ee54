//! Which time records of a file are one hit, and which of them is the force.

use std::collections::{BTreeMap, BTreeSet};

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::quantity::Quantity;
use crate::record::Role;

use super::hit_axis::{belong_together, common_axis};
use crate::io::{ChannelOverride, Entry, FunctionType, HitFile, IoError};

/// Entries of one hit, by their index in the catalogue, in file order.
pub(in crate::io) type RecordGroup = Vec<usize>;

pub(in crate::io) struct RecordGrouper<'a> {
    pub overrides: &'a [ChannelOverride],
    pub file: &'a HitFile,
    /// Force records of hammers that do not hit.
    pub idle: &'a BTreeSet<usize>,
}

impl RecordGrouper<'_> {
    fn entries(&self) -> &[Entry] {
        &self.file.source.catalog().entries
    }

    fn path(&self) -> &str {
        &self.file.source.catalog().path
    }

    /// The time records of which hits are made.
    fn time_records(&self) -> Vec<usize> {
        let left_out = self.left_out();
        let times = self.all_time_records().map(|(index, _)| index);
        times.filter(|index| !left_out.contains(index)).collect()
    }

    fn all_time_records(&self) -> impl Iterator<Item = (usize, &Entry)> {
        let entries = self.entries().iter().enumerate();
        entries.filter(|(_, entry)| entry.function_type == FunctionType::Time)
    }

    /// Records of another quantity than force and motion, where others are forces and motions: no
    /// hit needs them. None where the scene numbers the records of a hit.
    fn left_out(&self) -> BTreeSet<usize> {
        if !self.overrides.is_empty() {
            return self.idle.clone();
        }
        let times = self.all_time_records().map(|(index, _)| index);
        times
            .filter(|index| self.is_other_quantity(*index) || self.idle.contains(index))
            .collect()
    }

    /// Whether a record states another quantity than force and motion, where others are forces and
    /// motions.
    pub fn is_other_quantity(&self, index: usize) -> bool {
        let has = |wanted: fn(Quantity) -> bool| {
            let mut quantities = self
                .all_time_records()
                .filter_map(|(_, entry)| entry.quantity);
            quantities.any(wanted)
        };
        let entry = &self.entries()[index];
        let states_other = entry.quantity.is_none() && !entry.unit_label.is_empty();
        states_other
            && has(|quantity| quantity == Quantity::Force)
            && has(|quantity| quantity != Quantity::Force)
    }

    /// The records that are left out, each point, unit and idle hammer once.
    pub fn left_out_findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for index in self.left_out() {
            let finding = match self.idle.contains(&index) {
                true => self.idle_finding(index),
                false => self.left_out_finding(index),
            };
            add_once(&mut findings, finding);
        }
        findings
    }

    /// The finding of a record that is left out.
    pub fn left_out_finding(&self, index: usize) -> Finding {
        let entry = &self.entries()[index];
        let location = Location::Function {
            response: entry.response.clone(),
            reference: None,
        };
        let finding = Finding::new(Severity::Warning, Code::FunctionLeftOut, location);
        finding.detail(format!("{}: unit {:?}", self.path(), entry.unit_label))
    }

    fn idle_finding(&self, index: usize) -> Finding {
        let location = Location::Function {
            response: self.entries()[index].response.clone(),
            reference: None,
        };
        Finding::new(Severity::Warning, Code::IdleForce, location)
    }

    /// The role of an entry that is record `number` of its hit.
    pub fn role(&self, index: usize, number: usize) -> Role {
        let entry = &self.entries()[index];
        let stated = channel_override(self.overrides, number);
        let by_quantity = |quantity| {
            if quantity == Quantity::Force {
                Role::Force
            } else {
                Role::Response
            }
        };
        let stated_role = stated.and_then(|channel| {
            channel
                .role
                .or(channel.unit.map(|unit| by_quantity(unit.quantity)))
        });
        let missing_unit = stated.and_then(|channel| channel.missing_unit);
        let missing_quantity = missing_unit.map(|unit| unit.quantity);
        let quantity = entry.quantity.or(missing_quantity);
        stated_role
            .or(entry.role)
            .unwrap_or_else(|| quantity.map_or(Role::Response, by_quantity))
    }

    pub fn whole_file_as_hit(&self) -> Result<Vec<RecordGroup>, IoError> {
        let group = self.time_records();
        self.check_hit(&group)?;
        Ok(vec![group])
    }

    /// By identification; where its ID lines tell channels apart instead of hits, by version number
    /// and load case; where these do not change either, by order.
    pub fn group_records(&self, findings: &mut Vec<Finding>) -> Result<Vec<RecordGroup>, IoError> {
        let by_order = self.split_at_hits(&self.time_records());
        let numbers =
            |entry: &Entry| (entry.identification.version, entry.identification.load_case);
        let by_lines = self.group_by_key(|entry| entry.identification.clone());
        let is_whole =
            |groups: &[RecordGroup]| groups.iter().all(|group| self.is_complete_hit(group));
        let times = self.time_records();
        let first = times.first().map(|index| numbers(&self.entries()[*index]));
        let numbered = times
            .iter()
            .any(|index| Some(numbers(&self.entries()[*index])) != first);
        let (mut groups, is_stated) = if is_whole(&by_lines) {
            (
                by_lines,
                !self.has_no_identification() || by_order.len() < 2,
            )
        } else if numbered {
            (self.group_by_key(numbers), true)
        } else {
            match self.group_by_channel() {
                Some(groups) if !is_whole(&by_order) && is_whole(&groups) => (groups, false),
                _ => (by_order, false),
            }
        };
        groups.sort();
        if self.file.partial {
            self.drop_incomplete_hits(&mut groups, findings);
        }
        groups.iter().try_for_each(|group| self.check_hit(group))?;
        if !is_stated {
            let location = Location::File {
                path: self.path().to_owned(),
                line: None,
                byte: None,
            };
            let finding = Finding::new(Severity::Info, Code::GroupedByOrder, location);
            findings.push(finding.value(groups.len() as f64, "hits"));
        }
        Ok(groups)
    }

    /// Leaves out the hits that have another number of records than most, with a finding for each:
    /// where a file is cut or bad records were left out, a hit lacks records or has a neighbour's.
    fn drop_incomplete_hits(&self, groups: &mut Vec<RecordGroup>, findings: &mut Vec<Finding>) {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for group in groups.iter().filter(|group| self.is_complete_hit(group)) {
            *counts.entry(group.len()).or_default() += 1;
        }
        let Some((usual, _)) = counts.into_iter().max_by_key(|(_, hits)| *hits) else {
            return;
        };
        let is_whole = |group: &RecordGroup| group.len() == usual && self.is_complete_hit(group);
        for group in groups.iter().filter(|group| !is_whole(group)) {
            let entry = &self.entries()[group[0]];
            let location = Location::File {
                path: self.path().to_owned(),
                line: entry.line,
                byte: entry.byte.filter(|_| entry.line.is_none()),
            };
            let finding = Finding::new(Severity::Error, Code::HitLeftOut, location);
            findings.push(
                finding
                    .value(group.len() as f64, "records")
                    .limit(usual as f64),
            );
        }
        groups.retain(is_whole);
    }

    /// Whether the responses' references name the excitation points of the force records.
    fn references_name_excitation_points(&self) -> bool {
        let times = self.time_records();
        let entries = || times.iter().map(|index| &self.entries()[*index]);
        let is_force = |entry: &&Entry| entry.quantity == Some(Quantity::Force);
        let hit_points: BTreeSet<Dof> = entries()
            .filter(is_force)
            .filter_map(|entry| Some(entry.response.as_ref()?.positive()))
            .collect();
        let mut references = entries()
            .filter(|entry| !is_force(entry))
            .filter_map(|entry| Some(entry.reference.as_ref()?.positive()));
        references.any(|reference| hit_points.contains(&reference))
    }

    /// Whether one of two records is a force and the other names another excitation point.
    fn belong_to_other_hits(&self, one: usize, other: usize) -> bool {
        let pair = [&self.entries()[one], &self.entries()[other]];
        let differ = |force: &Entry, response: &Entry| {
            let is_force = force.quantity == Some(Quantity::Force);
            let points = force.response.as_ref().zip(response.reference.as_ref());
            is_force && points.is_some_and(|(at, named)| at.positive() != named.positive())
        };
        differ(pair[0], pair[1]) || differ(pair[1], pair[0])
    }

    /// Records of equal key together, each such run cut where the next hit begins.
    fn group_by_key<K: Ord>(&self, key: impl Fn(&Entry) -> K) -> Vec<RecordGroup> {
        let mut keyed: BTreeMap<K, Vec<usize>> = BTreeMap::new();
        for index in self.time_records() {
            keyed
                .entry(key(&self.entries()[index]))
                .or_default()
                .push(index);
        }
        keyed
            .values()
            .flat_map(|indices| self.split_at_hits(indices))
            .collect()
    }

    /// Records that come channel by channel: the first record of each channel is the first hit.
    /// `None` where channels have different numbers of records, a record names no point, or the
    /// scene numbers the records of a hit.
    fn group_by_channel(&self) -> Option<Vec<RecordGroup>> {
        let mut channels: BTreeMap<(Role, &Dof), Vec<usize>> = BTreeMap::new();
        for index in self.time_records() {
            let dof = self.entries()[index].response.as_ref()?;
            let channel = channels.entry((self.role(index, 1), dof)).or_default();
            channel.push(index);
        }
        let hits = channels
            .values()
            .next()
            .filter(|_| self.overrides.is_empty())?
            .len();
        let is_even = channels.values().all(|records| records.len() == hits);
        let hit = |number: usize| channels.values().map(|records| records[number]).collect();
        is_even.then(|| (0..hits).map(hit).collect())
    }

    /// Whether no header names a version, a load case or a reference.
    fn has_no_identification(&self) -> bool {
        let nothing = |entry: &Entry| {
            entry.identification.version == 0
                && entry.identification.load_case == 0
                && entry.reference.is_none()
        };
        self.time_records()
            .iter()
            .all(|index| nothing(&self.entries()[*index]))
    }

    /// Cuts a run of records where a second force, a response that is already there, a response of
    /// another excitation point or another axis begins.
    fn split_at_hits(&self, indices: &[usize]) -> Vec<RecordGroup> {
        let mut groups: Vec<RecordGroup> = Vec::new();
        let named = self.references_name_excitation_points();
        for &index in indices {
            let apart = |group: &RecordGroup| {
                let mut members = group.iter();
                named && members.any(|member| self.belong_to_other_hits(*member, index))
            };
            match groups.last_mut() {
                Some(group) if self.continues_hit(group, index) && !apart(group) => {
                    group.push(index)
                }
                _ => groups.push(vec![index]),
            }
        }
        groups
    }

    fn continues_hit(&self, group: &RecordGroup, index: usize) -> bool {
        let entries = self.entries();
        let role = self.role(index, group.len() + 1);
        let numbered = group
            .iter()
            .enumerate()
            .map(|(place, member)| (*member, self.role(*member, place + 1)));
        let repeats = numbered
            .clone()
            .any(|(other, other_role)| match (role, other_role) {
                (Role::Force, Role::Force) => true,
                (Role::Response, Role::Response) => {
                    entries[other].response.is_some()
                        && entries[other].response == entries[index].response
                }
                _ => false,
            });
        // Overrides number the records of a hit: past the last one, a complete hit is closed.
        let beyond = self
            .overrides
            .iter()
            .map(|channel| channel.number)
            .max()
            .is_some_and(|last| group.len() >= last && self.is_complete_hit(group));
        belong_together(&entries[group[0]].axis, &entries[index].axis) && !repeats && !beyond
    }

    fn is_complete_hit(&self, group: &RecordGroup) -> bool {
        let forces = group
            .iter()
            .enumerate()
            .filter(|(place, index)| self.role(**index, place + 1) == Role::Force)
            .count();
        forces == 1 && group.len() > 1
    }

    /// The records with version and load case of a group; the group where all records have them.
    fn records_of_same_numbers(&self, group: &[usize]) -> RecordGroup {
        let numbers = |index: &usize| {
            let identification = &self.entries()[*index].identification;
            (identification.version, identification.load_case)
        };
        let of_group = group.first().map(numbers);
        let all = self.time_records();
        let same = all
            .iter()
            .copied()
            .filter(|index| Some(numbers(index)) == of_group);
        let same: RecordGroup = same.collect();
        match same.len() == all.len() {
            true => group.to_vec(),
            false => same,
        }
    }

    fn check_hit(&self, group: &RecordGroup) -> Result<(), IoError> {
        let forces = group
            .iter()
            .enumerate()
            .filter(|(place, index)| self.role(**index, place + 1) == Role::Force)
            .count();
        let responses = group.len() - forces;
        if forces == 1 && responses > 0 {
            return Ok(());
        }
        let of_numbers = self.records_of_same_numbers(group);
        common_axis(self.entries(), &of_numbers, self.path())?;
        let is_force = |index: &&usize| self.role(**index, 1) == Role::Force;
        let all_forces = of_numbers.iter().filter(is_force).count();
        let first = group.first().copied().unwrap_or_default();
        let got = match of_numbers.len() > group.len() && all_forces > 1 {
            true => format!(
                "{all_forces} force and {} response records of version {}",
                of_numbers.len() - all_forces,
                self.entries()[first].identification.version
            ),
            false => format!(
                "{forces} force and {responses} response records in the hit that starts with \
                 record {}",
                first + 1
            ),
        };
        Err(IoError::Grouping {
            path: self.path().to_owned(),
            what: "grouping time records into hits",
            got,
            expected: "one force record (ordinate type 13, or role = \"force\" in [[test.channel]]) and one response or more".to_owned(),
        })
    }
}

/// Adds a finding that is not there yet.
pub(in crate::io) fn add_once(findings: &mut Vec<Finding>, finding: Finding) {
    if !findings.contains(&finding) {
        findings.push(finding);
    }
}

pub(in crate::io) fn channel_override(
    overrides: &[ChannelOverride],
    number: usize,
) -> Option<&ChannelOverride> {
    overrides.iter().find(|channel| channel.number == number)
}
