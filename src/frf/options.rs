//! Options of the estimation of FRFs from hits.

use crate::signal::{Conditioning, ExponentialWindow, ForceWindow, Offset};

use super::{Estimator, FrfError};

/// How hits become FRFs. The default is H1 of the records as they are: no window, no offset
/// removed, nothing cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimateOptions {
    /// Estimator of every function.
    pub estimator: Estimator,
    /// Window of the force alone.
    pub force_window: Option<ForceWindow>,
    /// Window of force and responses; its decay rate becomes
    /// [`super::FrfSet::added_damping_rad_s`].
    pub exponential: Option<ExponentialWindow>,
    /// Noise power in the response spectrum over that in the force spectrum, SI units squared, for
    /// Hv. `None` takes it from the samples before each hit.
    pub noise_ratio: Option<f64>,
    /// Treatment of the mean before the hit of each channel.
    pub offset: Offset,
    /// Leave out what lies before the pulse of each hit, so that the transform begins at the hit.
    ///
    /// A response that is cut off by the end of the record then has the same factor `1 − e^{λT}` at
    /// every line of a mode, which changes its residue and not its pole; with a time `t₀` before
    /// the hit the factor is `1 − e^{(λ−iω)(T−t₀)}`, which differs from line to line.
    pub cut_pretrigger: bool,
}

impl Default for EstimateOptions {
    fn default() -> Self {
        Self {
            estimator: Estimator::H1,
            force_window: None,
            exponential: None,
            noise_ratio: None,
            offset: Offset::Keep,
            cut_pretrigger: false,
        }
    }
}

impl EstimateOptions {
    /// Checks the windows and the noise ratio.
    ///
    /// # Errors
    /// [`FrfError::Signal`] for a window; [`FrfError::NoiseRatio`] unless it is positive and
    /// finite.
    pub fn validate(&self) -> Result<(), FrfError> {
        self.conditioning().validate()?;
        match self.noise_ratio {
            Some(got) if !(got > 0.0 && got.is_finite()) => Err(FrfError::NoiseRatio { got }),
            _ => Ok(()),
        }
    }

    /// The part that is done to each hit alone.
    pub fn conditioning(&self) -> Conditioning {
        Conditioning {
            force_window: self.force_window,
            exponential: self.exponential,
            offset: self.offset,
        }
    }
}
