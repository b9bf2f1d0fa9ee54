//! What a block of poles is fitted in: the FRFs, all poles, and the out-of-band terms.

use crate::linalg::ComplexMatrix;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::fit::fit_data::FitData;

/// Data and poles around a block.
pub(in crate::identify) struct FitContext<'a> {
    pub data: &'a FitData,
    pub sides: &'a FrfMatrix,
    /// All poles, and their residues.
    pub roots: &'a [ModelPole],
    pub residues: &'a ComplexMatrix,
    /// Coordinates of the out-of-band terms of all lines, where they are subtracted first.
    pub far: Option<&'a ComplexMatrix>,
    /// Whether all poles have converged and the shapes need standard deviations.
    pub last: bool,
}
