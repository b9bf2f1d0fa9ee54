//! The interface of the methods inside of `identify`: a table of poles, and the shifts between
//! measurement runs at which residues are fitted again for poles that the user selects.

use crate::axis::Band;
use crate::frf::FrfSet;

use crate::identify::error::IdentifyError;
use crate::identify::estimator::{PoleEstimator, PoleTable};
use crate::identify::run_variation::RunShifts;

/// Result of a method.
pub(in crate::identify) struct Outcome {
    /// Candidates, findings and poles of all model orders.
    pub table: PoleTable,
    /// Frequency shifts of modes between measurement runs.
    pub run_shifts: RunShifts,
}

/// A method of identification. One that estimates no shifts between runs has an empty `impl`.
pub(in crate::identify) trait Method: PoleEstimator {
    /// As [`PoleEstimator::estimate`], with the shifts between runs: none, unless a method
    /// estimates them.
    ///
    /// # Errors
    /// As [`PoleEstimator::estimate`].
    fn outcome(&self, set: &FrfSet, band: Band) -> Result<Outcome, IdentifyError> {
        Ok(Outcome {
            table: self.estimate(set, band)?,
            run_shifts: RunShifts::default(),
        })
    }
}
