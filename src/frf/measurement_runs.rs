//! FRFs are grouped by measurement run: those measured together, with the roving sensor or hammer
//! at one position.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::dof::Dof;
use crate::frf::Function;

/// The resonance and the run, by one of its functions, that a finding on a shifted frequency is
/// about.
pub(crate) fn shifted_run(functions: &[Function], function: usize, resonance_rad_s: f64) -> String {
    let (runs, roving_sensor) = measurement_runs(functions);
    let function = &functions[function];
    let (kind, dof) = match roving_sensor {
        true => ("sensor", &function.response),
        false => ("excitation point", &function.reference),
    };
    let (hz, count) = (resonance_rad_s / TAU, runs.len());
    format!("resonance at {hz:.2} Hz; run of {kind} {dof}, of {count} runs")
}

/// Functions by run, and whether the sensor roves.
///
/// A run is the functions of one response DOF where the responses outnumber the references, as with
/// a roving sensor (so is a fixed array of sensors taken); else those of one reference, as with a
/// roving hammer.
pub(crate) fn measurement_runs(functions: &[Function]) -> (Vec<Vec<usize>>, bool) {
    let mut responses = BTreeMap::<Dof, Vec<usize>>::new();
    let mut references = BTreeMap::<Dof, Vec<usize>>::new();
    for (i, function) in functions.iter().enumerate() {
        let response = responses.entry(function.response.without_sign_and_repeat());
        response.or_default().push(i);
        let reference = references.entry(function.reference.without_sign_and_repeat());
        reference.or_default().push(i);
    }
    let roving_sensor = responses.len() > references.len();
    let groups = if roving_sensor { responses } else { references };
    (groups.into_values().collect(), roving_sensor)
}
