//! A small sample of the damaged files on which every reader is tried: the first of each.

use crate::mutation::{stated, survives};
use crate::readers::READERS;
use modalign::io::FORMATS;

/// Damaged files for each reader, unless `MUTATED_FILES` states another number.
const FILES: usize = 400;

#[test]
fn readers_survive_damaged_files() {
    let (first, files) = (stated("MUTATED_FIRST", 0), stated("MUTATED_FILES", FILES));
    for reader in READERS {
        let outcome = survives(reader, first, files);
        assert!(
            outcome.opened > outcome.files / 200,
            "{} {:?}: {outcome:?}",
            reader.name,
            reader.packing
        );
    }
}

#[test]
fn every_format_is_tried() {
    for format in FORMATS {
        let tried = READERS.iter().any(|reader| reader.name == format.name());
        assert!(tried, "{} has no line in READERS", format.name());
    }
}
