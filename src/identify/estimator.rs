//! The interface of all identification methods: options, candidate poles, and poles of all model
//! orders.

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::Finding;
use crate::frf::FrfSet;
use crate::identify::error::IdentifyError;
use crate::modal::{Pole, PoleSelection};

/// Options that an estimator is built with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodOptions {
    /// Probability of taking noise for a peak anywhere in the band, between 0 and 1.
    pub false_alarm_probability: f64,
    /// Maximum number of modes, the strongest; all without it. A repeated pole counts as one.
    pub max_modes: Option<usize>,
    /// Highest model order of a method with orders, 4 or more; without it the number of peaks
    /// determines it.
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

/// A candidate pole of an estimator. A value that the method does not give is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Model order of the pole.
    pub order: Option<usize>,
    /// Pole as measured, with the decay rate of an exponential window
    /// ([`FrfSet::added_damping_rad_s`]), which is subtracted later.
    pub pole: Pole,
    /// Participation of each of [`FrfSet::references`].
    pub participation: Option<Vec<Complex64>>,
    /// Receptance residue of each function of the set, in its order, m/(N s); without them the mode
    /// has no shape.
    pub residues: Option<Vec<Complex64>>,
    /// Standard deviation of real and of imaginary part of each residue, m/(N s), without a common
    /// factor.
    pub residue_stds: Option<Vec<f64>>,
    /// Multiplicity of the pole by its residues: 1 for a single mode.
    pub multiplicity: usize,
    /// Standard deviation of the frequency, Hz.
    pub frequency_std_hz: Option<f64>,
    /// Standard deviation of the damping ratio.
    pub damping_std: Option<f64>,
    /// Correlation of the errors of frequency and damping.
    pub frequency_damping_correlation: Option<f64>,
    /// Size of the frequency error by out-of-band modes, Hz, where the data determine it.
    pub frequency_bias_hz: Option<f64>,
    /// Size of the damping ratio error by out-of-band modes.
    pub damping_bias: Option<f64>,
    /// What the data around the pole say about it.
    pub evidence: Option<Evidence>,
    /// Figure of merit of the method; for the circle fit the relative standard deviation of the
    /// damping surface.
    pub quality: Option<f64>,
}

/// What the data on the lines of a pole say about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Modal contribution: square root of the energy that this pole alone explains over that of the
    /// response; of a repeated pole, that of its weakest mode.
    pub contribution: f64,
    /// Square root of the energy of the residual beyond the noise over that of the response.
    pub misfit: f64,
}

impl Candidate {
    /// A single pole of which nothing else is known.
    pub fn new(pole: Pole) -> Self {
        Self {
            order: None,
            pole,
            participation: None,
            residues: None,
            residue_stds: None,
            multiplicity: 1,
            frequency_std_hz: None,
            damping_std: None,
            frequency_damping_correlation: None,
            frequency_bias_hz: None,
            damping_bias: None,
            evidence: None,
            quality: None,
        }
    }
}

/// Status of a pole of one model order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoleStatus {
    /// Its track has fewer than three orders.
    Unstable,
    /// Stable over three orders or more, and not selected as a mode.
    Stable,
    /// Selected as a mode by [`identification`](crate::identify::identification).
    Selected,
}

impl PoleStatus {
    /// Its name in the listing.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unstable => "alone",
            Self::Stable => "stable",
            Self::Selected => "chosen",
        }
    }
}

/// A pole of one model order: a point of the stabilization diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleAtOrder {
    /// Model order.
    pub order: usize,
    /// Pole as in the data.
    pub pole: Pole,
    /// Status of the pole.
    pub status: PoleStatus,
}

/// Candidates, findings and poles of all model orders of an estimate.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct PoleTable {
    /// Poles in ascending order, then frequency.
    pub candidates: Vec<Candidate>,
    /// Findings of the estimate.
    pub findings: Vec<Finding>,
    /// Poles of all model orders, for a method that has orders.
    pub stabilization: Vec<PoleAtOrder>,
}

/// A method that finds poles in a set of FRFs.
pub trait PoleEstimator {
    /// Its name in [`ESTIMATORS`](crate::identify::ESTIMATORS).
    fn name(&self) -> &'static str;

    /// Poles in a band; no candidate where the FRFs hold no signal.
    ///
    /// # Errors
    /// [`IdentifyError`] when band or options do not fit the set or a matrix problem has no
    /// solution.
    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError>;
}

/// Options of an identification.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifyOptions {
    /// Name of an estimator, or `auto` (maximum likelihood).
    pub method: String,
    /// Band to search, cut to the data; without it the valid band of the set, else the whole axis
    /// above 0 Hz.
    pub band: Option<Band>,
    /// References to use; all without it.
    pub references: Option<Vec<Dof>>,
    /// Whether FRFs with a value in the band that is not finite are left out, with a finding; if
    /// not, they are an error.
    pub partial: bool,
    /// Poles that the user selects; without it all modes that the data support.
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
