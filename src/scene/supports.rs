//! Findings on supports: the suspension of a test, the support of a model against its matrices, and
//! the difference of both.

use crate::correlate::{ComparisonTable, Status, TestCell};
use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::ModalModel;
use crate::theory::{ModelRoot, ModelSupport, ReleasedMode, Support};

use super::SceneError;
use super::model::{Theory, table_model};
use super::plan::Scene;
use super::test_result::TestResult;
use super::test_state::TestState;

/// Frequency of the highest rigid-body mode of a suspension over that of the lowest elastic mode.
/// The suspension raises an elastic mode by about half the square of this ratio: 0.5 %. Larger, at
/// 0.2: a bias of 2 % goes unreported, as large as the errors of a good model. Smaller, at 0.05:
/// soft slings that change a frequency by 0.1 % are reported. Ewins (2000), chapter 3, allows 0.1
/// to 0.2. Tests `stiff_suspension_is_reported_with_its_bias` and, in `tests/suite/supports.rs`,
/// `bias_of_a_stiff_suspension_is_that_of_the_model_with_its_springs`.
pub(super) const MAX_RIGID_BODY_OVER_ELASTIC: f64 = 0.1;

/// Frequency of a test mode over the stated highest rigid-body mode up to which it is that mode.
/// Larger, at 2: an elastic mode near a stiff suspension is taken for its rigid-body mode. Smaller,
/// at 1: the rigid-body mode, stated with two digits, is taken for elastic. Test
/// `modes_of_the_suspension_are_named`.
const MAX_OVER_HIGHEST_RIGID_BODY: f64 = 1.1;

/// Part of a frequency within which a root of the model is that of a row: that of repeated roots.
const SAME_ROOT: f64 = 1e-6;

/// The rigid-body modes of a test on its suspension or mounts, and a suspension that is too stiff.
pub(super) fn suspension_findings(state: &TestState, modes: &ModalModel) -> Vec<Finding> {
    let Some(rigid_body_hz) = state.highest_rigid_body_hz else {
        return Vec::new();
    };
    let frequencies = || modes.modes.iter().map(|mode| mode.frequency_hz);
    let is_rigid_body = |hz: &f64| *hz <= MAX_OVER_HIGHEST_RIGID_BODY * rigid_body_hz;
    let named = |hz: f64| {
        Finding::new(Severity::Info, Code::RigidBodyMode, Location::Mode(hz))
            .value(hz, "Hz")
            .limit(rigid_body_hz)
    };
    let mut findings: Vec<Finding> = frequencies().filter(is_rigid_body).map(named).collect();
    let elastic = frequencies().filter(|hz| !is_rigid_body(hz));
    let lowest = elastic.reduce(f64::min);
    let limit = |elastic_hz: f64| MAX_RIGID_BODY_OVER_ELASTIC * elastic_hz;
    if let Some(elastic_hz) = lowest.filter(|hz| rigid_body_hz > limit(*hz))
        && state.support == Some(Support::Suspended)
    {
        let bias_percent = 50.0 * (rigid_body_hz / elastic_hz).powi(2);
        let detail = format!("raises the mode at {elastic_hz:.2} Hz by about {bias_percent:.2} %");
        findings.push(
            Finding::new(Severity::Warning, Code::SuspensionStiff, Location::Whole)
                .value(rigid_body_hz, "Hz")
                .limit(limit(elastic_hz))
                .detail(detail),
        );
    }
    findings
}

/// Adds the findings on the support of the model to those of the theory, and those on its
/// difference from the support of each test to `findings`, by test.
///
/// # Errors
/// As [`table_model`], and those of the modes without the stiffness to ground.
pub(super) fn add_support_findings(
    scene: &Scene,
    tests: &[TestResult],
    theory: &mut Theory,
    table: Option<&ComparisonTable>,
    findings: &mut Vec<(String, Vec<Finding>)>,
) -> Result<(), SceneError> {
    let needs_release = |test: &TestResult| is_released(&test.state, &theory.support);
    let released = match &scene.model {
        Some(model) if tests.iter().any(needs_release) => {
            let model = table_model(model, &scene.folder, &scene.path)?;
            model
                .map(|model| model.released_modes())
                .transpose()?
                .flatten()
        }
        _ => None,
    };
    let mut lowest_elastic_hz = None;
    for test in tests {
        let paired_hz = table.map_or_else(Vec::new, |table| paired_roots_hz(table, &test.name));
        let lowest = paired_hz.iter().copied().chain(lowest_elastic_hz);
        lowest_elastic_hz = lowest.reduce(f64::min);
        let released = released.as_deref();
        let difference = support_difference(&test.state, &theory.support, &paired_hz, released);
        findings.extend(difference.map(|finding| (test.name.clone(), vec![finding])));
    }
    let lowest_elastic_hz = lowest_elastic_hz.or_else(|| surely_elastic_hz(&theory.roots));
    let contradicted = support_contradiction(&theory.support, lowest_elastic_hz);
    theory.modes.findings.extend(contradicted);
    Ok(())
}

