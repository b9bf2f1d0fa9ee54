//! Correlation measures compare shapes, degrees of freedom, subspaces, shapes through a mass
//! matrix, and FRFs, in addition to the pairing.
//!
//! | measure | of what | source |
//! |---|---|---|
//! | [`MacMatrix`], [`auto_mac`] | every mode of one set with every mode of another, or of the same | Allemang and Brown 1982 |
//! | [`FrequencyMac`] | the same pairs with both frequencies | Fotsch and Ewins 2000 |
//! | [`ScaleFactor`] | a pair: which factor and phase lie between its shapes | Allemang 2003 |
//! | [`CoordinateMac`] | a degree of freedom over all pairs | Lieven and Ewins 1988; Hunt 1992 |
//! | [`ReversedSensor`] | a sensor that reads against the theory | - |
//! | [`ClusterMac`] | close modes as subspaces | Björck and Golub 1973 |
//! | [`Orthogonality`] | shapes through a mass matrix reduced to the sensors | Guyan 1965; O'Callahan et al. 1989 |
//! | [`FrfCorrelation`] | two sets of FRFs, by function and by line | Heylen and Lammens 1996; Zang et al. 2001 |
//!
//! Each has the number of its degrees of freedom, and is `None` where it is not defined.

mod auto_mac;
mod cluster;
mod coordinate;
mod frf;
mod mac_matrix;
mod orthogonality;
mod pair_shapes;
mod serep_modes;

use num_complex::Complex64;
use serde::Serialize;

use crate::modal::{ModalModel, modal_scale_factor};

use super::shapes::Shapes;
use super::{CorrelateError, PairOptions, Pairing};

pub use auto_mac::{AutoMac, Duplicate, DuplicateLimits, auto_mac};
pub use cluster::{CLUSTER_SPAN, CLUSTER_WIDTH, ClusterMac};
pub use coordinate::CoordinateMac;
pub use frf::{
    BandCorrelation, FrfCorrelation, FunctionCorrelation, LineCorrelation, frf_correlation,
};
pub use mac_matrix::{DofRange, MacMatrix, ModeName};
pub use orthogonality::{
    Orthogonality, ReducedMass, Reduction, SensorRow, orthogonality, orthogonality_dofs,
    reduced_mass,
};

pub use super::reversed_sensors::{
    ReversedSensor, reverse_sensors, reversed_findings, reversed_sensors,
};
pub use serep_modes::{SerepModes, expansion_modes, serep_modes};

use auto_mac::theory_auto_mac;
use cluster::clusters;
use coordinate::coordinates;
use pair_shapes::PairShapes;

/// Two modes with frequencies and MAC: a point of the plot of the MAC over both frequencies, which
/// shows similar shapes at different frequencies.
///
/// # Reference
/// Fotsch and Ewins (2000), Application of MAC in the frequency domain, IMAC 18 (FMAC).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrequencyMac {
    /// Test mode.
    pub test: ModeName,
    /// Theory mode.
    pub theory: ModeName,
    /// Signed frequency error by the options' reference, percent; `None` for a theory mode at 0 Hz.
    pub error_percent: Option<f64>,
    /// MAC.
    pub mac: f64,
}

/// Modal scale factor of a pair.
///
/// Direction: from theory to test, `φ_test ≈ s φ_theory`, `s = φ_theory^H φ_test / φ_theory^H
/// φ_theory`. Its phase is that of the test shape against the theory's; its magnitude is
/// meaningful where both have the same scaling.
///
/// # Reference
/// Allemang (2003), The modal assurance criterion: twenty years of use and abuse, Sound and
/// Vibration 37(8), eq. 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScaleFactor {
    /// Test mode.
    pub test: ModeName,
    /// Theory mode.
    pub theory: ModeName,
    /// Magnitude of `s`.
    pub magnitude: f64,
    /// Phase of `s`, degrees, -180 to 180.
    pub phase_deg: f64,
    /// Degrees of freedom used.
    pub dofs: usize,
}

/// Correlation measures of the pairs of one test and one theory, besides their MAC.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// MAC of every test mode (row) with every theory mode (column), each pair separately.
    pub mac: MacMatrix,
    /// MAC of the theory with itself at the test's sensors: modes that these cannot separate.
    pub theory_auto_mac: MacMatrix,
    /// All pairs of modes with frequencies and MAC.
    pub frequency_mac: Vec<FrequencyMac>,
    /// For every pair with a simple root.
    pub scale_factors: Vec<ScaleFactor>,
    /// For every degree of freedom that both have.
    pub coordinates: Vec<CoordinateMac>,
    /// Close and repeated roots with the modes that met them.
    pub clusters: Vec<ClusterMac>,
    /// Through a reduced mass matrix; `None` where none was given.
    pub orthogonality: Option<Orthogonality>,
}

/// The measures of a test and a theory that [`super::pair`] paired, without orthogonality, which
/// needs a mass matrix.
///
/// # Errors
/// [`CorrelateError::MixedUnits`], [`CorrelateError::Linalg`].
pub fn measures(
    test: &ModalModel,
    theory: &ModalModel,
    pairing: &Pairing,
    options: &PairOptions,
) -> Result<Measures, CorrelateError> {
    let shapes = Shapes::new(test, theory, &pairing.map, options)?;
    let pairs = PairShapes::of_pairing(&shapes, pairing);
    let mac = MacMatrix::new(test, theory, &shapes);
    Ok(Measures {
        theory_auto_mac: theory_auto_mac(theory, &pairing.map, options)?,
        frequency_mac: frequency_mac(&mac, options),
        scale_factors: scale_factors(&mac, &shapes, pairing),
        coordinates: coordinates(&pairing.map, &pairs),
        clusters: clusters(test, theory, &shapes, pairing)?,
        orthogonality: None,
        mac,
    })
}

fn frequency_mac(matrix: &MacMatrix, options: &PairOptions) -> Vec<FrequencyMac> {
    let mut points = Vec::new();
    for (test, row) in matrix.rows.iter().zip(&matrix.mac) {
        for (theory, mac) in matrix.columns.iter().zip(row) {
            let Some(mac) = *mac else { continue };
            let error = options.error_reference.error(test.hz, theory.hz);
            points.push(FrequencyMac {
                test: *test,
                theory: *theory,
                error_percent: Some(100.0 * error).filter(|error| error.is_finite()),
                mac,
            });
        }
    }
    points
}

fn scale_factors(matrix: &MacMatrix, shapes: &Shapes, pairing: &Pairing) -> Vec<ScaleFactor> {
    let simple = pairing.pairs.iter().filter(|pair| pair.theory.len() == 1);
    let factor = |pair: &super::Pair| {
        let (i, j) = (pair.partners[0].test, pair.theory[0]);
        let [test, theory] = shapes.common_values(&[i], &[j]);
        let s: Complex64 = modal_scale_factor(&theory[0], &test[0])?;
        Some(ScaleFactor {
            test: matrix.rows[i],
            theory: matrix.columns[j],
            magnitude: s.norm(),
            phase_deg: s.arg().to_degrees(),
            dofs: test[0].len(),
        })
    };
    simple.filter_map(factor).collect()
}

#[cfg(test)]
pub(in super::super) mod models;
#[cfg(test)]
mod orthogonality_tests;
#[cfg(test)]
mod tests;
