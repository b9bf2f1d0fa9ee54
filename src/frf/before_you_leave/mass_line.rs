//! The mass line of a suspended test, with a stated mass, and the suspension against the first
//! elastic mode.

use crate::frf::rigid_body::{MassComparison, RigidBody};

/// The mass line of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct MassLineCheck {
    /// Its band, inertia, and the sensor that does not fit.
    pub body: RigidBody,
    /// A stated mass beside that of the mass line; `None` where one of both is not there.
    pub mass: Option<MassComparison>,
}

impl MassLineCheck {
    /// Whether all sensors fit and no stated mass differs.
    pub fn is_right(&self) -> bool {
        self.body.fault.is_none() && !self.mass.is_some_and(|mass| mass.differs())
    }
}

/// A stated support.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportCheck {
    /// Its name.
    pub support: &'static str,
    /// Highest rigid-body mode on the suspension, Hz.
    pub rigid_body_hz: Option<f64>,
    /// First elastic mode, Hz.
    pub elastic_hz: Option<f64>,
    /// Largest ratio of both; `None` for supports that belong to the structure.
    pub limit: Option<f64>,
}

impl SupportCheck {
    /// The highest rigid-body mode over the first elastic one.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.rigid_body_hz? / self.elastic_hz?)
    }

    /// Whether the suspension is too stiff.
    pub fn is_stiff(&self) -> bool {
        let compared = self.ratio().zip(self.limit);
        compared.is_some_and(|(ratio, limit)| ratio > limit)
    }

    /// Whether what has a limit has a ratio.
    pub fn is_tested(&self) -> bool {
        self.limit.is_none() || self.ratio().is_some()
    }
}
