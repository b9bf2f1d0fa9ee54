//! The header of dataset 58 for an entry: fields that read back as the entry.
//!
//! Properties without a field in dataset 58 (start and step to the bit, the number of a repeated
//! measurement, how a function was made) go into ID lines 4 and 5 as `modalign key=value ...`,
//! where these are empty or already a note of modalign.

use super::axis::even_axis;
use super::dof_fields::DofFields;
use super::meaning::{AXIS, Ordinate, REFERENCE_REPEAT, REPEAT, ordinate, quantity};
use super::{Characteristic, Spacing};
use crate::dof::Dof;
use crate::io::catalog::function_metadata::{is_note_line, pack_fields};
use crate::io::formats::uff::dataset_164::Units;
use crate::io::formats::uff::fields::fixed_columns::{line_text, twelve_columns};
use crate::io::formats::uff::fields::{finite, half_unit};
use crate::io::{Domain, Entry, EntryAxis, FunctionType, IoError, SampleFormat};
use crate::quantity::{Quantity, Unit};

/// Columns of a unit's text.
const UNIT_COLUMNS: usize = 20;
/// A unit's text that says nothing, where an empty one would mean the units of the file.
const UNKNOWN_UNIT: &str = "unknown";
/// The units of the file as written: SI.
const SI: Units = Units {
    length: 1.0,
    force: 1.0,
};

/// The contents of a header.
pub(in crate::io::formats::uff) struct FunctionHeader {
    pub id_lines: [String; 5],
    pub function_type: i32,
    pub version: i64,
    pub load_case: i64,
    pub response: DofFields,
    pub reference: DofFields,
    pub format: SampleFormat,
    pub points: usize,
    /// Start and step as printed; `None` for an uneven abscissa.
    pub spacing: Option<[String; 2]>,
    pub abscissa: Characteristic,
    pub numerator: Characteristic,
    pub denominator: Characteristic,
}

/// A header with what values are to be multiplied by, and what found no place in it.
pub(in crate::io::formats::uff) struct Fitted {
    pub header: FunctionHeader,
    pub factor: f64,
    /// Kinds of what is lost, each once.
    pub lost: Vec<&'static str>,
}

/// The header of an entry whose values are written in a format; in SI units where that is asked
/// for. The entry must have a function type with a number.
///
/// # Errors
/// [`IoError::Unwritable`] for a number that its columns do not hold; [`IoError::Dof`] for a degree
/// of freedom that has no fields.
pub(in crate::io::formats::uff) fn fit(
    entry: &Entry,
    function_type: i32,
    format: SampleFormat,
    in_si: bool,
    path: &str,
) -> Result<Fitted, IoError> {
    let mut lost = Vec::new();
    let (sides, factor) = sides(entry, in_si, &mut lost);
    let [numerator, denominator] = sides;
    let spacing = spacing(entry);
    let header = FunctionHeader {
        id_lines: id_lines(entry, spacing.as_ref(), &mut lost),
        function_type,
        version: number(entry.identification.version, 5, "version number", path)?,
        load_case: number(entry.identification.load_case, 9, "load case", path)?,
        response: dof_fields(entry.response.as_ref(), path)?,
        reference: dof_fields(entry.reference.as_ref(), path)?,
        format,
        points: entry.len(),
        spacing,
        abscissa: abscissa(entry, &mut lost),
        numerator,
        denominator,
    };
    number(i64::from(function_type), 5, "function type", path)?;
    if entry.role.is_some() && role_differs(entry) {
        lost.push("role of a channel");
    }
    Ok(Fitted {
        header,
        factor,
        lost,
    })
}

/// A number that fits its columns.
fn number(value: i64, columns: u32, what: &'static str, path: &str) -> Result<i64, IoError> {
    let (least, most) = (-(10_i64.pow(columns - 1) - 1), 10_i64.pow(columns) - 1);
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(IoError::Unwritable {
        path: path.to_owned(),
        what,
        got: value.to_string(),
        expected: format!("{least} to {most}"),
    })
}

fn dof_fields(dof: Option<&Dof>, path: &str) -> Result<DofFields, IoError> {
    let fields = dof.map_or_else(|| Ok(DofFields::none()), DofFields::from_dof);
    fields.map_err(|source| IoError::Dof {
        path: path.to_owned(),
        source,
    })
}

fn role_differs(entry: &Entry) -> bool {
    use crate::record::Role;
    let read_back = match entry.quantity {
        Some(Quantity::Force) => Role::Force,
        _ => Role::Response,
    };
    entry.role != Some(read_back)
}

/// Start and step in their columns.
fn spacing(entry: &Entry) -> Option<[String; 2]> {
    let (start, step) = entry.axis.even()?;
    Some([twelve_columns(start), twelve_columns(step)])
}

/// Whether start and step as printed are read as the entry's axis.
fn reads_back(entry: &Entry, [start, step]: &[String; 2]) -> bool {
    let number = |text: &str| finite(text.as_bytes()).unwrap_or(f64::NAN);
    let half_unit = |text: &str| half_unit(text.as_bytes());
    let printed = Spacing {
        start: number(start),
        step: number(step),
        start_half_unit: half_unit(start),
        step_half_unit: half_unit(step),
    };
    let read = even_axis(entry.axis.domain(), 1.0, entry.len(), &printed, None);
    let bits = |axis: EntryAxis| axis.even().map(|(a, b)| (a.to_bits(), b.to_bits()));
    read.is_some_and(|read| bits(read.axis) == bits(entry.axis))
}

