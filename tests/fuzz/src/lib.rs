//! The inputs of the program as targets of a fuzzer: a reader of recordings by its format, or a
//! text by its kind.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

use modalign::frf::{HammerOptions, evaluate_hammer_test};
use modalign::identify::{ESTIMATORS, IdentifyOptions, identification};
use modalign::io::{
    Encoding, FORMATS, Format, Hints, HitFile, HitGrouping, Source, TableSpec, WriteOptions,
    frf_sets, group_hits, modal_model_of,
};
use modalign::record::Recording;
use tempfile::TempDir;

#[path = "../../population/packing.rs"]
pub mod packing;
#[path = "../../population/readers.rs"]
pub mod readers;
mod seed_files;
#[path = "../../population/seeds.rs"]
pub mod seeds;
#[path = "../../support/text_inputs.rs"]
pub mod text_inputs;

use packing::Packing;
use readers::{READERS, Reader, read_all};
use text_inputs::{TEXT_INPUTS, TextInput};

pub use seed_files::write_seeds;

/// Hits with more samples are not evaluated: they take time and nothing else.
const MAX_EVALUATED_SAMPLES: usize = 1 << 15;

/// FRFs with more values are not identified, for the same reason.
const MAX_IDENTIFIED_VALUES: usize = 1 << 9;

/// The project.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The names of all targets.
pub fn names() -> BTreeSet<&'static str> {
    let readers = READERS.iter().map(|reader| reader.name);
    readers
        .chain(TEXT_INPUTS.iter().map(|input| input.name))
        .collect()
}

/// The lines of [`READERS`] of a format. The first byte of an input chooses one of them,
/// and the format in which the file is written again.
pub fn readers_of(name: &str) -> Vec<&'static Reader> {
    READERS
        .iter()
        .filter(|reader| reader.name == name)
        .collect()
}

/// A target, ready for its inputs.
pub enum Target {
    /// A recording, read as a line of [`READERS`] says.
    Recording(&'static dyn Format, Vec<Packed>),
    /// A text, in a folder with the files that it may name.
    Text(&'static TextInput, TempDir),
}

/// How the bytes of an input become a file, and what a scene says of it.
pub struct Packed {
    packing: Packing,
    spec: TableSpec,
    /// Length of each seed, with its parts that a check sum follows.
    sealed: Vec<(usize, Vec<Range<usize>>)>,
}

impl Packed {
    fn new(reader: &Reader) -> Self {
        let seal = |seed: Vec<u8>| (seed.len(), reader.packing.check_sums(&seed));
        Self {
            packing: reader.packing,
            spec: (reader.spec)(),
            sealed: (reader.seeds)().into_iter().map(seal).collect(),
        }
    }

    /// An input of the length of a seed keeps its check sums where that seed has them.
    fn file(&self, bytes: &[u8]) -> Vec<u8> {
        let seed = self
            .sealed
            .iter()
            .find(|(length, _)| *length == bytes.len());
        let sums = seed.map_or(&[][..], |(_, sums)| sums);
        self.packing.pack(bytes.to_vec(), bytes.len(), sums)
    }
}

impl Target {
    /// The target of this name.
    pub fn named(name: &str) -> Option<Self> {
        if let Some(input) = TEXT_INPUTS.iter().find(|input| input.name == name) {
            let folder = tempfile::tempdir().unwrap();
            for file in ["model.toml", "synth.toml", "expected.toml"] {
                let bar = root().join("measurements/free-free-beam");
                std::fs::copy(bar.join(file), folder.path().join(file)).unwrap();
            }
            return Some(Self::Text(input, folder));
        }
        let format = FORMATS.iter().find(|format| format.name() == name)?;
        let readers = readers_of(name).into_iter().map(Packed::new).collect();
        Some(Self::Recording(*format, readers))
    }

    /// Reads and uses an input.
    pub fn run(&self, input: &[u8]) {
        match self {
            Self::Text(kind, folder) => {
                if let Ok(text) = std::str::from_utf8(input) {
                    (kind.used)(text, folder.path());
                }
            }
            Self::Recording(format, readers) => {
                let Some((choice, bytes)) = input.split_first() else {
                    return;
                };
                let reader = &readers[usize::from(*choice) % readers.len()];
                let hints = Hints {
                    path: "input".to_owned(),
                    table: Some(reader.spec.clone()),
                };
                let file = Cursor::new(reader.file(bytes));
                if let Ok(mut source) = format.open(Box::new(file), &hints) {
                    write_as(usize::from(*choice) / readers.len(), source.as_mut());
                    use_recording(usize::from(*choice) / readers.len(), source);
                }
            }
        }
    }
}

/// Writes a file in one of the formats that are written.
fn write_as(choice: usize, source: &mut dyn Source) {
    let mut formats = FORMATS.iter().cycle();
    let is_written = |format: &&&dyn Format| !format.written_extensions().is_empty();
    let format = formats.by_ref().filter(is_written).nth(choice).unwrap();
    let options = WriteOptions {
        encoding: [Encoding::Binary, Encoding::Text][choice % 2],
        ..WriteOptions::default()
    };
    let _ = format.write(&mut Cursor::new(Vec::new()), source, &options);
}

/// The modes, FRFs and hits of a file; a few FRFs become modes by one of the methods, short hits
/// become FRFs.
fn use_recording(choice: usize, mut source: Box<dyn Source>) {
    read_all(source.as_mut());
    let _ = modal_model_of(source.catalog(), Vec::new());
    let mut files = vec![HitFile::new(source)];
    let method = ESTIMATORS[choice % ESTIMATORS.len()].name;
    let options = IdentifyOptions {
        method: method.to_owned(),
        ..IdentifyOptions::default()
    };
    for set in frf_sets(&mut files).unwrap_or_default() {
        if set.len() * set.axis().len <= MAX_IDENTIFIED_VALUES {
            let _ = identification(&set, &options);
        }
    }
    let Ok(mut hits) = group_hits(files, HitGrouping::Records, &[]) else {
        return;
    };
    let samples = hits.recording.hits().iter().map(|hit| {
        let channels = 1 + hit.responses.len();
        hit.axis.len.saturating_mul(channels)
    });
    if samples.fold(0_usize, usize::saturating_add) <= MAX_EVALUATED_SAMPLES {
        let _ = evaluate_hammer_test(&mut hits.recording, &HammerOptions::default());
    }
}
