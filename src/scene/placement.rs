//! Proposal of points that tests of a scene should measure in addition.

use crate::correlate::{Candidates, NotAssessed, Placement, SensorSet, fewest_sensors, placement};
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::modal::ModalModel;

use super::SceneError;
use super::error::value_error;
use super::test_result::TestResult;
use super::typed::PlacementTable;

/// A test and the candidates for its additional points.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacementPlan {
    /// Name of the test.
    pub test: String,
    /// The candidates.
    pub candidates: Candidates,
    /// Largest AutoMAC between modes of different roots.
    pub max_auto_mac: f64,
}

/// Effect of additional points on a test.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedTest {
    /// Name of the test.
    pub test: String,
    /// The candidates.
    pub candidates: Candidates,
    /// The selected points, or the reason why they are not known.
    pub placement: Result<Placement, NotAssessed>,
    /// The fewest sensors whose AutoMAC is diagonal; `None` for fewer than two roots in the band.
    pub sensor_set: Option<SensorSet>,
}

/// The plans of `[[placement]]` tables: tests by name, and candidates among the scene's sensors.
///
/// # Errors
/// [`SceneError::Value`] for an unknown test and for a pattern that no sensor has.
pub(super) fn placement_plans(
    stated: Vec<PlacementTable>,
    tests: &[&str],
    sensors: &[Sensor],
    path: &str,
) -> Result<Vec<PlacementPlan>, SceneError> {
    let plan = |table: PlacementTable| {
        if !tests.contains(&table.test.as_str()) {
            let expected = format!("one of the tests {}", tests.join(", "));
            let got = format!("{:?}", table.test);
            return Err(value_error(path, "[[placement]] test", &got, &expected));
        }
        let max_auto_mac = table.max_auto_mac;
        if !(max_auto_mac > 0.0 && max_auto_mac < 1.0) {
            let key = "[[placement]] max_auto_mac";
            return Err(value_error(
                path,
                key,
                &max_auto_mac.to_string(),
                "above 0 and below 1",
            ));
        }
        Ok(PlacementPlan {
            max_auto_mac,
            test: table.test,
            candidates: Candidates {
                hits: points(&table.hits, sensors, path, "[[placement]] hits")?,
                sensors: points(&table.sensors, sensors, path, "[[placement]] sensors")?,
            },
        })
    };
    stated.into_iter().map(plan).collect()
}

/// The sensors' degrees of freedom that patterns name, ascending; a `*` at the end stands for
/// anything.
fn points(
    patterns: &[String],
    sensors: &[Sensor],
    path: &str,
    key: &str,
) -> Result<Vec<Dof>, SceneError> {
    let fits = |pattern: &str, dof: &Dof| match pattern.strip_suffix('*') {
        Some(start) => dof.to_string().starts_with(start),
        None => dof.to_string() == pattern,
    };
    let mut found = std::collections::BTreeSet::new();
    for pattern in patterns {
        let sensor_dofs = sensors.iter().map(|sensor| &sensor.dof);
        let fitting: Vec<Dof> = sensor_dofs
            .filter(|dof| fits(pattern, dof))
            .cloned()
            .collect();
        if fitting.is_empty() {
            let got = format!("{pattern:?}");
            let expected = "the degree of freedom of a [[sensor]], or the beginning of some with a * behind it";
            return Err(value_error(path, key, &got, expected));
        }
        found.extend(fitting);
    }
    Ok(found.into_iter().collect())
}

/// The selected points of every test that has a plan.
pub(super) fn placed_tests(
    plans: &[PlacementPlan],
    tests: &[TestResult],
    theory: &ModalModel,
) -> Vec<PlacedTest> {
    let placed = plans.iter().filter_map(|plan| {
        let test = tests.iter().find(|test| test.name == plan.test)?;
        Some(PlacedTest {
            test: plan.test.clone(),
            candidates: plan.candidates.clone(),
            sensor_set: fewest_sensors(
                theory,
                test.modes.band,
                &plan.candidates.sensors,
                plan.max_auto_mac,
            ),
            placement: placement(
                theory,
                &test.modes,
                &test.frfs,
                test.modes.band,
                &plan.candidates,
            ),
        })
    });
    placed.collect()
}
