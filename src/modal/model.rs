//! The modal model is the common result type of test and theory.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::Finding;

use super::{Grade, ModeShape, Pole, Quality};

/// How a shape is scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// φᵀMφ = 1 (kg), for theory and for tests with a driving point.
    UnitModalMass,
    /// Largest component 1.
    UnitMax,
    /// As the file gave it; nothing is known.
    Unknown,
}

impl Scaling {
    /// The name in `modes.json`.
    pub fn name(self) -> &'static str {
        match self {
            Scaling::UnitModalMass => "unit-modal-mass",
            Scaling::UnitMax => "unit-max",
            Scaling::Unknown => "unknown",
        }
    }

    /// The scaling of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        let all = [Scaling::UnitModalMass, Scaling::UnitMax, Scaling::Unknown];
        all.into_iter().find(|scaling| scaling.name() == name)
    }
}

/// One mode, measured or predicted. What is not known is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Natural frequency |λ|/2π, Hz; 0 for a rigid-body mode.
    pub frequency_hz: f64,
    /// Damping ratio, a fraction; `None` for an undamped model.
    pub damping_ratio: Option<f64>,
    /// Standard deviation of the frequency, Hz.
    pub frequency_std_hz: Option<f64>,
    /// Standard deviation of the damping ratio.
    pub damping_std: Option<f64>,
    /// Correlation of the errors of frequency and damping.
    pub frequency_damping_correlation: Option<f64>,
    /// Modes of one repeated root share this number.
    pub group: Option<u32>,
    /// Shape at the sensors.
    pub shape: ModeShape,
    /// Values of responses of other quantities, in the scale of the shape, by the unit that they
    /// have for a shape in m: sound pressures in `Pa s2`, strains in `m/m`, rotations in `rad`.
    pub other_shapes: BTreeMap<String, ModeShape>,
    /// Standard deviation of the real and of the imaginary part of each shape component, in the
    /// scale of the shape, but for an error of that scale, which all components have in common.
    pub shape_std: Option<BTreeMap<Dof, f64>>,
    /// Receptance residues A of `A/(iω−λ) + conj.`, m/(N s), by (response, reference); those of
    /// other quantities in their unit over N s.
    pub residues: BTreeMap<(Dof, Dof), Complex64>,
    /// Modal mass for the shape as scaled, kg.
    pub modal_mass_kg: Option<f64>,
    /// How the shape is scaled.
    pub scaling: Scaling,
    /// Modal phase collinearity of the shape.
    pub mpc: Option<f64>,
    /// Method that found it (`circle`, `peak`, `theory`).
    pub method: Option<String>,
    /// Model order at which it was found.
    pub order: Option<usize>,
    /// Mean phase of the shape, rad.
    pub mean_phase_rad: Option<f64>,
    /// Mean phase deviation of the shape, rad.
    pub mean_phase_deviation_rad: Option<f64>,
    /// Half-power width over the mean distance to the neighbouring modes; `None` for a mode without
    /// neighbours.
    pub modal_overlap: Option<f64>,
    /// Frequency lines across the half-power band of the pole as measured, the damping of an
    /// exponential window included.
    pub half_power_lines: Option<f64>,
    /// Size of the error in frequency that modes outside the band leave, Hz, as far as the data
    /// tell; in no standard deviation.
    pub frequency_bias_hz: Option<f64>,
    /// The same of the damping ratio.
    pub damping_bias: Option<f64>,
    /// Whether it is a mode and what its values are worth; `None` of a model.
    pub quality: Option<Quality>,
}

impl Mode {
    /// Uncertainty of the frequency, Hz: its standard deviation and the error that modes outside
    /// the band leave, `√(σ² + b²)`.
    pub fn frequency_uncertainty_hz(&self) -> Option<f64> {
        let bias = self.frequency_bias_hz.unwrap_or(0.0);
        self.frequency_std_hz.map(|std| std.hypot(bias))
    }

    /// Whether its quality is known and not good.
    pub fn is_doubtful(&self) -> bool {
        let quality = self.quality.as_ref();
        quality.is_some_and(|quality| quality.verdict != Grade::Good)
    }

    /// A mode with nothing known but its frequency, damping and shape.
    pub fn new(
        frequency_hz: f64,
        damping_ratio: Option<f64>,
        shape: ModeShape,
        scaling: Scaling,
    ) -> Self {
        Self {
            frequency_hz,
            damping_ratio,
            frequency_std_hz: None,
            damping_std: None,
            frequency_damping_correlation: None,
            group: None,
            shape,
            other_shapes: BTreeMap::new(),
            shape_std: None,
            residues: BTreeMap::new(),
            modal_mass_kg: None,
            scaling,
            mpc: None,
            method: None,
            order: None,
            mean_phase_rad: None,
            mean_phase_deviation_rad: None,
            modal_overlap: None,
            half_power_lines: None,
            frequency_bias_hz: None,
            damping_bias: None,
            quality: None,
        }
    }

    /// The pole, when the damping is known.
    pub fn pole(&self) -> Option<Pole> {
        self.damping_ratio
            .map(|zeta| Pole::from_frequency(self.frequency_hz, zeta))
    }
}

/// An input of a result, with its fingerprint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// Path as given.
    pub path: String,
    /// SHA-256 of its bytes, lower-case hexadecimal.
    pub sha256: String,
    /// Degrees of freedom that are in this one of several files alone.
    pub dofs: Vec<Dof>,
}

/// The modes of a test or of a model, ordered by frequency.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ModalModel {
    /// Program and version that made it.
    pub producer: String,
    /// Files it was made from.
    pub inputs: Vec<InputFile>,
    /// Band that was searched.
    pub band: Option<Band>,
    /// Reference (hit) degrees of freedom.
    pub references: Vec<Dof>,
    /// Decay rate of an exponential window that has been taken out of every pole, rad/s.
    pub added_damping_rad_s: Option<f64>,
    /// Modes in ascending frequency.
    pub modes: Vec<Mode>,
    /// Findings of the stages that made the model.
    pub findings: Vec<Finding>,
}

impl ModalModel {
    /// The modes by root: indices of the modes that share a group number, alone those without one;
    /// roots in ascending order of their first mode.
    pub fn roots(&self) -> Vec<Vec<usize>> {
        let mut roots: Vec<Vec<usize>> = Vec::new();
        let mut of_group: BTreeMap<u32, usize> = BTreeMap::new();
        for (index, mode) in self.modes.iter().enumerate() {
            let known = mode.group.and_then(|group| of_group.get(&group));
            match known {
                Some(&root) => roots[root].push(index),
                None => {
                    of_group.extend(mode.group.map(|group| (group, roots.len())));
                    roots.push(vec![index]);
                }
            }
        }
        roots
    }
}
