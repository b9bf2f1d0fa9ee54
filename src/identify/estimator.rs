//! What every method gives: candidates with the poles of all model orders, and the options it is
//! built with.

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::Finding;
use crate::frf::FrfSet;
use crate::identify::error::IdentifyError;
use crate::identify::run_variation::Moved;
use crate::modal::{Pole, PoleSelection};

/// Options that an estimator is built with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodOptions {
    /// Probability of taking noise for a peak anywhere in the band, between 0 and 1.
    pub false_alarm_probability: f64,
    /// Keep at most this many modes, the strongest; all without it. A repeated root counts as one.
    pub max_modes: Option<usize>,
    /// Highest model order of a method that has one, 4 or more; chosen by the number of peaks
    /// without it.
    pub max_order: Option<usize>,
}

impl Default for MethodOptions {
    fn default() -> Self {
        Self {
            false_alarm_probability: 1e-3,
            max_modes: None,
            max_order: None,
        }
    }
}

/// A pole that an estimator proposes. What a method does not give is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Model order at which it was found.
    pub order: Option<usize>,
    /// Pole as in the data: the damping of an exponential window is still in.
    pub pole: Pole,
    /// Participation of each of [`FrfSet::references`].
    pub participation: Option<Vec<Complex64>>,
    /// Receptance residue of each function of the set, in its order, m/(N s).
    pub residues: Option<Vec<Complex64>>,
    /// Standard deviation of real and of imaginary part of each residue, m/(N s), but for a factor
    /// that all have in common.
    pub residue_stds: Option<Vec<f64>>,
    /// Modes that share this pole, as far as the residues show: 1 for a single one.
    pub multiplicity: usize,
    /// Standard deviation of the frequency, Hz.
    pub frequency_std_hz: Option<f64>,
    /// Standard deviation of the damping ratio.
    pub damping_std: Option<f64>,
    /// Correlation of the errors of frequency and damping.
    pub frequency_damping_correlation: Option<f64>,
    /// Size of the error in frequency that modes outside the band leave, Hz, as far as the data
    /// tell.
    pub frequency_bias_hz: Option<f64>,
    /// The same of the damping ratio.
    pub damping_bias: Option<f64>,
    /// Figure of merit of the method; for the circle fit the relative standard deviation of the
    /// damping surface.
    pub quality: Option<f64>,
}

/// What became of a pole of one model order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoleStatus {
    /// It stays over fewer than three orders.
    Alone,
    /// It stays over three orders or more, and no mode was made of it.
    Stable,
    /// A mode was made of it, as [`identification`] tells.
    Chosen,
}

impl PoleStatus {
    /// Its name in the listing.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Stable => "stable",
            Self::Chosen => "chosen",
        }
    }
}

/// A pole of one model order: a point of the stabilisation diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleAtOrder {
    /// Model order.
    pub order: usize,
    /// Pole as in the data.
    pub pole: Pole,
    /// What became of it.
    pub status: PoleStatus,
}

/// What an estimator found.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct PoleTable {
    /// Poles in ascending order, then frequency.
    pub candidates: Vec<Candidate>,
    /// What the data said on the way.
    pub findings: Vec<Finding>,
    /// Poles of all model orders, for a method that has orders.
    pub stabilization: Vec<PoleAtOrder>,
    /// Modes that move from run to run.
    pub(in crate::identify) moved: Moved,
}

/// A method that finds poles in a set of FRFs.
pub trait PoleEstimator {
    /// Its name in [`ESTIMATORS`].
    fn name(&self) -> &'static str;

    /// Poles in a band.
    ///
    /// # Errors
    /// [`IdentifyError`] when set, band and options do not go together or a matrix problem has no
    /// answer.
    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError>;
}

/// Options of an identification.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifyOptions {
    /// Name of an estimator, or `auto` (maximum likelihood).
    pub method: String,
    /// Band to search, cut to the data; without it the set's valid band, and where that is unknown
    /// the whole axis above 0 Hz.
    pub band: Option<Band>,
    /// References to use; all without it.
    pub references: Option<Vec<Dof>>,
    /// Whether functions with a value in the band that is no number are left out, with a finding;
    /// an error without it.
    pub partial: bool,
    /// A person's choice among the poles of the method; all that the data support without it.
    pub selection: Option<PoleSelection>,
    /// Options of the estimator.
    pub estimator: MethodOptions,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            method: "auto".to_owned(),
            band: None,
            references: None,
            partial: false,
            selection: None,
            estimator: MethodOptions::default(),
        }
    }
}
