//! Where results go: several files of one command all come or none does, and nothing that is read
//! is written over.

use std::process::{Command, Output};

use tempfile::TempDir;

use crate::command::{succeed, write};
use crate::faults::{content, prepared};

/// The program in the prepared folder.
fn run(folder: &TempDir, line: &str) -> Output {
    let mut command = Command::new(crate::command::program());
    let arguments = line.split(' ');
    command
        .current_dir(folder.path())
        .args(arguments)
        .output()
        .unwrap()
}

/// Verbs that write more than one file, the last of which cannot be written, and a file that they
/// would have written before it.
const PARTLY: &[(&str, &str)] = &[
    (
        "identify frfs.h5 --method circle --band 60:3200 -o out/new.json --indicators out/file/new.csv",
        "new.json",
    ),
    (
        "correlate --test frfs.h5 --theory frfs.h5 --lines out/new.csv -o out/file/new.md",
        "new.csv",
    ),
    ("report out", "report.html"),
    ("update . -o out", "update.json"),
];

#[test]
fn of_several_files_all_come_or_none() {
    let folder = prepared();
    let out = folder.path().join("out");
    succeed([
        "run",
        folder.path().to_str().unwrap(),
        "-q",
        "-o",
        out.to_str().unwrap(),
    ]);
    std::fs::remove_dir_all(out.join("figures")).unwrap();
    write(
        &out,
        &[
            ("file", "no folder"),
            ("figures", "no folder"),
            ("new.json", ""),
            ("update.json", "{}"),
            ("new.csv", ""),
        ],
    );
    std::fs::write(out.join("report.html"), "of an earlier day").unwrap();
    let before = content(&out);
    for (line, name) in PARTLY {
        let ended = run(&folder, line);
        let error = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{line}: {error}");
        assert!(before.contains_key(&out.join(name)), "{line}");
        assert!(
            content(&out) == before && ended.stdout.is_empty(),
            "{line}: {error}"
        );
    }
}

/// Commands that would overwrite one of their input files, and their error messages.
const OVER: &[(&str, &str)] = &[
    ("convert hits.uff -o ./hits.uff", "is read"),
    ("frf hits.uff -o out/../hits.uff", "is read"),
    ("identify frfs.h5 -o frfs.h5", "is read"),
    (
        "identify frfs.h5 -o new.csv --indicators new.csv",
        "gets another result",
    ),
    ("theory modes.json -o modes.json", "is read"),
    (
        "correlate --test modes.json --theory . -o modes.json",
        "is read",
    ),
    ("correlate --test modes.json -o modes.json", "is read"),
    (
        "correlate --test modes.json --theory . --expand modes.json",
        "is read",
    ),
    (
        "correlate --test modes.json --theory . --expand a.json -o a.json",
        "gets another result",
    ),
    (
        "correlate --test modes.json --theory . --dof-map map.csv -o map.csv",
        "is read",
    ),
    (
        "check modes.json --against modes.json --junit modes.json",
        "is read",
    ),
    ("update . -o .", "model.toml, which is read"),
    (
        "run named -o named",
        "roving-hammer.modes.json, which is read",
    ),
];

#[test]
fn no_verb_writes_over_what_it_reads() {
    let folder = prepared();
    let named = folder.path().join("named");
    std::fs::create_dir(&named).unwrap();
    write(folder.path(), &[("map.csv", "1:+Z,1:+Z\n")]);
    for name in ["model.toml", "modes.json"] {
        let new = name.replace("modes", "roving-hammer.modes");
        std::fs::copy(folder.path().join(name), named.join(new)).unwrap();
    }
    let scene = std::fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    let modes = "modes = \"roving-hammer.modes.json\"";
    write(
        &named,
        &[(
            "scene.toml",
            &scene.replace("synth = \"synth.toml\"", modes),
        )],
    );
    let before = (content(folder.path()), content(&named));
    for (line, word) in OVER {
        let ended = run(&folder, line);
        let error = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{line}: {error}");
        assert!(error.contains(word), "{line}: {error}");
        assert!(
            (content(folder.path()), content(&named)) == before,
            "{line}"
        );
    }
}
