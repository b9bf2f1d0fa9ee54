//! A scene from elsewhere names only files below its folder.
//!
//! Every text of its TOML files counts as a path, whatever its key, with wildcards expanded and
//! symbolic links resolved: a key that is added later cannot be forgotten here.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::io::IoError;

use super::error::{SceneError, value_error};
use super::toml_text::read_text;

/// Files that a verb reads beside a scene without a key that names them.
const IMPLIED: [&str; 4] = ["scene.toml", "study.toml", "expected.toml", "model.toml"];

/// Checks that a scene, model or spec, and what it names, lie in its folder.
///
/// # Errors
/// [`SceneError::Value`] with the text that names another place; [`SceneError::Io`] for a file that
/// cannot be read. Faults of TOML are left to the reader of the file.
pub fn check_confined(path: &Path) -> Result<(), SceneError> {
    let folder = match path.is_dir() {
        true => path,
        false => path.parent().unwrap_or(Path::new("")),
    };
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let root = folder.canonicalize().map_err(|source| IoError::System {
        path: folder.display().to_string(),
        action: "read",
        source,
    })?;
    let mut files: Vec<PathBuf> = match path.is_dir() {
        true => IMPLIED.iter().map(|name| folder.join(name)).collect(),
        false => vec![path.to_owned()],
    };
    if path.is_file() {
        let beside = IMPLIED.iter().map(|name| folder.join(name));
        files.extend(beside.filter(|file| file.is_file()));
    }
    let mut search = Search {
        root,
        checked: BTreeSet::new(),
    };
    while let Some(file) = files.pop() {
        if file.exists() {
            let shown = file.display().to_string();
            search.check_place(&file, &shown, "the file itself", &shown)?;
            files.extend(search.check_file(&file)?);
        }
    }
    Ok(())
}

struct Search {
    /// The folder of the scene, without links.
    root: PathBuf,
    /// TOML files that were checked, without links.
    checked: BTreeSet<PathBuf>,
}

impl Search {
    /// Checks the texts of a TOML file; returns the TOML files that they name.
    fn check_file(&mut self, file: &Path) -> Result<Vec<PathBuf>, SceneError> {
        let place = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        if !self.checked.insert(place) {
            return Ok(Vec::new());
        }
        let shown = file.display().to_string();
        let text = read_text(file)?;
        let (table, _) = DeTable::parse_recoverable(&text);
        let mut texts = Vec::new();
        push_texts(table.get_ref(), "", &mut texts);
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut named = Vec::new();
        for (key, text) in texts
            .iter()
            .filter(|(_, text)| text.contains(char::is_alphanumeric))
        {
            let pattern =
                Path::new(&glob::Pattern::escape(&folder.display().to_string())).join(text);
            // A text that is no pattern names one file at most.
            let matches = glob::glob(&pattern.display().to_string())
                .into_iter()
                .flatten();
            let paths = matches.filter_map(Result::ok).chain([folder.join(text)]);
            for path in paths {
                self.check_place(&path, &shown, key, text)?;
                let is_toml = path
                    .extension()
                    .is_some_and(|extension| extension == "toml");
                if is_toml && path.is_file() {
                    named.push(path);
                }
            }
        }
        Ok(named)
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
            Ok(place) if !place.starts_with(&self.root) => Err(value_error(
                file,
                key,
                &format!("{text:?}, which lies outside"),
                &format!("a path below {} (--confine)", self.root.display()),
            )),
            _ => Ok(()),
        }
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
        DeValue::String(text) => texts.push((key.to_owned(), text.to_string())),
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
        // Files that name each other.
        confined(&[scene, ("m.toml", "a = \"scene.toml\"")]).unwrap();
    }
}
