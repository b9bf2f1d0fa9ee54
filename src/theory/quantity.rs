//! Named quantities that the theory of a model gives in addition to its matrices.

use super::TheoryError;

/// A number with its name, unit and formula.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelQuantity {
    /// Name, unique in its model, by which a claim of a publication asks for it.
    pub name: &'static str,
    /// The value; `None` where it does not exist for these parameters, such as a crossing of roots
    /// that do not cross.
    pub value: Option<f64>,
    /// Unit; empty for a pure number.
    pub unit: &'static str,
    /// Description, with formula or source.
    pub meaning: String,
}

impl ModelQuantity {
    /// A quantity; a value that is not finite is one that does not exist.
    pub fn new(name: &'static str, value: f64, unit: &'static str, meaning: &str) -> Self {
        Self {
            name,
            value: value.is_finite().then_some(value),
            unit,
            meaning: meaning.to_owned(),
        }
    }
}

/// A result, or `none` where it needs values of parameters that the model does not allow.
pub(super) fn allowed_or<T>(none: T, result: Result<T, TheoryError>) -> Result<T, TheoryError> {
    match result {
        Err(TheoryError::OutOfBounds { .. } | TheoryError::SweepRange { .. }) => Ok(none),
        other => other,
    }
}

/// The largest; not a number where one of them is none.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    values.into_iter().fold(0.0, larger)
}
