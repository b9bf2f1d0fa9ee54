//! How results are written: through links and into devices, with the permissions that were there,
//! with few open files, and so that a folder that a kill left half written is recognised.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs::{self, Permissions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::command::{modalign_in, root, write};

const LIMITS: &str = "[[limits.mode]]\nfrequency_hz = 1\nmax_frequency_error_percent = 1\n";

/// Runs a line of bash, in which `modalign` is the program, in a folder.
fn bash(folder: &Path, line: &str) -> Output {
    let program = crate::command::program();
    let line = format!("modalign() {{ {:?} \"$@\"; }}; {line}", program);
    let mut command = Command::new("bash");
    command.current_dir(folder).args(["-c", &line]);
    command.stdin(Stdio::null()).output().unwrap()
}

/// Asserts the exit code of a line of bash; its standard error.
fn ends(folder: &Path, line: &str, code: i32) -> String {
    let output = bash(folder, line);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{line}: {error}");
    error
}

/// The modes of a model in a new folder, with limits that they miss.
fn with_modes() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("limits.toml", LIMITS)]);
    ends(
        folder.path(),
        "modalign theory cycloid-ball -o modes.json",
        0,
    );
    folder
}

/// The contents of a folder and of those in it, hidden files included.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(content(&path));
        } else {
            // A link may lead nowhere.
            all.insert(path.clone(), fs::read(&path).unwrap_or_default());
        }
    }
    all
}

fn hidden(folder: &Path) -> Vec<PathBuf> {
    let is_hidden = |path: &PathBuf| path.file_name().unwrap().as_bytes().starts_with(b".");
    content(folder).into_keys().filter(is_hidden).collect()
}

/// Scenes `a` and `b` of a model without a test, which `run` needs little time for.
fn scenes() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let model = root().join("measurements/free-free-beam/model.toml");
    let model = fs::read_to_string(model).unwrap();
    for name in ["a", "b"] {
        let scene = format!(
            "schema = \"modalign-scene/1\"\ntitle = \"{name}\"\n[model]\nfile = \"model.toml\"\n"
        );
        fs::create_dir(folder.path().join(name)).unwrap();
        write(
            &folder.path().join(name),
            &[("scene.toml", &scene), ("model.toml", &model)],
        );
    }
    folder
}

#[test]
fn a_device_and_a_pipe_are_written_into_and_stay() {
    let folder = with_modes();
    let at = |name: &str| folder.path().join(name);
    let check = "modalign check modes.json --against limits.toml -q --junit";
    ends(folder.path(), &format!("{check} /dev/null"), 1);
    assert!(
        fs::metadata("/dev/null")
            .unwrap()
            .file_type()
            .is_char_device()
    );
    symlink("/dev/null", at("null.h5")).unwrap();
    ends(folder.path(), "modalign convert modes.json -o null.h5", 0);
    assert!(fs::symlink_metadata(at("null.h5")).unwrap().is_symlink());

    let piped = |name: &str| format!("mkfifo {name}; cat {name} > read-{name} & modalign");
    let line = format!("{} convert modes.json -o p.npz; wait", piped("p.npz"));
    ends(folder.path(), &line, 0);
    assert!(fs::metadata(at("p.npz")).unwrap().file_type().is_fifo());
    ends(folder.path(), "modalign inspect read-p.npz", 0);

    let full = ends(folder.path(), &format!("{check} /dev/full"), 2);
    assert!(full.contains("/dev/full: cannot write"), "{full}");
    for line in ["--help", "--version", "run --help", ""] {
        ends(folder.path(), &format!("modalign {line} > /dev/full"), 2);
    }
}

