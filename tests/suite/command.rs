//! Runs the program as a user does.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Path of the program.
pub fn program() -> PathBuf {
    let stated = std::env::var_os("CARGO_BIN_EXE_modalign");
    stated.map_or_else(|| env!("CARGO_BIN_EXE_modalign").into(), PathBuf::from)
}

/// The program, which signals end although the suite may run under `nohup`, whose programs ignore
/// them.
pub fn interruptible() -> Command {
    if !cfg!(target_os = "linux") {
        return Command::new(program());
    }
    let mut command = Command::new("env");
    command.arg("--default-signal").arg(program());
    command
}

/// The program with these arguments, in the project's folder.
pub fn modalign<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    modalign_in(root(), arguments)
}

/// The program with these arguments, in a folder.
pub fn modalign_in<S: AsRef<std::ffi::OsStr>>(
    folder: &Path,
    arguments: impl IntoIterator<Item = S>,
) -> Output {
    Command::new(program())
        .current_dir(folder)
        .env_remove("COLUMNS")
        .args(arguments)
        .output()
        .unwrap()
}

/// Standard output of a run that must end with exit code 0.
pub fn succeed<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> String {
    let output = modalign(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{error}");
    String::from_utf8(output.stdout).unwrap()
}

/// Standard error of a run that must end with exit code 2 and print no result.
pub fn fail<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> String {
    let output = modalign(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(output.stdout.is_empty(), "an error prints no result");
    error
}

/// The project's folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// An empty folder for what several tests of one file share: a `static` is never dropped, so a
/// temporary folder would stay behind after each run.
pub fn shared_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The scene of the beam with an eighth of its record, in a folder.
pub fn short_beam(folder: &Path) -> String {
    let beam = root().join("measurements/free-free-beam");
    for name in ["scene.toml", "model.toml", "synth.toml", "expected.toml"] {
        let text = std::fs::read_to_string(beam.join(name)).unwrap();
        let text = text.replace("samples = 32768", "samples = 4096");
        std::fs::write(folder.join(name), text).unwrap();
    }
    folder.to_str().unwrap().to_owned()
}

/// Asserts that a text, perhaps wrapped, has every sentence of these lists of a JSON.
pub fn assert_has_sentences(text: &str, json: &serde_json::Value, keys: &[&str]) {
    let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = one_line(text);
    for key in keys {
        let sentences = json[key].as_array().unwrap();
        assert!(!sentences.is_empty(), "{key}");
        for sentence in sentences {
            let sentence = one_line(sentence.as_str().unwrap());
            assert!(text.contains(&sentence), "{key}: {sentence}\n{text}");
        }
    }
}

/// JSON of a file.
pub fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The private recordings; a line on standard error and `None` where they are absent.
pub fn shared_data() -> Option<PathBuf> {
    let places = ["../shared/data", "../../shared/data"];
    let found = places
        .iter()
        .map(|place| root().join(place))
        .find(|place| place.is_dir());
    if found.is_none() {
        let _ = std::io::stderr().write_all(b"skipped: no reference data\n");
    }
    found
}

/// Writes files into a folder.
pub fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
}
