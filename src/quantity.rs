//! Physical quantities, units to SI, and the kind of an FRF. No value here has a default.

mod other;
mod unit_text;

use std::fmt;
use std::str::FromStr;

pub use other::OtherQuantity;
use serde::{Serialize, Serializer};
use unit_text::measure;

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quantity {
    /// Force, N.
    Force,
    /// Displacement, m.
    Displacement,
    /// Velocity, m/s.
    Velocity,
    /// Acceleration, m/s².
    Acceleration,
    /// Any other, such as sound pressure, strain or a rotation.
    Other(OtherQuantity),
}

impl Quantity {
    /// The SI unit, as printed.
    pub fn si_unit(self) -> &'static str {
        match self {
            Quantity::Force => "N",
            Quantity::Displacement => "m",
            Quantity::Velocity => "m/s",
            Quantity::Acceleration => "m/s2",
            Quantity::Other(other) => other.si_unit(),
        }
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Force => "force",
            Quantity::Displacement => "displacement",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Other(other) => other.name(),
        })
    }
}

/// A unit text that is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("got unit `{got}`, expected {expected}")]
pub struct UnitError {
    /// The text as given.
    pub got: String,
    /// What could stand there.
    pub expected: &'static str,
}

/// Units as they are written: name, quantity, factor to SI. 1 lbf = 4.4482216152605 N and
/// g = 9.80665 m/s² are exact by definition.
const WRITTEN_UNITS: [(&str, Quantity, f64); 16] = [
    ("N", Quantity::Force, 1.0),
    ("mN", Quantity::Force, 1e-3),
    ("kN", Quantity::Force, 1e3),
    ("lbf", Quantity::Force, 4.448_221_615_260_5),
    ("kip", Quantity::Force, 4_448.221_615_260_5),
    ("m", Quantity::Displacement, 1.0),
    ("mm", Quantity::Displacement, 1e-3),
    ("um", Quantity::Displacement, 1e-6),
    ("in", Quantity::Displacement, 0.0254),
    ("m/s", Quantity::Velocity, 1.0),
    ("mm/s", Quantity::Velocity, 1e-3),
    ("in/s", Quantity::Velocity, 0.0254),
    ("m/s2", Quantity::Acceleration, 1.0),
    ("mm/s2", Quantity::Acceleration, 1e-3),
    ("in/s2", Quantity::Acceleration, 0.0254),
    ("g", Quantity::Acceleration, 9.806_65),
];

/// A unit of one of the quantities.
///
/// Read from any usual spelling: `mm/s2`, `mm/s^2`, `mm/s**2`, `mm/s²`, `mm/sec/sec`. `g` is the
/// acceleration of free fall, `lb` a force. In SI, `0.1 m/s2` for a unit without a name.
///
/// ```
/// use modalign::quantity::{Quantity, Unit};
/// let unit: Unit = "in/sec^2".parse().unwrap();
/// assert_eq!(unit, Unit { quantity: Quantity::Acceleration, to_si: 0.0254 });
/// assert_eq!(unit.to_string(), "in/s2");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub quantity: Quantity,
    /// Value in SI = factor × value in this unit.
    pub to_si: f64,
}

impl Unit {
    /// The name under which it is written; `None` for a unit without one.
    ///
    /// ```
    /// use modalign::quantity::{Quantity, Unit};
    /// let unit = Unit { quantity: Quantity::Force, to_si: 1e3 };
    /// assert_eq!(unit.name(), Some("kN"));
    /// ```
    pub fn name(&self) -> Option<&'static str> {
        let is_this = |row: &&(&str, Quantity, f64)| {
            row.1 == self.quantity && row.2.to_bits() == self.to_si.to_bits()
        };
        WRITTEN_UNITS.iter().find(is_this).map(|row| row.0)
    }

    /// The unit of this text, of any quantity.
    ///
    /// ```
    /// use modalign::quantity::Unit;
    /// let unit = Unit::of_any_quantity("mPa").unwrap();
    /// assert_eq!((unit.quantity.to_string().as_str(), unit.to_si), ("pressure", 1e-3));
    /// ```
    ///
    /// # Errors
    /// [`UnitError`] for a text that is not read.
    pub fn of_any_quantity(text: &str) -> Result<Self, UnitError> {
        text.parse().or_else(|error| {
            let measure = measure(text);
            let other = measure.and_then(|measure| OtherQuantity::new(measure.dimension));
            let other = other.zip(measure).map(|(other, measure)| Self {
                quantity: Quantity::Other(other),
                to_si: measure.to_si,
            });
            other.ok_or(UnitError {
                expected: "a unit of force (N kN lbf kgf), displacement (m mm um in), velocity \
                           (m/s mm/s in/s), acceleration (m/s2 mm/s2 in/s2 g) or another quantity \
                           (Pa um/m V rad/s2)",
                ..error
            })
        })
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "{} x {}", self.to_si, self.quantity.si_unit()),
        }
    }
}

