//! Bytes of variables, plain or deflated, by their position within the variable.

use std::collections::BTreeSet;
use std::io::{Read, Seek, SeekFrom};

use flate2::{Decompress, FlushDecompress, Status};

use crate::io::{IoError, ReadSeek};

/// Deflate expands at most so many times.
pub(super) const DEFLATE_EXPANSION: u64 = 1032;

/// Size of the pieces in which deflated bytes are read and unused inflated bytes are skipped.
const PIECE: usize = 1 << 16;

/// Memory for a value grows in steps of this size, so that a wrong count costs no more than the
/// bytes that are there.
const STEP: usize = 1 << 22;

/// All reads of a file together inflate at most so many times its bytes, and 16 MiB: a variable
/// that is not read in its order is inflated again from its start. Larger: a struct of 1 MB that
/// inflates to 1 GB, with its fields in reverse, takes hours
/// (`fields_out_of_order_are_inflated_to_a_limit`). Smaller than 1,100: the 40 arrays of each of 20
/// groups of a file that deflates to a third (`fields_of_a_deflated_struct_are_read_in_any_order`).
const MAX_INFLATED_OVER_FILE: u64 = 4096;
const MAX_ADDITIONAL_INFLATED_BYTES: u64 = 16 << 20;

/// Where the bytes of a variable lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Storage {
    /// From this byte of the file.
    Plain(u64),
    /// Deflated: first byte and length in the file.
    Deflated(u64, u64),
}

impl Storage {
    /// First byte in the file.
    pub fn at(self) -> u64 {
        match self {
            Storage::Plain(at) | Storage::Deflated(at, _) => at,
        }
    }
}

/// A file whose variables can be read anywhere. Reading a deflated variable forwards inflates it
/// once.
pub(super) struct Bytes {
    input: Box<dyn ReadSeek>,
    /// Where `input` stands.
    position: u64,
    /// Length of the file.
    pub length: u64,
    path: String,
    inflating: Option<Inflating>,
    /// Bytes that were inflated so far.
    inflated: u64,
    /// First bytes of the deflated variables whose check sum was found right.
    checked: BTreeSet<u64>,
}

/// A deflated variable that is being read.
struct Inflating {
    storage: Storage,
    state: Decompress,
    /// Next deflated byte in the file, and their end.
    next: u64,
    end: u64,
    /// Deflated bytes, of which the first `used` are done.
    piece: Vec<u8>,
    used: usize,
    /// Inflated bytes so far.
    position: u64,
}

impl Bytes {
    /// Over a whole file.
    ///
    /// # Errors
    /// [`IoError::System`].
    pub fn new(mut input: Box<dyn ReadSeek>, path: &str) -> Result<Self, IoError> {
        let end = input.seek(SeekFrom::End(0));
        let length = end.map_err(|source| IoError::System {
            path: path.to_owned(),
            action: "read",
            source,
        })?;
        Ok(Self {
            input,
            position: length,
            length,
            path: path.to_owned(),
            inflating: None,
            inflated: 0,
            checked: BTreeSet::new(),
        })
    }

    /// Path of the file, for messages.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Fills `out` with the bytes from `position` of a variable.
    ///
    /// # Errors
    /// [`IoError::System`], [`IoError::Truncated`] and, for a stream that cannot be inflated,
    /// [`IoError::Binary`].
    pub fn read(&mut self, storage: Storage, position: u64, out: &mut [u8]) -> Result<(), IoError> {
        match storage {
            Storage::Plain(at) => self.read_file(at + position, out),
            Storage::Deflated(..) => self.read_deflated(storage, position, out),
        }
    }

    /// As many bytes as stated, from `position` of a variable.
    ///
    /// # Errors
    /// As [`Bytes::read`].
    pub fn read_vec(
        &mut self,
        storage: Storage,
        position: u64,
        count: usize,
    ) -> Result<Vec<u8>, IoError> {
        let mut bytes = Vec::new();
        while bytes.len() < count {
            let done = bytes.len();
            bytes.resize(count.min(done + STEP), 0);
            self.read(storage, position + done as u64, &mut bytes[done..])?;
        }
        Ok(bytes)
    }

    /// Inflates a deflated variable to its end, where its check sum is compared, unless that was
    /// done: the sum covers all of it, so that values before a damaged byte, too, are uncertain.
    ///
    /// # Errors
    /// As [`Bytes::read`].
    pub fn check(&mut self, storage: Storage) -> Result<(), IoError> {
        let is_plain = matches!(storage, Storage::Plain(_));
        if is_plain || self.checked.contains(&storage.at()) {
            return Ok(());
        }
        let mut inflating = Inflating::new(storage);
        let mut scratch = vec![0; PIECE];
        while self.inflate(&mut inflating, &mut scratch)? > 0 {}
        self.checked.insert(storage.at());
        Ok(())
    }

