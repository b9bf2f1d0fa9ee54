//! The part of the pass over a file that finds functions (dataset 58), their qualifiers (1858) and
//! where their samples are.
//!
//! A text block ends at the next delimiter; its numbers are counted when they are read. A binary
//! block ends where its length puts a delimiter. Values with an uneven abscissa are read here
//! already, for they say what axis it is.

use std::io;

use super::scanner::{ByteOrder, Scanner, header_part};
use super::uneven_axis::{binary_abscissae, text_abscissae};
use crate::finding::{Code, Finding, Severity};
use crate::io::formats::uff::dataset_58::axis::{Abscissae, has_unknown_unit};
use crate::io::formats::uff::dataset_58::binary_samples::{BinaryBlock, Samples};
use crate::io::formats::uff::dataset_58::byte_order::Evidence;
use crate::io::formats::uff::dataset_58::meaning::{Meaning, meaning};
use crate::io::formats::uff::dataset_58::text_samples::{TextBlock, read_text};
use crate::io::formats::uff::dataset_58::value_width::value_bytes;
use crate::io::formats::uff::dataset_58::{
    BinaryLine, HEADER_LINES, Header, binary_extent, binary_line, header, spacing_record,
};
use crate::io::formats::uff::dataset_1858;
use crate::io::formats::uff::fields::delimiter::{
    appended_delimiter, is_delimiter, without_padding,
};
use crate::io::formats::uff::fields::{FieldError, Line, Position, dataset_number};
use crate::io::{EntryAxis, FunctionType, GeneralAxis, IoError, Part, SampleFormat};

impl Scanner {
    /// A function written as text: its end is the next delimiter behind the header.
    pub fn text_function(&mut self, first: &Line) -> io::Result<()> {
        self.qualifiers.begin();
        let start = self.lines.position();
        let Some(lines) = self.header_lines(HEADER_LINES)? else {
            self.lines.go_to(start)?;
            return self.find_delimiter().map(|_| ());
        };
        let header = match header(first.at, &lines) {
            Ok(header) => header,
            Err(error) => {
                self.damaged(error, header_part(&lines));
                self.lines.go_to(start)?;
                return self.find_delimiter().map(|_| ());
            }
        };
        let at = self.lines.position();
        match self.text_end(&header, at)? {
            Some(end) => {
                self.text_block(header, at, end)?;
                self.reopen(end)
            }
            None => self.unclosed_text(header, at),
        }
    }

    /// Passes over the numbers of a text block and its delimiter, and says where that starts.
    ///
    /// A delimiter may stand directly behind the last number, without a line end between them. It
    /// is one where the line behind it begins or ends a dataset and the numbers before it are as
    /// many as the header states.
    fn text_end(&mut self, header: &Header, at: Position) -> io::Result<Option<u64>> {
        let mut line = Vec::new();
        let mut appended: Option<u64> = None;
        let mut was_tried = false;
        loop {
            let read = self.lines.read_line_of_dataset(&mut line)?;
            if appended.is_some() && read.is_some() && without_padding(&line).is_empty() {
                continue;
            }
            let is_end = read.is_none() || is_delimiter(&line);
            if let Some(delimiter) = appended.take()
                && (is_end || (!was_tried && dataset_number(&line).is_some()))
            {
                was_tried = true;
                let behind = read.unwrap_or(self.lines.position());
                let block = self.text_block_to(header, at, delimiter);
                if self.is_whole(&block)? {
                    self.lines.go_to(behind)?;
                    return Ok(Some(delimiter));
                }
            }
            let Some(found) = read else { return Ok(None) };
            if is_end {
                return Ok(Some(found.byte));
            }
            appended = appended_delimiter(&line).map(|column| found.byte + column as u64);
        }
    }

    fn text_block_to(&self, header: &Header, at: Position, end: u64) -> TextBlock {
        TextBlock {
            at,
            end,
            format: header.format,
            points: header.points,
            uneven: header.spacing.is_none(),
            line_end: self.lines.line_end(),
        }
    }

    /// Whether a text block has as many numbers as its header states, and nothing else.
    fn is_whole(&mut self, block: &TextBlock) -> io::Result<bool> {
        // A number takes a digit and what parts it from the next.
        let most = (block.end - block.at.byte).div_ceil(2);
        let wanted = block.points.checked_mul(block.stride());
        let path = &self.path;
        Ok(wanted.is_some_and(|wanted| wanted <= most)
            && self
                .lines
                .with_input(|input| read_text(input.as_mut(), block, false, path).is_ok())?)
    }

