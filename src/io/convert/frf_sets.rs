//! FRF and coherence entries of files become FRF sets, one per axis.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::{EvenLines, FrfSet, Function, FunctionData, variance_from_coherence};
use crate::quantity::FrfUnit;

use super::coherence::{ValidCoherence, valid_coherence};
use super::common_window::StatedWindows;
use super::entry_quantity::{frf_kind, is_other_quantity};
use crate::io::{
    Block, Domain, Entry, EntryAxis, FunctionMetadata, FunctionType, HitFile, IoError, Source,
    StatedFrfUnit,
};

/// One function with its axis.
struct ReadFrf {
    path: String,
    axis: FrequencyAxis,
    function: Function,
    data: FunctionData,
    note: FunctionMetadata,
    averages_assumed: bool,
    is_interpolated: bool,
    findings: Vec<Finding>,
}

/// Number of averages where coherence is given without it: the fewest that are common practice in a
/// hammer test.
const ASSUMED_AVERAGES: u32 = 3;

/// Collects the FRFs of files into sets of one axis each, in order of appearance; coherence and
/// variance join their function, also from files that hold them alone.
///
/// A variance that the file does not hold is that of H1 with the coherence and the number of
/// averages, |H|²(1−γ²)/(γ²(n−1)). A number that neither file nor scene states is taken as 3, with
/// a finding. A coherence of 1 throughout is that of a single average and says nothing; then the
/// variance is unknown. Coherence outside 0 to 1 is ignored, and a function of another quantity
/// than motion over force is left out, each with a finding.
///
/// # Errors
/// [`IoError::NotStated`] for a unit, kind or degree of freedom that neither file nor scene states;
/// reading errors.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., table 9.6.
pub fn frf_sets(files: &mut [HitFile]) -> Result<Vec<FrfSet>, IoError> {
    let mut collected = SetsByAxis::default();
    let mut alone = NoiseByPair::default();
    for file in files.iter_mut() {
        if entries_of_type(file.source.as_ref(), FunctionType::Frf).is_empty() {
            collected.findings.extend(alone.add_file(file)?);
        }
    }
    collected.findings.extend(repeated_channels(files));
    let mut over_all = Occurrences::default();
    for file in files {
        let mut in_file = NoiseByPair::default();
        if !entries_of_type(file.source.as_ref(), FunctionType::Frf).is_empty() {
            collected.findings.extend(in_file.add_file(file)?);
        }
        let named = Occurrences::default().of(file);
        let named_over_all = over_all.of(file);
        for index in entries_of_type(file.source.as_ref(), FunctionType::Frf) {
            let beside = in_file.of(&named[index]);
            let quality = if beside.is_empty() {
                alone.of(&named_over_all[index])
            } else {
                beside
            };
            match read_frf(file, index, quality) {
                Ok(read) => collected.add(read)?,
                Err(error) => collected.leave_out(file, index, error)?,
            }
        }
    }
    collected.finish()
}

/// The finding of files whose FRFs have the same channels, where no point is stated for them.
fn repeated_channels(files: &[HitFile]) -> Option<Finding> {
    let mut repeated: BTreeMap<(Option<Dof>, Option<Dof>), usize> = BTreeMap::new();
    for file in files {
        let (response, reference) = (file.response.as_ref(), file.reference.as_ref());
        let names_channel = |entry: &&Entry| {
            entry.function_type == FunctionType::Frf
                && (entry.response_is_channel && response.is_none()
                    || entry.reference_is_channel && reference.is_none())
        };
        let entries = file.source.catalog().entries.iter().filter(names_channel);
        let pair = |entry: &Entry| {
            let response = entry.response_point(response);
            (response, entry.reference_point(reference))
        };
        for pair in entries.map(pair).collect::<BTreeSet<_>>() {
            *repeated.entry(pair).or_default() += 1;
        }
    }
    let (pair, files) = repeated.into_iter().find(|(_, files)| *files > 1)?;
    let location = Location::Function {
        response: pair.0,
        reference: pair.1,
    };
    let finding = Finding::new(Severity::Warning, Code::ChannelsRepeated, location);
    Some(finding.value(files as f64, "files"))
}

