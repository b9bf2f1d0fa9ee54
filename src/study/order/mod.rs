//! The study of needs finds the fewest modes, the lowest order, and the simplest method, theory and
//! parameter set that the data of a scene support.
//!
//! | file | question |
//! |---|---|
//! | `options` | [`OrderOptions`]: errors of a sufficient method |
//! | `methods` | the lowest order of every method that has one, and the modes for which one mode at a time is enough |
//! | `model` | the simplest theory, and the fewest parameters that update it to the tests |
//! | `summary` | [`summarise_needs`]: the results in sentences |
//!
//! [`crate::identify::support`] estimates the number of modes that the data support.

mod methods;
mod model;
mod options;
mod summary;
#[cfg(test)]
mod tests;

use crate::axis::Band;
use crate::finding::{Finding, Severity};
use crate::frf::FrfSet;
use crate::identify::{OrderSelection, identification, support};
use crate::modal::{InputFile, ModalModel};
use crate::scene::{Observer, Scene, TestPlan, TestSource};

use super::speed_accuracy::{
    RefinedSolution, SpeedAccuracyOptions, chosen_tests, variants_of_test,
};
use super::{Method, StudyError};

pub use methods::{LowestOrder, ModeNeeds, SingleMode, TriedOrder};
pub use model::{ParameterNeeds, TheoryNeeds};
pub use options::OrderOptions;
pub use summary::{method_sentences, needs_of_model, summarise_needs};

/// The needs of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct TestNeeds {
    /// Its name.
    pub name: String,
    /// Its files or its recording.
    pub inputs: Vec<InputFile>,
    /// Whether its recording is synthetic.
    pub synthetic: bool,
    /// The band that was searched.
    pub band: Band,
    /// Warnings of reading, estimation and the refined identification.
    pub warnings: Vec<Finding>,
    /// Number of poles that its data support.
    pub support: OrderSelection,
    /// Number of modes that the refined method identified.
    pub modes: usize,
    /// Number of them without an estimated damping ratio, which are no poles.
    pub undamped: usize,
    /// The lowest order of each method that has one.
    pub orders: Vec<LowestOrder>,
    /// Single-mode methods on every mode.
    pub single: Vec<ModeNeeds>,
    /// Comparisons that were not possible, and why.
    pub notes: Vec<String>,
}

/// The needs of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneNeeds {
    /// Title of the scene.
    pub title: String,
    /// Errors of a sufficient method.
    pub options: OrderOptions,
    /// Its tests.
    pub tests: Vec<TestNeeds>,
    /// Tests that could not be analysed, and why.
    pub failed: Vec<(String, String)>,
    /// The simplest theory, or why none was determined.
    pub theory: Result<TheoryNeeds, String>,
    /// The fewest parameters, or why none were determined.
    pub parameters: Result<ParameterNeeds, String>,
}

/// Determines the needs of a scene.
///
/// # Errors
/// [`StudyError`] for invalid options, for a model or an `[update]` that is wrong, and
/// where no test could be analysed: the reason of the first one.
pub fn order(
    scene: &Scene,
    options: &OrderOptions,
    observer: &dyn Observer,
) -> Result<SceneNeeds, StudyError> {
    options.validate()?;
    let has_data = |test: &TestPlan| !matches!(test.source, TestSource::Modes(_));
    let tests = match options.tests.is_empty() && !scene.tests.iter().any(has_data) {
        true => Vec::new(),
        false => chosen_tests(scene, &options.tests, "[order] tests")?,
    };
    let steps = tests.len() + 2;
    let (mut needs, mut failed) = (Vec::new(), Vec::new());
    for (number, test) in tests.iter().enumerate() {
        observer.step(&test.name, number + 1, steps);
        match test_needs(scene, test, options) {
            Ok(test) => needs.push(test),
            Err(error) => failed.push((test.name.clone(), error)),
        }
    }
    observer.step("theory", steps - 1, steps);
    let ends = needs.iter().map(|test| test.band.hi_hz);
    let theory = model::theory(scene, ends.reduce(f64::max), options)?;
    observer.step("parameters", steps, steps);
    let parameters = model::parameters(scene)?;
    if needs.is_empty() && theory.is_err() && parameters.is_err() {
        if let Some((_, error)) = failed.into_iter().next() {
            return Err(error);
        }
        return Err(StudyError::Value {
            key: "study order".to_owned(),
            got: "a scene with nothing to ask".to_owned(),
            expected: "a test of hits or FRFs, a model with a simpler one, or [update]".to_owned(),
        });
    }
    Ok(SceneNeeds {
        title: scene.title.clone(),
        options: options.clone(),
        tests: needs,
        failed: failed
            .into_iter()
            .map(|(name, error)| (name, error.to_string()))
            .collect(),
        theory,
        parameters,
    })
}

fn test_needs(
    scene: &Scene,
    test: &TestPlan,
    options: &OrderOptions,
) -> Result<TestNeeds, StudyError> {
    let without_variants = SpeedAccuracyOptions {
        estimators: Vec::new(),
        record_shares: Vec::new(),
        ..SpeedAccuracyOptions::default()
    };
    let data = variants_of_test(scene, test, &without_variants)?;
    let set = &data.sets[0].set;
    let refined_solution = identification(set, &Method::REFINED.options(data.band))?;
    let support = support(set, data.band, &refined_solution)?;
    let modes = refined_solution.model.modes.len();
    let all = refined_solution.model.modes.iter();
    let undamped = all.filter(|mode| mode.pole().is_none()).count();
    let findings = [
        &data.findings,
        &set.findings,
        &refined_solution.model.findings,
    ];
    let mut warnings: Vec<Finding> = Vec::new();
    for finding in findings.into_iter().flatten() {
        if finding.severity >= Severity::Warning && !warnings.contains(finding) {
            warnings.push(finding.clone());
        }
    }
    let (orders, single, notes) = if modes == 0 {
        let note = "methods are not compared: no mode was identified in the band";
        (Vec::new(), Vec::new(), vec![note.to_owned()])
    } else {
        compare_methods(refined_solution.model, set, data.band, options)
    };
    Ok(TestNeeds {
        name: test.name.clone(),
        inputs: data.inputs,
        synthetic: data.truth.is_some(),
        band: data.band,
        warnings,
        support,
        modes,
        undamped,
        orders,
        single,
        notes,
    })
}

/// The lowest orders, the single-mode methods on every mode, and a note where the methods cannot be
/// compared with the modes of the refined solution.
fn compare_methods(
    model: ModalModel,
    set: &FrfSet,
    band: Band,
    options: &OrderOptions,
) -> (Vec<LowestOrder>, Vec<ModeNeeds>, Vec<String>) {
    // Without a residue of every pair the twin, the truth of the comparison, is undefined.
    match RefinedSolution::from_modes(model, set, band) {
        Ok(refined) => (
            methods::lowest_orders(&refined, set, band),
            methods::single_mode_methods(&refined, set, band, options),
            Vec::new(),
        ),
        Err(error) => {
            let note = format!("methods are not compared: {error}");
            (Vec::new(), Vec::new(), vec![note])
        }
    }
}
