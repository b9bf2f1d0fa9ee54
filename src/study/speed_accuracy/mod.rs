//! The study of speed and accuracy runs every method, order, FRF estimator and length of record on
//! the tests of a scene and on their twins.
//!
//! On the measured data of a test, errors are those against its refined solution
//! ([`super::REFINED`], from whole records), whose error is limited by its Cramér-Rao bound. On the
//! twin, a [`System`] of the test's modes, they are those against the truth, over draws of white
//! noise, in three [`Condition`]s.
//!
//! | file | what it holds |
//! |---|---|
//! | `options` | [`SpeedAccuracyOptions`]: varied quantities |
//! | `data` | a test's FRFs by estimator and length of record |
//! | `test_data` | methods on the measured data of a test, with their cost |
//! | `twins` | methods on the twin over noise |
//! | `recommendations` | [`lessons`]: recommendations in sentences |
//! | `front` | [`front`]: Pareto front of time and error |

mod data;
mod front;
mod options;
mod recommendations;
mod test_data;
mod twins;

use crate::modal::InputFile;
use crate::scene::{Observer, Scene, TestPlan, TestSource};

use super::{DetectionCounts, Meter, Method, StudyError, System};

pub(super) use data::variants_of_test;
pub use front::front;
pub use options::SpeedAccuracyOptions;
pub use recommendations::lessons;
pub(super) use test_data::Refined;
pub use twins::Condition;

/// Cost of repeated runs of one identification.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Warm runs, one that is not counted before them.
    pub repeats: usize,
    /// Median processor time, s.
    pub median_s: Option<f64>,
    /// Longest less shortest, s; a single run has none.
    pub spread_s: Option<f64>,
    /// Most memory taken at once by a run, bytes.
    pub peak_bytes: Option<u64>,
}

/// A method on the measured data of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct DataRow {
    /// FRF estimator; `None` for FRFs that were given as such.
    pub estimator: Option<&'static str>,
    /// Distance of the lines, Hz.
    pub step_hz: f64,
    /// Method and order.
    pub method: Method,
    /// Whether it is the refined solution itself, by whatever order: it has no error against
    /// itself.
    pub is_reference: bool,
    /// Errors against the refined solution.
    pub tally: DetectionCounts,
    /// What it cost.
    pub timing: Timing,
    /// Whether it is on the [`front`] of processor time and frequency error among all rows of its
    /// test.
    pub on_front: bool,
}

/// A method on the twin.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinRow {
    /// Condition of the twin.
    pub condition: Condition,
    /// Noise.
    pub snr_db: f64,
    /// Method.
    pub method: Method,
    /// Errors against the truth, over all draws.
    pub tally: DetectionCounts,
}

/// Cost of a method on the twin in white noise, at the middle level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwinCost {
    /// Method.
    pub method: Method,
    /// Cost of one identification.
    pub timing: Timing,
    /// Whether it is on the [`front`] of processor time and frequency error at that level.
    pub on_front: bool,
}

/// Lower limits of the processor time of any method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedLimits {
    /// Processor time of one forward transform of every function, s.
    pub transform_s: Option<f64>,
    /// Processor time of reading every value of the band once, s.
    pub pass_s: Option<f64>,
}

/// The results of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct TestStudy {
    /// Its name.
    pub name: String,
    /// Its files or its recording.
    pub inputs: Vec<InputFile>,
    /// Functions and lines of the band, of the whole records.
    pub functions: usize,
    /// Lines of the band.
    pub lines: usize,
    /// Modes of the refined solution.
    pub refined_modes: usize,
    /// Rms stated deviation of the refined frequencies, relative.
    pub frequency_std: Option<f64>,
    /// Rms stated deviation of the refined damping ratios, relative.
    pub damping_std: Option<f64>,
    /// Whether the twin is of the recording's truth, and not of the refined modes.
    pub twin_of_truth: bool,
    /// Modes of the twin in the band.
    pub twin_modes: usize,
    /// Distance of its lines in white noise, Hz.
    pub twin_step_hz: f64,
    /// Methods on its measured data.
    pub data: Vec<DataRow>,
    /// Methods on its twin.
    pub twin: Vec<TwinRow>,
    /// Cost of each method on the twin.
    pub twin_costs: Vec<TwinCost>,
    /// Lower limits of processor time on the data and on the twin.
    pub limits: [SpeedLimits; 2],
    /// Comparisons that were not possible, and why.
    pub notes: Vec<String>,
}

/// Speed against accuracy of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedAccuracy {
    /// Title of the scene.
    pub title: String,
    /// Varied quantities.
    pub options: SpeedAccuracyOptions,
    /// Its tests.
    pub tests: Vec<TestStudy>,
}

/// Studies the tests of a scene.
///
/// # Errors
/// [`StudyError`] for invalid options, for a test whose data give no FRFs on one axis,
/// and where the refined method finds no mode to compare with.
pub fn speed_accuracy(
    scene: &Scene,
    options: &SpeedAccuracyOptions,
    (meter, observer): (&dyn Meter, &dyn Observer),
) -> Result<SpeedAccuracy, StudyError> {
    options.validate()?;
    let tests = chosen_tests(scene, (&options.tests, "[speed_accuracy] tests"))?;
    let study = |(number, test): (usize, &&TestPlan)| {
        let steps = Steps {
            observer,
            before: number * Steps::OF_TEST,
            count: tests.len() * Steps::OF_TEST,
            test: &test.name,
        };
        test_study(scene, test, (options, meter, &steps))
    };
    let studies = tests.iter().enumerate().map(study);
    Ok(SpeedAccuracy {
        title: scene.title.clone(),
        options: options.clone(),
        tests: studies.collect::<Result<_, _>>()?,
    })
}

/// The tests that are named under a key, or all with data.
pub(super) fn chosen_tests<'a>(
    scene: &'a Scene,
    (named, key): (&[String], &str),
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

impl TestStudy {
    /// The row of a method on the twin, at a level.
    pub fn twin_row(&self, condition: Condition, snr_db: f64, method: Method) -> Option<&TwinRow> {
        let mut rows = self.twin.iter();
        rows.find(|row| {
            let same_level = row.snr_db.total_cmp(&snr_db).is_eq();
            row.condition == condition && same_level && row.method == method
        })
    }
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
    (options, meter, steps): (&SpeedAccuracyOptions, &dyn Meter, &Steps),
) -> Result<TestStudy, StudyError> {
    steps.step("FRFs", 1);
    let mut data = variants_of_test(scene, test, options)?;
    let refined = Refined::new(&data)?;
    steps.step("methods on its data", 2);
    let rows = test_data::rows(&data, &refined, (options, meter));
    steps.step("methods on its twin", 3);
    let set = &data.sets[0].set;
    let of_truth = data.truth.as_ref();
    let model = of_truth.unwrap_or(&refined.model);
    let twin = System::twin(model, set, data.band)?;
    let seed = (
        options,
        scene.tests.iter().position(|plan| plan.name == test.name),
    );
    let twin = twins::study(twin, seed, (meter, &mut data.notes))?;
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
