//! A header of dataset 58 gives degrees of freedom, quantity, factor to SI and axis. No I/O.
//!
//! No unit has a default. The unit's text decides; where it is empty, dataset 164 does; a text that
//! is not a known unit of the stated quantity leaves the factor open. The note of modalign in ID
//! lines 4 and 5 (`modalign key=value ...`) adds to [`FunctionMetadata`]: `axis=START:STEP` to the
//! bit, and the numbers of repeated measurements.

use super::axis::{Abscissae, Axis, domain, even_axis, uneven_axis};
use super::dof_fields::DofFields;
use super::{Characteristic, Header};
use crate::dof::Dof;
use crate::io::catalog::function_metadata::{note_fields, number_pair};
use crate::io::formats::uff::dataset_164::Units;
use crate::io::formats::uff::fields::FieldError;
use crate::io::{Domain, Entry, FunctionMetadata, FunctionType, SampleFormat};
use crate::quantity::{FrfUnit, Quantity, Unit};

/// Key of start and step in our note.
pub(super) const AXIS: &str = "axis";
/// Key of the response's number of a repeated measurement in our note.
pub(super) const REPEAT: &str = "repeat";
/// As [`REPEAT`], of the reference.
pub(super) const REFERENCE_REPEAT: &str = "reference_repeat";

/// An entry and the sampling rate that was restored for it, when it was.
pub(in crate::io::formats::uff) struct Meaning {
    pub entry: Entry,
    pub restored_rate_hz: Option<f64>,
}

/// The entry of a header, without the factors of dataset 164; `text` when its samples are written
/// as text, `abscissae` those that stand before its values.
pub(in crate::io::formats::uff) fn meaning(
    header: &Header,
    text: bool,
    abscissae: Option<&Abscissae>,
) -> Result<Meaning, FieldError> {
    let lines = &header.identification.lines;
    let Axis {
        axis,
        restored_rate_hz,
    } = axis(header, abscissae)?;
    let format = match header.format {
        SampleFormat::RealF32 if text => SampleFormat::RealF64,
        SampleFormat::ComplexF32 if text => SampleFormat::ComplexF64,
        format => format,
    };
    let function_type = FunctionType::from_code(header.function_type);
    // Of a force the responses may name the excitation point, with its direction.
    let is_record = function_type == FunctionType::Time;
    let is_force = is_record && quantity(header.numerator.code) == Some(Quantity::Force);
    let scalar = |fields: &DofFields, may_be: bool| may_be.then(|| fields.scalar()).flatten();
    let response = (header.response.dof()).or_else(|| scalar(&header.response, !is_force));
    let reference = (header.reference.dof()).or_else(|| scalar(&header.reference, !is_record));
    let mut entry = Entry {
        identification: header.identification.clone(),
        response: repeated(response, lines, REPEAT),
        reference: repeated(reference, lines, REFERENCE_REPEAT),
        unit_label: unit_label(&header.numerator, &header.denominator),
        axis_label: axis_label(header),
        note: FunctionMetadata::from_lines(lines),
        line: header.at.line,
        byte: Some(header.at.byte),
        ..Entry::new(function_type, axis, format)
    };
    set_units(&mut entry, header, None);
    Ok(Meaning {
        entry,
        restored_rate_hz,
    })
}

/// The unit of the abscissa as it is read: seconds or hertz whatever the header had, else the unit
/// text of the header.
fn axis_label(header: &Header) -> String {
    match domain(header).0 {
        Domain::Time => "s".to_owned(),
        Domain::Frequency => "Hz".to_owned(),
        Domain::Other(_) => header.abscissa.unit.clone(),
    }
}

fn axis(header: &Header, abscissae: Option<&Abscissae>) -> Result<Axis, FieldError> {
    let (domain, scale) = domain(header);
    let Some(spacing) = &header.spacing else {
        let none = Abscissae::default();
        return Ok(Axis {
            axis: uneven_axis(domain, scale, abscissae.unwrap_or(&none)),
            restored_rate_hz: None,
        });
    };
    let note = note_fields(&header.identification.lines)
        .find(|(key, _)| *key == AXIS)
        .and_then(|(_, value)| number_pair(value));
    let len = usize::try_from(header.points).unwrap_or(usize::MAX);
    even_axis(domain, scale, len, spacing, note).ok_or_else(|| FieldError {
        at: header.spacing_at,
        what: "abscissa step of dataset 58",
        got: spacing.step.to_string(),
        expected: "a step that is not zero, for several values".to_owned(),
    })
}

/// The degree of freedom with the number of the repeated measurement in the note of modalign.
fn repeated(dof: Option<Dof>, lines: &[String], key: &str) -> Option<Dof> {
    let repeat = note_fields(lines)
        .find(|(name, _)| *name == key)
        .and_then(|(_, value)| value.parse().ok())
        .filter(|repeat| *repeat > 0);
    dof.map(|dof| repeat.map_or(dof.clone(), |repeat| dof.with_repeat(repeat)))
}

