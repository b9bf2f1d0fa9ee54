//! Headings of modalign's tables state everything about each column; they are written and read
//! here.
//!
//! | heading | column |
//! |---|---|
//! | `time [s]`, `frequency [Hz]`, `abscissa-19 [rpm]` | abscissa, the first column; `uneven` before it where it is |
//! | `force 1:+Z [N]`, `response 2:+Z [m/s2]`, `record 3:+X` | time record of the hammer, of a sensor, of an unspecified quantity |
//! | `re 2:+Z\|1:+Z [(m/s2)/N]`, `im ...` | parts of a complex FRF, response before reference, `?` where not stated |
//! | `coherence 2:+Z\|1:+Z`, `auto-spectrum 2:+Z` | any other function by its name; complex ones with `re` and `im` too |
//!
//! `hit 3` behind the points is the version of the record. The unit is a known one, `FACTOR x` one
//! in SI, `1` for a plain number, or any text, which then stays a text.

use crate::dof::Dof;
use crate::io::{Domain, Entry, EntryAxis, FunctionType};
use crate::quantity::{FrfKind, FrfUnit, Quantity, Unit};
use crate::record::Role;

/// Which part of its values a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All of a real value.
    Whole,
    /// Real part.
    Real,
    /// Imaginary part.
    Imaginary,
}

/// The meaning of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// The abscissa.
    Abscissa(Abscissa),
    /// Values of an entry.
    Values(Part, Box<HeadingMeaning>),
}

/// The abscissa as a heading states it.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::io::formats) struct Abscissa {
    /// The measured quantity.
    pub domain: Domain,
    /// Whether its values are to be kept as they are.
    pub uneven: bool,
    /// Its unit.
    pub label: String,
}

/// An entry as a heading states it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeadingMeaning {
    /// The type of the function.
    pub function_type: FunctionType,
    /// Role of a time record.
    pub role: Option<Role>,
    /// Response.
    pub response: Option<Dof>,
    /// Reference.
    pub reference: Option<Dof>,
    /// Version of the record.
    pub hit: i64,
    /// Unit.
    pub unit: StatedUnit,
}

/// Unit of an entry.
#[derive(Clone, Debug, PartialEq, Default)]
pub(in crate::io::formats) struct StatedUnit {
    /// Quantity.
    pub quantity: Option<Quantity>,
    /// Quantity of the denominator.
    pub denominator: Option<Quantity>,
    /// Factor to SI.
    pub to_si: Option<f64>,
    /// The text.
    pub label: String,
}

/// The meaning of all columns, when every heading states it.
pub(super) fn meanings(headings: &[String]) -> Option<Vec<Meaning>> {
    let (first, others) = headings.split_first()?;
    let mut found = vec![Meaning::Abscissa(abscissa(first)?)];
    for heading in others {
        let (part, described) = described(heading)?;
        let before = match found.last() {
            Some(Meaning::Values(Part::Real, before)) => Some(before.as_ref()),
            _ => None,
        };
        // An imaginary part stands behind its real part, and a real part before its imaginary part.
        let fits = match part {
            Part::Imaginary => before == Some(&described),
            Part::Real | Part::Whole => before.is_none(),
        };
        if !fits {
            return None;
        }
        found.push(Meaning::Values(part, Box::new(described)));
    }
    let whole = matches!(
        found.last(),
        Some(Meaning::Values(Part::Whole | Part::Imaginary, _))
    );
    whole.then_some(found)
}

/// Text before the unit, and the unit.
fn split_unit(heading: &str) -> (&str, Option<&str>) {
    let inner = heading.strip_suffix(']');
    match inner.and_then(|inner| inner.rsplit_once(" [")) {
        Some((before, unit)) => (before, Some(unit)),
        None => (heading, None),
    }
}

fn abscissa(heading: &str) -> Option<Abscissa> {
    let (words, unit) = split_unit(heading);
    let (uneven, word) = match words.strip_prefix("uneven ") {
        Some(word) => (true, word),
        None => (false, words),
    };
    let domain = match (word, unit) {
        ("time", Some("s")) => Domain::Time,
        ("frequency", Some("Hz")) => Domain::Frequency,
        _ => Domain::Other(word.strip_prefix("abscissa-")?.parse().ok()?),
    };
    Some(Abscissa {
        domain,
        uneven,
        label: unit.unwrap_or_default().to_owned(),
    })
}

