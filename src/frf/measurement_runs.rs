//! FRFs are grouped by measurement run: those measured together, with the roving sensor or hammer at
//! one position.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::frf::Function;

/// Functions by run, and whether the sensor roves.
///
/// A run is the functions of one response point where the responses outnumber the references (a
/// roving sensor), else those of one reference (a roving hammer).
pub(crate) fn measurement_runs(functions: &[Function]) -> (Vec<Vec<usize>>, bool) {
    let mut responses = BTreeMap::<Dof, Vec<usize>>::new();
    let mut references = BTreeMap::<Dof, Vec<usize>>::new();
    for (i, function) in functions.iter().enumerate() {
        let response = responses.entry(function.response.site());
        response.or_default().push(i);
        let reference = references.entry(function.reference.site());
        reference.or_default().push(i);
    }
    let roving_sensor = responses.len() > references.len();
    let groups = if roving_sensor { responses } else { references };
    (groups.into_values().collect(), roving_sensor)
}
