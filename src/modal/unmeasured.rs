//! Degrees of freedom that are 0 in every mode of a set: directions that no sensor measured.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use super::ModalModel;
use crate::dof::{Axis, Dof};

/// Minimum number of modes in which a degree of freedom is 0 that was not measured, where others
/// of its axis were. With 1, a node of the only mode of a set is left out
/// (`one_mode_shows_an_unmeasured_direction_and_no_unmeasured_node`); with 3, unmeasured nodes of
/// a set of two modes are kept (`two_modes_show_an_unmeasured_node`).
const MIN_ZERO_MODES: usize = 2;

impl ModalModel {
    /// Degrees of freedom that are exactly 0 in every mode that has a value there.
    ///
    /// Noise and the rounding of an estimate leave no measured value at exactly 0 in several
    /// modes; exporting programs fill what was not measured with zeros. In a set of one mode, 0 may
    /// be a node of the mode, so that only an axis that is 0 at all points counts. The zeros of a
    /// computed mode (`method` is `theory`) are values, and so are all of its set.
    pub fn unmeasured_dofs(&self) -> BTreeSet<Dof> {
        let is_computed = |method: &Option<String>| method.as_deref() == Some("theory");
        if self.modes.iter().any(|mode| is_computed(&mode.method)) {
            return BTreeSet::new();
        }
        let moves = |value: Complex64| value != Complex64::ZERO;
        let mut zero_modes: BTreeMap<&Dof, usize> = BTreeMap::new();
        let mut moving: BTreeSet<&Dof> = BTreeSet::new();
        for mode in &self.modes {
            let has_shape = mode.shape.iter().any(|(_, value)| moves(value));
            for (dof, value) in mode.shape.iter() {
                if moves(value) {
                    moving.insert(dof);
                } else {
                    *zero_modes.entry(dof).or_default() += usize::from(has_shape);
                }
            }
        }
        let axes: BTreeSet<Axis> = moving.iter().map(|dof| dof.axis()).collect();
        let unmeasured = zero_modes.into_iter().filter(|(dof, modes)| {
            let is_axis_measured = axes.contains(&dof.axis());
            !moving.contains(dof) && (*modes >= MIN_ZERO_MODES || !is_axis_measured)
        });
        unmeasured.map(|(dof, _)| dof.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::{Mode, ModeShape, Scaling};

    fn model(shapes: &[&[(&str, f64)]]) -> ModalModel {
        let mode = |shape: &&[(&str, f64)]| {
            let values = shape.iter().map(|(dof, value)| {
                let dof: Dof = dof.parse().expect("the degrees of freedom of these tests");
                (dof, Complex64::new(*value, 0.0))
            });
            Mode::new(10.0, None, ModeShape::new(values), Scaling::Unknown)
        };
        ModalModel {
            modes: shapes.iter().map(mode).collect(),
            ..ModalModel::default()
        }
    }

    fn names(model: &ModalModel) -> Vec<String> {
        let dofs = model.unmeasured_dofs();
        dofs.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn two_modes_show_an_unmeasured_node() {
        let first: &[_] = &[("1:+Z", 1.0), ("2:+Z", 0.0), ("3:+Z", 0.0)];
        let second: &[_] = &[("1:+Z", 1.0), ("2:+Z", -0.0), ("3:+Z", 2.0)];
        assert_eq!(names(&model(&[first, second])), ["2:+Z"]);
        // A mode without any value shows nothing.
        let none: &[_] = &[("1:+Z", 0.0), ("2:+Z", 0.0)];
        assert!(names(&model(&[first, none])).is_empty());
    }

    #[test]
    fn one_mode_shows_an_unmeasured_axis_alone() {
        let one: &[_] = &[("1:+Z", 1.0), ("2:+Z", 0.0), ("1:+X", 0.0), ("2:-X", 0.0)];
        assert_eq!(names(&model(&[one])), ["1:+X", "2:-X"]);
    }

    #[test]
    fn a_value_that_is_no_number_and_a_computed_mode_are_no_zeros() {
        let bad: &[_] = &[("1:+Z", f64::NAN), ("2:+Z", 1.0)];
        assert!(names(&model(&[bad, bad])).is_empty());
        let zero: &[_] = &[("1:+Z", 1.0), ("1:+X", 0.0)];
        let mut computed = model(&[zero, zero]);
        assert_eq!(names(&computed), ["1:+X"]);
        computed.modes[0].method = Some("theory".to_owned());
        assert!(names(&computed).is_empty());
    }
}