/// Sets of one axis and window each, while functions are added.
#[derive(Default)]
struct SetsByAxis {
    sets: Vec<SetOfAxis>,
    findings: Vec<Finding>,
    /// Why the first function was left out.
    left_out: Option<IoError>,
}

struct SetOfAxis {
    set: FrfSet,
    /// Numbers of repeated measurements that each pair has.
    repeats: BTreeMap<(Dof, Dof), BTreeSet<u32>>,
    valid_bands: Vec<Band>,
    windows: StatedWindows,
    averages_assumed: bool,
}

impl SetsByAxis {
    /// Adds a function to the set of its axis and window, which begins with the first one. A
    /// repeated measurement of a pair gets the next free number.
    fn add(&mut self, read: ReadFrf) -> Result<(), IoError> {
        let (axis, note) = (read.axis, &read.note);
        let decay = note.added_damping_rad_s.unwrap_or(0.0);
        let fits = |collecting: &SetOfAxis| {
            let set = &collecting.set;
            set.axis().same_lines(&axis) && set.added_damping_rad_s.to_bits() == decay.to_bits()
        };
        let place = self.sets.iter().position(fits).unwrap_or_else(|| {
            let mut set = FrfSet::new(axis);
            (set.added_damping_rad_s, set.record_duration_s) = (decay, note.record_s);
            self.sets.push(SetOfAxis {
                set,
                repeats: BTreeMap::new(),
                valid_bands: Vec::new(),
                windows: StatedWindows::default(),
                averages_assumed: false,
            });
            self.sets.len() - 1
        });
        self.sets[place].add(read)
    }

    /// Leaves a function out whose header states another quantity than motion over force; with
    /// --partial any that cannot be used.
    fn leave_out(&mut self, file: &HitFile, index: usize, error: IoError) -> Result<(), IoError> {
        let entry = &file.source.catalog().entries[index];
        let severity = match (is_other_quantity(entry), file.partial) {
            (true, _) => Severity::Warning,
            (false, true) => Severity::Error,
            (false, false) => return Err(error),
        };
        let location = Location::Function {
            response: entry.response.clone(),
            reference: entry.reference.clone(),
        };
        let finding = Finding::new(severity, Code::FunctionLeftOut, location);
        self.findings.push(finding.detail(error.to_string()));
        self.left_out.get_or_insert(error);
        Ok(())
    }

    /// The sets; the error of the first function that was left out where there is no other.
    fn finish(self) -> Result<Vec<FrfSet>, IoError> {
        let mut sets: Vec<FrfSet> = self.sets.into_iter().map(SetOfAxis::finish).collect();
        match (sets.first_mut(), self.left_out) {
            (Some(first), _) => first.findings.extend(self.findings),
            (None, Some(error)) => return Err(error),
            (None, None) => {}
        }
        Ok(sets)
    }
}

impl SetOfAxis {
    fn add(&mut self, read: ReadFrf) -> Result<(), IoError> {
        let (note, mut function) = (read.note, read.function);
        let band = note.valid_hz.and_then(|(lo, hi)| Band::new(lo, hi).ok());
        self.valid_bands.extend(band);
        self.averages_assumed |= read.averages_assumed;
        self.set.findings.extend(read.findings);
        self.set.is_interpolated |= read.is_interpolated;
        // Window and record length are what is true of all functions.
        self.windows
            .add(&function.response, &function.reference, note.window);
        let common = self.set.record_duration_s;
        self.set.record_duration_s = common.filter(|duration| note.record_s == Some(*duration));
        let pair = (function.response.with_repeat(1), function.reference.clone());
        let taken = self.repeats.entry(pair).or_default();
        if taken.contains(&function.response.repeat()) {
            let next = taken.last().map_or(1, |largest| largest.saturating_add(1));
            function.response = function.response.with_repeat(next);
        }
        taken.insert(function.response.repeat());
        let pushed = self.set.push(function, read.data);
        pushed.map_err(|error| IoError::Grouping {
            path: read.path,
            what: "collecting FRFs of one axis",
            got: error.to_string(),
            expected: "each pair once on one axis".to_owned(),
        })
    }