    fn text_block(&mut self, header: Header, at: Position, end: u64) -> io::Result<()> {
        let block = self.text_block_to(&header, at, end);
        // A number takes a digit and what parts it from the next.
        let most = (end - at.byte).div_ceil(2);
        let wanted = header.points.checked_mul(block.stride());
        if wanted.is_none_or(|wanted| wanted > most) {
            let error = FieldError {
                at,
                what: "number of points of dataset 58",
                got: header.points.to_string(),
                expected: format!(
                    "at most {} in {} bytes of text",
                    most / block.stride(),
                    end - at.byte
                ),
            };
            self.damaged(error, header.part());
            return Ok(());
        }
        let abscissae = match block.uneven {
            true => text_abscissae(&mut self.lines, &block, &self.path)?.map(Some),
            false => Ok(None),
        };
        match abscissae {
            Ok(abscissae) => self.entry(header, Samples::Text(block), abscissae.as_ref()),
            Err(error) => self.push_damage(error, at, header.part()),
        }
        Ok(())
    }

    /// A delimiter that the number of a dataset follows has opened that dataset: the one before was
    /// not closed.
    fn reopen(&mut self, delimiter: u64) -> io::Result<()> {
        let behind = self.lines.position();
        let next = self.line()?;
        if next.is_some_and(|line| dataset_number(&line.bytes).is_some()) {
            let line = behind.line.map(|line| line - 1);
            let at = Position {
                line,
                byte: delimiter,
            };
            self.not_closed(at);
            return self.lines.go_to(at);
        }
        self.lines.go_to(behind)
    }

    /// A text at the end of the file without a delimiter: whole when its numbers are, and its last
    /// line.
    fn unclosed_text(&mut self, header: Header, at: Position) -> io::Result<()> {
        let end = self.lines.end();
        self.lines.go_to(at)?;
        let (mut line, mut next, mut last) = (Vec::new(), Vec::new(), at.byte);
        // Padding behind the numbers is none of them.
        let mut padding = None;
        while let Some(at) = self.lines.read_line(&mut next)? {
            if without_padding(&next).is_empty() {
                padding.get_or_insert(at.byte);
                continue;
            }
            padding = None;
            last = at.byte;
            std::mem::swap(&mut line, &mut next);
        }
        // The last line may be incomplete, unless it has a line end or begins a delimiter.
        let ended = padding.unwrap_or(end) - last > line.len() as u64;
        let end = match line.trim_ascii() {
            b"-" => last,
            _ if ended => padding.unwrap_or(end),
            _ => {
                self.no_end(header.part());
                return Ok(());
            }
        };
        let whole = self.text_block_to(&header, at, end);
        if self.is_whole(&whole)? {
            self.not_closed(Position {
                line: None,
                byte: end,
            });
            return self.text_block(header, at, end);
        }
        self.no_end(header.part());
        Ok(())
    }

    fn not_closed(&mut self, at: Position) {
        let finding = Finding::new(Severity::Warning, Code::NotClosed, self.location(at));
        self.catalog.findings.push(finding);
    }

    /// A function with a binary block: its end is where its length says.
    pub fn binary_function(&mut self, first: &Line) -> io::Result<()> {
        self.qualifiers.begin();
        let start = self.lines.position();
        let binary = match binary_line(first) {
            Ok(binary) => binary,
            Err(error) => {
                let part = self.part_ahead(start)?;
                self.damaged(error, part);
                if self.pass_over_binary(first)? {
                    return Ok(());
                }
                self.lines.go_to(start)?;
                return self.resynchronise();
            }
        };
        let Some(lines) = self.header_lines(binary.header_lines)? else {
            self.lines.go_to(start)?;
            return self.resynchronise();
        };
        let block = self.lines.position();
        match header(first.at, &lines) {
            Ok(header) => self.binary_block(header, binary, block.byte),
            Err(error) => {
                self.damaged(error, header_part(&lines));
                self.lines.go_to(start)?;
                if self.pass_over_binary(first)? {
                    return Ok(());
                }
                self.lines.go_to(start)?;
                self.resynchronise()
            }
        }
    }

