//! A `model.toml` of `kind = "matrices"`: which files hold the matrices of a model, and its degrees
//! of freedom.
//!
//! ```toml
//! schema = "modalign-model/1"
//! kind = "matrices"
//! title = "Housing from a finite element program"
//!
//! [matrices]                        # SI units; paths are relative to this file
//! dofs = "dofs.txt"                 # one for each row and column; or a list, ["1:+X", "1:+Y"]
//! mass = "m.mtx"
//! stiffness = { file = "k.h5", name = "housing/K" }
//!
//! [[matrices.group]]                # K = K0 + theta K1
//! parameter = "bearing"
//! stiffness = { file = "k.h5", name = "bearing/K" }
//!
//! [[parameter]]
//! name = "bearing"
//! unit = "-"
//! nominal = 1.0
//! lower = 0.2
//! upper = 5.0
//! status = "assumed"
//!
//! # C = alpha M + beta K in addition to a damping matrix, or damping ratios by mode.
//! [damping]
//! mass_per_s = 0.0
//! stiffness_s = 1e-6
//! ```

use std::fmt;
use std::path::Path;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::dof::Dof;
use crate::io::{IoError, MatrixEntries, read_matrix};
use crate::linalg::SparseMatrix;
use crate::theory::{
    ExternalMatrices, ExternalModel, MatrixSet, ParameterSpec, SCHEMA, StatedDamping, Support,
};