    fn finish(mut self) -> FrfSet {
        let mut bands = self.valid_bands.into_iter();
        let first = bands.next();
        self.set.valid_band = first
            .and_then(|first| bands.try_fold(first, |common, band| common.intersection(&band)));
        self.set.window = self.windows.common();
        self.set.mixed_windows = self.windows.mixed();
        self.set.findings.extend(self.windows.finding());
        if self.averages_assumed {
            let finding = Finding::new(Severity::Warning, Code::AveragesAssumed, Location::Whole);
            let averages = f64::from(ASSUMED_AVERAGES);
            self.set.findings.push(finding.value(averages, "averages"));
        }
        self.set
    }
}

fn entries_of_type(source: &dyn Source, wanted: FunctionType) -> Vec<usize> {
    let entries = source.catalog().entries.iter().enumerate();
    entries
        .filter(|(_, entry)| entry.function_type == wanted)
        .map(|(index, _)| index)
        .collect()
}

/// Response, reference and which occurrence of the pair in its file, from 0.
type Occurrence = (Option<Dof>, Option<Dof>, usize);

/// How often each pair was met, by type.
#[derive(Default)]
struct Occurrences(BTreeMap<(FunctionType, Option<Dof>, Option<Dof>), usize>);

impl Occurrences {
    /// For each entry of a file which occurrence of its pair it is among those of its type, the
    /// files before counted in; points that the header leaves open are the scene's.
    fn of(&mut self, file: &HitFile) -> Vec<Occurrence> {
        let numbered = |entry: &Entry| {
            let response = entry.response_point(file.response.as_ref());
            let reference = entry.reference_point(file.reference.as_ref());
            let key = (entry.function_type, response.clone(), reference.clone());
            let count = self.0.entry(key).or_default();
            *count += 1;
            (response, reference, *count - 1)
        };
        file.source.catalog().entries.iter().map(numbered).collect()
    }
}

type OnAxis<T> = (FrequencyAxis, T);

/// Coherences and variances by the pair that they belong to.
#[derive(Default)]
struct NoiseByPair {
    occurrences: Occurrences,
    coherence: BTreeMap<Occurrence, OnAxis<ValidCoherence>>,
    variance: BTreeMap<Occurrence, OnAxis<Vec<f64>>>,
}

/// Coherence and variance of one function.
struct FrfNoise<'a> {
    coherence: Option<&'a OnAxis<ValidCoherence>>,
    variance: Option<&'a OnAxis<Vec<f64>>>,
}

impl FrfNoise<'_> {
    fn is_empty(&self) -> bool {
        self.coherence.is_none() && self.variance.is_none()
    }
}

impl NoiseByPair {
    /// Adds those of a file; one that cannot be read is a finding, for no FRF needs it.
    fn add_file(&mut self, file: &mut HitFile) -> Result<Vec<Finding>, IoError> {
        let named = self.occurrences.of(file);
        let mut findings = Vec::new();
        for index in entries_of_type(file.source.as_ref(), FunctionType::Coherence) {
            if let Some((axis, values)) = read_auxiliary(file, index, &mut findings)? {
                let valid = valid_coherence(&axis, values);
                self.coherence.insert(named[index].clone(), (axis, valid));
            }
        }
        for index in entries_of_type(file.source.as_ref(), FunctionType::Variance) {
            let to_si = file.source.catalog().entries[index].to_si;
            let read = read_auxiliary(file, index, &mut findings)?;
            let (Some((axis, values)), Some(to_si)) = (read, to_si) else {
                continue;
            };
            let values = values.into_iter().map(|v| v * to_si).collect();
            self.variance.insert(named[index].clone(), (axis, values));
        }
        Ok(findings)
    }

