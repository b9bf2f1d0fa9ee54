//! Reading speed of universal files beside plain reads of the same bytes. Prints ratios; asserts no
//! timing.
//!
//! `cargo bench --bench uff_read`. Files are made in a temporary folder, 128 MiB each; the one with
//! many functions has 1 GiB where the folder has room for it (`UFF_READ_MIB` in the environment
//! gives another size).

use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use modalign::axis::TimeAxis;
use modalign::io::{
    Block, Encoding, Entry, EntryAxis, Format, FunctionType, Hints, MemorySource, SampleFormat,
    Source, Uff, WriteOptions, open_path,
};

/// Values of a function of the files with few functions.
const FEW: usize = 1 << 20;
/// Values of a function of the file with many functions.
const MANY: usize = 1 << 16;
/// Samples that a stream takes at once.
const AT_ONCE: usize = 1 << 18;
/// Each reading is repeated, and the fastest counts.
const REPEATS: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let mebibytes = std::env::var("UFF_READ_MIB").ok();
    let many: usize = mebibytes.map_or(Ok(1024), |text| text.parse())?;
    for (name, format, encoding) in [
        ("58b, 32 bits", SampleFormat::RealF32, Encoding::Binary),
        ("58b, 64 bits", SampleFormat::RealF64, Encoding::Binary),
        ("58, E13.5", SampleFormat::RealF32, Encoding::Text),
        ("58, E20.12", SampleFormat::RealF64, Encoding::Text),
    ] {
        let path = folder.path().join("few.uff");
        let bytes = match (encoding, format) {
            (Encoding::Text, SampleFormat::RealF32) => 13 * FEW,
            (Encoding::Text, _) => 20 * FEW,
            (_, SampleFormat::RealF32) => 4 * FEW,
            _ => 8 * FEW,
        };
        write(&path, format, encoding, FEW, (128 << 20) / bytes)?;
        measure(name, &path)?;
    }
    let path = folder.path().join("many.uff");
    let functions = many * (1 << 20) / (4 * MANY);
    write(
        &path,
        SampleFormat::RealF32,
        Encoding::Binary,
        MANY,
        functions,
    )?;
    let opening = fastest(|| open(&path).map(|source| source.catalog().entries.len()))?;
    let seconds = opening.as_secs_f64();
    println!("opening {functions} functions in {many} MiB: {seconds:.3} s");
    Ok(())
}

/// Writes a file of equal functions, one piece at a time.
fn write(
    path: &Path,
    format: SampleFormat,
    encoding: Encoding,
    len: usize,
    functions: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    let axis = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 1.0 / 51_200.0,
        len,
    });
    let wave = |i: usize| (i as f64 * 0.37).sin() * 12.5;
    let values = match format {
        SampleFormat::RealF32 => Block::F32((0..len).map(|i| wave(i) as f32).collect()),
        _ => Block::F64((0..len).map(wave).collect()),
    };
    let entry = Entry::new(FunctionType::Time, axis, format);
    let mut source = MemorySource::default();
    source.push(entry, values, Vec::new());
    let options = WriteOptions {
        encoding,
        ..WriteOptions::default()
    };
    let mut one = std::io::Cursor::new(Vec::new());
    Uff.write(&mut one, &mut source, &options)?;
    let mut out = BufWriter::new(File::create(path)?);
    for _ in 0..functions {
        out.write_all(one.get_ref())?;
    }
    Ok(out.flush()?)
}

fn open(path: &Path) -> Result<Box<dyn Source>, Box<dyn std::error::Error>> {
    Ok(open_path(path, &Hints::default(), None)?)
}

fn fastest<T>(
    mut run: impl FnMut() -> Result<T, Box<dyn std::error::Error>>,
) -> Result<Duration, Box<dyn std::error::Error>> {
    let mut best = Duration::MAX;
    for _ in 0..REPEATS {
        let start = Instant::now();
        std::hint::black_box(run()?);
        best = best.min(start.elapsed());
    }
    Ok(best)
}

fn measure(name: &str, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bytes = std::fs::metadata(path)?.len() as f64 / 1e6;
    let mut buffer = vec![0_u8; 1 << 20];
    let mut plain_file = File::open(path)?;
    let plain = fastest(|| {
        plain_file.seek(SeekFrom::Start(0))?;
        while plain_file.read(&mut buffer)? > 0 {}
        Ok(())
    })?;
    let whole = fastest(|| Ok(std::fs::read(path)?))?;
    let mut source = open(path)?;
    let mut block = Block::F64(Vec::new());
    let streamed = fastest(|| stream(source.as_mut(), &mut block))?;
    let entries = fastest(|| entries(path))?;
    let rate = |time: Duration| bytes / time.as_secs_f64();
    println!("{name}: {bytes:.0} MB");
    println!("  plain read, 1 MiB buffer   {:>8.0} MB/s", rate(plain));
    println!("  fs::read                   {:>8.0} MB/s", rate(whole));
    println!(
        "  streamed in ranges         {:>8.0} MB/s, {:.2} of the plain read",
        rate(streamed),
        rate(streamed) / rate(plain)
    );
    println!(
        "  opened, all entries read   {:>8.0} MB/s, {:.2} of fs::read",
        rate(entries),
        rate(entries) / rate(whole)
    );
    Ok(())
}

/// Reads every entry in ranges into one block.
fn stream(source: &mut dyn Source, block: &mut Block) -> Result<(), Box<dyn std::error::Error>> {
    for entry in 0..source.catalog().entries.len() {
        let len = source.catalog().entries[entry].len();
        for start in (0..len).step_by(AT_ONCE) {
            source.read(entry, start..len.min(start + AT_ONCE), block)?;
        }
    }
    Ok(())
}

/// Opens a file and keeps the values of every entry.
fn entries(path: &Path) -> Result<Vec<Block>, Box<dyn std::error::Error>> {
    let mut source = open(path)?;
    let mut blocks = Vec::new();
    for entry in 0..source.catalog().entries.len() {
        let mut block = Block::F32(Vec::new());
        let len = source.catalog().entries[entry].len();
        source.read(entry, 0..len, &mut block)?;
        blocks.push(block);
    }
    Ok(blocks)
}
