//! Modes from FRFs: poles by an estimator, residues, shapes, and the modal model that correlation
//! works on.
//!
//! ```text
//! FrfSet, band ── PoleEstimator ──▶ PoleTable ── selection ──▶ ModalModel
//! ```
//!
//! | name | method |
//! |---|---|
//! | `peak` | peak-picking with half-power damping (Ewins 2000) |
//! | `circle` | circle fit with damping surface (Kennedy and Pancu 1947) |
//! | `line` | line fit (Dobson 1987) |
//! | `rfp` | global rational fraction polynomials with orthogonal bases (Richardson and Formenti 1982) |
//! | `lsce` | least-squares complex exponentials, polyreference (Brown et al. 1979, Vold et al. 1982) |
//! | `lscf` | polyreference least-squares complex frequency domain (Guillaume et al. 2003) |
//! | `ml` | maximum likelihood from the poles of the polyreference LSCF that stay (Guillaume et al. 2003), with bounds (Golub and Pereyra 1973) |
//!
//! An estimator sees poles as they are in the data, the damping of an exponential window included;
//! the window is taken out once, when candidates become modes. This stage reads no file and knows
//! no model.
//!
//! Several responses and references show how many modes share a pole (`repeated`); such a root
//! becomes as many modes of one group (`parts`). `ml`, which `auto` stands for, tells close modes
//! apart by the participation of several references as well. `rfp`, `lsce` and `lscf` take the
//! poles that stay while the model order rises, with residues by least squares (`multi`), and list
//! the poles of all orders. A single reference or response cannot show it, and a repeated root then
//! gives one mode.

#[cfg(test)]
mod accuracy_tests;
mod automatic;
mod background;
#[cfg(test)]
mod beam_tests;
mod block;
mod checks;
mod choice;
#[cfg(test)]
mod choice_tests;
mod circle;
mod circle_detail;
mod close;
#[cfg(test)]
mod close_tests;
mod companions;
mod correlation;
mod doubled;
mod doubts;
mod error;
#[cfg(test)]
mod failed_decomposition_tests;
mod far;
#[cfg(test)]
mod high_snr_tests;
#[cfg(test)]
mod hump_tests;
mod indicator;
mod indicators;
mod influence;
mod leakage;
mod left_over;
mod line;
mod linearised;
mod lsce;
#[cfg(test)]
mod lscf_tests;
#[cfg(test)]
mod methods_tests;
mod misfit;
#[cfg(test)]
mod ml_tests;
mod moving;
mod multi;
mod narrower_bands;
mod noise;
mod noise_course;
mod noise_profile;
#[cfg(test)]
mod options_tests;
mod outside;
mod parts;
#[cfg(test)]
mod parts_tests;
mod peak;
mod plscf;
mod pruning;
#[cfg(test)]
mod rank_tests;
mod reasons;
mod receptance;
mod refine;
mod repeated;
#[cfg(test)]
mod repeated_tests;
mod residues;
mod rfp;
mod roots;
mod run_partners;
mod search;
mod seeds;
mod selection;
mod several;
mod shape;
#[cfg(test)]
mod shape_tests;
mod shared;
mod sides;
mod significance;
mod single;
mod spread;
mod stabilization;
mod stable;
#[doc(hidden)]
pub mod stages;
mod standing;
mod strength;
mod support;
#[cfg(test)]
mod support_tests;
#[cfg(test)]
mod synthetic;
mod transforms;
mod tries;
mod turning;
mod unexplained;
mod window;
#[cfg(test)]
mod window_tests;

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::Finding;
use crate::frf::FrfSet;
use crate::modal::{ModalModel, Pole, PoleSelection};

use moving::Moved;

pub use circle_detail::{CircleDetail, circle_detail};
pub use error::IdentifyError;
pub use indicators::{Indicators, cmif_at, indicators};
pub use support::{Foretold, Support, Tried, support};

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
    moved: Moved,
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

/// An estimator by name.
pub struct Entry {
    /// Name on the command line, in scenes and in `modes.json`.
    pub name: &'static str,
    /// Whether it has a model order.
    pub has_order: bool,
    /// Builds it.
    pub build: fn(&MethodOptions) -> Box<dyn PoleEstimator>,
}

/// Every estimator.
pub const ESTIMATORS: &[Entry] = &[
    Entry {
        name: "peak",
        has_order: false,
        build: |options| {
            Box::new(single::SingleModeEstimator {
                method: peak::PeakPicking,
                options: *options,
            })
        },
    },
    Entry {
        name: "circle",
        has_order: false,
        build: |options| {
            Box::new(single::SingleModeEstimator {
                method: circle::CircleFit,
                options: *options,
            })
        },
    },
    Entry {
        name: "line",
        has_order: false,
        build: |options| {
            Box::new(single::SingleModeEstimator {
                method: line::LineFit,
                options: *options,
            })
        },
    },
    Entry {
        name: "rfp",
        has_order: true,
        build: |options| {
            Box::new(multi::MultiModeEstimator {
                method: rfp::RationalFractions {
                    max_order: options.max_order,
                },
                options: *options,
            })
        },
    },
    Entry {
        name: "lsce",
        has_order: true,
        build: |options| {
            Box::new(multi::MultiModeEstimator {
                method: lsce::ComplexExponentials {
                    max_order: options.max_order,
                },
                options: *options,
            })
        },
    },
    Entry {
        name: "lscf",
        has_order: true,
        build: |options| {
            Box::new(multi::MultiModeEstimator {
                method: seeds::LeastSquaresComplexFrequency {
                    max_order: options.max_order,
                },
                options: *options,
            })
        },
    },
    Entry {
        name: "ml",
        has_order: true,
        build: |options| Box::new(automatic::Automatic { options: *options }),
    },
];