impl FromStr for Unit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        let quantities = [
            (Quantity::Force, unit_text::FORCE),
            (Quantity::Displacement, unit_text::DISPLACEMENT),
            (Quantity::Velocity, unit_text::VELOCITY),
            (Quantity::Acceleration, unit_text::ACCELERATION),
        ];
        let unit = measure(text).and_then(|measure| {
            let mut rows = quantities.into_iter();
            let row = rows.find(|row| row.1 == measure.dimension);
            row.map(|(quantity, _)| Unit {
                quantity,
                to_si: measure.to_si,
            })
        });
        unit.ok_or_else(|| UnitError {
            got: text.to_owned(),
            expected: "a unit of force (N kN lbf kgf), displacement (m mm um in), velocity (m/s \
                       mm/s in/s) or acceleration (m/s2 mm/s2 in/s2 g)",
        })
    }
}

/// Factor of a unit of time to s; `None` for any other text.
pub(crate) fn time_factor(text: &str) -> Option<f64> {
    let measure = measure(text).filter(|measure| measure.dimension == unit_text::TIME)?;
    Some(measure.to_si)
}

/// Factor of a unit of frequency to Hz; `None` for any other text.
pub(crate) fn frequency_factor(text: &str) -> Option<f64> {
    let measure = measure(text).filter(|measure| measure.dimension == unit_text::FREQUENCY)?;
    Some(measure.to_si)
}

/// Factor of a unit of rotation, such as `rpm` or `rad/s`, to turns per second; `None` for any
/// other text.
pub(crate) fn rotation_factor(text: &str) -> Option<f64> {
    let measure = measure(text).filter(|measure| measure.dimension == unit_text::ROTATION)?;
    Some(measure.to_si / std::f64::consts::TAU)
}

/// Whether a unit text names another quantity than force, motion and motion over force, as the
/// whole, the numerator or the denominator: sound pressure over force, a rotation, a voltage.
///
/// A text that cannot be read names nothing: its function may be one that is needed.
pub(crate) fn names_other_quantity(text: &str) -> bool {
    if text.parse::<Unit>().is_ok() || text.parse::<FrfUnit>().is_ok() {
        return false;
    }
    let is_other = |part: &str| measure(part).is_some() && part.parse::<Unit>().is_err();
    // The last slash parts response and force: `m/s2/V`, `Pa/EU`.
    let sides = text.rsplit_once('/');
    is_other(text) || sides.is_some_and(|(above, below)| is_other(above) || is_other(below))
}

/// Whether a unit text is a voltage over force, such as `mV/N`: a response without calibration.
pub(crate) fn is_uncalibrated_response(text: &str) -> bool {
    let unit = FrfUnit::of_any_response(text);
    unit.is_ok_and(|unit| match unit.kind {
        FrfKind::Other(response) => response.is_voltage(),
        _ => false,
    })
}

/// Response per force: receptance X/F, mobility V/F, accelerance A/F, or another response.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FrfKind {
    /// Displacement per force, m/N.
    Receptance,
    /// Velocity per force, m/(N s).
    Mobility,
    /// Acceleration per force, m/(N s²).
    Accelerance,
    /// Another response per force, such as sound pressure, Pa/N.
    Other(OtherQuantity),
}

impl FrfKind {
    /// How many times the receptance is multiplied by s = iω (+ added damping) to give this kind.
    pub fn derivative_order(self) -> i32 {
        match self {
            FrfKind::Receptance => 0,
            FrfKind::Mobility => 1,
            FrfKind::Accelerance => 2,
            FrfKind::Other(other) => other.derivative_order(),
        }
    }

    /// Whether the response is a displacement, a velocity or an acceleration.
    pub fn is_motion(self) -> bool {
        !matches!(self, FrfKind::Other(_))
    }

    /// The quantity of the response.
    pub fn response_quantity(self) -> Quantity {
        match self {
            FrfKind::Receptance => Quantity::Displacement,
            FrfKind::Mobility => Quantity::Velocity,
            FrfKind::Accelerance => Quantity::Acceleration,
            FrfKind::Other(other) => Quantity::Other(other),
        }
    }

    /// The kind that a response of this quantity per force has; `None` for force per force.
    pub fn from_response(quantity: Quantity) -> Option<Self> {
        match quantity {
            Quantity::Force => None,
            Quantity::Displacement => Some(FrfKind::Receptance),
            Quantity::Velocity => Some(FrfKind::Mobility),
            Quantity::Acceleration => Some(FrfKind::Accelerance),
            Quantity::Other(other) => Some(FrfKind::Other(other)),
        }
    }

    /// SI unit, as printed.
    pub fn si_unit(self) -> &'static str {
        match self {
            FrfKind::Receptance => "m/N",
            FrfKind::Mobility => "(m/s)/N",
            FrfKind::Accelerance => "(m/s2)/N",
            FrfKind::Other(other) => other.si_unit_per_force(),
        }
    }
}

