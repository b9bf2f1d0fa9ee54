//! Stages of an identification one by one, for benchmarks: the library reads no clock, so that a
//! benchmark calls each stage and times it.

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::FrfSet;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::error::IdentifyError;
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::estimator::fit_at_poles;
use crate::identify::mdof::normal_equations::Transforms;
use crate::identify::mdof::plscf::Lscf;
use crate::identify::run_variation::RunShifts;

/// Receptances of a band, with all references or as if of a single one.
pub struct Lines {
    data: FitData,
    frf_matrix: FrfMatrix,
}

/// Transforms of the lines.
pub struct Transformed(Transforms);

/// Reduced normal equations of the LSCF.
pub struct Equations(Lscf);

impl Lines {
    /// Receptances of a complete set on a band.
    ///
    /// # Errors
    /// [`IdentifyError`] when set and band do not match.
    pub fn new(set: &FrfSet, band: Band, one_reference: bool) -> Result<Self, IdentifyError> {
        let frf_matrix = FrfMatrix::new(set.functions());
        Ok(Self {
            data: FitData::guarded(set, band)?,
            frf_matrix: if one_reference {
                frf_matrix.as_one_input()
            } else {
                frf_matrix
            },
        })
    }

    /// Transforms for equations up to an order.
    pub fn transformed(&self, order: usize) -> Transformed {
        let whole = 0..self.data.frfs.lines();
        Transformed(Transforms::new(
            &self.data,
            &self.frf_matrix,
            whole,
            order,
            &[],
        ))
    }
}

impl Transformed {
    /// The reduced equations: products of all outputs.
    ///
    /// # Errors
    /// [`IdentifyError::Linalg`].
    pub fn equations(&self) -> Result<Equations, IdentifyError> {
        Ok(Equations(Lscf::new(&self.0)?))
    }
}

impl Equations {
    /// Stable poles λ, rad/s, of several model orders: eigenvalues.
    ///
    /// # Errors
    /// [`IdentifyError::Linalg`].
    pub fn poles(&self, orders: &[usize]) -> Result<Vec<Vec<Complex64>>, IdentifyError> {
        let tables = self.0.tables_of(orders)?.into_iter();
        let poles = tables.map(|(_, poles)| poles.into_iter().map(|pole| pole.lambda).collect());
        Ok(poles.collect())
    }
}

/// Fits the residues of given poles, rad/s, with their noise.
///
/// # Errors
/// [`IdentifyError`] when set and band do not match.
pub fn residues(set: &FrfSet, band: Band, poles: &[Complex64]) -> Result<(), IdentifyError> {
    fit_at_poles(set, band, poles, RunShifts::default()).map(drop)
}
