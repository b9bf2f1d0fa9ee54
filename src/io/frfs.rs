//! FRF and coherence entries of files become FRF sets, one per axis.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::frf::{Estimator, FrfSet, Function, FunctionData};
use crate::quantity::{FrfKind, Quantity};

use super::{Block, Entry, EntryAxis, FunctionType, HitFile, IoError, Source};

/// What modalign's own files say of a function in their ID lines 4 and 5.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FunctionNote {
    /// Number of averages.
    pub averages: Option<u32>,
    /// Estimator.
    pub estimator: Option<Estimator>,
    /// Decay rate of the exponential window still in the values, rad/s.
    pub added_damping_rad_s: Option<f64>,
    /// Length of the records, s.
    pub record_s: Option<f64>,
    /// Where the function is valid, Hz.
    pub valid_hz: Option<(f64, f64)>,
}

/// The mark that the line begins with.
const NOTE_MARK: &str = "modalign ";

impl FunctionNote {
    /// ID lines 4 and 5, such as `modalign averages=5 estimator=h1 added_damping_rad_s=12.5 record_s=1.28` and
    /// `modalign valid_hz=0.5:1600`; empty where nothing is known. A line of a universal file holds 80 characters.
    pub fn to_lines(&self) -> [String; 2] {
        let fourth = [
            self.averages.map(|n| format!("averages={n}")),
            self.estimator
                .map(|estimator| format!("estimator={}", estimator.name())),
            self.added_damping_rad_s
                .map(|decay| format!("added_damping_rad_s={decay}")),
            self.record_s.map(|length| format!("record_s={length}")),
        ];
        let fifth = [self.valid_hz.map(|(lo, hi)| format!("valid_hz={lo}:{hi}"))];
        [marked(&fourth), marked(&fifth)]
    }

    /// What the ID lines of a header say; nothing where they are another program's.
    pub fn from_lines(lines: &[String]) -> Self {
        let mut note = Self::default();
        let marked = lines.iter().filter_map(|line| line.strip_prefix(NOTE_MARK));
        let fields = marked
            .flat_map(str::split_whitespace)
            .filter_map(|field| field.split_once('='));
        for (key, value) in fields {
            match key {
                "averages" => note.averages = value.parse().ok(),
                "estimator" => note.estimator = Estimator::from_name(value),
                "added_damping_rad_s" => note.added_damping_rad_s = value.parse().ok(),
                "record_s" => note.record_s = value.parse().ok(),
                "valid_hz" => note.valid_hz = range(value),
                _ => {}
            }
        }
        note
    }
}

fn marked(fields: &[Option<String>]) -> String {
    let known: Vec<&str> = fields.iter().flatten().map(String::as_str).collect();
    if known.is_empty() {
        String::new()
    } else {
        format!("{NOTE_MARK}{}", known.join(" "))
    }
}

fn range(text: &str) -> Option<(f64, f64)> {
    let (lo, hi) = text.split_once(':')?;
    Some((lo.parse().ok()?, hi.parse().ok()?))
}

/// One function with its axis.
struct Read {
    path: String,
    axis: FrequencyAxis,
    function: Function,
    data: FunctionData,
    note: FunctionNote,
}

/// Collects the FRFs of files into sets of one axis each, in order of appearance; coherence joins its function.
///
/// The variance is that of H1 with the stated coherence and number of averages, |H|²(1−γ²)/(γ²(n−1)); unknown where one
/// of them is.
///
/// # Errors
/// [`IoError::NotStated`] for a unit, kind or degree of freedom that neither file nor scene states; reading errors.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., table 9.6.
pub fn frf_sets(files: &mut [HitFile]) -> Result<Vec<FrfSet>, IoError> {
    let mut read = Vec::new();
    for file in files {
        let coherences = coherences(file)?;
        for index in of_type(file.source.as_ref(), FunctionType::Frf) {
            read.push(read_function(file, index, &coherences)?);
        }
    }
    let mut sets: Vec<FrfSet> = Vec::new();
    for function in read {
        add(&mut sets, function)?;
    }
    Ok(sets)
}