use super::SceneError;
use super::error::{model_error, value_error};
use super::faults::{Faults, parse_checked};
use super::toml_text::{check_schema, read_text};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MatricesFile {
    schema: Option<String>,
    #[serde(rename = "kind")]
    _kind: Option<String>,
    title: Option<String>,
    support: Option<Support>,
    /// Read by the stage that loads the model.
    #[serde(default, rename = "example_values")]
    _example_values: bool,
    matrices: MatricesTable,
    #[serde(default, rename = "parameter")]
    parameters: Vec<ParameterSpec>,
    #[serde(default)]
    damping: DampingTable,
    /// Read by the stage that solves the model at them.
    #[serde(default, rename = "sensor")]
    _sensors: IgnoredAny,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MatricesTable {
    dofs: DofList,
    mass: Option<MatrixFile>,
    damping: Option<MatrixFile>,
    stiffness: Option<MatrixFile>,
    #[serde(default, rename = "group")]
    groups: Vec<GroupTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupTable {
    parameter: String,
    mass: Option<MatrixFile>,
    damping: Option<MatrixFile>,
    stiffness: Option<MatrixFile>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct DampingTable {
    #[serde(default)]
    mass_per_s: f64,
    #[serde(default)]
    stiffness_s: f64,
    #[serde(default)]
    ratios: Vec<f64>,
}

/// A file, with the name of the matrix in it where it has names: `"m.mtx"` or `{ file = "m.mat",
/// name = "M" }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NamedMatrix {
    file: String,
    name: Option<String>,
}

struct MatrixFile(NamedMatrix);

impl<'de> Deserialize<'de> for MatrixFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = MatrixFile;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a path, or { file = PATH, name = NAME }")
            }

            fn visit_str<E>(self, path: &str) -> Result<MatrixFile, E> {
                let file = path.to_owned();
                Ok(MatrixFile(NamedMatrix { file, name: None }))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MatrixFile, A::Error> {
                NamedMatrix::deserialize(MapAccessDeserializer::new(map)).map(MatrixFile)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// Degrees of freedom as a list, or the file that lists them.
enum DofList {
    Here(Vec<Dof>),
    File(String),
}

impl<'de> Deserialize<'de> for DofList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = DofList;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str(
                    "a list of degrees of freedom, or the path of a file with one on each line",
                )
            }

            fn visit_str<E>(self, path: &str) -> Result<DofList, E> {
                Ok(DofList::File(path.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<DofList, A::Error> {
                let dofs = Vec::deserialize(SeqAccessDeserializer::new(list));
                dofs.map(DofList::Here).map_err(A::Error::custom)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// The model of a file's text.
///
/// # Errors
/// [`SceneError`] with file and place, or the error of the model.
pub(super) fn matrix_model(
    text: &str,
    path: &str,
    folder: &Path,
) -> Result<ExternalModel, SceneError> {
    let check = |file: MatricesFile, _| checked_model(file, path, folder);
    parse_checked(text, path, check)
}

fn checked_model(
    file: MatricesFile,
    path: &str,
    folder: &Path,
) -> Result<ExternalModel, SceneError> {
    let mut faults = Faults::default();
    if let Some(schema) = &file.schema {
        faults.take(check_schema(schema, SCHEMA, path));
    }
    let table = file.matrices;
    let dofs = match table.dofs {
        DofList::Here(dofs) => Some(dofs),
        DofList::File(name) => faults.take(listed_dofs(&folder.join(name))),
    };
    let reader = Reader {
        path,
        folder,
        size: dofs.as_ref().map(Vec::len),
    };
    let fixed = [&table.mass, &table.damping, &table.stiffness];
    let fixed = faults.take(reader.set("[matrices]", fixed));
    let mut groups = Vec::new();
    for (number, group) in (1..).zip(table.groups) {
        let key = format!("[[matrices.group]] {number} ({})", group.parameter);
        let parts = [&group.mass, &group.damping, &group.stiffness];
        if parts.iter().all(|part| part.is_none()) {
            let expected = "mass, damping or stiffness";
            faults.add(value_error(path, &key, "no matrix", expected));
            continue;
        }
        let set = faults.take(reader.set(&key, parts));
        groups.extend(set.map(|set| (group.parameter, set)));
    }
    let (dofs, fixed) = faults.finish(dofs.zip(fixed))?;
    let matrices = ExternalMatrices {
        title: file.title.unwrap_or_else(|| "matrices".to_owned()),
        dofs,
        fixed,
        parameters: file.parameters,
        groups,
        damping: StatedDamping {
            mass_per_s: file.damping.mass_per_s,
            stiffness_s: file.damping.stiffness_s,
            ratios: file.damping.ratios,
        },
        support: file.support,
    };
    ExternalModel::new(matrices).map_err(|source| model_error(path, source))
}

/// Reads the matrices that a file names.
struct Reader<'a> {
    path: &'a str,
    folder: &'a Path,
    /// Number of degrees of freedom; `None` where their list has a fault.
    size: Option<usize>,
}

impl Reader<'_> {
    /// Mass, damping and stiffness under a key.
    fn set(&self, key: &str, parts: [&Option<MatrixFile>; 3]) -> Result<MatrixSet, SceneError> {
        let [mass, damping, stiffness] = parts.map(Option::as_ref);
        let mut faults = Faults::default();
        let mut read = |name: &str, file: Option<&MatrixFile>| {
            let file = file?;
            faults.take(self.matrix(&format!("{key} {name}"), &file.0))
        };
        let set = MatrixSet {
            mass: read("mass", mass),
            damping: read("damping", damping),
            stiffness: read("stiffness", stiffness),
        };
        faults.into_result().map(|()| set)
    }

    fn matrix(&self, key: &str, named: &NamedMatrix) -> Result<SparseMatrix, SceneError> {
        let file = self.folder.join(&named.file);
        let MatrixEntries {
            rows,
            columns,
            entries,
        } = read_matrix(&file, named.name.as_deref())?;
        let size = self.size.unwrap_or(rows);
        if rows != size || columns != size {
            let got = format!("{rows} x {columns} in {}", file.display());
            let expected = format!("{size} x {size}, one row for each degree of freedom");
            return Err(value_error(self.path, key, &got, &expected));
        }
        SparseMatrix::from_entries(size, &entries)
            .map_err(|source| model_error(self.path, source.into()))
    }
}

/// A degree of freedom on each line of a file, or several with commas or blanks between; what
/// follows `#` is a remark where a blank or nothing stands before it.
fn listed_dofs(path: &Path) -> Result<Vec<Dof>, SceneError> {
    let text = read_text(path)?;
    let mut dofs = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let words = content.split([',', ' ', '\t', '\r']);
        let words = words.filter(|word| !word.is_empty());
        for word in words.take_while(|word| !word.starts_with('#')) {
            let dof = word.parse::<Dof>().map_err(|error| IoError::Text {
                path: path.display().to_string(),
                line,
                what: "degree of freedom",
                // A file of another kind is not quoted: a scene may name any file.
                got: match dofs.is_empty() {
                    true => "another text".to_owned(),
                    false => error.got,
                },
                expected: error.expected.to_owned(),
            })?;
            dofs.push(dof);
        }
    }
    Ok(dofs)
}
