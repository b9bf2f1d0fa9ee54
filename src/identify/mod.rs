//! Identification estimates modes from FRFs: poles by an estimator, then residues, shapes and the
//! modal model for the correlation.
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
//! | `ml` | maximum likelihood from the stable poles of the polyreference LSCF (Guillaume et al. 2003), with Cramér-Rao bounds (Golub and Pereyra 1973) |
//!
//! An estimator gives poles as they are in the data, with the damping of an exponential window; the
//! damping of the window is removed once, when candidates become modes. This stage reads no file
//! and uses no theoretical model.
//!
//! Several responses and references show the multiplicity of a pole (`repeated_poles`); a repeated
//! pole gives as many modes of one group (`rank_one_terms`). With a single reference or response it
//! gives one mode. `ml`, the method of `auto`, also separates close modes by the participation
//! factors of several references. `rfp`, `lsce` and `lscf` take the poles that are stable while the
//! model order rises, with residues by least squares (`mdof`), and list the poles of all orders.
//!
//! A file may import from its room and from those of the last column, which a test checks.
//!
//! | room | holds | may use |
//! |---|---|---|
//! | `estimator` | what every method gives | `error` |
//! | `method` | table of a method with its shifts between runs | `run_variation` `estimator` `error` |
//! | `data` | FRFs of a band, poles that are fitted to them, residual | `estimator` `error` |
//! | `noise` | variances, force noise, line correlation | `data` |
//! | `fit` | data of a fit, nonlinear least squares, covariances | `data` `noise` `error` |
//! | `gain_errors` | factors by which FRFs of several references disagree | `data` `fit` `modes` `error` |
//! | `run_variation` | frequency shifts between measurement runs | `data` `noise` `fit` `estimator` |
//! | `sdof` | single-degree-of-freedom methods | `data` `fit` `method` `estimator` `error` |
//! | `pole_model` | poles of a fit, their tests, candidates and findings | `data` `noise` `fit` `run_variation` `sdof` `estimator` `error` |
//! | `mdof` | methods of rising model order | `data` `noise` `fit` `run_variation` `pole_model` `method` `estimator` `error` |
//! | `ml` | maximum likelihood | `data` `noise` `fit` `run_variation` `sdof` `pole_model` `mdof` `method` `estimator` `error` |
//! | `modes` | modes from poles | `estimator` `error` |
//! | `mode_indicators` | CMIF, MvMIF | `data` `estimator` `error` |
//! | `order_selection` | number of modes that the data support | `data` `noise` `fit` `estimator` `error` |

mod data;
mod error;
mod estimator;
mod fit;
mod gain_errors;
mod mdof;
mod method;
mod ml;
mod mode_indicators;
mod modes;
mod noise;
mod order_selection;
#[cfg(test)]
mod order_selection_tests;
mod pole_model;
mod run_variation;
mod sdof;
#[doc(hidden)]
pub mod stages;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use num_complex::Complex64;

use crate::frf::FrfSet;
use crate::modal::ModalModel;

use gain_errors::GainErrors;
use method::{Method, Outcome};
use run_variation::within_runs::merge_varying_modes;

pub use error::IdentifyError;
pub use estimator::{
    Candidate, Evidence, IdentifyOptions, MethodOptions, PoleAtOrder, PoleEstimator, PoleStatus,
    PoleTable,
};
pub(crate) use mdof::stabilization::{MAX_ORDER, MIN_HIGHEST_ORDER};
pub use mode_indicators::{Indicators, cmif_at, indicators};
pub use modes::quality::assess;
pub use order_selection::{OrderSelection, OrderStep, PredictiveScore, support};
pub use sdof::circle_detail::{CircleDetail, circle_detail};

/// An estimator by name.
pub struct Entry {
    /// Name on the command line, in scenes and in `modes.json`.
    pub name: &'static str,
    /// Whether it has a model order.
    pub has_order: bool,
    /// Its constructor; an estimator without shifts between runs has an empty `impl Method`.
    build: fn(&MethodOptions) -> Box<dyn Method>,
}

impl Entry {
    /// The estimator with its options.
    pub fn estimator(&self, options: &MethodOptions) -> Box<dyn PoleEstimator> {
        (self.build)(options)
    }
}

