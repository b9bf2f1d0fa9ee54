//! A scene is read with its files in a stated format, and the good part of a bad one if requested.

use std::path::Path;

use crate::error::Error;
use crate::scene::{Scene, SceneError, damage, read_text};
use crate::study::{StudyFile, parse_study};

use super::output::Output;

/// Name of the spec in a scene's folder.
const STUDY_FILE: &str = "study.toml";

/// How the files of a scene are to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneReading<'a> {
    /// Format of every file; detected from the content when `None`.
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
            scene.accept_partial_files();
        }
        Ok(scene)
    }
}

/// The scene with its spec; the defaults for a scene without one.
pub(super) fn load_scene_and_study(
    path: &Path,
    reading: SceneReading,
) -> Result<(Scene, StudyFile), Error> {
    let is_scene = Scene::is_path(path);
    let beside = path.is_dir().then(|| path.join(STUDY_FILE));
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
    Ok((reading.scene(&scene)?.base_alone(), file))
}

/// Adds the findings on damaged files of the tests; whether there are any.
pub(super) fn report_damage(scene: &Scene, output: &mut Output) -> Result<bool, Error> {
    let mut is_bad = false;
    for test in &scene.tests {
        let findings = damage(scene, test)?;
        is_bad |= !findings.is_empty();
        output.add_findings_of(&test.name, &findings);
    }
    Ok(is_bad)
}
