//! The FRF set: functions on one frequency axis.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::finding::Finding;
use crate::quantity::FrfKind;

use super::Window;

/// Which FRF estimator made a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// Noise on the response alone.
    H1,
    /// Noise on the force alone.
    H2,
    /// Noise on both, in a stated ratio.
    Hv,
}

impl Estimator {
    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Estimator::H1 => "h1",
            Estimator::H2 => "h2",
            Estimator::Hv => "hv",
        }
    }

    /// The estimator of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Estimator::H1, Estimator::H2, Estimator::Hv]
            .into_iter()
            .find(|e| e.name() == name)
    }
}

/// The description of one function; its values are in the set.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Response degree of freedom, with the sensor's sign.
    pub response: Dof,
    /// Reference (hit) degree of freedom, with its sign.
    pub reference: Dof,
    /// Receptance, mobility or accelerance; values are in its SI unit.
    pub kind: FrfKind,
    /// Number of averages; `None` when the file does not say.
    pub averages: Option<u32>,
    /// Estimator; `None` when the file does not say.
    pub estimator: Option<Estimator>,
    /// Degrees of freedom of the variance: real numbers of which each line's is the mean square;
    /// `None` when it is not stated.
    pub variance_dof: Option<f64>,
}

/// Values of one function with coherence and variance, each of the length of the axis.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct FunctionData {
    /// Complex values in the SI unit of the kind.
    pub values: Vec<Complex64>,
    /// Ordinary coherence; `None` for one average or when the file does not hold it.
    pub coherence: Option<Vec<f64>>,
    /// Variance of the complex value, E|H − E H|², SI unit squared.
    pub variance: Option<Vec<f64>>,
}

/// A set that cannot take a function.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetError {
    /// A length that is not the axis's.
    #[error("{response}|{reference}: got {got} {what}, expected {expected} (the lines of the set)")]
    Length {
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
        /// Values, coherence or variance.
        what: &'static str,
        /// Got.
        got: usize,
        /// Expected.
        expected: usize,
    },
    /// A pair that is already there.
    #[error("{response}|{reference} is in the set twice; name repeated measurements #2, #3, ...")]
    Duplicate {
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
    },
}

/// FRFs on one frequency axis, values function-major with the lines of a function contiguous.
///
/// A missing (response, reference) pair is absent, never zero. Values may carry the decay of an
/// exponential window: then `H` was sampled at `s = iω + a`, `a` = [`FrfSet::added_damping_rad_s`].
#[derive(Clone, Debug, PartialEq)]
pub struct FrfSet {
    axis: FrequencyAxis,
    functions: Vec<Function>,
    pairs: BTreeSet<(Dof, Dof)>,
    /// Shared with copies of the set and with its receptances, until they change.
    values: Vec<Arc<Vec<Complex64>>>,
    coherence: Vec<Option<Vec<f64>>>,
    variance: Vec<Option<Vec<f64>>>,
    /// Decay rate of the exponential window still in the values, rad/s; 0 without one.
    pub added_damping_rad_s: f64,
    /// Window of all records; `None` where none is stated, or functions differ.
    pub window: Option<Window>,
    /// Windows that only some functions state, or in which they differ.
    pub mixed_windows: Vec<Window>,
    /// Whether the lines were interpolated from unevenly measured ones. Each variance is then that
    /// of a measured line times the lines per measured one: the lines are not independent.
    pub is_interpolated: bool,
    /// Length of the records that the functions came from, s; `None` when the file does not say.
    pub record_duration_s: Option<f64>,
    /// Where the force excites and the anti-alias filter is open; `None` when it is unknown.
    pub valid_band: Option<Band>,
    /// Where the force excites at all, up to half the sampling rate. Above the valid band the FRFs
    /// may be wrong (anti-alias filter).
    pub excited_band: Option<Band>,
    /// Multiple coherence of each response that was measured with several references: `Σ_j γ_j²
    /// Gxx_j / Σ_j Gxx_j`, the part of its power that all references together explain. Hits come
    /// one at a time, so that references never act together and their matrix of powers is diagonal
    /// (Bendat and Piersol 2010, section 7.3).
    pub multiple_coherence: BTreeMap<Dof, Vec<f64>>,
    /// Findings of the stages that made the set.
    pub findings: Vec<Finding>,
}

impl FrfSet {
    /// An empty set.
    pub fn new(axis: FrequencyAxis) -> Self {
        Self {
            axis,
            functions: Vec::new(),
            pairs: BTreeSet::new(),
            values: Vec::new(),
            coherence: Vec::new(),
            variance: Vec::new(),
            added_damping_rad_s: 0.0,
            window: None,
            mixed_windows: Vec::new(),
            is_interpolated: false,
            record_duration_s: None,
            valid_band: None,
            excited_band: None,
            multiple_coherence: BTreeMap::new(),
            findings: Vec::new(),
        }
    }