/// The finding on the stated support of a model that its matrices contradict. The lowest paired
/// root of a comparison is one that a test confirms; without a pair springs of a suspension are a
/// contradiction where they are stiff for every elastic mode.
pub fn contradicted_support(theory: &Theory, table: Option<&ComparisonTable>) -> Option<Finding> {
    let paired_hz = table.iter().flat_map(|table| {
        let tests = table.summary.iter();
        tests.flat_map(|test| paired_roots_hz(table, &test.test))
    });
    let lowest_elastic_hz = paired_hz.reduce(f64::min);
    support_contradiction(
        &theory.support,
        lowest_elastic_hz.or_else(|| surely_elastic_hz(&theory.roots)),
    )
}

/// The frequency of the lowest mode that is elastic whatever the springs of a suspension are: a
/// body has at most six rigid-body modes.
fn surely_elastic_hz(roots: &[ModelRoot]) -> Option<f64> {
    let modes = roots.iter().flat_map(|root| {
        std::iter::repeat_n(root.omega_rad_s / std::f64::consts::TAU, root.modes.len())
    });
    modes.into_iter().nth(MAX_RIGID_BODY_MODES)
}

/// Maximum number of rigid-body modes of a body.
const MAX_RIGID_BODY_MODES: usize = 6;

/// A stated support of a model that its matrices contradict. Springs of a suspension are no
/// contradiction where the model moves on them far below `lowest_elastic_hz`, the lowest root that
/// a test confirms.
fn support_contradiction(model: &ModelSupport, lowest_elastic_hz: Option<f64>) -> Option<Finding> {
    let (stated, derived) = (model.stated?, model.derived?);
    let is_free = |support| support == Support::Suspended;
    if is_free(stated) == is_free(derived) {
        return None;
    }
    let detail = format!(
        "stated {}, by the matrices {}",
        stated.name(),
        derived.name()
    );
    let code = Code::ModelSupportContradicted;
    let finding = Finding::new(Severity::Warning, code, Location::Whole).detail(detail);
    if !is_free(stated) {
        return Some(finding);
    }
    let Some(translation_hz) = model.translation_hz else {
        return Some(finding);
    };
    let limit = MAX_RIGID_BODY_OVER_ELASTIC * lowest_elastic_hz?;
    (translation_hz > limit).then(|| finding.value(translation_hz, "Hz").limit(limit))
}

/// Whether a test hangs and its model is held, so that the modes of the model without its stiffness
/// to ground show the effect.
fn is_released(test: &TestState, model: &ModelSupport) -> bool {
    test.support == Some(Support::Suspended)
        && model
            .support()
            .is_some_and(|support| support != Support::Suspended)
}

/// A support of a test that differs from that of the model, with the largest change of the
/// frequencies of the paired roots by it where `released` tells.
fn support_difference(
    test: &TestState,
    model: &ModelSupport,
    paired_hz: &[f64],
    released: Option<&[ReleasedMode]>,
) -> Option<Finding> {
    let (of_test, of_model) = (test.support?, model.support()?);
    let both_held = of_test != Support::Suspended && of_model != Support::Suspended;
    // Matrices do not tell a frame from mounts.
    if of_test == of_model || both_held && model.stated.is_none() {
        return None;
    }
    let supports = format!("test {}, model {}", of_test.name(), of_model.name());
    let code = Code::SupportDiffers;
    let finding = Finding::new(Severity::Warning, code, Location::Whole);
    let released = released
        .filter(|_| is_released(test, model))
        .unwrap_or_default();
    let is_paired = |mode: &&ReleasedMode| {
        let is_root = |hz: &f64| (hz - mode.held_hz).abs() <= SAME_ROOT * mode.held_hz;
        paired_hz.iter().any(is_root)
    };
    let paired: Vec<&ReleasedMode> = released.iter().filter(is_paired).collect();
    let changes = paired
        .iter()
        .filter_map(|mode| Some((mode.held_hz, mode.free_hz?)));
    let percent = |(held, free): &(f64, f64)| 100.0 * (free - held) / held;
    let largest = changes.max_by(|a, b| percent(a).abs().total_cmp(&percent(b).abs()));
    let Some((held, free)) = largest else {
        let detail = format!("{supports}; the model does not tell the effect on its frequencies");
        return Some(finding.detail(detail));
    };
    let lost = paired.iter().filter(|mode| mode.free_hz.is_none()).count();
    let lost = match lost {
        0 => String::new(),
        _ => format!("; modes without a counterpart: {lost}"),
    };
    let detail =
        format!("{supports}; without stiffness to ground {held:.1} Hz becomes {free:.1} Hz{lost}");
    let change = percent(&(held, free));
    Some(finding.value(change, "%").detail(detail))
}

