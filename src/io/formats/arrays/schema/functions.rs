//! Records and functions to arrays: one group for each type, axis and sample format.

use std::collections::{BTreeMap, BTreeSet};

use crate::io::formats::arrays::store::{Elements, NamedArray};
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::{
    Block, Entry, EntryAxis, IoError, Precision, SampleFormat, Source, sha256_of_bytes,
};

use super::arrays::{Put, Wanted, numbers, text, texts, whole_numbers};
use super::entry_fields::{NUMBERS, TEXTS, axis_name, domain_name, format_name};

/// Functions of one type, axis and sample format.
struct Group {
    name: String,
    /// Places in the catalogue, ascending.
    entries: Vec<usize>,
    stored: SampleFormat,
}

/// Which part of the values an array holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Real,
    Imaginary,
}

/// Emits every function of a source.
pub(super) fn write(
    source: &mut dyn Source,
    wanted: Wanted,
    put: &mut Put,
    lost: &mut DroppedContent,
) -> Result<(), IoError> {
    for group in groups(source, wanted)? {
        describe(source, &group, put)?;
        axis(source, &group, wanted, put)?;
        samples(source, &group, wanted, put)?;
    }
    let ids = source
        .catalog()
        .entries
        .iter()
        .map(|entry| &entry.identification);
    let ids = ids.flat_map(|id| [id.version, id.load_case]);
    let (_, inexact) = whole_numbers(ids);
    lost.add("version numbers and load cases beyond 2^53", inexact);
    Ok(())
}

fn groups(source: &mut dyn Source, wanted: Wanted) -> Result<Vec<Group>, IoError> {
    let mut groups: Vec<Group> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    let mut names = BTreeSet::new();
    for index in 0..source.catalog().entries.len() {
        let entry = source.catalog().entries[index].clone();
        let stored = stored_as(entry.format, wanted);
        let type_name = entry.function_type.name();
        let axis = axis_key(source, index, &entry)?;
        let key = format!("{type_name} {} {axis}", format_name(stored));
        let place = *known.entry(key).or_insert_with(|| {
            groups.push(Group {
                name: free_name(&type_name, &mut names),
                entries: Vec::new(),
                stored,
            });
            groups.len() - 1
        });
        groups[place].entries.push(index);
    }
    Ok(groups)
}

fn stored_as(format: SampleFormat, wanted: Wanted) -> SampleFormat {
    use SampleFormat::{ComplexF32, ComplexF64, RealF32, RealF64};
    match (wanted.precision, format) {
        (Some(Precision::Single), RealF32 | RealF64) => RealF32,
        (Some(Precision::Single), ComplexF32 | ComplexF64) => ComplexF32,
        (Some(Precision::Double), RealF32 | RealF64) => RealF64,
        (Some(Precision::Double), ComplexF32 | ComplexF64) => ComplexF64,
        (None, format) => format,
    }
}

/// A text that is the same for equal axes alone: by the bits of an even one, by a fingerprint of an
/// uneven one.
fn axis_key(source: &mut dyn Source, index: usize, entry: &Entry) -> Result<String, IoError> {
    let kind = format!(
        "{} {} {}",
        axis_name(&entry.axis),
        domain_name(entry.axis.domain()),
        entry.len()
    );
    if let Some((start, step)) = entry.axis.even() {
        return Ok(format!("{kind} {:x} {:x}", start.to_bits(), step.to_bits()));
    }
    let mut abscissa = Vec::new();
    // A source need not have the abscissa of a function without samples.
    if !entry.is_empty() {
        source.abscissa(index, 0..entry.len(), &mut abscissa)?;
    }
    let fingerprint = sha256_of_bytes(bytemuck::cast_slice(&abscissa));
    Ok(format!("{kind} {fingerprint}"))
}

/// The name of a type as a name of MATLAB, with a number behind it when it is taken.
fn free_name(type_name: &str, taken: &mut BTreeSet<String>) -> String {
    let base = type_name.replace('-', "_");
    let numbered = (2..).map(|number: usize| format!("{base}_{number}"));
    let mut candidates = std::iter::once(base.clone()).chain(numbered);
    let free = candidates
        .find(|name| !taken.contains(name))
        .unwrap_or(base);
    taken.insert(free.clone());
    free
}

