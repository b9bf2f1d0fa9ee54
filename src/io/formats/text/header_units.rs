//! Units that a table's headings state, against those of the scene.
//!
//! The unit stands in brackets behind the heading (`Force [kN]`) or in a row of units below. A
//! known one must be that of the scene; for an axis whose unit the scene does not state it is
//! taken. Any other text is left to the scene.

use super::dialect::{Dialect, bare_unit, split_unit};
use crate::io::columns::frf_unit_text;
use crate::io::{ColumnRole, IoError, TableSpec};
use crate::quantity::{FrfUnit, Unit, frequency_factor, rotation_factor, time_factor};

/// Units of time and frequency that a message names.
const AXIS_UNITS: [&str; 8] = ["s", "ms", "us", "min", "Hz", "kHz", "rpm", "rad/s"];

/// The unit that a text states.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stated {
    Time(f64),
    Frequency(f64),
    Value(Unit),
    Frf(FrfUnit),
}

impl Stated {
    fn of(text: &str) -> Option<Self> {
        let frequency = || frequency_factor(text).or_else(|| rotation_factor(text));
        let time = time_factor(text).map(Stated::Time);
        let axis = time.or_else(|| frequency().map(Stated::Frequency));
        let value = || text.parse().ok().map(Stated::Value);
        axis.or_else(value)
            .or_else(|| text.parse().ok().map(Stated::Frf))
    }
}

/// The spec with the unit that the heading of its axis states.
///
/// # Errors
/// [`IoError::Text`] at the headings, or at the row of units, for a known unit that is not that of
/// the scene.
pub(super) fn with_heading_units(
    spec: &TableSpec,
    dialect: &Dialect,
    places: &[usize],
    path: &str,
) -> Result<TableSpec, IoError> {
    let mut spec = spec.clone();
    for (index, place) in places.iter().enumerate() {
        let column = &spec.columns[index];
        let Some((text, line)) = unit_at(dialect, *place) else {
            continue;
        };
        let Some(stated) = Stated::of(bare_unit(text)).or_else(|| Stated::of(text)) else {
            continue;
        };
        let (agrees, expected) = match (&column.role, stated) {
            (ColumnRole::Time, Stated::Time(factor))
            | (ColumnRole::Frequency, Stated::Frequency(factor)) => {
                let axis_factor = *spec.axis_to_si.get_or_insert(factor);
                (
                    same(axis_factor, factor),
                    axis_text(axis_factor, &column.role),
                )
            }
            (ColumnRole::Time, _) => (false, "a unit of time".to_owned()),
            (ColumnRole::Frequency, _) => (false, "a unit of frequency".to_owned()),
            (ColumnRole::Force { unit, .. } | ColumnRole::Response { unit, .. }, stated) => {
                (same_unit(unit, stated), unit.to_string())
            }
            (
                ColumnRole::Real { unit, .. }
                | ColumnRole::Imaginary { unit, .. }
                | ColumnRole::Complex { unit, .. }
                | ColumnRole::Magnitude { unit, .. },
                Stated::Frf(unit_read),
            ) => (
                same(unit_read.to_si, unit.to_si) && unit_read.kind == unit.kind,
                frf_unit_text(unit),
            ),
            _ => continue,
        };
        if !agrees {
            return Err(IoError::Text {
                path: path.to_owned(),
                line,
                what: "unit in the heading",
                got: text.to_owned(),
                expected: format!("{expected} in column {}, as the scene says", place + 1),
            });
        }
    }
    Ok(spec)
}

/// The text of a column's unit, and its line.
fn unit_at(dialect: &Dialect, place: usize) -> Option<(&str, u64)> {
    let heading = dialect.headings.get(place).map_or("", String::as_str);
    let below = dialect.units.get(place).map(|text| text.trim());
    match split_unit(heading).zip(dialect.heading_line) {
        Some(((_, unit), line)) => Some((unit, line)),
        None => below.zip(dialect.units_line),
    }
}

/// Equal but for the rounding of products and quotients.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs()
}