/// Frequencies of the roots of the model that a test is paired with.
fn paired_roots_hz(table: &ComparisonTable, test: &str) -> Vec<f64> {
    let is_paired = |cell: &TestCell| cell.test == test && cell.status == Status::Paired;
    let rows = table.rows.iter();
    rows.filter(|row| row.tests.iter().any(is_paired))
        .filter_map(|row| row.theory.as_ref().map(|root| root.hz))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::{Mode, ModeShape, Scaling};

    fn test_modes(all_hz: &[f64]) -> ModalModel {
        let mode = |hz: &f64| Mode::new(*hz, None, ModeShape::default(), Scaling::Unknown);
        ModalModel {
            modes: all_hz.iter().map(mode).collect(),
            ..ModalModel::default()
        }
    }

    fn state(support: Support, highest_rigid_body_hz: Option<f64>) -> TestState {
        TestState {
            support: Some(support),
            highest_rigid_body_hz,
            ..TestState::default()
        }
    }

    fn held(stated: Option<Support>) -> ModelSupport {
        ModelSupport {
            stated,
            derived: Some(Support::Fixed),
            translation_hz: Some(30.0),
        }
    }

    #[test]
    fn stiff_suspension_is_reported_with_its_bias() {
        let found = |rigid_body_hz| {
            let state = state(Support::Suspended, Some(rigid_body_hz));
            suspension_findings(&state, &test_modes(&[50.0, 120.0]))
        };
        assert!(found(4.9).is_empty());
        let stiff = found(10.0);
        assert_eq!(stiff.len(), 1);
        assert_eq!(stiff[0].code, Code::SuspensionStiff);
        assert_eq!((stiff[0].value, stiff[0].limit), (Some(10.0), Some(5.0)));
        let detail = stiff[0].detail.as_deref().unwrap();
        assert!(detail.contains("50.00 Hz by about 2.00 %"), "{detail}");
        // The mounts of an operating state belong to the structure.
        let mounted = state(Support::Mounted, Some(10.0));
        assert!(suspension_findings(&mounted, &test_modes(&[50.0])).is_empty());
    }

    #[test]
    fn modes_of_the_suspension_are_named() {
        let state = state(Support::Suspended, Some(4.0));
        let found = suspension_findings(&state, &test_modes(&[2.1, 4.04, 90.0]));
        let named: Vec<_> = found
            .iter()
            .map(|finding| (finding.code, finding.value))
            .collect();
        let rigid = Code::RigidBodyMode;
        assert_eq!(named, [(rigid, Some(2.1)), (rigid, Some(4.04))]);
    }

    #[test]
    fn difference_of_supports_has_the_largest_change_of_the_paired_modes() {
        let released = [(100.0, Some(80.0)), (200.0, None), (300.0, Some(30.0))];
        let released = released.map(|(held_hz, free_hz)| ReleasedMode { held_hz, free_hz });
        let hung = state(Support::Suspended, None);
        let found = support_difference(&hung, &held(None), &[100.0, 200.0], Some(&released));
        let found = found.unwrap();
        assert_eq!(
            (found.code, found.value),
            (Code::SupportDiffers, Some(-20.0))
        );
        let detail = found.detail.unwrap();
        for part in [
            "test suspended, model fixed",
            "100.0 Hz becomes 80.0 Hz",
            "without a counterpart: 1",
        ] {
            assert!(detail.contains(part), "{detail}");
        }
        let unknown = support_difference(&hung, &held(None), &[100.0], None).unwrap();
        assert_eq!(unknown.value, None);
        assert!(unknown.detail.unwrap().contains("does not tell"));
    }

    #[test]
    fn supports_that_may_be_one_are_no_difference() {
        let difference =
            |support, model| support_difference(&state(support, None), &model, &[], None).is_some();
        let free = ModelSupport {
            derived: Some(Support::Suspended),
            ..ModelSupport::default()
        };
        assert!(difference(Support::Fixed, free));
        assert!(!difference(Support::Suspended, free));
        assert!(!difference(Support::Mounted, held(None)));
        assert!(difference(Support::Mounted, held(Some(Support::Fixed))));
        assert!(!difference(
            Support::Suspended,
            held(Some(Support::Suspended))
        ));
        assert!(!difference(Support::Fixed, ModelSupport::default()));
    }

    #[test]
    fn model_on_soft_springs_may_state_that_it_is_suspended() {
        let suspended = held(Some(Support::Suspended));
        assert_eq!(support_contradiction(&suspended, Some(400.0)), None);
        assert_eq!(support_contradiction(&suspended, None), None);
        let stiff = support_contradiction(&suspended, Some(200.0)).unwrap();
        assert_eq!((stiff.value, stiff.limit), (Some(30.0), Some(20.0)));
        let free = ModelSupport {
            stated: Some(Support::Mounted),
            derived: Some(Support::Suspended),
            translation_hz: Some(0.0),
        };
        let found = support_contradiction(&free, None).unwrap();
        assert_eq!(found.code, Code::ModelSupportContradicted);
        assert_eq!(
            support_contradiction(&held(Some(Support::Mounted)), None),
            None
        );
    }
}
