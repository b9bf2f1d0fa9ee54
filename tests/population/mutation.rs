//! Seeded changes of bytes damage files; a reader must meet its guarantees on every damaged file.
//!
//! A reader may refuse a damaged file or read its intact part. It must not panic, it must not ask
//! for more memory than a small multiple of the file (a few bytes can say that a terabyte follows),
//! and it must not read the same bytes without end.
//!
//! Half of the changes are of bytes and half of the structure: numbers that may be lengths, counts,
//! offsets or links get hostile values. Compressed and check-summed files are changed before they
//! are packed, so that the changes reach the reader behind the check sum.
//!
//! The number of a file is the seed of its changes. `MUTATED_FILES` states how many files each
//! reader is tried on, `MUTATED_FIRST` the number of the first.

use std::io::{Cursor, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use modalign::io::{FORMATS, Format, Hints, TableSpec};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::readers::{Reader, read_all};
use crate::structure::change_structure;

/// Largest memory of a reader over the size of the file ...
const MAX_MEMORY_OVER_FILE_SIZE: u64 = 64;

/// ... in addition to this number of bytes.
const MAX_ADDITIONAL_BYTES: u64 = 4 << 20;

/// Largest number of bytes that are read over the size of the file: a reader may look up every
/// array in the whole file, but not without end ...
const MAX_READ_OVER_FILE_SIZE: u64 = 512;

/// ... in addition to this number of bytes.
const MAX_ADDITIONAL_READ_BYTES: u64 = 16 << 20;

/// A file that takes longer is reported, and the process ends, because a loop without end cannot be
/// left: ten thousand times the time of a file.
const MAX_TIME: Duration = Duration::from_secs(60);

/// The number that an environment variable states, else `default`.
pub fn stated(variable: &str, default: usize) -> usize {
    std::env::var(variable).map_or(default, |number| number.parse().unwrap())
}

/// Results of many damaged files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Files.
    pub files: usize,
    /// Those that opened.
    pub opened: usize,
    /// Most memory at once.
    pub most_bytes: u64,
    /// Largest memory at once over the size of the file.
    pub most_over_size: u64,
    /// Most bytes that were read.
    pub most_read: u64,
    /// Longest time of a file.
    pub longest: Duration,
}

impl Outcome {
    fn and(self, other: Self) -> Self {
        Self {
            files: self.files + other.files,
            opened: self.opened + other.opened,
            most_bytes: self.most_bytes.max(other.most_bytes),
            most_over_size: self.most_over_size.max(other.most_over_size),
            most_read: self.most_read.max(other.most_read),
            longest: self.longest.max(other.longest),
        }
    }
}

/// Tries a reader on `files` damaged files from number `first` on; the number of a file is all that
/// makes it.
pub fn survives(reader: &Reader, first: usize, files: usize) -> Outcome {
    let seeds = (reader.seeds)();
    let spec = (reader.spec)();
    let name = format!("{} {:?}", reader.name, reader.packing);
    assert!(!seeds.is_empty(), "{name}");
    let format = FORMATS
        .iter()
        .copied()
        .find(|format| format.name() == reader.name);
    let format = format.unwrap_or_else(|| panic!("no format {}", reader.name));
    let sealed = seeds.iter().map(|seed| reader.packing.check_sums(seed));
    let sealed: Vec<_> = sealed.collect();
    let pack = |number: usize, bytes: Vec<u8>| {
        let seed = number % seeds.len();
        reader.packing.pack(bytes, seeds[seed].len(), &sealed[seed])
    };
    for (number, seed) in seeds.iter().enumerate() {
        let whole = attempt(format, &spec, pack(number, seed.clone()));
        assert!(whole.opened, "{name}: seed {number} opens");
    }
    let begun = Begun::new(&name);
    let tried = (first..first + files).into_par_iter().map(|number| {
        let bytes = pack(number, damaged(&seeds[number % seeds.len()], number));
        let size = bytes.len() as u64;
        let most = MAX_MEMORY_OVER_FILE_SIZE * size + MAX_ADDITIONAL_BYTES;
        let most_read = MAX_READ_OVER_FILE_SIZE * size + MAX_ADDITIONAL_READ_BYTES;
        begun.begin(number);
        let start = Instant::now();
        let end = attempt(format, &spec, bytes);
        let longest = start.elapsed();
        begun.end();
        assert!(
            !end.panicked,
            "{name}: file {number} makes the reader panic"
        );
        assert!(
            end.peak <= most,
            "{name}: file {number} takes {} bytes, expected at most {most}",
            end.peak
        );
        assert!(
            end.read <= most_read,
            "{name}: of file {number} {} bytes are read, expected at most {most_read}",
            end.read
        );
        Outcome {
            files: 1,
            opened: usize::from(end.opened),
            most_bytes: end.peak,
            most_over_size: end.peak / size.max(1),
            most_read: end.read,
            longest,
        }
    });
    let outcome = tried.reduce(Outcome::default, Outcome::and);
    println!("{name}, seeds from {first}: {outcome:?}");
    outcome
}

