//! Options that messages name exist, and a message with a key of a scene names the option beside
//! it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use clap::{Command, CommandFactory};

use super::args::Cli;
use crate::correlate::CorrelateError;
use crate::finding::Code;

/// Options of cargo, which messages on features of the build name.
const OF_CARGO: [&str; 3] = ["--features", "--path", "--release"];
/// Files whose messages name the options of another verb: `inspect` ends with the command that
/// drafts a scene.
const OF_OTHER_VERB: [(&str, &str); 1] = [("inspect", "new")];
/// Options that the parser adds.
const OF_PARSER: [&str; 2] = ["--help", "--version"];

/// Options of every verb, `study` with those of its kinds.
fn options() -> BTreeMap<String, BTreeSet<String>> {
    fn collect(command: &Command, names: &mut BTreeSet<String>) {
        let longs = command
            .get_arguments()
            .filter_map(|option| option.get_long());
        names.extend(longs.map(|long| format!("--{long}")));
        for part in command.get_subcommands() {
            collect(part, names);
        }
    }
    let program = Cli::command();
    let global = program
        .get_arguments()
        .filter_map(|option| option.get_long());
    let global: BTreeSet<String> = global
        .map(|long| format!("--{long}"))
        .chain(OF_PARSER.map(str::to_owned))
        .collect();
    let verb = |command: &Command| {
        let mut names = global.clone();
        collect(command, &mut names);
        (command.get_name().to_owned(), names)
    };
    program.get_subcommands().map(verb).collect()
}

/// Rust files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            found.push(path);
        }
    }
    found
}

/// The words `--name` of a line.
fn named(line: &str) -> Vec<String> {
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let starts = line.match_indices("--").map(|(at, _)| at);
    let names = starts.filter_map(|at| {
        let is_start = !line[..at].ends_with(|c: char| c == '-' || c.is_alphanumeric());
        let rest = &line[at + 2..];
        let end = rest.find(|c: char| !is_name(c)).unwrap_or(rest.len());
        let name = rest[..end].trim_end_matches('-');
        let is_name = name.starts_with(|c: char| c.is_ascii_lowercase()) && name.len() > 1;
        (is_start && is_name).then(|| format!("--{name}"))
    });
    names.collect()
}

#[test]
fn every_option_that_a_message_names_exists_on_its_verb() {
    let options = options();
    let all: BTreeSet<&String> = options.values().flatten().collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut count = 0;
    for path in files(&root) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let is_of_cli = path.starts_with(root.join("cli"));
        if name.ends_with("tests") || (is_of_cli && ["args", "study_args"].contains(&&*name)) {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let (text, _) = text
            .split_once("\n#[cfg(test)]\nmod tests")
            .unwrap_or((&text, ""));
        let verb = name.split('_').next().unwrap_or_default();
        let named_verb = OF_OTHER_VERB.iter().find(|(file, _)| *file == verb);
        let verb = named_verb.map_or(verb, |(_, other)| *other);
        let of_verb = options.get(verb).filter(|_| is_of_cli);
        for line in text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
        {
            for option in named(line) {
                // A command that is written out names another verb than that of the file.
                let other = options
                    .keys()
                    .find(|verb| line.contains(&format!("modalign {verb}")));
                let of_verb = other.map_or(of_verb, |verb| options.get(verb));
                let exists = match of_verb {
                    Some(names) => names.contains(&option),
                    None => all.contains(&option),
                };
                let of_cargo = OF_CARGO.contains(&&*option);
                assert!(exists || of_cargo, "{}: {option}: {line}", path.display());
                count += 1;
            }
        }
    }
    assert!(count > 100, "{count} options were found");
}

#[test]
fn a_message_with_a_key_of_a_scene_names_the_option_beside_it() {
    let keys = [
        ("rotation_length_m", "--rotation-length"),
        ("max_frequency_error", "--max-frequency-error"),
        ("level_n", "--trigger-level"),
        ("length_s", "--hit-length"),
        ("pretrigger_s", "--pretrigger"),
        ("`averages`", "--averages"),
        ("`window`", "--window"),
    ];
    let mixed = CorrelateError::MixedUnits {
        translations: 1,
        rotations: 1,
    };
    let explanations = Code::ALL.iter().map(|code| code.explanation().to_owned());
    for message in explanations.chain([mixed.to_string()]) {
        for (key, option) in keys {
            // `block_length_s` is another key than `length_s`.
            let mut places = message.match_indices(key);
            let is_whole = |(place, _): (usize, &str)| !message[..place].ends_with('_');
            let is_alone = places.any(is_whole) && !message.contains(option);
            assert!(!is_alone, "{key} without {option}: {message}");
        }
    }
}
