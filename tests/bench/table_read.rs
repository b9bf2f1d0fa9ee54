//! Speed of reading a text table: four columns of 9 to 17 digits, against a plain read of the same
//! file.
//!
//! `cargo bench --bench table_read [-- MEGABYTES [FILE]]` prints the figures and asserts none; FILE
//! keeps the table.

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use modalign::io::{Block, ColumnName, ColumnRole, Hints, TableColumn, TableSpec, open_path};

/// Runs of which the fastest counts.
const RUNS: usize = 3;

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let megabytes = arguments
        .first()
        .and_then(|text| text.parse().ok())
        .unwrap_or(100);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = arguments
        .get(1)
        .map_or_else(|| folder.path().join("table.csv"), PathBuf::from);
    write_table(&path, megabytes * 1_000_000);
    let size = std::fs::metadata(&path).expect("the table").len() as f64 / 1e6;
    let plain = fastest(|| read_plain(&path));
    let table = fastest(|| read_table(&path));
    println!("table of {size:.0} MB, fastest of {RUNS} runs");
    println!("plain read    {plain:7.3} s  {:8.0} MB/s", size / plain);
    println!("table read    {table:7.3} s  {:8.0} MB/s", size / table);
    println!("ratio         {:7.1}", table / plain);
}

/// Seconds of the fastest run.
fn fastest(mut run: impl FnMut()) -> f64 {
    let seconds = (0..RUNS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    seconds.fold(f64::INFINITY, f64::min)
}

/// Time, force and two responses: printed with 9 digits, with 12, and as short as gives the double
/// back.
fn write_table(path: &Path, bytes: usize) {
    let mut out = BufWriter::new(File::create(path).expect("a new file"));
    let mut written = 0;
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    written += out.write(b"time,force,a,b\n").expect("written");
    let mut row = 0u32;
    while written < bytes {
        let time = f64::from(row) / 51_200.0;
        let (force, a, b) = (1e3 * random(), 20.0 * random(), random());
        let line = format!("{time:.9},{force:.8e},{a:.11},{b:?}\n");
        out.write_all(line.as_bytes()).expect("written");
        written += line.len();
        row += 1;
    }
}

fn read_plain(path: &Path) {
    let mut buffer = vec![0; 1 << 20];
    let mut file = File::open(path).expect("the table");
    let mut sum = 0usize;
    loop {
        let count = file.read(&mut buffer).expect("read");
        if count == 0 {
            break;
        }
        sum += count + usize::from(buffer[0]);
    }
    std::hint::black_box(sum);
}

fn read_table(path: &Path) {
    let response = || ColumnRole::Response {
        dof: None,
        unit: "m/s2".parse().expect("a unit"),
    };
    let force = ColumnRole::Force {
        dof: None,
        unit: "N".parse().expect("a unit"),
    };
    let roles = [
        ("time", ColumnRole::Time),
        ("force", force),
        ("a", response()),
        ("b", response()),
    ];
    let columns = roles.map(|(name, role)| TableColumn {
        column: ColumnName::Heading(name.to_owned()),
        role,
        scale: 1.0,
    });
    let hints = Hints {
        path: path.display().to_string(),
        table: Some(TableSpec {
            columns: columns.to_vec(),
            ..TableSpec::default()
        }),
    };
    let mut source = open_path(path, &hints, None).expect("a table");
    assert!(source.catalog().damage.is_empty());
    let mut block = Block::F64(Vec::new());
    source.read(2, 0..1000, &mut block).expect("samples");
    std::hint::black_box(block);
}