fn described(heading: &str) -> Option<(Part, HeadingMeaning)> {
    let (words, unit) = split_unit(heading);
    let mut words: Vec<&str> = words.split(' ').collect();
    let part = match words.first() {
        Some(&"re") => Part::Real,
        Some(&"im") => Part::Imaginary,
        _ => Part::Whole,
    };
    if part != Part::Whole {
        words.remove(0);
    }
    let hit = match words.as_slice() {
        [.., "hit", number] => number.parse().ok()?,
        _ => 0,
    };
    if hit != 0 {
        words.truncate(words.len() - 2);
    }
    let (word, points) = match words.as_slice() {
        [points] if part != Part::Whole => ("frf", *points),
        [word, points] => (*word, *points),
        _ => return None,
    };
    let (function_type, role) = match word {
        "force" => (FunctionType::Time, Some(Role::Force)),
        "response" => (FunctionType::Time, Some(Role::Response)),
        "record" => (FunctionType::Time, None),
        name => (FunctionType::from_name(name)?, None),
    };
    let (response, reference) = match points.split_once('|') {
        Some((response, reference)) => (response, Some(reference.parse().ok()?)),
        None => (points, None),
    };
    let response = match response {
        "?" => None,
        text => Some(text.parse().ok()?),
    };
    let described = HeadingMeaning {
        function_type,
        role,
        response,
        reference,
        hit,
        unit: stated(unit, function_type),
    };
    Some((part, described))
}

/// The unit that a text states; a coherence has none.
fn stated(text: Option<&str>, function_type: FunctionType) -> StatedUnit {
    match text {
        Some(text) => unit_of(text, function_type),
        None => StatedUnit {
            to_si: (function_type == FunctionType::Coherence).then_some(1.0),
            ..StatedUnit::default()
        },
    }
}

/// Unit of a text; where it is not known the text is all there is.
pub(in crate::io::formats) fn unit_of(text: &str, function_type: FunctionType) -> StatedUnit {
    let known = |rest: &str| {
        let rest = match function_type {
            FunctionType::Variance => rest.strip_prefix('(')?.strip_suffix(")2")?,
            _ => rest,
        };
        ratio_of(rest)
    };
    let factor = text.split_once(" x ").and_then(|(factor, rest)| {
        let factor: f64 = factor
            .parse()
            .ok()
            .filter(|factor: &f64| factor.is_finite())?;
        Some((factor, known(rest)?))
    });
    let found = factor.or_else(|| Some((1.0, known(text)?)));
    let mut unit = StatedUnit {
        label: text.to_owned(),
        ..StatedUnit::default()
    };
    if let Some((factor, (quantity, denominator, to_si))) = found {
        (unit.quantity, unit.denominator) = (quantity, denominator);
        unit.to_si = Some(if function_type == FunctionType::Variance {
            factor * to_si * to_si
        } else {
            factor * to_si
        });
    }
    unit
}

type Ratio = (Option<Quantity>, Option<Quantity>, f64);

fn ratio_of(text: &str) -> Option<Ratio> {
    if text == "1" {
        return Some((None, None, 1.0));
    }
    if let Ok(unit) = text.parse::<Unit>() {
        return Some((Some(unit.quantity), None, unit.to_si));
    }
    if let Ok(unit) = text.parse::<FrfUnit>() {
        let quantity = unit.kind.response_quantity();
        return Some((Some(quantity), Some(Quantity::Force), unit.to_si));
    }
    let inner = text.strip_prefix('(')?.strip_suffix(')')?;
    let (above, below) = inner.split_once(")/(")?;
    let (above, below): (Unit, Unit) = (above.parse().ok()?, below.parse().ok()?);
    Some((
        Some(above.quantity),
        Some(below.quantity),
        above.to_si / below.to_si,
    ))
}