impl Serialize for FrfKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Unit of an FRF: a response unit over a force unit, such as `(m/s2)/N`, `m/N`, `(g)/(lbf)` or
/// `1/kg`.
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

impl FrfUnit {
    /// The unit of any response per force that this text is.
    ///
    /// ```
    /// use modalign::quantity::FrfUnit;
    /// let unit = FrfUnit::of_any_response("Pa/kN").unwrap();
    /// assert_eq!((unit.kind.to_string().as_str(), unit.to_si), ("pressure over force", 1e-3));
    /// ```
    ///
    /// # Errors
    /// [`UnitError`] for a text that is not read, and a quantity without a name.
    pub fn of_any_response(text: &str) -> Result<Self, UnitError> {
        text.parse().or_else(|error| {
            // A plain `m/s` is no `W/N`.
            let is_over_force = text.rsplit_once('/').is_some_and(|(_, below)| {
                let unit = below.trim().parse::<Unit>();
                unit.is_ok_and(|unit| unit.quantity == Quantity::Force)
            });
            let measure = measure(text).filter(|_| is_over_force);
            let of_force = measure.and_then(|measure| {
                let other = OtherQuantity::per_force(measure.dimension)?;
                Some(Self {
                    kind: FrfKind::Other(other),
                    to_si: measure.to_si,
                })
            });
            of_force.ok_or(error)
        })
    }
}

impl FromStr for FrfUnit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        let kinds = [
            (FrfKind::Receptance, unit_text::RECEPTANCE),
            (FrfKind::Mobility, unit_text::MOBILITY),
            (FrfKind::Accelerance, unit_text::ACCELERANCE),
        ];
        let unit = measure(text).and_then(|measure| {
            let mut kinds = kinds.into_iter();
            let row = kinds.find(|row| row.1 == measure.dimension);
            row.map(|(kind, _)| Self {
                kind,
                to_si: measure.to_si,
            })
        });
        unit.ok_or_else(|| UnitError {
            got: text.to_owned(),
            expected: "a unit of motion over one of force, such as (m/s2)/N, mm/N or g/lbf",
        })
    }
}

impl fmt::Display for FrfKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FrfKind::Receptance => "receptance",
            FrfKind::Mobility => "mobility",
            FrfKind::Accelerance => "accelerance",
            FrfKind::Other(other) => other.name_per_force(),
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
    fn other_quantities_are_named_as_whole_numerator_or_denominator() {
        for text in [
            "Pa",
            "Pa/N",
            "(Pa)/(N)",
            "V/N",
            "N/V",
            "[rad/s^2]/N",
            "(rad/s2)/Nm",
            "rad/s**2/N",
            "m/s2/V",
            "N/m^2",
            "µm/m",
            "Pa/EU",
            "%",
            "dB",
        ] {
            assert!(names_other_quantity(text), "{text}");
        }
        for text in [
            "m/s",
            "(mm/s)",
            "in/s",
            "m/s2",
            "(m/s2)/N",
            "mm/N",
            "g/lbf",
            "m s-2",
            "m.s-2/N",
            "ms-2/N",
            "1/kg",
            "furlong/N",
            "EU/s^2/N",
            "EU/s/N",
            "EU",
            "EU/EU",
            "?",
            "",
        ] {
            assert!(!names_other_quantity(text), "{text}");
        }
    }

    #[test]
    fn a_motion_over_a_force_is_read_in_every_spelling() {
        for (text, kind, to_si) in [
            ("g/lb", FrfKind::Accelerance, 9.80665 / 4.4482216152605),
            ("m/s**2/N", FrfKind::Accelerance, 1.0),
            ("(mm/s²)/kN", FrfKind::Accelerance, 1e-6),
            ("1/kg", FrfKind::Accelerance, 1.0),
            ("mm/s/N", FrfKind::Mobility, 1e-3),
            ("s/kg", FrfKind::Mobility, 1.0),
            ("in/lbf", FrfKind::Receptance, 0.0254 / 4.4482216152605),
            ("um/daN", FrfKind::Receptance, 1e-7),
        ] {
            let unit: FrfUnit = text.parse().unwrap();
            assert_eq!(unit.kind, kind, "{text}");
            assert!((unit.to_si / to_si - 1.0).abs() < 1e-14, "{text}");
        }
        for text in ["Pa/N", "m/s2", "N", "m/s2/V", "N/(m/s2)"] {
            assert!(text.parse::<FrfUnit>().is_err(), "{text}");
        }
    }

    #[test]
    fn units_are_read_back_under_the_name_that_is_written() {
        for (name, quantity, to_si) in WRITTEN_UNITS {
            let unit = Unit { quantity, to_si };
            assert_eq!(name.parse::<Unit>(), Ok(unit));
            assert_eq!(unit.to_string(), name);
        }
    }

    #[test]
    fn every_kind_comes_back_from_its_response() {
        for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
            assert_eq!(FrfKind::from_response(kind.response_quantity()), Some(kind));
        }
    }
}
