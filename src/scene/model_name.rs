//! The name of a model means a built-in model or the path of a file.

use std::path::{Path, PathBuf};

use crate::theory::BUILT_IN;

use super::error::{SceneError, value_error};
use super::typed::ModelTable;

/// Whether a model is meant by its built-in name, perhaps with a set, and not as a file.
pub(super) fn is_built_in(name: &Path) -> bool {
    let text = name.to_string_lossy();
    let first = text.split('/').next();
    let short = text.split('/').count() <= 2 && !text.ends_with('/') && name.extension().is_none();
    short && BUILT_IN.iter().any(|model| Some(model.name) == first)
}

/// Number of the first elastic root of a model in tables: that of a built-in model, else 1.
pub fn first_root(name: &Path) -> usize {
    let text = name.to_string_lossy();
    let mut models = BUILT_IN.iter();
    let found = models.find(|model| Some(model.name) == text.split('/').next());
    found
        .filter(|_| is_built_in(name))
        .map_or(1, |model| model.first_root)
}

/// The model that a `[model]` table names: a built-in name as it stands, or the path of a file.
///
/// # Errors
/// [`SceneError::Value`] when it names neither or both, or a name that is not built in.
pub(super) fn named_model(
    table: &ModelTable,
    folder: &Path,
    path: &str,
) -> Result<PathBuf, SceneError> {
    let named: PathBuf = match (&table.name, &table.file) {
        (Some(name), None) => Path::new(name).to_path_buf(),
        (None, Some(file)) => folder.join(file),
        _ => {
            return Err(value_error(
                path,
                "[model]",
                "none or both of `name` and `file`",
                "`name` of a built-in model, or `file` with a model.toml or a file of modes",
            ));
        }
    };
    if table.name.is_some() && !is_built_in(&named) {
        let got = format!("{:?}", named.display());
        let built_in_names: Vec<&str> = BUILT_IN.iter().map(|model| model.name).collect();
        return Err(value_error(
            path,
            "[model] name",
            &got,
            &built_in_names.join(", "),
        ));
    }
    Ok(named)
}
