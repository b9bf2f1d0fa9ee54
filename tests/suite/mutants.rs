//! A small sample of the damaged files on which every reader is tried: the first 2,000 of each.

use crate::mutation::{READERS, survives};
use modalign::io::FORMATS;

#[test]
fn readers_survive_damaged_files() {
    for reader in READERS {
        let outcome = survives(reader, 2_000);
        assert!(
            outcome.opened > outcome.files / 200,
            "{}: {outcome:?}",
            reader.name
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
