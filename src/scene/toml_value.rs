//! Deserialises the values of a TOML document.
//!
//! The parser is that of `toml`. Its deserialiser has three types of tables (of values, spans and
//! dates), for each of which every struct is compiled; here a table has one type. An error is at
//! the key or value that it is about. Dates have no type here, a struct is a table, never an array,
//! and a text is one line.

use std::borrow::Cow;
use std::fmt::Display;
use std::ops::Range;

use serde::de::value::{CowStrDeserializer, MapAccessDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Error, Expected, MapAccess, SeqAccess, Unexpected, Visitor,
};
use serde::{Deserializer, forward_to_deserialize_any};
use toml::Spanned;
use toml::de::{DeArray, DeInteger, DeTable, DeValue};

use crate::printable::one_line;

/// Why a document cannot be deserialised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub(super) struct TomlError {
    pub message: String,
    /// Bytes of the value.
    pub span: Option<Range<usize>>,
}

impl TomlError {
    /// The error with this place, unless it has one.
    fn or_at(mut self, span: Range<usize>) -> Self {
        self.span.get_or_insert(span);
        self
    }
}

impl Error for TomlError {
    fn custom<T: Display>(message: T) -> Self {
        TomlError {
            message: message.to_string(),
            span: None,
        }
    }
}

/// Deserialises a value.
///
/// # Errors
/// [`TomlError`] where it is not what `T` expects.
pub(super) fn deserialized<T: DeserializeOwned>(
    value: Spanned<DeValue<'_>>,
) -> Result<T, TomlError> {
    T::deserialize(Value::from(value))
}

/// A key or a value with its place.
struct Value<'de> {
    value: DeValue<'de>,
    span: Range<usize>,
}

impl<'de> Value<'de> {
    fn of_key(key: Spanned<Cow<'de, str>>) -> Self {
        Value {
            span: key.span(),
            value: DeValue::String(key.into_inner()),
        }
    }
}

impl<'de> From<Spanned<DeValue<'de>>> for Value<'de> {
    fn from(value: Spanned<DeValue<'de>>) -> Self {
        Value {
            span: value.span(),
            value: value.into_inner(),
        }
    }
}

/// Entries of a table.
struct Entries<'de> {
    entries: <DeTable<'de> as IntoIterator>::IntoIter,
    value: Option<Value<'de>>,
}

