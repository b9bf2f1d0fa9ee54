//! Expansion computes the motion of all coordinates of a model from a shape at a few sensors.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::{ModalModel, ModeShape};

use super::measures::ReducedMass;
use super::{CorrelateError, DofMap};

/// A test's shapes at all coordinates of a model: `x = T y`, with `y` the readings along the
/// theory's directions and `T` the expansion of the reduction (statically, or as a sum of the modes
/// that it keeps).
///
/// `coordinates` name the rows of `T`. Modes without a value at one of the sensors are left out, as
/// are standard deviations of shapes and residues, which belong to the sensors.
///
/// # Errors
/// [`CorrelateError::NotACoordinate`] for a sensor that the map does not have;
/// [`CorrelateError::CoordinateNames`] for another number of names than rows.
///
/// # Reference
/// Guyan (1965); O'Callahan, Avitabile and Riemer (1989), System equivalent reduction expansion
/// process (SEREP), IMAC 7, 29.
pub fn expand_shapes(
    test: &ModalModel,
    map: &DofMap,
    reduced: &ReducedMass,
    coordinates: &[Dof],
) -> Result<ModalModel, CorrelateError> {
    let expansion = &reduced.expansion;
    if coordinates.len() != expansion.nrows() {
        return Err(CorrelateError::CoordinateNames {
            got: coordinates.len(),
            expected: expansion.nrows(),
        });
    }
    let pair = |dof: &Dof| {
        let mut pairs = map.pairs.iter();
        let found = pairs.find(|pair| pair.theory == *dof);
        found.ok_or_else(|| CorrelateError::NotACoordinate { dof: dof.clone() })
    };
    let pairs: Vec<_> = reduced.dofs.iter().map(pair).collect::<Result<_, _>>()?;
    let motion = |shape: &ModeShape| -> Option<ModeShape> {
        let readings = pairs.iter();
        let readings: Option<Vec<Complex64>> = readings
            .map(|pair| shape.get(&pair.test).map(|v| v * pair.sign))
            .collect();
        let readings = readings?;
        let value = |i: usize| -> Complex64 {
            let terms = readings.iter().enumerate();
            terms.map(|(a, y)| y * expansion[(i, a)]).sum()
        };
        let values = coordinates.iter().enumerate();
        Some(ModeShape::new(
            values.map(|(i, dof)| (dof.clone(), value(i))),
        ))
    };
    let mut model = test.clone();
    model.modes.retain_mut(|mode| match motion(&mode.shape) {
        Some(shape) => {
            mode.shape = shape;
            (mode.shape_std, mode.residues) = (None, Default::default());
            true
        }
        None => false,
    });
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::measures::Reduction;
    use crate::linalg::real_matrix;
    use crate::modal::{Mode, Scaling};

    fn dof(text: &str) -> Dof {
        text.parse().unwrap()
    }

    #[test]
    fn readings_become_motions_of_all_coordinates() {
        let shape = |values: &[(&str, f64)]| {
            ModeShape::new(
                values
                    .iter()
                    .map(|(d, v)| (dof(d), Complex64::new(0.0, *v))),
            )
        };
        let mode = |hz, values| Mode::new(hz, Some(0.01), shape(values), Scaling::Unknown);
        let test = ModalModel {
            modes: vec![
                mode(10.0, &[("1:-X", 2.0), ("2:+X", 3.0)]),
                mode(20.0, &[("1:-X", 1.0)]),
            ],
            ..ModalModel::default()
        };
        let theory = [dof("1:+X"), dof("2:+X")];
        let of_test = [dof("1:-X"), dof("2:+X")];
        let map = DofMap::new(of_test.iter(), theory.iter());
        // Two coordinates read as they are, and one halfway between them.
        let rows = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];
        let reduced = ReducedMass {
            reduction: Reduction::Guyan,
            dofs: theory.to_vec(),
            mass: real_matrix(2, 2, |_, _| 0.0),
            expansion: real_matrix(3, 2, |i, j| rows[i][j]),
            modes: None,
        };
        let names = ["a:+X", "b:+X", "c:+X"].map(dof);
        let model = expand_shapes(&test, &map, &reduced, &names).unwrap();
        assert_eq!(model.modes.len(), 1);
        assert_eq!(model.modes[0].damping_ratio, Some(0.01));
        let values: Vec<f64> = model.modes[0].shape.iter().map(|(_, v)| v.im).collect();
        assert_eq!(values, [-2.0, 0.5, 3.0]);
        let error = expand_shapes(&test, &map, &reduced, &names[..2]).unwrap_err();
        assert_eq!(
            error,
            CorrelateError::CoordinateNames {
                got: 2,
                expected: 3
            }
        );
    }
}