    /// Passes over the header and the block of a binary dataset whose first line is `first`, and
    /// over its delimiter: where the byte count or the number of points leads to one. Else false,
    /// and the reader stands anywhere.
    pub fn pass_over_binary(&mut self, first: &Line) -> io::Result<bool> {
        let extent = binary_extent(first);
        let lines = self.available_lines(extent.header_lines)?;
        let by_points = lines.get(6).map_or_else(Vec::new, block_bytes);
        let byte = self.lines.position().byte;
        for bytes in std::iter::once(extent.stated_bytes).chain(by_points) {
            let end = byte.saturating_add(bytes);
            if let Some(delimiter) = self.lines.delimiter_at(end, false)? {
                self.lines.jump_to(delimiter)?;
                self.close()?;
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The type of the function whose header begins at `start`; nothing is passed over.
    fn part_ahead(&mut self, start: Position) -> io::Result<Part> {
        let lines = self.available_lines(HEADER_LINES)?;
        self.lines.go_to(start)?;
        Ok(header_part(&lines))
    }

    /// Finds the end of a binary block that starts at `byte`: where the number of points puts it if
    /// a delimiter (or the end of the file) stands there, whatever the byte count says.
    fn binary_block(&mut self, header: Header, line: BinaryLine, byte: u64) -> io::Result<()> {
        for abscissa_bytes in abscissa_bytes(header.format, header.spacing.is_none()) {
            let stride = value_bytes(header.format) + *abscissa_bytes as u64;
            let needed = header.points.checked_mul(stride);
            let end = needed.and_then(|needed| byte.checked_add(needed));
            let file_bytes = self.lines.end();
            let there = match end {
                Some(end) if end == file_bytes => Some(end),
                Some(end) => {
                    let agrees = needed == Some(line.stated_bytes);
                    match self.lines.delimiter_at(end, agrees)? {
                        None if self.lines.is_padding_to_end(end)? => Some(file_bytes),
                        delimiter => delimiter,
                    }
                }
                None => None,
            };
            if let (Some(needed), Some(delimiter)) = (needed, there) {
                if needed != line.stated_bytes {
                    let location = self.location(header.at);
                    let finding = Finding::new(Severity::Warning, Code::ByteCountWrong, location);
                    let finding = finding.value(line.stated_bytes as f64, "byte");
                    self.catalog.findings.push(finding.limit(needed as f64));
                }
                return self.found_block(header, line, byte, *abscissa_bytes, delimiter);
            }
        }
        self.lost_block(header, line, byte)
    }

    /// A block whose end is known.
    fn found_block(
        &mut self,
        header: Header,
        line: BinaryLine,
        byte: u64,
        abscissa_bytes: usize,
        delimiter: u64,
    ) -> io::Result<()> {
        let mut block = BinaryBlock {
            byte,
            little_endian: line.little_endian,
            format: header.format,
            abscissa_bytes,
        };
        let evidence = self.byte_order_evidence(&block, header.points)?;
        if evidence == Evidence::Opposite {
            block.little_endian = !block.little_endian;
        }
        let (at, before) = (header.at, self.samples.len());
        let abscissae = match abscissa_bytes {
            0 => None,
            _ => Some(binary_abscissae(&mut self.lines, &block, header.points)?),
        };
        self.entry(header, Samples::Binary(block), abscissae.as_ref());
        if self.samples.len() > before {
            self.byte_orders.push(ByteOrder {
                evidence,
                entry: before,
                at,
            });
        }
        self.lines.jump_to(delimiter)?;
        self.close()
    }

    /// A block that does not end where its points put it: where the byte count alone is right, it
    /// says how many points there are; else says why it has no end and goes on behind it.
    fn lost_block(&mut self, mut header: Header, line: BinaryLine, byte: u64) -> io::Result<()> {
        let size = value_bytes(header.format);
        let stated_end = byte.saturating_add(line.stated_bytes);
        let by_count = self.lines.delimiter_at(stated_end, false)?;
        let points = points_of_bytes(&header, line.stated_bytes);
        if let (Some(delimiter), Some(points)) = (by_count, points) {
            let finding = Finding::new(
                Severity::Warning,
                Code::PointCountWrong,
                self.location(header.spacing_at),
            );
            let finding = finding.value(header.points as f64, "");
            self.catalog.findings.push(finding.limit(points as f64));
            header.points = points;
            return self.found_block(header, line, byte, 0, delimiter);
        }
        let path = self.path.clone();
        let file_bytes = self.lines.end();
        let end = u128::from(byte) + u128::from(header.points) * u128::from(size);
        let error = if by_count.is_some() {
            IoError::Binary {
                path,
                byte,
                what: "number of points of dataset 58b",
                got: format!("{} points of {size} bytes", header.points),
                expected: format!("{} bytes, where the delimiter stands", line.stated_bytes),
            }
        } else if end > u128::from(file_bytes) {
            IoError::Truncated {
                path,
                byte: file_bytes,
                what: "a binary block of dataset 58b",
                got: format!("{} bytes", file_bytes.saturating_sub(byte)),
                expected: format!("{} points of {size} bytes", header.points),
            }
        } else {
            IoError::Binary {
                path,
                byte: end as u64,
                what: "end of a binary block of dataset 58b",
                got: "other bytes".to_owned(),
                expected: "the delimiter `    -1`".to_owned(),
            }
        };
        self.push_damage(error, Position { line: None, byte }, header.part());
        match by_count {
            Some(delimiter) => {
                self.lines.jump_to(delimiter)?;
                self.close()
            }
            None => {
                self.lines.jump_to(byte)?;
                self.resynchronise()
            }
        }
    }

    fn entry(&mut self, header: Header, samples: Samples, abscissae: Option<&Abscissae>) {
        let text = matches!(samples, Samples::Text(_));
        let Meaning {
            mut entry,
            restored_rate_hz,
        } = match meaning(&header, text, abscissae) {
            Ok(meaning) => meaning,
            Err(error) => return self.damaged(error, header.part()),
        };
        entry.note.window = entry.note.window.or(self.qualifiers.current);
        self.qualifiers.read = self.qualifiers.begun;
        if let Some(rate) = restored_rate_hz
            && self.reported.insert(Code::SpacingRounded)
        {
            let location = self.location(header.spacing_at);
            let finding = Finding::new(Severity::Info, Code::SpacingRounded, location);
            self.catalog.findings.push(finding.value(rate, "Hz"));
        }
        if let EntryAxis::General(GeneralAxis { even: None, .. }) = entry.axis
            && self.reported.insert(Code::UnevenAxis)
        {
            let location = self.location(header.spacing_at);
            let finding = Finding::new(Severity::Warning, Code::UnevenAxis, location);
            self.catalog.findings.push(finding);
        }
        if has_unknown_unit(&header) && self.reported.insert(Code::AxisUnitUnknown) {
            let location = self.location(header.abscissa_at);
            let finding = Finding::new(Severity::Warning, Code::AxisUnitUnknown, location);
            self.catalog.findings.push(finding);
        }
        self.catalog.entries.push(entry);
        self.headers.push(header);
        self.samples.push(samples);
    }

    /// Qualifiers of the function before them, or of the one behind them where the first of the
    /// file stand before any.
    pub fn qualify(&mut self, lines: &[Line], first: &Line) -> Result<(), FieldError> {
        let window = dataset_1858::window(lines, first)?;
        let (begun, read) = (self.qualifiers.begun, self.qualifiers.read);
        if *self.qualifiers.lead.get_or_insert(begun == 0) {
            self.qualifiers.next = window;
        } else if begun == read
            && let Some(entry) = self.catalog.entries.last_mut()
        {
            entry.note.window = entry.note.window.or(window);
        }
        Ok(())
    }
}

impl Header {
    /// The type of the function.
    fn part(&self) -> Part {
        Part::of_function(FunctionType::from_code(self.function_type))
    }
}

/// Bytes that an abscissa may take before each value.
fn abscissa_bytes(format: SampleFormat, is_uneven: bool) -> &'static [usize] {
    match (is_uneven, format) {
        (false, _) => &[0],
        (true, SampleFormat::RealF32 | SampleFormat::ComplexF32) => &[4],
        (true, SampleFormat::RealF64 | SampleFormat::ComplexF64) => &[8, 4],
    }
}

/// Lengths that a binary block may have by the number of points of record 7; none where the record
/// cannot be read.
fn block_bytes(record_7: &Line) -> Vec<u64> {
    let Ok(record) = spacing_record(record_7) else {
        return Vec::new();
    };
    let abscissa_bytes = abscissa_bytes(record.format, record.spacing.is_none()).iter();
    let strides = abscissa_bytes.map(|bytes| value_bytes(record.format) + *bytes as u64);
    strides
        .filter_map(|stride| record.points.checked_mul(stride))
        .collect()
}

/// Number of points that a byte count holds, for an even abscissa. Where the count is right for the
/// stated points with values of another width, the width may be what is wrong, and nothing is
/// known.
fn points_of_bytes(header: &Header, bytes: u64) -> Option<u64> {
    let size = value_bytes(header.format);
    let other_width = [4, 8, 16]
        .iter()
        .any(|width| header.points.checked_mul(*width) == Some(bytes));
    let whole = bytes > 0 && bytes.is_multiple_of(size);
    (whole && !other_width && header.spacing.is_some()).then_some(bytes / size)
}