    fn of(&self, named: &Occurrence) -> FrfNoise<'_> {
        FrfNoise {
            coherence: self.coherence.get(named),
            variance: self.variance.get(named),
        }
    }
}

/// The values of a function beside FRFs; `None`, with a finding, where they cannot be read.
///
/// # Errors
/// [`IoError::System`].
fn read_auxiliary(
    file: &mut HitFile,
    index: usize,
    findings: &mut Vec<Finding>,
) -> Result<Option<OnAxis<Vec<f64>>>, IoError> {
    match read_real_values(file, index) {
        Err(error) if !matches!(error, IoError::System { .. }) => {
            let entry = &file.source.catalog().entries[index];
            let location = Location::Function {
                response: entry.response.clone(),
                reference: entry.reference.clone(),
            };
            let finding = Finding::new(Severity::Warning, Code::BadDataset, location);
            findings.push(finding.detail(error.to_string()));
            Ok(None)
        }
        read => read,
    }
}

/// The values of an entry on an even frequency axis.
fn read_real_values(file: &mut HitFile, index: usize) -> Result<Option<OnAxis<Vec<f64>>>, IoError> {
    let entry = &file.source.catalog().entries[index];
    let len = entry.len();
    let is_frequency = match entry.axis {
        EntryAxis::Frequency(_) => true,
        EntryAxis::Time(_) => false,
        EntryAxis::General(axis) => axis.domain == Domain::Frequency,
    };
    if !is_frequency {
        return Ok(None);
    }
    let path = file.source.catalog().path.clone();
    let (axis, uneven) = frequency_lines(file, index, &path)?;
    let mut block = Block::F64(Vec::new());
    file.source.read(index, 0..len, &mut block)?;
    let values: Vec<f64> = match block {
        Block::F32(values) => values.into_iter().map(f64::from).collect(),
        Block::F64(values) => values,
        Block::Complex(values) => values.into_iter().map(|value| value.re).collect(),
    };
    let values = match uneven {
        Some(lines) => lines.linear(&values),
        None => values,
    };
    Ok(Some((axis, values)))
}