fn unit_label(numerator: &Characteristic, denominator: &Characteristic) -> String {
    let (numerator, denominator) = (&numerator.unit, &denominator.unit);
    if denominator.is_empty() {
        numerator.clone()
    } else if numerator.contains('/') && !numerator.starts_with('(') {
        format!("({numerator})/{denominator}")
    } else {
        format!("{numerator}/{denominator}")
    }
}

/// Sets quantity, denominator and factor to SI; `units` are those of dataset 164.
pub(in crate::io::formats::uff) fn set_units(
    entry: &mut Entry,
    header: &Header,
    units: Option<&Units>,
) {
    let sides = [&header.numerator, &header.denominator];
    let meant = ordinate(entry.function_type, sides, units);
    (entry.quantity, entry.denominator, entry.to_si) =
        (meant.quantity, meant.denominator, meant.to_si);
    entry.has_other_quantity = sides.iter().any(|side| is_other_quantity(side.code));
}

/// The quantity that numerator and denominator of an ordinate state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::io::formats::uff) struct Ordinate {
    pub quantity: Option<Quantity>,
    pub denominator: Option<Quantity>,
    pub to_si: Option<f64>,
}

/// Reads numerator and denominator of a function of a type; `units` are those of dataset 164.
pub(in crate::io::formats::uff) fn ordinate(
    function_type: FunctionType,
    [numerator, denominator]: [&Characteristic; 2],
    units: Option<&Units>,
) -> Ordinate {
    match function_type {
        FunctionType::Time => Side::new(numerator, units).alone(),
        FunctionType::Frf => ratio(numerator, denominator, units),
        // A ratio of powers whose unit is 1, whatever the labels say.
        FunctionType::Coherence => Ordinate {
            to_si: Some(1.0),
            ..Ordinate::default()
        },
        // A spectrum's unit is a square or a density, which dataset 164 does not tell.
        FunctionType::Variance | FunctionType::Other(_) => {
            let nothing = denominator.unit.is_empty() && quantity(denominator.code).is_none();
            if nothing {
                Side::new(numerator, None).alone()
            } else {
                ratio(numerator, denominator, None)
            }
        }
    }
}

fn ratio(above: &Characteristic, below: &Characteristic, units: Option<&Units>) -> Ordinate {
    let numerator = Side::new(above, units);
    let denominator = Side::new(below, units);
    if let Ok(whole) = above.unit.parse::<FrfUnit>() {
        let response = whole.kind.response_quantity();
        let agrees = numerator.quantity.is_none_or(|q| q == response)
            && denominator.quantity.is_none_or(|q| q == Quantity::Force);
        return Ordinate {
            quantity: numerator.quantity.or(Some(response)),
            denominator: denominator.quantity.or(Some(Quantity::Force)),
            to_si: agrees.then_some(whole.to_si),
        };
    }
    let factors = numerator.to_si.zip(denominator.to_si);
    Ordinate {
        quantity: numerator.quantity,
        denominator: denominator.quantity,
        to_si: factors.map(|(above, below)| above / below),
    }
}

/// Quantity and factor of a numerator or a denominator.
struct Side {
    quantity: Option<Quantity>,
    to_si: Option<f64>,
}

impl Side {
    /// As the whole ordinate.
    fn alone(self) -> Ordinate {
        Ordinate {
            quantity: self.quantity,
            denominator: None,
            to_si: self.to_si,
        }
    }

    fn new(field: &Characteristic, units: Option<&Units>) -> Self {
        let unit: Option<Unit> = field.unit.trim_matches(['(', ')', '[', ']']).parse().ok();
        match (quantity(field.code), unit) {
            (Some(quantity), Some(unit)) => Self {
                quantity: Some(quantity),
                to_si: (unit.quantity == quantity).then_some(unit.to_si),
            },
            (Some(quantity), None) => Self {
                quantity: Some(quantity),
                to_si: units
                    .filter(|_| field.unit.is_empty())
                    .and_then(|units| units.to_si(quantity)),
            },
            // 0 and 1 are unknown and general.
            (None, Some(unit)) if matches!(field.code, 0 | 1) => Self {
                quantity: Some(unit.quantity),
                to_si: Some(unit.to_si),
            },
            _ => Self {
                quantity: None,
                to_si: None,
            },
        }
    }
}

/// Quantity of a specific data type.
pub(in crate::io::formats::uff) fn quantity(code: i64) -> Option<Quantity> {
    match code {
        8 => Some(Quantity::Displacement),
        9 | 13 => Some(Quantity::Force),
        11 => Some(Quantity::Velocity),
        12 => Some(Quantity::Acceleration),
        _ => None,
    }
}

