//! One pass over the headers of a file: delimiters and the datasets between them (functions:
//! `scan_functions`, nodes and modes: `scan_geometry`).
//!
//! Binary blocks are jumped over by their length, never searched. A dataset that cannot be read
//! becomes damage with its place, and the pass goes on behind it. Knows the layout of no dataset.

use std::collections::BTreeSet;
use std::io;

use super::dataset_58::{Header, function_type};
use super::dataset_58_axis::domain;
use super::dataset_58_meaning::set_units;
use super::dataset_58_samples::Samples;
use super::dataset_164::Units;
use super::fields::{FieldError, Line, Position, dataset_number, is_delimiter};
use super::lines::LineReader;
use super::scan_functions::Qualifiers;
use super::scan_geometry::{RawGeometry, is_geometry};
use super::{dataset_151, dataset_164};
use crate::finding::{Code, Finding, Place, Severity};
use crate::io::{Catalog, FunctionType, IoError, Part, ReadSeek};

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

pub(super) struct Scanner {
    pub lines: LineReader<Box<dyn ReadSeek>>,
    pub path: String,
    pub catalog: Catalog,
    pub headers: Vec<Header>,
    pub samples: Vec<Samples>,
    /// Units of the file, `None` where their dataset is damaged.
    pub units: Vec<(Position, Option<Units>)>,
    pub described: RawGeometry,
    unknown: BTreeSet<u32>,
    pub reported: BTreeSet<Code>,
    datasets: usize,
    pub qualifiers: Qualifiers,
}

impl Scanner {
    fn new(lines: LineReader<Box<dyn ReadSeek>>, path: &str) -> Self {
        let catalog = Catalog {
            format: super::NAME,
            path: path.to_owned(),
            ..Catalog::default()
        };
        Self {
            lines,
            path: path.to_owned(),
            catalog,
            headers: Vec::new(),
            samples: Vec::new(),
            units: Vec::new(),
            described: RawGeometry::default(),
            unknown: BTreeSet::new(),
            reported: BTreeSet::new(),
            datasets: 0,
            qualifiers: Qualifiers::default(),
        }
    }

    /// Finds the datasets: a delimiter, a line with their number, their lines, a delimiter.
    fn datasets(&mut self) -> io::Result<()> {
        let (mut opened, mut stray) = (false, false);
        while let Some(line) = self.line()? {
            if is_delimiter(&line.bytes) {
                opened = true;
            } else if line.bytes.trim_ascii().is_empty() {
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
            _ => {
                if self.unknown.insert(number) {
                    let finding =
                        Finding::new(Severity::Info, Code::UnknownDataset, self.place(first.at));
                    self.catalog
                        .findings
                        .push(finding.value(f64::from(number), ""));
                }
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

    /// One line, of which nothing is known yet.
    pub fn line(&mut self) -> io::Result<Option<Line>> {
        let mut bytes = Vec::new();
        let at = self.lines.read_line(&mut bytes)?;
        Ok(at.map(|at| Line { at, bytes }))
    }

    /// One line of a header; text that is not UTF-8 is reported once.
    fn header_line(&mut self) -> io::Result<Option<Line>> {
        let line = self.line()?;
        if let Some(line) = &line
            && std::str::from_utf8(&line.bytes).is_err()
            && self.reported.insert(Code::HeaderNotUtf8)
        {
            let place = self.place(line.at);
            let finding = Finding::new(Severity::Info, Code::HeaderNotUtf8, place);
            self.catalog.findings.push(finding);
        }
        Ok(line)
    }

    /// The next `count` lines, which may look like delimiters; `None` when the file ends before.
    pub fn header_lines(&mut self, count: usize) -> io::Result<Option<Vec<Line>>> {
        let mut lines = Vec::with_capacity(count);
        while lines.len() < count {
            let Some(line) = self.header_line()? else {
                let got = format!("{} lines", lines.len());
                let part = header_part(&lines);
                let expected = format!("{count} lines");
                self.truncated("the header of dataset 58", got, expected, part);
                return Ok(None);
            };
            lines.push(line);
        }
        Ok(Some(lines))
    }

    /// The lines up to the delimiter; damage when the file ends before.
    fn collect(&mut self, part: Part) -> io::Result<Option<Vec<Line>>> {
        let mut lines = Vec::new();
        while let Some(line) = self.header_line()? {
            if is_delimiter(&line.bytes) {
                return Ok(Some(lines));
            }
            lines.push(line);
        }
        self.no_end(part);
        Ok(None)
    }

    /// Passes over lines up to and with the delimiter, and says where it starts.
    pub fn find_delimiter(&mut self) -> io::Result<Option<u64>> {
        let mut line = Vec::new();
        while let Some(at) = self.lines.read_line(&mut line)? {
            if is_delimiter(&line) {
                return Ok(Some(at.byte));
            }
        }
        Ok(None)
    }

    /// Passes over the delimiter that stands here, or over nothing at the end of the file.
    pub fn close(&mut self) -> io::Result<()> {
        self.line().map(|_| ())
    }

    /// Searches the start of the next dataset: a delimiter with a dataset's number on the line
    /// behind it.
    pub fn resynchronise(&mut self) -> io::Result<()> {
        let mut before: Option<Position> = None;
        let mut line = Vec::new();
        while let Some(at) = self.lines.read_line(&mut line)? {
            if let (Some(delimiter), Some(_)) = (before, dataset_number(&line)) {
                return self.lines.go_to(delimiter);
            }
            before = is_delimiter(&line).then_some(at);
        }
        Ok(())
    }

    pub fn place(&self, at: Position) -> Place {
        Place::File {
            path: self.path.clone(),
            line: at.line,
            byte: at.line.is_none().then_some(at.byte),
        }
    }

    pub fn damaged(&mut self, error: FieldError, part: Part) {
        let at = error.at;
        self.push_damage(error.in_file(&self.path), at, part);
    }

    pub fn no_end(&mut self, part: Part) {
        let got = "the end of the file".to_owned();
        let expected = "the delimiter `    -1`".to_owned();
        self.truncated("a dataset", got, expected, part);
    }

    fn truncated(&mut self, what: &'static str, got: String, expected: String, part: Part) {
        let byte = self.lines.end();
        let error = IoError::Truncated {
            path: self.path.clone(),
            byte,
            what,
            got,
            expected,
        };
        self.push_damage(error, Position { line: None, byte }, part);
    }

    pub fn push_damage(&mut self, error: IoError, at: Position, part: Part) {
        let place = self.place(at);
        self.catalog.note_damage_at(error, part, place);
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
        self.place_geometry();
        Ok(Scan {
            abscissa_scales: self.headers.iter().map(|header| domain(header).1).collect(),
            catalog: self.catalog,
            samples: self.samples,
            input: self.lines.into_input(),
        })
    }
}

/// The units that stand last before a byte, else the first of the file; `None` where these are
/// damaged.
pub(super) fn units_at(units: &[(Position, Option<Units>)], byte: u64) -> Option<&Units> {
    let before = units.iter().rev().find(|(at, _)| at.byte < byte);
    before
        .or(units.first())
        .and_then(|(_, units)| units.as_ref())
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

/// The type of the function with these header lines, as far as record 6 can be read.
pub(super) fn header_part(lines: &[Line]) -> Part {
    lines
        .get(5)
        .and_then(function_type)
        .map_or(Part::Function, |code| {
            Part::of_function(FunctionType::from_code(code))
        })
}