fn read_frf(file: &mut HitFile, index: usize, beside: FrfNoise) -> Result<ReadFrf, IoError> {
    let entry = file.source.catalog().entries[index].clone();
    let path = file.source.catalog().path.clone();
    let place = entry
        .line
        .map_or_else(|| path.clone(), |line| format!("{path}:{line}"));
    let not_stated = |what: &str, expected: &str| IoError::NotStated {
        path: place.clone(),
        what: format!("{what} of function {}", index + 1),
        expected: expected.to_owned(),
    };
    let response = entry.response_point(file.response.as_ref());
    let stated = response
        .as_ref()
        .and_then(|response| StatedFrfUnit::of_entry(&file.frf_units, &entry, response));
    if stated.is_none() && is_other_quantity(&entry) {
        return Err(IoError::Grouping {
            path: place,
            what: "reading FRFs",
            got: format!("function {} in {:?}", index + 1, entry.unit_label),
            expected:
                "displacement, velocity or acceleration over force; to use it, state `unit`, \
                       such as Pa/N, with the `dof` of its response in [[test.channel]]"
                    .to_owned(),
        });
    }
    let response = response.ok_or_else(|| {
        not_stated(
            "the response point",
            "a response node in the header, `dof` of the column in [[test.channel]] or `response` in \
             [[test.file]]",
        )
    })?;
    let reference = entry.reference_point(file.reference.as_ref());
    let reference = reference.ok_or_else(|| {
        not_stated(
            "the reference point",
            "a reference node in the header or `reference` in [[test.file]]",
        )
    })?;
    let (axis, uneven) = frequency_lines(file, index, &place)?;
    let of_header = frf_kind(&entry);
    let missing = file.missing_frf_unit;
    let missing = missing.filter(|unit| of_header.is_none_or(|kind| kind == unit.kind));
    let kind = stated.map(|unit| unit.kind).or(of_header);
    let kind = kind.or(missing.map(|unit| unit.kind)).ok_or_else(|| {
        not_stated(
            &format!("the kind (unit label {:?})", entry.unit_label),
            "an ordinate of displacement, velocity or acceleration over force",
        )
    })?;
    let to_si = stated.map(|unit| unit.to_si).or(entry.to_si);
    let to_si = to_si.or(missing.map(|unit| unit.to_si)).ok_or_else(|| {
        not_stated(
            &format!("the unit (label {:?})", entry.unit_label),
            "units of response and force in the header, or `unit` in [[test.channel]] such as \
             (m/s2)/N",
        )
    })?;
    let mut block = Block::Complex(Vec::new());
    file.source.read(index, 0..entry.len(), &mut block)?;
    let Block::Complex(values) = block else {
        return Err(not_stated("the imaginary part", "complex values"));
    };
    let mut measured: Vec<Complex64> = values.into_iter().map(|value| value * to_si).collect();
    let ascending = uneven.as_ref().and_then(|lines| lines.reordered(&measured));
    let uneven = uneven.filter(|_| ascending.is_none());
    measured = ascending.unwrap_or(measured);
    let mut even = uneven
        .as_ref()
        .map(|lines| lines.interpolated(&measured, None));
    let values = match &mut even {
        Some(even) => std::mem::take(&mut even.values),
        None => std::mem::take(&mut measured),
    };
    let mut note = entry.note.clone();
    note.window = note.window.or(file.window);
    let coherence = on_same_axis(beside.coherence, &axis);
    let finding = coherence.as_ref().and_then(|valid| valid.finding.clone());
    let location = Location::Function {
        response: Some(response.clone()),
        reference: Some(reference.clone()),
    };
    let contradiction = stated.and_then(|unit| contradiction(&entry, unit));
    let of_uneven = uneven.as_ref().map(|lines| {
        let finding = Finding::new(Severity::Warning, Code::LinesInterpolated, Location::Whole);
        finding.value(lines.axis.step_hz, "Hz")
    });
    let findings = [finding, contradiction, of_uneven].into_iter().flatten();
    let findings = findings.map(|finding| Finding {
        location: location.clone(),
        ..finding
    });
    let findings = findings.collect();
    let coherence = coherence.and_then(|valid| valid.values);
    let coherence = coherence.filter(|values| !is_one_everywhere(values));
    // The variance of the file is in the square of its unit.
    let to_stated = entry.to_si.map_or(1.0, |of_file| to_si / of_file);
    let stated = on_same_axis(beside.variance, &axis);
    let stated = stated.map(|mut variance| {
        variance
            .iter_mut()
            .for_each(|value| *value *= to_stated * to_stated);
        variance
    });
    let averages = note.averages.or(file.averages);
    // The scatter of n hits has 2(n − 1) degrees of freedom; who states the variance states them
    // too.
    let variance_dof = match &stated {
        Some(_) => note.variance_dof,
        None => averages.filter(|n| *n >= 2).map(|n| 2.0 * f64::from(n - 1)),
    };
    let averages_assumed = stated.is_none() && coherence.is_some() && averages.is_none();
    let variance = stated.or_else(|| {
        let averages = averages.unwrap_or(ASSUMED_AVERAGES);
        variance_of_values(&values, coherence.as_deref(), averages)
    });
    let variance = match (&uneven, variance) {
        (Some(lines), Some(stated)) => Some(lines.interpolated(&measured, Some(&stated)).variance),
        (_, stated) => stated.or(even.map(|even| even.variance)),
    };
    let function = Function {
        response,
        reference,
        kind,
        averages,
        estimator: note.estimator,
        variance_dof: variance_dof.filter(|_| variance.is_some()),
    };
    Ok(ReadFrf {
        path,
        axis: FrequencyAxis {
            step_hz: exact_step(axis.step_hz, note.record_s),
            ..axis
        },
        function,
        data: FunctionData {
            values,
            coherence,
            variance,
        },
        note,
        averages_assumed,
        is_interpolated: uneven.is_some() || entry.note.interpolated,
        findings,
    })
}

