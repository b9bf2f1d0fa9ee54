//! The options of a hammer test state its estimator, its window and its accepted hits.

use std::collections::BTreeSet;

use crate::signal::HitQualityLimits;

use super::EstimateOptions;

/// The exponential window on force and responses.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum ResponseWindow {
    /// None where the responses have decayed to 1 % when their records end; else one that falls to
    /// 1 %.
    #[default]
    Auto,
    /// None.
    Off,
    /// One that falls to this fraction at the end of the record.
    End(f64),
}

/// What excites the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Excitation {
    /// A hammer: each record is a hit.
    #[default]
    Hammer,
    /// A shaker with random noise, bursts of it, or sines: records are averaged in blocks.
    Shaker,
}

impl Excitation {
    /// The excitation of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "hammer" => Some(Self::Hammer),
            "random" | "sine" => Some(Self::Shaker),
            _ => None,
        }
    }
}

/// How a recorded test becomes FRFs.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct HammerOptions {
    /// Estimator, force window, offsets. Exponential window and cut are decided here.
    pub estimate: EstimateOptions,
    /// The exponential window.
    pub response_window: ResponseWindow,
    /// Whether what lies before each pulse is left out; with an exponential window alone when not
    /// stated.
    pub cut_pretrigger: Option<bool>,
    /// What excites the structure. Windows, cut, limits and numbers of hits are those of a hammer.
    pub excitation: Excitation,
    /// Length of the blocks of a shaker test, s; chosen for some sixteen blocks where not stated.
    pub block_length_s: Option<f64>,
    /// Limits of the rules.
    pub limits: HitQualityLimits,
    /// Numbers, from 1, of hits that are used whatever the rules say.
    pub accept: BTreeSet<usize>,
    /// Numbers, from 1, of hits that are not used whatever the rules say.
    pub reject: BTreeSet<usize>,
    /// Assess, but use every hit that `reject` does not name.
    pub keep_all: bool,
}
