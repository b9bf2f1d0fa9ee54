//! Seeded changes of TOML and JSON inputs: each ends with a result or an error, never with a panic.
//!
//! Numbers get hostile values, lines are removed, repeated and exchanged, texts are replaced. The
//! number of a file is the seed of its changes; `MUTATED_FILES` states how many are tried of each
//! kind, `MUTATED_FIRST` the number of the first.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::command::root;
use crate::mutation::stated;
use crate::text_inputs::{TEXT_INPUTS, write_inputs};

/// Mutations of each kind of input, unless `MUTATED_FILES` states another number.
const FILES: usize = 60;

/// Longer files of results take time and nothing else.
const MAX_SEED_BYTES: u64 = 1 << 18;

/// An input that takes longer is a failure: some ten thousand times the time of one.
const MAX_TIME: Duration = Duration::from_secs(60);

/// Values that counts, sizes, masses, frequencies and names cannot have, or hardly.
const HOSTILE: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "-0.0",
    "1e308",
    "-1e308",
    "5e-324",
    "1e-308",
    "1e16",
    "1e-16",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "4294967296",
    "1000000000",
    "100000",
    "inf",
    "nan",
    "-inf",
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"x\"",
    "0.5",
    "1e300",
];

/// An input with its changes.
fn mutated(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut text = text.to_owned();
    for _ in 0..random.random_range(1..=3) {
        text = match random.random_range(0..10) {
            0..=5 => with_hostile_number(&text, random),
            6 => with_changed_lines(&text, random),
            7 => with_hostile_text(&text, random),
            8 => {
                let cut = random.random_range(0..=text.len());
                let cut = (cut..=text.len()).find(|at| text.is_char_boundary(*at));
                text[..cut.unwrap_or(0)].to_owned()
            }
            _ => {
                let mut characters: Vec<char> = text.chars().collect();
                if let Some(at) = (0..characters.len()).collect::<Vec<_>>().choose(random) {
                    characters[*at] = char::from(random.random_range(32..127_u8));
                }
                characters.into_iter().collect()
            }
        };
    }
    text
}

fn with_hostile_number(text: &str, random: &mut ChaCha8Rng) -> String {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | 'e' | '+');
    let mut tokens = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (start, is_number(c)) {
            (None, true) if c.is_ascii_digit() || c == '-' => start = Some(at),
            (Some(first), false) => {
                tokens.push(first..at);
                start = None;
            }
            _ => {}
        }
    }
    let Some(token) = tokens.choose(random) else {
        return text.to_owned();
    };
    let value = HOSTILE.choose(random).expect("there are some");
    [&text[..token.start], value, &text[token.end..]].concat()
}

fn with_changed_lines(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() {
        return String::new();
    }
    let (one, other) = (
        random.random_range(0..lines.len()),
        random.random_range(0..lines.len()),
    );
    match random.random_range(0..3) {
        0 => drop(lines.remove(one)),
        1 => lines.insert(other, lines[one]),
        _ => lines.swap(one, other),
    }
    lines.join("\n")
}

fn with_hostile_text(text: &str, random: &mut ChaCha8Rng) -> String {
    let quotes: Vec<usize> = text.match_indices('"').map(|(at, _)| at).collect();
    let Some(pair) = quotes
        .chunks_exact(2)
        .collect::<Vec<_>>()
        .choose(random)
        .copied()
    else {
        return text.to_owned();
    };
    let long = "x".repeat(5000);
    let texts = [
        "",
        "\\u0000",
        "1:+Z",
        "../..",
        "ground",
        "-",
        "🦀",
        "kg",
        long.as_str(),
    ];
    let value = texts.choose(random).expect("there are some");
    [&text[..=pair[0]], value, &text[pair[1]..]].concat()
}

#[test]
fn mutated_inputs_end_with_a_result_or_an_error() {
    let (first, files) = (stated("MUTATED_FIRST", 0), stated("MUTATED_FILES", FILES));
    let inputs = tempfile::tempdir().unwrap();
    write_inputs(
        root(),
        Path::new(env!("CARGO_BIN_EXE_modalign")),
        inputs.path(),
    );
    let failures: Vec<String> = TEXT_INPUTS
        .iter()
        .flat_map(|kind| {
            let seeds = kind.seeds(inputs.path(), MAX_SEED_BYTES);
            assert!(!seeds.is_empty(), "no input {}", kind.file);
            let one = |number: usize| {
                let mut random = ChaCha8Rng::seed_from_u64(number as u64);
                let text = mutated(&seeds[number % seeds.len()], &mut random);
                let folder = tempfile::tempdir().unwrap();
                let begin = Instant::now();
                let used = catch_unwind(AssertUnwindSafe(|| (kind.used)(&text, folder.path())));
                let is_slow = begin.elapsed() > MAX_TIME;
                (used.is_err() || is_slow).then(|| {
                    let how = if is_slow { "slow" } else { "panic" };
                    format!("{} {number}: {how}", kind.name)
                })
            };
            let numbers = (first..first + files).into_par_iter();
            numbers.filter_map(one).collect::<Vec<_>>()
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
