//! Time records become hits: which records belong together, which is the force, where the hammer
//! hit.
//!
//! The header decides: records of one file with the same version number, load case and ID lines
//! belong together, and a further force record (or a response that is already there) opens the next
//! hit. Where headers do not say, the order in the file, the length and the sampling decide, and a
//! finding says so. Nothing is guessed beyond that: a unit, a response point or an excitation point
//! that neither file nor scene states is an error.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::quantity::Quantity;
use crate::record::{
    ChannelInfo, ChannelPlace, ChannelSegment, HitInfo, ReadError, Recording, Role, Samples,
};

use super::hit_axis::common_axis;
use super::hit_grouping::{RecordGroup, RecordGrouper, add_once, channel_override};
use super::idle_forces::idle_forces;
use crate::io::{
    Block, ChannelOverride, Entry, EntryAxis, FunctionType, HitFile, HitGrouping, IoError, Merged,
    SampleFormat,
};

/// Hits with what was said on the way.
pub struct HitSet {
    /// Hits in file order, their samples still in the files.
    pub recording: FileRecording,
    /// Findings.
    pub findings: Vec<Finding>,
}

impl std::fmt::Debug for HitSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let hits = &self.recording.hits;
        write!(f, "{hits:?} {:?}", self.findings)
    }
}

/// Hits whose samples are in files.
#[derive(Default)]
pub struct FileRecording {
    files: Vec<HitFile>,
    hits: Vec<HitInfo>,
    /// File of each hit, and the entries of its force and its responses.
    places: Vec<(usize, usize, Vec<usize>)>,
}

impl FileRecording {
    /// States the range of the converter of the forces, or of the responses at a degree of freedom
    /// (at all without one), SI unit.
    pub fn state_full_scale(&mut self, role: Role, dof: Option<&Dof>, full_scale: f64) {
        for hit in &mut self.hits {
            match role {
                Role::Force => hit.force.full_scale = Some(full_scale),
                Role::Response => {
                    let channels = hit.responses.iter_mut();
                    let channels =
                        channels.filter(|channel| dof.is_none_or(|dof| *dof == channel.dof));
                    channels.for_each(|channel| channel.full_scale = Some(full_scale));
                }
            }
        }
    }
}

impl Recording for FileRecording {
    fn hits(&self) -> &[HitInfo] {
        &self.hits
    }

    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        let (file, force, responses) = &self.places[segment.hit];
        let entry = match segment.channel {
            ChannelPlace::Force => *force,
            ChannelPlace::Response(number) => responses[number],
        };
        let mut block = match std::mem::replace(samples, Samples::F64(Vec::new())) {
            Samples::F32(values) => Block::F32(values),
            Samples::F64(values) => Block::F64(values),
        };
        let source = &mut self.files[*file].source;
        source
            .read(entry, segment.samples.clone(), &mut block)
            .map_err(ReadError::new)?;
        *samples = match block {
            Block::F32(values) => Samples::F32(values),
            Block::F64(values) => Samples::F64(values),
            // Grouping refuses complex records.
            Block::Complex(values) => Samples::F64(values.iter().map(|v| v.re).collect()),
        };
        Ok(())
    }
}

/// Groups the time records of files into hits; their samples are read when they are asked for.
///
/// # Errors
/// [`IoError::Grouping`] for records that cannot make a hit; [`IoError::NotStated`] for a unit, a
/// quantity, a response or an excitation point that neither file nor scene states.
pub fn group_hits(
    mut files: Vec<HitFile>,
    grouping: HitGrouping,
    overrides: &[ChannelOverride],
) -> Result<HitSet, IoError> {
    let none: Vec<BTreeSet<usize>> = files.iter().map(|_| BTreeSet::new()).collect();
    let mut grouped = hits_of_files(&files, grouping, overrides, &none);
    // Samples are read only where the headers alone make no hits.
    if is_not_grouped(&grouped) && overrides.is_empty() {
        let idle = files.iter_mut().map(|file| idle_forces(file, grouping));
        let idle = idle.collect::<Result<Vec<_>, IoError>>()?;
        if idle.iter().any(|records| !records.is_empty()) {
            grouped = hits_of_files(&files, grouping, overrides, &idle);
        }
    }
    if is_not_grouped(&grouped) && grouping != HitGrouping::Files && files.len() > 1 {
        let is_alone = |file: &HitFile| {
            let entries = file.source.catalog().entries.iter();
            let mut times = entries.filter(|entry| entry.function_type == FunctionType::Time);
            let is_force = times.clone().next().map(Entry::is_force);
            times.all(|entry| Some(entry.is_force()) == is_force)
        };
        if files.iter().all(is_alone) {
            files = vec![as_one_file(files)];
            grouped = hits_of_files(&files, grouping, overrides, &none[..1]);
        }
    }
    let GroupedHits {
        hits,
        places,
        findings,
    } = grouped?;
    let recording = FileRecording {
        files,
        hits,
        places,
    };
    Ok(HitSet {
        recording,
        findings,
    })
}

