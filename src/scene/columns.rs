//! `[[test.channel]]` of a scene states the columns of a table.

use crate::frf::Window;
use crate::io::{ColumnName, ColumnRole, Delimiter, Dimension, TableColumn, TableSpec};
use crate::quantity::{FrfUnit, Quantity, Unit, UnitError};

use super::SceneError;
use super::error::value_error;
use super::faults::Faults;
use super::typed::{ChannelTable, ColumnKey, TestTable};

/// Errors of the keys of one channel.
struct ChannelErrors<'a> {
    path: &'a str,
    test: &'a str,
    column: String,
}

impl ChannelErrors<'_> {
    fn at_key(&self, key: &str, got: impl Into<String>, expected: impl Into<String>) -> SceneError {
        let key = channel_key(self.test, &self.column, key);
        value_error(self.path, &key, &got.into(), &expected.into())
    }
}

/// A key of a channel, as an error names it.
pub(super) fn channel_key(test: &str, column: &str, key: &str) -> String {
    format!("[[test.channel]] {column} of {test:?}, {key}")
}

/// How to read the tables of a test.
///
/// # Errors
/// [`SceneError::Value`] with the key.
pub fn table_spec(test: &TestTable, path: &str) -> Result<TableSpec, SceneError> {
    let mut faults = Faults::default();
    let of_channel = |faults: &mut Faults<SceneError>, channel| {
        let axis = faults
            .take(axis_factor(channel, &test.name, path))
            .flatten();
        (axis, faults.take(column(channel, &test.name, path)))
    };
    let channels = test.channel.iter();
    let (axes, columns): (Vec<Option<f64>>, Vec<Option<TableColumn>>) = channels
        .map(|channel| of_channel(&mut faults, channel))
        .unzip();
    let spec = TableSpec {
        axis_to_si: axes.into_iter().flatten().next(),
        delimiter: faults.take(delimiter(test, path)).flatten(),
        skip_lines: test.skip_lines,
        dimensions: faults.take(dimensions(test, path)).flatten(),
        sampling_rate_hz: faults.take(sampling_rate(test, path)).flatten(),
        columns: columns.into_iter().flatten().collect(),
    };
    faults.into_result().map(|()| spec)
}

fn sampling_rate(test: &TestTable, path: &str) -> Result<Option<f64>, SceneError> {
    match test.sampling_rate_hz {
        Some(hz) if !(hz.is_finite() && hz > 0.0) => Err(value_error(
            path,
            &format!("[[test]] {:?} sampling_rate_hz", test.name),
            &hz.to_string(),
            "a positive number of samples per second",
        )),
        other => Ok(other),
    }
}

fn delimiter(test: &TestTable, path: &str) -> Result<Option<Delimiter>, SceneError> {
    match test.delimiter.as_deref() {
        None => Ok(None),
        Some("comma") => Ok(Some(Delimiter::Comma)),
        Some("semicolon") => Ok(Some(Delimiter::Semicolon)),
        Some("tab") => Ok(Some(Delimiter::Tab)),
        Some("blank") => Ok(Some(Delimiter::Blank)),
        Some(other) => Err(value_error(
            path,
            &format!("[[test]] {:?} delimiter", test.name),
            &format!("{other:?}"),
            "comma, semicolon, tab or blank",
        )),
    }
}

/// The window that a scene states.
///
/// # Errors
/// [`SceneError::Value`] for an unknown name.
pub(super) fn window(name: Option<&str>, path: &str) -> Result<Option<Window>, SceneError> {
    let Some(name) = name else { return Ok(None) };
    let got = format!("{name:?}");
    let unknown = || value_error(path, "[[test]] window", &got, &Window::names());
    Window::from_name(name).map(Some).ok_or_else(unknown)
}

/// Meaning of the dimensions of an array: each at most once, samples always.
fn dimensions(test: &TestTable, path: &str) -> Result<Option<Vec<Dimension>>, SceneError> {
    let Some(names) = &test.dimensions else {
        return Ok(None);
    };
    let one = |name: &String| match name.as_str() {
        "hit" => Some(Dimension::Hit),
        "channel" => Some(Dimension::Channel),
        "sample" => Some(Dimension::Sample),
        _ => None,
    };
    let found: Option<Vec<Dimension>> = names.iter().map(one).collect();
    let each_once = |all: &Vec<Dimension>| {
        let count = |wanted| all.iter().filter(|role| **role == wanted).count();
        count(Dimension::Sample) == 1
            && count(Dimension::Hit) <= 1
            && count(Dimension::Channel) <= 1
    };
    match found.filter(each_once) {
        Some(dimensions) => Ok(Some(dimensions)),
        None => Err(value_error(
            path,
            &format!("[[test]] {:?} dimensions", test.name),
            &format!("{names:?}"),
            "hit, channel and sample, slowest first, each at most once and sample always",
        )),
    }
}

fn column(channel: &ChannelTable, test: &str, path: &str) -> Result<TableColumn, SceneError> {
    let name = match &channel.column {
        ColumnKey::Number(number) => ColumnName::Number(*number),
        ColumnKey::Heading(heading) => ColumnName::Heading(heading.clone()),
    };
    let errors = ChannelErrors {
        path,
        test,
        column: channel.column.to_string(),
    };
    let scale = channel.scale.unwrap_or(1.0);
    if !scale.is_finite() || scale == 0.0 {
        return Err(errors.at_key("scale", scale.to_string(), "a finite number other than 0"));
    }
    Ok(TableColumn {
        column: name,
        role: role(channel, &errors)?,
        scale,
    })
}