impl<'de> Entries<'de> {
    fn new(table: DeTable<'de>) -> Self {
        Entries {
            entries: table.into_iter(),
            value: None,
        }
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = TomlError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, TomlError> {
        let Some((key, value)) = self.entries.next() else {
            return Ok(None);
        };
        self.value = Some(Value::from(value));
        let span = key.span();
        let key = seed.deserialize(Value::of_key(key));
        key.map(Some).map_err(|error| error.or_at(span))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, TomlError> {
        let value = self.value.take();
        let value = value.ok_or_else(|| TomlError::custom("a value was read before its key"))?;
        let span = value.span.clone();
        let value = seed.deserialize(value);
        value.map_err(|error| error.or_at(span))
    }
}

/// Values of an array.
struct Items<'de>(<DeArray<'de> as IntoIterator>::IntoIter);

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = TomlError;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, TomlError> {
        let Some(item) = self.0.next() else {
            return Ok(None);
        };
        let span = item.span();
        let item = seed.deserialize(Value::from(item));
        item.map(Some).map_err(|error| error.or_at(span))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// A value of a type that the visitor does not expect.
fn unexpected(value: &DeValue<'_>, expected: &dyn Expected) -> TomlError {
    let got = match value {
        DeValue::String(text) => Unexpected::Str(text),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(value) => Unexpected::Signed(value),
            Err(_) => Unexpected::Other("integer"),
        },
        DeValue::Float(number) => match number.as_str().parse() {
            Ok(value) => Unexpected::Float(value),
            Err(_) => Unexpected::Other("floating point number"),
        },
        DeValue::Boolean(value) => Unexpected::Bool(*value),
        DeValue::Datetime(_) => Unexpected::Other("date"),
        DeValue::Array(_) => Unexpected::Seq,
        DeValue::Table(_) => Unexpected::Map,
    };
    Error::invalid_type(got, expected)
}

fn visit_integer<'de, V: Visitor<'de>>(
    integer: &DeInteger<'_>,
    visitor: V,
) -> Result<V::Value, TomlError> {
    let (digits, radix) = (integer.as_str(), integer.radix());
    if let Ok(value) = i64::from_str_radix(digits, radix) {
        visitor.visit_i64(value)
    } else if let Ok(value) = u64::from_str_radix(digits, radix) {
        visitor.visit_u64(value)
    } else {
        Err(Error::custom(format!(
            "got the integer {integer}, expected one of at most 64 bits"
        )))
    }
}

fn visit_float<'de, V: Visitor<'de>>(digits: &str, visitor: V) -> Result<V::Value, TomlError> {
    match digits.parse::<f64>() {
        Ok(value) if value.is_finite() || !digits.contains(|c: char| c.is_ascii_digit()) => {
            visitor.visit_f64(value)
        }
        _ => Err(Error::custom(format!(
            "got {digits}, expected a magnitude of at most {:e}",
            f64::MAX
        ))),
    }
}

impl<'de> Deserializer<'de> for Value<'de> {
    type Error = TomlError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlError> {
        let result = match self.value {
            DeValue::String(text) => match text {
                text if text.contains(['\n', '\r']) => visitor.visit_str(&one_line(&text)),
                Cow::Borrowed(text) => visitor.visit_borrowed_str(text),
                Cow::Owned(text) => visitor.visit_string(text),
            },
            DeValue::Integer(integer) => visit_integer(&integer, visitor),
            DeValue::Float(number) => visit_float(number.as_str(), visitor),
            DeValue::Boolean(value) => visitor.visit_bool(value),
            DeValue::Array(values) => visitor.visit_seq(Items(values.into_iter())),
            DeValue::Table(table) => visitor.visit_map(Entries::new(table)),
            DeValue::Datetime(_) => Err(unexpected(&self.value, &visitor)),
        };
        result.map_err(|error| error.or_at(self.span))
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlError> {
        let result = match self.value {
            DeValue::Table(table) => visitor.visit_map(Entries::new(table)),
            other => Err(unexpected(&other, &visitor)),
        };
        result.map_err(|error| error.or_at(self.span))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, TomlError> {
        self.deserialize_map(visitor)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlError> {
        let result = match self.value {
            DeValue::Array(values) => visitor.visit_seq(Items(values.into_iter())),
            other => Err(unexpected(&other, &visitor)),
        };
        result.map_err(|error| error.or_at(self.span))
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _len: usize,
        visitor: V,
    ) -> Result<V::Value, TomlError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlError> {
        let result = match self.value {
            DeValue::String(text) => visitor.visit_str(&text),
            other => Err(unexpected(&other, &visitor)),
        };
        result.map_err(|error| error.or_at(self.span))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlError> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, TomlError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, TomlError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, TomlError> {
        let result = match self.value {
            DeValue::String(text) => visitor.visit_enum(CowStrDeserializer::new(text)),
            DeValue::Table(table) => {
                visitor.visit_enum(MapAccessDeserializer::new(Entries::new(table)))
            }
            other => Err(unexpected(&other, &visitor)),
        };
        result.map_err(|error| error.or_at(self.span))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct tuple_struct
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;

    use super::*;
    use crate::dof::Dof;

    fn from_text<T: DeserializeOwned>(text: &str) -> Result<T, TomlError> {
        let table = DeTable::parse(text).unwrap();
        let span = table.span();
        deserialized(Spanned::new(span, DeValue::Table(table.into_inner())))
    }

    #[derive(Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Window {
        Force,
        Exponential,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(untagged, expecting = "expected a number or a name")]
    enum Stiffness {
        Number(f64),
        Name(String),
    }

    #[derive(Debug, PartialEq, Deserialize)]
    struct Hertz(f64);

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Values {
        name: String,
        count: u64,
        level: Option<Hertz>,
        windows: Vec<Window>,
        place: (f64, f64),
        by_window: BTreeMap<Window, i64>,
        by_dof: BTreeMap<Dof, f64>,
        stiffness: Vec<Stiffness>,
        dof: Option<Dof>,
    }

    const TEXT: &str = r#"
name = "a\tb"
count = 0xff
level = 2.5
windows = ["force", "exponential"]
place = [-1, 1e3]
by_window.force = -7
by_dof."2:+Y" = 3
stiffness = [1, "k"]
dof = "1:+X"
"#;

    #[test]
    fn values_are_those_that_the_crate_reads() {
        let values = from_text::<Values>(TEXT).unwrap();
        assert_eq!(values, toml::from_str::<Values>(TEXT).unwrap());
        assert_eq!((values.count, values.level), (255, Some(Hertz(2.5))));
        assert_eq!(values.stiffness[1], Stiffness::Name("k".to_owned()));
        let numbers = "a = inf\nb = -nan\nc = 1_000.5\nd = -3\ne = 0o17\nf = 0b101";
        let numbers = from_text::<BTreeMap<String, f64>>(numbers).unwrap();
        assert_eq!((numbers["a"], numbers["c"]), (f64::INFINITY, 1000.5));
        assert_eq!(
            (numbers["d"], numbers["e"], numbers["f"]),
            (-3.0, 15.0, 5.0)
        );
        assert!(numbers["b"].is_nan());
    }

    #[test]
    fn a_date_under_an_ignored_key_is_no_error() {
        #[derive(Deserialize)]
        struct Limits {
            limit: u64,
        }
        let limits = from_text::<Limits>("date = 2025-01-01\nlimit = 3\n[other]\nat = 07:00:00");
        assert_eq!(limits.unwrap().limit, 3);
    }

    #[test]
    fn an_error_is_at_the_value_or_key_that_it_is_about() {
        // Whether the crate has the error at the same place.
        let cases = [
            ("count = 0xff", "count = -1", "-1", "integer `-1`", true),
            (
                "count = 0xff",
                "count = 1e400",
                "1e400",
                "a magnitude of at most",
                true,
            ),
            (
                "count = 0xff",
                "count = 99999999999999999999",
                "99",
                "64 bits",
                true,
            ),
            ("count = 0xff", "count = 1979-05-27", "1979", "date", true),
            (
                "count = 0xff",
                "count = 1\ncounts = 2",
                "counts",
                "unknown field `counts`",
                true,
            ),
            (
                "count = 0xff\n",
                "",
                "\nname",
                "missing field `count`",
                true,
            ),
            (
                "2.5",
                "[0x10]",
                "[0x10]",
                "invalid type: sequence, expected f64",
                true,
            ),
            (
                "[-1, 1e3]",
                "[-1, \"x\"]",
                "\"x\"",
                "string \"x\", expected f64",
                true,
            ),
            ("[-1, 1e3]", "[-1]", "[-1]", "invalid length 1", true),
            (
                "[-1, 1e3]",
                "0x10",
                "0x10",
                "integer `16`, expected a tuple",
                true,
            ),
            (
                "\"exponential\"",
                "\"none\"",
                "\"none\"",
                "unknown variant `none`",
                true,
            ),
            (
                "by_window.force = -7",
                "by_window = 3",
                "3",
                "integer `3`, expected a map",
                true,
            ),
            ("\"2:+Y\"", "\"2:+Q\"", "\"2:+Q\"", "2:+Q", true),
            ("\"1:+X\"", "\"1:+Q\"", "\"1:+Q\"", "1:+Q", true),
            (
                "[1, \"k\"]",
                "[1, true]",
                "true",
                "expected a number or a name",
                false,
            ),
        ];
        for (from, to, place, message, same_place) in cases {
            let text = TEXT.replace(from, to);
            assert_ne!(text, TEXT, "{from}");
            let error = from_text::<Values>(&text).unwrap_err();
            assert!(error.message.contains(message), "{to}: {error}");
            let span = error.span.unwrap();
            assert!(text[span.start..].starts_with(place), "{to}: at {span:?}");
            let of_crate = toml::from_str::<Values>(&text).unwrap_err();
            assert_eq!(of_crate.span() == Some(span), same_place, "{to}");
        }
    }
}