fn is_not_grouped(grouped: &Result<GroupedHits, IoError>) -> bool {
    matches!(grouped, Err(IoError::Grouping { .. }))
}

/// Hits with their places in the files.
struct GroupedHits {
    hits: Vec<HitInfo>,
    places: Vec<(usize, usize, Vec<usize>)>,
    findings: Vec<Finding>,
}

/// The hits of all files; `idle` are the records of idle hammers of each.
fn hits_of_files(
    files: &[HitFile],
    grouping: HitGrouping,
    overrides: &[ChannelOverride],
    idle: &[BTreeSet<usize>],
) -> Result<GroupedHits, IoError> {
    let mut findings = Vec::new();
    let (mut hits, mut places) = (Vec::new(), Vec::new());
    for (number, (file, idle)) in files.iter().zip(idle).enumerate() {
        let grouper = RecordGrouper {
            overrides,
            file,
            idle,
        };
        findings.extend(grouper.left_out_findings());
        let groups = match grouping {
            HitGrouping::Files => grouper.whole_file_as_hit()?,
            HitGrouping::Auto | HitGrouping::Records | HitGrouping::Trigger => {
                grouper.group_records(&mut findings)?
            }
        };
        for group in groups {
            let (hit, force, responses) = build_hit(&grouper, &group, &mut findings)?;
            hits.push(hit);
            places.push((number, force, responses));
        }
    }
    Ok(GroupedHits {
        hits,
        places,
        findings,
    })
}

/// Files of one channel each as one file.
fn as_one_file(files: Vec<HitFile>) -> HitFile {
    let partial = files.iter().any(|file| file.partial);
    let points: Vec<(Option<Dof>, Option<Dof>)> = files
        .iter()
        .map(|file| (file.response.clone(), file.reference.clone()))
        .collect();
    let sources = files.into_iter().map(|file| file.source).collect();
    let mut merged = Merged::new(sources);
    for (number, (response, reference)) in points.iter().enumerate() {
        merged.state_points(number, response.as_ref(), reference.as_ref());
    }
    HitFile {
        partial,
        ..HitFile::new(Box::new(merged))
    }
}

/// A hit with the entries of its force and its responses.
fn build_hit(
    grouper: &RecordGrouper,
    group: &RecordGroup,
    findings: &mut Vec<Finding>,
) -> Result<(HitInfo, usize, Vec<usize>), IoError> {
    let (file, overrides) = (grouper.file, grouper.overrides);
    let numbered = group.iter().enumerate();
    let roles: Vec<Role> = numbered
        .map(|(place, index)| grouper.role(*index, place + 1))
        .collect();
    let catalog = file.source.catalog();
    let axis = common_axis(catalog.entries.as_slice(), group, &catalog.path)?;
    let excitation_point = excitation_point(file, group, &roles, overrides, findings)?;
    let is_motion = |quantity| quantity != Quantity::Force;
    let quantities = group.iter().map(|index| catalog.entries[*index].quantity);
    let moves = quantities.flatten().any(is_motion);
    let (mut force, mut responses, mut entries) = (None, Vec::new(), Vec::new());
    for (place, (&index, &role)) in group.iter().zip(&roles).enumerate() {
        let stated = channel_override(overrides, place + 1);
        match role {
            Role::Force => {
                force = Some((
                    channel_info(file, index, role, excitation_point.clone(), stated)?,
                    index,
                ));
            }
            Role::Response if stated.is_none() && moves && grouper.is_other_quantity(index) => {
                add_once(findings, grouper.left_out_finding(index));
            }
            Role::Response => {
                let dof = response_point(file, index, stated)?;
                responses.push(channel_info(file, index, role, dof, stated)?);
                entries.push(index);
            }
        }
    }
    let (force, force_entry) = force.expect("every group was checked to hold one force");
    for (response, entry) in responses.iter_mut().zip(&entries) {
        let starts_s = [*entry, force_entry].map(|index| start_s(&catalog.entries[index]));
        let delay_s = starts_s[0] - starts_s[1];
        if delay_s.abs() > MIN_DELAY_SAMPLES * axis.step_s {
            response.delay_s = delay_s;
            let location = Location::Function {
                response: Some(response.dof.clone()),
                reference: None,
            };
            let finding = Finding::new(Severity::Info, Code::ChannelDelayCorrected, location);
            add_once(findings, finding.value(delay_s, "s"));
        }
    }
    let origin = format!("{} record {}", catalog.path, group[0] + 1);
    let hit = HitInfo {
        axis,
        force,
        responses,
        origin,
    };
    Ok((hit, force_entry, entries))
}

