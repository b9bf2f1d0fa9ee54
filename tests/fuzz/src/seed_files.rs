//! Whole inputs of every target as files, with dictionaries of the words of those that are text.

use std::collections::BTreeSet;
use std::path::Path;

use crate::text_inputs::{TEXT_INPUTS, write_inputs};
use crate::{names, readers_of, root};

/// Longer files of results take time and nothing else.
const MAX_SEED_BYTES: u64 = 160_000;

/// Longer words are texts of the user.
const MAX_WORD_BYTES: usize = 32;

/// Numbers that counts, sizes and frequencies cannot have, or hardly.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "-0.0",
    "1e308",
    "5e-324",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "4294967296",
    "1000000000",
    "inf",
    "nan",
    "null",
    "[]",
    "{}",
];

/// Writes `FOLDER/TARGET/N` and `FOLDER/TARGET.dict`, with results of the program.
pub fn write_seeds(folder: &Path, program: &Path) {
    let inputs = tempfile::tempdir().unwrap();
    write_inputs(root(), program, inputs.path());
    for name in names() {
        let text = TEXT_INPUTS.iter().find(|input| input.name == name);
        let seeds: Vec<Vec<u8>> = match text {
            Some(input) => {
                let texts = input.seeds(inputs.path(), MAX_SEED_BYTES).into_iter();
                texts.map(String::into_bytes).collect()
            }
            None => {
                let readers = readers_of(name).into_iter().enumerate();
                let of_reader = readers.map(|(number, reader)| {
                    let seeds = (reader.seeds)().into_iter();
                    seeds.map(move |seed| [&[number as u8], &seed[..]].concat())
                });
                of_reader.flatten().collect()
            }
        };
        assert!(!seeds.is_empty(), "no input of {name}");
        let target = folder.join(name);
        std::fs::create_dir_all(&target).unwrap();
        for (number, seed) in seeds.iter().enumerate() {
            std::fs::write(target.join(number.to_string()), seed).unwrap();
        }
        std::fs::write(folder.join(format!("{name}.dict")), dictionary(&seeds)).unwrap();
    }
}

/// The words of the inputs that are text, and numbers that fit nowhere.
fn dictionary(seeds: &[Vec<u8>]) -> String {
    let texts = seeds
        .iter()
        .filter_map(|seed| std::str::from_utf8(seed).ok());
    let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '/' | ':' | ' ');
    let words = texts
        .flat_map(|text| text.split(|c| !is_part(c)))
        .map(str::trim);
    let words = words.filter(|word| {
        let is_number = word.parse::<f64>().is_ok();
        word.starts_with(|c: char| c.is_ascii_alphabetic())
            && !is_number
            && word.len() <= MAX_WORD_BYTES
    });
    let words: BTreeSet<&str> = words.chain(NUMBERS.iter().copied()).collect();
    words.iter().map(|word| format!("\"{word}\"\n")).collect()
}
