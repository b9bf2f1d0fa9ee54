//! Shapes hold the values of all test and theory modes at the common degrees of freedom.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::linalg::{ComplexMatrix, complex_matrix, singular_values};
use crate::modal::{ModalModel, mac_matrix};

use super::model_roots::Root;
use super::subspace::{principal_angles_deg, subspace_mac};
use super::{CorrelateError, DofMap, PairOptions};

/// Minimum singular value of the unit shapes of a root whose directions the sensors separate.
const MIN_SINGULAR_VALUE: f64 = 0.1;

/// Minimum number of common degrees of freedom of a meaningful MAC.
pub(super) const MIN_SHAPE_DOFS: usize = 2;

/// Maximum difference of two values over the largest of the mode that counts as none. Larger, at
/// 1e-3: neighbouring points of a fine mesh move alike. Smaller, at 1e-15: rounding separates
/// sensors at one position. Test `sensors_at_one_position_count_once`.
const MAX_DIFFERENCE_ALIKE: f64 = 1e-9;

/// Minimum number of theory modes from which degrees of freedom are grouped. Larger, at 6: the
/// sensors at one position of a model of few modes count one by one. Smaller, at 2: points that
/// mirror each other count once in a model of two symmetric modes. Test
/// `sensors_at_one_position_count_once`.
const MIN_MODES_OF_GROUPS: usize = 3;

/// Values of every mode at the common degrees of freedom, along the theory's directions, with
/// rotations times the length that [`PairOptions`] states.
pub(super) struct Shapes {
    pub test: Vec<Vec<Option<Complex64>>>,
    pub theory: Vec<Vec<Option<Complex64>>>,
    /// Number of the group of each degree of freedom: those of one group move alike in every
    /// mode of the theory.
    groups: Vec<usize>,
    /// Number of groups, where every mode has a value at each degree of freedom.
    distinct_of_full: Option<usize>,
}

impl Shapes {
    pub fn new(
        test: &ModalModel,
        theory: &ModalModel,
        map: &DofMap,
        options: &PairOptions,
    ) -> Result<Self, CorrelateError> {
        let weights = map.weights(options)?;
        let of_test = test.modes.iter();
        let of_theory = theory.modes.iter();
        let theory = of_theory.map(|m| map.theory_values(&m.shape, &weights));
        let theory = without_rounding(theory.collect());
        let test: Vec<_> = of_test
            .map(|m| map.test_values(&m.shape, &weights))
            .collect();
        let groups = groups_that_move_alike(&theory);
        let mut shapes = Self {
            test,
            theory,
            groups,
            distinct_of_full: None,
        };
        let is_full = shapes.full_dof_count().is_some();
        shapes.distinct_of_full = is_full.then(|| shapes.all_distinct_count());
        Ok(shapes)
    }

    /// These shapes with the test's values multiplied by signs.
    pub fn reversed(&self, signs: &[f64]) -> Self {
        let signed = |shape: &Vec<Option<Complex64>>| {
            let values = shape.iter().zip(signs);
            values
                .map(|(value, sign)| value.map(|v| v * *sign))
                .collect()
        };
        Self {
            test: self.test.iter().map(signed).collect(),
            theory: self.theory.clone(),
            groups: self.groups.clone(),
            distinct_of_full: self.distinct_of_full,
        }
    }

    /// Number of degrees of freedom, each group that moves alike in every mode of the theory once.
    pub fn distinct_count(&self, dofs: impl IntoIterator<Item = usize>) -> usize {
        let groups = dofs.into_iter().filter_map(|dof| self.groups.get(dof));
        groups.collect::<BTreeSet<_>>().len()
    }

    /// [`Self::distinct_count`] of the degrees of freedom at which a test mode and the modes of a
    /// root have values.
    pub fn distinct_common_count(&self, test: usize, theory: &[usize]) -> usize {
        let counted = || self.distinct_count(self.common_dofs(&[test], theory));
        self.distinct_of_full.unwrap_or_else(counted)
    }

    /// Number of all common degrees of freedom that differ.
    pub fn all_distinct_count(&self) -> usize {
        self.distinct_count(0..self.groups.len())
    }

    /// Theory shapes of all modes of some roots.
    pub fn of_roots(&self, roots: &[Root]) -> Vec<Vec<Option<Complex64>>> {
        let modes = roots.iter().flat_map(|root| &root.modes);
        modes.map(|&j| self.theory[j].clone()).collect()
    }

    /// Indices of the degrees of freedom at which all of these modes have a value.
    pub fn common_dofs(&self, test: &[usize], theory: &[usize]) -> Vec<usize> {
        let all = || {
            let test = test.iter().map(|&i| &self.test[i]);
            test.chain(theory.iter().map(|&j| &self.theory[j]))
        };
        let count = all().next().map_or(0, Vec::len);
        (0..count)
            .filter(|&d| all().all(|values| values[d].is_some()))
            .collect()
    }

