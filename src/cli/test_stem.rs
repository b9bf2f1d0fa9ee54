//! The name of a test gives the stem of its file names.

use crate::printable::file_name_part;
use crate::scene::SceneResult;

/// A file name made of a test's name.
pub(super) fn file_stem(name: &str) -> String {
    let legal = |c: char| {
        if c.is_alphanumeric() {
            c.to_lowercase().collect()
        } else {
            " ".to_owned()
        }
    };
    let legal: String = name.chars().map(legal).collect();
    let stem = legal.split_whitespace().collect::<Vec<_>>().join("-");
    file_name_part(&stem).to_owned()
}

/// The stem of the files of one test, another for each.
pub(super) fn test_stem(result: &SceneResult, index: usize) -> String {
    let stem = file_stem(&result.tests[index].name);
    let mut before = result.tests[..index].iter();
    match before.any(|other| file_stem(&other.name) == stem) {
        true => format!("{stem}-{}", index + 1),
        false => stem,
    }
}
