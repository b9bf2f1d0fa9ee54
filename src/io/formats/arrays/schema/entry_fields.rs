//! This table lists the stored properties of each function by name; writer and reader share it.

use super::arrays::whole;
use crate::dof::Dof;
use crate::frf::Estimator;
use crate::io::{Domain, Entry, EntryAxis, SampleFormat, Window};
use crate::quantity::{OtherQuantity, Quantity};
use crate::record::Role;

/// A text of each function; `set` is false for a text that is not one of its values.
pub(super) struct TextField {
    /// Array name within the group.
    pub name: &'static str,
    /// The text; empty where nothing is known.
    pub get: fn(&Entry) -> String,
    /// Takes a text that is not empty.
    pub set: fn(&mut Entry, &str) -> bool,
}

/// A number of each function.
pub(super) struct NumberField {
    /// Array name within the group.
    pub name: &'static str,
    /// The number; NaN where nothing is known.
    pub get: fn(&Entry) -> f64,
    /// Takes a number that is not NaN; false for one that cannot be.
    pub set: fn(&mut Entry, f64) -> bool,
    /// Whether the array is absent where no function has a number.
    pub is_optional: bool,
}

/// Texts in the order of writing.
pub(super) const TEXTS: &[TextField] = &[
    TextField {
        name: "response",
        get: |entry| dof_text(entry.response.as_ref()),
        set: |entry, text| put(&mut entry.response, text.parse::<Dof>().ok()),
    },
    TextField {
        name: "reference",
        get: |entry| dof_text(entry.reference.as_ref()),
        set: |entry, text| put(&mut entry.reference, text.parse::<Dof>().ok()),
    },
    TextField {
        name: "quantity",
        get: |entry| quantity_text(entry.quantity),
        set: |entry, text| put(&mut entry.quantity, quantity(text)),
    },
    TextField {
        name: "denominator",
        get: |entry| quantity_text(entry.denominator),
        set: |entry, text| put(&mut entry.denominator, quantity(text)),
    },
    TextField {
        name: "unit",
        get: |entry| entry.unit_label.clone(),
        set: |entry, text| {
            text.clone_into(&mut entry.unit_label);
            true
        },
    },
    TextField {
        name: "axis_unit",
        get: |entry| entry.axis_label.clone(),
        set: |entry, text| {
            text.clone_into(&mut entry.axis_label);
            true
        },
    },
    TextField {
        name: "role",
        get: |entry| entry.role.map_or("", role_name).to_owned(),
        set: |entry, text| {
            let roles = [Role::Force, Role::Response];
            put(
                &mut entry.role,
                roles.into_iter().find(|role| role_name(*role) == text),
            )
        },
    },
    TextField {
        name: "estimator",
        get: |entry| entry.note.estimator.map_or("", Estimator::name).to_owned(),
        set: |entry, text| put(&mut entry.note.estimator, Estimator::from_name(text)),
    },
    TextField {
        name: "window",
        get: |entry| entry.note.window.map_or("", Window::name).to_owned(),
        set: |entry, text| put(&mut entry.note.window, Window::from_name(text)),
    },
];

