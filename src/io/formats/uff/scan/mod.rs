//! One pass over the headers of a file: delimiters and the datasets between them (`functions`: FRFs
//! and records; `byte_orders`: the order of their bytes; `geometry`: nodes and modes).
//!
//! Binary blocks are jumped over by their length, never searched. A dataset that cannot be read
//! becomes damage with its place, and the pass goes on behind it. Knows the layout of no dataset.

mod byte_orders;
mod functions;
mod geometry;
mod raw_geometry;
pub(super) mod scanner;
mod uneven_axis;

use std::io;

use super::dataset_58::axis::domain;
use super::dataset_58::binary_samples::Samples;
use super::dataset_58::meaning::set_units;
use super::fields::delimiter::{is_delimiter, without_padding};
use super::fields::lines::LineReader;
use super::fields::{FieldError, Line, Position, dataset_number};
use super::{dataset_151, dataset_164};
use crate::finding::{Code, Finding, Severity};
use crate::io::{Catalog, IoError, Part, ReadSeek};
use geometry::is_geometry;
use scanner::{Scanner, units_at};

/// The result of a pass over a file.
pub(super) struct Scan {
    pub catalog: Catalog,
    /// Where the samples of each entry are.
    pub samples: Vec<Samples>,
    /// Factor of each entry's stored abscissae to s or Hz.
    pub abscissa_scales: Vec<f64>,
    pub input: Box<dyn ReadSeek>,
}

/// Scans a file.
///
/// # Errors
/// [`IoError::System`] when it cannot be read, [`IoError::Text`] when it holds no dataset.
pub(super) fn scan(input: Box<dyn ReadSeek>, path: &str) -> Result<Scan, IoError> {
    let system = |source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    };
    let lines = LineReader::new(input).map_err(system)?;
    let mut scanner = Scanner::new(lines, path);
    scanner.datasets().map_err(system)?;
    scanner.finish()
}

impl Scanner {
    /// Finds the datasets: a delimiter, a line with their number, their lines, a delimiter.
    fn datasets(&mut self) -> io::Result<()> {
        let (mut opened, mut stray) = (false, false);
        loop {
            self.lines.adapt_line_end()?;
            let Some(line) = self.line()? else { break };
            if is_delimiter(&line.bytes) {
                opened = true;
            } else if without_padding(&line.bytes).is_empty() {
                continue;
            } else if let (true, Some((number, binary))) = (opened, dataset_number(&line.bytes)) {
                (opened, stray) = (false, false);
                self.datasets += 1;
                self.dataset(&line, number, binary)?;
            } else {
                if !stray {
                    let expected = if opened {
                        "a dataset number"
                    } else {
                        "`    -1`"
                    };
                    let error = FieldError::line(&line, "text between datasets", expected);
                    self.damaged(error, Part::Any);
                }
                (opened, stray) = (false, true);
            }
        }
        Ok(())
    }

    fn dataset(&mut self, first: &Line, number: u32, binary: bool) -> io::Result<()> {
        match (number, binary) {
            (58, false) => self.text_function(first),
            (58, true) => self.binary_function(first),
            (151 | 164 | 1858, false) => {
                if let Some(lines) = self.collect(part_of(number))? {
                    let read = self.head_dataset(number, &lines, first);
                    read.unwrap_or_else(|error| self.damaged(error, part_of(number)));
                }
                Ok(())
            }
            (number, false) if is_geometry(number) => {
                if let Some(lines) = self.collect(part_of(number))? {
                    let read = self.geometry_dataset(number, &lines, first);
                    read.unwrap_or_else(|error| self.damaged(error, part_of(number)));
                }
                Ok(())
            }
            (_, binary) => {
                if self.unknown.insert(number) {
                    let finding = Finding::new(
                        Severity::Info,
                        Code::UnknownDataset,
                        self.location(first.at),
                    );
                    self.catalog
                        .findings
                        .push(finding.value(f64::from(number), ""));
                }
                let start = self.lines.position();
                if binary && self.pass_over_binary(first)? {
                    return Ok(());
                }
                self.lines.go_to(start)?;
                if self.find_delimiter()?.is_none() {
                    self.no_end(Part::Other);
                }
                Ok(())
            }
        }
    }

    fn head_dataset(
        &mut self,
        number: u32,
        lines: &[Line],
        first: &Line,
    ) -> Result<(), FieldError> {
        match number {
            164 => {
                let units = dataset_164::units(lines, first);
                self.units.push((first.at, units.as_ref().ok().copied()));
                units?;
            }
            1858 => self.qualify(lines, first)?,
            _ if self.catalog.title.is_empty() => self.catalog.title = dataset_151::title(lines),
            _ => {}
        }
        Ok(())
    }

    /// Puts units, nodes and entries together, for dataset 164 may stand behind what it applies to.
    fn finish(mut self) -> Result<Scan, IoError> {
        if self.datasets == 0 {
            let nothing = FieldError {
                at: Position {
                    line: Some(1),
                    byte: 0,
                },
                what: "first line of a universal file",
                got: "no dataset".to_owned(),
                expected: "the delimiter `    -1`".to_owned(),
            };
            let first = self.catalog.damage.into_iter().next();
            let first = first.map(|damaged| damaged.error);
            return Err(first.unwrap_or_else(|| nothing.in_file(&self.path)));
        }
        for (entry, header) in self.catalog.entries.iter_mut().zip(&self.headers) {
            set_units(entry, header, units_at(&self.units, header.at.byte));
        }
        self.settle_byte_orders();
        self.place_geometry();
        Ok(Scan {
            abscissa_scales: self.headers.iter().map(|header| domain(header).1).collect(),
            catalog: self.catalog,
            samples: self.samples,
            input: self.lines.into_input(),
        })
    }
}

/// The contents of the dataset of a number.
fn part_of(number: u32) -> Part {
    match number {
        55 | 2414 => Part::Mode,
        15 | 781 | 2411 => Part::Nodes,
        18 | 2420 => Part::Systems,
        164 => Part::Units,
        _ => Part::Other,
    }
}
