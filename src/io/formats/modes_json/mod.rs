//! `modes.json`, the modal model as a file, in the schema `modalign-modes/1`.

pub(in crate::io) mod schema;

use crate::finding::Finding;

use super::dropped_content::DroppedContent;
use super::text_coding::{decoded_bytes, decoded_head};
use crate::io::{
    Catalog, Confidence, Format, Hints, IoError, MemorySource, ModeEntry, ReadSeek, Source,
    WriteOptions, WriteSeek, modal_model_of,
};
use schema::{modes_from_json, modes_to_json};

/// Finished modes in the schema `modalign-modes/1`.
pub struct ModesJson;

/// A text as it is quoted in JSON begins the schema.
const MARK: &[u8] = b"\"modalign-modes/";

impl Format for ModesJson {
    fn name(&self) -> &'static str {
        "modes"
    }

    fn written_extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    /// Certain for an object whose beginning names the schema.
    fn detect(&self, head: &[u8]) -> Confidence {
        let head = decoded_head(head);
        let object = head.trim_ascii_start().starts_with(b"{");
        if object && memchr::memmem::find(&head, MARK).is_some() {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let bytes = decoded_bytes(input, &hints.path)?;
        let text = String::from_utf8(bytes).map_err(|error| IoError::Binary {
            path: hints.path.clone(),
            byte: error.utf8_error().valid_up_to() as u64,
            what: "text",
            got: "a byte that is not UTF-8".to_owned(),
            expected: "UTF-8 text".to_owned(),
        })?;
        let model = modes_from_json(&text, &hints.path)?;
        Ok(Box::new(MemorySource {
            catalog: Catalog {
                format: "modes",
                path: hints.path.clone(),
                modes: model.modes.into_iter().map(ModeEntry::new).collect(),
                findings: model.findings,
                ..Catalog::default()
            },
            ..MemorySource::default()
        }))
    }

    /// Writes the modes; records, functions, geometry and arrays are not carried.
    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        let catalog = source.catalog();
        if catalog.modes.is_empty() {
            return Err(IoError::Unwritable {
                path: options.path.clone(),
                what: "modes",
                got: format!(
                    "a file with {} records and functions and no modes",
                    catalog.entries.len()
                ),
                expected: "modes; identify them first".to_owned(),
            });
        }
        let model = modal_model_of(catalog, Vec::new());
        out.write_all(modes_to_json(&model, None).as_bytes())
            .map_err(|source| IoError::System {
                path: options.path.clone(),
                action: "write",
                source,
            })?;
        let mut lost = DroppedContent::default();
        lost.add("records and functions", catalog.entries.len());
        lost.add("geometry", catalog.geometry.len());
        lost.add("arrays without a meaning", catalog.arrays.len());
        let count =
            |has: fn(&ModeEntry) -> bool| catalog.modes.iter().filter(|entry| has(entry)).count();
        lost.add(
            "modal A or B",
            count(|entry| entry.modal_a.or(entry.modal_b).is_some()),
        );
        lost.add("titles of modes", count(|entry| !entry.title.is_empty()));
        Ok(lost.findings())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::modes_source;
    use crate::modal::{ModalModel, Mode, ModeShape, Scaling};
    use std::io::Cursor;

    #[test]
    fn modes_are_written_as_they_are_read_and_functions_are_refused() {
        let shape = ModeShape::new([("1:+Z".parse().unwrap(), num_complex::Complex64::i())]);
        let modes =
            [20.0, 10.0].map(|hz| Mode::new(hz, Some(0.01), shape.clone(), Scaling::UnitMax));
        let model = ModalModel {
            modes: modes.to_vec(),
            ..ModalModel::default()
        };
        let mut bytes = Cursor::new(Vec::new());
        let mut source = modes_source(&model, "two");
        let findings = ModesJson
            .write(&mut bytes, &mut source, &WriteOptions::default())
            .unwrap();
        assert!(findings.is_empty());
        assert_eq!(ModesJson.detect(bytes.get_ref()), Confidence::Certain);
        let read = ModesJson
            .open(Box::new(Cursor::new(bytes.into_inner())), &Hints::default())
            .unwrap();
        let read: Vec<_> = read
            .catalog()
            .modes
            .iter()
            .map(|entry| &entry.mode)
            .collect();
        assert_eq!(read, [&modes[1], &modes[0]]);
        let mut none = MemorySource::default();
        let error = ModesJson.write(
            &mut Cursor::new(Vec::new()),
            &mut none,
            &WriteOptions::default(),
        );
        assert!(error.unwrap_err().to_string().contains("no modes"));
    }

    #[test]
    fn modes_are_read_in_every_coding_of_text() {
        let json =
            r#"{"schema": "modalign-modes/1", "modes": [{"frequency_hz": 20.0, "shape": {}}]}"#;
        let marked = format!("\u{feff}{json}");
        let utf_16 = |turn: fn(u16) -> [u8; 2]| marked.encode_utf16().flat_map(turn).collect();
        let texts: [Vec<u8>; 4] = [
            marked.clone().into_bytes(),
            utf_16(u16::to_le_bytes),
            utf_16(u16::to_be_bytes),
            format!("{json}\r\n\u{1a}").into_bytes(),
        ];
        for bytes in texts {
            assert_eq!(ModesJson.detect(&bytes), Confidence::Certain);
            let read = ModesJson.open(Box::new(Cursor::new(bytes)), &Hints::default());
            let frequency_hz = read.unwrap().catalog().modes[0].mode.frequency_hz;
            assert_eq!(frequency_hz.to_bits(), 20_f64.to_bits());
        }
    }
}
