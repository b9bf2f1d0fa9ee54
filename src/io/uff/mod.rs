//! Universal files (UFF, UNV): reader and writer, one file per dataset number.
//!
//! A universal file is a row of datasets between lines `    -1`; the line behind the first of them is the dataset's number.
//!
//! | dataset | holds | read | written |
//! |---|---|---|---|
//! | 15, 2411 | nodes | yes | - |
//! | 58, 58b | functions and time records, as text or bytes | yes | yes |
//! | 82 | trace lines | yes | - |
//! | 151 | title | yes | yes |
//! | 164 | units | yes | yes |
//!
//! Any other number is passed over with a finding. Reading is free in form (CRLF or LF, any padding, fields off their
//! columns, `D` and three-digit exponents, wrong byte counts) and strict in meaning (no unit, step or type is guessed).

mod dataset_15;
mod dataset_151;
mod dataset_164;
mod dataset_2411;
mod dataset_58;
mod dataset_58_meaning;
mod dataset_58_samples;
mod dataset_58_write;
mod dataset_82;
mod dof_fields;
mod fields;
mod lines;
mod nodes;
mod scan;
mod scan_functions;
mod write;

#[cfg(test)]
mod damage_tests;
#[cfg(test)]
mod file_builder;
#[cfg(test)]
mod layout_tests;
#[cfg(test)]
mod mutation_tests;
#[cfg(test)]
mod recording_tests;
#[cfg(test)]
mod round_trip_tests;

pub use write::{Encoding, FileLabel, Precision, write_frfs, write_time_records};

use std::io::ErrorKind;
use std::ops::Range;

use super::{Block, Catalog, Confidence, Format, Hints, IoError, ReadSeek, Source};
use dataset_58_samples::{Samples, copy_text, read_binary, read_text};
use fields::{dataset_number, is_delimiter};

/// Name of the format.
const NAME: &str = "uff";

/// The universal file format.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uff;

impl Format for Uff {
    fn name(&self) -> &'static str {
        NAME
    }

    /// Certain when the first line that is not blank is `-1` and the next one a dataset number.
    fn detect(&self, head: &[u8]) -> Confidence {
        let mut lines = head
            .split(|byte| *byte == b'\n')
            .filter(|line| !line.trim_ascii().is_empty());
        let opened = lines.next().is_some_and(is_delimiter);
        let numbered = lines
            .next()
            .is_some_and(|line| dataset_number(line).is_some());
        if opened && numbered {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let scan = scan::scan(input, &hints.path)?;
        Ok(Box::new(UffSource {
            catalog: scan.catalog,
            samples: scan.samples,
            input: scan.input,
            last_text: None,
        }))
    }
}

/// An opened universal file.
struct UffSource {
    catalog: Catalog,
    samples: Vec<Samples>,
    input: Box<dyn ReadSeek>,
    /// Entry and numbers of the text block that was read last.
    last_text: Option<(usize, Vec<f64>)>,
}

impl UffSource {
    fn check(&self, entry: usize, range: &Range<usize>) -> Result<Samples, IoError> {
        let len = self.catalog.entries.get(entry).map_or(0, super::Entry::len);
        match self.samples.get(entry) {
            Some(samples) if range.start <= range.end && range.end <= len => Ok(*samples),
            _ => Err(IoError::Binary {
                path: self.catalog.path.clone(),
                byte: 0,
                what: "range of samples asked for",
                got: format!("{range:?} of entry {entry}"),
                expected: format!(
                    "at most {len} samples of one of {} entries",
                    self.samples.len()
                ),
            }),
        }
    }
}

impl Source for UffSource {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        std::mem::take(&mut self.catalog.damage)
    }

    fn read(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        let path = &self.catalog.path;
        match self.check(entry, &range)? {
            Samples::Binary(binary) => {
                let read = read_binary(self.input.as_mut(), &binary, range, block);
                read.map_err(|source| match source.kind() {
                    // The length was checked when the file was opened.
                    ErrorKind::UnexpectedEof => IoError::Truncated {
                        path: path.clone(),
                        byte: binary.byte,
                        what: "a binary block of dataset 58b",
                        got: "a file that became shorter since it was opened".to_owned(),
                        expected: "its samples".to_owned(),
                    },
                    _ => IoError::System {
                        path: path.clone(),
                        action: "read",
                        source,
                    },
                })
            }
            Samples::Text(text) => {
                if self.last_text.as_ref().map(|last| last.0) != Some(entry) {
                    let numbers = read_text(self.input.as_mut(), &text, path)?;
                    self.last_text = Some((entry, numbers));
                }
                if let Some((_, numbers)) = &self.last_text {
                    copy_text(numbers, text.format, range, block);
                }
                Ok(())
            }
        }
    }
}
