//! An excitation point that is hit again after others shows whether the structure or the
//! instrumentation drifted during the test.

use crate::dof::Dof;
use crate::record::Recording;

use super::consistency::visits::{Drift, resonance_drifts};
use super::estimate::estimate_recording;
use super::few_responses::FewResponses;
use super::hit_report::HitReport;
use super::selection::Selection;
use super::{EstimateOptions, FrfSet};

/// The change from the first hits at a point to its last ones after hits at other points, for the
/// point with the most hits between; `None` where no point was hit again.
///
/// Of many responses four of each hit are used.
pub(super) fn drift(
    recording: &mut dyn Recording,
    hits: &[HitReport],
    averaged: &FrfSet,
    selection: &Selection,
    options: &EstimateOptions,
) -> Option<Drift> {
    let mut recording = FewResponses::new(recording);
    let visits = visits(hits, &recording);
    let pairs = visits.iter().enumerate().filter_map(|(index, first)| {
        let is_first = visits[..index].iter().all(|other| other.key != first.key);
        let last = visits.iter().rposition(|other| other.key == first.key)?;
        (is_first && last > index).then(|| (first, &visits[last]))
    });
    let between = |(first, last): &(&Visit, &Visit)| last.hits[0] - first.hits[0];
    let (first, last) = pairs.max_by_key(between)?;
    let mut estimate = |visit: &Visit| {
        let selection = Selection {
            hits: visit.hits.iter().map(|number| number - 1).collect(),
            ..selection.clone()
        };
        // Hits that give no FRF alone show no frequency.
        let estimated = estimate_recording(&mut recording, &selection, options);
        estimated.ok().map(|estimated| estimated.set)
    };
    let (before, after) = (estimate(first)?, estimate(last)?);
    Some(Drift {
        reference: first.key.reference.clone(),
        first_hits: first.hits.clone(),
        last_hits: last.hits.clone(),
        resonances: resonance_drifts(averaged, before, after),
    })
}

/// Excitation point and responses of hits.
#[derive(PartialEq)]
struct VisitKey {
    reference: Dof,
    responses: Vec<Dof>,
}

/// Hits at one point with the same responses, one after the other.
struct Visit {
    key: VisitKey,
    /// Their numbers.
    hits: Vec<usize>,
}

/// The used hits as visits of points, in their order.
fn visits(hits: &[HitReport], recording: &FewResponses) -> Vec<Visit> {
    let mut visits: Vec<Visit> = Vec::new();
    for hit in hits.iter().filter(|hit| hit.used) {
        let responses = recording.hits()[hit.number - 1].responses.iter();
        let responses = responses.map(|response| response.dof.without_sign_and_repeat());
        let key = VisitKey {
            reference: hit.reference.without_sign_and_repeat(),
            responses: responses.collect(),
        };
        match visits.last_mut().filter(|visit| visit.key == key) {
            Some(visit) => visit.hits.push(hit.number),
            None => visits.push(Visit {
                key,
                hits: vec![hit.number],
            }),
        }
    }
    visits
}
