//! The examples of the library run, and their results are those of the synthetic recordings.

use std::path::Path;
use std::process::ExitCode;

use modalign::scene::Scene;

#[path = "../examples/gate.rs"]
mod gate;
#[path = "../examples/hits_to_frfs.rs"]
mod hits_to_frfs;
#[path = "../examples/identify.rs"]
mod identify;
#[path = "../examples/pair.rs"]
mod pair;
// Its main reads the arguments of the program, which here are those of the tests.
#[expect(dead_code)]
#[path = "../examples/read_any_file.rs"]
mod read_any_file;
#[path = "../examples/update.rs"]
mod update;

#[test]
fn hits_become_frfs() {
    hits_to_frfs::main().unwrap();
}

#[test]
fn frfs_become_the_six_modes_of_the_bar() {
    identify::main().unwrap();
    let frequencies: Vec<f64> = identify::modes()
        .unwrap()
        .modes
        .iter()
        .map(|mode| mode.frequency_hz.round())
        .collect();
    assert_eq!(frequencies, [143.0, 395.0, 775.0, 1281.0, 1914.0, 2674.0]);
}

#[test]
fn modes_are_paired_with_those_of_a_model() {
    pair::main().unwrap();
}

#[test]
fn updated_parameters_are_those_of_the_recorded_bar() {
    update::main().unwrap();
    let result = update::updated().unwrap();
    assert!(result.fits());
    for (parameter, truth) in result.parameters.iter().zip([2.04e11, 0.012]) {
        let deviation = (parameter.updated - truth) / parameter.std;
        assert!(deviation.abs() < 4.0, "{}: {deviation}", parameter.name);
    }
}

#[test]
fn a_missed_limit_or_a_changed_mode_is_exit_code_1() {
    assert_eq!(gate::main(), ExitCode::SUCCESS);
    let scene = Scene::load(Path::new("measurements/free-free-beam")).unwrap();
    let baseline = gate::baseline(&scene).unwrap();
    let mut strict = scene.clone();
    strict.limits.max_frequency_error_percent = Some(2.0);
    let mut changed = baseline.clone();
    changed.modes[1].frequency_hz *= 1.001;
    for (scene, baseline) in [(&strict, &baseline), (&scene, &changed)] {
        assert_eq!(gate::check(scene, baseline).unwrap(), ExitCode::from(1));
    }
}

#[test]
fn records_of_a_file_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let path = read_any_file::write_recording(folder.path()).unwrap();
    read_any_file::list(&path).unwrap();
}
