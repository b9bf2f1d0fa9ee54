//! Every reader on damaged files.

use crate::draws;
use crate::mutation::{stated, survives};
use crate::readers::READERS;

/// Damaged files for each reader, unless `MUTATED_FILES` states another number.
const FILES: u64 = 200_000;

#[test]
fn readers_survive_damaged_files() {
    let first = stated("MUTATED_FIRST", 0);
    let files = stated("MUTATED_FILES", draws(FILES) as usize);
    for reader in READERS {
        let outcome = survives(reader, first, files);
        assert!(
            outcome.opened > outcome.files / 200,
            "{}: {outcome:?}",
            reader.name
        );
    }
}
