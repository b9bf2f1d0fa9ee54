//! Time of all modes of dense pairs, checks included, beside numpy's LAPACK on the same matrices,
//! and the part of the time that the checks take. Prints ratios; asserts no timing.
//!
//! `cargo bench --bench dense_modes`; with `-- 2000` a table of all specimens up to 2,000
//! coordinates follows. numpy is run with the Python that `MODALIGN_PYTHON` names, else `python3`,
//! by `tests/reference/dense_eigh.py`, on one thread; without it the bench prints the time of this
//! library alone.

#[path = "../support/extended_precision.rs"]
#[allow(dead_code)]
mod extended_precision;
#[path = "../support/matrix_zoo.rs"]
#[allow(dead_code)]
mod matrix_zoo;

use std::error::Error;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use modalign::linalg::{RealMatrix, symmetric_modes, verify};

use matrix_zoo::{Ends, Specimen};

/// Each is solved so often, and the fastest counts.
const REPEATS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    println!("one thread each; time over numpy's; fraction of the time for the check alone");
    for size in [35, 100, 300, 1000] {
        let elements = (size - 2) / 2;
        for (name, (k, m)) in [
            ("random", matrix_zoo::random(size)),
            ("free beam", matrix_zoo::beam(elements, Ends::Free)),
            ("graded", matrix_zoo::graded(size, 12.0)),
        ] {
            row(name, &k, &m)?;
        }
    }
    // Given a size, as `-- 2000`: every specimen up to it beside extended precision.
    if let Some(largest) = std::env::args().find_map(|argument| argument.parse().ok()) {
        table(largest)?;
    }
    Ok(())
}

fn row(name: &str, k: &RealMatrix, m: &RealMatrix) -> Result<(), Box<dyn Error>> {
    let (mut solved, mut checked) = (f64::MAX, f64::MAX);
    for _ in 0..REPEATS {
        let start = Instant::now();
        let modes = symmetric_modes(k, m)?;
        solved = solved.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        verify::symmetric_modes(k, m, &modes)?;
        checked = checked.min(start.elapsed().as_secs_f64());
    }
    let beside = match numpy(k, m)? {
        Some((seconds, residual)) => format!(
            "{:.2} of numpy's {seconds:.4} s (its residual {residual})",
            solved / seconds
        ),
        None => "numpy was not found".to_owned(),
    };
    println!(
        "{:5} {name:10} {solved:.4} s, {beside}; check {:.2}",
        k.nrows(),
        checked / solved
    );
    Ok(())
}

/// Residual, orthogonality and errors of every specimen, with its time over numpy's.
fn table(largest: usize) -> Result<(), Box<dyn Error>> {
    println!(
        "| specimen | n | residual | orthogonality | error | rounding bound | error over limit | time over numpy's |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for specimen in matrix_zoo::zoo(largest) {
        let Specimen {
            stiffness, mass, ..
        } = &specimen;
        let start = Instant::now();
        symmetric_modes(stiffness, mass)?;
        let solved = start.elapsed().as_secs_f64();
        let ratio =
            numpy(stiffness, mass)?.map_or(String::new(), |(s, _)| format!("{:.2}", solved / s));
        let row = extended_precision::compared(&specimen)?;
        println!(
            "| {} | {} | {:.0e} | {:.0e} | {:.1e} | {:.1e} | {:.1e} | {ratio} |",
            row.name,
            row.size,
            row.residual,
            row.orthogonality,
            row.error,
            row.rounding,
            row.error_over_limit
        );
    }
    Ok(())
}

/// Seconds and residual of numpy on the same matrices.
fn numpy(k: &RealMatrix, m: &RealMatrix) -> Result<Option<(f64, String)>, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    for (name, matrix) in [("k.f64", k), ("m.f64", m)] {
        let columns = (0..matrix.ncols()).flat_map(|j| matrix.col(j).iter());
        let bytes: Vec<u8> = columns.flat_map(|value| value.to_le_bytes()).collect();
        std::fs::write(folder.path().join(name), bytes)?;
    }
    let python = std::env::var("MODALIGN_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/dense_eigh.py");
    let run = Command::new(python)
        .arg(script)
        .arg(folder.path())
        .arg(k.nrows().to_string())
        .env("OPENBLAS_NUM_THREADS", "1")
        .output();
    let Some(output) = run.ok().filter(|output| output.status.success()) else {
        return Ok(None);
    };
    let text = String::from_utf8(output.stdout)?;
    let field = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        line.map(str::trim).ok_or("the script prints each field")
    };
    Ok(Some((
        field("seconds")?.parse()?,
        field("residual")?.to_owned(),
    )))
}
