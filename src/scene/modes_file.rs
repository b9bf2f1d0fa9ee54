//! Finished modes from a file: `modes.json`, or any format that holds mode shapes.

use std::path::Path;

use crate::geometry::Geometry;
use crate::io::{
    Catalog, Hints, IoError, Need, check_damage, format_of, modal_model_of, modes_from_json,
    open_path, sha256_hex,
};
use crate::modal::{InputFile, ModalModel};

use super::SceneError;
use super::error::value_error;
use super::model_name::is_built_in;
use super::toml_text::read_text;

/// Whether a path names a file of modes, and not a model to be solved: whatever is neither a
/// built-in name, nor TOML, nor a folder.
pub fn is_modes_file(path: &Path) -> bool {
    let is_toml = path
        .extension()
        .is_some_and(|extension| extension == "toml");
    !is_toml && !is_built_in(path) && !path.is_dir()
}

/// Whether a file holds functions and no modes, by its headers; `false` for one that cannot be
/// opened, whose reason the reader of modes tells.
pub fn has_functions_only(path: &Path, format: Option<&str>) -> bool {
    let Ok(format) = format_of(path, format) else {
        return false;
    };
    let hints = Hints {
        path: path.display().to_string(),
        table: None,
    };
    let opened = open_path(path, &hints, Some(format.name()));
    format.name() != "modes"
        && opened.is_ok_and(|source| {
            let catalog = source.catalog();
            catalog.modes.is_empty() && !catalog.entries.is_empty()
        })
}

/// How a file of modes is to be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct ModesOptions<'a> {
    /// Its format, instead of judging by content.
    pub format: Option<&'a str>,
    /// Whether the good part of a partly bad file is sufficient.
    pub partial: bool,
    /// Whether the positions of nodes are needed, too.
    pub positions: bool,
}

/// The modes of a file.
#[derive(Clone, Debug, Default)]
pub struct LoadedModes {
    /// The modes.
    pub modes: ModalModel,
    /// Where the points are.
    pub geometry: Geometry,
    /// Whether part of the file was bad and left out.
    pub partly_bad: bool,
}

/// Reads the modes of a file, with the geometry that it holds.
///
/// # Errors
/// [`SceneError`] with the place, where what is needed of the file is damaged, and for one that
/// holds no modes.
pub fn load_modes(path: &Path, options: &ModesOptions) -> Result<LoadedModes, SceneError> {
    let name = path.display().to_string();
    let format = format_of(path, options.format)?;
    if format.name() == "modes" {
        return Ok(LoadedModes {
            modes: modes_from_json(&read_text(path)?, &name)?,
            ..LoadedModes::default()
        });
    }
    let hints = Hints {
        path: name.clone(),
        table: None,
    };
    let opened = open_path(path, &hints, Some(format.name()));
    let mut source = opened.map_err(|error| match error {
        IoError::NotStated { what, .. } => {
            no_modes(&name, &format!("a table in which {what} is open"))
        }
        other => other.into(),
    })?;
    let is_list = format.name() == "table" && is_single_column(source.catalog());
    if is_list {
        source = open_path(path, &hints, Some("modes-csv"))?;
    }
    let needs: &[Need] = match options.positions {
        true => &[Need::Modes, Need::Positions],
        false => &[Need::Modes],
    };
    let partly_bad = check_damage(source.as_mut(), needs, options.partial)?;
    let catalog = source.catalog();
    if catalog.modes.is_empty() {
        let got = format!("a file without modes ({})", held(catalog));
        return Err(no_modes(&name, &got));
    }
    let input = InputFile {
        path: name,
        sha256: sha256_hex(path)?,
        dofs: Vec::new(),
    };
    Ok(LoadedModes {
        modes: modal_model_of(catalog, vec![input]),
        geometry: catalog.geometry.clone(),
        partly_bad,
    })
}

/// The error of a file without modes, with the columns that a table of modes has.
fn no_modes(name: &str, got: &str) -> SceneError {
    let expected = "mode shapes, such as universal datasets 55 or 2414, a modes.json, or a table \
                    with the headings `frequency_hz`, `damping_ratio`, then `1:+Z`, or `1:+Z re` \
                    and `1:+Z im`, for each DOF (cells of `damping_ratio` may be empty), or with \
                    `frequency_hz` alone";
    value_error(name, "modes", got, expected)
}

/// Whether a table has one column, which may be a list of natural frequencies.
fn is_single_column(catalog: &Catalog) -> bool {
    let mut columns = catalog.arrays.iter();
    let is_single = matches!(
        columns.next().map(|array| array.shape.as_slice()),
        Some([_] | [_, 1])
    );
    is_single && columns.next().is_none() && catalog.entries.is_empty()
}

/// Contents of a file without modes: its columns or arrays by name, else the number of its records
/// and functions.
pub(super) fn held(catalog: &Catalog) -> String {
    let names: Vec<&str> = catalog.arrays.iter().map(|a| a.name.as_str()).collect();
    match names.as_slice() {
        [] => format!(
            "the file holds {} records and functions",
            catalog.entries.len()
        ),
        _ => format!("the file holds the columns {}", names.join(", ")),
    }
}