#[test]
fn standard_output_is_written_into_wherever_it_leads() {
    let folder = with_modes();
    let line = "modalign check modes.json --against limits.toml -q --junit /dev/stdout";
    let printed = bash(folder.path(), line).stdout;
    ends(folder.path(), &format!("{line} > file.xml"), 1);
    let written = fs::read(folder.path().join("file.xml")).unwrap();
    for text in [&printed, &written] {
        let text = String::from_utf8_lossy(text);
        assert!(
            text.starts_with("<?xml") && text.contains("MISSED"),
            "{text}"
        );
    }
    ends(
        folder.path(),
        &format!("{line} | true; exit ${{PIPESTATUS[0]}}"),
        1,
    );
    for line in [
        "modalign theory cycloid-ball -o -",
        "modalign run . -o -",
        "modalign check modes.json --against limits.toml --junit -",
    ] {
        let error = ends(folder.path(), line, 2);
        assert!(
            error.contains("got -, expected the name of a file"),
            "{error}"
        );
    }
    assert!(!folder.path().join("-").exists());
}

#[test]
fn pipes_are_read_whole_and_devices_are_refused() {
    let folder = with_modes();
    let limits = "--against limits.toml -q";
    ends(
        folder.path(),
        &format!("cat modes.json | modalign check /dev/stdin {limits}"),
        1,
    );
    ends(
        folder.path(),
        &format!("modalign check <(cat modes.json) {limits}"),
        1,
    );
    ends(
        folder.path(),
        "modalign convert <(cat modes.json) -o copy.csv",
        0,
    );
    assert!(folder.path().join("copy.csv").exists());
    for (line, word) in [
        ("modalign inspect /dev/zero", "it is a device"),
        (
            "modalign check /dev/zero --against limits.toml",
            "it is a device",
        ),
        (
            "modalign inspect - < modes.json",
            "standard input is /dev/stdin",
        ),
    ] {
        let error = ends(folder.path(), line, 2);
        assert!(error.contains(word), "{line}: {error}");
    }
}

#[test]
fn links_are_followed_and_permissions_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("inner")).unwrap();
    for (to, link) in [
        ("inner/second.json", "first.json"),
        ("../target.json", "inner/second.json"),
        ("new.json", "dangling.json"),
        ("loop-1.json", "loop-2.json"),
        ("loop-2.json", "loop-1.json"),
    ] {
        symlink(to, at(link)).unwrap();
    }
    let make = |line: &str, code| {
        ends(
            folder.path(),
            &format!("modalign theory cycloid-ball {line}"),
            code,
        )
    };
    for mode in [0o600, 0o640, 0o444, 0o666] {
        fs::write(at("target.json"), "of an earlier day").unwrap();
        fs::set_permissions(at("target.json"), Permissions::from_mode(mode)).unwrap();
        let owner = fs::metadata(at("target.json")).unwrap().uid();
        make("-o first.json", 0);
        let data = fs::metadata(at("target.json")).unwrap();
        assert_eq!((data.mode() & 0o777, data.uid()), (mode, owner));
        assert!(fs::read(at("target.json")).unwrap().starts_with(b"{"));
        fs::remove_file(at("target.json")).unwrap();
    }
    make("-o dangling.json", 0);
    assert!(fs::read(at("new.json")).unwrap().starts_with(b"{"));
    for link in ["first.json", "inner/second.json", "dangling.json"] {
        assert!(
            fs::symlink_metadata(at(link)).unwrap().is_symlink(),
            "{link}"
        );
    }
    assert!(make("-o loop-1.json", 2).contains("links lead to no file"));
    ends(
        folder.path(),
        "umask 027; modalign theory cycloid-ball -o masked.json",
        0,
    );
    assert_eq!(
        fs::metadata(at("masked.json")).unwrap().mode() & 0o777,
        0o640
    );
    // Two names of one file.
    symlink("new.json", at("same.csv")).unwrap();
    let line = "modalign identify x.uff -o new.json --indicators same.csv";
    ends(folder.path(), line, 2);
    assert_eq!(hidden(folder.path()), [] as [PathBuf; 0]);
}

