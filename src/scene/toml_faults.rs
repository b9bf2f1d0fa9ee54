//! Finds every fault of a TOML document: the place of a fault is repaired by a value of the
//! expected type, and the document is deserialised again.
//!
//! A repaired value serves the search alone; a document with a fault is never used. The search ends
//! where no repair is known, such as behind a text that only a rule of the type accepts.

use std::borrow::Cow;
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::toml_value::{TomlError, deserialized};

/// Maximum number of times a document is deserialised: a fault takes one to nine attempts,
/// and a message lists twenty.
const MAX_ATTEMPTS: usize = 400;

/// Values that are tried in the place of a faulty or missing one.
const SUBSTITUTES: [&str; 8] = [
    "1.0",
    "\"stand-in\"",
    "1",
    "true",
    "[]",
    "[1.0, 1.0, 1.0]",
    "{}",
    "\"stand-in:+S\"",
];

/// Part of every text that is put in the place of another.
pub(super) const SUBSTITUTE_TEXT: &str = "stand-in";

/// Maximum number of errors of syntax that are taken for independent: an array, a table or a text
/// that is not closed makes many of one.
const MAX_SYNTAX_ERRORS: usize = 3;

/// Substitutes stand at places that no document has: the nth at this one plus n.
const FIRST_SUBSTITUTE: usize = usize::MAX / 2;

/// Deserialises a document.
///
/// # Errors
/// Every fault that the search finds, in the order of their places; at least one.
pub(super) fn from_text<T: DeserializeOwned>(text: &str) -> Result<T, TomlFaults<T>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        return Err(TomlFaults {
            faults: syntax_errors(&errors),
            all_found: true,
            repaired: None,
        });
    }
    let span = table.span();
    let root = Spanned::new(span, DeValue::Table(table.into_inner()));
    let first = match deserialized(root.clone()) {
        Ok(value) => return Ok(value),
        Err(error) => error,
    };
    Err(Search::of(root).faults::<T>(first))
}

/// The errors of syntax, of many the first.
fn syntax_errors(errors: &[toml::de::Error]) -> Vec<TomlError> {
    let start = |error: &&toml::de::Error| error.span().map_or(0, |span| span.start);
    let further = errors.len().saturating_sub(1);
    match errors.iter().min_by_key(start) {
        Some(first) if errors.len() > MAX_SYNTAX_ERRORS => vec![TomlError {
            message: format!(
                "{}; {further} faults of syntax behind it may follow from it (an array, a table or a text that is not closed at or above this line)",
                first.message()
            ),
            span: first.span(),
        }],
        _ => {
            let error = |error: &toml::de::Error| TomlError {
                message: error.message().to_owned(),
                span: error.span(),
            };
            errors.iter().map(error).collect()
        }
    }
}

/// Faults of a document, in the order of their places.
#[derive(Debug)]
pub(super) struct TomlFaults<T> {
    pub faults: Vec<TomlError>,
    /// Whether the search ended with a document without a fault.
    pub all_found: bool,
    /// The value of that document, whose repaired parts mean nothing.
    pub repaired: Option<T>,
}

/// The document with its repairs.
struct Search<'de> {
    root: Spanned<DeValue<'de>>,
    /// Index of the substitute that is tried, for each repaired place.
    tried: Vec<usize>,
}

impl<'de> Search<'de> {
    fn of(root: Spanned<DeValue<'de>>) -> Self {
        let tried = Vec::new();
        Self { root, tried }
    }

    fn faults<T: DeserializeOwned>(self, first: TomlError) -> TomlFaults<T> {
        let mut repaired = None;
        let (faults, all_found) = self.search(first, &mut |root| {
            deserialized::<T>(root).map(|value| repaired = Some(value))
        });
        TomlFaults {
            faults,
            all_found,
            repaired,
        }
    }

