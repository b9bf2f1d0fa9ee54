//! Paired shapes are scaled and rotated to a common amplitude and phase, for comparison point by
//! point.

use num_complex::Complex64;

use super::super::Pairing;
use super::super::shapes::Shapes;
use super::super::subspace::projection;

/// Values of one test mode and of its partner at every common degree of freedom; `None` where one
/// has none.
///
/// The partner is the projection of the test mode on the root's subspace (for a simple root the
/// theory's shape itself), so that a repeated root has one as well. Both have unit length, and
/// their inner product is real and positive.
pub(in super::super) struct PairShapes {
    pub values: Vec<Option<(Complex64, Complex64)>>,
}

impl PairShapes {
    /// Of every partner that has a MAC.
    pub fn of_pairing(shapes: &Shapes, pairing: &Pairing) -> Vec<Self> {
        let partners = pairing.pairs.iter().flat_map(|pair| {
            let with_shape = pair.partners.iter().filter(|partner| partner.mac.is_some());
            with_shape.map(|partner| (partner.test, pair.theory.as_slice()))
        });
        partners
            .filter_map(|(test, theory)| Self::new(shapes, test, theory))
            .collect()
    }

    fn new(shapes: &Shapes, test: usize, theory: &[usize]) -> Option<Self> {
        let [vector, span] = shapes.common_values(&[test], theory);
        let shape = unit(&vector[0])?;
        let partner = unit(&projection(&shape, &span))?;
        let mut both = shape.into_iter().zip(partner);
        let present = |d: usize| {
            let theory_too = theory.iter().all(|&j| shapes.theory[j][d].is_some());
            shapes.test[test][d].is_some() && theory_too
        };
        let count = shapes.test[test].len();
        let next = |d: usize| if present(d) { both.next() } else { None };
        Some(Self {
            values: (0..count).map(next).collect(),
        })
    }
}

fn unit(values: &[Complex64]) -> Option<Vec<Complex64>> {
    let length = values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    (length > 0.0).then(|| values.iter().map(|v| v / length).collect())
}