/// What `auto` stands for.
const AUTO: &str = "ml";

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

impl IdentifyOptions {
    /// The estimator that these options name, their numbers checked.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownMethod`] with the known names; [`IdentifyError::OptionOutOfRange`];
    /// [`IdentifyError::NoOrder`] for an order of a method that has none.
    pub fn validate(&self) -> Result<&'static Entry, IdentifyError> {
        let probability = self.estimator.false_alarm_probability;
        if !(probability > 0.0 && probability < 1.0) {
            return Err(IdentifyError::OptionOutOfRange {
                name: "false_alarm_probability",
                got: probability,
                expected: "a number between 0 and 1",
            });
        }
        if let Some(order) = self.estimator.max_order
            && order < stabilization::LEAST_HIGHEST
        {
            return Err(IdentifyError::OptionOutOfRange {
                name: "order",
                got: order as f64,
                expected: "4 or more: modes are poles that stay over three orders, the lowest of which is 2",
            });
        }
        if self.estimator.max_modes == Some(0) {
            return Err(IdentifyError::OptionOutOfRange {
                name: "max_modes",
                got: 0.0,
                expected: "1 or more",
            });
        }
        let name = if self.method == "auto" {
            AUTO
        } else {
            &self.method
        };
        let entry = ESTIMATORS.iter().find(|entry| entry.name == name);
        let entry = entry.ok_or_else(|| IdentifyError::UnknownMethod {
            got: self.method.clone(),
            known: std::iter::once("auto")
                .chain(ESTIMATORS.iter().map(|entry| entry.name))
                .collect(),
        })?;
        if self.estimator.max_order.is_some() && !entry.has_order {
            let with_order = ESTIMATORS.iter().filter(|entry| entry.has_order);
            return Err(IdentifyError::NoOrder {
                got: entry.name,
                known: with_order.map(|entry| entry.name).collect(),
            });
        }
        Ok(entry)
    }
}

/// The modes of a set of FRFs.
///
/// Poles are those of the structure: the decay rate of an exponential window that the set still
/// carries is taken out. Residues are those of receptances, m/(N s), whatever kind the functions
/// are. The findings are those of this stage; the set keeps its own.
///
/// ```
/// use modalign::axis::FrequencyAxis;
/// use modalign::frf::{FrfSet, Function, FunctionData};
/// use modalign::identify::{IdentifyOptions, identify};
/// use modalign::quantity::FrfKind;
/// use num_complex::Complex64;
///
/// // One mode of 2 kg at 50 Hz with 1 % damping, as a driving-point receptance.
/// let axis = FrequencyAxis { start_hz: 0.0, step_hz: 0.1, len: 1001 };
/// let natural = std::f64::consts::TAU * 50.0;
/// let receptance = |k: usize| {
///     let omega = axis.rad_s(k);
///     let stiffness = Complex64::new(natural * natural - omega * omega, 0.02 * natural * omega);
///     (2.0 * stiffness).inv()
/// };
/// let dof: modalign::dof::Dof = "1:+Z".parse().unwrap();
/// let function = Function {
///     response: dof.clone(),
///     reference: dof.clone(),
///     kind: FrfKind::Receptance,
///     averages: None,
///     estimator: None,
///     variance_dof: None,
/// };
/// let values = (0..axis.len).map(receptance).collect();
/// let mut set = FrfSet::new(axis);
/// set.push(function, FunctionData { values, ..FunctionData::default() }).unwrap();
///
/// let model = identify(&set, &IdentifyOptions::default()).unwrap();
/// let mode = &model.modes[0];
/// assert!((mode.frequency_hz - 50.0).abs() < 1e-6);
/// assert!((mode.damping_ratio.unwrap() - 0.01).abs() < 1e-8);
/// // Unit modal mass: the shape at the hit is one over the root of the mass.
/// assert!((mode.shape.get(&dof).unwrap().re - 0.5f64.sqrt()).abs() < 1e-6);
/// ```
///
/// # Errors
/// [`IdentifyError`] when options and set do not go together, or a matrix problem has no answer.
pub fn identify(set: &FrfSet, options: &IdentifyOptions) -> Result<ModalModel, IdentifyError> {
    Ok(identification(set, options)?.model)
}

/// Modes with the poles of all model orders that they were taken from.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// The modes.
    pub model: ModalModel,
    /// Points of the stabilisation diagram, without the damping of an exponential window; none for
    /// a method without orders.
    pub stabilization: Vec<PoleAtOrder>,
}

/// As [`identify`], with the poles of all model orders.
///
/// # Errors
/// As [`identify`].
pub fn identification(
    set: &FrfSet,
    options: &IdentifyOptions,
) -> Result<Identification, IdentifyError> {
    let entry = options.validate()?;
    let chosen = selection::chosen(set, options)?;
    let (set, band) = (chosen.set.as_ref(), chosen.band);
    let estimator = (entry.build)(&options.estimator);
    let mut table = estimator.estimate(set, band)?;
    if let Some(selection) = &options.selection {
        table = choice::chosen((set, band), table, selection)?;
    }
    let findings = chosen.findings.into_iter();
    table
        .findings
        .splice(0..0, findings.chain(checks::window_decay(set)));
    stabilization::mark_chosen(&mut table);
    let mut stabilization = std::mem::take(&mut table.stabilization);
    for point in &mut stabilization {
        point.pole = point.pole.without_added_damping(set.added_damping_rad_s);
    }
    Ok(Identification {
        model: selection::modal_model(set, band, estimator.name(), table)?,
        stabilization,
    })
}