fn same_unit(unit: &Unit, stated: Stated) -> bool {
    matches!(stated, Stated::Value(value) if value.quantity == unit.quantity && same(value.to_si, unit.to_si))
}

fn axis_text(factor: f64, role: &ColumnRole) -> String {
    let is_this = |unit: &&&str| {
        let read = match (role, Stated::of(unit)) {
            (ColumnRole::Time, Some(Stated::Time(read))) => read,
            (ColumnRole::Frequency, Some(Stated::Frequency(read))) => read,
            _ => return false,
        };
        same(read, factor)
    };
    let unit = AXIS_UNITS.iter().find(is_this);
    unit.map_or_else(|| factor.to_string(), |unit| (*unit).to_owned())
}

#[cfg(test)]
mod tests {
    use crate::io::*;

    fn opened(text: &str, axis_to_si: Option<f64>, names: [&str; 3]) -> Result<EntryAxis, String> {
        let dof = None;
        let roles = [
            ColumnRole::Time,
            ColumnRole::Force {
                dof: dof.clone(),
                unit: "N".parse().expect("a unit"),
            },
            ColumnRole::Response {
                dof,
                unit: "m/s2".parse().expect("a unit"),
            },
        ];
        let columns = names.iter().zip(roles).map(|(name, role)| TableColumn {
            column: name.parse().map_or_else(
                |_| ColumnName::Heading((*name).to_owned()),
                ColumnName::Number,
            ),
            role,
            scale: 2.0,
        });
        let hints = Hints {
            path: "t.csv".to_owned(),
            table: Some(TableSpec {
                axis_to_si,
                columns: columns.collect(),
                ..TableSpec::default()
            }),
        };
        let source = open_bytes(text.as_bytes().to_vec(), &hints);
        let source = source.map_err(|error| error.to_string())?;
        Ok(source.catalog().entries[0].axis)
    }

    const ROWS: &str = "0,1,2\n0.5,3,4\n1.0,5,6\n";

    #[test]
    fn the_heading_states_the_unit_of_the_axis() {
        for (header, step) in [
            ("t [ms],F [N],a (m/s²)\n", 1e-3),
            ("t[ms],F(N),a[m/s2]\n", 1e-3),
            ("t,F,a\ns,N,m/s^2\n", 1.0),
            ("t,F,a\n[us],[N],[m/s2]\n", 1e-6),
            ("t [ticks],F [V],a (up)\n", 1.0),
        ] {
            for names in [["t", "F", "a"], ["1", "2", "3"]] {
                let axis =
                    opened(&format!("{header}{ROWS}"), None, names).expect("a table with a header");
                let (_, found) = axis.even().expect("even times");
                // The scale of the scene is 2, the spacing 0.5.
                assert!((found / step - 1.0).abs() < 1e-12, "{header} {found}");
            }
        }
        let axis = opened(&format!("t [ms],F,a\n{ROWS}"), Some(1e-3), ["t", "F", "a"]);
        assert!(
            (axis
                .expect("a table with a header")
                .even()
                .expect("even times")
                .1
                - 1e-3)
                .abs()
                < 1e-15
        );
    }

    #[test]
    fn a_heading_unit_contradicting_the_scene_is_an_error() {
        for (header, stated, message) in [
            (
                "t [s],F [kN],a [m/s2]\n",
                None,
                "t.csv:1: unit in the heading: got \"[kN]\", expected N in column 2, as the scene says",
            ),
            (
                "t [s],F [N],a [g]\n",
                None,
                "got \"[g]\", expected m/s2 in column 3",
            ),
            (
                "t,F,a\ns,N,g\n",
                None,
                "t.csv:2: unit in the heading: got \"g\", expected m/s2",
            ),
            (
                "t [ms],F,a\n",
                Some(1.0),
                "got \"[ms]\", expected s in column 1",
            ),
            (
                "t [Hz],F,a\n",
                None,
                "got \"[Hz]\", expected a unit of time in column 1",
            ),
        ] {
            let error = opened(&format!("{header}{ROWS}"), stated, ["t", "F", "a"]).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }
}
