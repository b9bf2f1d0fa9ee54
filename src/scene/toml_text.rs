//! Reads TOML into a typed value; errors carry file, line and column, and an unknown key names the
//! nearest known one.

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::de::DeTable;

use crate::io::{IoError, read_input_part};

use super::error::{Place, SceneError, TomlFault, value_error};
use super::places::place_at;
use super::toml_faults::from_text;
use super::toml_value::TomlError;

/// Maximum length of a file of TOML or JSON, whose values take some ten times as much memory.
/// Longer: a pipe without an end fills the memory. Shorter: reports of many tests are refused.
const MAX_TEXT_BYTES: u64 = 256 << 20;

/// Reads a file as UTF-8 text.
///
/// # Errors
/// [`IoError::System`] when it cannot be read; [`IoError::Binary`] with the byte where it is not
/// UTF-8 or longer than 256 MiB.
pub fn read_text(path: &Path) -> Result<String, IoError> {
    let name = path.display().to_string();
    let system = |source| IoError::System {
        path: name.clone(),
        action: "read",
        source,
    };
    let bytes = read_input_part(path, MAX_TEXT_BYTES + 1).map_err(system)?;
    if bytes.len() as u64 > MAX_TEXT_BYTES {
        return Err(IoError::Binary {
            path: name,
            byte: MAX_TEXT_BYTES,
            what: "text",
            got: "a longer file".to_owned(),
            expected: format!("at most {} MiB", MAX_TEXT_BYTES >> 20),
        });
    }
    String::from_utf8(bytes).map_err(|error| IoError::Binary {
        path: name,
        byte: error.utf8_error().valid_up_to() as u64,
        what: "text",
        got: "a byte that is not UTF-8".to_owned(),
        expected: "UTF-8 text".to_owned(),
    })
}

/// Checks the `schema` key of a file.
///
/// # Errors
/// [`SceneError::Value`] for another one.
pub(super) fn check_schema(got: &str, expected: &str, path: &str) -> Result<(), SceneError> {
    if got == expected {
        Ok(())
    } else {
        Err(value_error(
            path,
            "schema",
            &format!("{got:?}"),
            &format!("{expected:?}"),
        ))
    }
}

/// The `schema` key at the top of a document, which may have faults elsewhere.
pub(super) fn stated_schema(text: &str) -> Option<String> {
    let (table, _) = DeTable::parse_recoverable(text);
    let schema = table.get_ref().get("schema")?.get_ref().as_str();
    schema.map(str::to_owned)
}

/// A text as TOML writes it.
pub(super) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// Placeholder in a drafted file where the user has to state a value.
pub const FILL_IN: &str = "FILL IN";

/// A line of a drafted file that is still to be filled in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenLine {
    /// Number from 1.
    pub line: usize,
    /// Its key.
    pub key: String,
    /// Expected value, as its remark states.
    pub expected: String,
}

/// The lines that hold [`FILL_IN`] before their remark.
pub fn open_lines(text: &str) -> Vec<OpenLine> {
    let open = |(index, line): (usize, &str)| {
        let (key, rest) = line.split_once('=')?;
        let (value, remark) = rest.split_once('#').unwrap_or((rest, ""));
        let is_open = value.contains(FILL_IN) && !key.trim_start().starts_with('#');
        is_open.then(|| OpenLine {
            line: index + 1,
            key: key.trim().to_owned(),
            expected: match remark.trim() {
                "" => "a value".to_owned(),
                remark => remark.to_owned(),
            },
        })
    };
    text.lines().enumerate().filter_map(open).collect()
}

/// Parses TOML text.
///
/// # Errors
/// [`SceneError::Unfilled`] for a drafted file with a line that is still to be filled in;
/// [`SceneError::Toml`] with line, column, what was got and expected of every fault.
pub fn parse<T: DeserializeOwned>(text: &str, path: &str) -> Result<T, SceneError> {
    parse_repaired(text, path).map_err(|faulty| faulty.error)
}

/// A document with faults.
pub(super) struct Faulty<T> {
    pub error: SceneError,
    /// Its value with the faulty parts repaired, as far as that was possible.
    pub repaired: Option<T>,
    /// The lines of the faults that were repaired by a value of no meaning.
    pub substituted_lines: Vec<usize>,
    /// The line of each misspelt key, with the key that is probably meant.
    pub misspelt_keys: Vec<(usize, String)>,
}

