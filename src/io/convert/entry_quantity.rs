//! The quantity that the header of an FRF states.

use crate::dof::Dof;
use crate::io::{Domain, Entry};
use crate::quantity::{FrfKind, Quantity, names_other_quantity};

/// Whether the header of an FRF states a quantity other than motion over force, or another abscissa
/// than frequency. A unit label that cannot be read states nothing: the FRF may be needed.
pub(super) fn is_other_quantity(entry: &Entry) -> bool {
    let is_rotation = |dof: &Option<Dof>| dof.as_ref().is_some_and(|dof| dof.axis().is_rotation());
    let rotates = is_rotation(&entry.response) || is_rotation(&entry.reference);
    let is_read = entry.to_si.is_some() || entry.quantity.is_some() && entry.denominator.is_some();
    let is_ratio = frf_kind(entry).is_none() && is_read;
    let other_abscissa = matches!(entry.axis.domain(), Domain::Other(code) if code != 0);
    let is_motion_over_force = frf_kind(entry).is_some() && entry.to_si.is_some();
    let has_other = entry.has_other_quantity
        || !is_motion_over_force && names_other_quantity(&entry.unit_label);
    is_ratio || has_other || (rotates && entry.to_si.is_none()) || other_abscissa
}

/// The kind of FRF that a header states.
pub(super) fn frf_kind(entry: &Entry) -> Option<FrfKind> {
    let over_force = entry.denominator == Some(Quantity::Force);
    entry
        .quantity
        .filter(|_| over_force)
        .and_then(FrfKind::from_response)
}
