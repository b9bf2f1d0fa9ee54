//! What to repeat before the structure is gone is written as a list of items.

use serde_json::{Value, json};

use crate::frf::rigid_body::MIN_FALL;
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
        CheckItem::MassLine(check) => mass_line(check),
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

fn mass_line(check: &MassLineCheck) -> Value {
    let comparison = check.comparison();
    let stated = check.stated_kg.map(|stated_kg| match comparison {
        Some(mass) => json!({ "mass_kg": stated_kg, "compared": true,
            "difference": mass.difference(), "limit": mass.limit, "differs": mass.differs(),
            "gain": mass.gain(), "gain_std": mass.gain_std() }),
        None => json!({ "mass_kg": stated_kg, "compared": false }),
    });
    let Some(body) = &check.body else {
        return json!({ "item": "mass-line", "tested": false, "stated": stated });
    };
    let inertia = body.inertia.as_ref().ok();
    let no_mass = body.inertia.as_ref().err().map(|cause| cause.name());
    let fault = body.fault.as_ref();
    let repaired = inertia.and(fault).map(|fault| fault.repair.sensors());
    let fault = fault.map(|fault| {
        json!({ "sensor": fault.dof, "repair": fault.repair.to_string(),
            "fall_of_sum_of_squares": fault.fall, "limit": MIN_FALL })
    });
    json!({ "item": "mass-line", "tested": true, "band_hz": [body.band.lo_hz, body.band.hi_hz],
        "sensors": body.sensors, "rigid": body.is_rigid(), "misfit": body.misfit.value,
        "misfit_limit": body.misfit.limit, "not_rigid": fault,
        "mass_kg": inertia.map(|inertia| inertia.mass_kg),
        "mass_std_kg": inertia.map(|inertia| inertia.mass_std_kg),
        "centre_of_mass_m": inertia.map(|inertia| inertia.centre_m),
        "mass_with_repaired": repaired, "mass_not_determined": no_mass, "stated": stated })
}

fn support(check: &SupportCheck) -> Value {
    json!({ "item": "support", "tested": check.is_tested(), "support": check.support,
        "highest_rigid_body_hz": check.rigid_body_hz, "peak_below_hz": check.peak_below_hz,
        "elastic_hz": check.elastic_hz, "ratio": check.ratio(), "limit": check.limit })
}
