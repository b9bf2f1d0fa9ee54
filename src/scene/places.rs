//! The place in a TOML file of a key that a message names, such as `[[test]] "hammer" band_hz`.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use super::error::{Place, SceneError};

/// A table with the byte at which it begins.
#[derive(Clone, Copy)]
struct Table<'t, 'd> {
    entries: &'t DeTable<'d>,
    start: usize,
}

/// The errors with their places in the file of this path and text, as far as it has the keys.
pub(super) fn located(error: SceneError, file: &str, text: &str) -> SceneError {
    match error {
        SceneError::Value {
            path,
            key,
            got,
            expected,
            place: None,
        } if path == file => SceneError::Value {
            place: key_place(text, &key, &got).map(Box::new),
            path,
            key,
            got,
            expected,
        },
        SceneError::Model {
            path,
            source,
            place: None,
        } if path == file => SceneError::Model {
            place: part_place(text, &source.to_string()).map(Box::new),
            path,
            source,
        },
        SceneError::Several { faults } => {
            let faults = faults.into_iter();
            SceneError::Several {
                faults: faults.map(|fault| located(fault, file, text)).collect(),
            }
        }
        other => other,
    }
}

/// Line and column, from 1, of a byte of a text.
pub(super) fn place_at(text: &str, byte: usize) -> Place {
    let before = text.get(..byte).unwrap_or(text);
    Place {
        line: before.matches('\n').count() + 1,
        column: before.rsplit('\n').next().unwrap_or("").chars().count() + 1,
    }
}

impl<'t, 'd> Table<'t, 'd> {
    /// The tables of a key: one, or those of an array.
    fn below(&self, key: &str) -> Vec<Table<'t, 'd>> {
        let Some(value) = self.entries.get(key) else {
            return Vec::new();
        };
        let table = |value: &'t DeValue<'d>, start: usize| match value {
            DeValue::Table(entries) => Some(Table { entries, start }),
            _ => None,
        };
        match value.get_ref() {
            DeValue::Array(items) => {
                let items = items.iter();
                let tables = items.filter_map(|item| table(item.get_ref(), item.span().start));
                tables.collect()
            }
            single => table(single, value.span().start).into_iter().collect(),
        }
    }

    /// The byte at which the value of a key begins.
    fn value_at(&self, key: &str) -> Option<usize> {
        Some(self.entries.get(key)?.span().start)
    }

    /// The byte at which a text stands: the value of a key other than the name, or in an array.
    fn text_at(&self, wanted: &str) -> Option<usize> {
        let is_wanted = |value: &DeValue| matches!(value, DeValue::String(text) if text == wanted);
        let mut values = self.entries.iter();
        values.find_map(|(key, value)| match value.get_ref() {
            _ if key.get_ref() == "name" => None,
            DeValue::Array(items) => {
                let mut items = items.iter();
                let item = items.find(|item| is_wanted(item.get_ref()))?;
                Some(item.span().start)
            }
            single => is_wanted(single).then(|| value.span().start),
        })
    }

    fn has_name(&self, wanted: &str) -> bool {
        let name = self.entries.get("name").map(|value| value.get_ref());
        matches!(name, Some(DeValue::String(text)) if text == wanted)
    }

    /// Whether the key `column` has this number.
    fn has_column(&self, wanted: &str) -> bool {
        let column = self.entries.get("column").map(|value| value.get_ref());
        matches!(column, Some(DeValue::Integer(number)) if number.as_str() == wanted)
    }

    fn has_text(&self, wanted: &str) -> bool {
        let mut values = self.entries.values();
        values.any(|value| matches!(value.get_ref(), DeValue::String(text) if text == wanted))
    }
}

/// The place of a key: of several tables that could be meant, the one that the key names, else the
/// one with the value, else the last. A table of an array inside it may be named as well.
pub(super) fn key_place(text: &str, key: &str, got: &str) -> Option<Place> {
    let document = DeTable::parse(text).ok()?;
    let document = Table {
        entries: document.get_ref(),
        start: 0,
    };
    let Some(header) = key.strip_prefix('[') else {
        return document.value_at(key).map(|at| place_at(text, at));
    };
    let (header, names) = header.trim_start_matches('[').split_once(']')?;
    let mut names = words(names.trim_start_matches(']'));
    let mut tables = vec![document];
    let mut parts = header.split('.').peekable();
    while let Some(part) = parts.next() {
        tables = tables.iter().flat_map(|table| table.below(part)).collect();
        let outer = names.iter().rposition(|name| {
            let is_outer = parts.peek().is_some();
            is_outer && tables.iter().any(|table| table.has_name(name))
        });
        if let Some(name) = outer.map(|position| names.remove(position)) {
            tables.retain(|table| table.has_name(&name));
        }
    }
    let is_named = |table: &Table| {
        let mut names = names.iter();
        names.any(|name| table.has_text(name) || table.has_column(name))
    };
    if tables.iter().any(is_named) {
        tables.retain(is_named);
    } else if let Some(number) = names.iter().find_map(|name| name.parse::<usize>().ok()) {
        let numbered = number.checked_sub(1).and_then(|index| tables.get(index));
        tables = numbered.map_or(tables.clone(), |table| vec![*table]);
    }
    let keys = tables.iter().filter_map(|table| {
        let mut names = names.iter().rev();
        names.find_map(|name| table.value_at(name))
    });
    let keys: Vec<usize> = keys.collect();
    let holds_value = |at: &&usize| {
        let line = text.get(**at..).and_then(|rest| rest.lines().next());
        line.is_some_and(|line| line.contains(got.trim_matches('"')))
    };
    let meant = keys.iter().find(holds_value).or(keys.last()).copied();
    let at = meant.or_else(|| tables.last().map(|table| table.start))?;
    Some(place_at(text, at))
}

