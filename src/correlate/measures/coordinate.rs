//! COMAC correlates one degree of freedom over all pairs, which locates disagreement.

use serde::Serialize;

use crate::dof::Dof;

use super::super::DofMap;
use super::pair_shapes::PairShapes;

/// Minimum number of pairs for COMAC: over one, it is 1 for any shapes.
const MIN_PAIRS_OF_COMAC: usize = 2;

/// Correlation of one degree of freedom `q` over the pairs `r`, whose test shape `φ` and theory
/// shape `ψ` have unit length over the common degrees of freedom and one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoordinateMac {
    /// As the test names it.
    pub dof: Dof,
    /// `(Σ_r |φ_qr ψ_qr|)² / (Σ_r |φ_qr|² Σ_r |ψ_qr|²)`, 0 to 1 (Lieven and Ewins 1988); it does
    /// not depend on the sign. `None` with fewer than two pairs, or where one side has nodes in all
    /// of them.
    pub comac: Option<f64>,
    /// `Σ_r |φ_qr − ψ_qr| / 2N`, 0 to 1, 0 for equal shapes (Hunt 1992); it depends on the sign.
    /// `None` with fewer than two pairs.
    pub enhanced: Option<f64>,
    /// `Σ_r Re(ψ_qr* φ_qr) / sqrt(Σ_r |φ_qr|² Σ_r |ψ_qr|²)`, -1 to 1: near -1 the sensor points the
    /// other way. `None` as for `comac`.
    pub direction: Option<f64>,
    /// Pairs `N` that have a value here on both sides.
    pub pairs: usize,
}

/// Correlation of every degree of freedom of the map, in its order.
pub(super) fn coordinates(map: &DofMap, pairs: &[PairShapes]) -> Vec<CoordinateMac> {
    let dofs = map.pairs.iter().enumerate();
    dofs.map(|(q, dof)| coordinate(q, dof.test.clone(), pairs))
        .collect()
}

fn coordinate(q: usize, dof: Dof, pairs: &[PairShapes]) -> CoordinateMac {
    let values: Vec<_> = pairs.iter().filter_map(|pair| pair.values[q]).collect();
    let sum = |of: fn(&(_, _)) -> f64| values.iter().map(of).sum::<f64>();
    let squares = sum(|(test, _): &(num_complex::Complex64, _)| test.norm_sqr())
        * sum(|(_, theory): &(_, num_complex::Complex64)| theory.norm_sqr());
    let enough = values.len() >= MIN_PAIRS_OF_COMAC;
    let defined = enough && squares > 0.0;
    let products = sum(|(test, theory)| (test * theory).norm());
    let along = sum(|(test, theory)| (theory.conj() * test).re);
    let apart = sum(|(test, theory)| (test - theory).norm());
    CoordinateMac {
        dof,
        comac: defined.then(|| (products * products / squares).min(1.0)),
        enhanced: enough.then(|| apart / (2.0 * values.len() as f64)),
        direction: defined.then(|| (along / squares.sqrt()).clamp(-1.0, 1.0)),
        pairs: values.len(),
    }
}
