//! What a header of dataset 58 means: degrees of freedom, quantity, factor to SI and axis. No I/O.
//!
//! No unit has a default. The unit's text decides; where it is empty, dataset 164 does; a text that is not a known unit of
//! the stated quantity leaves the factor open. A time step printed with few digits is put right where one whole number of
//! samples per second, and only one, lies within its rounding.

use super::dataset_58::{Characteristic, Header};
use super::dataset_164::Units;
use super::fields::FieldError;
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::io::{Entry, EntryAxis, FunctionType, SampleFormat};
use crate::quantity::{FrfUnit, Quantity, Unit};

/// Relative change of the step from which on a restored sampling rate is worth a finding.
const WORTH_TELLING: f64 = 1e-9;

/// An entry and the sampling rate that was restored for it, when it was.
pub(super) struct Meaning {
    pub entry: Entry,
    pub restored_rate_hz: Option<f64>,
}

/// The entry of a header, without the factors of dataset 164; `text` when its samples are written as text.
pub(super) fn meaning(header: &Header, text: bool) -> Result<Meaning, FieldError> {
    let (axis, restored_rate_hz) = axis(header)?;
    let format = match header.format {
        SampleFormat::RealF32 if text => SampleFormat::RealF64,
        SampleFormat::ComplexF32 if text => SampleFormat::ComplexF64,
        format => format,
    };
    let mut entry = Entry {
        function_type: FunctionType::from_code(header.function_type),
        identification: header.identification.clone(),
        response: header.response.dof(),
        reference: header.reference.dof(),
        quantity: None,
        denominator: None,
        to_si: None,
        unit_label: unit_label(header),
        role: None,
        axis,
        format,
        line: header.at.line,
        byte: Some(header.at.byte),
    };
    set_units(&mut entry, header, None);
    Ok(Meaning {
        entry,
        restored_rate_hz,
    })
}

fn unit_label(header: &Header) -> String {
    let (numerator, denominator) = (&header.numerator.unit, &header.denominator.unit);
    if denominator.is_empty() {
        numerator.clone()
    } else if numerator.contains('/') && !numerator.starts_with('(') {
        format!("({numerator})/{denominator}")
    } else {
        format!("{numerator}/{denominator}")
    }
}

/// Sets quantity, denominator and factor to SI; `units` are those of dataset 164.
pub(super) fn set_units(entry: &mut Entry, header: &Header, units: Option<&Units>) {
    match entry.function_type {
        FunctionType::Time => {
            let ordinate = Side::new(&header.numerator, units);
            (entry.quantity, entry.to_si) = (ordinate.quantity, ordinate.to_si);
        }
        FunctionType::Frf => set_frf_units(entry, header, units),
        // A ratio of powers whose unit is 1, whatever the labels say.
        FunctionType::Coherence => entry.to_si = Some(1.0),
        // A spectrum's unit is a square or a density, which dataset 164 does not tell.
        FunctionType::Other(_) => {
            let ordinate = Side::new(&header.numerator, None);
            (entry.quantity, entry.to_si) = (ordinate.quantity, ordinate.to_si);
        }
    }
}

fn set_frf_units(entry: &mut Entry, header: &Header, units: Option<&Units>) {
    let numerator = Side::new(&header.numerator, units);
    let denominator = Side::new(&header.denominator, units);
    if let Ok(whole) = header.numerator.unit.parse::<FrfUnit>() {
        let response = whole.kind.response_quantity();
        let agrees = numerator.quantity.is_none_or(|q| q == response)
            && denominator.quantity.is_none_or(|q| q == Quantity::Force);
        entry.quantity = numerator.quantity.or(Some(response));
        entry.denominator = denominator.quantity.or(Some(Quantity::Force));
        entry.to_si = agrees.then_some(whole.to_si);
        return;
    }
    (entry.quantity, entry.denominator) = (numerator.quantity, denominator.quantity);
    entry.to_si = numerator
        .to_si
        .zip(denominator.to_si)
        .map(|(above, below)| above / below);
}

/// Quantity and factor of a numerator or a denominator.
struct Side {
    quantity: Option<Quantity>,
    to_si: Option<f64>,
}