/// Numbers in the order of writing.
pub(super) const NUMBERS: &[NumberField] = &[
    NumberField {
        name: "to_si",
        is_optional: false,
        get: |entry| entry.to_si.unwrap_or(f64::NAN),
        set: |entry, value| {
            let usable = value.is_finite() && value != 0.0;
            put(&mut entry.to_si, usable.then_some(value))
        },
    },
    NumberField {
        name: "version",
        is_optional: false,
        get: |entry| entry.identification.version as f64,
        set: |entry, value| {
            whole(value).is_some_and(|version| {
                entry.identification.version = version;
                true
            })
        },
    },
    NumberField {
        name: "load_case",
        is_optional: false,
        get: |entry| entry.identification.load_case as f64,
        set: |entry, value| {
            whole(value).is_some_and(|load_case| {
                entry.identification.load_case = load_case;
                true
            })
        },
    },
    NumberField {
        name: "averages",
        is_optional: false,
        get: |entry| entry.note.averages.map_or(f64::NAN, f64::from),
        set: |entry, value| {
            let count = whole(value).and_then(|count| u32::try_from(count).ok());
            put(&mut entry.note.averages, count)
        },
    },
    NumberField {
        name: "added_damping_rad_s",
        is_optional: false,
        get: |entry| entry.note.added_damping_rad_s.unwrap_or(f64::NAN),
        set: |entry, value| put(&mut entry.note.added_damping_rad_s, Some(value)),
    },
    NumberField {
        name: "record_s",
        is_optional: false,
        get: |entry| entry.note.record_s.unwrap_or(f64::NAN),
        set: |entry, value| put(&mut entry.note.record_s, Some(value)),
    },
    NumberField {
        name: "interpolated",
        is_optional: true,
        get: |entry| {
            if entry.note.interpolated {
                1.0
            } else {
                f64::NAN
            }
        },
        set: |entry, value| {
            entry.note.interpolated = value > 0.0;
            entry.note.interpolated
        },
    },
    NumberField {
        name: "variance_degrees_of_freedom",
        is_optional: false,
        get: |entry| entry.note.variance_dof.unwrap_or(f64::NAN),
        set: |entry, value| put(&mut entry.note.variance_dof, Some(value)),
    },
];

fn put<T>(place: &mut Option<T>, value: Option<T>) -> bool {
    *place = value;
    place.is_some()
}

fn dof_text(dof: Option<&Dof>) -> String {
    dof.map_or_else(String::new, ToString::to_string)
}

fn quantity_text(quantity: Option<Quantity>) -> String {
    quantity.map_or_else(String::new, |quantity| quantity.to_string())
}

fn quantity(text: &str) -> Option<Quantity> {
    let all = [
        Quantity::Force,
        Quantity::Displacement,
        Quantity::Velocity,
        Quantity::Acceleration,
    ];
    let known = all
        .into_iter()
        .find(|quantity| quantity.to_string() == text);
    known.or_else(|| OtherQuantity::from_name(text).map(Quantity::Other))
}

fn role_name(role: Role) -> &'static str {
    match role {
        Role::Force => "force",
        Role::Response => "response",
    }
}

/// Sample formats and their names.
const FORMATS: [(SampleFormat, &str); 4] = [
    (SampleFormat::RealF32, "f32"),
    (SampleFormat::RealF64, "f64"),
    (SampleFormat::ComplexF32, "complex f32"),
    (SampleFormat::ComplexF64, "complex f64"),
];

/// The name of a sample format.
pub(super) fn format_name(format: SampleFormat) -> &'static str {
    let row = FORMATS.iter().find(|row| row.0 == format);
    row.map_or("f64", |row| row.1)
}

/// The sample format of a name.
pub(super) fn format_of(name: &str) -> Option<SampleFormat> {
    FORMATS.iter().find(|row| row.1 == name).map(|row| row.0)
}

/// The name of what an abscissa measures.
pub(super) fn domain_name(domain: Domain) -> String {
    match domain {
        Domain::Time => "time".to_owned(),
        Domain::Frequency => "frequency".to_owned(),
        Domain::Other(code) => format!("type-{code}"),
    }
}

/// The quantity of an abscissa of this name.
pub(super) fn domain_of(name: &str) -> Option<Domain> {
    match name {
        "time" => Some(Domain::Time),
        "frequency" => Some(Domain::Frequency),
        other => Some(Domain::Other(other.strip_prefix("type-")?.parse().ok()?)),
    }
}

/// `even` for a time or frequency axis, `general` for any other.
pub(super) fn axis_name(axis: &EntryAxis) -> &'static str {
    match axis {
        EntryAxis::Time(_) | EntryAxis::Frequency(_) => "even",
        EntryAxis::General(_) => "general",
    }
}
