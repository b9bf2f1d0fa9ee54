//! Provenance of a result: files with their fingerprints, options as stated, seeds.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::{IoError, read_input, sha256_of_bytes};

use super::super::SceneError;
use super::super::model_name::{is_built_in, named_model};
use super::super::plan::Scene;
use super::super::recording::load_synth;
use super::super::result::SceneResult;
use super::super::test_plan::TestSource;

/// Maximum length of a text that is shown; of a longer one only the name is given.
const MAX_TEXT_BYTES: usize = 60_000;

/// Provenance of a result.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// Program and version.
    pub producer: String,
    /// Name of the model, where it is built in.
    pub model: Option<String>,
    /// The files that state the run: scene, model, specs of synthetic tests.
    pub stated: Vec<SourceFile>,
    /// The files or recordings of the tests: test, path, SHA-256.
    pub inputs: Vec<[String; 3]>,
    /// Seeds of synthetic recordings by test.
    pub seeds: Vec<(String, u64)>,
    /// Method of identification and band searched, by test.
    pub searched: Vec<[String; 3]>,
}

/// A file of options with its text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFile {
    /// Path as given.
    pub path: String,
    /// SHA-256 of its bytes, lower-case hexadecimal.
    pub sha256: String,
    /// Its text; `None` for one that is long or no text.
    pub text: Option<String>,
}

/// Inputs of a scene.
pub(super) fn provenance(scene: &Scene, result: &SceneResult) -> Result<Provenance, SceneError> {
    let mut stated = vec![source_file(&scene.file)?];
    let mut model = None;
    if let Some(table) = &scene.model {
        let named = named_model(table, &scene.folder, &scene.path)?;
        match is_built_in(&named) {
            true => model = Some(named.display().to_string()),
            false => stated.push(source_file(&named)?),
        }
    }
    let mut seeds = Vec::new();
    for test in &scene.tests {
        if let TestSource::Synth(path) = &test.source {
            stated.push(source_file(path)?);
            seeds.push((test.name.clone(), load_synth(path)?.seed));
        }
    }
    let mut inputs = Vec::new();
    let mut searched = Vec::new();
    for test in &result.tests {
        let input_files = test.modes.inputs.iter();
        inputs.extend(
            input_files.map(|file| [test.name.clone(), file.path.clone(), file.sha256.clone()]),
        );
        let method = test.modes.modes.iter().find_map(|mode| mode.method.clone());
        let band = test.modes.band;
        searched.push([
            test.name.clone(),
            method.unwrap_or_else(|| "—".to_owned()),
            band.map_or_else(|| "—".to_owned(), |b| format!("{} – {}", b.lo_hz, b.hi_hz)),
        ]);
    }
    Ok(Provenance {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        model,
        stated,
        inputs,
        seeds,
        searched,
    })
}

fn source_file(path: &Path) -> Result<SourceFile, SceneError> {
    let name = path.display().to_string();
    let bytes = read_input(path).map_err(|source| IoError::System {
        path: name.clone(),
        action: "read",
        source,
    })?;
    let sha256 = sha256_of_bytes(&bytes);
    let short = bytes.len() <= MAX_TEXT_BYTES;
    Ok(SourceFile {
        path: name,
        sha256,
        text: String::from_utf8(bytes).ok().filter(|_| short),
    })
}
