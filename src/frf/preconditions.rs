//! Hits are averaged only if they agree in sampling and quantities.

use std::collections::{HashMap, HashSet};

use crate::dof::Dof;
use crate::quantity::{FrfKind, Quantity};
use crate::record::{ChannelInfo, HitInfo};
use crate::signal::check_axis;

use super::{EstimateOptions, FrfError};

/// All argument checks of this stage that need no sample.
pub(super) fn check(hits: &[&HitInfo], options: &EstimateOptions) -> Result<(), FrfError> {
    options.validate()?;
    let first = hits.first().ok_or(FrfError::NoHits)?;
    let mut quantities = HashMap::new();
    for hit in hits {
        check_axis(hit)?;
        check_same_axis(hit, first)?;
        if hit.force.quantity != Quantity::Force {
            return Err(FrfError::NotAForce {
                origin: hit.origin.clone(),
                dof: hit.force.dof.clone(),
                got: hit.force.quantity,
            });
        }
        if hit.responses.is_empty() {
            return Err(FrfError::NoResponse {
                origin: hit.origin.clone(),
            });
        }
        check_responses(hit, &mut quantities)?;
    }
    Ok(())
}

/// One axis for all: as many samples, and steps that differ by less than a thousandth of a sample
/// over the record.
fn check_same_axis(hit: &HitInfo, first: &HitInfo) -> Result<(), FrfError> {
    let drift = (hit.axis.step_s - first.axis.step_s).abs() * hit.axis.len as f64;
    let differs = drift > 1e-3 * first.axis.step_s.abs();
    if hit.axis.len == first.axis.len && !differs {
        return Ok(());
    }
    Err(FrfError::AxisMismatch {
        origin: hit.origin.clone(),
        got_len: hit.axis.len,
        got_step_s: hit.axis.step_s,
        expected_len: first.axis.len,
        expected_step_s: first.axis.step_s,
        first: first.origin.clone(),
    })
}

fn check_responses<'a>(
    hit: &'a HitInfo,
    quantities: &mut HashMap<&'a Dof, Quantity>,
) -> Result<(), FrfError> {
    let mut seen = HashSet::with_capacity(hit.responses.len());
    for channel in &hit.responses {
        kind_of(hit, channel)?;
        let of = || (hit.origin.clone(), channel.dof.clone());
        if !seen.insert(&channel.dof) {
            let (origin, dof) = of();
            return Err(FrfError::DuplicateResponse { origin, dof });
        }
        let expected = *quantities.entry(&channel.dof).or_insert(channel.quantity);
        if expected != channel.quantity {
            let (origin, dof) = of();
            return Err(FrfError::QuantityMismatch {
                origin,
                dof,
                got: channel.quantity,
                expected,
            });
        }
    }
    Ok(())
}

/// The kind of FRF that a response gives.
pub(super) fn kind_of(hit: &HitInfo, channel: &ChannelInfo) -> Result<FrfKind, FrfError> {
    FrfKind::from_response(channel.quantity).ok_or_else(|| FrfError::NotAResponse {
        origin: hit.origin.clone(),
        dof: channel.dof.clone(),
        got: channel.quantity,
    })
}