    /// The test and theory vectors on the degrees of freedom at which all of these modes have a
    /// value.
    pub fn common_values(&self, test: &[usize], theory: &[usize]) -> [Vec<Vec<Complex64>>; 2] {
        let dofs = self.common_dofs(test, theory);
        let vector =
            |values: &Vec<Option<Complex64>>| dofs.iter().filter_map(|&d| values[d]).collect();
        [
            test.iter().map(|&i| vector(&self.test[i])).collect(),
            theory.iter().map(|&j| vector(&self.theory[j])).collect(),
        ]
    }

    /// MAC of a test mode with a root; `None` with too few degrees of freedom in common, and for a
    /// zero vector.
    pub fn mac(&self, test: usize, theory: &[usize]) -> Option<f64> {
        let [vector, span] = self.common_values(&[test], theory);
        let comparable = vector[0].len() >= MIN_SHAPE_DOFS;
        let mac = comparable.then(|| subspace_mac(&vector[0], &span));
        mac.flatten()
    }

    /// Principal angles between test modes and a root; none with too few degrees of freedom for a
    /// MAC.
    pub fn angles_deg(&self, test: &[usize], theory: &[usize]) -> Result<Vec<f64>, CorrelateError> {
        let [test, theory] = self.common_values(test, theory);
        match test[0].len() {
            0..MIN_SHAPE_DOFS => Ok(Vec::new()),
            _ => principal_angles_deg(&test, &theory),
        }
    }

    /// Contribution of test modes to the direction of a root that they represent worst, `cos²` of
    /// the largest principal angle: 0 where they span fewer directions than modes. `None` for one
    /// test mode, where the degrees of freedom do not separate the directions of the root (its unit
    /// shapes have a singular value below [`MIN_SINGULAR_VALUE`]), and where they are no more than
    /// the modes of the root.
    ///
    /// # Errors
    /// [`CorrelateError::Linalg`].
    pub fn weakest_direction(
        &self,
        test: &[usize],
        theory: &[usize],
    ) -> Result<Option<f64>, CorrelateError> {
        if test.len() < 2 {
            return Ok(None);
        }
        let [modes, root] = self.common_values(test, theory);
        let dofs = modes[0].len();
        if dofs <= theory.len() {
            return Ok(None);
        }
        let norm = |shape: &[Complex64]| shape.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let unit = complex_matrix(dofs, theory.len(), |dof, mode| {
            root[mode][dof] / norm(&root[mode]).max(f64::MIN_POSITIVE)
        });
        let values = singular_values(&unit)?;
        if values
            .last()
            .is_none_or(|least| *least < MIN_SINGULAR_VALUE)
        {
            return Ok(None);
        }
        let angles = principal_angles_deg(&modes, &root)?;
        let largest = angles.last().filter(|_| angles.len() == test.len());
        Ok(Some(
            largest.map_or(0.0, |angle| angle.to_radians().cos().powi(2)),
        ))
    }

    /// Number of degrees of freedom at which a test and a theory mode both have values.
    pub fn common_dof_count(&self, test: usize, theory: usize) -> usize {
        let both = self.test[test].iter().zip(&self.theory[theory]);
        both.filter(|(a, b)| a.is_some() && b.is_some()).count()
    }

    /// The number of degrees of freedom where every mode has a value at each of them.
    pub fn full_dof_count(&self) -> Option<usize> {
        let mut all = self.test.iter().chain(&self.theory);
        let count = self.test.first().and(self.theory.first())?.len();
        all.all(|shape| shape.iter().all(Option::is_some))
            .then_some(count)
    }

    /// MAC of every test mode with every theory mode; one product of matrices where all modes have
    /// all values.
    pub fn mac_matrix(&self) -> Vec<Vec<Option<f64>>> {
        if let (Some(test), Some(theory)) = (full_matrix(&self.test), full_matrix(&self.theory)) {
            return mac_matrix(&test, &theory);
        }
        let row = |i| (0..self.theory.len()).map(|j| self.mac(i, &[j])).collect();
        (0..self.test.len()).map(row).collect()
    }
}

