//! What a set of FRFs says about the test that made it: signs at driving points, reciprocity, repeated measurements, delays
//! between channels, and resonances that move from run to run.
//!
//! | check | holds for | reference |
//! |---|---|---|
//! | [`driving`] | a passive structure: `Re Y ≥ 0` where force and response meet | Ewins (2000), Modal Testing, section 3.7 |
//! | [`reciprocity`] | a linear structure: `H_ij = H_ji` | Maxwell and Betti; Ewins (2000), section 2.8 |
//! | [`repeated`] | the same pair measured twice | — |
//! | [`delay`] | real modes: residues of one phase | — |
//! | [`drift`] | one structure in all runs: one pole | Ewins (2000), section 3.6 (mass loading) |
//!
//! Every check works on mobilities `Y = s^d H` at `s = iω + a`, turned to the positive axes. A check says nothing where the
//! data cannot carry it. It fits single resonances to compare functions; it lists no modes.

mod delay;
mod difference;
mod drift;
mod driving;
mod local;
mod mobility;
mod peaks;
mod reciprocity;
mod repeated;

#[cfg(test)]
mod false_alarm_tests;
#[cfg(test)]
mod synthetic;

pub(crate) use drift::runs;

use crate::finding::Finding;

use super::FrfSet;
use mobility::Mobilities;

/// All checks of a set, in the valid band (the whole axis when the set does not know it).
///
/// The set itself is not changed. Nothing comes back for a set of less than the lines that one resonance needs.
pub fn check_set(set: &FrfSet) -> Vec<Finding> {
    let Some(data) = Mobilities::new(set) else {
        return Vec::new();
    };
    let checks = [
        driving::findings,
        reciprocity::findings,
        repeated::findings,
        delay::findings,
        drift::findings,
    ];
    checks.iter().flat_map(|check| check(&data)).collect()
}
