//! Parameters of a model: definition, source of the value, and vectors of values over a list of
//! them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::TheoryError;
use super::faults::Faults;
use super::nearest_name::nearest_name;

/// Source of a parameter's nominal value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ParameterStatus {
    /// Printed in a publication, a drawing or a data sheet, or measured.
    Printed,
    /// Follows from printed values.
    Inferred,
    /// Neither: a guess.
    Assumed,
}

/// A parameter of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterSpec {
    /// Name, unique in its model.
    pub name: String,
    /// Unit of all its values, as printed.
    pub unit: String,
    /// The value to start from.
    pub nominal: f64,
    /// Smallest value allowed.
    #[serde(default)]
    pub lower: Option<f64>,
    /// Largest value allowed.
    #[serde(default)]
    pub upper: Option<f64>,
    /// Source of the nominal value.
    pub status: ParameterStatus,
    /// A number of parts: whole values alone, no derivative by it. The parameters of a model file
    /// are none.
    #[serde(skip)]
    pub whole: bool,
}

impl ParameterSpec {
    /// A fraction from 0, its nominal value, to 1.
    pub(super) fn fraction(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            unit: "1".to_owned(),
            nominal: 0.0,
            lower: Some(0.0),
            upper: Some(1.0),
            status: ParameterStatus::Printed,
            whole: false,
        }
    }

    fn check(&self, value: f64) -> Result<(), TheoryError> {
        if let (Some(lower), Some(upper)) = (self.lower, self.upper)
            && lower > upper
        {
            return Err(TheoryError::ReversedBounds {
                name: self.name.clone(),
                lower,
                upper,
                unit: self.unit.clone(),
            });
        }
        let above = self.lower.is_none_or(|lower| value >= lower);
        let below = self.upper.is_none_or(|upper| value <= upper);
        if value.is_finite() && above && below {
            return self.check_whole(value);
        }
        Err(TheoryError::OutOfBounds {
            name: self.name.clone(),
            got: value,
            lower: self.lower,
            upper: self.upper,
            unit: self.unit.clone(),
        })
    }

    fn check_whole(&self, value: f64) -> Result<(), TheoryError> {
        if !self.whole || value.fract() == 0.0 {
            return Ok(());
        }
        Err(TheoryError::NotWhole {
            name: self.name.clone(),
            got: value,
        })
    }
}

/// Checks that a parameter has a derivative.
pub(super) fn check_derivable(spec: &ParameterSpec) -> Result<(), TheoryError> {
    if !spec.whole {
        return Ok(());
    }
    Err(TheoryError::NoDerivative {
        name: spec.name.clone(),
    })
}

/// The nominal values, in order.
pub fn nominal_values(specs: &[ParameterSpec]) -> Vec<f64> {
    specs.iter().map(|spec| spec.nominal).collect()
}

/// Checks a vector of values against the specifications: one finite value for each, inside its
/// bounds (edges included), whole where it is a number of parts.
///
/// # Errors
/// [`TheoryError::ValueCount`]; [`TheoryError::ReversedBounds`]; [`TheoryError::OutOfBounds`];
/// [`TheoryError::NotWhole`].
pub fn check_values(
    model: &str,
    specs: &[ParameterSpec],
    values: &[f64],
) -> Result<(), TheoryError> {
    if specs.len() != values.len() {
        return Err(TheoryError::ValueCount {
            model: model.to_owned(),
            got: values.len(),
            expected: specs.len(),
        });
    }
    let mut faults = Faults::default();
    for (spec, &value) in specs.iter().zip(values) {
        faults.take(spec.check(value));
    }
    faults.into_result()
}

/// The nominal values with some replaced by name, in the order of the specifications.
///
/// ```
/// use modalign::theory::{ParameterSpec, ParameterStatus, override_values};
/// let spec = |name: &str, nominal| ParameterSpec {
///     name: name.into(), unit: "N/m".into(), nominal, lower: Some(0.0), upper: None,
///     status: ParameterStatus::Assumed, whole: false,
/// };
/// let specs = [spec("mesh", 1.0), spec("bearing", 2.0)];
/// let values = override_values("gear", &specs, &[("bearing".to_owned(), 5.0)].into()).unwrap();
/// assert_eq!(values, [1.0, 5.0]);
/// assert!(override_values("gear", &specs, &[("baering".to_owned(), 5.0)].into()).is_err());
/// ```
///
/// # Errors
/// [`TheoryError::UnknownParameter`] for a name that is not declared; as [`check_values`].
pub fn override_values(
    model: &str,
    specs: &[ParameterSpec],
    overrides: &BTreeMap<String, f64>,
) -> Result<Vec<f64>, TheoryError> {
    let mut values = nominal_values(specs);
    let mut faults = Faults::default();
    for (name, &value) in overrides {
        if let Some(index) = faults.take(index_of(model, specs, name)) {
            values[index] = value;
        }
    }
    faults.take(check_values(model, specs, &values));
    faults.into_result().map(|()| values)
}

/// The place of a parameter in the list.
pub(super) fn index_of(
    used_by: &str,
    specs: &[ParameterSpec],
    name: &str,
) -> Result<usize, TheoryError> {
    specs
        .iter()
        .position(|spec| spec.name == name)
        .ok_or_else(|| TheoryError::UnknownParameter {
            got: name.to_owned(),
            used_by: used_by.to_owned(),
            nearest: nearest_name(name, specs.iter().map(|spec| spec.name.as_str())),
            known: specs.iter().map(|spec| spec.name.clone()).collect(),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn specs() -> Vec<ParameterSpec> {
        let spec = |name: &str, nominal| ParameterSpec {
            name: name.to_owned(),
            unit: "Pa".to_owned(),
            nominal,
            lower: Some(1.0),
            upper: Some(4.0),
            status: ParameterStatus::Printed,
            whole: false,
        };
        vec![spec("a", 1.0), spec("b", 4.0)]
    }

    #[test]
    fn values_are_checked_in_count_bounds_and_finiteness() {
        assert_eq!(
            check_values("m", &specs(), &nominal_values(&specs())),
            Ok(())
        );
        assert!(matches!(
            check_values("m", &specs(), &[2.0]),
            Err(TheoryError::ValueCount {
                got: 1,
                expected: 2,
                ..
            })
        ));
        for bad in [0.999, 4.001, f64::NAN, f64::INFINITY] {
            let error = check_values("m", &specs(), &[2.0, bad]);
            assert!(matches!(error, Err(TheoryError::OutOfBounds { name, .. }) if name == "b"));
        }
    }

    #[test]
    fn overriding_replaces_the_named_value_alone_and_checks_it() {
        let named = |name: &str, value| BTreeMap::from([(name.to_owned(), value)]);
        assert_eq!(
            override_values("m", &specs(), &named("b", 3.0)),
            Ok(vec![1.0, 3.0])
        );
        assert!(override_values("m", &specs(), &named("b", 5.0)).is_err());
        assert!(matches!(
            override_values("m", &specs(), &named("c", 3.0)),
            Err(TheoryError::UnknownParameter { known, .. }) if known == ["a", "b"]
        ));
    }

    #[test]
    fn the_status_is_written_in_lower_case() {
        let text = serde_json::to_string(&specs()[0]).unwrap();
        assert!(text.contains("\"status\":\"printed\""), "{text}");
        assert_eq!(
            serde_json::from_str::<ParameterSpec>(&text).unwrap(),
            specs()[0]
        );
    }
}