    /// Adds one function.
    ///
    /// # Errors
    /// [`SetError::Length`] when a vector has not the axis's length; [`SetError::Duplicate`] for a
    /// pair already there.
    pub fn push(&mut self, function: Function, data: FunctionData) -> Result<(), SetError> {
        let lengths = [
            ("values", Some(data.values.len())),
            ("coherence values", data.coherence.as_ref().map(Vec::len)),
            ("variances", data.variance.as_ref().map(Vec::len)),
        ];
        let (response, reference) = (function.response.clone(), function.reference.clone());
        for (what, got) in lengths
            .into_iter()
            .filter_map(|(what, got)| Some((what, got?)))
        {
            if got != self.axis.len {
                return Err(SetError::Length {
                    response,
                    reference,
                    what,
                    got,
                    expected: self.axis.len,
                });
            }
        }
        if !self.pairs.insert((response.clone(), reference.clone())) {
            return Err(SetError::Duplicate {
                response,
                reference,
            });
        }
        self.functions.push(function);
        self.values.push(Arc::new(data.values));
        self.coherence.push(data.coherence);
        self.variance.push(data.variance);
        Ok(())
    }

    /// The common axis.
    pub fn axis(&self) -> &FrequencyAxis {
        &self.axis
    }

    /// The functions in the order they were added.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// Values of function `i`, one per line.
    pub fn values(&self, i: usize) -> &[Complex64] {
        &self.values[i]
    }

    /// Values of function `i`, shared with the set.
    pub(crate) fn shared_values(&self, i: usize) -> Arc<Vec<Complex64>> {
        Arc::clone(&self.values[i])
    }

    /// Values of function `i`, to be replaced.
    pub(crate) fn values_mut(&mut self, i: usize) -> &mut [Complex64] {
        Arc::make_mut(&mut self.values[i]).as_mut_slice()
    }

    /// Coherence of function `i`.
    pub fn coherence(&self, i: usize) -> Option<&[f64]> {
        self.coherence[i].as_deref()
    }

    /// Variance of function `i`.
    pub fn variance(&self, i: usize) -> Option<&[f64]> {
        self.variance[i].as_deref()
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Whether there is no function.
    pub fn is_empty(&self) -> bool {
        self.functions.is_empty()
    }

    /// Some of its functions, by their indices, with the properties of the whole set.
    ///
    /// # Panics
    /// When an index is out of range or given twice.
    pub fn part(&self, functions: &[usize]) -> Self {
        let mut part = Self::new(self.axis);
        part.added_damping_rad_s = self.added_damping_rad_s;
        part.window = self.window;
        part.mixed_windows.clone_from(&self.mixed_windows);
        part.is_interpolated = self.is_interpolated;
        part.record_duration_s = self.record_duration_s;
        part.valid_band = self.valid_band;
        part.excited_band = self.excited_band;
        for &i in functions {
            let function = self.functions[i].clone();
            let pair = (function.response.clone(), function.reference.clone());
            assert!(part.pairs.insert(pair), "the functions of a set differ");
            part.functions.push(function);
            part.values.push(Arc::clone(&self.values[i]));
            part.coherence.push(self.coherence[i].clone());
            part.variance.push(self.variance[i].clone());
        }
        part
    }

    /// The functions whose response is a motion.
    pub(crate) fn motions(&self) -> Cow<'_, Self> {
        let is_motion = |i: &usize| self.functions[*i].kind.is_motion();
        let motions: Vec<usize> = (0..self.len()).filter(is_motion).collect();
        match motions.len() == self.len() {
            true => Cow::Borrowed(self),
            false => Cow::Owned(self.part(&motions)),
        }
    }

    /// The first lines of all functions, with the properties of the whole set.
    ///
    /// # Panics
    /// When there are fewer lines.
    pub(crate) fn first_lines(&self, len: usize) -> Self {
        let mut first = self.clone();
        first.axis.len = len;
        first
            .values
            .iter_mut()
            .for_each(|values| Arc::make_mut(values).truncate(len));
        let of_noise = first.coherence.iter_mut().chain(&mut first.variance);
        of_noise.flatten().for_each(|values| values.truncate(len));
        let coherences = first.multiple_coherence.values_mut();
        coherences.for_each(|values| values.truncate(len));
        assert!(len <= self.axis.len, "lines of the set");
        first
    }

    /// The set with every function times a real factor of its index.
    pub(crate) fn scaled(&self, factor: impl Fn(usize) -> f64) -> Self {
        let mut scaled = self.clone();
        for (i, values) in scaled.values.iter_mut().enumerate() {
            let factor = factor(i);
            let values = Arc::make_mut(values).iter_mut();
            values.for_each(|value| *value *= factor);
            let variance = scaled.variance[i].iter_mut().flatten();
            variance.for_each(|variance| *variance *= factor * factor);
        }
        scaled
    }

    /// Different reference degrees of freedom, in order.
    pub fn references(&self) -> Vec<Dof> {
        self.functions
            .iter()
            .map(|f| f.reference.clone())
            .collect::<std::collections::BTreeSet<_>>()
            .into_iter()
            .collect()
    }

    /// Different response degrees of freedom, in order.
    pub fn responses(&self) -> Vec<Dof> {
        self.functions
            .iter()
            .map(|f| f.response.clone())
            .collect::<std::collections::BTreeSet<_>>()
            .into_iter()
            .collect()
    }
}