/// Adds a function to the set of its axis and window, which begins with the first one.
fn add(
    sets: &mut Vec<FrfSet>,
    Read {
        path,
        axis,
        function,
        data,
        note,
    }: Read,
) -> Result<(), IoError> {
    let decay = note.added_damping_rad_s.unwrap_or(0.0);
    let valid = note.valid_hz.and_then(|(lo, hi)| Band::new(lo, hi).ok());
    let fits = |set: &FrfSet| {
        set.axis().same_lines(&axis) && set.added_damping_rad_s.to_bits() == decay.to_bits()
    };
    let place = sets.iter().position(fits).unwrap_or_else(|| {
        let mut set = FrfSet::new(axis);
        (
            set.added_damping_rad_s,
            set.record_duration_s,
            set.valid_band,
        ) = (decay, note.record_s, valid);
        sets.push(set);
        sets.len() - 1
    });
    let set = &mut sets[place];
    // What is true of all functions: the common band, and the record length where it is one.
    set.valid_band = match (set.valid_band, valid) {
        (Some(own), Some(other)) => own.intersection(&other),
        (own, other) => own.or(other),
    };
    set.record_duration_s = set
        .record_duration_s
        .filter(|own| note.record_s == Some(*own));
    let function = unrepeated(set, function);
    set.push(function, data).map_err(|error| IoError::Grouping {
        path,
        what: "collecting FRFs of one axis",
        got: error.to_string(),
        expected: "each pair once on one axis".to_owned(),
    })
}

/// Gives a repeated measurement of a pair the next free number.
fn unrepeated(set: &FrfSet, function: Function) -> Function {
    let same = |f: &&Function| {
        f.response.with_repeat(1) == function.response.with_repeat(1)
            && f.reference == function.reference
    };
    let taken: Vec<u32> = set
        .functions()
        .iter()
        .filter(same)
        .map(|f| f.response.repeat())
        .collect();
    if !taken.contains(&function.response.repeat()) {
        return function;
    }
    let next = taken.iter().max().map_or(1, |largest| largest + 1);
    Function {
        response: function.response.with_repeat(next),
        ..function
    }
}

fn of_type(source: &dyn Source, wanted: FunctionType) -> Vec<usize> {
    let entries = source.catalog().entries.iter().enumerate();
    entries
        .filter(|(_, entry)| entry.function_type == wanted)
        .map(|(index, _)| index)
        .collect()
}

/// Response, reference and which occurrence of the pair in its file, from 0.
type Occurrence = (Option<Dof>, Option<Dof>, usize);

/// Which occurrence of its pair an entry is among those of its type.
fn occurrence(file: &HitFile, index: usize) -> Occurrence {
    let entries = &file.source.catalog().entries;
    let own = &entries[index];
    let same = |entry: &&Entry| {
        entry.function_type == own.function_type
            && entry.response == own.response
            && entry.reference == own.reference
    };
    let before = entries[..index].iter().filter(same).count();
    (own.response.clone(), own.reference.clone(), before)
}

type Coherences = BTreeMap<Occurrence, (FrequencyAxis, Vec<f64>)>;

fn coherences(file: &mut HitFile) -> Result<Coherences, IoError> {
    let mut found = BTreeMap::new();
    for index in of_type(file.source.as_ref(), FunctionType::Coherence) {
        let entry = file.source.catalog().entries[index].clone();
        let EntryAxis::Frequency(axis) = entry.axis else {
            continue;
        };
        let mut block = Block::F64(Vec::new());
        file.source.read(index, 0..entry.len(), &mut block)?;
        let values: Vec<f64> = match block {
            Block::F32(values) => values.into_iter().map(f64::from).collect(),
            Block::F64(values) => values,
            Block::Complex(values) => values.into_iter().map(|value| value.re).collect(),
        };
        check_coherence(&values, file, index)?;
        // Single precision may round one a little above itself.
        let values = values
            .into_iter()
            .map(|value| value.clamp(0.0, 1.0))
            .collect();
        found.insert(occurrence(file, index), (axis, values));
    }
    Ok(found)
}

fn check_coherence(values: &[f64], file: &HitFile, index: usize) -> Result<(), IoError> {
    let bad = values
        .iter()
        .enumerate()
        .find(|(_, value)| !(-1e-6..=1.0 + 1e-6).contains(*value));
    bad.map_or(Ok(()), |(line, value)| {
        Err(IoError::Grouping {
            path: file.source.catalog().path.clone(),
            what: "reading a coherence",
            got: format!("{value} at line {line} of function {}", index + 1),
            expected: "0 to 1".to_owned(),
        })
    })
}

