//! Quantities of responses that are no translation: sound pressure, strain, rotation, voltage.

use super::unit_text::{
    ANGLE, CHARGE, CURRENT, Dimension, ENERGY, FORCE, NONE, POWER, PRESSURE, ROTATION, TEMPERATURE,
    VOLTAGE,
};

/// A quantity that is neither a force nor a translation, with the shape of its responses apart from
/// that of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OtherQuantity(&'static Row);

/// A quantity with its names.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Row {
    dimension: Dimension,
    name: &'static str,
    name_per_force: &'static str,
    si_unit: &'static str,
    si_unit_per_force: &'static str,
    /// How many times it is differentiated with respect to time; the sound pressure that a
    /// structure radiates is in proportion to its acceleration.
    derivative_order: i32,
    /// Name of the group of a shape that its responses are in, with the unit of their values for a
    /// shape in m.
    group: &'static str,
}

const ANGULAR_ACCELERATION: Dimension = [0, 0, -2, 1, 0, 0, 0];

macro_rules! row {
    ($dimension:expr, $name:literal, $unit:literal, $order:literal, $group:literal) => {
        Row {
            dimension: $dimension,
            name: $name,
            name_per_force: concat!($name, " over force"),
            si_unit: $unit,
            si_unit_per_force: concat!("(", $unit, ")/N"),
            derivative_order: $order,
            group: $group,
        }
    };
}

/// Every such quantity.
static ROWS: [Row; 11] = [
    row!(PRESSURE, "pressure", "Pa", 2, "Pa s2"),
    row!(NONE, "strain", "m/m", 0, "m/m"),
    row!(VOLTAGE, "voltage", "V", 0, "V"),
    row!(CURRENT, "current", "A", 0, "A"),
    row!(CHARGE, "charge", "C", 0, "C"),
    row!(ENERGY, "moment", "Nm", 0, "Nm"),
    row!(POWER, "power", "W", 0, "W"),
    row!(TEMPERATURE, "temperature", "K", 0, "K"),
    row!(ANGLE, "rotation", "rad", 0, "rad"),
    row!(ROTATION, "angular velocity", "rad/s", 1, "rad"),
    row!(
        ANGULAR_ACCELERATION,
        "angular acceleration",
        "rad/s2",
        2,
        "rad"
    ),
];

impl OtherQuantity {
    /// The quantity of this dimension.
    pub(super) fn new(dimension: Dimension) -> Option<Self> {
        let row = ROWS.iter().find(|row| row.dimension == dimension)?;
        Some(Self(row))
    }

    /// The quantity that has this dimension over a force.
    pub(super) fn per_force(dimension: Dimension) -> Option<Self> {
        let mut response = dimension;
        response
            .iter_mut()
            .zip(FORCE)
            .for_each(|(power, of_force)| *power += of_force);
        Self::new(response)
    }

    /// The quantity of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        ROWS.iter().find(|row| row.name == name).map(Self)
    }

    /// Whether it is the voltage of a response without calibration.
    pub(super) fn is_voltage(self) -> bool {
        self.0.dimension == VOLTAGE
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// Name of its response function to a force.
    pub fn name_per_force(self) -> &'static str {
        self.0.name_per_force
    }

    /// Its SI unit.
    pub fn si_unit(self) -> &'static str {
        self.0.si_unit
    }

    /// SI unit of its response function to a force.
    pub fn si_unit_per_force(self) -> &'static str {
        self.0.si_unit_per_force
    }

    /// How many times it is differentiated with respect to time.
    pub fn derivative_order(self) -> i32 {
        self.0.derivative_order
    }

    /// The group of a shape that its responses are in: responses of one group have one unit.
    pub fn group(self) -> &'static str {
        self.0.group
    }
}

#[cfg(test)]
mod tests {
    use crate::quantity::{FrfUnit, Unit};

    #[test]
    fn names_and_units_of_every_quantity_are_read_back() {
        for row in &super::ROWS {
            let unit = Unit::of_any_quantity(row.si_unit).unwrap();
            assert_eq!(
                (unit.quantity.to_string().as_str(), unit.to_si),
                (row.name, 1.0)
            );
            let unit = FrfUnit::of_any_response(row.si_unit_per_force).unwrap();
            assert_eq!(
                (unit.kind.to_string().as_str(), unit.to_si),
                (row.name_per_force, 1.0)
            );
        }
        for text in ["Pa", "m", "m/s", "N", "Nm", "W", "1/kg/m", "dB/N"] {
            assert!(FrfUnit::of_any_response(text).is_err(), "{text}");
        }
        assert!(Unit::of_any_quantity("dB").is_err());
    }
}