    fn read_file(&mut self, at: u64, out: &mut [u8]) -> Result<(), IoError> {
        let available = self.length.saturating_sub(at);
        if (out.len() as u64) > available {
            return Err(IoError::Truncated {
                path: self.path.clone(),
                byte: self.length,
                what: "a variable",
                got: format!("{available} bytes"),
                expected: format!("{} bytes from byte {at}", out.len()),
            });
        }
        // A relative seek keeps what is buffered.
        let read = self
            .input
            .seek_relative(at.wrapping_sub(self.position) as i64)
            .and_then(|()| self.input.read_exact(out));
        self.position = at + out.len() as u64;
        read.map_err(|source| IoError::System {
            path: self.path.clone(),
            action: "read",
            source,
        })
    }

    fn read_deflated(
        &mut self,
        storage: Storage,
        position: u64,
        out: &mut [u8],
    ) -> Result<(), IoError> {
        let known = self.inflating.take();
        let known = known.filter(|state| state.storage == storage && state.position <= position);
        let mut inflating = known.unwrap_or_else(|| Inflating::new(storage));
        // Memory is asked for only where bytes are skipped: most reads are of a few bytes, one
        // after the other.
        let mut scratch = Vec::new();
        while inflating.position < position {
            let wanted = (position - inflating.position).min(PIECE as u64) as usize;
            scratch.resize(PIECE.min(wanted.max(scratch.len())), 0);
            if self.inflate(&mut inflating, &mut scratch[..wanted])? == 0 {
                return Err(self.ended(&inflating));
            }
        }
        let mut done = 0;
        while done < out.len() {
            match self.inflate(&mut inflating, &mut out[done..])? {
                0 => return Err(self.ended(&inflating)),
                count => done += count,
            }
        }
        self.inflating = Some(inflating);
        Ok(())
    }

    /// Bytes that all reads together may inflate.
    fn most_inflated(&self) -> u64 {
        let most = self.length.saturating_mul(MAX_INFLATED_OVER_FILE);
        most.saturating_add(MAX_ADDITIONAL_INFLATED_BYTES)
    }

    fn inflated_too_often(&self, inflating: &Inflating) -> IoError {
        IoError::Binary {
            path: self.path.clone(),
            byte: inflating.storage.at(),
            what: "compressed variable",
            got: format!("more than {} bytes to inflate", self.most_inflated()),
            expected:
                "fields in the order in which they are read: save the file without compression, \
                       save -v6"
                    .to_owned(),
        }
    }

    /// The error of a stream that holds less than is asked for.
    fn ended(&self, inflating: &Inflating) -> IoError {
        IoError::Truncated {
            path: self.path.clone(),
            byte: inflating.end,
            what: "a compressed variable",
            got: format!("{} bytes", inflating.position),
            expected: "more, as its counts say".to_owned(),
        }
    }

    /// Inflates some bytes; none at the end of the stream.
    fn inflate(&mut self, inflating: &mut Inflating, out: &mut [u8]) -> Result<usize, IoError> {
        loop {
            if inflating.used == inflating.piece.len() && inflating.next < inflating.end {
                let count = (inflating.end - inflating.next).min(PIECE as u64) as usize;
                inflating.piece.resize(count, 0);
                inflating.used = 0;
                self.read_file(inflating.next, &mut inflating.piece)?;
                inflating.next += count as u64;
            }
            let (consumed, produced) = (inflating.state.total_in(), inflating.state.total_out());
            let status = inflating.state.decompress(
                &inflating.piece[inflating.used..],
                out,
                FlushDecompress::None,
            );
            let consumed = (inflating.state.total_in() - consumed) as usize;
            let produced = (inflating.state.total_out() - produced) as usize;
            inflating.used += consumed;
            inflating.position += produced as u64;
            self.inflated += produced as u64;
            if self.inflated > self.most_inflated() {
                return Err(self.inflated_too_often(inflating));
            }
            let status = status.map_err(|error| IoError::Binary {
                path: self.path.clone(),
                byte: inflating.storage.at(),
                what: "compressed variable",
                got: error.to_string(),
                expected: "a zlib stream of its check sum: copy or save the file anew".to_owned(),
            })?;
            if produced > 0 {
                return Ok(produced);
            }
            if status == Status::StreamEnd {
                return Ok(0);
            }
            if consumed == 0 && inflating.next >= inflating.end {
                return Err(self.ended(inflating));
            }
        }
    }
}

impl Inflating {
    fn new(storage: Storage) -> Self {
        let (next, end) = match storage {
            Storage::Deflated(at, length) => (at, at + length),
            Storage::Plain(at) => (at, at),
        };
        Self {
            storage,
            state: Decompress::new(true),
            next,
            end,
            piece: Vec::new(),
            used: 0,
            position: 0,
        }
    }
}