fn id_lines(
    entry: &Entry,
    spacing: Option<&[String; 2]>,
    lost: &mut Vec<&'static str>,
) -> [String; 5] {
    let mut fields = Vec::new();
    if let (Some(printed), Some((start, step))) = (spacing, entry.axis.even())
        && !reads_back(entry, printed)
    {
        fields.push(format!("{AXIS}={start}:{step}"));
    }
    for (key, dof) in [
        (REPEAT, &entry.response),
        (REFERENCE_REPEAT, &entry.reference),
    ] {
        let repeat = dof.as_ref().map_or(1, Dof::repeat);
        if repeat > 1 {
            fields.push(format!("{key}={repeat}"));
        }
    }
    let id_lines = &entry.identification.lines;
    let room = |line: &String| (line.is_empty() || is_note_line(line)).then(String::new);
    let mut notes = [room(&id_lines[3]), room(&id_lines[4])];
    let exact_lost = pack_fields(&fields, &mut notes[..]);
    let notes_lost = pack_fields(&entry.note.to_fields(), &mut notes[..]);
    if notes_lost > 0 {
        lost.push("note of how a function was made");
    }
    if exact_lost > 0 {
        lost.push("digits of the axis or number of a repeated measurement");
    }
    let lines: [String; 5] = std::array::from_fn(|i| line_text(&id_lines[i]));
    if lines
        .iter()
        .zip(id_lines)
        .any(|(line, id_line)| line != id_line.trim())
    {
        lost.push("characters of an identification line");
    }
    let [first, second, third, fourth, fifth] = lines;
    let [note_4, note_5] = notes;
    [
        first,
        second,
        third,
        note_4.unwrap_or(fourth),
        note_5.unwrap_or(fifth),
    ]
}

fn abscissa(entry: &Entry, lost: &mut Vec<&'static str>) -> Characteristic {
    let (code, unit) = match entry.axis.domain() {
        Domain::Time => (17, "s".to_owned()),
        Domain::Frequency => (18, "Hz".to_owned()),
        Domain::Other(code) => (i64::from(code), unit_text(&entry.axis_label, lost)),
    };
    Characteristic { code, unit }
}

/// A unit's text in its columns.
fn unit_text(label: &str, lost: &mut Vec<&'static str>) -> String {
    let mut text = line_text(label);
    while text.len() > UNIT_COLUMNS {
        text.pop();
    }
    if text != label.trim() {
        lost.push("characters of a unit");
    }
    text
}

/// Numerator and denominator that read back as the entry's quantities and factor to SI, and what
/// the values are to be multiplied by: one, but for a factor that no unit has.
fn sides(entry: &Entry, in_si: bool, lost: &mut Vec<&'static str>) -> ([Characteristic; 2], f64) {
    let meant = Ordinate {
        quantity: entry.quantity,
        denominator: entry.denominator,
        to_si: entry.to_si,
    };
    let read = |sides: &[Characteristic; 2]| {
        ordinate(entry.function_type, [&sides[0], &sides[1]], Some(&SI))
    };
    let si = || [si_side(entry.quantity), si_side(entry.denominator)];
    let factor = entry
        .to_si
        .filter(|_| entry.quantity.is_some())
        .unwrap_or(1.0);
    if in_si {
        return (si(), factor);
    }
    let fits = |sides: &[Characteristic; 2]| {
        sides.iter().all(|side| side.unit.len() <= UNIT_COLUMNS) && read(sides) == meant
    };
    if let Some(found) = candidates(entry).into_iter().find(fits) {
        return (found, 1.0);
    }
    let in_si_units = Ordinate {
        to_si: Some(1.0),
        ..meant
    };
    if entry.to_si.is_some() && read(&si()) == in_si_units {
        return (si(), factor);
    }
    lost.push("unit of a function");
    let unit = unit_text(&entry.unit_label, &mut Vec::new());
    (
        [side(entry.quantity, &unit), side(entry.denominator, "")],
        1.0,
    )
}

/// Ways to write the unit: parted at its last slash, in one piece, by the names of known units, and
/// as no unit.
fn candidates(entry: &Entry) -> Vec<[Characteristic; 2]> {
    let label = line_text(&entry.unit_label);
    let bare = |text: &str| text.trim_matches(['(', ')']).to_owned();
    let two =
        |above: &str, below: &str| [side(entry.quantity, above), side(entry.denominator, below)];
    let mut all = Vec::new();
    if let (Some((above, below)), Some(_)) = (label.rsplit_once('/'), entry.denominator) {
        all.push(two(&bare(above), &bare(below)));
    }
    all.push(two(&label, ""));
    all.extend(known_units(entry).map(|[above, below]| two(above, below)));
    all.push(two(UNKNOWN_UNIT, ""));
    all
}

/// Names of units with exactly the entry's factor.
fn known_units(entry: &Entry) -> Option<[&'static str; 2]> {
    let (quantity, to_si) = (entry.quantity?, entry.to_si?);
    match (entry.function_type, entry.denominator) {
        (FunctionType::Time, _) | (_, None) => Some([Unit { quantity, to_si }.name()?, ""]),
        (_, Some(below)) => Some([Unit { quantity, to_si }.name()?, below.si_unit()]),
    }
}

fn side(quantity: Option<Quantity>, unit: &str) -> Characteristic {
    Characteristic {
        code: quantity.map_or(0, code),
        unit: unit.to_owned(),
    }
}

fn si_side(quantity: Option<Quantity>) -> Characteristic {
    side(quantity, quantity.map_or("", Quantity::si_unit))
}

/// Specific data type of a quantity.
fn code(wanted: Quantity) -> i64 {
    [8, 11, 12, 13]
        .into_iter()
        .find(|code| quantity(*code) == Some(wanted))
        .unwrap_or(0)
}
