//! What would make a sensor fit the motion of a rigid body.

use std::fmt;

use crate::dof::Dof;

/// The one change of the test's description that makes all sensors fit.
#[derive(Clone, Debug, PartialEq)]
pub enum Repair {
    /// The sensor reads with the other sign.
    Sign(Dof),
    /// What the sensor reads is this many times what it should.
    Gain {
        /// The sensor.
        dof: Dof,
        /// What it reads over what it should.
        gain: f64,
        /// Its standard deviation.
        std: f64,
    },
    /// The sensor points along another axis.
    Direction {
        /// The sensor.
        dof: Dof,
        /// Unit direction that fits.
        direction: [f64; 3],
    },
    /// Two sensors have each other's place.
    Exchanged(Dof, Dof),
    /// No sign, gain or axis makes the sensor fit.
    LeftOut(Dof),
}

impl Repair {
    /// The sensor, the first of two exchanged ones.
    pub fn dof(&self) -> &Dof {
        match self {
            Repair::Sign(dof) | Repair::LeftOut(dof) | Repair::Exchanged(dof, _) => dof,
            Repair::Gain { dof, .. } | Repair::Direction { dof, .. } => dof,
        }
    }

    /// All sensors that it changes.
    pub fn sensors(&self) -> Vec<&Dof> {
        match self {
            Repair::Exchanged(one, other) => vec![one, other],
            _ => vec![self.dof()],
        }
    }

    /// What was done before a mass was computed.
    pub fn precaution(&self) -> String {
        match self {
            Repair::LeftOut(dof) => format!("with {dof} left out"),
            Repair::Exchanged(one, other) => format!("with {one} and {other} repaired"),
            _ => format!("with {} repaired", self.dof()),
        }
    }
}

/// Free fall in m/s², the ratio of the two usual units of acceleration.
const FREE_FALL: f64 = 9.806_65;
/// Relative distance of a gain from that ratio within which it is named.
const NEAR: f64 = 0.03;

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Repair::Sign(_) => f.write_str("it fits with the other sign"),
            Repair::Gain { gain, std, .. } => {
                let is_near = |ratio: f64| (gain / ratio - 1.0).abs() < NEAR;
                let cause = match (is_near(FREE_FALL), is_near(FREE_FALL.recip())) {
                    (true, _) => ": m/s2 taken for g",
                    (_, true) => ": g taken for m/s2",
                    _ => "",
                };
                write!(
                    f,
                    "it reads {gain:.4} ± {std:.4} times what it should{cause}"
                )
            }
            Repair::Direction {
                direction: [x, y, z],
                ..
            } => write!(f, "it fits along ({x}, {y}, {z})"),
            Repair::Exchanged(one, other) => {
                write!(f, "{one} and {other} fit in each other's place")
            }
            Repair::LeftOut(_) => f.write_str("no sign, gain or axis makes it fit"),
        }
    }
}
