//! A number that a part of a model needs, and which values it may have.

use super::description::Value;
use super::dual::{Dual, Values};
use super::{ParameterSpec, TheoryError};

/// Admissible sign of a property.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Sign {
    Positive,
    NotNegative,
}

/// A property of a part, as the model file states it.
pub(super) struct Property<'a> {
    pub part: &'a str,
    pub name: &'static str,
    pub value: &'a Value,
    pub sign: Sign,
}

impl Property<'_> {
    /// The number itself for these values of the parameters.
    ///
    /// # Errors
    /// [`TheoryError::UnknownParameter`]; [`TheoryError::PropertyOutOfRange`].
    pub fn resolve(&self, specs: &[ParameterSpec], values: &[f64]) -> Result<f64, TheoryError> {
        let got = self.value.resolve(self.part, specs, values)?;
        self.check_unit(specs)?;
        let expected = match self.sign {
            Sign::Positive => "a finite number above 0",
            Sign::NotNegative => "a finite number of 0 or more",
        };
        let zero_allowed = self.sign == Sign::NotNegative;
        if got.is_finite() && (got > 0.0 || zero_allowed && got >= 0.0) {
            return Ok(got);
        }
        Err(TheoryError::PropertyOutOfRange {
            part: self.part.to_owned(),
            property: self.name,
            got,
            expected,
        })
    }

    /// The number with its derivative by the parameter of `values`.
    ///
    /// # Errors
    /// As [`resolve`](Property::resolve).
    pub fn dual(&self, values: &Values<'_>) -> Result<Dual, TheoryError> {
        let value = self.resolve(values.specs, values.values)?;
        let slope = match self.value {
            Value::Parameter(name) => values.get(name).slope,
            Value::Number(_) => 0.0,
        };
        Ok(Dual { value, slope })
    }

    /// A parameter is in the unit of the property that it stands for: nothing is converted, and
    /// nothing guessed.
    fn check_unit(&self, specs: &[ParameterSpec]) -> Result<(), TheoryError> {
        let Value::Parameter(name) = self.value else {
            return Ok(());
        };
        let spec = specs.iter().find(|spec| spec.name == *name);
        let unit = UNITS.iter().find(|(property, _)| *property == self.name);
        match (spec, unit) {
            (Some(spec), Some((_, unit))) if plain(&spec.unit) != plain(unit) => {
                Err(TheoryError::ParameterUnit {
                    part: self.part.to_owned(),
                    parameter: name.clone(),
                    property: self.name,
                    got: spec.unit.clone(),
                    expected: unit,
                })
            }
            _ => Ok(()),
        }
    }
}

/// Unit of every property that a parameter may stand for.
const UNITS: [(&str, &str); 9] = [
    ("youngs_modulus_pa", "Pa"),
    ("density_kg_per_m3", "kg/m3"),
    ("area_m2", "m2"),
    ("second_moment_m4", "m4"),
    ("mass_kg", "kg"),
    ("inertia_kg_m2", "kg m2"),
    ("rotary_inertia_kg_m2", "kg m2"),
    ("stiffness_n_per_m", "N/m"),
    ("stiffness_nm_per_rad", "N m/rad"),
];

/// A unit without the signs in which people write it differently: `kg·m²`, `kg m^2`, `kg*m2`.
fn plain(unit: &str) -> String {
    let powers = unit.replace('²', "2").replace('³', "3").replace('⁴', "4");
    powers
        .chars()
        .filter(|c| !matches!(c, ' ' | '·' | '*' | '^' | '.'))
        .collect()
}
