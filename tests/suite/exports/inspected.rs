//! The contents of one file as `inspect --json` lists them.

use serde_json::Value;

use super::universal_file::{OneFile, on_file};

/// Exit code and listing of a file.
#[derive(Debug)]
pub struct Inspected {
    pub code: Option<i32>,
    pub listing: Value,
}

impl Inspected {
    /// Items of a list of the file.
    pub fn items(&self, list: &str) -> &[Value] {
        self.listing[list].as_array().unwrap()
    }

    /// How many findings have this code.
    pub fn count_of(&self, code: &str) -> usize {
        let findings = self.items("findings").iter();
        findings.filter(|finding| finding["code"] == code).count()
    }
}

/// Inspects a file.
pub fn inspect(file: &OneFile) -> Inspected {
    let ran = on_file("inspect", &file.path(), &["--json"]);
    let listing = ran.json()["files"][0].take();
    Inspected {
        code: ran.code,
        listing,
    }
}
