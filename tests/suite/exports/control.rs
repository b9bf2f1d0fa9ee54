//! The files of these tests, unchanged, hold one mode.

use super::universal_file::{OneFile, accelerances, file_of, finds_the_mode};

#[test]
fn the_mode_of_the_unchanged_file_is_found() {
    let file = OneFile::new("control.uff", file_of(&accelerances()));
    let ran = finds_the_mode(&file.path(), &[]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
}
