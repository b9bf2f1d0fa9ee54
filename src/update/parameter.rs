//! Free parameters have bounds, a prior, and the scale on which the solver works.

use crate::theory::{ParameterSpec, ParameterStatus, TheoreticalModel};

use super::{UpdateError, UpdateOptions};

/// Largest change of a value, as a part of it, in the first step of the linear model.
const MAX_FIRST_RELATIVE_CHANGE: f64 = 0.3;

/// Prior distribution of a parameter, around its initial value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// `ln p` is normal with this deviation: the parameter stays above 0.
    LogNormal {
        /// Deviation of the logarithm.
        std: f64,
    },
    /// `p` is normal with this deviation.
    Normal {
        /// In the parameter's unit.
        std: f64,
    },
}

/// A parameter as a user frees it.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ParameterChoice {
    /// Name in the model.
    pub name: String,
    /// `None` for the default: log-normal with the stated deviation where value and bounds are not
    /// below 0; a normal one with that part of the value otherwise; for a value of 0 a normal one
    /// with a quarter of the range between its bounds.
    pub prior: Option<Prior>,
    /// Deviation of the default prior, instead of the options'; a value of 0 has no use for it.
    pub prior_std: Option<f64>,
    /// Lower bound, instead of the model's.
    pub lower: Option<f64>,
    /// Upper bound, instead of the model's.
    pub upper: Option<f64>,
}

/// A parameter that updating may change. With `z` its distance from the start in prior deviations
/// `sigma`, its value is `p0 exp(sigma z)` (log-normal) or `p0 + sigma z` (normal).
#[derive(Clone, Debug, PartialEq)]
pub struct FreeParameter {
    /// Index in the model's list.
    pub index: usize,
    /// Name.
    pub name: String,
    /// The configuration that has it, where the first one does not.
    pub configuration: Option<String>,
    /// Unit.
    pub unit: String,
    /// Source of the model's value.
    pub status: ParameterStatus,
    /// Where it starts, which is the middle of the prior.
    pub initial: f64,
    /// Smallest value; minus infinity where there is none.
    pub lower: f64,
    /// Largest value; infinity where there is none.
    pub upper: f64,
    /// Prior.
    pub prior: Prior,
}

impl FreeParameter {
    /// The parameter of a model that a choice frees.
    pub(super) fn new(
        model: &dyn TheoreticalModel,
        values: &[f64],
        choice: &ParameterChoice,
        options: &UpdateOptions,
    ) -> Result<Self, UpdateError> {
        let specs = model.parameters();
        let named = specs.iter().position(|spec| spec.name == choice.name);
        let index = named.ok_or_else(|| unknown(specs, &choice.name, "there is none"))?;
        let (spec, initial) = (&specs[index], values[index]);
        if spec.whole {
            let reason = "a number of parts, which is not updated";
            return Err(unknown(specs, &choice.name, reason));
        }
        let model_lower = spec.lower.unwrap_or(f64::NEG_INFINITY);
        let model_upper = spec.upper.unwrap_or(f64::INFINITY);
        let lower = choice.lower.unwrap_or(model_lower).max(model_lower);
        let upper = choice.upper.unwrap_or(model_upper).min(model_upper);
        let name = spec.name.clone();
        if !(lower <= initial && initial <= upper && lower < upper) {
            return Err(UpdateError::Bounds {
                name,
                initial,
                lower,
                upper,
            });
        }
        let std = choice.prior_std.unwrap_or(options.prior_std);
        let default = default_prior(initial, lower, upper, std);
        let prior = choice.prior.or(default);
        let prior = prior.ok_or_else(|| UpdateError::NoPrior {
            name: name.clone(),
            initial,
        })?;
        let (std, needs_positive) = match prior {
            Prior::LogNormal { std } => (std, true),
            Prior::Normal { std } => (std, false),
        };
        if !(std.is_finite() && std > 0.0) || (needs_positive && initial <= 0.0) {
            return Err(UpdateError::PriorDeviation {
                name,
                got: std,
                initial,
            });
        }
        Ok(Self {
            index,
            name,
            configuration: None,
            unit: spec.unit.clone(),
            status: spec.status,
            initial,
            lower,
            upper,
            prior,
        })
    }

    /// The value at `z`, inside the bounds.
    pub fn value(&self, z: f64) -> f64 {
        let value = match self.prior {
            Prior::LogNormal { std } => self.initial * (std * z).exp(),
            Prior::Normal { std } => self.initial + std * z,
        };
        value.clamp(self.lower, self.upper)
    }

    /// `dp/dz` at a value.
    pub fn slope(&self, value: f64) -> f64 {
        match self.prior {
            Prior::LogNormal { std } => value * std,
            Prior::Normal { std } => std,
        }
    }

    /// `z` of a value; infinite where a log-normal prior does not allow it.
    pub fn z(&self, value: f64) -> f64 {
        match self.prior {
            Prior::LogNormal { std } => (value / self.initial).max(0.0).ln() / std,
            Prior::Normal { std } => (value - self.initial) / std,
        }
    }

    /// The bounds as `z`.
    pub fn bounds(&self) -> (f64, f64) {
        (self.z(self.lower), self.z(self.upper))
    }

    /// Prior deviation in the parameter's unit, of a log-normal one `p0 sigma`.
    pub fn prior_std(&self) -> f64 {
        self.slope(self.initial)
    }

    /// The step in `z` that the solver takes at first: a prior deviation, or less for a wide prior.
    pub(super) fn first_step(&self) -> f64 {
        match self.prior {
            Prior::LogNormal { std } => (MAX_FIRST_RELATIVE_CHANGE / std).min(1.0),
            Prior::Normal { std } if self.initial != 0.0 => {
                (MAX_FIRST_RELATIVE_CHANGE * self.initial.abs() / std).min(1.0)
            }
            Prior::Normal { .. } => 1.0,
        }
    }
}

/// The choices as free parameters, each once.
pub(super) fn free_parameters(
    model: &dyn TheoreticalModel,
    values: &[f64],
    choices: &[ParameterChoice],
    options: &UpdateOptions,
) -> Result<Vec<FreeParameter>, UpdateError> {
    let mut free: Vec<FreeParameter> = Vec::with_capacity(choices.len());
    for choice in choices {
        let parameter = FreeParameter::new(model, values, choice, options)?;
        if free.iter().any(|other| other.index == parameter.index) {
            return Err(unknown(model.parameters(), &parameter.name, "named twice"));
        }
        free.push(parameter);
    }
    if free.is_empty() {
        return Err(UpdateError::NothingFree);
    }
    Ok(free)
}

fn unknown(specs: &[ParameterSpec], name: &str, reason: &'static str) -> UpdateError {
    UpdateError::Parameter {
        name: name.to_owned(),
        reason,
        known: specs.iter().map(|spec| spec.name.clone()).collect(),
    }
}

fn default_prior(initial: f64, lower: f64, upper: f64, std: f64) -> Option<Prior> {
    let may_be_negative = lower.is_finite() && lower < 0.0;
    if initial > 0.0 && !may_be_negative {
        return Some(Prior::LogNormal { std });
    }
    if initial != 0.0 {
        let std = std * initial.abs();
        return Some(Prior::Normal { std });
    }
    let range = upper - lower;
    range
        .is_finite()
        .then_some(Prior::Normal { std: 0.25 * range })
}
