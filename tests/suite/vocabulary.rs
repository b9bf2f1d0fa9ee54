//! The language of code and documents: phrases and names that the glossary in
//! `.github/CONTRIBUTING.md` replaces, and comments wider than 100 columns, counted by part of the
//! project against numbers that may only fall.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Words that say nothing of the field. Identifiers count as the words they are made of; a finding
/// code such as `odd-one-out` is one word.
const PHRASES: [&str; 24] = [
    "told",
    "untold",
    "telling",
    "foretell",
    "foretold",
    "leaves over",
    "left over",
    "hangs together",
    "hang together",
    "brought together",
    "speaks for",
    "speaks against",
    "nobody",
    "what is left",
    "what is known",
    "from which on",
    "held against",
    "stands out",
    "reckon",
    "counts for one",
    "of its own",
    "of their own",
    "by itself",
    "odd one out",
];
/// A direction without a quantity; `MIN_FREQUENCY_LINES` has both.
const DIRECTIONS: [&str; 6] = ["LEAST", "MOST", "OWN", "REACH", "FEWEST", "STILL"];
const MAX_COMMENT_COLUMNS: usize = 100;

/// Part of the project, with its number of phrases, of the word `own`, and of constants named by a
/// direction.
const COUNTS: [(&str, [usize; 3]); 4] = [
    ("src/identify", [0, 1, 0]),
    ("src/report", [2, 3, 0]),
    ("src/scene", [0, 2, 0]),
    ("tests/suite", [0, 11, 0]),
];

/// Files with words for people, each with the part it belongs to: a stage of `src`, a folder of
/// `tests`, or a document.
fn files() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![
        root.join("src"),
        root.join("tests"),
        root.join("measurements"),
    ];
    let mut paths = vec![root.join("README.md")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                paths.push(path);
            }
        }
    }
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        let below = path.strip_prefix(root).unwrap().to_path_buf();
        let kind = below.extension().unwrap_or_default().to_string_lossy();
        let read = ["rs", "js", "md", "toml", "py"].contains(&kind.as_ref());
        // This file lists the phrases.
        if !read || below.ends_with("vocabulary.rs") {
            continue;
        }
        let names: Vec<_> = below.iter().map(|name| name.to_string_lossy()).collect();
        let part = match names.len() {
            1 => names[0].to_string(),
            _ => format!("{}/{}", names[0], names[1].trim_end_matches(".rs")),
        };
        found.push((part, below, fs::read_to_string(&path).unwrap()));
    }
    assert!(found.len() > 400, "the source tree was found");
    found
}

/// Words in small letters with the number of their line. `held_by` and `HeldBy` are two words each.
fn words(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let mut word = String::new();
        let mut before = ' ';
        for letter in line.chars().chain([' ']) {
            let joined = letter.is_alphanumeric() || letter == '-';
            let second_word = letter.is_uppercase() && before.is_lowercase();
            if (!joined || second_word) && !word.is_empty() {
                found.push((number, std::mem::take(&mut word)));
            }
            if joined {
                word.extend(letter.to_lowercase());
            }
            before = letter;
        }
    }
    found.retain(|(_, word)| word.contains(char::is_alphanumeric));
    found
}

/// Lines with one of the phrases.
fn phrases(text: &str) -> Vec<(usize, &'static str)> {
    let words = words(text);
    let mut found = Vec::new();
    for phrase in PHRASES {
        let parts: Vec<&str> = phrase.split(' ').collect();
        let starts = words.windows(parts.len()).filter(|window| {
            let pairs = window.iter().zip(&parts);
            pairs.into_iter().all(|((_, word), part)| word == part)
        });
        found.extend(starts.map(|window| (window[0].0, phrase)));
    }
    found
}

fn direction_alone(line: &str) -> bool {
    let line = line.trim_start().trim_start_matches("pub ");
    let Some(("const" | "static", name)) = line.split_once(' ') else {
        return false;
    };
    let first = name.split(|letter: char| !letter.is_alphanumeric()).next();
    first.is_some_and(|first| DIRECTIONS.contains(&first))
}

/// A comment of more columns; a row of a table cannot be wrapped.
fn too_wide(line: &str) -> bool {
    let text = line.trim_start();
    let comment =
        text.starts_with("//") && !text.trim_start_matches(['/', '!', ' ']).starts_with("| ");
    comment && line.chars().count() > MAX_COMMENT_COLUMNS
}

#[test]
fn words_and_names_are_found_across_lines_and_in_identifiers() {
    let text = "//! What a fit leaves\n//! over is told_by LeftOver; by-itself is\n//! one word.";
    let found = phrases(text);
    assert_eq!(found, [(2, "told"), (1, "leaves over"), (2, "left over")]);
    assert!(direction_alone("    const LEAST_LINES: f64 = 3.0;"));
    assert!(direction_alone("pub const REACH: f64 = 3.0;"));
    assert!(!direction_alone("const MOSTLY: f64 = 3.0;"));
    assert!(!direction_alone("const MIN_LINES: f64 = 3.0;"));
    assert!(too_wide(&format!("    /// {}", "a".repeat(93))));
    assert!(!too_wide(&format!("    /// {}", "a".repeat(92))));
    assert!(!too_wide(&format!("    /// | {} |", "a".repeat(93))));
}

#[test]
fn comments_wrap_at_100_columns() {
    for (_, path, text) in files() {
        for (number, line) in (1..).zip(text.lines()) {
            assert!(!too_wide(line), "{}:{number}: {line}", path.display());
        }
    }
}

#[test]
fn phrases_outside_the_glossary_become_fewer() {
    let mut counts: BTreeMap<String, [usize; 3]> = BTreeMap::new();
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (part, path, text) in files() {
        let found = phrases(&text);
        let own = words(&text)
            .iter()
            .filter(|(_, word)| word == "own")
            .count();
        let constants = text.lines().filter(|line| direction_alone(line)).count();
        let sum = counts.entry(part.clone()).or_default();
        for (sum, own) in sum.iter_mut().zip([found.len(), own, constants]) {
            *sum += own;
        }
        let lines = found.iter();
        let lines = lines.map(|(line, phrase)| format!("{}:{line}: {phrase}", path.display()));
        places.entry(part).or_default().extend(lines);
    }
    counts.retain(|_, count| *count != [0; 3]);
    let stated: BTreeMap<String, [usize; 3]> = COUNTS
        .iter()
        .map(|(part, count)| ((*part).to_owned(), *count))
        .collect();
    if counts == stated {
        return;
    }
    let table: String = counts
        .iter()
        .map(|(part, count)| format!("    (\"{part}\", {count:?}),\n"))
        .collect();
    let mut more = String::new();
    for (part, count) in &counts {
        if count[0] > stated.get(part).map_or(0, |stated| stated[0]) {
            let lines = places[part].iter().take(20);
            more.extend(lines.map(|line| format!("{line}\n")));
        }
    }
    panic!(
        "state these counts where they fell; where they rose, use the term of the glossary:\n{table}{more}"
    );
}