/// The files that are being read, each by its thread; ends the process at one that takes too long.
struct Begun {
    /// Number of the file plus 1, 0 for none, and the time of its begin in ms.
    files: Arc<Vec<[AtomicU64; 2]>>,
    start: Instant,
}

impl Begun {
    fn new(name: &str) -> Self {
        let threads = (0..=rayon::current_num_threads()).map(|_| Default::default());
        let begun = Self {
            files: Arc::new(threads.collect()),
            start: Instant::now(),
        };
        let (files, start) = (Arc::downgrade(&begun.files), begun.start);
        let name = name.to_owned();
        std::thread::spawn(move || {
            while let Some(files) = files.upgrade() {
                for [number, time] in files.iter() {
                    let number = number.load(Ordering::SeqCst);
                    let begin = Duration::from_millis(time.load(Ordering::SeqCst));
                    if number > 0 && start.elapsed().saturating_sub(begin) > MAX_TIME {
                        eprintln!("{name}: file {} takes over {MAX_TIME:?}", number - 1);
                        std::process::abort();
                    }
                }
                drop(files);
                std::thread::sleep(Duration::from_millis(500));
            }
        });
        begun
    }

    fn place(&self) -> &[AtomicU64; 2] {
        &self.files[rayon::current_thread_index().unwrap_or(self.files.len() - 1)]
    }

    fn begin(&self, number: usize) {
        let [file, time] = self.place();
        time.store(self.start.elapsed().as_millis() as u64, Ordering::SeqCst);
        file.store(number as u64 + 1, Ordering::SeqCst);
    }

    fn end(&self) {
        self.place()[0].store(0, Ordering::SeqCst);
    }
}

struct End {
    opened: bool,
    panicked: bool,
    peak: u64,
    read: u64,
}

/// A file in memory that counts the bytes that are read.
struct Counting {
    file: Cursor<Vec<u8>>,
    read: Arc<AtomicU64>,
}

impl Read for Counting {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(out)?;
        self.read.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

impl Seek for Counting {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.file.seek(to)
    }
}

fn attempt(format: &dyn Format, spec: &TableSpec, bytes: Vec<u8>) -> End {
    let hints = Hints {
        path: "damaged".to_owned(),
        table: Some(spec.clone()),
    };
    let mut end = End {
        opened: false,
        panicked: false,
        peak: 0,
        read: 0,
    };
    let read = Arc::new(AtomicU64::new(0));
    let file = Counting {
        file: Cursor::new(bytes),
        read: Arc::clone(&read),
    };
    let info = allocation_counter::measure(|| {
        let read = AssertUnwindSafe(|| {
            let source = format.open(Box::new(file), &hints);
            source.map(|mut source| read_all(source.as_mut())).is_ok()
        });
        match catch_unwind(read) {
            Ok(opened) => end.opened = opened,
            Err(_) => end.panicked = true,
        }
    });
    end.peak = info.bytes_max;
    end.read = read.load(Ordering::Relaxed);
    end
}

/// The seed with one to five changes.
fn damaged(seed: &[u8], number: usize) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..6) {
        if bytes.is_empty() {
            bytes.push(rng.random());
        }
        match rng.random() {
            true => change(&mut bytes, &mut rng),
            false => change_structure(&mut bytes, &mut rng),
        }
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    let at = rng.random_range(0..bytes.len());
    let end = (at + rng.random_range(1..100)).min(bytes.len());
    match rng.random_range(0..10) {
        0 => bytes[at] = rng.random(),
        1 => bytes[at] ^= 1 << rng.random_range(0..8),
        2 => drop(bytes.splice(
            at..at,
            (0..rng.random_range(1..9)).map(|_| rng.random::<u8>()),
        )),
        3 => drop(bytes.drain(at..end)),
        4 => {
            let copy = bytes[at..end].to_vec();
            let to = rng.random_range(0..bytes.len());
            drop(bytes.splice(to..to, copy));
        }
        5 => {
            let part = end - at;
            let other = rng.random_range(0..=bytes.len() - part);
            for i in 0..part {
                bytes.swap(at + i, other + i);
            }
        }
        // The half that is kept is the longer one more often than not.
        6 => bytes.truncate(at.max(rng.random_range(0..bytes.len()))),
        7 => bytes[at..end].fill(rng.random_range(b'0'..=b'9')),
        8 => bytes[at..end].fill(0xff),
        _ => overwrite(&mut bytes[at..], rng),
    }
}

/// Puts a number there that is large for its width.
fn overwrite(bytes: &mut [u8], rng: &mut ChaCha8Rng) {
    let width = [2, 4, 8][rng.random_range(0..3)];
    let value = u64::MAX >> rng.random_range(0..63) >> (64 - 8 * width);
    let value = value.wrapping_sub(rng.random_range(0..2));
    let mut number = value.to_le_bytes()[..width].to_vec();
    if rng.random() {
        number.reverse();
    }
    let width = width.min(bytes.len());
    bytes[..width].copy_from_slice(&number[..width]);
}