/// Whether a specific data type is a quantity other than force and motion: stress, strain,
/// temperature, heat flux, pressure, mass, speed of rotation.
fn is_other_quantity(code: i64) -> bool {
    matches!(code, 2 | 3 | 5 | 6 | 15 | 16 | 19)
}

#[cfg(test)]
mod tests {
    use crate::io::formats::uff::tests::file_builder::{dataset, header, open, text_58};
    use crate::io::{Domain, Entry, EntryAxis, GeneralAxis};

    /// The entry of a header with function type, abscissa code and abscissa unit, in a file with
    /// units in millimetres.
    fn entry(function_type: i32, code: i32, unit: &str) -> Option<Entry> {
        let mut head = header(2, 1);
        head[5].replace_range(..5, &format!("{function_type:>5}"));
        head[6] = "         2         1         1  2.00000E+00  4.00000E+00".to_owned();
        head[7] = format!("{code:>10}    0    0    0 Label                {unit:<20}");
        head[8] = "        12    0    0    0 Acceleration         NONE".to_owned();
        let mut file = text_58(&head, &["1.0"], "\n");
        let units = ["   164", "         5", "1.0D+03 1.0D+03 1.0D+00", "0.0"];
        file.extend(dataset(&units, "\n"));
        open(file)
            .expect("the dataset of this test can be read")
            .catalog()
            .entries
            .first()
            .cloned()
    }

    #[test]
    fn the_abscissa_is_in_seconds_or_hertz() {
        for (function_type, code, unit, start, step) in [
            (1, 17, "s", 2.0, 4.0),
            (1, 17, "ms", 2e-3, 4e-3),
            (1, 0, "NONE", 2.0, 4.0),
            (0, 1, "s", 2.0, 4.0),
            (7, 0, "", 2.0, 4.0),
        ] {
            let Some(EntryAxis::Time(axis)) = entry(function_type, code, unit).map(|e| e.axis)
            else {
                panic!("{function_type} {code} {unit}: expected time")
            };
            assert!((axis.start_s - start).abs() < 1e-15 && (axis.step_s - step).abs() < 1e-15);
        }
        for (function_type, code, unit, start) in [
            (4, 18, "Hz", 2.0),
            (4, 18, "kHz", 2e3),
            (4, 18, "rad/s", std::f64::consts::FRAC_1_PI),
            (4, 18, "rpm", 1.0 / 30.0),
            (6, 0, "NONE", 2.0),
            (0, 1, "Hz", 2.0),
            (9, 0, "", 2.0),
        ] {
            let Some(EntryAxis::Frequency(axis)) = entry(function_type, code, unit).map(|e| e.axis)
            else {
                panic!("{function_type} {code} {unit}: expected frequency")
            };
            assert!((axis.start_hz - start).abs() < 1e-12, "{unit}");
            assert!((axis.step_hz - 2.0 * start).abs() < 1e-12, "{unit}");
        }
        for (function_type, code, unit) in [(0, 0, "NONE"), (1, 16, "s"), (4, 19, "rpm")] {
            let general = GeneralAxis {
                domain: Domain::Other(code),
                even: Some((2.0, 4.0)),
                len: 1,
            };
            let got =
                entry(function_type, code, unit).expect("the dataset of this test can be read");
            assert_eq!(got.axis, EntryAxis::General(general), "{code}");
        }
    }

    #[test]
    fn each_function_has_the_units_dataset_before_it() {
        let mut head = header(2, 1);
        head[8] = "        12    0    0    0 Acceleration         NONE".to_owned();
        let function = text_58(&head, &["1.0"], "\n");
        let units = |length: &str| dataset(&["   164", "         9", length], "\n");
        let (millimetre, micrometre) = (units("1.0D+03 1.0 1.0"), units("1.0D+06 1.0 1.0"));
        let parts = [
            &function[..],
            &millimetre,
            &function,
            &micrometre,
            &function,
        ];
        let source = open(parts.concat()).expect("the dataset of this test can be read");
        let to_si: Vec<Option<f64>> = source.catalog().entries.iter().map(|e| e.to_si).collect();
        assert_eq!(to_si, [Some(1e-3), Some(1e-3), Some(1e-6)]);
    }

    #[test]
    fn the_units_of_the_file_are_not_those_of_a_spectrum() {
        assert_eq!(
            entry(1, 17, "s")
                .expect("the dataset of this test can be read")
                .to_si,
            Some(1e-3)
        );
        assert_eq!(
            entry(2, 18, "Hz")
                .expect("the dataset of this test can be read")
                .to_si,
            None
        );
        assert_eq!(
            entry(6, 18, "Hz")
                .expect("the dataset of this test can be read")
                .to_si,
            Some(1.0)
        );
        assert_eq!(
            entry(4, 18, "Hz")
                .expect("the dataset of this test can be read")
                .to_si,
            None,
            "no denominator"
        );
    }
}
