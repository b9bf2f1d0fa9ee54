//! Unit labels of quantities that neither FRFs nor modes need, such as sound pressure over force.
//!
//! A label outside this list and outside the units of force and motion cannot be read: its function
//! may be one that is needed.

/// Units of pressure, voltage, current, charge, rotation, strain, stress, temperature, power,
/// moment, mass, speed of rotation, and of ratios. Compared without case.
const OTHER_UNITS: [&str; 77] = [
    "Pa", "hPa", "kPa", "MPa", "GPa", "uPa", "µPa", "bar", "mbar", "psi", "N/m2", "N/m^2", "N/m²",
    "N/mm2", "N/mm^2", "N/mm²", "V", "mV", "uV", "µV", "kV", "Volt", "Volts", "A", "mA", "C", "pC",
    "rad", "mrad", "deg", "°", "rad/s", "mrad/s", "deg/s", "°/s", "rad/s2", "rad/s^2", "rad/s²",
    "deg/s2", "deg/s^2", "°/s²", "strain", "ustrain", "µstrain", "ue", "uE", "µε", "με", "m/m",
    "mm/m", "um/m", "µm/m", "K", "degC", "°C", "degF", "°F", "W", "mW", "J", "Nm", "N m", "N*m",
    "N.m", "N·m", "kNm", "kg", "gram", "rpm", "1/min", "Hz", "kHz", "s", "ms", "dB", "%", "Ohm",
];

/// Units of length.
const LENGTHS: [&str; 8] = ["m", "cm", "mm", "um", "µm", "in", "ft", "inch"];

/// Whether a unit label names another quantity than force and motion, as the whole, the numerator
/// or the denominator.
pub(in crate::io) fn names_other_quantity(label: &str) -> bool {
    let label = label.trim();
    if is_velocity(label) {
        return false;
    }
    let slashes = label.match_indices('/').map(|(place, _)| place);
    let mut sides = slashes.flat_map(|place| [&label[..place], &label[place + 1..]]);
    is_other(label) || sides.any(is_other)
}

/// Whether a label is a length over seconds, whose denominator alone is a unit of another quantity.
fn is_velocity(label: &str) -> bool {
    let label = label.trim_matches(['(', ')', '[', ']']).trim();
    let length = label.strip_suffix("/s").map(str::trim);
    length.is_some_and(|unit| LENGTHS.contains(&unit))
}

/// Whether a text is one of these units, brackets around it apart.
fn is_other(text: &str) -> bool {
    let text = text.trim().trim_matches(['(', ')', '[', ']']).trim();
    let mut units = OTHER_UNITS.iter();
    units.any(|unit| unit.eq_ignore_ascii_case(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{FrfUnit, Unit};

    #[test]
    fn other_quantities_are_named_as_whole_numerator_or_denominator() {
        for label in [
            "Pa",
            "Pa/N",
            "(Pa)/(N)",
            "V/N",
            "N/V",
            "[rad/s^2]/N",
            "(rad/s2)/Nm",
            "m/s2/V",
            "N/m^2",
            "µm/m",
        ] {
            assert!(names_other_quantity(label), "{label}");
        }
    }

    #[test]
    fn labels_of_motion_and_force_and_unreadable_ones_name_no_other_quantity() {
        for label in [
            "m/s",
            "(mm/s)",
            "in/s",
            "m/s2",
            "(m/s2)/N",
            "mm/N",
            "g/lbf",
            "m s-2",
            "m.s-2/N",
            "ms-2/N",
            "furlong/N",
            "EU",
            "EU/EU",
            "?",
            "",
        ] {
            assert!(!names_other_quantity(label), "{label}");
        }
        // None of these units is one of force or motion.
        for unit in OTHER_UNITS {
            assert!(unit.parse::<Unit>().is_err(), "{unit}");
            assert!(unit.parse::<FrfUnit>().is_err(), "{unit}");
        }
    }
}
