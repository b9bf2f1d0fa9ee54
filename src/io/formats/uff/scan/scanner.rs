//! The scanner reads a universal file line by line and keeps what its headers describe.

use std::collections::BTreeSet;
use std::io;

use super::raw_geometry::RawGeometry;
use crate::finding::{Code, Finding, Location, Severity};
use crate::io::formats::uff::dataset_58::binary_samples::Samples;
use crate::io::formats::uff::dataset_58::byte_order::Evidence;
use crate::io::formats::uff::dataset_58::{Header, function_type};
use crate::io::formats::uff::dataset_164::Units;
use crate::io::formats::uff::fields::delimiter::is_delimiter;
use crate::io::formats::uff::fields::lines::LineReader;
use crate::io::formats::uff::fields::{FieldError, Line, Position, dataset_number};
use crate::io::formats::uff::qualifiers::Qualifiers;
use crate::io::{Catalog, FunctionType, IoError, Part, ReadSeek};

/// Name of the format.
pub(in crate::io::formats::uff) const NAME: &str = "uff";

/// What the values of a binary entry show of its byte order.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByteOrder {
    pub evidence: Evidence,
    /// Number of the entry.
    pub entry: usize,
    /// Where its dataset begins.
    pub at: Position,
}

/// A pass over a file: its lines, and the contents of the datasets before them.
pub(super) struct Scanner {
    pub lines: LineReader<Box<dyn ReadSeek>>,
    pub path: String,
    pub catalog: Catalog,
    pub headers: Vec<Header>,
    pub samples: Vec<Samples>,
    /// What the values of binary entries show of their byte order.
    pub byte_orders: Vec<ByteOrder>,
    /// Units of the file, `None` where their dataset is damaged.
    pub units: Vec<(Position, Option<Units>)>,
    pub described: RawGeometry,
    /// Numbers of datasets that were passed over.
    pub unknown: BTreeSet<u32>,
    pub reported: BTreeSet<Code>,
    /// Number of datasets.
    pub datasets: usize,
    pub qualifiers: Qualifiers,
}

impl Scanner {
    pub fn new(lines: LineReader<Box<dyn ReadSeek>>, path: &str) -> Self {
        let catalog = Catalog {
            format: NAME,
            path: path.to_owned(),
            ..Catalog::default()
        };
        Self {
            lines,
            path: path.to_owned(),
            catalog,
            headers: Vec::new(),
            samples: Vec::new(),
            byte_orders: Vec::new(),
            units: Vec::new(),
            described: RawGeometry::default(),
            unknown: BTreeSet::new(),
            reported: BTreeSet::new(),
            datasets: 0,
            qualifiers: Qualifiers::default(),
        }
    }

    /// One line, of which nothing is known yet.
    pub fn line(&mut self) -> io::Result<Option<Line>> {
        let mut bytes = Vec::new();
        let at = self.lines.read_line_of_dataset(&mut bytes)?;
        Ok(at.map(|at| Line { at, bytes }))
    }

    /// Reports text that is not UTF-8 once.
    fn report_coding(&mut self, line: &Line) {
        if std::str::from_utf8(&line.bytes).is_err() && self.reported.insert(Code::HeaderNotUtf8) {
            let location = self.location(line.at);
            let finding = Finding::new(Severity::Info, Code::HeaderNotUtf8, location);
            self.catalog.findings.push(finding);
        }
    }

    /// The next lines, which may look like delimiters: `count` of them, or as many as the file has.
    pub fn available_lines(&mut self, count: usize) -> io::Result<Vec<Line>> {
        let mut lines = Vec::with_capacity(count);
        while lines.len() < count {
            let mut bytes = Vec::new();
            let Some(at) = self.lines.read_line(&mut bytes)? else {
                break;
            };
            lines.push(Line { at, bytes });
        }
        Ok(lines)
    }

    /// The next `count` lines, which may look like delimiters; `None` when the file ends before.
    pub fn header_lines(&mut self, count: usize) -> io::Result<Option<Vec<Line>>> {
        let lines = self.available_lines(count)?;
        lines.iter().for_each(|line| self.report_coding(line));
        if lines.len() < count {
            let got = format!("{} lines", lines.len());
            let part = header_part(&lines);
            let expected = format!("{count} lines");
            self.truncated("the header of dataset 58", got, expected, part);
            return Ok(None);
        }
        Ok(Some(lines))
    }

    /// The lines up to the delimiter; damage when the file ends before.
    pub fn collect(&mut self, part: Part) -> io::Result<Option<Vec<Line>>> {
        let mut lines = Vec::new();
        while let Some(line) = self.line()? {
            self.report_coding(&line);
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
        while let Some(at) = self.lines.read_line_of_dataset(&mut line)? {
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
        while let Some(at) = self.lines.read_line_of_dataset(&mut line)? {
            if let (Some(delimiter), Some(_)) = (before, dataset_number(&line)) {
                return self.lines.go_to(delimiter);
            }
            before = is_delimiter(&line).then_some(at);
        }
        Ok(())
    }

    pub fn location(&self, at: Position) -> Location {
        Location::File {
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
        let location = self.location(at);
        self.catalog.note_damage_at(error, part, location);
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

/// The type of the function with these header lines, as far as record 6 can be read.
pub(super) fn header_part(lines: &[Line]) -> Part {
    lines
        .get(5)
        .and_then(function_type)
        .map_or(Part::Function, |code| {
            Part::of_function(FunctionType::from_code(code))
        })
}
