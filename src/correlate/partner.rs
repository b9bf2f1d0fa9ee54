//! A pair joins a root of the theory with its test modes, each with a cost and a verdict.

use serde::{Deserialize, Serialize};

use super::chance::ChanceLevel;

/// Minimum contribution of the partners of a repeated root to each of its directions; that of
/// partners with similar shapes is smaller.
pub(super) const MIN_DIRECTION_CONTRIBUTION: f64 = 0.25;

/// Another partner of one side of a pair.
#[derive(Clone, Debug, PartialEq)]
pub enum Competitor {
    /// Another root of the theory, by the indices of its modes.
    Theory(Vec<usize>),
    /// Another mode of the test, by its index.
    Test(usize),
}

/// Judgement of a pair.
#[derive(Clone, Debug, PartialEq)]
pub enum PairVerdict {
    /// No other partner of either side fits as well.
    Paired,
    /// The MAC is below the chance level: independent shapes correlate as well.
    Uncorrelated {
        /// MAC of the pair.
        mac: f64,
        /// The chance level.
        level: ChanceLevel,
        /// MAC with the reversed sensors corrected, where that reaches the level.
        reversed: Option<f64>,
    },
    /// Sensors are reversed, and the MAC of the shapes as measured is below the gate: only with
    /// these sensors reversed is this a pair.
    RestsOnReversal {
        /// MAC of the shapes as measured.
        mac: f64,
        /// MAC with the reversed sensors corrected.
        reversed: Option<f64>,
    },
    /// A competitor costs at most the margin more.
    Ambiguous {
        /// The competitor of lowest cost.
        competitor: Competitor,
        /// Its cost minus the pair's; negative when the competitor alone is better and the
        /// assignment of all modes decided against it.
        cost_difference: f64,
    },
    /// Another root contributes half of the test shape or more, or the root as much of another test
    /// shape.
    ContestedShape {
        /// The competitor with the largest contribution.
        competitor: Competitor,
        /// Its contribution, or that of the root to it.
        contribution: f64,
    },
    /// The contribution of the root to the test shape, less its standard deviation, is too small.
    MixedShape {
        /// Contribution of the paired root.
        contribution: f64,
        /// Its standard deviation.
        std: f64,
    },
}

/// Evidence on which a pair rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// Frequency and shape.
    Shape,
    /// Frequency alone: fewer than three degrees of freedom are in common, or there are no shapes.
    Frequency,
}

/// A test mode as the partner of a root.
#[derive(Clone, Debug, PartialEq)]
pub struct Partner {
    /// Index of the test mode.
    pub test: usize,
    /// Signed frequency error, a fraction, by the options' reference.
    pub frequency_error: f64,
    /// MAC, for a repeated root that with its subspace; `None` when paired by frequency alone.
    pub mac: Option<f64>,
    /// Chance level of that MAC; `None` with fewer than three degrees of freedom in common.
    pub chance_level: Option<ChanceLevel>,
    /// Evidence on which the pair rests.
    pub basis: Basis,
    /// Cost of the pair, from 0 to 1.
    pub cost: f64,
    /// Verdict on the pair.
    pub verdict: PairVerdict,
}

/// A root of the theory with its partners.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Indices of the theory modes; several for a repeated root.
    pub theory: Vec<usize>,
    /// Its test modes in ascending index, from one to the multiplicity of the root.
    pub partners: Vec<Partner>,
    /// Principal angles between the test modes and the subspace of a repeated root, ascending,
    /// degrees; `None` for a simple root or without shapes.
    pub angles_deg: Option<Vec<f64>>,
    /// Contribution of several test modes to the direction of the root that they represent worst,
    /// where it is below a quarter (60 degrees): two of them may be one mode.
    pub weakest_direction: Option<f64>,
}

/// A test mode within the frequency gate that was rejected for its MAC.
#[derive(Clone, Debug, PartialEq)]
pub struct NearMiss {
    /// Index of the test mode.
    pub test: usize,
    /// Its MAC, below the gate.
    pub mac: f64,
}

/// A root of the theory without a partner.
#[derive(Clone, Debug, PartialEq)]
pub struct UnpairedRoot {
    /// Indices of the theory modes.
    pub theory: Vec<usize>,
    /// The test mode nearest in frequency, when it was rejected for its MAC.
    pub near_miss: Option<NearMiss>,
}
