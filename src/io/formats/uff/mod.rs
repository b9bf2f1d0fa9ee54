//! Universal files (UFF, UNV): reader and writer, one file or folder per dataset number.
//!
//! `fields` parses lines and knows no dataset; `scan` passes over the headers of a file. Functions
//! are in `dataset_58`, modes (55, 2414) in `modes`; nodes, coordinate systems, trace lines,
//! elements and groups in `geometry`.
//!
//! A universal file is a sequence of datasets between lines `    -1`; the line after the first of
//! them is the number of the dataset.
//!
//! | dataset | holds | read | written |
//! |---|---|---|---|
//! | 15, 781 | nodes | yes | as 2411 |
//! | 18 | coordinate systems by points | yes | as 2420 |
//! | 55 | data at nodes: modes; other analyses are passed over | yes | yes |
//! | 58, 58b | functions and time records, as text or bytes | yes | yes |
//! | 82 | trace lines | yes | yes |
//! | 151 | title | yes | yes |
//! | 164 | units | yes | yes |
//! | 1858 | qualifiers of a function: its window | yes | yes |
//! | 2400 | head of a model: its name | yes | - |
//! | 2411 | nodes, double precision | yes | yes |
//! | 2412 | elements | yes | yes |
//! | 2414 | analysis data: modes at nodes; others are passed over | yes | as 55 |
//! | 2417, 2429, 2430, 2432, 2435, 2452, 2477 | groups | yes | as 2467 |
//! | 2420 | coordinate systems | yes | yes |
//! | 2467 | groups | yes | yes |
//!
//! Any other number is passed over with a finding. Reading is free in form (UTF-8, Latin-1 or
//! UTF-16, CRLF, LF or CR, files joined without a line end, any padding, fields off their columns,
//! `D` and three-digit exponents, wrong byte counts, a wrong byte order) and strict in meaning (no
//! unit, step or type is guessed).

mod dataset_151;
mod dataset_164;
mod dataset_1858;
mod dataset_2400;
mod dataset_58;
mod fields;
mod geometry;
mod modes;
mod qualifiers;
mod scan;
#[cfg(test)]
mod tests;
mod write;

pub use write::{FileLabel, write_frfs, write_time_records};

use std::io::{BufWriter, ErrorKind, Write};
use std::ops::Range;

use crate::finding::Finding;
use crate::io::error::write_failed;
use crate::io::formats::text_coding::{decoded_head, without_utf_16};
use crate::io::{
    Block, Catalog, Confidence, Format, Hints, IoError, ReadSeek, Source, WriteOptions, WriteSeek,
};
use dataset_58::binary_samples::{BinaryBlock, Input, Samples, read_abscissa, read_binary};
use dataset_58::text_samples::{TextBlock, copy_abscissa, copy_text, read_text};
use fields::dataset_number;
use fields::delimiter::{is_delimiter, without_padding};
use scan::scanner::NAME;

/// The universal file format.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uff;

impl Format for Uff {
    fn name(&self) -> &'static str {
        NAME
    }

    fn written_extensions(&self) -> &'static [&'static str] {
        &["uff", "unv", "ufb"]
    }

    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        let mut buffered = BufWriter::new(out);
        let findings = write::write_source(&mut buffered, source, options, false)?;
        let flushed = buffered.flush();
        flushed.map_err(|source| write_failed(&options.path, source))?;
        Ok(findings)
    }

    /// Certain when the first line that is not blank is `-1` and the next one a dataset number, or
    /// when a dataset that is read begins so behind lines of text, as in files that were joined
    /// with a title for each.
    fn detect(&self, head: &[u8]) -> Confidence {
        let head = decoded_head(head);
        let lines = head.split(|byte| matches!(byte, b'\r' | b'\n'));
        let lines: Vec<&[u8]> = lines
            .filter(|line| !without_padding(line).is_empty())
            .collect();
        let is_text =
            |line: &&&[u8]| line.iter().any(u8::is_ascii_alphabetic) || line.contains(&b'=');
        let titles = lines.iter().take_while(is_text).count();
        let number = match lines.get(titles..titles + 2) {
            Some([opening, number]) if is_delimiter(opening) => dataset_number(number),
            _ => None,
        };
        match number {
            Some(_) if titles == 0 => Confidence::Certain,
            Some((number, _)) if DATASETS_BEHIND_TEXT.contains(&number) => Confidence::Certain,
            _ => Confidence::No,
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let input = without_utf_16(input).map_err(|source| IoError::System {
            path: hints.path.clone(),
            action: "read",
            source,
        })?;
        let scan = scan::scan(input, &hints.path)?;
        Ok(Box::new(UffSource {
            catalog: scan.catalog,
            samples: scan.samples,
            abscissa_scales: scan.abscissa_scales,
            input: Input::new(scan.input),
            last_text: None,
        }))
    }
}

/// Datasets that show a universal file behind lines of text. All numbers would be too many: a
/// heading and a column of whole numbers, `count`, `-1`, `3`, is a table
/// (`text_before_the_first_dataset_hides_no_universal_file`).
const DATASETS_BEHIND_TEXT: [u32; 9] = [15, 55, 58, 82, 151, 164, 2411, 2412, 2414];

/// An opened universal file.
struct UffSource {
    catalog: Catalog,
    samples: Vec<Samples>,
    /// Factor of each entry's stored abscissae to s or Hz.
    abscissa_scales: Vec<f64>,
    input: Input,
    /// Entry and numbers of the text block that was read last.
    last_text: Option<(usize, Vec<f64>)>,
}

impl UffSource {
    /// The numbers of a text block.
    fn numbers(&mut self, entry: usize, text: &TextBlock) -> Result<&[f64], IoError> {
        if self.last_text.as_ref().map(|last| last.0) != Some(entry) {
            let stream = self.input.anywhere();
            let numbers = read_text(stream, text, false, &self.catalog.path)?;
            self.last_text = Some((entry, numbers.values));
        }
        let numbers = self.last_text.as_ref().map(|last| last.1.as_slice());
        Ok(numbers.unwrap_or_default())
    }

    /// The length was checked when the file was opened.
    fn read_failed(&self, from: &BinaryBlock, source: std::io::Error) -> IoError {
        let path = self.catalog.path.clone();
        match source.kind() {
            ErrorKind::UnexpectedEof => IoError::Truncated {
                path,
                byte: from.byte,
                what: "a binary block of dataset 58b",
                got: "a file that became shorter since it was opened".to_owned(),
                expected: "its samples".to_owned(),
            },
            _ => IoError::System {
                path,
                action: "read",
                source,
            },
        }
    }
}

impl Source for UffSource {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn catalog_mut(&mut self) -> &mut Catalog {
        &mut self.catalog
    }

    fn read_samples(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        match self.samples[entry] {
            Samples::Binary(binary) => read_binary(&mut self.input, &binary, range, block)
                .map_err(|source| self.read_failed(&binary, source)),
            Samples::Text(text) => {
                copy_text(self.numbers(entry, &text)?, &text, range, block);
                Ok(())
            }
        }
    }

    fn read_abscissa(
        &mut self,
        entry: usize,
        range: Range<usize>,
        out: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        match self.samples[entry] {
            Samples::Binary(binary) => read_abscissa(&mut self.input, &binary, range, out)
                .map_err(|source| self.read_failed(&binary, source))?,
            Samples::Text(text) => copy_abscissa(self.numbers(entry, &text)?, &text, range, out),
        }
        let scale = self.abscissa_scales[entry];
        if (scale - 1.0).abs() > 0.0 {
            out.iter_mut().for_each(|value| *value *= scale);
        }
        Ok(())
    }
}
