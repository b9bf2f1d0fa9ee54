//! The variants of a test are its FRFs by estimator and length of record.

use crate::axis::{Band, TimeAxis};
use crate::finding::Finding;
use crate::frf::{Estimator, FrfError, FrfSet, HammerOptions, evaluate_hammer_test, excited_part};
use crate::modal::{InputFile, ModalModel};
use crate::record::{ChannelSegment, HitInfo, ReadError, Recording, Samples};
use crate::scene::{Scene, SceneError, TestPlan, test_data};

use super::super::StudyError;
use super::SpeedAccuracyOptions;

/// FRFs of one estimator from records of one length.
pub(in crate::study) struct Variant {
    /// `None` for a test whose files hold FRFs.
    pub estimator: Option<&'static str>,
    pub set: FrfSet,
}

/// FRFs on which the methods are compared.
pub(in crate::study) struct TestSets {
    /// The first has the estimator of the scene and whole records.
    pub sets: Vec<Variant>,
    pub band: Band,
    /// The truth of a synthetic recording.
    pub truth: Option<ModalModel>,
    pub inputs: Vec<InputFile>,
    pub notes: Vec<String>,
    /// Findings of reading; the sets have those of estimation.
    pub findings: Vec<Finding>,
}

pub(in crate::study) fn variants_of_test(
    scene: &Scene,
    test: &TestPlan,
    options: &SpeedAccuracyOptions,
) -> Result<TestSets, StudyError> {
    let data = test_data(scene, test)?;
    let truth = data.recording.map(|recording| recording.truth);
    let mut sets = match data.ingested.recording {
        Some(mut recording) => estimate_variants(scene, test, recording.as_mut(), options)?,
        None => given_frfs(test, data.ingested.frfs)?,
    };
    sets.truth = truth;
    sets.inputs = data.inputs;
    sets.findings = data.ingested.findings;
    Ok(sets)
}

/// The set of a test whose files hold FRFs: they have one estimator and one resolution.
fn given_frfs(test: &TestPlan, mut sets: Vec<FrfSet>) -> Result<TestSets, StudyError> {
    let axes = SceneError::Axes {
        test: test.name.clone(),
        got: sets.len(),
    };
    let set = sets.pop().filter(|_| sets.is_empty()).ok_or(axes)?;
    let axis = set.axis();
    let whole = Band::new(axis.hz(0).max(axis.step_hz), axis.hz(axis.len - 1));
    let band = test.band.or(set.valid_band).or(whole.ok());
    let band = band.ok_or(FrfError::BandEmpty {
        lo_hz: axis.hz(0),
        hi_hz: axis.hz(axis.len - 1),
    })?;
    Ok(TestSets {
        sets: vec![Variant {
            estimator: None,
            set,
        }],
        band,
        truth: None,
        inputs: Vec::new(),
        notes: vec!["the FRFs came as such: one estimator, one resolution".to_owned()],
        findings: Vec::new(),
    })
}

/// FRFs of a recording: with the options of the scene first, then of shorter records, then by the
/// other estimators.
fn estimate_variants(
    scene: &Scene,
    test: &TestPlan,
    recording: &mut dyn Recording,
    options: &SpeedAccuracyOptions,
) -> Result<TestSets, StudyError> {
    let base = test.hammer_options(&scene.hammer);
    let first = evaluate_hammer_test(recording, &base)?;
    let wanted = test.band.unwrap_or(first.usable);
    let band = excited_part(&first.estimated.set, wanted, first.usable)?;
    let stated_estimator = base.estimate.estimator;
    let mut sets = vec![Variant {
        estimator: Some(stated_estimator.name()),
        set: first.estimated.set,
    }];
    let mut notes = Vec::new();
    let shorter = options
        .record_shares
        .iter()
        .map(|share| (stated_estimator, *share));
    let named = options
        .estimators
        .iter()
        .filter_map(|name| Estimator::from_name(name));
    let others = named
        .filter(|other| *other != stated_estimator)
        .map(|other| (other, 1.0));
    for (estimator, share) in shorter.chain(others) {
        let mut options = base.clone();
        options.estimate.estimator = estimator;
        let estimator = estimator.name();
        match estimate_from_share(recording, share, &options) {
            Ok(set) => sets.push(Variant {
                estimator: Some(estimator),
                set,
            }),
            Err(error) => notes.push(format!("{estimator} of {share} of the record: {error}")),
        }
    }
    Ok(TestSets {
        sets,
        band,
        truth: None,
        inputs: Vec::new(),
        notes,
        findings: Vec::new(),
    })
}

fn estimate_from_share(
    recording: &mut dyn Recording,
    share: f64,
    options: &HammerOptions,
) -> Result<FrfSet, FrfError> {
    let hits = recording.hits().iter().cloned();
    let hits = hits.map(|hit| HitInfo {
        axis: TimeAxis {
            // An even number of samples, as the transform has them in pairs.
            len: 2 * (0.5 * share * hit.axis.len as f64).round() as usize,
            ..hit.axis
        },
        ..hit
    });
    let mut shortened = Shortened {
        hits: hits.collect(),
        whole: recording,
    };
    Ok(evaluate_hammer_test(&mut shortened, options)?.estimated.set)
}

/// The beginning of every hit.
struct Shortened<'a> {
    hits: Vec<HitInfo>,
    whole: &'a mut dyn Recording,
}

impl Recording for Shortened<'_> {
    fn hits(&self) -> &[HitInfo] {
        &self.hits
    }

    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        self.whole.read(segment, samples)
    }
}
