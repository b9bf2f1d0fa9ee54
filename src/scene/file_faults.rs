//! Faults of the files that a scene names: its model, the specs of its synthetic tests, and its
//! recordings.

use std::path::Path;

use crate::geometry::Sensor;
use crate::io::IoError;

use super::error::SceneError;
use super::faults::Faults;
use super::ingest::{IngestOptions, check_files};
use super::model::{OpenedModel, open_model};
use super::modes_file::{ModesOptions, load_modes};
use super::recording::{hammer_test, load_synth};
use super::test_plan::{TestSource, listed_files, test_source};
use super::typed::SceneFile;
use super::update_options::check_parameter_names;

/// Collects the faults of the files of a scene that has faults itself.
pub(super) fn collect_file_faults(
    typed: &SceneFile,
    folder: &Path,
    path: &str,
    sensors: &[Sensor],
    faults: &mut Faults<SceneError>,
) {
    if let Some(table) = &typed.model {
        let opened = faults.take(open_model(table, folder, path, sensors));
        if let (Some(OpenedModel::Model(model)), Some(update)) = (&opened, &typed.update)
            && typed.configuration.is_empty()
        {
            let parameters = model.model.parameters();
            faults.take(check_parameter_names(update, parameters, path));
        }
    }
    for test in &typed.test {
        // Faults of the table are known already; the files that it lists may have further ones.
        match test_source(test, folder, path) {
            Ok(source) => collect_source_faults(&source, test.partial, path, faults),
            Err(_) => {
                let options = IngestOptions {
                    typed: Some(test),
                    partial: test.partial,
                    scene: path,
                    ..IngestOptions::default()
                };
                faults.take(check_files(&listed_files(test, folder, path).0, &options));
            }
        }
    }
}

/// Collects the faults of the files of a test.
pub(super) fn collect_source_faults(
    source: &TestSource,
    partial: bool,
    scene: &str,
    faults: &mut Faults<SceneError>,
) {
    match source {
        TestSource::Modes(path) => {
            let options = ModesOptions {
                partial,
                ..ModesOptions::default()
            };
            faults.take(load_modes(path, &options));
        }
        TestSource::Synth(path) => {
            let spec = load_synth(path);
            faults.take(spec.and_then(|spec| hammer_test(&spec, path)));
        }
        TestSource::Files {
            files,
            hits,
            trigger,
            typed,
        } => {
            let options = IngestOptions {
                hits: *hits,
                trigger: *trigger,
                typed: Some(typed.as_ref()),
                partial,
                scene,
                ..IngestOptions::default()
            };
            faults.take(check_files(files, &options));
        }
    }
}

/// The files of the sources that do not exist.
///
/// # Errors
/// All of them.
pub(super) fn check_existence<'s>(
    sources: impl IntoIterator<Item = &'s TestSource>,
) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    for source in sources {
        let paths: Vec<&Path> = match source {
            TestSource::Modes(path) | TestSource::Synth(path) => vec![path],
            TestSource::Files { files, .. } => files.iter().map(|file| &*file.path).collect(),
        };
        for path in paths {
            let opened = path.metadata().map_err(|source| IoError::System {
                path: path.display().to_string(),
                action: "open",
                source,
            });
            faults.take(opened.map_err(SceneError::from));
        }
    }
    faults.into_result()
}
