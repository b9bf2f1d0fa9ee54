//! A mode shape: one complex value per degree of freedom.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::dof::Dof;

/// Values of a mode at degrees of freedom, ordered by degree of freedom.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ModeShape {
    values: BTreeMap<Dof, Complex64>,
}

impl ModeShape {
    /// A shape from pairs; the last value of a repeated degree of freedom stays.
    pub fn new(values: impl IntoIterator<Item = (Dof, Complex64)>) -> Self {
        Self {
            values: values.into_iter().collect(),
        }
    }

    /// The value at exactly this degree of freedom (sign included).
    pub fn get(&self, dof: &Dof) -> Option<Complex64> {
        self.values.get(dof).copied()
    }

    /// The value along the positive axis of this degree of freedom, whichever way the sensor there
    /// points.
    pub fn along_positive(&self, dof: &Dof) -> Option<Complex64> {
        let positive = dof.positive();
        self.get(&positive)
            .or_else(|| self.get(&positive.opposite()).map(|value| -value))
    }

    /// Degrees of freedom and values in order.
    pub fn iter(&self) -> impl Iterator<Item = (&Dof, Complex64)> {
        self.values.iter().map(|(dof, value)| (dof, *value))
    }

    /// Number of degrees of freedom.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether the shape has no degree of freedom.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The component of largest magnitude (the first of equals).
    pub fn largest(&self) -> Option<(&Dof, Complex64)> {
        let mut best: Option<(&Dof, Complex64)> = None;
        for (dof, value) in self.iter() {
            if best.is_none_or(|(_, largest)| value.norm() > largest.norm()) {
                best = Some((dof, value));
            }
        }
        best
    }

    /// The shape multiplied by a complex factor.
    pub fn scaled(&self, factor: Complex64) -> Self {
        Self {
            values: self
                .values
                .iter()
                .map(|(dof, value)| (dof.clone(), value * factor))
                .collect(),
        }
    }

    /// The shape turned and scaled so that its largest component is 1; unchanged when it is zero.
    pub fn unit_max(&self) -> Self {
        match self.largest() {
            Some((_, value)) if value.norm() > 0.0 => self.scaled(value.inv()),
            _ => self.clone(),
        }
    }
}
