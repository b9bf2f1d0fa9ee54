//! The history of an update records iterations, changes of pairing and the reason to stop.

use serde::{Deserialize, Serialize};

/// Why the iteration from a start ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// No step promises to lower the objective by more than rounding.
    NoDecrease,
    /// The steps that are still trusted have become as small as rounding.
    SmallStep,
    /// The test sees none of the free parameters: all are held where they were.
    NothingSeen,
    /// The stated number of iterations is reached; not converged.
    IterationLimit,
}

impl StopReason {
    /// In words.
    pub fn sentence(self) -> &'static str {
        match self {
            StopReason::NoDecrease => "Converged: no step lowers the objective",
            StopReason::SmallStep => "Converged: the steps have become as small as rounding",
            StopReason::NothingSeen => "Nothing changed: the test sees none of the free parameters",
            StopReason::IterationLimit => {
                "Not converged: the stated number of iterations is reached"
            }
        }
    }

    /// Whether the linear model finds no lower objective, or no parameter was to be changed.
    pub fn converged(self) -> bool {
        self != StopReason::IterationLimit
    }
}

/// One step of the solver.
#[derive(Clone, Debug, PartialEq)]
pub struct Iteration {
    /// Objective after it: data and prior.
    pub objective: f64,
    /// Part of the data in it.
    pub chi_square: f64,
    /// Values of the free parameters after it.
    pub values: Vec<f64>,
    /// Radius of the trust region of the next step, in first steps of each parameter.
    pub radius: f64,
    /// Whether the step was accepted; a rejected one changes nothing.
    pub accepted: bool,
}

/// A measured root whose partner in the model changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PairingChange {
    /// Label of the target.
    pub label: String,
    /// Number of iterations taken before.
    pub after_iterations: usize,
    /// Numbers, from 1, of the modes of the model before.
    pub from: Vec<usize>,
    /// Numbers after; empty when it lost its partner.
    pub to: Vec<usize>,
    /// Whether the modes changed their order while they were followed by shape; else test and model
    /// were paired again.
    pub followed: bool,
}