fn read_function(
    file: &mut HitFile,
    index: usize,
    coherences: &Coherences,
) -> Result<Read, IoError> {
    let entry = file.source.catalog().entries[index].clone();
    let path = file.source.catalog().path.clone();
    let not_stated = |what: &str, expected: &str| IoError::NotStated {
        path: entry
            .line
            .map_or_else(|| path.clone(), |line| format!("{path}:{line}")),
        what: format!("{what} of function {}", index + 1),
        expected: expected.to_owned(),
    };
    let EntryAxis::Frequency(axis) = entry.axis else {
        return Err(not_stated("the frequency axis", "an abscissa in Hz"));
    };
    let response = entry.response.clone().or_else(|| file.response.clone());
    let response = response.ok_or_else(|| {
        not_stated(
            "the response point",
            "a response node in the header or `response` in [[test.file]]",
        )
    })?;
    let reference = entry.reference.clone().or_else(|| file.reference.clone());
    let reference = reference.ok_or_else(|| {
        not_stated(
            "the reference point",
            "a reference node in the header or `reference` in [[test.file]]",
        )
    })?;
    let stated = file.frf_unit;
    let kind = kind(&entry)
        .or(stated.map(|unit| unit.kind))
        .ok_or_else(|| {
            not_stated(
                "the kind",
                "an ordinate of displacement, velocity or acceleration over force",
            )
        })?;
    let label = entry.unit_label.clone();
    let stated = stated
        .filter(|unit| unit.kind == kind)
        .map(|unit| unit.to_si);
    let to_si = entry.to_si.or(stated).ok_or_else(|| {
        not_stated(
            &format!("the unit (label {label:?})"),
            "units of response and force in the header, or `unit` in [[test.channel]] such as (m/s2)/N",
        )
    })?;
    let mut block = Block::Complex(Vec::new());
    file.source.read(index, 0..entry.len(), &mut block)?;
    let Block::Complex(values) = block else {
        return Err(not_stated("the imaginary part", "complex values"));
    };
    let values: Vec<Complex64> = values.into_iter().map(|value| value * to_si).collect();
    let note = FunctionNote::from_lines(&entry.identification.lines);
    let coherence = coherences.get(&occurrence(file, index));
    let coherence = coherence
        .filter(|(own, _)| own.same_lines(&axis))
        .map(|(_, values)| values.clone());
    let variance = variance(&values, coherence.as_deref(), note.averages);
    let function = Function {
        response,
        reference,
        kind,
        averages: note.averages,
        estimator: note.estimator,
    };
    Ok(Read {
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
    })
}

/// The line spacing of whole records is one over their length; a file prints it with seven digits.
fn exact_step(printed_hz: f64, record_s: Option<f64>) -> f64 {
    let exact = record_s.map(|length| 1.0 / length);
    exact
        .filter(|exact| (exact - printed_hz).abs() < 1e-6 * printed_hz)
        .unwrap_or(printed_hz)
}

fn kind(entry: &Entry) -> Option<FrfKind> {
    let over_force = entry.denominator == Some(Quantity::Force);
    entry
        .quantity
        .filter(|_| over_force)
        .and_then(FrfKind::from_response)
}

fn variance(
    values: &[Complex64],
    coherence: Option<&[f64]>,
    averages: Option<u32>,
) -> Option<Vec<f64>> {
    let (coherence, averages) = (coherence?, averages.filter(|n| *n >= 2)?);
    let of_line = |(h, g2): (&Complex64, &f64)| {
        if *g2 > 0.0 {
            h.norm_sqr() * (1.0 - g2) / (g2 * f64::from(averages - 1))
        } else {
            f64::INFINITY
        }
    };
    Some(values.iter().zip(coherence).map(of_line).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_comes_back_and_other_lines_say_nothing() {
        let note = FunctionNote {
            averages: Some(5),
            estimator: Some(Estimator::Hv),
            added_damping_rad_s: Some(12.5),
            record_s: Some(1.28),
            valid_hz: Some((0.25, 3276.5)),
        };
        let lines = note.to_lines();
        assert_eq!(FunctionNote::from_lines(&lines), note);
        assert_eq!(
            lines[0],
            "modalign averages=5 estimator=hv added_damping_rad_s=12.5 record_s=1.28"
        );
        assert_eq!(lines[1], "modalign valid_hz=0.25:3276.5");
        assert_eq!(
            FunctionNote::from_lines(&["averages=5".to_owned()]),
            FunctionNote::default()
        );
        assert_eq!(FunctionNote::default().to_lines(), ["", ""]);
    }

    #[test]
    fn variance_follows_coherence_and_averages() {
        let h = [Complex64::new(3.0, 4.0)];
        let value = variance(&h, Some(&[0.8]), Some(3)).unwrap()[0];
        assert!((value - 25.0 * 0.2 / (0.8 * 2.0)).abs() < 1e-12);
        assert!(
            variance(&h, Some(&[0.8]), Some(1)).is_none() && variance(&h, None, Some(3)).is_none()
        );
    }
}
