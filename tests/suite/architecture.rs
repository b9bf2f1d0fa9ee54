//! The stages follow the table in the head of `src/lib.rs`: each uses only those it may, files
//! stay short, and only some stages reach the outside world.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Every file, module named by its path below `src`.
fn sources() -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
        {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&entry).unwrap();
                found.push((entry, text));
            }
        }
    }
    found.sort();
    assert!(found.len() > 40, "the source tree was found");
    found
}

/// The stage a file belongs to: its first path part below `src`.
fn stage(path: &Path) -> String {
    let below = path
        .strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src"))
        .unwrap();
    let first = below
        .components()
        .next()
        .unwrap()
        .as_os_str()
        .to_string_lossy()
        .into_owned();
    first.trim_end_matches(".rs").to_owned()
}

/// The table in the head of `lib.rs`, lines `//! | stage | a b c |`.
fn allowed() -> BTreeMap<String, Vec<String>> {
    let head =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let rows = head
        .lines()
        .filter_map(|line| line.strip_prefix("//! | `"))
        .filter_map(|line| line.split_once("` | "));
    let table: BTreeMap<_, _> = rows
        .map(|(stage, rest)| {
            let uses = rest
                .trim_end_matches(" |")
                .split_whitespace()
                .map(|word| word.trim_matches('`').to_owned());
            (stage.to_owned(), uses.filter(|word| word != "—").collect())
        })
        .collect();
    assert!(table.len() >= 18, "the table of lib.rs was read: {table:?}");
    table
}

/// Names that follow `crate::` in code, one level deep, braces included.
fn uses(text: &str) -> Vec<String> {
    let code: String = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n");
    let mut names = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with('$') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            Some(group) => names.extend(group_heads(group)),
            None => names.push(identifier(rest)),
        }
    }
    names
}

fn identifier(text: &str) -> String {
    text.chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .collect()
}

/// The first names of `a::b, c::{d, e}}`, up to the closing brace of the group.
fn group_heads(group: &str) -> Vec<String> {
    let (mut depth, mut heads, mut at_start) = (0, Vec::new(), true);
    for (index, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => at_start = true,
            c if at_start && (c.is_alphanumeric() || c == '_') => {
                heads.push(identifier(&group[index..]));
                at_start = false;
            }
            _ => {}
        }
    }
    heads
}

/// Names that a chain of `super::` reaches at the crate's root from a file, which is a path in
/// disguise.
fn uses_by_super(path: &Path, text: &str) -> Vec<String> {
    let below = path
        .strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src"))
        .unwrap();
    let parts = below.components().count();
    let is_folder = below.file_name().is_some_and(|name| name == "mod.rs");
    let depth = if is_folder { parts - 1 } else { parts };
    let code = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n");
    let chain = "super::".repeat(depth);
    let at_root = code
        .match_indices(&chain)
        .filter(|(at, _)| !code[..*at].ends_with("super::"));
    at_root
        .map(|(at, _)| identifier(&code[at + chain.len()..]))
        .collect()
}

/// Files that hold no code of a stage: roots of the packages and of the program.
const ROOTS: &[&str] = &["lib", "main", "numerics"];

/// Offences against the table, as `file uses stage`.
fn offences(files: &[(PathBuf, String)], table: &BTreeMap<String, Vec<String>>) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in files {
        let own = stage(path);
        if ROOTS.contains(&own.as_str()) {
            continue;
        }
        let Some(may_use) = table.get(&own) else {
            found.push(format!(
                "{} belongs to no stage of the table",
                path.display()
            ));
            continue;
        };
        for used in uses(text).into_iter().chain(uses_by_super(path, text)) {
            if table.contains_key(&used) && used != own && !may_use.contains(&used) {
                found.push(format!(
                    "{} uses {used}, which {own} may not",
                    path.display()
                ));
            }
        }
    }
    found
}

#[test]
fn stages_use_only_what_the_table_allows() {
    let found = offences(&sources(), &allowed());
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_forbidden_use_is_found() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let table = allowed();
    for text in [
        "use super::super::identify::Candidate;",
        "use crate::identify::Candidate;",
        "use crate::{axis::Band, identify::{Candidate}};",
        "fn f() { crate::identify::g() }",
    ] {
        let files = [(src.join("theory/beam.rs"), text.to_owned())];
        assert_eq!(offences(&files, &table).len(), 1, "{text}");
    }
}

#[test]
fn every_stage_is_in_the_table_and_the_table_has_no_cycle() {
    let table = allowed();
    for (path, _) in sources() {
        let own = stage(&path);
        assert!(
            ROOTS.contains(&own.as_str()) || table.contains_key(&own),
            "{}",
            path.display()
        );
    }
    let mut done: Vec<&String> = Vec::new();
    while done.len() < table.len() {
        let next = table
            .iter()
            .find(|(name, uses)| !done.contains(name) && uses.iter().all(|u| done.contains(&u)));
        done.push(next.expect("a stage whose needs are all placed").0);
    }
}

#[test]
fn files_stay_under_800_lines() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = |folder: &str| fs::read_dir(root.join(folder)).unwrap();
    // The script and the style of the HTML report are written by hand, too.
    let suite = [
        "tests/suite",
        "tests/suite/torture",
        "tests/bench",
        "src/report/html",
    ]
    .into_iter()
    .flat_map(files)
    .map(|entry| entry.unwrap().path())
    .filter(|path| path.is_file());
    let tests = suite.map(|path| (path.clone(), fs::read_to_string(path).unwrap()));
    for (path, text) in sources().into_iter().chain(tests) {
        let lines = text.lines().count();
        assert!(lines <= 800, "{} has {lines} lines", path.display());
    }
}

/// Texts that only some stages may hold in code: crate names behind their one door, and the outside
/// world.
const DOORS: &[(&str, &[&str])] = &[
    ("faer::", &["linalg"]),
    ("nalgebra::", &["linalg"]),
    ("realfft::", &["fourier"]),
    ("rustfft::", &["fourier"]),
    ("resvg::", &["report"]),
    ("png::", &["report"]),
    ("clap::", &["cli", "main"]),
    ("std::fs", &["io", "scene", "cli"]),
    ("{env", &["cli", "main"]),
    ("{fs", &["io", "scene", "cli"]),
    ("print!", &["cli"]),
    ("dbg!", &[]),
    // No build has debug assertions.
    ("debug_assert", &[]),
    ("stdout()", &["cli"]),
    ("stderr()", &["cli"]),
    ("fs::File", &["io", "scene", "cli"]),
    ("std::env", &["cli", "main"]),
    ("std::process", &["cli", "main"]),
    ("println!", &["cli"]),
    ("SystemTime", &["cli"]),
    ("Instant::now", &["cli"]),
    ("thread_rng", &[]),
    ("rand::rng(", &[]),
    ("from_os_rng", &[]),
];

#[test]
fn each_door_to_the_outside_is_in_its_place() {
    for (path, text) in sources() {
        let own = stage(&path);
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let in_tests = |name: &std::ffi::OsStr| name.to_string_lossy().ends_with("tests");
        let below = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
        if below.unwrap().with_extension("").iter().any(in_tests) {
            continue;
        }
        for (needle, stages) in DOORS {
            let used = code
                .lines()
                .any(|line| !line.trim_start().starts_with("//") && line.contains(needle));
            assert!(
                !used || stages.contains(&own.as_str()),
                "{} holds {needle}",
                path.display()
            );
        }
    }
}
