//! The modes of a catalogue become a modal model.

use crate::io::Catalog;
use crate::modal::{InputFile, ModalModel};

/// The modes of a file as a modal model, in ascending frequency.
pub fn modal_model_of(catalog: &Catalog, inputs: Vec<InputFile>) -> ModalModel {
    let mut modes: Vec<_> = catalog
        .modes
        .iter()
        .map(|entry| entry.mode.clone())
        .collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        inputs,
        modes,
        findings: catalog.findings.clone(),
        ..ModalModel::default()
    }
}
