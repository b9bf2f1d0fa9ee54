//! Physical quantities, units to SI, and the kind of an FRF. No value here has a default.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Force, N.
    Force,
    /// Displacement, m.
    Displacement,
    /// Velocity, m/s.
    Velocity,
    /// Acceleration, m/s².
    Acceleration,
}

impl Quantity {
    /// The SI unit, as printed.
    pub fn si_unit(self) -> &'static str {
        match self {
            Quantity::Force => "N",
            Quantity::Displacement => "m",
            Quantity::Velocity => "m/s",
            Quantity::Acceleration => "m/s2",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Force => "force",
            Quantity::Displacement => "displacement",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
        })
    }
}

/// A unit text that is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("got unit `{got}`, expected one of {}", unit_names())]
pub struct UnitError {
    /// The text as given.
    pub got: String,
}

/// Text, quantity, factor to SI. 1 lbf = 4.4482216152605 N and g = 9.80665 m/s² are exact by
/// definition.
const UNITS: [(&str, Quantity, f64); 24] = [
    ("N", Quantity::Force, 1.0),
    ("mN", Quantity::Force, 1e-3),
    ("kN", Quantity::Force, 1e3),
    ("lbf", Quantity::Force, 4.448_221_615_260_5),
    ("kip", Quantity::Force, 4_448.221_615_260_5),
    ("m", Quantity::Displacement, 1.0),
    ("mm", Quantity::Displacement, 1e-3),
    ("um", Quantity::Displacement, 1e-6),
    ("µm", Quantity::Displacement, 1e-6),
    ("in", Quantity::Displacement, 0.0254),
    ("m/s", Quantity::Velocity, 1.0),
    ("mm/s", Quantity::Velocity, 1e-3),
    ("in/s", Quantity::Velocity, 0.0254),
    ("m/s2", Quantity::Acceleration, 1.0),
    ("m/s^2", Quantity::Acceleration, 1.0),
    ("m/s²", Quantity::Acceleration, 1.0),
    ("m/s/s", Quantity::Acceleration, 1.0),
    ("mm/s2", Quantity::Acceleration, 1e-3),
    ("mm/s^2", Quantity::Acceleration, 1e-3),
    ("in/s2", Quantity::Acceleration, 0.0254),
    ("in/s^2", Quantity::Acceleration, 0.0254),
    ("g", Quantity::Acceleration, 9.806_65),
    ("gn", Quantity::Acceleration, 9.806_65),
    ("G", Quantity::Acceleration, 9.806_65),
];

fn unit_names() -> String {
    UNITS.iter().map(|row| row.0).collect::<Vec<_>>().join(" ")
}

/// A unit of one of the quantities: its text and its factor to SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The text, as printed.
    pub name: &'static str,
    /// What it measures.
    pub quantity: Quantity,
    /// Value in SI = factor × value in this unit.
    pub to_si: f64,
}

impl Unit {
    /// The first unit of this quantity with exactly this factor to SI.
    ///
    /// ```
    /// use modalign::quantity::{Quantity, Unit};
    /// assert_eq!(Unit::of(Quantity::Force, 1e3).map(|unit| unit.name), Some("kN"));
    /// ```
    pub fn of(quantity: Quantity, to_si: f64) -> Option<Self> {
        let row = UNITS
            .iter()
            .find(|row| row.1 == quantity && row.2.to_bits() == to_si.to_bits());
        row.map(|&(name, quantity, to_si)| Self {
            name,
            quantity,
            to_si,
        })
    }
}

impl FromStr for Unit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        let row = UNITS.iter().find(|row| row.0 == text.trim());
        row.map(|&(name, quantity, to_si)| Unit {
            name,
            quantity,
            to_si,
        })
        .ok_or_else(|| UnitError {
            got: text.to_owned(),
        })
    }
}

/// Response per force: receptance X/F, mobility V/F, accelerance A/F.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrfKind {
    /// Displacement per force, m/N.
    Receptance,
    /// Velocity per force, m/(N s).
    Mobility,
    /// Acceleration per force, m/(N s²).
    Accelerance,
}

impl FrfKind {
    /// How many times the receptance is multiplied by s = iω (+ added damping) to give this kind.
    pub fn derivative_order(self) -> i32 {
        match self {
            FrfKind::Receptance => 0,
            FrfKind::Mobility => 1,
            FrfKind::Accelerance => 2,
        }
    }

    /// The quantity of the response.
    pub fn response_quantity(self) -> Quantity {
        match self {
            FrfKind::Receptance => Quantity::Displacement,
            FrfKind::Mobility => Quantity::Velocity,
            FrfKind::Accelerance => Quantity::Acceleration,
        }
    }

    /// The kind that a response of this quantity per force has; `None` for force per force.
    pub fn from_response(quantity: Quantity) -> Option<Self> {
        match quantity {
            Quantity::Force => None,
            Quantity::Displacement => Some(FrfKind::Receptance),
            Quantity::Velocity => Some(FrfKind::Mobility),
            Quantity::Acceleration => Some(FrfKind::Accelerance),
        }
    }

    /// SI unit, as printed.
    pub fn si_unit(self) -> &'static str {
        match self {
            FrfKind::Receptance => "m/N",
            FrfKind::Mobility => "(m/s)/N",
            FrfKind::Accelerance => "(m/s2)/N",
        }
    }
}

/// Unit of an FRF: a response unit over a force unit, such as `(m/s2)/N`, `m/N` or `(g)/(lbf)`.
///
/// ```
/// use modalign::quantity::{FrfKind, FrfUnit};
/// let unit: FrfUnit = "(g)/kN".parse().unwrap();
/// assert_eq!(unit.kind, FrfKind::Accelerance);
/// assert!((unit.to_si - 9.80665e-3).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrfUnit {
    /// The kind that the response unit gives.
    pub kind: FrfKind,
    /// SI value = factor × value in this unit.
    pub to_si: f64,
}

impl FromStr for FrfUnit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        let error = || UnitError {
            got: text.to_owned(),
        };
        let bare = |part: &str| {
            part.trim()
                .trim_start_matches('(')
                .trim_end_matches(')')
                .parse::<Unit>()
        };
        let (response, force) = text.rsplit_once('/').ok_or_else(error)?;
        let (response, force) = (
            bare(response).map_err(|_| error())?,
            bare(force).map_err(|_| error())?,
        );
        match (FrfKind::from_response(response.quantity), force.quantity) {
            (Some(kind), Quantity::Force) => Ok(Self {
                kind,
                to_si: response.to_si / force.to_si,
            }),
            _ => Err(error()),
        }
    }
}

impl fmt::Display for FrfKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FrfKind::Receptance => "receptance",
            FrfKind::Mobility => "mobility",
            FrfKind::Accelerance => "accelerance",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_convert_by_their_definition() {
        assert!((("g".parse::<Unit>().unwrap().to_si) - 9.80665).abs() < 1e-12);
        assert!(
            ("lbf".parse::<Unit>().unwrap().to_si / ("in".parse::<Unit>().unwrap().to_si)
                - 175.126_835)
                .abs()
                < 1e-6
        );
        assert!(
            "furlong"
                .parse::<Unit>()
                .unwrap_err()
                .to_string()
                .contains("`furlong`")
        );
    }

    #[test]
    fn every_kind_comes_back_from_its_response() {
        for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
            assert_eq!(FrfKind::from_response(kind.response_quantity()), Some(kind));
        }
    }
}