/// Parses TOML text; of one with faults its repaired value is there for further checks.
///
/// # Errors
/// As [`parse`].
pub(super) fn parse_repaired<T: DeserializeOwned>(
    text: &str,
    path: &str,
) -> Result<T, Box<Faulty<T>>> {
    let open = open_lines(text);
    if let Some(first) = open.first() {
        return Err(Box::new(Faulty {
            error: SceneError::Unfilled {
                path: path.to_owned(),
                line: first.line,
                key: first.key.clone(),
                expected: first.expected.clone(),
                others: open[1..].iter().map(|header| header.line).collect(),
            },
            repaired: None,
            substituted_lines: Vec::new(),
            misspelt_keys: Vec::new(),
        }));
    }
    from_text(text).map_err(|found| {
        let line = |fault: &TomlError| toml_fault(text, fault).line;
        let is_substituted = |fault: &&TomlError| !fault.message.starts_with("unknown field");
        let substituted = found.faults.iter().filter(is_substituted);
        let substituted_lines = substituted.map(line).collect();
        let misspelt = found.faults.iter();
        let misspelt =
            misspelt.filter_map(|fault| Some((line(fault), nearest_key(&fault.message)?)));
        let misspelt_keys = misspelt.collect();
        // A scene may name any file: one of another kind is not quoted.
        let is_quoted = has_known_key(text, &found.faults);
        let faults = without_misspelt(text, found.faults).into_iter();
        let faults = faults.map(|fault| match is_quoted {
            true => toml_fault(text, &fault),
            false => toml_fault(text, &without_quotation(fault)),
        });
        Box::new(Faulty {
            error: SceneError::Toml {
                path: path.to_owned(),
                faults: faults.collect(),
                all_found: found.all_found,
            },
            repaired: found.repaired.filter(|_| is_quoted),
            substituted_lines,
            misspelt_keys,
        })
    })
}

/// Whether a document has a key that its schema has, at its top.
fn has_known_key(text: &str, faults: &[TomlError]) -> bool {
    let (table, _) = DeTable::parse_recoverable(text);
    let is_unknown = |key: &str| {
        let message = format!("unknown field `{key}`");
        faults
            .iter()
            .any(|fault| fault.message.starts_with(&message))
    };
    table.get_ref().keys().any(|key| !is_unknown(key.get_ref()))
}

/// The fault without the key or value that it quotes; its place shows it.
fn without_quotation(mut fault: TomlError) -> TomlError {
    let message = &fault.message;
    if let Some((_, expected)) = message.split_once(", expected ") {
        let got = match message.starts_with("unknown field ") {
            true => "an unknown key",
            false => "another value",
        };
        fault.message = format!("got {got}, expected {expected}");
    }
    fault
}

/// The faults without missing keys that are misspelt in their table: the unknown key says it.
fn without_misspelt(text: &str, mut faults: Vec<TomlError>) -> Vec<TomlError> {
    let start = |fault: &TomlError| fault.span.as_ref().map_or(0, |span| span.start);
    let misspelt = faults
        .iter()
        .filter_map(|fault| Some((start(fault), nearest_key(&fault.message)?)));
    for (place, key) in misspelt.collect::<Vec<_>>() {
        let missing = format!("missing field `{key}`");
        let is_missing = |fault: &TomlError| {
            fault.message == missing && is_same_table(text, start(fault), place)
        };
        if let Some(index) = faults.iter().rposition(is_missing) {
            faults.remove(index);
        }
    }
    faults
}

/// Whether a key at a place belongs to the table that begins at another: no line between them is
/// the head of a table.
fn is_same_table(text: &str, table: usize, key: usize) -> bool {
    let between = text.get(table..key);
    // The first line is the head of the table itself, which the document has none of.
    let skipped = usize::from(text[table.min(text.len())..].starts_with('['));
    between.is_some_and(|between| {
        let mut lines = between.lines().skip(skipped);
        !lines.any(|line| line.trim_start().starts_with('['))
    })
}