    /// Repairs fault after fault until `read` succeeds; the faults in order, and whether it did.
    fn search(
        mut self,
        first: TomlError,
        read: &mut dyn FnMut(Spanned<DeValue<'de>>) -> Result<(), TomlError>,
    ) -> (Vec<TomlError>, bool) {
        let mut faults: Vec<TomlError> = Vec::new();
        let mut next = Some(first);
        for _ in 0..MAX_ATTEMPTS {
            let Some(fault) = &next else { break };
            let span = fault.span.clone().unwrap_or(self.root.span());
            let of_document = span.start < FIRST_SUBSTITUTE;
            let is_known = faults.contains(fault);
            if of_document && !is_known {
                faults.push(fault.clone());
            }
            if of_document && is_known || !self.repair(&span, &fault.message) {
                break;
            }
            next = read(self.root.clone()).err();
        }
        let start = |fault: &TomlError| fault.span.as_ref().map_or(0, |span| span.start);
        faults.sort_by_key(start);
        (faults, next.is_none())
    }

    /// Repairs the fault at a place; false where no repair is known.
    fn repair(&mut self, span: &Range<usize>, message: &str) -> bool {
        if message.starts_with("unknown field") {
            return self.remove_key(span);
        }
        match message.strip_prefix("missing field ") {
            Some(key) => self.add(span, key.trim_matches('`')),
            None => self.replace(span, message),
        }
    }

    fn remove_key(&mut self, span: &Range<usize>) -> bool {
        visit(&mut self.root, &mut |value| {
            let DeValue::Table(table) = value.get_mut() else {
                return false;
            };
            let unknown = table.keys().find(|key| key.span() == *span);
            let unknown = unknown.map(|key| key.get_ref().clone().into_owned());
            unknown.is_some_and(|key| table.remove(key.as_str()).is_some())
        })
    }

    fn add(&mut self, span: &Range<usize>, key: &str) -> bool {
        let place = FIRST_SUBSTITUTE + self.tried.len();
        let Some(value) = substitute(0, place, "") else {
            return false;
        };
        self.tried.push(0);
        visit(&mut self.root, &mut |table| {
            let is_table = table.span() == *span;
            let DeValue::Table(table) = table.get_mut() else {
                return false;
            };
            if !is_table || table.contains_key(key) {
                return false;
            }
            let key = Spanned::new(place..place, Cow::Owned(key.to_owned()));
            table.insert(key, value.clone());
            true
        })
    }

    /// Puts the next substitute in the place of a value.
    fn replace(&mut self, span: &Range<usize>, message: &str) -> bool {
        let number = match span.start.checked_sub(FIRST_SUBSTITUTE) {
            Some(number) => number,
            None => {
                self.tried.push(0);
                self.tried.len() - 1
            }
        };
        let is_repaired = span.start >= FIRST_SUBSTITUTE;
        let Some(tried) = self.tried.get_mut(number) else {
            return false;
        };
        *tried += usize::from(is_repaired);
        let Some(value) = substitute(*tried, FIRST_SUBSTITUTE + number, message) else {
            return false;
        };
        visit(&mut self.root, &mut |found| {
            let is_value = found.span() == *span;
            if is_value {
                *found = value.clone();
            }
            is_value
        })
    }
}

/// A substitute at a place: the first name that the message expects, else the one of this index.
fn substitute(index: usize, place: usize, message: &str) -> Option<Spanned<DeValue<'static>>> {
    let expected = message.split_once("expected").map(|(_, names)| names);
    let name = expected.and_then(|names| names.split('`').nth(1));
    let value = match name.filter(|_| message.starts_with("unknown variant")) {
        Some(name) => DeValue::String(Cow::Owned(name.to_owned())),
        None => DeValue::parse(SUBSTITUTES.get(index)?).ok()?.into_inner(),
    };
    Some(at_place(value, place))
}

