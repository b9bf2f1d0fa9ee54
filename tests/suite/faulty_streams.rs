//! Places that fill up and files that shrink, for every format: an error, never a panic and never
//! other numbers.

use std::io::{Cursor, Read, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use modalign::io::{Block, Encoding, FORMATS, Format, Hints, WriteOptions};

use crate::seeds;

/// A place for this many bytes.
struct Full {
    held: Cursor<Vec<u8>>,
    room: usize,
}

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let end = self.held.position() as usize + bytes.len();
        if end > self.room {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        self.held.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.held.seek(to)
    }
}

#[test]
fn a_full_place_is_an_error_of_every_writer_wherever_it_fills() {
    let mut writers = 0;
    for format in FORMATS {
        for encoding in [Encoding::Binary, Encoding::Text] {
            let options = WriteOptions {
                encoding,
                ..WriteOptions::default()
            };
            let write = |room: usize| {
                let held = Cursor::new(Vec::new());
                let mut out = Full { held, room };
                let result = format.write(&mut out, &mut seeds::source(), &options);
                result.map(|_| out.held.into_inner().len())
            };
            let Ok(needed) = write(usize::MAX) else {
                continue;
            };
            writers += 1;
            assert_eq!(write(needed).unwrap(), needed, "{}", format.name());
            for room in [0, 1, needed / 3, needed / 2, needed - 1] {
                let error = write(room).map(|_| ()).unwrap_err().to_string();
                assert!(
                    error.contains("cannot write"),
                    "{} with {room} bytes: {error}",
                    format.name()
                );
            }
        }
    }
    assert!(
        writers >= 12,
        "{writers} of every format that is written, in both encodings"
    );
}

/// Bytes of which those from a place on are gone once they have been opened.
struct Shrinking {
    bytes: Cursor<Vec<u8>>,
    end: Arc<AtomicU64>,
}

impl Read for Shrinking {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let left = self
            .end
            .load(Ordering::Relaxed)
            .saturating_sub(self.bytes.position());
        let most = buffer
            .len()
            .min(usize::try_from(left).unwrap_or(usize::MAX));
        self.bytes.read(&mut buffer[..most])
    }
}

impl Seek for Shrinking {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.bytes.seek(to)
    }
}

/// The values of every entry of a file that is cut to `end` bytes after it was opened; `None` where
/// reading failed.
fn read_cut(format: &dyn Format, bytes: &[u8], end: u64) -> Option<Vec<Block>> {
    let cut = Arc::new(AtomicU64::new(u64::MAX));
    let input = Shrinking {
        bytes: Cursor::new(bytes.to_vec()),
        end: Arc::clone(&cut),
    };
    let mut source = format.open(Box::new(input), &Hints::default()).unwrap();
    cut.store(end, Ordering::Relaxed);
    let lengths: Vec<usize> = source
        .catalog()
        .entries
        .iter()
        .map(modalign::io::Entry::len)
        .collect();
    let mut read = |(entry, length): (usize, &usize)| {
        let mut block = Block::F64(Vec::new());
        source
            .read(entry, 0..*length, &mut block)
            .ok()
            .map(|()| block)
    };
    lengths.iter().enumerate().map(&mut read).collect()
}

/// The formats whose samples are read after the file is opened.
#[test]
fn a_file_that_shrinks_while_it_is_read_is_an_error_or_gives_what_it_held() {
    let all: [(&str, Vec<Vec<u8>>); 9] = [
        ("uff", seeds::uff()),
        ("hdf5", seeds::hdf5()),
        ("npz", seeds::npz()),
        ("npy", seeds::npy()),
        ("matlab4", seeds::matlab4()),
        ("matlab5", seeds::matlab5()),
        ("table", seeds::table()),
        ("pulse", seeds::pulse()),
        ("signalcalc", seeds::signalcalc()),
    ];
    let (mut failed, mut read) = (0, 0);
    for (name, files) in all {
        let format = *FORMATS
            .iter()
            .find(|candidate| candidate.name() == name)
            .unwrap();
        for bytes in files {
            let whole = read_cut(format, &bytes, u64::MAX).expect("a whole file is read");
            for part in 0..10 {
                match read_cut(format, &bytes, bytes.len() as u64 * part / 10) {
                    None => failed += 1,
                    Some(values) => {
                        assert_eq!(values, whole, "{name} cut to {part} tenths");
                        read += 1;
                    }
                }
            }
        }
    }
    // Readers that stream fail, those that hold the text in memory do not.
    assert!(failed > 20 && read > 20, "{failed} failed, {read} read");
}