/// The group of each degree of freedom whose values in all shapes are equal. One at rest or without
/// a value in a mode is alone, as is every one of few modes, whose values may be equal at points
/// that mirror each other.
fn groups_that_move_alike(shapes: &[Vec<Option<Complex64>>]) -> Vec<usize> {
    let count = shapes.first().map_or(0, Vec::len);
    if shapes.len() < MIN_MODES_OF_GROUPS {
        return (0..count).collect();
    }
    let largest = |shape: &Vec<Option<Complex64>>| {
        let norms = shape.iter().flatten().map(|value| value.norm());
        norms.fold(0.0, f64::max)
    };
    let scales: Vec<f64> = shapes.iter().map(largest).collect();
    let mut groups: BTreeMap<Vec<[i64; 2]>, usize> = BTreeMap::new();
    let group = |dof: usize| {
        let rounded = |(shape, scale): (&Vec<Option<Complex64>>, &f64)| {
            let value = shape[dof]? / scale.max(f64::MIN_POSITIVE);
            Some([value.re, value.im].map(|part| (part / MAX_DIFFERENCE_ALIKE).round() as i64))
        };
        let row: Option<Vec<[i64; 2]>> = shapes.iter().zip(&scales).map(rounded).collect();
        let row = row.filter(|row| row.iter().flatten().any(|part| *part != 0))?;
        Some(*groups.entry(row).or_insert(dof))
    };
    let found: Vec<Option<usize>> = (0..count).map(group).collect();
    let numbered = found.into_iter().enumerate();
    numbered.map(|(dof, group)| group.unwrap_or(dof)).collect()
}

/// Shapes as columns, where all values are there and enough of them for a MAC.
fn full_matrix(shapes: &[Vec<Option<Complex64>>]) -> Option<ComplexMatrix> {
    let points = shapes.first()?.len();
    let full = |shape: &Vec<Option<Complex64>>| shape.iter().all(Option::is_some);
    let value = |p: usize, c: usize| shapes[c][p].unwrap_or_default();
    (points >= MIN_SHAPE_DOFS && shapes.iter().all(full))
        .then(|| complex_matrix(points, shapes.len(), value))
}

/// A theory's values with zeros at the nodes of modes: a value below 1e-10 of the largest of any
/// mode there is rounding, which correlates with every shape.
pub(super) fn without_rounding(
    mut modes: Vec<Vec<Option<Complex64>>>,
) -> Vec<Vec<Option<Complex64>>> {
    /// An eigenvector is known to about 1e-14 of its largest component.
    const ROUNDING: f64 = 1e-10;
    let count = modes.first().map_or(0, Vec::len);
    for d in 0..count {
        let values = modes.iter().filter_map(|values| values[d]);
        let limit = ROUNDING * values.map(Complex64::norm).fold(0.0, f64::max);
        for value in modes.iter_mut().filter_map(|values| values[d].as_mut()) {
            if value.norm() < limit {
                *value = Complex64::ZERO;
            }
        }
    }
    modes
}

#[cfg(test)]
mod tests {
    use super::super::pairing_tests::{mode, model, paired};
    use super::super::{Basis, Pairing};
    use super::*;

    /// Modes of a beam with sensors at these positions, from 0 to 1.
    fn beam(at: &[f64], modes: u32) -> ModalModel {
        let wave = |number: u32| {
            let values = at
                .iter()
                .map(move |x| (f64::from(number) * 2.1 * x + 0.3).sin());
            mode(100.0 * f64::from(number), &values.collect::<Vec<_>>())
        };
        model((1..=modes).map(wave).collect())
    }

    fn bases(pairing: &Pairing) -> Vec<Basis> {
        let partners = pairing.pairs.iter().flat_map(|pair| &pair.partners);
        partners.map(|partner| partner.basis).collect()
    }

    #[test]
    fn sensors_at_one_position_count_once() {
        let count = |at: &[f64], modes: u32| {
            let theory = beam(at, modes);
            let map = DofMap::of_models(&theory, &theory);
            let options = PairOptions::default();
            let shapes = Shapes::new(&theory, &theory, &map, &options).unwrap();
            shapes.all_distinct_count()
        };
        let spread = [0.0, 0.2, 0.4, 0.7, 1.0];
        assert_eq!(count(&spread, 3), 5);
        assert_eq!(count(&[0.2, 0.2, 0.2 + 1e-12, 0.7, 0.7], 3), 2);
        // A fine mesh, and two modes alone.
        assert_eq!(count(&[0.2, 0.2001, 0.2002], 3), 3);
        assert_eq!(count(&[0.2, 0.2, 0.7], 2), 3);
        let pairing = |at: &[f64]| paired(&beam(at, 3), &beam(at, 3));
        assert_eq!(bases(&pairing(&spread)), [Basis::Shape; 3]);
        let two = pairing(&[0.2, 0.2, 0.2, 0.7, 0.7]);
        assert_eq!(bases(&two), [Basis::Frequency; 3]);
        let few = two
            .findings
            .iter()
            .find(|finding| finding.limit == Some(4.0));
        assert_eq!(few.and_then(|finding| finding.value), Some(2.0));
    }
}
