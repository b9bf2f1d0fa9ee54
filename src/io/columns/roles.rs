//! Whether the roles that a scene gives to columns fit together: every column is used, and each in
//! one way.

use crate::io::{ColumnName, ColumnRole, IoError, TableColumn, TableSpec};
use crate::quantity::{FrfUnit, Unit};

/// Checks the roles before any value is taken.
///
/// # Errors
/// [`IoError::Grouping`] for two columns in one role, for records beside parts of FRFs, and for an
/// axis alone; [`IoError::NotStated`] for an imaginary part or a phase without the column that it
/// belongs to.
pub(super) fn check_roles(spec: &TableSpec, path: &str) -> Result<(), IoError> {
    check_roles_differ(spec, path)?;
    let columns = || spec.columns.iter();
    let of_frf = columns().find(|column| kind(&column.role) == RoleKind::Frf);
    let of_time = columns().find(|column| kind(&column.role) == RoleKind::Time);
    if let (Some(frf), Some(time)) = (of_frf, of_time) {
        let columns = format!(
            "{} as {} beside {} as {}",
            column_text(&time.column),
            role_name(&time.role),
            column_text(&frf.column),
            role_name(&frf.role)
        );
        return Err(IoError::Grouping {
            path: path.to_owned(),
            what: "roles of the columns",
            got: columns,
            expected: "roles of time records (time, force, response) alone, or of functions alone"
                .to_owned(),
        });
    }
    if !columns().any(|column| !matches!(column.role, ColumnRole::Time | ColumnRole::Frequency)) {
        return Err(IoError::NotStated {
            path: path.to_owned(),
            what: "what is measured".to_owned(),
            expected: "a column of values beside the axis ([[test.channel]])".to_owned(),
        });
    }
    match columns().find(|column| lacks_partner(spec, &column.role)) {
        Some(alone) => Err(missing_partner_error(alone, path)),
        None => Ok(()),
    }
}

/// Which records or functions a role is of.
#[derive(PartialEq, Eq)]
enum RoleKind {
    Time,
    Frf,
}

fn kind(role: &ColumnRole) -> RoleKind {
    match role {
        ColumnRole::Time | ColumnRole::Force { .. } | ColumnRole::Response { .. } => RoleKind::Time,
        _ => RoleKind::Frf,
    }
}

/// Two axes, or two equal parts of an FRF, could each be meant. Records stand alone, whatever their
/// points.
fn check_roles_differ(spec: &TableSpec, path: &str) -> Result<(), IoError> {
    let alone =
        |role: &ColumnRole| matches!(role, ColumnRole::Force { .. } | ColumnRole::Response { .. });
    for (index, second) in spec.columns.iter().enumerate() {
        let before = spec.columns[..index].iter();
        let mut equal = before.filter(|column| column.role == second.role && !alone(&column.role));
        let Some(first) = equal.next() else { continue };
        let axis = matches!(second.role, ColumnRole::Time | ColumnRole::Frequency);
        return Err(IoError::Grouping {
            path: path.to_owned(),
            what: "roles of the columns",
            got: format!(
                "{} and {} both as {}",
                column_text(&first.column),
                column_text(&second.column),
                role_name(&second.role)
            ),
            expected: if axis {
                "one axis".to_owned()
            } else {
                "a different `dof` for each in [[test.channel]]".to_owned()
            },
        });
    }
    Ok(())
}

/// Whether a column is an imaginary part or phase of an FRF without a real part or magnitude; the
/// converse is checked when the FRF is read.
fn lacks_partner(spec: &TableSpec, role: &ColumnRole) -> bool {
    let mut others = spec.columns.iter().map(|column| &column.role);
    match role {
        ColumnRole::Imaginary { dof, unit } => {
            let (dof, unit) = (dof.clone(), *unit);
            let real = ColumnRole::Real { dof, unit };
            !others.any(|role| *role == real)
        }
        ColumnRole::PhaseDegrees { dof } => !others
            .any(|role| matches!(role, ColumnRole::Magnitude { dof: other, .. } if other == dof)),
        _ => false,
    }
}

fn missing_partner_error(alone: &TableColumn, path: &str) -> IoError {
    let (part, expected) = match alone.role {
        ColumnRole::PhaseDegrees { .. } => (
            "magnitude",
            "a column with role = \"magnitude\" and the same dof",
        ),
        _ => (
            "real part",
            "a column with role = \"real\" and the same dof and unit",
        ),
    };
    IoError::NotStated {
        path: path.to_owned(),
        what: format!("the {part} that belongs to {}", column_text(&alone.column)),
        expected: expected.to_owned(),
    }
}

/// A column as an error names it.
fn column_text(column: &ColumnName) -> String {
    match column {
        ColumnName::Heading(heading) => format!("column {heading:?}"),
        ColumnName::Number(number) => format!("column {number}"),
    }
}

