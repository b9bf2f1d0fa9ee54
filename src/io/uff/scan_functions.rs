//! The part of the pass over a file that finds functions (dataset 58) and where their samples are.
//!
//! A text block ends at the next delimiter; its numbers are counted when they are read. A binary block ends where its
//! length puts a delimiter.

use std::io;

use super::dataset_58::{BinaryLine, HEADER_LINES, Header, binary_line, header};
use super::dataset_58_meaning::{Meaning, meaning};
use super::dataset_58_samples::{BinaryBlock, Samples, TextBlock, numbers_per_value, value_bytes};
use super::fields::{FieldError, Line, Position};
use super::scan::Scanner;
use crate::finding::{Code, Finding, Severity};
use crate::io::IoError;

impl Scanner {
    /// A function written as text: its end is the next delimiter behind the header.
    pub fn text_function(&mut self, first: &Line) -> io::Result<()> {
        let start = self.lines.position();
        let Some(lines) = self.header_lines(HEADER_LINES)? else {
            self.lines.go_to(start)?;
            return self.find_delimiter().map(|_| ());
        };
        let header = match header(first.at, &lines) {
            Ok(header) => header,
            Err(error) => {
                self.damaged(error);
                self.lines.go_to(start)?;
                return self.find_delimiter().map(|_| ());
            }
        };
        let at = self.lines.position();
        let Some(end) = self.skip_text()? else {
            return Ok(());
        };
        // A number takes a digit and what parts it from the next.
        let most = (end - at.byte).div_ceil(2);
        let wanted = header.points.checked_mul(numbers_per_value(header.format));
        if wanted.is_none_or(|wanted| wanted > most) {
            self.damaged(FieldError {
                at,
                what: "number of points of dataset 58",
                got: header.points.to_string(),
                expected: format!(
                    "at most {} in {} bytes of text",
                    most / numbers_per_value(header.format),
                    end - at.byte
                ),
            });
            return Ok(());
        }
        let block = TextBlock {
            at,
            end,
            format: header.format,
            points: header.points,
        };
        self.entry(header, Samples::Text(block));
        Ok(())
    }

    /// A function with a binary block: its end is where its length says.
    pub fn binary_function(&mut self, first: &Line) -> io::Result<()> {
        let start = self.lines.position();
        let binary = match binary_line(first) {
            Ok(binary) => binary,
            Err(error) => {
                self.damaged(error);
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
                self.damaged(error);
                let behind = block.byte.saturating_add(binary.stated_bytes);
                if let Some(delimiter) = self.lines.delimiter_at(behind, false)? {
                    self.lines.jump_to(delimiter)?;
                    self.close()
                } else {
                    self.lines.go_to(start)?;
                    self.resynchronise()
                }
            }
        }
    }

    /// Finds the end of a binary block that starts at `byte`: where the number of points puts it if a delimiter (or the
    /// end of the file) stands there, whatever the byte count says.
    fn binary_block(&mut self, header: Header, line: BinaryLine, byte: u64) -> io::Result<()> {
        let needed = header.points.checked_mul(value_bytes(header.format));
        let end = needed.and_then(|needed| byte.checked_add(needed));
        let file_bytes = self.lines.end();
        let there = match end {
            Some(end) if end == file_bytes => Some(end),
            Some(end) => {
                let agrees = needed == Some(line.stated_bytes);
                self.lines.delimiter_at(end, agrees)?
            }
            None => None,
        };
        if let (Some(needed), Some(delimiter)) = (needed, there) {
            if needed != line.stated_bytes {
                let place = self.place(header.at);
                let finding = Finding::new(Severity::Warning, Code::ByteCountWrong, place);
                let finding = finding.value(line.stated_bytes as f64, "byte");
                self.catalog.findings.push(finding.limit(needed as f64));
            }
            let block = BinaryBlock {
                byte,
                little_endian: line.little_endian,
                format: header.format,
            };
            self.entry(header, Samples::Binary(block));
            self.lines.jump_to(delimiter)?;
            return self.close();
        }
        self.lost_block(&header, line, byte)
    }

    /// Says why a binary block has no end and goes on behind it.
    fn lost_block(&mut self, header: &Header, line: BinaryLine, byte: u64) -> io::Result<()> {
        let file_bytes = self.lines.end();
        let size = value_bytes(header.format);
        let stated_end = byte.saturating_add(line.stated_bytes);
        let path = self.path.clone();
        let by_count = self.lines.delimiter_at(stated_end, false)?;
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
        self.push_damage(error, Position { line: None, byte });
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

    fn entry(&mut self, header: Header, samples: Samples) {
        let text = matches!(samples, Samples::Text(_));
        match meaning(&header, text) {
            Ok(Meaning {
                entry,
                restored_rate_hz,
            }) => {
                if let Some(rate) = restored_rate_hz
                    && self.told.insert(Code::SpacingRounded)
                {
                    let place = self.place(header.spacing_at);
                    let finding = Finding::new(Severity::Info, Code::SpacingRounded, place);
                    self.catalog.findings.push(finding.value(rate, "Hz"));
                }
                self.catalog.entries.push(entry);
                self.headers.push(header);
                self.samples.push(samples);
            }
            Err(error) => self.damaged(error),
        }
    }
}