#[test]
fn a_file_that_becomes_too_long_is_an_error_and_leaves_nothing() {
    let folder = scenes();
    for line in [
        "modalign run a -o out",
        "modalign theory cycloid-ball -o new/modes.json",
        "modalign convert modes.json -o out/x.h5",
    ] {
        ends(
            folder.path(),
            "modalign theory cycloid-ball -o modes.json",
            0,
        );
        let error = ends(folder.path(), &format!("ulimit -f 1; {line}"), 2);
        assert!(error.contains("cannot write: File too large"), "{error}");
        assert!(!folder.path().join("out").exists(), "{line}");
        assert!(!folder.path().join("new").exists(), "{line}");
    }
}

#[test]
fn hundreds_of_files_need_few_handles() {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let spec = fs::read_to_string(beam.join("synth.toml")).unwrap();
    let begin = spec.find("dofs = [").unwrap();
    let end = begin + spec[begin..].find('\n').unwrap();
    let spec = spec.replace(&spec[begin..end], "dofs = [ \"1:+Z\" ]");
    let spec = spec
        .replace("samples = 32768", "samples = 1024")
        .replace("averages = 3", "averages = 1");
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"many\"\n[[test]]\nname = \"hammer\"\n\
                 files = [\"raw/*.uff\"]\nhits = \"files\"\n";
    let model = fs::read_to_string(beam.join("model.toml")).unwrap();
    write(
        folder.path(),
        &[
            ("synth.toml", &spec),
            ("model.toml", &model),
            ("scene.toml", scene),
        ],
    );
    ends(folder.path(), "modalign synth synth.toml -o hit.uff", 0);
    fs::create_dir(folder.path().join("raw")).unwrap();
    for number in 0..300 {
        let name = format!("raw/{number}.uff");
        fs::copy(folder.path().join("hit.uff"), folder.path().join(name)).unwrap();
    }
    for line in [
        "convert raw/*.uff -o all.h5",
        "frf raw/*.uff --hits files -o frfs.uff",
        "frf . -o frfs.h5",
    ] {
        ends(folder.path(), &format!("ulimit -n 64; modalign {line}"), 0);
    }
    // Files of a folder: more than there are handles.
    let scenes = scenes();
    ends(
        scenes.path(),
        "ulimit -n 14; modalign run a -o out --threads 1",
        0,
    );
    assert!(content(&scenes.path().join("out")).len() > 7);
}

