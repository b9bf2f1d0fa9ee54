//! The mass line of a suspended test, with a stated mass, and the suspension against the first
//! elastic mode.

use crate::frf::rigid_body::{MassComparison, RigidBody};

/// The mass line of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct MassLineCheck {
    /// Its band, inertia, and the sensor that does not fit; `None` where no band has a mass line,
    /// or no more sensors are placed than the motions that they see.
    pub body: Option<RigidBody>,
    /// The stated mass, kg.
    pub stated_kg: Option<f64>,
}

impl MassLineCheck {
    /// The stated mass beside that of the mass line; `None` where one of both is not there.
    pub fn comparison(&self) -> Option<MassComparison> {
        let inertia = self.body.as_ref()?.inertia.as_ref().ok()?;
        Some(MassComparison::new(inertia, self.stated_kg?))
    }

    /// Whether sensors do not move as one rigid body, or a stated mass differs.
    pub fn is_wrong(&self) -> bool {
        let is_wrong = |body: &RigidBody| !body.is_rigid() || body.fault.is_some();
        self.body.as_ref().is_some_and(is_wrong)
            || self.comparison().is_some_and(|mass| mass.differs())
    }

    /// Whether the sensors were compared, and a stated mass with that of the mass line.
    pub fn is_tested(&self) -> bool {
        self.body.is_some() && (self.stated_kg.is_none() || self.comparison().is_some())
    }
}

/// A stated support.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportCheck {
    /// Its name.
    pub support: &'static str,
    /// Highest rigid-body mode on the suspension or the mounts as stated, Hz.
    pub rigid_body_hz: Option<f64>,
    /// Highest clear peak below the mass line, Hz, where no rigid-body mode is stated. It is no
    /// measurement of the highest one, which may have no clear peak.
    pub peak_below_hz: Option<f64>,
    /// First clear peak above, Hz.
    pub elastic_hz: Option<f64>,
    /// Largest ratio of rigid-body mode and first clear peak above; `None` for supports that belong
    /// to the structure.
    pub limit: Option<f64>,
}

impl SupportCheck {
    /// The highest rigid-body mode over the first clear peak above.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.rigid_body_hz? / self.elastic_hz?)
    }

    /// Whether the suspension is too stiff.
    pub fn is_stiff(&self) -> bool {
        let compared = self.ratio().zip(self.limit);
        compared.is_some_and(|(ratio, limit)| ratio > limit)
    }

    /// Whether the ratio is there, if it has a limit.
    pub fn is_tested(&self) -> bool {
        self.limit.is_none() || self.ratio().is_some()
    }
}
