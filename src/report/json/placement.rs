//! Recommended test points and limits are written to `comparison.json`.

use serde_json::{Value, json};

use crate::correlate::{Placement, PlannedRoot, RankedHit, SensorSet, Step};
use crate::dof::Dof;
use crate::scene::{LimitCheck, PlacedTest};

/// The recommended points of tests, as `placements` of `comparison.json` holds them.
pub(super) fn placements_value(placed: &[PlacedTest]) -> Option<Value> {
    (!placed.is_empty()).then(|| placed.iter().map(placed_test).collect())
}

/// Limits with the values compared, as `limits` of `comparison.json` holds them.
pub(super) fn limits_value(limits: &[LimitCheck]) -> Option<Value> {
    let check = |check: &LimitCheck| {
        json!({
            "what": check.what,
            "value": check.value,
            "limit": check.limit,
            "bound": if check.upper { "upper" } else { "lower" },
            "met": check.is_met(),
        })
    };
    (!limits.is_empty()).then(|| limits.iter().map(check).collect())
}

fn placed_test(placed: &PlacedTest) -> Value {
    let mut value = match &placed.placement {
        Ok(points) => placement(points),
        Err(why) => json!({ "not_known": why.to_string() }),
    };
    value["test"] = placed.test.as_str().into();
    value["candidates"] = json!({
        "hits": names(&placed.candidates.hits),
        "sensors": names(&placed.candidates.sensors),
    });
    if let Some(set) = &placed.sensor_set {
        value["sensor_set"] = sensor_set(set);
    }
    value
}

fn sensor_set(set: &SensorSet) -> Value {
    json!({
        "max_auto_mac": set.limit,
        "met": set.is_met(),
        "sensors": names(&set.sensors),
        "largest_auto_mac": set.largest,
        "largest_at": set.largest_at.map(|at| set.modes[at].mode),
        "modes": set.modes,
        "auto_mac": set.auto_mac,
        "at_nodes": set.at_nodes,
    })
}

fn placement(placement: &Placement) -> Value {
    let step = |step: &Step| {
        let shown = step.shown.iter().map(
            |(root, modes)| json!({ "modes": numbers(&placement.roots[*root]), "shown": modes }),
        );
        json!({
            "hit": step.hit.as_ref().map(Dof::to_string),
            "sensor": step.sensor.as_ref().map(Dof::to_string),
            "shows": shown.collect::<Vec<Value>>(),
        })
    };
    let root = |root: &PlannedRoot| {
        json!({
            "modes": numbers(root),
            "hz": root.hz,
            "seen": root.seen,
            "planned": root.planned,
            "peak_over_noise_db": root.peak_over_noise_db,
            "every_hit_still": root.at_nodes[0],
            "every_sensor_still": root.at_nodes[1],
        })
    };
    let ranked = |hit: &RankedHit| {
        json!({
            "hit": hit.dof.to_string(),
            "shown": hit.shown,
            "driving_point_residue": hit.driving_point_residue,
            "independence": hit.independence,
        })
    };
    json!({
        "steps": placement.steps.iter().map(step).collect::<Vec<Value>>(),
        "roots": placement.roots.iter().map(root).collect::<Vec<Value>>(),
        "ranking": placement.ranking.iter().map(ranked).collect::<Vec<Value>>(),
    })
}

/// Mode numbers from 1, as in the rows.
fn numbers(root: &PlannedRoot) -> Vec<usize> {
    root.modes.iter().map(|j| j + 1).collect()
}

fn names(dofs: &[Dof]) -> Vec<String> {
    dofs.iter().map(Dof::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::measures::ModeName;
    use crate::correlate::{Candidates, NotAssessed};

    #[test]
    fn steps_roots_and_ranking_are_keys_of_the_test() {
        let dof = |text: &str| -> Dof { text.parse().unwrap() };
        let root = PlannedRoot {
            modes: vec![2, 3],
            hz: 80.0,
            seen: 0,
            planned: 1,
            peak_over_noise_db: Some(21.0),
            at_nodes: [false, true],
        };
        let placed = PlacedTest {
            test: "one hit".to_owned(),
            candidates: Candidates {
                hits: vec![dof("2:+Y")],
                sensors: vec![],
            },
            placement: Ok(Placement {
                steps: vec![Step {
                    hit: Some(dof("2:+Y")),
                    sensor: None,
                    shown: vec![(0, 1)],
                }],
                roots: vec![root],
                ranking: vec![RankedHit {
                    dof: dof("2:+Y"),
                    shown: 1,
                    driving_point_residue: 1.0,
                    independence: None,
                }],
            }),
            sensor_set: Some(SensorSet {
                sensors: vec![dof("1:+Z")],
                modes: vec![
                    ModeName { mode: 3, hz: 80.0 },
                    ModeName { mode: 5, hz: 90.0 },
                ],
                auto_mac: vec![vec![1.0, 0.04], vec![0.04, 1.0]],
                largest: 0.04,
                largest_at: [0, 1],
                limit: 0.1,
                candidates: 3,
                at_nodes: Vec::new(),
            }),
        };
        let unknown = PlacedTest {
            placement: Err(NotAssessed::ModalMass),
            sensor_set: None,
            ..placed.clone()
        };
        let value = placements_value(&[placed, unknown]).unwrap();
        assert_eq!(value[0]["test"], "one hit");
        let step =
            json!({ "hit": "2:+Y", "sensor": null, "shows": [{ "modes": [3, 4], "shown": 1 }] });
        assert_eq!(value[0]["steps"], json!([step]));
        let root = &value[0]["roots"][0];
        assert_eq!(
            [&root["every_hit_still"], &root["every_sensor_still"]],
            [&json!(false), &json!(true)]
        );
        assert_eq!(value[0]["ranking"][0]["shown"], 1);
        let set = &value[0]["sensor_set"];
        assert_eq!(
            [&set["met"], &set["auto_mac"][0][1]],
            [&json!(true), &json!(0.04)]
        );
        assert_eq!(
            [&set["largest_at"], &set["sensors"]],
            [&json!([3, 5]), &json!(["1:+Z"])]
        );
        assert!(value[1].get("sensor_set").is_none());
        assert_eq!(value[1]["not_known"], "the model has no modal mass");
        assert_eq!(placements_value(&[]), None);
    }

    #[test]
    fn limit_is_written_with_its_value_and_verdict() {
        let limit = LimitCheck {
            what: "t: smallest MAC".to_owned(),
            value: Some(0.8),
            limit: 0.9,
            upper: false,
        };
        let value = limits_value(&[limit]).unwrap();
        assert_eq!(
            [&value[0]["bound"], &value[0]["met"]],
            [&json!("lower"), &json!(false)]
        );
    }
}
