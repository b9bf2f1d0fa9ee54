//! Faults from outside: no space, targets that cannot be written, kills, interrupts, inputs that
//! shrink. Existing files stay unchanged, no partial file has a final name, and the exit code
//! is 2.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

#[cfg(target_os = "linux")]
use rand::{Rng, SeedableRng, seq::SliceRandom};
#[cfg(target_os = "linux")]
use rand_chacha::ChaCha8Rng;

use crate::command::{fail, interruptible, modalign, root, succeed, write};

/// What a folder holds, by name.
pub fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.is_file())
        .map(|path| (path.clone(), std::fs::read(path).unwrap()))
        .collect()
}

/// A folder with a short recording, its FRFs and modes, and results of an earlier day under every
/// name that verbs write.
pub fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(beam.join(name)).unwrap();
    let spec = text("synth.toml").replace("samples = 32768", "samples = 2048");
    let scene = text("scene.toml");
    write(
        folder.path(),
        &[
            ("scene.toml", &scene),
            ("model.toml", &text("model.toml")),
            ("synth.toml", &spec),
        ],
    );
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    succeed(["synth", &path("synth.toml"), "-o", &path("hits.uff")]);
    succeed(["frf", &path("hits.uff"), "-o", &path("frfs.h5")]);
    succeed([
        "identify",
        &path("frfs.h5"),
        "--method",
        "circle",
        "--band",
        "60:3200",
        "-o",
        &path("modes.json"),
    ]);
    std::fs::create_dir(folder.path().join("out")).unwrap();
    folder
}

/// Every verb that writes, as it is typed in the prepared folder, with the files that it would
/// write to `out`.
const WRITING: &[(&str, &[&str])] = &[
    (
        "synth synth.toml -o out/new.uff",
        &["new.uff", "new.modes.json"],
    ),
    ("convert hits.uff -o out/new.uff", &["new.uff"]),
    ("convert hits.uff -o out/new.h5", &["new.h5"]),
    ("convert hits.uff -o out/new.mat", &["new.mat"]),
    ("convert hits.uff -o out/new.npz", &["new.npz"]),
    (
        "frf hits.uff --response-window none -o out/new.csv",
        &["new.csv"],
    ),
    ("frf hits.uff -o out/new.h5", &["new.h5"]),
    (
        "identify frfs.h5 --method circle --band 60:3200 -o out/new.json",
        &["new.json"],
    ),
    (
        "identify frfs.h5 --method circle --band 60:3200 -o out/new.uff",
        &["new.uff"],
    ),
    (
        "identify frfs.h5 --method circle --band 60:3200 --indicators out/new.csv",
        &["new.csv"],
    ),
    ("theory . -o out/new.json", &["new.json"]),
    (
        "correlate --test modes.json --theory . --measures -o out/new.json",
        &["new.json"],
    ),
    (
        "run . -o out",
        &[
            "comparison.json",
            "comparison.md",
            "comparison.txt",
            "comparison.tex",
            "roving-hammer.modes.json",
        ],
    ),
    (
        "update . -o out",
        &[
            "update.json",
            "model.toml",
            "comparison-after.json",
            "update.md",
        ],
    ),
];

#[cfg(unix)]
#[test]
fn with_no_space_earlier_results_stay_and_nothing_new_comes() {
    let folder = prepared();
    let out = folder.path().join("out");
    for (line, names) in WRITING {
        for old in content(&out).into_keys() {
            std::fs::remove_file(old).unwrap();
        }
        for name in *names {
            std::fs::write(out.join(name), "of an earlier day").unwrap();
        }
        let before = content(&out);
        // Files of at most 1 KiB: the system refuses the rest, as a full disk does.
        let program = crate::command::program();
        let script = format!(
            "trap '' XFSZ; ulimit -f 1; exec {} {line}",
            program.display()
        );
        let mut shell = Command::new("bash");
        let output = shell
            .current_dir(folder.path())
            .args(["-c", &script])
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {error}");
        assert!(error.contains("cannot write"), "{line}: {error}");
        assert!(
            output.stdout.is_empty(),
            "{line}: no result beside an error"
        );
        assert!(
            content(&out) == before,
            "{line} left {:?}",
            content(&out).keys()
        );
        // With space the same line writes every name.
        let mut shell = Command::new(&program);
        let output = shell
            .current_dir(folder.path())
            .args(line.split(' '))
            .output()
            .unwrap();
        assert!(
            matches!(output.status.code(), Some(0 | 1)),
            "{line}: {output:?}"
        );
        for name in *names {
            assert_ne!(
                std::fs::read(out.join(name)).unwrap(),
                b"of an earlier day",
                "{line}: {name}"
            );
        }
    }
}