impl Side {
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
                    .map(|units| units.to_si(quantity)),
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
fn quantity(code: i64) -> Option<Quantity> {
    match code {
        8 => Some(Quantity::Displacement),
        9 | 13 => Some(Quantity::Force),
        11 => Some(Quantity::Velocity),
        12 => Some(Quantity::Acceleration),
        _ => None,
    }
}

fn axis(header: &Header) -> Result<(EntryAxis, Option<f64>), FieldError> {
    let (time, scale) = abscissa(header)?;
    let (start, mut step) = (header.start * scale, header.step * scale);
    let len = usize::try_from(header.points).unwrap_or(usize::MAX);
    if !(step > 0.0 && step.is_finite() && start.is_finite()) {
        return Err(FieldError {
            at: header.spacing_at,
            what: "abscissa step of dataset 58",
            got: header.step.to_string(),
            expected: "a positive step".to_owned(),
        });
    }
    if !time {
        let axis = FrequencyAxis {
            start_hz: start,
            step_hz: step,
            len,
        };
        return Ok((EntryAxis::Frequency(axis), None));
    }
    let half_unit = header.step_half_unit.map(|half| half * scale);
    let rate = half_unit.and_then(|half| whole_rate(step, half));
    let told = rate.filter(|rate| (step * rate - 1.0).abs() > WORTH_TELLING);
    if let Some(rate) = rate {
        step = 1.0 / rate;
    }
    let axis = TimeAxis {
        start_s: start,
        step_s: step,
        len,
    };
    Ok((EntryAxis::Time(axis), told))
}

/// Whether the abscissa is time (else frequency), and its factor to seconds or hertz.
fn abscissa(header: &Header) -> Result<(bool, f64), FieldError> {
    let unit = header.abscissa.unit.as_str();
    let time = match (header.abscissa.code, header.function_type) {
        (17, _) => true,
        (18, _) => false,
        // The unit decides, then the function type: spectra, FRFs and coherences are 2 to 9.
        (0 | 1, _) if unit == "s" => true,
        (0 | 1, _) if unit == "Hz" => false,
        (0 | 1, 1) => true,
        (0 | 1, 2..=9) => false,
        (code, _) => {
            return Err(FieldError {
                at: header.abscissa_at,
                what: "abscissa type of dataset 58",
                got: code.to_string(),
                expected: "17 (time) or 18 (frequency)".to_owned(),
            });
        }
    };
    let scale = match (time, unit) {
        (true, "ms") => 1e-3,
        (true, "us" | "µs") => 1e-6,
        (false, "kHz") => 1e3,
        (false, "rad/s") => 1.0 / std::f64::consts::TAU,
        (false, "rpm" | "RPM") => 1.0 / 60.0,
        // The format's own units are seconds and hertz.
        _ => 1.0,
    };
    Ok((time, scale))
}

/// The whole number of samples per second whose step prints as `step`, when there is one and no other.
fn whole_rate(step: f64, half_unit: f64) -> Option<f64> {
    // A step that ends in 5 lies on the edge itself (1.953125E-05 prints as 1.95313E-05), where rounding must not lose it.
    let half = half_unit * (1.0 + 1e-6);
    if half >= step {
        return None;
    }
    let first = (1.0 / (step + half)).ceil();
    let last = (1.0 / (step - half)).floor();
    // Both are whole numbers, and so is their difference.
    ((last - first).abs() < 0.5 && first >= 1.0).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::super::fields::half_unit;
    use super::super::file_builder::{dataset, header, open, text_58};
    use super::whole_rate;
    use crate::io::{Entry, EntryAxis};

    /// The entry of a header with function type, abscissa code and abscissa unit, in a file with units in millimetres.
    fn entry(function_type: i32, code: i32, unit: &str) -> Option<Entry> {
        let mut head = header(2, 1);
        head[5].replace_range(..5, &format!("{function_type:>5}"));
        head[6] = "         2         1         1  2.00000E+00  4.00000E+00".to_owned();
        head[7] = format!("{code:>10}    0    0    0 Label                {unit:<20}");
        head[8] = "        12    0    0    0 Acceleration         NONE".to_owned();
        let mut file = text_58(&head, &["1.0"], "\n");
        let units = ["   164", "         5", "1.0D+03 1.0D+03 1.0D+00", "0.0"];
        file.extend(dataset(&units, "\n"));
        open(file).unwrap().catalog().entries.first().cloned()
    }

    #[test]
    fn the_abscissa_is_in_seconds_or_hertz() {
        for (function_type, code, unit, start, step) in [
            (1, 17, "s", 2.0, 4.0),
            (1, 17, "ms", 2e-3, 4e-3),
            (1, 0, "NONE", 2.0, 4.0),
            (0, 1, "s", 2.0, 4.0),
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
        ] {
            let Some(EntryAxis::Frequency(axis)) = entry(function_type, code, unit).map(|e| e.axis)
            else {
                panic!("{function_type} {code} {unit}: expected frequency")
            };
            assert!((axis.start_hz - start).abs() < 1e-12, "{unit}");
            assert!((axis.step_hz - 2.0 * start).abs() < 1e-12, "{unit}");
        }
        for (function_type, code, unit) in [(0, 0, "NONE"), (1, 16, "s"), (4, 19, "rpm")] {
            assert_eq!(entry(function_type, code, unit), None, "{code}");
        }
    }

    #[test]
    fn each_function_has_the_units_that_stand_before_it() {
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
        let source = open(parts.concat()).unwrap();
        let to_si: Vec<Option<f64>> = source.catalog().entries.iter().map(|e| e.to_si).collect();
        assert_eq!(to_si, [Some(1e-3), Some(1e-3), Some(1e-6)]);
    }

    #[test]
    fn the_units_of_the_file_are_not_those_of_a_spectrum() {
        assert_eq!(entry(1, 17, "s").unwrap().to_si, Some(1e-3));
        assert_eq!(entry(2, 18, "Hz").unwrap().to_si, None);
        assert_eq!(entry(6, 18, "Hz").unwrap().to_si, Some(1.0));
        assert_eq!(entry(4, 18, "Hz").unwrap().to_si, None, "no denominator");
    }

    fn rate(printed: &str) -> Option<f64> {
        let half = half_unit(printed.as_bytes()).unwrap();
        whole_rate(printed.parse().unwrap(), half)
    }

    #[test]
    fn every_common_rate_comes_back_from_six_digits() {
        // Up to 90 kHz six digits always tell one rate from the next; above, the common ones are told.
        for hz in (1..=90_000).chain([96_000, 102_400, 131_072, 192_000, 204_800, 262_144]) {
            let hz = f64::from(hz);
            let printed = format!("{:.5E}", 1.0 / hz);
            assert_eq!(
                rate(&printed).map(f64::to_bits),
                Some(hz.to_bits()),
                "{printed}"
            );
        }
    }

    #[test]
    fn a_rate_is_not_invented() {
        // 1/3 s is 3 Hz; 0.3 s is none; with two digits or fewer many rates fit, or none does.
        assert_eq!(rate("3.33333E-01").map(f64::to_bits), Some(3f64.to_bits()));
        for printed in ["3.00000E-01", "1.0E-05", "0.01", "0.0", "4.88210E-04"] {
            assert_eq!(rate(printed), None, "{printed}");
        }
    }
}
