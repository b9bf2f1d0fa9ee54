//! A path of the command line names a built-in model, a scene, finished modes or a model file.

use std::path::Path;

use crate::finding::{Code, Finding, Location, Severity};

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

/// Kind of the model at a path: a folder with a scene is the scene, whatever its name, as for the
/// verbs that take a scene; a built-in name is else the built-in model, as is `NAME/SET` unless it
/// is a file.
pub fn model_kind(path: &Path) -> ModelKind {
    if is_built_in_model(path) && !has_scene(path) {
        ModelKind::BuiltIn
    } else if Scene::is_path(path) {
        ModelKind::Scene
    } else if path.is_file() && is_built_in(path) || is_modes_file(path) {
        ModelKind::Modes
    } else {
        ModelKind::File
    }
}

/// Whether a path names a built-in model where no scene can be meant: a built-in name, or
/// `NAME/SET` that is no file.
pub fn is_built_in_model(path: &Path) -> bool {
    let is_plain = path.components().count() == 1;
    is_built_in(path) && (is_plain || !path.is_file())
}

/// The finding on a built-in model whose name a file, or a folder with a scene, has too.
pub fn built_in_name_finding(path: &Path) -> Option<Finding> {
    if !is_built_in(path) {
        return None;
    }
    let is_built_in_used = model_kind(path) == ModelKind::BuiltIn;
    let name = path.display();
    let (severity, detail) = match (is_built_in_used, path.is_file(), has_scene(path)) {
        (true, true, _) => (
            Severity::Warning,
            format!("the built-in model was used; ./{name} names the file"),
        ),
        (false, _, true) => (
            Severity::Info,
            format!(
                "the scene {name}/scene.toml was used; in another folder {name} is the built-in model"
            ),
        ),
        _ => return None,
    };
    let location = Location::File {
        path: name.to_string(),
        line: None,
        byte: None,
    };
    Some(Finding::new(severity, Code::BuiltInTaken, location).detail(detail))
}

fn has_scene(path: &Path) -> bool {
    path.join("scene.toml").is_file()
}