fn toml_fault(text: &str, error: &TomlError) -> TomlFault {
    let offset = error.span.as_ref().map_or(0, |span| span.start);
    let Place { line, column } = place_at(text, offset);
    let message = error.message.replace('\n', " ");
    let hint = nearest_key(&message)
        .map_or_else(String::new, |key| format!("\nhint: did you mean `{key}`?"));
    TomlFault {
        line,
        column,
        message: format!("{}{hint}", got_and_expected(&message)),
    }
}

/// Says what was got and expected, in the words of TOML for what the deserialiser says in those of
/// Rust.
fn got_and_expected(message: &str) -> String {
    if let Some(rest) = message.strip_prefix("unknown field ") {
        return format!("got unknown key {rest}");
    }
    if let Some(key) = message.strip_prefix("missing field ") {
        return format!("got no key {key}, expected it in this table");
    }
    if let Some(rest) = message.strip_prefix("unknown variant ") {
        return format!("got {rest}");
    }
    let kinds = ["invalid type: ", "invalid value: ", "invalid length "];
    let parts = kinds.iter().find_map(|kind| message.strip_prefix(kind));
    match parts.and_then(|parts| parts.rsplit_once(", expected ")) {
        Some((got, expected)) => {
            format!(
                "got {}, expected {}",
                value_found(got),
                value_expected(expected)
            )
        }
        None => message.to_owned(),
    }
}

/// A value, or the length of an array.
fn value_found(got: &str) -> String {
    let numbers = ["integer ", "floating point "];
    if let Some(number) = numbers.iter().find_map(|kind| got.strip_prefix(kind)) {
        return format!("the number {}", number.trim_matches('`'));
    }
    match (got.split_once(' '), got) {
        (Some(("string", text)), _) => format!("the text {text}"),
        (Some(("boolean", value)), _) => value.trim_matches('`').to_owned(),
        (_, "sequence") => "an array".to_owned(),
        (_, "map") => "a table".to_owned(),
        (None, length) if length.parse::<usize>().is_ok() => format!("{length} values"),
        (None, kind) => format!("a {kind}"),
        (Some(_), other) => other.to_owned(),
    }
}

fn value_expected(expected: &str) -> String {
    let lengths = ["an array of length ", "a tuple of size "];
    if let Some(length) = lengths.iter().find_map(|kind| expected.strip_prefix(kind)) {
        return format!("an array of {length} values");
    }
    let text = match expected {
        "f64" => "a number",
        "usize" | "u8" | "u32" | "u64" => "a whole number, 0 or more",
        "i32" | "i64" => "a whole number",
        "a string" => "a text in quotes",
        "a boolean" => "true or false",
        "a sequence" => "an array, [...]",
        "a map" => "a table",
        table if table.starts_with("struct ") => "a table",
        other => other,
    };
    text.to_owned()
}

/// The known key closest to the unknown one that the message is about.
fn nearest_key(message: &str) -> Option<String> {
    let quoted: Vec<&str> = message
        .strip_prefix("unknown field ")?
        .split('`')
        .skip(1)
        .step_by(2)
        .collect();
    let (got, known) = quoted.split_first()?;
    // A key without its unit, `mass` for `mass_kg`, is nearer than any other.
    let distance = |key: &&&str| match key.strip_prefix(got) {
        Some(unit) if unit.starts_with('_') => 0,
        _ => strsim::damerau_levenshtein(got, key),
    };
    let nearest = known.iter().min_by_key(distance)?;
    let is_near = 3 * distance(&nearest) <= got.chars().count().max(3);
    is_near.then(|| (*nearest).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sample {
        #[serde(rename = "sampling_rate_hz")]
        _rate: f64,
        #[serde(rename = "title")]
        _title: Option<String>,
    }

    #[test]
    fn a_misspelt_key_names_its_place_and_the_nearest_key() {
        let error = parse::<Sample>("title = \"a\"\nsamplng_rate_hz = 1.0\n", "scene.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("scene.toml:2:1: got unknown key `samplng_rate_hz`, expected"),
            "{error}"
        );
        assert!(
            error.ends_with("did you mean `sampling_rate_hz`?"),
            "{error}"
        );
    }

    #[test]
    fn a_wrong_type_names_its_place() {
        let error = parse::<Sample>("sampling_rate_hz = \"fast\"\n", "s.toml")
            .unwrap_err()
            .to_string();
        let expected = "s.toml:1:20: got the text \"fast\", expected a number";
        assert_eq!(error, expected);
    }
}