/// A role as a scene writes it.
fn role_name(role: &ColumnRole) -> &'static str {
    match role {
        ColumnRole::Time => "time",
        ColumnRole::Frequency => "frequency",
        ColumnRole::Force { .. } => "force",
        ColumnRole::Response { .. } => "response",
        ColumnRole::Real { .. } => "real",
        ColumnRole::Imaginary { .. } => "imaginary",
        ColumnRole::Complex { .. } => "complex",
        ColumnRole::Magnitude { .. } => "magnitude",
        ColumnRole::PhaseDegrees { .. } => "phase",
        ColumnRole::Coherence { .. } => "coherence",
    }
}

/// A text of exactly this unit: of known units, or `FACTOR x` the one in SI.
pub(in crate::io) fn frf_unit_text(unit: &FrfUnit) -> String {
    let si = unit.kind.si_unit();
    if unit.to_si.to_bits() == 1f64.to_bits() {
        return si.to_owned();
    }
    let quantity = unit.kind.response_quantity();
    let over = |force: &str| {
        let to_si = unit.to_si * force.parse::<Unit>().ok()?.to_si;
        let response = Unit { quantity, to_si }.name()?;
        let text = if response.contains('/') {
            format!("({response})/{force}")
        } else {
            format!("{response}/{force}")
        };
        let same = text.parse::<FrfUnit>().is_ok_and(|named| named == *unit);
        same.then_some(text)
    };
    let known = ["N", "kN", "lbf"].into_iter().find_map(over);
    known.unwrap_or_else(|| format!("{} x {si}", unit.to_si))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(roles: Vec<ColumnRole>) -> Result<(), String> {
        let column = |(index, role)| TableColumn {
            column: ColumnName::Number(index + 1),
            role,
            scale: 1.0,
        };
        let spec = TableSpec {
            columns: roles.into_iter().enumerate().map(column).collect(),
            ..TableSpec::default()
        };
        check_roles(&spec, "t.csv").map_err(|error| error.to_string())
    }

    fn part(text: &str, point: Option<&str>) -> ColumnRole {
        let dof = point.map(|point| point.parse().unwrap());
        let unit = "m/N".parse().unwrap();
        match text {
            "real" => ColumnRole::Real { dof, unit },
            "imaginary" => ColumnRole::Imaginary { dof, unit },
            "magnitude" => ColumnRole::Magnitude { dof, unit },
            "phase" => ColumnRole::PhaseDegrees { dof },
            "complex" => ColumnRole::Complex { dof, unit },
            "time" => ColumnRole::Time,
            "frequency" => ColumnRole::Frequency,
            "force" => ColumnRole::Force {
                dof,
                unit: "N".parse().unwrap(),
            },
            other => panic!("{other}"),
        }
    }

    #[test]
    fn two_frfs_need_their_points() {
        let of = |second| {
            let mut roles = vec![part("frequency", None)];
            for point in [None, second] {
                roles.extend(["real", "imaginary"].map(|text| part(text, point)));
            }
            checked(roles)
        };
        assert_eq!(
            of(None).unwrap_err(),
            "t.csv: roles of the columns: got column 2 and column 4 both as real, expected a different `dof` for each \
             in [[test.channel]]"
        );
        assert_eq!(of(Some("2:+Z")), Ok(()));
    }

    #[test]
    fn an_unused_column_is_an_error() {
        for (roles, message) in [
            (
                &["time", "time", "force"][..],
                "column 1 and column 2 both as time, expected one axis",
            ),
            (&["frequency", "frequency", "complex"], "both as frequency"),
            (
                &["frequency", "complex", "imaginary"],
                "the real part that belongs to column 3 is not stated",
            ),
            (
                &["frequency", "complex", "phase"],
                "the magnitude that belongs to column 3 is not stated",
            ),
            (
                &["frequency", "complex", "force"],
                "column 3 as force beside column 1 as frequency",
            ),
            (
                &["time", "force", "complex"],
                "column 1 as time beside column 3 as complex",
            ),
            (&["time"], "what is measured is not stated"),
        ] {
            let error = checked(roles.iter().map(|text| part(text, None)).collect()).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
        let good = ["frequency", "magnitude", "phase"].map(|text| part(text, None));
        assert_eq!(checked(good.to_vec()), Ok(()));
    }

    #[test]
    fn a_known_unit_is_named_as_it_is_written() {
        for text in ["(m/s2)/N", "m/N", "mm/N", "g/N", "(mm/s2)/N", "um/kN"] {
            let unit: FrfUnit = text.parse().unwrap();
            let named = frf_unit_text(&unit);
            assert_eq!(named.parse::<FrfUnit>(), Ok(unit), "{text} {named}");
        }
        let unit = FrfUnit {
            to_si: 0.3,
            ..("m/N".parse().unwrap())
        };
        assert_eq!(frf_unit_text(&unit), "0.3 x m/N");
    }
}
