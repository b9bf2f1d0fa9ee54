//! FRFs as programs export them become one set of one-sided, causal functions.
//!
//! | file | what programs write |
//! |---|---|
//! | `one_sided` | both halves of the transform, the upper one the mirror image of the lower |
//! | `causality` | conjugate values, of the convention e^{-iωt} |
//! | `even_lines` | lines of a stepped sine, unevenly spaced |
//! | here | functions of several frequency axes or exponential windows in one test |
//!
//! It changes no value of a set that has none of these.

mod causality;
pub(crate) mod even_lines;
mod one_sided;

use super::{FrfSet, Function};
use crate::axis::FrequencyAxis;
use crate::finding::{Code, Finding, Location, Severity};

/// The set with the most functions, one-sided and causal, with findings on what was changed and on
/// the functions of the other sets, which were left out; nothing where there is no set.
///
/// Of sets with equally many functions it is the one with more lines.
pub(crate) fn usable_set(sets: Vec<FrfSet>) -> Option<FrfSet> {
    let sets = sets.into_iter().map(one_sided::one_sided);
    let size = |set: &FrfSet| (set.len(), set.axis().len);
    let mut sets: Vec<FrfSet> = sets.collect();
    // The first of equal ones.
    sets.reverse();
    let largest = (0..sets.len()).max_by_key(|i| size(&sets[*i]))?;
    let mut used = causality::causal(sets.remove(largest));
    for other in sets.iter().rev() {
        let axis = described(other.axis());
        let left_out = |function: &Function| {
            let location = Location::Function {
                response: Some(function.response.clone()),
                reference: Some(function.reference.clone()),
            };
            let finding = Finding::new(Severity::Warning, Code::FunctionLeftOut, location);
            let detail = match other.axis().same_lines(used.axis()) {
                false => format!("{axis}, those used {}", described(used.axis())),
                true => format!(
                    "added damping {} rad/s, those used {} rad/s",
                    other.added_damping_rad_s, used.added_damping_rad_s
                ),
            };
            finding.detail(detail)
        };
        let findings: Vec<Finding> = other.functions().iter().map(left_out).collect();
        used.findings.extend(findings);
    }
    Some(used)
}

/// An axis as text.
fn described(axis: &FrequencyAxis) -> String {
    let FrequencyAxis {
        start_hz,
        step_hz,
        len,
    } = axis;
    format!("{len} lines by {step_hz} Hz from {start_hz} Hz")
}
