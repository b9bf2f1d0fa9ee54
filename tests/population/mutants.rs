//! Every reader on damaged files.

use crate::draws;
use crate::mutation::{READERS, survives};

/// Damaged files for each reader.
const FILES: u64 = 200_000;

#[test]
fn readers_survive_damaged_files() {
    for reader in READERS {
        let outcome = survives(reader, draws(FILES) as usize);
        println!("{}: {outcome:?}", reader.name);
        assert!(
            outcome.opened > outcome.files / 200,
            "{}: {outcome:?}",
            reader.name
        );
    }
}