/// The place of a part of a model, such as ``spring `left mount` ``, or of a property of it that
/// the message names.
fn part_place(text: &str, message: &str) -> Option<Place> {
    let document = DeTable::parse(text).ok()?;
    let document = Table {
        entries: document.get_ref(),
        start: 0,
    };
    let (before, rest) = message.split_once('`')?;
    let (name, said) = rest.split_once('`')?;
    let got = said.split('`').nth(1).unwrap_or_default();
    let kind = before.trim_start_matches("got ").trim().replace(' ', "_");
    let parts = document.below(&kind);
    let part = parts
        .iter()
        .copied()
        .rfind(|part| part.has_name(name) && (got.is_empty() || part.text_at(got).is_some()))
        .or_else(|| parts.iter().rfind(|part| part.has_name(name)).copied())?;
    let mut said = words(said).into_iter();
    let property = said.find_map(|word| part.value_at(&word).filter(|_| word != "name"));
    let property = property.or_else(|| part.text_at(got));
    let at = property.or_else(|| part.value_at("name"))?;
    Some(place_at(text, at))
}

/// The words of a text; one in quotation marks is a word without them.
fn words(text: &str) -> Vec<Cow<'_, str>> {
    let mut words = Vec::new();
    for (number, part) in text.split('"').enumerate() {
        match number % 2 {
            1 => words.push(Cow::Borrowed(part)),
            _ => words.extend(part.split_whitespace().map(trimmed).map(Cow::Borrowed)),
        }
    }
    words
}

fn trimmed(word: &str) -> &str {
    word.trim_matches([',', ':', ';', '`'])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "schema = \"s\"\n[[test]]\nname = \"a\"\nband_hz = [9, 1]\n\
                         [[test.channel]]\ncolumn = \"F\"\nunit = \"N\"\n[[test]]\nname = \"b\"\n\
                         band_hz = [1, 9]\n[pair]\nmin_mac = 95\n[[limits.mode]]\nfrequency_hz = 1\n\
                         [[limits.mode]]\nfrequency_hz = -5\n";

    #[test]
    fn keys_of_messages_have_their_places() {
        let line = |key: &str, got: &str| key_place(SCENE, key, got).map(|place| place.line);
        for (key, got, expected) in [
            ("schema", "\"s\"", 1),
            ("[[test]] \"a\" band_hz", "[9.0, 1.0]", 4),
            ("[[test]] \"b\" band_hz", "[1.0, 9.0]", 10),
            ("[[test]] name", "\"b\" twice", 9),
            ("[[test.channel]] \"F\" unit", "\"N\"", 7),
            ("[[test.channel]] \"F\" role", "nothing", 5),
            ("[pair] min_mac", "95", 12),
            ("[[limits.mode]] 2 frequency_hz", "-5", 16),
        ] {
            assert_eq!(line(key, got), Some(expected), "{key}");
        }
        assert_eq!(line("[frf] estimator", "\"h9\""), None);
        let place = key_place(SCENE, "[pair] min_mac", "95").unwrap();
        assert_eq!((place.line, place.column), (12, 11));
    }

    #[test]
    fn parts_of_a_model_have_their_places() {
        let model =
            "[[body]]\nname = \"b\"\nmass_kg = -4\n[[spring]]\nname = \"s\"\nfrom = \"x\"\n";
        let line = |message: &str| part_place(model, message).map(|place| place.line);
        assert_eq!(
            line("body `b`: got mass_kg -4, expected 0 or more"),
            Some(3)
        );
        assert_eq!(line("spring `s`: got point `x`, expected a point"), Some(6));
        assert_eq!(line("spring `t`: got point `x`, expected a point"), None);
        let model = "[[body]]\nname = \"b\"\nfree = [\"x\"]\nmass_kg = \"m\"\n\
                     inertia_kg_m2 = [\n1,\n\"i\", 2]\n";
        let line = |message: &str| part_place(model, message).map(|place| place.line);
        assert_eq!(
            line("body `b`: got parameter `m`, expected one of a"),
            Some(4)
        );
        assert_eq!(
            line("body `b`: got parameter `i`, expected one of a"),
            Some(7)
        );
        // The name of a part may be that of the parameter.
        assert_eq!(
            line("body `b`: got parameter `b`, expected one of a"),
            Some(2)
        );
    }
}
