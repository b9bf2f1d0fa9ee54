//! A file of any supported format is opened, and its records and functions are listed with its
//! findings. The path is the first argument; without one a synthetic recording is written to a
//! temporary folder and listed.

use std::error::Error;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use modalign::io::{EntryAxis, Hints, open_path};
use modalign::scene::{hammer_test, load_synth, record};

/// Writes a universal file with one hit at each of eleven points.
pub fn write_recording(folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let spec_path = Path::new("measurements/free-free-beam/synth.toml");
    let mut spec = load_synth(spec_path)?;
    spec.averages = 1;
    let recorded = record(&spec, &hammer_test(&spec, spec_path)?, spec_path)?;
    let path = folder.join("hits.uff");
    std::fs::write(&path, recorded.uff)?;
    Ok(path)
}

fn axis_text(axis: EntryAxis) -> String {
    match axis {
        EntryAxis::Time(time) => format!("{} samples at {} Hz", time.len, time.sampling_rate_hz()),
        EntryAxis::Frequency(axis) => {
            let (lines, start, step) = (axis.len, axis.start_hz, axis.step_hz);
            format!("{lines} lines from {start} Hz by {step} Hz")
        }
        EntryAxis::General(axis) => {
            format!("{} values, uneven, or neither time nor frequency", axis.len)
        }
    }
}

/// A value that a header may not state.
fn text(value: Option<impl Display>) -> String {
    value.map_or("-".to_owned(), |value| value.to_string())
}

/// Prints response and reference as point and direction, quantity, unit and axis of each record.
pub fn list(path: &Path) -> Result<(), Box<dyn Error>> {
    let hints = Hints {
        path: path.display().to_string(),
        ..Hints::default()
    };
    let source = open_path(path, &hints, None)?;
    let catalog = source.catalog();
    println!("{} ({})", catalog.path, catalog.format);
    println!("type       response  reference  quantity      unit        axis");
    for entry in &catalog.entries {
        let unit = Some(&entry.unit_label).filter(|unit| !unit.is_empty());
        println!(
            "{:9}  {:8}  {:9}  {:12}  {:10}  {}",
            entry.function_type.name(),
            text(entry.response.as_ref()),
            text(entry.reference.as_ref()),
            text(entry.quantity),
            text(unit),
            axis_text(entry.axis),
        );
    }
    for finding in &catalog.findings {
        println!("{}: {finding}", finding.severity);
    }
    Ok(())
}

/// Lists the file of the first argument.
pub fn main() -> Result<(), Box<dyn Error>> {
    if let Some(path) = std::env::args_os().nth(1) {
        return list(Path::new(&path));
    }
    let folder = tempfile::tempdir()?;
    list(&write_recording(folder.path())?)
}
