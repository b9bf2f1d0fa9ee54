//! An error about a missing file or model suggests the nearest existing name.

use std::io::ErrorKind;
use std::path::Path;

use crate::error::Error;
use crate::io::IoError;
use crate::report::json::REPORT_FILE;
use crate::scene::{ModelDraft, SceneError};
use crate::theory::BUILT_IN;

use super::new_points::{POINTS_OPTION, may_hold_points};

/// A line `hint: did you mean ...?` for a file that does not exist beside one of nearly that name,
/// or a model of nearly that name; the way to a scene for what files do not state.
pub fn hint(error: &Error) -> String {
    if let Error::Scene(SceneError::Io(IoError::NotStated { .. }))
    | Error::Io(IoError::NotStated { .. }) = error
    {
        return "\nhint: a scene states it; `modalign new DIR FILE...` drafts one".to_owned();
    }
    if let Some(hint) = folder_path(error).map(folder_hint) {
        return hint;
    }
    if let Some(path) = toml_path(error) {
        return format!(
            "\nhint: {path} is a scene or a model, no data; `modalign run SCENE` runs a scene"
        );
    }
    if let Error::Io(IoError::NoNumbers { path, .. }) = error
        && may_hold_points(Path::new(path))
    {
        return format!("\nhint: {POINTS_OPTION} with lines POINT,X,Y,Z in metres");
    }
    let missing = missing_path(error);
    if let Some(draft) = missing.and_then(ModelDraft::at) {
        let kind = draft.kind;
        return format!(
            "\nhint: `modalign new DIR FILE... --model {kind}` drafts a model file of this kind"
        );
    }
    if let Some(folder) = missing.and_then(folder_without_report) {
        let name = folder.display();
        let (scene, results) = match folder.join("scene.toml").is_file() {
            true => (name.to_string(), folder.join("out").display().to_string()),
            false => ("SCENE".to_owned(), "DIR".to_owned()),
        };
        return format!(
            "
hint: {name} holds no finished run; `modalign run {scene} -o {results}` makes one"
        );
    }
    match (missing.and_then(nearest_path), missing) {
        (Some(name), _) => format!("\nhint: did you mean `{name}`?"),
        (None, Some(path)) if is_report(path) => {
            let folder = path.parent().unwrap_or(Path::new("DIR")).display();
            format!("\nhint: `modalign run SCENE -o {folder}` makes a report")
        }
        _ => String::new(),
    }
}

/// A TOML file that was given where data are expected.
fn toml_path(error: &Error) -> Option<&str> {
    match error {
        Error::Io(io) | Error::Scene(SceneError::Io(io)) if io.is_no_measurement() => match io {
            IoError::NoNumbers { path, .. } | IoError::UnknownFormat { path, .. } => {
                Some(path.as_str()).filter(|path| path.ends_with(".toml"))
            }
            _ => None,
        },
        _ => None,
    }
}

/// The folder that was given where a file is to be read.
fn folder_path(error: &Error) -> Option<&Path> {
    let (path, action) = match error {
        Error::Io(IoError::System { path, action, .. })
        | Error::Scene(SceneError::Io(IoError::System { path, action, .. })) => (path, *action),
        _ => return None,
    };
    let is_read = matches!(action, "open" | "read");
    Some(Path::new(path)).filter(|path| is_read && path.is_dir())
}

/// The way from a folder to what a verb takes.
fn folder_hint(folder: &Path) -> String {
    let name = folder.display();
    if folder.join("scene.toml").is_file() {
        format!(
            "\nhint: {name} is a scene, which `modalign run {name}` runs; else name a file in it"
        )
    } else {
        "\nhint: name the files in it; `modalign new DIR FILE...` drafts a scene from them"
            .to_owned()
    }
}

/// The folder that exists and lacks the file from which `report` builds the page.
fn folder_without_report(missing: &Path) -> Option<&Path> {
    let folder = missing.parent().filter(|folder| folder.is_dir());
    folder.filter(|_| is_report(missing))
}

fn is_report(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == REPORT_FILE)
}

fn missing_path(error: &Error) -> Option<&Path> {
    let io = match error {
        Error::Io(io) => Some(io),
        Error::Scene(error) => missing_file(error),
        _ => None,
    };
    match io? {
        IoError::System { path, source, .. } if source.kind() == ErrorKind::NotFound => {
            Some(Path::new(path))
        }
        _ => None,
    }
}

/// The error of a file; of several faults the first of a file.
fn missing_file(error: &SceneError) -> Option<&IoError> {
    match error {
        SceneError::Io(io) => Some(io),
        SceneError::Several { faults } => faults.iter().find_map(missing_file),
        _ => None,
    }
}

/// The path with its first missing part replaced by the nearest name in that folder.
fn nearest_path(path: &Path) -> Option<String> {
    let mut known = std::path::PathBuf::new();
    let mut parts = path.components();
    let missing = parts.find(|part| {
        known.push(part);
        !known.exists()
    })?;
    known.pop();
    let folder = if known.as_os_str().is_empty() {
        Path::new(".")
    } else {
        &known
    };
    let entries = std::fs::read_dir(folder).ok()?.filter_map(Result::ok);
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    if known.as_os_str().is_empty() {
        names.extend(BUILT_IN.iter().map(|model| model.name.to_owned()));
    }
    names.sort();
    let name = nearest(
        &missing.as_os_str().to_string_lossy(),
        names.iter().map(String::as_str),
    )?;
    Some(
        known
            .join(name)
            .join(parts.as_path())
            .display()
            .to_string()
            .trim_end_matches('/')
            .to_owned(),
    )
}

/// The other name that is nearest by letters inserted, dropped, changed or swapped; none where a
/// third of them or more differ.
pub fn nearest<'a>(got: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let distance = |name: &str| strsim::damerau_levenshtein(got, name);
    let best = names
        .into_iter()
        // A link to nothing has the very name that was typed.
        .filter(|name| *name != got)
        .map(|name| (distance(name), name))
        .min_by_key(|(far, _)| *far)?;
    (3 * best.0 <= got.chars().count().max(3)).then_some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_is_suggested_and_another_is_not() {
        let names = ["hits.uff", "scene.toml", "b"];
        assert_eq!(nearest("hist.uff", names), Some("hits.uff"));
        assert_eq!(nearest("a", names), Some("b"));
        assert_eq!(nearest("measurement.csv", names), None);
        assert_eq!(nearest("hits.uff", names), None);
    }

    #[test]
    fn the_missing_part_of_a_path_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("beam/raw")).unwrap();
        std::fs::write(folder.path().join("beam/raw/hits.uff"), "").unwrap();
        let near = |path: &str| nearest_path(&folder.path().join(path));
        let expected = folder
            .path()
            .join("beam/raw/hits.uff")
            .display()
            .to_string();
        assert_eq!(near("beam/raw/hit.uff"), Some(expected.clone()));
        assert_eq!(near("baem/raw/hits.uff"), Some(expected));
        assert_eq!(
            nearest_path(Path::new("cycloid-bal")),
            Some("cycloid-ball".to_owned())
        );
    }
}