#[test]
fn an_unwritable_target_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    write(folder.path(), &[("file", "of an earlier day")]);
    std::fs::create_dir(path("folder.json")).unwrap();
    for target in ["file/new.json", "folder.json"] {
        let error = fail(["theory", "cycloid-ball", "-o", &path(target)]);
        assert!(
            error.contains(&path(target)) && error.contains("cannot "),
            "{error}"
        );
    }
    let error = fail(["run", "measurements/free-free-beam", "-o", &path("file")]);
    assert!(
        error.contains(&path("file")) && error.contains("cannot "),
        "{error}"
    );
    assert_eq!(std::fs::read(path("file")).unwrap(), b"of an earlier day");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    assert_eq!(std::fs::read_dir(path("folder.json")).unwrap().count(), 0);
}

/// A script in the project's folder; `PROGRAM` is the path of the program.
#[cfg(target_os = "linux")]
fn bash(script: &str) -> std::process::Output {
    let program = crate::command::program();
    let script = script.replace("PROGRAM", &program.display().to_string());
    let mut shell = Command::new("bash");
    let output = shell.current_dir(root()).args(["-c", &script]).output();
    output.unwrap()
}

/// Standard error, with the exit code as its last line, of a verb whose reader is gone before
/// anything is written.
#[cfg(target_os = "linux")]
fn without_reader(verb: &str) -> String {
    let piped = bash(&format!("(sleep 0.2; PROGRAM {verb}; echo $? >&2) | true"));
    String::from_utf8(piped.stderr).unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error_and_a_closed_one_is_not() {
    let full = bash("PROGRAM theory cycloid-ball > /dev/full");
    assert_eq!(full.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&full.stderr).contains("standard output"),
        "{full:?}"
    );
    for verb in [
        "theory cycloid-ball --energies",
        "completions bash",
        "--help",
        "theory cycloid-ball --json",
    ] {
        let error = without_reader(verb);
        assert_eq!(error.lines().last(), Some("0"), "{verb}: {error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_closed_standard_output_keeps_the_verdict_and_the_findings() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mode = "[[limits.mode]]\nfrequency_hz = 1\nmax_frequency_error_percent = 1\n";
    let table = "frequency_hz,1:+Z/1:+Z re,1:+Z/1:+Z im\n1,1,0\n2,1,x\n";
    write(
        folder.path(),
        &[("missed.toml", mode), ("damaged.csv", table)],
    );
    succeed(["theory", "cycloid-ball", "-o", &path("modes.json")]);
    let (modes, missed) = (path("modes.json"), path("missed.toml"));
    for (verb, code) in [
        (format!("check {modes} --against {missed}"), "1"),
        (format!("check {modes} --against {missed} --json"), "1"),
        (format!("check {modes} --against {modes}"), "0"),
        (format!("inspect {}", path("absent.uff")), "2"),
    ] {
        let error = without_reader(&verb);
        assert_eq!(error.lines().last(), Some(code), "{verb}: {error}");
    }
    let verb = format!("inspect {}", path("damaged.csv"));
    let read = modalign(verb.split(' '));
    let expected = String::from_utf8(read.stderr).unwrap();
    assert_eq!(read.status.code(), Some(1), "{expected}");
    assert!(!expected.is_empty());
    assert_eq!(without_reader(&verb), format!("{expected}1\n"));
}

/// The program in a folder, running.
fn spawned(folder: &Path, line: &str) -> Child {
    let mut command = interruptible();
    command.current_dir(folder).args(line.split(' '));
    command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Whether a folder holds a file that is being written.
fn is_written(folder: &Path) -> bool {
    let name = |path: &PathBuf| {
        path.file_name()
            .unwrap()
            .to_string_lossy()
            .starts_with(".modalign-")
    };
    content(folder)
        .iter()
        .any(|(path, bytes)| name(path) && !bytes.is_empty())
}

#[test]
fn a_kill_while_writing_leaves_the_earlier_result() {
    let folder = tempfile::tempdir().unwrap();
    // Large enough that its text takes a while to write.
    let rows: String = (0..400_000)
        .map(|i| format!("{}e-5,{}\n", i, i % 977))
        .collect();
    write(
        folder.path(),
        &[(
            "a.csv",
            &format!("time [s],record 1:+Z|1:+Z hit 1 [m/s2]\n{rows}"),
        )],
    );
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("new.uff"), "of an earlier day").unwrap();
    let mut caught = 0;
    for _ in 0..5 {
        let mut child = spawned(folder.path(), "convert a.csv --text -o out/new.uff");
        while child.try_wait().unwrap().is_none() {
            if is_written(&out) {
                child.kill().unwrap();
                break;
            }
        }
        let ended = child.wait_with_output().unwrap();
        if ended.status.success() {
            continue;
        }
        assert_eq!(ended.status.code(), None, "killed: {ended:?}");
        caught += 1;
        assert_eq!(
            std::fs::read(out.join("new.uff")).unwrap(),
            b"of an earlier day"
        );
    }
    assert!(caught > 0, "a kill came while the file was written");
}

/// Kills of the test below, unless `KILLS` states another number; 200 take some minutes.
#[cfg(target_os = "linux")]
const KILLS: usize = 6;

/// The contents of a folder and of those in it, hidden files too.
#[cfg(target_os = "linux")]
fn whole_content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = content(folder);
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(whole_content(&path));
        }
    }
    all
}

