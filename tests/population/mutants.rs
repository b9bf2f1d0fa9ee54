//! Every reader on 200,000 damaged files.

use crate::mutation::{READERS, survives};

/// Damaged files for each reader.
const FILES: usize = 200_000;

#[test]
fn readers_survive_damaged_files() {
    for reader in READERS {
        let outcome = survives(reader, FILES);
        println!("{}: {outcome:?}", reader.name);
        assert!(
            outcome.opened > outcome.files / 200,
            "{}: {outcome:?}",
            reader.name
        );
    }
}