/// The lines of an FRF, with their interpolation where those of the file are uneven.
fn frequency_lines(
    file: &mut HitFile,
    index: usize,
    place: &str,
) -> Result<(FrequencyAxis, Option<EvenLines>), IoError> {
    let axis = file.source.catalog().entries[index].axis;
    let not_lines = |got: &str| IoError::Grouping {
        path: place.to_owned(),
        what: "reading FRFs",
        got: format!("{got} at function {}", index + 1),
        expected: "frequency lines in Hz".to_owned(),
    };
    match axis {
        EntryAxis::Frequency(axis) => Ok((axis, None)),
        EntryAxis::Time(_) => Err(not_lines("a time axis")),
        EntryAxis::General(axis) if axis.domain == Domain::Frequency => {
            let mut frequencies_hz = Vec::new();
            file.source
                .abscissa(index, 0..axis.len, &mut frequencies_hz)?;
            let lines = EvenLines::new(&frequencies_hz);
            let lines = lines.ok_or_else(|| not_lines("too few lines or no frequencies"))?;
            Ok((lines.axis, Some(lines)))
        }
        EntryAxis::General(_) => Err(not_lines("an abscissa that is not in Hz")),
    }
}

/// The finding, without a place, of a stated unit that is another than the header's.
fn contradiction(entry: &Entry, stated: FrfUnit) -> Option<Finding> {
    let of_label = FrfUnit::of_any_response(&entry.unit_label).ok();
    let of_header = frf_kind(entry).or(of_label.map(|unit| unit.kind))?;
    let to_si = entry.to_si.or(of_label.map(|unit| unit.to_si));
    let same_factor = |of_file: f64| (stated.to_si / of_file - 1.0).abs() < 1e-9;
    if of_header == stated.kind && to_si.is_none_or(same_factor) {
        return None;
    }
    let finding = Finding::new(
        Severity::Warning,
        Code::UnitContradictsFile,
        Location::Whole,
    );
    let label = match entry.unit_label.as_str() {
        "" => "no unit",
        label => label,
    };
    Some(finding.detail(format!(
        "the header has {of_header} in {label}, stated is {} x {}",
        stated.to_si,
        stated.kind.si_unit()
    )))
}

/// The values on this axis.
fn on_same_axis<T: Clone>(found: Option<&OnAxis<T>>, axis: &FrequencyAxis) -> Option<T> {
    let found = found.filter(|(on_axis, _)| on_axis.same_lines(axis));
    found.map(|(_, on_axis)| on_axis.clone())
}

/// A coherence of 1 at every line is that of one average.
fn is_one_everywhere(coherence: &[f64]) -> bool {
    coherence.iter().all(|g2| *g2 > 1.0 - 1e-9)
}

/// The line spacing of whole records is one over their length; a file prints it with seven digits.
fn exact_step(printed_hz: f64, record_s: Option<f64>) -> f64 {
    let exact = record_s.map(|length| 1.0 / length);
    exact
        .filter(|exact| (exact - printed_hz).abs() < 1e-6 * printed_hz)
        .unwrap_or(printed_hz)
}

fn variance_of_values(
    values: &[Complex64],
    coherence: Option<&[f64]>,
    averages: u32,
) -> Option<Vec<f64>> {
    let coherence = coherence.filter(|_| averages >= 2)?;
    Some(variance_from_coherence(values, coherence, averages))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_follows_coherence_and_averages() {
        let h = [Complex64::new(3.0, 4.0)];
        let value = variance_of_values(&h, Some(&[0.8]), 3).unwrap()[0];
        assert!((value - 25.0 * 0.2 / (0.8 * 2.0)).abs() < 1e-12);
        assert!(
            variance_of_values(&h, Some(&[0.8]), 1).is_none()
                && variance_of_values(&h, None, 3).is_none()
        );
    }
}