#[cfg(target_os = "linux")]
fn is_hidden(path: &Path) -> bool {
    path.file_name().unwrap().to_string_lossy().starts_with('.')
}

/// A line of [`WRITING`] with the contents of `out` before and after, and its time.
#[cfg(target_os = "linux")]
struct Replacement {
    line: &'static str,
    earlier: BTreeMap<PathBuf, Vec<u8>>,
    later: BTreeMap<PathBuf, Vec<u8>>,
    time: Duration,
}

#[cfg(target_os = "linux")]
impl Replacement {
    /// Results of the same scene with another title, or texts, are replaced.
    fn new(folder: &Path, (line, names): (&'static str, &[&str])) -> Self {
        let (out, file) = (folder.join("out"), folder.join("scene.toml"));
        std::fs::remove_dir_all(&out).unwrap();
        std::fs::create_dir(&out).unwrap();
        let finish = |line: &str| {
            let ended = spawned(folder, line).wait_with_output().unwrap();
            assert!(matches!(ended.status.code(), Some(0 | 1)), "{ended:?}");
        };
        if line.ends_with("-o out") {
            let scene = std::fs::read_to_string(&file).unwrap();
            std::fs::write(&file, scene.replace("title = \"", "title = \"Earlier, ")).unwrap();
            finish(line);
            std::fs::write(&file, scene).unwrap();
        } else {
            for name in names {
                std::fs::write(out.join(name), "of an earlier day").unwrap();
            }
        }
        let earlier = whole_content(&out);
        let begin = std::time::Instant::now();
        finish(line);
        Self {
            line,
            earlier,
            later: whole_content(&out),
            time: begin.elapsed(),
        }
    }

    /// Ends the line at a moment by a signal, checks what it left, and runs it again. Whether the
    /// signal came before the end.
    fn interrupt(&self, folder: &Path, signal: &str, moment: f64, while_writing: bool) -> bool {
        let out = folder.join("out");
        std::fs::remove_dir_all(&out).unwrap();
        for (path, bytes) in &self.earlier {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        let mut child = spawned(folder, self.line);
        if while_writing {
            // Files are replaced within milliseconds after the first hidden one is there.
            while child.try_wait().unwrap().is_none() && !is_written(&out) {}
            std::thread::sleep(Duration::from_secs_f64(0.0025 * moment));
        } else {
            std::thread::sleep(self.time.mul_f64(moment));
        }
        if child.try_wait().unwrap().is_none() {
            let id = child.id().to_string();
            let sent = Command::new("kill").args(["-s", signal, &id]).status();
            sent.unwrap();
        }
        let ended = child.wait_with_output().unwrap();
        let is_caught = !matches!(ended.status.code(), Some(0 | 1));
        let case = format!("{} after {signal} at {moment}", self.line);
        let mut found = whole_content(&out);
        if signal == "TERM" {
            assert!(
                !found.keys().any(|path| is_hidden(path)),
                "{case}: {found:?}"
            );
        }
        found.retain(|path, _| !is_hidden(path));
        let is_one = found == self.earlier || found == self.later;
        let has_manifest = self.later.contains_key(&out.join("manifest.json"));
        assert!(
            is_one || !has_manifest || modalign::io::check_results(&out).is_err(),
            "{case}: a mixture of two runs is not refused"
        );
        for (path, bytes) in &found {
            let whole = [self.earlier.get(path), self.later.get(path)];
            // The manifest is marked before the first result is replaced.
            let is_manifest = path.ends_with("manifest.json");
            assert!(
                is_manifest || whole.contains(&Some(bytes)),
                "{case}: {} is neither",
                path.display()
            );
        }
        let again = spawned(folder, self.line).wait_with_output().unwrap();
        assert!(
            matches!(again.status.code(), Some(0 | 1)),
            "{case}: {again:?}"
        );
        let (found, later) = (whole_content(&out), &self.later);
        assert!(
            found == *later,
            "{case}: {:?}, expected {:?}",
            found.keys(),
            later.keys()
        );
        is_caught
    }
}

#[cfg(target_os = "linux")]
#[test]
fn killed_verbs_leave_old_or_new_results_or_a_mixture_that_is_refused() {
    let folder = prepared();
    let kills = crate::mutation::stated("KILLS", KILLS);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut lines: Vec<_> = WRITING.to_vec();
    lines.shuffle(&mut random);
    let used = kills.min(lines.len());
    let mut caught = 0;
    for (number, line) in lines[..used].iter().enumerate() {
        let replacement = Replacement::new(folder.path(), *line);
        for kill in (number..kills).step_by(used) {
            let signal = ["KILL", "TERM"][(kill / used + number) % 2];
            let moment = random.random_range(0.0..1.0);
            let while_writing = random.random();
            if replacement.interrupt(folder.path(), signal, moment, while_writing) {
                caught += 1;
            }
        }
    }
    assert!(caught > 0, "no signal came before the end of its line");
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_with_a_clear_word_and_leaves_the_earlier_results() {
    let folder = prepared();
    let out = folder.path().join("out");
    write(&out, &[("comparison.json", "of an earlier day")]);
    let before = content(&out);
    let pipe = folder.path().join("pipe.uff");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let scene = std::fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    write(
        folder.path(),
        &[(
            "scene.toml",
            &scene.replace("synth = \"synth.toml\"", "files = [\"pipe.uff\"]"),
        )],
    );
    for signal in ["INT", "TERM"] {
        let child = spawned(folder.path(), "run . -o out");
        // Opening it waits until the program reads: then its handler is in place, and nothing ever
        // comes.
        let held = std::fs::OpenOptions::new().write(true).open(&pipe).unwrap();
        std::thread::sleep(Duration::from_millis(50));
        let kill = Command::new("kill")
            .args([format!("-{signal}"), child.id().to_string()])
            .status();
        assert!(kill.unwrap().success());
        let ended = child.wait_with_output().unwrap();
        drop(held);
        let error = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{error}");
        assert!(error.contains("error: interrupted"), "{error}");
        assert!(ended.stdout.is_empty());
        assert!(content(&out) == before);
    }
}

#[test]
fn an_input_that_is_cut_short_during_the_run_leaves_the_earlier_results() {
    let folder = prepared();
    let out = folder.path().join("out");
    write(&out, &[("comparison.json", "of an earlier day")]);
    let before = content(&out);
    let hits = std::fs::read(folder.path().join("hits.uff")).unwrap();
    let scene = std::fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    write(
        folder.path(),
        &[(
            "scene.toml",
            &scene.replace("synth = \"synth.toml\"", "files = [\"hits.uff\"]"),
        )],
    );
    let arguments = [
        "run",
        folder.path().to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
    ];
    for part in [1, 3, 7] {
        std::fs::write(
            folder.path().join("hits.uff"),
            &hits[..hits.len() * part / 8],
        )
        .unwrap();
        let output = modalign(arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(content(&out) == before);
    }
}