fn describe(source: &dyn Source, group: &Group, put: &mut Put) -> Result<(), IoError> {
    let all = &source.catalog().entries;
    let entries: Vec<&Entry> = group.entries.iter().map(|index| &all[*index]).collect();
    let (first, count) = (entries[0], entries.len());
    let name = |field: &str| format!("{}/{field}", group.name);
    put(text(&name("function_type"), &first.function_type.name()))?;
    put(text(&name("stored"), format_name(group.stored)))?;
    put(text(&name("domain"), &domain_name(first.axis.domain())))?;
    put(text(&name("axis"), axis_name(&first.axis)))?;
    let positions = group.entries.iter().map(|index| *index as f64);
    put(numbers(&name("position"), &[count], positions.collect()))?;
    for field in TEXTS {
        let values = entries.iter().map(|entry| (field.get)(entry)).collect();
        put(texts(&name(field.name), &[count], values))?;
    }
    for field in NUMBERS {
        let values: Vec<f64> = entries.iter().map(|entry| (field.get)(entry)).collect();
        if !field.is_optional || values.iter().any(|value| !value.is_nan()) {
            put(numbers(&name(field.name), &[count], values))?;
        }
    }
    let lines = entries
        .iter()
        .flat_map(|entry| entry.identification.lines.clone());
    put(texts(&name("id_lines"), &[count, 5], lines.collect()))?;
    let valid = entries.iter().flat_map(|entry| {
        let (lo, hi) = entry.note.valid_hz.unwrap_or((f64::NAN, f64::NAN));
        [lo, hi]
    });
    put(numbers(&name("valid_hz"), &[count, 2], valid.collect()))
}

fn axis(
    source: &mut dyn Source,
    group: &Group,
    wanted: Wanted,
    put: &mut Put,
) -> Result<(), IoError> {
    let index = group.entries[0];
    let axis = source.catalog().entries[index].axis;
    let len = if wanted.samples {
        source.catalog().entries[index].len()
    } else {
        0
    };
    let name = |field: &str| format!("{}/{field}", group.name);
    let mut abscissa = Vec::new();
    let Some((start, step)) = axis.even() else {
        if len > 0 {
            source.abscissa(index, 0..len, &mut abscissa)?;
        }
        return put(numbers(&name("abscissa"), &[len], abscissa));
    };
    put(numbers(&name("start"), &[], vec![start]))?;
    put(numbers(&name("step"), &[], vec![step]))?;
    if let EntryAxis::Frequency(axis) = axis {
        let hz = (0..len).map(|line| axis.hz(line)).collect();
        put(numbers(&name("frequency_hz"), &[len], hz))?;
    }
    Ok(())
}

fn samples(
    source: &mut dyn Source,
    group: &Group,
    wanted: Wanted,
    put: &mut Put,
) -> Result<(), IoError> {
    use SampleFormat::{ComplexF32, ComplexF64};
    let parts: &[(&str, Part)] = match group.stored {
        ComplexF32 | ComplexF64 => &[("re", Part::Real), ("im", Part::Imaginary)],
        _ => &[("values", Part::Real)],
    };
    let len = source.catalog().entries[group.entries[0]].len();
    for (field, part) in parts {
        let elements = match wanted.samples {
            true => rows(source, group, *part, wanted.precision)?,
            false => Elements::F64(Vec::new()),
        };
        put(NamedArray {
            name: format!("{}/{field}", group.name),
            shape: vec![group.entries.len(), len],
            elements,
        })?;
    }
    Ok(())
}

/// Values of all functions of a group, one function after the other.
fn rows(
    source: &mut dyn Source,
    group: &Group,
    part: Part,
    precision: Option<Precision>,
) -> Result<Elements, IoError> {
    let single = matches!(
        group.stored,
        SampleFormat::RealF32 | SampleFormat::ComplexF32
    );
    let mut rows = match single {
        true => Elements::F32(Vec::new()),
        false => Elements::F64(Vec::new()),
    };
    let mut block = Block::F64(Vec::new());
    for index in &group.entries {
        let len = source.catalog().entries[*index].len();
        source.read(*index, 0..len, &mut block)?;
        append(&mut rows, &block, part, precision.is_some());
    }
    Ok(rows)
}

/// Adds a block. Values that single precision does not hold exactly turn the whole array to double,
/// unless single was asked for (`round`).
fn append(rows: &mut Elements, block: &Block, part: Part, round: bool) {
    let imaginary = part == Part::Imaginary;
    match block {
        Block::F32(values) if !imaginary => match rows {
            Elements::F32(singles) => singles.extend_from_slice(values),
            _ => append_numbers(rows, values.iter().map(|v| f64::from(*v)), round),
        },
        Block::F64(values) if !imaginary => append_numbers(rows, values.iter().copied(), round),
        Block::F32(values) => append_numbers(rows, values.iter().map(|_| 0.0), round),
        Block::F64(values) => append_numbers(rows, values.iter().map(|_| 0.0), round),
        Block::Complex(values) if imaginary => {
            append_numbers(rows, values.iter().map(|v| v.im), round);
        }
        Block::Complex(values) => append_numbers(rows, values.iter().map(|v| v.re), round),
    }
}

fn append_numbers(rows: &mut Elements, values: impl Iterator<Item = f64> + Clone, round: bool) {
    // A value that overflows single precision is not rounded: the array then stays double.
    let held = |value: f64| {
        let single = value as f32;
        let fits = !value.is_finite() || single.is_finite();
        (round && fits) || f64::from(single).to_bits() == value.to_bits()
    };
    if let Elements::F32(stored) = rows {
        if values.clone().all(held) {
            stored.extend(values.map(|value| value as f32));
            return;
        }
        *rows = Elements::F64(stored.iter().map(|value| f64::from(*value)).collect());
    }
    if let Elements::F64(stored) = rows {
        stored.extend(values);
    }
}
