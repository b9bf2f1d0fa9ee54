//! The columns of a table of modes are named by quantity or degree of freedom.

use crate::dof::Dof;

/// The first two headings of a table with shapes.
pub(super) const FIRST: [&str; 2] = ["frequency_hz", "damping_ratio"];

/// Further headings of the natural frequencies, in lower case.
const FREQUENCY_HEADINGS: [&str; 6] = [
    "frequency_hz",
    "frequency [hz]",
    "frequency (hz)",
    "f_hz",
    "f [hz]",
    "f (hz)",
];

/// Headings of a column that numbers or names the modes, in lower case and without a full stop at
/// the end; nothing is read from it.
const NUMBER_HEADINGS: [&str; 9] = [
    "mode",
    "modes",
    "mode no",
    "mode nr",
    "mode number",
    "no",
    "nr",
    "number",
    "#",
];

/// The column of a heading other than a degree of freedom.
pub(super) fn named_column(heading: &str) -> Option<Column> {
    let lower = heading.to_lowercase();
    if FREQUENCY_HEADINGS.contains(&lower.as_str()) {
        return Some(Column::Frequency);
    }
    if NUMBER_HEADINGS.contains(&lower.trim_end_matches('.').trim_end()) {
        return Some(Column::Number);
    }
    let mut named = NAMED.iter();
    let column = named.find(|(name, _)| heading.eq_ignore_ascii_case(name));
    column.map(|(_, column)| column.clone())
}

/// The meaning of a column.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Column {
    Frequency,
    Damping,
    FrequencyStd,
    DampingStd,
    Group,
    ModalMass,
    Scaling,
    /// A number or name of the mode, which is not read.
    Number,
    Shape(Dof, Part),
}

/// Which part of a shape's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Part {
    Whole,
    Real,
    Imaginary,
}

/// Columns that every mode has one value of.
pub(super) const NAMED: [(&str, Column); 7] = [
    ("frequency_hz", Column::Frequency),
    ("damping_ratio", Column::Damping),
    ("frequency_std_hz", Column::FrequencyStd),
    ("damping_std", Column::DampingStd),
    ("group", Column::Group),
    ("modal_mass_kg", Column::ModalMass),
    ("scaling", Column::Scaling),
];
