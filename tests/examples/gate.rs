//! A run is checked against the limits of its scene and against a baseline, as in continuous
//! integration. The exit code is 0 when all limits are met, 1 when one is missed and 2 on an error.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use modalign::ModalModel;
use modalign::scene::{
    ChangeLimits, ModesOptions, RowVerdict, Scene, TestResult, check_changes, load_modes,
    mode_changes, run,
};

fn only_test(tests: &[TestResult]) -> Result<&TestResult, Box<dyn Error>> {
    match tests {
        [test] => Ok(test),
        _ => Err("expected a scene with one test".into()),
    }
}

/// The modes of an earlier run; in continuous integration the file is kept with the scene.
pub fn baseline(scene: &Scene) -> Result<ModalModel, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("baseline.modes.json");
    std::fs::write(&path, only_test(&run(scene)?.tests)?.modes_json())?;
    Ok(load_modes(&path, &ModesOptions::default())?.modes)
}

/// Prints the failing rows: limits of the scene, and modes that differ from the baseline.
pub fn check(scene: &Scene, baseline: &ModalModel) -> Result<ExitCode, Box<dyn Error>> {
    let result = run(scene)?;
    let limits = ChangeLimits::default();
    let changes = mode_changes(&only_test(&result.tests)?.modes, baseline, &limits);
    let mut rows = check_changes(&changes, limits.false_refusals);
    rows.push(RowVerdict {
        row: "limits of the scene".to_owned(),
        checks: result.limits,
    });
    for row in &rows {
        for check in row.checks.iter().filter(|check| !check.is_met()) {
            let value = check
                .value
                .map_or("-".to_owned(), |value| value.to_string());
            println!(
                "{}, {}: {value}, limit {}",
                row.row, check.what, check.limit
            );
        }
    }
    let missed = rows.iter().filter(|row| !row.is_met()).count();
    println!("{} rows, {missed} missed", rows.len());
    Ok(ExitCode::from(u8::from(missed > 0)))
}

fn gate() -> Result<ExitCode, Box<dyn Error>> {
    let scene = Scene::load(Path::new("measurements/free-free-beam"))?;
    check(&scene, &baseline(&scene)?)
}

/// Exits with the code of the gate.
pub fn main() -> ExitCode {
    gate().unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(2)
    })
}
