//! The columns of a table of modes are named by quantity or degree of freedom.

use crate::dof::Dof;

/// The first two headings, by which the format is known.
pub(super) const FIRST: [&str; 2] = ["frequency_hz", "damping_ratio"];

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
