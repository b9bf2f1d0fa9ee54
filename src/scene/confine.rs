//! A scene from elsewhere names only files below its folder.
//!
//! Every text of its TOML files counts as a path, whatever its key: a key that is added later
//! cannot be forgotten here. Texts are read, and wildcards expanded, as the readers of the paths do
//! it.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::io::{IoError, read_input_part};
use crate::printable::one_line;

use super::error::{SceneError, value_error};
use super::test_plan::expand;

/// Files that a verb reads in the folder of a scene without a key that names them.
const IMPLIED: [&str; 4] = ["scene.toml", "study.toml", "expected.toml", "model.toml"];
/// Maximum length of a file whose texts are checked, whatever its name. Larger: recordings are read
/// to see that they are no TOML. Smaller: a long model is not followed.
const MAX_TOML_BYTES: u64 = 16 << 20;

/// Checks that a scene, model or spec, and what it names, lie in its folder.
///
/// # Errors
/// [`SceneError::Value`] with the text that names another place; [`SceneError::Io`] for a file that
/// cannot be read. Faults of TOML are left to the reader of the file.
pub fn check_confined(path: &Path) -> Result<(), SceneError> {
    if !path.exists() {
        return Ok(());
    }
    let shown = path.display().to_string();
    if !path.is_dir() && !path.is_file() {
        let expected = "a file or a folder, in which --confine can look";
        return Err(value_error(
            &shown,
            "the file itself",
            "a pipe or a device",
            expected,
        ));
    }
    let folder = match (path.is_dir(), path.parent()) {
        (true, _) => path,
        (false, Some(folder)) if !folder.as_os_str().is_empty() => folder,
        (false, _) => Path::new("."),
    };
    let root = folder.canonicalize().map_err(|source| IoError::System {
        path: folder.display().to_string(),
        action: "read",
        source,
    })?;
    let mut search = Search {
        root,
        checked: BTreeSet::new(),
    };
    let mut paths = implied(folder);
    if path.is_file() {
        paths.push(path.to_owned());
    }
    while let Some(path) = paths.pop() {
        let shown = path.display().to_string();
        search.check_place(&path, &shown, "the file itself", &shown)?;
        paths.extend(search.check_file(&path)?);
    }
    Ok(())
}

/// The files that are read in a folder without being named.
fn implied(folder: &Path) -> Vec<PathBuf> {
    let files = IMPLIED.iter().map(|name| folder.join(name));
    files.filter(|file| file.is_file()).collect()
}

struct Search {
    /// The folder of the scene, without links.
    root: PathBuf,
    /// Files that were checked, without links.
    checked: BTreeSet<PathBuf>,
}

impl Search {
    /// Checks the texts of a TOML file; returns the files that they name, of any other file none.
    fn check_file(&mut self, file: &Path) -> Result<Vec<PathBuf>, SceneError> {
        let place = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        if !self.checked.insert(place) {
            return Ok(Vec::new());
        }
        let shown = file.display().to_string();
        let bytes = read_input_part(file, MAX_TOML_BYTES).map_err(|source| IoError::System {
            path: shown.clone(),
            action: "read",
            source,
        })?;
        let Ok(text) = String::from_utf8(bytes) else {
            return Ok(Vec::new());
        };
        // A file with faults is read as far as it goes.
        let (table, _) = DeTable::parse_recoverable(&text);
        let mut texts = Vec::new();
        push_texts(table.get_ref(), "", &mut texts);
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut named = Vec::new();
        for (key, text) in &texts {
            self.check_text(&shown, key, text)?;
            // A text that matches nothing, or cannot be a pattern, names nothing.
            for path in expand(folder, text, &shown).unwrap_or_default() {
                self.check_place(&path, &shown, key, text)?;
                match path.is_dir() {
                    true => named.extend(implied(&path)),
                    false if path.is_file() => named.push(path),
                    false => {}
                }
            }
        }
        Ok(named)
    }

