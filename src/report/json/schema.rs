//! A result becomes the text of a file, and a file is read with the path, line and column of an
//! error.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::io::IoError;
use crate::printable::printable_json;

/// A result as text, ending in a newline.
pub(super) fn json_text<T: Serialize>(file: &T) -> String {
    let text = serde_json::to_string_pretty(file);
    printable_json(text.expect("plain data has no key that is not text")) + "\n"
}

/// A file; `expected` names its schema as errors state it.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column.
pub(super) fn parsed<T: DeserializeOwned>(
    text: &str,
    path: &str,
    expected: &'static str,
) -> Result<T, IoError> {
    serde_json::from_str(text).map_err(|error| IoError::Json {
        path: path.to_owned(),
        line: error.line(),
        column: error.column(),
        got: error.to_string(),
        expected,
    })
}

/// Checks the schema of a file; `expected` is `schema NAME`.
///
/// # Errors
/// [`IoError::Json`] for another schema.
pub(super) fn check_schema(
    schema: &str,
    path: &str,
    expected: &'static str,
) -> Result<(), IoError> {
    match format!("schema {schema}") == expected {
        true => Ok(()),
        false => Err(IoError::Json {
            path: path.to_owned(),
            line: 1,
            column: 1,
            got: format!("schema {schema:?}"),
            expected,
        }),
    }
}
