//! A modal model as a source.

use crate::io::{Catalog, MemorySource, ModeEntry};
use crate::modal::ModalModel;

/// A modal model as a source of modes, for a writer.
pub fn modes_source(model: &ModalModel, title: &str) -> MemorySource {
    MemorySource {
        catalog: Catalog {
            format: "modes",
            title: vec![title.to_owned()],
            modes: model.modes.iter().cloned().map(ModeEntry::new).collect(),
            ..Catalog::default()
        },
        ..MemorySource::default()
    }
}