/// Every estimator, in ascending order of effort: a study names the first one that suffices, and
/// takes those without a model order as single-degree-of-freedom methods.
///
/// The implementation is a file of `sdof`, `mdof` or `ml` that takes the FRFs of the band from
/// `data::band_frfs`.
pub const ESTIMATORS: &[Entry] = &[
    Entry {
        name: "peak",
        has_order: false,
        build: |options| {
            Box::new(sdof::estimator::SingleModeEstimator {
                method: sdof::peak_picking::PeakPicking,
                options: *options,
            })
        },
    },
    Entry {
        name: "circle",
        has_order: false,
        build: |options| {
            Box::new(sdof::estimator::SingleModeEstimator {
                method: sdof::circle_fit::CircleFit,
                options: *options,
            })
        },
    },
    Entry {
        name: "line",
        has_order: false,
        build: |options| {
            Box::new(sdof::estimator::SingleModeEstimator {
                method: sdof::line_fit::LineFit,
                options: *options,
            })
        },
    },
    Entry {
        name: "rfp",
        has_order: true,
        build: |options| {
            Box::new(mdof::estimator::MultiModeEstimator {
                method: mdof::rfp::RationalFractions {
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
            Box::new(mdof::estimator::MultiModeEstimator {
                method: mdof::lsce::ComplexExponentials {
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
            Box::new(mdof::estimator::MultiModeEstimator {
                method: mdof::lscf::LeastSquaresComplexFrequency {
                    max_order: options.max_order,
                },
                options: *options,
            })
        },
    },
    Entry {
        name: "ml",
        has_order: true,
        build: |options| Box::new(ml::estimator::MaximumLikelihood { options: *options }),
    },
];

/// The method of `auto`.
const AUTO: &str = "ml";

/// The method that a name stands for: `auto` for the default one, the trade name PolyMAX for LSCF.
pub fn method_of_name(name: &str) -> &str {
    match name {
        "auto" => AUTO,
        "polymax" => "lscf",
        name => name,
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
            && !(MIN_HIGHEST_ORDER..=MAX_ORDER).contains(&order)
        {
            return Err(IdentifyError::OptionOutOfRange {
                name: "order",
                got: order as f64,
                expected: "4 to 500: a mode is a pole that is stable over three orders, the lowest of which is 2; a band with more poles is divided",
            });
        }
        if self.estimator.max_modes == Some(0) {
            return Err(IdentifyError::OptionOutOfRange {
                name: "max_modes",
                got: 0.0,
                expected: "1 or more",
            });
        }
        let name = method_of_name(&self.method);
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
/// Poles are those of the structure, without the added decay rate of an exponential window.
/// Residues are those of receptances, m/(N s), for every kind of FRF. The model holds the findings
/// of this stage, not those of the set.
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
/// // Unit modal mass: the shape at the excitation point is one over the root of the mass.
/// assert!((mode.shape.get(&dof).unwrap().re - 0.5f64.sqrt()).abs() < 1e-6);
/// ```
///
/// # Errors
/// [`IdentifyError`] when the options do not fit the set, or a matrix problem has no solution.
pub fn identify(set: &FrfSet, options: &IdentifyOptions) -> Result<ModalModel, IdentifyError> {
    Ok(identification(set, options)?.model)
}

/// Modes with the poles of all model orders.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// The modes.
    pub model: ModalModel,
    /// Points of the stabilization diagram, without the damping of an exponential window; none for
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
    let prepared = data::prepare::chosen(set, options)?;
    let (mut set, band, scales) = (prepared.set, prepared.band, prepared.scales);
    let gain_errors = GainErrors::estimate(&set, band, options.estimator.false_alarm_probability)?;
    let mut findings = prepared.findings;
    if let Some(gain_errors) = gain_errors {
        findings.extend(gain_errors.findings(&set));
        set = Cow::Owned(gain_errors.corrected(&set));
    }
    let set = set.as_ref();
    let method = (entry.build)(&options.estimator);
    let Outcome {
        mut table,
        run_shifts,
    } = method.outcome(set, band)?;
    if let Some(selection) = &options.selection {
        let fit_residues =
            |poles: &[Complex64]| mdof::estimator::fit_at_poles(set, band, poles, run_shifts);
        table = modes::pole_selection::select_poles(set, band, table, selection, fit_residues)?;
    }
    findings.extend(sdof::findings::window_decay(set));
    table.findings.splice(0..0, findings);
    if table
        .candidates
        .iter()
        .any(|candidate| candidate.evidence.is_none())
    {
        mdof::estimator::add_evidence(set, band, &mut table.candidates)?;
    }
    mdof::stabilization::mark_selected(&mut table);
    let mut stabilization = std::mem::take(&mut table.stabilization);
    for point in &mut stabilization {
        point.pole = point.pole.without_added_damping(set.added_damping_rad_s);
    }
    // Poles that the user selected stay as they are.
    if options.selection.is_none() {
        merge_varying_modes(set, &mut table);
    }
    Ok(Identification {
        model: modes::modal_model::modal_model(set, &scales, band, method.name(), table)?,
        stabilization,
    })
}