/// A value with all its parts at one place.
fn at_place(value: DeValue<'static>, place: usize) -> Spanned<DeValue<'static>> {
    let value = match value {
        DeValue::Array(items) => {
            let items = items.into_iter();
            DeValue::Array(
                items
                    .map(|item| at_place(item.into_inner(), place))
                    .collect(),
            )
        }
        other => other,
    };
    Spanned::new(place..place, value)
}

/// Calls `act` with a value and the values inside it until it returns true; whether it did.
fn visit<'de>(
    value: &mut Spanned<DeValue<'de>>,
    act: &mut dyn FnMut(&mut Spanned<DeValue<'de>>) -> bool,
) -> bool {
    if act(value) {
        return true;
    }
    match value.get_mut() {
        DeValue::Table(table) => table.iter_mut().any(|(_, value)| visit(value, act)),
        DeValue::Array(items) => items.iter_mut().any(|value| visit(value, act)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Kind {
        Beam,
        Lumped,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Spring {
        name: String,
        stiffness: f64,
        place: [f64; 3],
        count: Option<u32>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Model {
        kind: Kind,
        title: String,
        dof: crate::dof::Dof,
        #[serde(default)]
        spring: Vec<Spring>,
    }

    fn messages(text: &str) -> Vec<(usize, String)> {
        let found = from_text::<Model>(text).expect_err("a faulty document");
        assert!(found.all_found, "{:?}", found.faults);
        let line = |fault: &TomlError| {
            let start = fault.span.as_ref().map_or(0, |span| span.start);
            text[..start].matches('\n').count() + 1
        };
        found
            .faults
            .into_iter()
            .map(|fault| (line(&fault), fault.message))
            .collect()
    }

    #[test]
    fn every_fault_of_a_document_is_found() {
        let text = "kind = \"beem\"\ndof = 7\nextra = 1\n\n[[spring]]\nname = 3\nplace = [1, 2]\n\n\
                    [[spring]]\nnam = \"b\"\nstiffness = \"stiff\"\nplace = [0, 0, 0]\ncount = -1\n";
        let found = messages(text);
        let expected = [
            (1, "missing field `title`"),
            (1, "unknown variant `beem`"),
            (2, "invalid type: integer `7`"),
            (3, "unknown field `extra`"),
            (5, "missing field `stiffness`"),
            (6, "invalid type: integer `3`"),
            (7, "invalid length 2"),
            (9, "missing field `name`"),
            (10, "unknown field `nam`"),
            (11, "invalid type: string \"stiff\""),
            (13, "invalid value: integer `-1`"),
        ];
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        for ((line, message), (expected_line, beginning)) in found.iter().zip(expected) {
            assert_eq!(*line, expected_line, "{message}");
            assert!(
                message.starts_with(beginning),
                "{message}, expected {beginning}"
            );
        }
    }

    #[test]
    fn five_missing_keys_are_five_faults() {
        let text = "[[spring]]\n";
        let missing: Vec<String> = messages(text)
            .into_iter()
            .map(|(_, message)| message)
            .collect();
        for key in ["kind", "title", "dof", "name", "stiffness", "place"] {
            assert!(
                missing.contains(&format!("missing field `{key}`")),
                "{missing:?}"
            );
        }
        assert_eq!(missing.len(), 6);
    }

    #[test]
    fn every_error_of_syntax_is_found_and_nothing_else() {
        let found = messages("kind = \ntitle = \"a\ndof = \"1:+X\"\n");
        let lines: Vec<usize> = found.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [1, 2], "{found:?}");
    }

    #[test]
    fn an_unclosed_array_is_one_fault() {
        let text =
            "kind = \"beam\"\nplaces = [\n".to_owned() + &"[[spring]]\nname = \"a\"\n".repeat(20);
        let found = messages(&text);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].1.contains("may follow from it"), "{found:?}");
    }

    #[test]
    fn a_document_without_a_fault_is_its_value() {
        let text = "kind = \"lumped\"\ntitle = \"a\"\ndof = \"1:+X\"\n";
        let model: Model = from_text(text).expect("a valid document");
        assert!(matches!(model.kind, Kind::Lumped) && model.title == "a");
    }

    #[test]
    fn a_search_that_is_given_up_says_so() {
        let many = "[[spring]]\nname = 1\nstiffness = true\nplace = 3\n".repeat(200);
        let text = format!("kind = \"beam\"\ntitle = \"a\"\ndof = \"1:+X\"\n{many}");
        let found = from_text::<Model>(&text).expect_err("a faulty document");
        assert!(
            !found.all_found && found.faults.len() > 20,
            "{}",
            found.faults.len()
        );
    }
}
