//! What to repeat before the structure is gone is written as a list of items.

use serde_json::{Value, json};

use crate::frf::{
    BeforeYouLeave, Cause, Change, CheckItem, Drift, DrivingPoints, HitAgain, Linearity,
    MassLineCheck, PairFigures, PointCheck, Reason, ResonanceDrift, SupportCheck,
};

/// One object per item, with its name in `item`; an item without data has `tested` false.
pub fn before_you_leave_value(list: &BeforeYouLeave) -> Value {
    list.items.iter().map(item).collect()
}

fn item(item: &CheckItem) -> Value {
    match item {
        CheckItem::HitAgain(points) => hit_again(points),
        CheckItem::Linearity(all) => linearity(all),
        CheckItem::Reciprocity(figures) => reciprocity(figures.as_ref()),
        CheckItem::DrivingPoints(points) => driving_points(points.as_ref()),
        CheckItem::Drift(found) => drift(found.as_ref()),
        CheckItem::MassLine(check) => mass_line(check.as_deref()),
        CheckItem::Support(check) => support(check),
    }
}

fn hit_again(points: &HitAgain) -> Value {
    let point = |point: &PointCheck| {
        let deviation = point.deviation.as_ref().map(|deviation| {
            json!({ "response": deviation.response, "frequency_hz": deviation.hz,
                "averages": deviation.averages, "relative_std": deviation.relative_std,
                "relative_std_1_more": deviation.with_more(1),
                "relative_std_3_more": deviation.with_more(3) })
        });
        let reasons: Vec<Value> = point.reasons.iter().map(reason).collect();
        json!({ "reference": point.reference, "hit_again": point.is_listed(), "hits": point.hits,
            "best_hits": point.best, "missing_hits": point.missing_hits(), "reasons": reasons,
            "resonance": deviation })
    };
    let points: Vec<Value> = points.points.iter().map(point).collect();
    json!({ "item": "hit-again", "points": points })
}

fn reason(reason: &Reason) -> Value {
    let (name, hz) = match reason.cause {
        Cause::Rule(rule) => (rule.name(), None),
        Cause::Stated => ("stated", None),
        Cause::WeakForce => ("weak-force", None),
        Cause::FewHits => ("few-hits", None),
        Cause::LowCoherence { hz } => ("low-coherence", Some(hz)),
    };
    json!({ "reason": name, "hit": reason.hit, "response": reason.response, "frequency_hz": hz,
        "value": reason.value, "limit": reason.limit })
}

fn linearity(all: &Linearity) -> Value {
    json!({ "item": "linearity", "tested": all.is_tested(), "reference": all.reference,
        "hits": all.hits, "range_db": all.range_db, "min_range_db": all.min_range_db,
        "min_hits": all.min_hits, "dependences": all.dependences })
}

fn reciprocity(figures: Option<&PairFigures>) -> Value {
    let Some(figures) = figures else {
        return json!({ "item": "reciprocity", "tested": false });
    };
    json!({ "item": "reciprocity", "tested": true, "pairs": figures.pairs,
        "above_limit": figures.above_limit, "response": figures.response,
        "reference": figures.reference, "difference": figures.difference, "limit": figures.limit })
}

fn driving_points(points: Option<&DrivingPoints>) -> Value {
    let Some(points) = points else {
        return json!({ "item": "driving-points", "tested": false });
    };
    let wrong = points
        .wrong
        .iter()
        .map(|(response, reference)| json!({ "response": response, "reference": reference }));
    json!({ "item": "driving-points", "tested": true, "frfs": points.points,
        "wrong": wrong.collect::<Vec<_>>(), "value": points.value, "limit": points.limit })
}

fn drift(found: Option<&Drift>) -> Value {
    let Some(drift) = found else {
        return json!({ "item": "drift", "tested": false });
    };
    let change = |change: Change| json!({ "change": change.value, "std": change.std, "limit": change.limit });
    let resonance = |resonance: &ResonanceDrift| {
        json!({ "frequency_hz": resonance.hz, "frequency": change(resonance.frequency),
            "residue": change(resonance.amplitude) })
    };
    let resonances: Vec<Value> = drift.resonances.iter().map(resonance).collect();
    json!({ "item": "drift", "tested": !resonances.is_empty(), "reference": drift.reference,
        "first_hits": drift.first_hits, "last_hits": drift.last_hits, "resonances": resonances })
}

fn mass_line(check: Option<&MassLineCheck>) -> Value {
    let Some(MassLineCheck { body, mass }) = check else {
        return json!({ "item": "mass-line", "tested": false });
    };
    let inertia = body.inertia.as_ref();
    let fault = body
        .fault
        .as_ref()
        .map(|fault| json!({ "sensor": fault.dof, "repair": fault.repair.to_string() }));
    let stated = mass.as_ref().map(|mass| {
        json!({ "mass_kg": mass.stated_kg, "difference": mass.difference(), "limit": mass.limit,
            "differs": mass.differs(), "gain": mass.gain() })
    });
    json!({ "item": "mass-line", "tested": true, "band_hz": [body.band.lo_hz, body.band.hi_hz],
        "sensors": body.sensors, "mass_kg": inertia.map(|inertia| inertia.mass_kg),
        "mass_std_kg": inertia.map(|inertia| inertia.mass_std_kg),
        "centre_of_mass_m": inertia.map(|inertia| inertia.centre_m),
        "not_rigid": fault, "stated": stated })
}

fn support(check: &SupportCheck) -> Value {
    json!({ "item": "support", "tested": check.is_tested(), "support": check.support,
        "highest_rigid_body_hz": check.rigid_body_hz, "elastic_hz": check.elastic_hz,
        "ratio": check.ratio(), "limit": check.limit })
}
