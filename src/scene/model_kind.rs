//! A path of the command line names a built-in model, a scene, finished modes or a model file.

use std::path::Path;

use crate::finding::{Code, Finding, Location, Severity};

use super::model_draft::ModelDraft;
use super::model_name::is_built_in;
use super::modes_file::is_modes_file;
use super::plan::Scene;

/// Kind of a model that a path of the command line names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelKind {
    /// A built-in model, perhaps with a set.
    BuiltIn,
    /// A scene, for its model.
    Scene,
    /// A file of finished modes.
    Modes,
    /// A model file.
    File,
}

/// Kind of the model at a path: a built-in name is the built-in model, as is `NAME/SET` unless it
/// is a file or a folder with a scene.
pub fn model_kind(path: &Path) -> ModelKind {
    let is_plain = path.components().count() == 1;
    if is_built_in(path) && (is_plain || !(path.is_file() || has_scene(path))) {
        ModelKind::BuiltIn
    } else if Scene::is_path(path) {
        ModelKind::Scene
    } else if path.is_file() && is_built_in(path) || is_modes_file(path) {
        ModelKind::Modes
    } else {
        ModelKind::File
    }
}

/// The finding on a built-in model, or a model file to begin with, whose name a file, or a folder
/// with a scene, has too.
pub fn built_in_name_finding(path: &Path) -> Option<Finding> {
    let other = match (path.is_file(), has_scene(path)) {
        (true, _) => "file",
        (_, true) => "folder",
        (false, false) => return None,
    };
    if model_kind(path) != ModelKind::BuiltIn && ModelDraft::at(path).is_none() {
        return None;
    }
    let location = Location::File {
        path: path.display().to_string(),
        line: None,
        byte: None,
    };
    let finding = Finding::new(Severity::Warning, Code::BuiltInTaken, location);
    Some(finding.detail(format!("./{} names the {other}", path.display())))
}

fn has_scene(path: &Path) -> bool {
    path.join("scene.toml").is_file()
}