    /// Refuses a text that leaves the folder by its letters, whatever is there.
    fn check_text(&self, file: &str, key: &str, text: &str) -> Result<(), SceneError> {
        let path = Path::new(text);
        let leaves = |part: Component<'_>| {
            matches!(
                part,
                Component::ParentDir | Component::RootDir | Component::Prefix(_)
            )
        };
        // A title may have a slash of its units.
        match path.components().any(leaves) && path.components().count() > 1 {
            true => Err(self.error(file, key, text)),
            false => Ok(()),
        }
    }

    /// Checks that a path, where it exists, lies below the folder.
    fn check_place(
        &self,
        path: &Path,
        file: &str,
        key: &str,
        text: &str,
    ) -> Result<(), SceneError> {
        match path.canonicalize() {
            Ok(place) if !place.starts_with(&self.root) => Err(self.error(file, key, text)),
            _ => Ok(()),
        }
    }

    fn error(&self, file: &str, key: &str, text: &str) -> SceneError {
        value_error(
            file,
            key,
            &format!("{text:?}, which lies outside"),
            &format!("a path below {} (--confine)", self.root.display()),
        )
    }
}

/// The texts of a table with their keys.
fn push_texts(table: &DeTable<'_>, above: &str, texts: &mut Vec<(String, String)>) {
    for (key, value) in table {
        let key = match above {
            "" => key.get_ref().to_string(),
            above => format!("{above}.{}", key.get_ref()),
        };
        push_texts_of_value(value.get_ref(), &key, texts);
    }
}

fn push_texts_of_value(value: &DeValue<'_>, key: &str, texts: &mut Vec<(String, String)>) {
    match value {
        DeValue::String(text) => texts.push((key.to_owned(), one_line(text).into_owned())),
        DeValue::Array(values) => {
            for value in values.iter() {
                push_texts_of_value(value.get_ref(), key, texts);
            }
        }
        DeValue::Table(table) => push_texts(table, key, texts),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn confined(files: &[(&str, &str)]) -> Result<(), SceneError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("secret.csv"), "1").unwrap();
        let scene = folder.path().join("scene");
        std::fs::create_dir_all(scene.join("raw")).unwrap();
        for (name, text) in files {
            std::fs::write(scene.join(name), text).unwrap();
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(folder.path().join("secret.csv"), scene.join("raw/link.csv"))
            .unwrap();
        check_confined(&scene)?;
        check_confined(&scene.join("scene.toml"))
    }

    #[test]
    fn paths_outside_the_folder_are_refused() {
        for text in [
            "[[test]]\nfiles = [\"../secret.csv\"]",
            "[[test]]\nfiles = [\"raw/../../secret.csv\"]",
            "[[test]]\nfiles = [\"../*.csv\"]",
            "model = { file = \"/\", matrices = \"/dev/null\" }",
            "a_key_that_is_added_later = \"../secret.csv\"",
            "[[test]]\nmodes = \"../secret.csv\\n\"",
            "[[test]]\nfiles = [\"../*.*\"]",
            "[[test]]\nfiles = [\"../.*\"]",
            "[[test]]\nfiles = [\"/**/nothing\"]",
        ] {
            let error = confined(&[("scene.toml", text)]).unwrap_err().to_string();
            assert!(error.contains("which lies outside"), "{text}: {error}");
        }
        #[cfg(unix)]
        for name in ["raw/link.csv", "raw/*.csv"] {
            let text = format!("[[test]]\nfiles = [\"{name}\"]");
            assert!(confined(&[("scene.toml", &text)]).is_err(), "{name}");
        }
    }

    #[test]
    fn files_that_a_named_file_names_are_checked() {
        let scene = ("scene.toml", "model = { file = \"m.toml\" }");
        let outside = ("m.toml", "[matrices]\ndofs = \"../secret.csv\"");
        let inside = (
            "m.toml",
            "title = \"a / b .. *\"\n[matrices]\ndofs = \"d.csv\"",
        );
        assert!(confined(&[scene, outside]).is_err());
        confined(&[scene, inside, ("d.csv", "1:+X")]).unwrap();
        // Whatever its ending, and in a folder.
        let spec = ("scene.toml", "[[test]]\nsynth = \"spec.txt\"");
        assert!(confined(&[spec, ("spec.txt", "truth = { modes = \"../secret.csv\" }")]).is_err());
        let study = ("study.toml", "scene = \"raw\"");
        let inner = ("raw/scene.toml", "[model]\nfile = \"../../secret.csv\"");
        assert!(confined(&[scene, inside, study, inner]).is_err());
        // Files that name each other.
        confined(&[scene, ("m.toml", "a = \"scene.toml\"")]).unwrap();
    }
}
