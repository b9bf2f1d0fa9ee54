//! Hits are written with the outcomes of their checks.

use serde_json::{Value, json};

use crate::frf::HitReport;

/// One object per hit: number, origin, point, peak, whether it is used and who decided that, and
/// every check.
pub fn hits_value(hits: &[HitReport]) -> Value {
    hits.iter().map(hit).collect()
}

fn hit(hit: &HitReport) -> Value {
    let checks = hit.checks.iter().map(|check| {
        json!({ "rule": check.rule.name(), "channel": check.dof, "value": check.value, "limit": check.limit,
            "unit": check.unit, "at": check.at, "detectability": check.detectability,
            "outcome": check.outcome.name() })
    });
    json!({ "hit": hit.number, "origin": hit.origin, "reference": hit.reference, "peak_n": hit.peak_n, "used": hit.used,
        "decided_by": if hit.stated { "user" } else { "rules" }, "checks": checks.collect::<Vec<_>>() })
}
