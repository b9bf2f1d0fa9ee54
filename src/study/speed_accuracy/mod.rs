//! The study of speed and accuracy runs every method, order, FRF estimator and length of record on
//! the tests of a scene and on their twins.
//!
//! On the measured data of a test, errors are those against its refined solution
//! ([`Method::REFINED`](super::Method::REFINED), from whole records), whose error is limited by its
//! Cramér-Rao bound. On the twin, a [`System`] of the test's modes, they are those against the
//! truth, over draws of white noise, in three [`Condition`]s.
//!
//! | file | what it holds |
//! |---|---|
//! | `options` | [`SpeedAccuracyOptions`]: varied quantities |
//! | `condition` | [`Condition`]: band, lines and end of the record of a twin |
//! | `result` | [`SpeedAccuracy`]: errors and cost by test |
//! | `data` | a test's FRFs by estimator and length of record |
//! | `test_data` | methods on the measured data of a test, with their cost |
//! | `twins` | methods on the twin over noise |
//! | `recommendations` | [`recommendations()`]: the fast and the accurate methods in sentences |
//! | `verdict` | [`method_verdicts`]: the method to use, its cost and where it fails |
//! | `front` | [`pareto_front`]: methods that no other undercuts in time and error |

mod condition;
mod data;
mod front;
mod options;
mod recommendations;
mod result;
mod test_data;
mod twins;
mod verdict;

use crate::scene::{Observer, Scene, TestPlan, TestSource};

use super::{Meter, StudyError, System};

pub use condition::Condition;
pub(super) use data::variants_of_test;
pub use front::{FrontPoint, pareto_front};
pub use options::SpeedAccuracyOptions;
pub use recommendations::recommendations;
pub use result::{DataRow, SpeedAccuracy, SpeedLimits, TestStudy, Timing, TwinCost, TwinRow};
pub(super) use test_data::RefinedSolution;
pub use verdict::method_verdicts;

/// Studies the tests of a scene.
///
/// # Errors
/// [`StudyError`] for invalid options, for a test whose data give no FRFs on one axis,
/// and where the refined method finds no mode to compare with.
pub fn speed_accuracy(
    scene: &Scene,
    options: &SpeedAccuracyOptions,
    meter: &dyn Meter,
    observer: &dyn Observer,
) -> Result<SpeedAccuracy, StudyError> {
    options.validate()?;
    let tests = chosen_tests(scene, &options.tests, "[speed_accuracy] tests")?;
    let study = |(number, test): (usize, &&TestPlan)| {
        let steps = Steps {
            observer,
            before: number * Steps::OF_TEST,
            count: tests.len() * Steps::OF_TEST,
            test: &test.name,
        };
        test_study(scene, test, options, meter, &steps)
    };
    let studies = tests.iter().enumerate().map(study);
    Ok(SpeedAccuracy {
        title: scene.title.clone(),
        options: options.clone(),
        tests: studies.collect::<Result<_, _>>()?,
    })
}

/// The tests that are named under a key, or every test with data where none is named.
pub(super) fn chosen_tests<'a>(
    scene: &'a Scene,
    named: &[String],
    key: &str,
) -> Result<Vec<&'a TestPlan>, StudyError> {
    let has_data = |test: &&TestPlan| !matches!(test.source, TestSource::Modes(_));
    let with_data: Vec<&TestPlan> = scene.tests.iter().filter(has_data).collect();
    let names = || -> Vec<&str> { with_data.iter().map(|test| test.name.as_str()).collect() };
    let wrong = |got: &str| StudyError::Value {
        key: key.to_owned(),
        got: got.to_owned(),
        expected: match with_data.is_empty() {
            true => "a scene with a test of hits or FRFs".to_owned(),
            false => format!("one of the tests with hits or FRFs: {}", names().join(", ")),
        },
    };
    if with_data.is_empty() {
        return Err(wrong("a scene without one"));
    }
    let named = named.iter().map(|name| {
        let mut all = with_data.iter().copied();
        all.find(|test| test.name == *name)
            .ok_or_else(|| wrong(&format!("{name:?}")))
    });
    let named: Vec<&TestPlan> = named.collect::<Result<_, _>>()?;
    Ok(if named.is_empty() { with_data } else { named })
}

/// Reports steps to the observer.
struct Steps<'a> {
    observer: &'a dyn Observer,
    before: usize,
    count: usize,
    test: &'a str,
}

impl Steps<'_> {
    const OF_TEST: usize = 3;

    fn step(&self, what: &str, number: usize) {
        let what = format!("{}: {what}", self.test);
        self.observer.step(&what, self.before + number, self.count);
    }
}

fn test_study(
    scene: &Scene,
    test: &TestPlan,
    options: &SpeedAccuracyOptions,
    meter: &dyn Meter,
    steps: &Steps,
) -> Result<TestStudy, StudyError> {
    steps.step("FRFs", 1);
    let mut data = variants_of_test(scene, test, options)?;
    let refined = RefinedSolution::new(&data)?;
    steps.step("methods on its data", 2);
    let rows = test_data::rows(&data, &refined, options, meter);
    steps.step("methods on its twin", 3);
    let set = &data.sets[0].set;
    let of_truth = data.truth.as_ref();
    let model = of_truth.unwrap_or(&refined.model);
    let twin = System::twin(model, set, data.band)?;
    let number = scene.tests.iter().position(|plan| plan.name == test.name);
    let number = number.unwrap_or_default();
    let twin = twins::study(twin, number, options, meter, &mut data.notes)?;
    Ok(TestStudy {
        name: test.name.clone(),
        inputs: data.inputs,
        functions: set.len(),
        lines: set.axis().lines(&data.band).len(),
        refined_modes: refined.model.modes.len(),
        frequency_std: refined.frequency_std,
        damping_std: refined.damping_std,
        twin_of_truth: of_truth.is_some(),
        twin_modes: twin.modes,
        twin_step_hz: twin.step_hz,
        limits: [test_data::limits(set, data.band, meter), twin.limits],
        data: rows,
        twin: twin.rows,
        twin_costs: twin.costs,
        notes: data.notes,
    })
}
