//! `modalign study`: one file per study.

use std::path::Path;

use clap::{Args, Subcommand};

use crate::error::Error;
use crate::scene::{Scene, SceneError, damage, read_text};
use crate::study::{StudyFile, parse_study};

use super::Outcome;
use super::breakdown::{BreakdownArgs, breakdown};
use super::order::{OrderArgs, needs};
use super::output::Output;
use super::speed_accuracy::{SpeedAccuracyArgs, study as speed_accuracy};

/// Name of the spec in a scene's folder.
const SPEC: &str = "study.toml";

/// `study`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign study speed-accuracy measurements/free-free-beam -o speed\n  modalign study breakdown measurements/free-free-beam -o fails\n  modalign study order measurements/free-free-beam -o needs"
)]
pub struct StudyArgs {
    /// The study.
    #[command(subcommand)]
    pub study: Study,
    /// Continue with the good part of a partly bad file of the scene.
    #[arg(long, global = true)]
    pub partial: bool,
}

/// How the files of a scene are to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneReading<'a> {
    /// Format of every file, instead of judging by content.
    pub format: Option<&'a str>,
    /// Whether the good part of a partly bad file is sufficient.
    pub partial: bool,
}

impl SceneReading<'_> {
    /// The scene of a path, its files to be read so.
    pub fn scene(self, path: &Path) -> Result<Scene, SceneError> {
        let mut scene = Scene::load(path)?;
        scene.format = self.format.map(str::to_owned);
        if self.partial {
            scene.take_good_parts();
        }
        Ok(scene)
    }
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Time and error of every method, order, FRF estimator and length of record, on a scene's data
    /// and on their synthetic twins.
    SpeedAccuracy(SpeedAccuracyArgs),
    /// Where every method fails: maps over noise, separation, damping, references and the like,
    /// with the contour of each method, the failure mode beyond it, and the modes of the scene.
    Breakdown(BreakdownArgs),
    /// The least effort that a scene needs: the modes that its data support, the lowest order of
    /// every method, where one mode at a time suffices, the simplest theory, the fewest parameters.
    Order(OrderArgs),
}

/// Makes a study.
pub fn study(
    args: &StudyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let partial = args.partial;
    let reading = SceneReading { format, partial };
    match &args.study {
        Study::SpeedAccuracy(args) => speed_accuracy(args, reading, output),
        Study::Breakdown(args) => breakdown(args, reading, output),
        Study::Order(args) => needs(args, reading, output),
    }
}

/// Lists what the files of the tests have lost; whether there is any.
pub(super) fn report_damage(scene: &Scene, output: &mut Output) -> Result<bool, Error> {
    let mut is_bad = false;
    for test in &scene.tests {
        let findings = damage(scene, test)?;
        is_bad |= !findings.is_empty();
        output.findings_of(&test.name, &findings);
    }
    Ok(is_bad)
}

/// The scene with its spec; the defaults for a scene without one.
pub(super) fn load(path: &Path, reading: SceneReading) -> Result<(Scene, StudyFile), Error> {
    let is_scene = Scene::is_path(path);
    let beside = path.is_dir().then(|| path.join(SPEC));
    let spec = match is_scene {
        true => beside.filter(|spec| spec.is_file()),
        false => Some(path.to_owned()),
    };
    let file = match &spec {
        None => StudyFile::default(),
        Some(spec) => parse_study(
            &read_text(spec).map_err(Error::Io)?,
            &spec.display().to_string(),
        )
        .map_err(Error::Scene)?,
    };
    let folder = spec
        .as_deref()
        .and_then(Path::parent)
        .unwrap_or(Path::new(""));
    let scene = match (is_scene, &file.scene) {
        (true, _) => path.to_owned(),
        (false, None) => folder.join("scene.toml"),
        (false, Some(scene)) => folder.join(scene),
    };
    Ok((reading.scene(&scene)?, file))
}