/// Channels start together where they do within this part of a sample, the digits of a printed
/// start. Larger: a delay that turns the phase by a degree at half the sampling rate stays.
/// Smaller: rounding alone is a delay
/// (`a_channel_that_starts_late_has_the_phase_of_one_that_does_not`).
const MIN_DELAY_SAMPLES: f64 = 1e-3;

/// The time of the first sample.
fn start_s(entry: &Entry) -> f64 {
    match entry.axis {
        EntryAxis::Time(axis) => axis.start_s,
        _ => 0.0,
    }
}

/// The force record's response, else the responses' common reference, else the scene's word.
fn excitation_point(
    file: &HitFile,
    group: &RecordGroup,
    roles: &[Role],
    overrides: &[ChannelOverride],
    findings: &mut Vec<Finding>,
) -> Result<Dof, IoError> {
    let catalog = file.source.catalog();
    let place = roles
        .iter()
        .position(|role| *role == Role::Force)
        .expect("every group was checked to hold one force");
    let stated = channel_override(overrides, place + 1).and_then(|channel| channel.dof.clone());
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
        expected: "a response node in the force record, a common reference of the responses, `dof` of the force in [[test.channel]], or `reference` in [[test.file]]".to_owned(),
    })?;
    let location = Location::File {
        path: catalog.path.clone(),
        line: None,
        byte: None,
    };
    let finding = Finding::new(Severity::Info, Code::HitPointAssumed, location);
    add_once(findings, finding);
    Ok(found)
}

fn response_point(
    file: &HitFile,
    index: usize,
    channel: Option<&ChannelOverride>,
) -> Result<Dof, IoError> {
    let stated = channel.and_then(|channel| channel.dof.clone());
    let catalog = file.source.catalog();
    stated.or_else(|| catalog.entries[index].response.clone()).or_else(|| file.response.clone()).ok_or_else(|| IoError::NotStated {
        path: catalog.path.clone(),
        what: format!("the response point of record {}", index + 1),
        expected: "a response node in its header, `dof` in [[test.channel]] or `response` in [[test.file]]".to_owned(),
    })
}

fn channel_info(
    file: &HitFile,
    index: usize,
    role: Role,
    dof: Dof,
    channel: Option<&ChannelOverride>,
) -> Result<ChannelInfo, IoError> {
    let entry = &file.source.catalog().entries[index];
    let path = &file.source.catalog().path;
    let (quantity, to_si) = calibration(entry, role, channel).ok_or_else(|| {
        let label = if entry.unit_label.is_empty() {
            "an empty unit label".to_owned()
        } else {
            format!("unit label {:?}", entry.unit_label)
        };
        IoError::NotStated {
            path: location(path, entry),
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
    if matches!(
        entry.format,
        SampleFormat::ComplexF32 | SampleFormat::ComplexF64
    ) {
        return Err(IoError::Grouping {
            path: location(path, entry),
            what: "reading a time record",
            got: "complex values".to_owned(),
            expected: "real values".to_owned(),
        });
    }
    let scale = channel.and_then(|channel| channel.scale).unwrap_or(1.0);
    let full_scale = channel.and_then(|channel| channel.full_scale);
    Ok(ChannelInfo {
        dof,
        quantity,
        to_si,
        full_scale: full_scale.map(|stated| stated * (to_si / scale).abs()),
        delay_s: 0.0,
    })
}

/// Quantity and factor to SI; the scene's word goes before the file's. `None` when they are unknown
/// or do not suit the role.
fn calibration(
    entry: &Entry,
    role: Role,
    channel: Option<&ChannelOverride>,
) -> Option<(Quantity, f64)> {
    let scale = channel.and_then(|channel| channel.scale).unwrap_or(1.0);
    let stated = channel.and_then(|channel| channel.unit);
    let missing = channel.and_then(|channel| channel.missing_unit);
    let (quantity, to_si) = match (stated, entry.quantity.zip(entry.to_si)) {
        (Some(unit), _) => (unit.quantity, unit.to_si),
        (None, Some(of_file)) => of_file,
        (None, None) => missing.map(|unit| (unit.quantity, unit.to_si))?,
    };
    ((quantity == Quantity::Force) == (role == Role::Force)).then_some((quantity, scale * to_si))
}

fn location(path: &str, entry: &Entry) -> String {
    entry
        .line
        .map_or_else(|| path.to_owned(), |line| format!("{path}:{line}"))
}
