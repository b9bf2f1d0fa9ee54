//! Identifiability analysis finds the parameter combinations that the data determine: singular
//! values of the weighted sensitivity, posterior deviations, and a verdict for each parameter.
//!
//! With `J` the derivatives of the data's residuals by `z`, in which every prior deviation is 1,
//! the posterior covariance of `z` is `(J^T J + I)^-1 = V diag(1/(1 + s^2)) V^T` for `J = U diag(s)
//! V^T`. A combination `v^T z` of the parameters with singular value `s` is known to `1/sqrt(1 +
//! s^2)` of what was known before the test.
//!
//! # Reference
//! Tarantola (2005), Inverse Problem Theory, section 3.2.3 (posterior of a linearised problem);
//! Friswell and Mottershead (1995), Finite Element Model Updating in Structural Dynamics, chapter 8
//! (regularisation, parameter choice).

use serde::{Deserialize, Serialize};

use crate::linalg::{RealMatrix, real_matrix, right_singular_vectors, sort_descending_by};

use super::{FreeParameter, UpdateError};

/// Maximum posterior over prior deviation of a quantity that the data determine.
pub const MAX_POSTERIOR_OVER_PRIOR: f64 = 0.5;
/// Two-sided 95 % of a normal distribution.
pub(super) const TWO_SIDED_95: f64 = 1.959_963_984_540_054;
/// Smallest part of a combination that its text lists.
const MIN_LISTED_PART: f64 = 0.1;

/// What the data say about a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ParameterVerdict {
    /// Its posterior deviation is at most half of the prior one.
    #[serde(rename = "identified")]
    Identified,
    /// Noise does not explain the residuals, but each mode is predicted by the others within
    /// deviations that grow with the residuals; with these the deviation is at most half of the
    /// prior one.
    #[serde(rename = "identified within model error")]
    IdentifiedWithinModelError,
    /// Another optimum of about the same objective has another value.
    #[serde(rename = "ambiguous")]
    Ambiguous,
    /// The deviation is larger, or the modes contradict each other. A parameter that the test does
    /// not see keeps its value; one that the test sees only together with others follows their
    /// combination.
    #[serde(rename = "not supported by the data")]
    NotSupported,
    /// It ended at one of its bounds: the data require a value beyond.
    #[serde(rename = "at bound")]
    AtBound,
}

impl ParameterVerdict {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            ParameterVerdict::Identified => "identified",
            ParameterVerdict::IdentifiedWithinModelError => "identified within model error",
            ParameterVerdict::Ambiguous => "ambiguous",
            ParameterVerdict::NotSupported => "not supported by the data",
            ParameterVerdict::AtBound => "at bound",
        }
    }
}

/// A combination of the parameters that the data determine to a known degree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// Singular value of the weighted sensitivity: change of the residuals, in deviations of the
    /// data, when the combination changes by a prior deviation.
    pub singular_value: f64,
    /// Posterior over prior deviation, `1/sqrt(1 + s^2)`.
    pub posterior_over_prior: f64,
    /// Whether that is at most [`MAX_POSTERIOR_OVER_PRIOR`].
    pub known: bool,
    /// Parameters with their parts, largest first; the squares of all parts add up to 1, those
    /// below 0.1 are left out.
    pub parts: Vec<(String, f64)>,
    /// Description of the combination with its ratio.
    pub text: String,
}

/// Identifiable combinations and posterior deviations.
#[derive(Clone, Debug)]
pub struct Identifiability {
    /// Posterior covariance of `z`.
    pub covariance: RealMatrix,
    /// Posterior over prior deviation of each parameter.
    pub ratio: Vec<f64>,
    /// The same with all other parameters known.
    pub ratio_alone: Vec<f64>,
    /// All combinations, the best determined first.
    pub combinations: Vec<Combination>,
}

impl Identifiability {
    /// From the derivatives of the data's residuals alone, one column for each parameter.
    ///
    /// # Errors
    /// [`UpdateError::Linalg`].
    pub fn new(jacobian: &RealMatrix, free: &[FreeParameter]) -> Result<Self, UpdateError> {
        let (rows, n) = (jacobian.nrows(), free.len());
        // Rows of zeros make it tall, so that directions without any data have vectors, too.
        let tall = real_matrix(rows.max(n), n, |i, j| {
            if i < rows { jacobian[(i, j)] } else { 0.0 }
        });
        let (values, vectors) = right_singular_vectors(&tall)?;
        let left = |k: usize| 1.0 / (1.0 + values[k] * values[k]);
        let covariance = real_matrix(n, n, |i, j| {
            let parts = (0..n).map(|k| vectors[(i, k)] * left(k) * vectors[(j, k)]);
            parts.sum()
        });
        let pull = |j: usize| (0..rows).map(|i| jacobian[(i, j)].powi(2)).sum::<f64>();
        let combination = |k: usize| {
            let part = |j: usize| (free[j].name.clone(), vectors[(j, k)]);
            combination(values[k], (0..n).map(part).collect())
        };
        Ok(Self {
            ratio: (0..n).map(|j| covariance[(j, j)].sqrt()).collect(),
            ratio_alone: (0..n).map(|j| (1.0 + pull(j)).sqrt().recip()).collect(),
            combinations: (0..n).map(combination).collect(),
            covariance,
        })
    }

    /// Correlation of the posterior errors of two parameters.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        self.covariance[(i, j)] / (self.ratio[i] * self.ratio[j])
    }

    /// Whether the test sees a parameter: with all others known, the data determine it.
    pub fn seen(&self, j: usize) -> bool {
        self.ratio_alone[j] <= MAX_POSTERIOR_OVER_PRIOR
    }
}

fn combination(s: f64, mut parts: Vec<(String, f64)>) -> Combination {
    sort_descending_by(&mut parts, |part| part.1.abs());
    let sign = if parts[0].1 < 0.0 { -1.0 } else { 1.0 };
    parts.retain(|(_, part)| part.abs() >= MIN_LISTED_PART);
    parts.iter_mut().for_each(|(_, part)| *part *= sign);
    let ratio = 1.0 / (1.0 + s * s).sqrt();
    let known = ratio <= MAX_POSTERIOR_OVER_PRIOR;
    Combination {
        singular_value: s,
        posterior_over_prior: ratio,
        known,
        text: words(&parts, ratio, known),
        parts,
    }
}

fn words(parts: &[(String, f64)], ratio: f64, known: bool) -> String {
    let term = |(name, part): &(String, f64)| format!("{part:+.2} {name}");
    let sum: Vec<String> = parts.iter().map(term).collect();
    let verdict = if known {
        "determined"
    } else {
        "not determined by the data"
    };
    let subject = match parts {
        [(name, _)] => format!("{name} alone"),
        [(a, first), (b, second)] if (first.abs() - second.abs()).abs() < MIN_LISTED_PART => {
            if second * first > 0.0 {
                format!("{a} and {b} in the same direction ({})", sum.join(" "))
            } else {
                format!("{a} against {b} ({})", sum.join(" "))
            }
        }
        _ => sum.join(" "),
    };
    format!("{subject}: {verdict}, to {ratio:.3} of the prior deviations")
}