/// The unit text that comes back as the entry's unit: empty where there is nothing to say, `None`
/// where it cannot be said.
pub(super) fn unit_text(entry: &Entry) -> Option<String> {
    let reads_back = |text: &str| {
        let unit = unit_of(text, entry.function_type);
        unit.to_si.map(f64::to_bits) == entry.to_si.map(f64::to_bits)
            && (unit.quantity, unit.denominator) == (entry.quantity, entry.denominator)
    };
    let label = entry.unit_label.as_str();
    let plain = |c: char| !c.is_control() && !",;\"[]".contains(c);
    let sayable = !label.trim().is_empty() && label.trim() == label && label.chars().all(plain);
    if sayable && reads_back(label) {
        return Some(label.to_owned());
    }
    let nothing = entry.quantity.is_none() && entry.denominator.is_none();
    let Some(factor) = entry.to_si else {
        return (nothing && label.trim().is_empty()).then(String::new);
    };
    if entry.function_type == FunctionType::Coherence
        && nothing
        && factor.to_bits() == 1f64.to_bits()
    {
        return Some(String::new());
    }
    let base = match (entry.quantity, entry.denominator) {
        (None, None) => "1".to_owned(),
        (Some(quantity), None) => quantity.si_unit().to_owned(),
        (Some(quantity), Some(denominator)) => si_ratio(quantity, denominator),
        (None, Some(_)) => return None,
    };
    let base = match entry.function_type {
        FunctionType::Variance => format!("({base})2"),
        _ => base,
    };
    let texts = [base.clone(), format!("{factor:?} x {base}")];
    texts.into_iter().find(|text| reads_back(text))
}

fn si_ratio(quantity: Quantity, denominator: Quantity) -> String {
    match FrfKind::from_response(quantity) {
        Some(kind) if denominator == Quantity::Force => kind.si_unit().to_owned(),
        _ => format!("({})/({})", quantity.si_unit(), denominator.si_unit()),
    }
}

/// Heading of the abscissa that entries share.
pub(super) fn abscissa_heading(entry: &Entry) -> String {
    let uneven = match entry.axis.even() {
        Some(_) => "",
        None => "uneven ",
    };
    let plain = |c: &char| !c.is_control() && !",;\"[]".contains(*c);
    match entry.axis.domain() {
        Domain::Time => format!("{uneven}time [s]"),
        Domain::Frequency => format!("{uneven}frequency [Hz]"),
        Domain::Other(code) => {
            let label: String = entry.axis_label.trim().chars().filter(plain).collect();
            let unit = if label.is_empty() {
                String::new()
            } else {
                format!(" [{label}]")
            };
            format!("{uneven}abscissa-{code}{unit}")
        }
    }
}

/// Heading of an entry's values, without the word for the part; `unit` is empty where there is
/// none.
pub(super) fn entry_heading(entry: &Entry, complex: bool, unit: &str) -> String {
    let name = match (entry.function_type, entry.role) {
        (FunctionType::Time, Some(Role::Force)) => "force ".to_owned(),
        (FunctionType::Time, Some(Role::Response)) => "response ".to_owned(),
        (FunctionType::Time, None) => "record ".to_owned(),
        (FunctionType::Frf, _) if complex => String::new(),
        (other, _) => format!("{} ", other.name()),
    };
    let response = entry.response.as_ref();
    let mut text = name + &response.map_or_else(|| "?".to_owned(), ToString::to_string);
    if let Some(reference) = &entry.reference {
        text += &format!("|{reference}");
    }
    if entry.identification.version != 0 {
        text += &format!(" hit {}", entry.identification.version);
    }
    if !unit.is_empty() {
        text += &format!(" [{unit}]");
    }
    text
}

/// Whether two entries have one abscissa as far as their headers say.
pub(super) fn same_axis(a: &EntryAxis, b: &EntryAxis) -> bool {
    let bits = |axis: &EntryAxis| {
        axis.even()
            .map(|(start, step)| (start.to_bits(), step.to_bits()))
    };
    let len = |axis: &EntryAxis| match axis {
        EntryAxis::Time(axis) => axis.len,
        EntryAxis::Frequency(axis) => axis.len,
        EntryAxis::General(axis) => axis.len,
    };
    (a.domain(), bits(a), len(a)) == (b.domain(), bits(b), len(b))
}
