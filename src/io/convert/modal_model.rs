//! The modes of a catalogue become a modal model.

use crate::io::Catalog;
use crate::linalg::sort_ascending_by;
use crate::modal::{InputFile, ModalModel};

/// The modes of a file as a modal model, in ascending frequency.
pub fn modal_model_of(catalog: &Catalog, inputs: Vec<InputFile>) -> ModalModel {
    let mut modes: Vec<_> = catalog
        .modes
        .iter()
        .map(|entry| entry.mode.clone())
        .collect();
    sort_ascending_by(&mut modes, |mode| mode.frequency_hz);
    ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        inputs,
        modes,
        findings: catalog.findings.clone(),
        ..ModalModel::default()
    }
}