/// Factor to s or Hz of an axis with a stated unit; `None` for every other column.
fn axis_factor(channel: &ChannelTable, test: &str, path: &str) -> Result<Option<f64>, SceneError> {
    let errors = ChannelErrors {
        path,
        test,
        column: channel.column.to_string(),
    };
    let known: &[(&str, f64)] = match channel.role.as_deref() {
        Some("time") => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6)],
        Some("frequency") => &[("Hz", 1.0), ("kHz", 1e3)],
        _ => return Ok(None),
    };
    if channel.dof.is_some() || channel.quantity.is_some() {
        return Err(errors.at_key("dof or quantity", "one for an axis", "none"));
    }
    let Some(unit) = channel.unit.as_deref() else {
        return Ok(None);
    };
    let found = known.iter().find(|(name, _)| *name == unit);
    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    let found =
        found.ok_or_else(|| errors.at_key("unit", format!("{unit:?}"), names.join(" or ")))?;
    Ok(Some(found.1))
}

fn role(channel: &ChannelTable, errors: &ChannelErrors) -> Result<ColumnRole, SceneError> {
    let dof = channel.dof.clone();
    match channel.role.as_deref() {
        Some("time") => Ok(ColumnRole::Time),
        Some("frequency") => Ok(ColumnRole::Frequency),
        Some("force") => Ok(ColumnRole::Force {
            dof,
            unit: unit(channel, errors, |q| q == Quantity::Force, "a force unit")?,
        }),
        Some("response") => {
            let is_response = |q| q != Quantity::Force;
            let unit = unit(
                channel,
                errors,
                is_response,
                "a unit of acceleration, velocity or displacement",
            )?;
            Ok(ColumnRole::Response { dof, unit })
        }
        Some("real") => Ok(ColumnRole::Real {
            dof,
            unit: frf_unit(channel, errors)?,
        }),
        Some("imaginary") => Ok(ColumnRole::Imaginary {
            dof,
            unit: frf_unit(channel, errors)?,
        }),
        Some("complex") => Ok(ColumnRole::Complex {
            dof,
            unit: frf_unit(channel, errors)?,
        }),
        Some("magnitude") => Ok(ColumnRole::Magnitude {
            dof,
            unit: frf_unit(channel, errors)?,
        }),
        Some("phase") => match channel.unit.as_deref() {
            None | Some("deg" | "°") => Ok(ColumnRole::PhaseDegrees { dof }),
            Some(text) => Err(errors.at_key("unit", format!("{text:?}"), "deg")),
        },
        Some("coherence") => match channel.unit.as_deref() {
            None | Some("1") => Ok(ColumnRole::Coherence { dof }),
            Some(text) => Err(errors.at_key("unit", format!("{text:?}"), "none")),
        },
        other => Err(errors.at_key(
            "role",
            other.map_or_else(|| "nothing".to_owned(), |text| format!("{text:?}")),
            "time, frequency, force, response, real, imaginary, complex, magnitude, phase or coherence",
        )),
    }
}

fn unit(
    channel: &ChannelTable,
    errors: &ChannelErrors,
    fits: impl Fn(Quantity) -> bool,
    expected: &str,
) -> Result<Unit, SceneError> {
    let text = channel.unit.as_deref().ok_or_else(|| {
        errors.at_key(
            "unit",
            "nothing",
            format!("{expected}; there is no default"),
        )
    })?;
    let unit = Unit::of_any_quantity(text).map_err(|error: UnitError| {
        errors.at_key("unit", format!("{text:?}"), error.to_string())
    })?;
    if !fits(unit.quantity) {
        return Err(errors.at_key("unit", format!("{text:?}"), expected));
    }
    match channel.quantity.as_deref() {
        Some(name) if name != unit.quantity.to_string() => Err(errors.at_key(
            "quantity",
            format!("{name:?} with unit {text:?}"),
            unit.quantity.to_string(),
        )),
        _ => Ok(unit),
    }
}

fn frf_unit(channel: &ChannelTable, errors: &ChannelErrors) -> Result<FrfUnit, SceneError> {
    let expected = "a unit of response over force such as (m/s2)/N; there is no default";
    let text = channel
        .unit
        .as_deref()
        .ok_or_else(|| errors.at_key("unit", "nothing", expected))?;
    let unit = FrfUnit::of_any_response(text)
        .map_err(|_| errors.at_key("unit", format!("{text:?}"), expected))?;
    match channel.quantity.as_deref() {
        Some(name) if name != unit.kind.to_string() => Err(errors.at_key(
            "quantity",
            format!("{name:?} with unit {text:?}"),
            unit.kind.to_string(),
        )),
        _ => Ok(unit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_an_axis_is_known_where_it_is_stated() {
        let of = |unit: &str| {
            let text = format!(
                "name = \"t\"\n[[channel]]\ncolumn = 1\nrole = \"time\"\nscale = 2.0\n{unit}\n"
            );
            let typed: TestTable = toml::from_str(&text).unwrap();
            table_spec(&typed, "s.toml").map(|spec| (spec.axis_to_si, spec.columns[0].scale))
        };
        assert_eq!(of("unit = \"ms\"").unwrap(), (Some(1e-3), 2.0));
        assert_eq!(of("").unwrap(), (None, 2.0));
        assert!(of("unit = \"Hz\"").is_err());
    }
}
