//! `modalign study`: one file per study.

use std::path::Path;

use clap::{Args, Subcommand};

use crate::error::Error;
use crate::scene::{Scene, read_text};
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
    /// What is studied.
    #[command(subcommand)]
    pub study: Study,
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Time and error of every method, order, FRF estimator and length of record, on a scene's data and on their synthetic twins.
    SpeedAccuracy(SpeedAccuracyArgs),
    /// Where every method fails: maps over noise, separation, damping, references and the like, with the contour of each method, what
    /// is seen beyond it, and the scene's own modes.
    Breakdown(BreakdownArgs),
    /// How little a scene needs: the modes that its data support, the lowest order of every method, where one mode at a time is enough, the
    /// simplest theory, the fewest parameters.
    Order(OrderArgs),
}

/// Makes a study.
pub fn study(
    args: &StudyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    match &args.study {
        Study::SpeedAccuracy(args) => speed_accuracy(args, format, output),
        Study::Breakdown(args) => breakdown(args, format, output),
        Study::Order(args) => needs(args, format, output),
    }
}

/// The scene with its spec; the defaults for a scene without one.
pub(super) fn load(path: &Path, format: Option<&str>) -> Result<(Scene, StudyFile), Error> {
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
    let mut scene = Scene::load(&scene)?;
    scene.format = format.map(str::to_owned);
    Ok((scene, file))
}