#[test]
fn a_folder_that_a_kill_left_half_written_is_recognised() {
    let folder = scenes();
    let out = folder.path().join("out");
    let mut whole = Vec::new();
    for name in ["a", "b"] {
        let start = Instant::now();
        ends(folder.path(), &format!("modalign run {name} -o out"), 0);
        whole.push((name, content(&out), start.elapsed()));
    }
    let program = crate::command::program();
    let mut random = 1_u64;
    for kill in 0..20 {
        let (name, new, duration) = &whole[kill % 2];
        let mut child = Command::new(&program)
            .current_dir(folder.path())
            .args(["run", name, "-o", "out"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let share = (random >> 40) as f64 / f64::from(1 << 24);
        if kill < 5 {
            std::thread::sleep(duration.mul_f64(share));
        } else {
            // The files are replaced within milliseconds after the first hidden one is there.
            while child.try_wait().unwrap().is_none() && is_clean(&out) {}
            std::thread::sleep(Duration::from_secs_f64(0.0025 * share));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let mut found = content(&out);
        found.retain(|path, _| !path.file_name().unwrap().as_bytes().starts_with(b"."));
        if !whole.iter().any(|(_, whole, _)| *whole == found) {
            is_refused(folder.path());
        }
        ends(folder.path(), &format!("modalign run {name} -o out"), 0);
        assert!(content(&out) == *new, "{:?}", hidden(&out));
    }
    // A kill when the manifest is marked, while the program waits for a reader of a pipe.
    ends(folder.path(), "rm out/tables.txt; mkfifo out/tables.txt", 0);
    let before = fs::read(out.join("manifest.json")).unwrap();
    let mut child = Command::new(&program)
        .current_dir(folder.path())
        .args(["run", "a", "-o", "out"])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    while fs::read(out.join("manifest.json")).unwrap() == before {
        let ended = child.try_wait().unwrap();
        assert!(ended.is_none(), "{ended:?}");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    fs::remove_file(out.join("tables.txt")).unwrap();
    is_refused(folder.path());
    ends(folder.path(), "modalign run a -o out", 0);
    assert!(content(&out) == whole[0].1, "{:?}", hidden(&out));
}

/// Asserts that the folder `out` is refused as one that holds files of two runs.
fn is_refused(folder: &Path) {
    let error = ends(folder, "modalign report out", 2);
    let names = error.contains("out/report.json: got a file that was being replaced");
    assert!(
        names && error.contains("run `modalign run` again"),
        "{error}"
    );
}

/// Whether a folder holds no hidden file.
fn is_clean(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).unwrap().flatten();
    entries
        .into_iter()
        .all(|entry| !entry.file_name().as_bytes().starts_with(b"."))
}

#[test]
fn results_of_two_runs_are_refused_by_name() {
    let folder = scenes();
    let beam = root().join("measurements/free-free-beam");
    for name in ["scene.toml", "synth.toml", "expected.toml"] {
        let text = fs::read_to_string(beam.join(name)).unwrap();
        let text = text.replace("samples = 32768", "samples = 2048");
        write(&folder.path().join("a"), &[(name, &text)]);
    }
    ends(folder.path(), "modalign run a -q -o out", 0);
    ends(folder.path(), "modalign run a -q -o again", 0);
    assert_eq!(
        fs::read(folder.path().join("out/manifest.json")).unwrap(),
        fs::read(folder.path().join("again/manifest.json")).unwrap()
    );
    let check = "modalign check out/comparison.json --against a/scene.toml -q";
    let ended = bash(folder.path(), check).status.code();
    assert!(matches!(ended, Some(0 | 1)));
    ends(folder.path(), "modalign report out", 0);
    ends(folder.path(), "modalign report out", 0);

    // Edited by hand, alone and beside its manifest.
    let comparison = folder.path().join("out/comparison.json");
    let text = fs::read_to_string(&comparison).unwrap();
    fs::write(&comparison, format!("{text}\n")).unwrap();
    let error = ends(folder.path(), check, 2);
    assert!(
        error.contains("out/comparison.json: got content with SHA-256"),
        "{error}"
    );
    ends(
        folder.path(),
        &format!(
            "ln -s out/comparison.json link.json; {}",
            check.replace("out/comparison", "link")
        ),
        2,
    );
    assert!(ends(folder.path(), "modalign report out", 2).contains("out/comparison.json: got"));
    ends(folder.path(), "mv out/comparison.json aside.json", 0);
    let error = ends(folder.path(), "modalign report out", 2);
    assert!(error.contains("no file that can be read"), "{error}");
    ends(folder.path(), "mv aside.json out/comparison.json", 0);
    fs::copy(&comparison, folder.path().join("alone.json")).unwrap();
    let alone = check.replace("out/comparison.json", "alone.json");
    assert_eq!(bash(folder.path(), &alone).status.code(), ended);
    let report = folder.path().join("out/report.json");
    let text = fs::read_to_string(&report).unwrap();
    fs::write(&report, format!("{text}\n")).unwrap();
    assert!(ends(folder.path(), "modalign report out", 2).contains("out/report.json: got"));

    // The next run, of another scene, leaves no file of the earlier one.
    ends(folder.path(), "modalign run b -q -o out", 0);
    ends(folder.path(), "modalign run b -q -o new", 0);
    let names = |folder: PathBuf| -> Vec<PathBuf> {
        let files = content(&folder).into_keys();
        files
            .map(|path| path.strip_prefix(&folder).unwrap().to_owned())
            .collect()
    };
    let mut expected = names(folder.path().join("new"));
    expected.extend([
        PathBuf::from("comparison.json"),
        PathBuf::from("report.json"),
    ]);
    expected.sort();
    expected.dedup();
    assert_eq!(
        names(folder.path().join("out")),
        expected,
        "but those that were edited"
    );
}

#[test]
fn of_two_runs_into_one_folder_the_second_ends_and_a_dead_one_holds_nothing() {
    let folder = scenes();
    ends(folder.path(), "mkfifo a/pipe.csv", 0);
    let scene = fs::read_to_string(folder.path().join("a/scene.toml")).unwrap();
    let test = "[[test]]\nname = \"t\"\nfiles = [\"pipe.csv\"]\n";
    write(
        &folder.path().join("a"),
        &[("scene.toml", &format!("{scene}{test}"))],
    );
    let start = || {
        let program = crate::command::program();
        let child = Command::new(program)
            .current_dir(folder.path())
            .args(["run", "a", "-o", "out"])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Opening the pipe waits until the run reads it, after it has locked its folder.
        let pipe = fs::OpenOptions::new()
            .write(true)
            .open(folder.path().join("a/pipe.csv"));
        (child, pipe.unwrap())
    };
    let (mut first, pipe) = start();
    let error = ends(folder.path(), "modalign run b -o out", 2);
    assert!(
        error.contains("another modalign writes into this folder"),
        "{error}"
    );
    ends(
        folder.path(),
        "modalign theory cycloid-ball -o out/modes.json",
        0,
    );
    first.kill().unwrap();
    first.wait().unwrap();
    drop(pipe);
    // A file of an earlier version, and one of another program.
    write(
        &folder.path().join("out"),
        &[(".modalign-Ab12cD", "half"), (".modalign-notes.txt", "")],
    );
    ends(folder.path(), "modalign run b -o out", 0);
    assert_eq!(
        hidden(&folder.path().join("out")),
        [folder.path().join("out/.modalign-notes.txt")]
    );
}

#[test]
fn names_that_are_not_utf_8_are_read_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let name = std::ffi::OsStr::from_bytes(b"sc \xff");
    let scene = folder.path().join(name);
    fs::create_dir_all(scene.join("raw")).unwrap();
    let spec = fs::read_to_string(beam.join("synth.toml")).unwrap();
    let spec = spec.replace("samples = 32768", "samples = 2048");
    let text = fs::read_to_string(beam.join("scene.toml")).unwrap();
    let text = text.replace("synth = \"synth.toml\"", "files = [\"r*/*.uff\"]");
    let model = fs::read_to_string(beam.join("model.toml")).unwrap();
    write(
        &scene,
        &[
            ("scene.toml", &text),
            ("synth.toml", &spec),
            ("model.toml", &model),
        ],
    );
    let limits = "[limits]\nmax_missed = 100\n";
    write(&scene, &[("limits.toml", limits)]);
    for (line, written) in [
        (
            "modalign synth $N/synth.toml -o $N/raw/hits$'\\xfe'.uff",
            &b"raw/hits\xfe.uff"[..],
        ),
        (
            "modalign run $N -q -o $N/out$'\\xfe'",
            b"out\xfe/report.html",
        ),
        ("modalign report $N/out$'\\xfe'", b"out\xfe/report.html"),
        ("modalign frf $N -q -o $N/$'\\xfe'.h5", b"\xfe.h5"),
        (
            "modalign convert $N/$'\\xfe'.h5 -q -o $N/new$'\\xfe'/x.npz",
            b"new\xfe/x.npz",
        ),
    ] {
        let line = format!("N=$'sc \\xff'; {}", line.replace("$N", "\"$N\""));
        let output = bash(folder.path(), &line);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(
            matches!(output.status.code(), Some(0 | 1)),
            "{line}: {error}"
        );
        let written = scene.join(std::ffi::OsStr::from_bytes(written));
        assert!(written.exists(), "{line}: {error}");
    }
    let found = modalign_in(&scene, ["check", "modes.json", "--against", "limits.toml"]);
    assert_eq!(found.status.code(), Some(2), "there is no modes.json");
}
