//! Time histories: channels that were sampled together.

use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::quantity::Quantity;

/// What a channel is in a hammer test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// The hammer's force.
    Force,
    /// A response.
    Response,
}

/// Samples as they were stored: single precision stays single until it is transformed.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Samples::F32(values) => values.len(),
            Samples::F64(values) => values.len(),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples in double precision, in order.
    pub fn iter(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Samples::F32(values) => Box::new(values.iter().map(|v| f64::from(*v))),
            Samples::F64(values) => Box::new(values.iter().copied()),
        }
    }

    /// The samples as a new vector of doubles.
    pub fn to_f64(&self) -> Vec<f64> {
        self.iter().collect()
    }
}

/// One channel of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What it is in the test.
    pub role: Role,
    /// Where it measures: for a force, the hit point.
    pub dof: Dof,
    /// What it measures.
    pub quantity: Quantity,
    /// SI value = `to_si` × sample.
    pub to_si: f64,
    /// Samples as stored.
    pub samples: Samples,
}

impl Channel {
    /// The samples in SI units.
    pub fn si(&self) -> Vec<f64> {
        self.samples.iter().map(|v| v * self.to_si).collect()
    }
}

/// One hit: a force and the responses that were sampled with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// Common time axis.
    pub axis: TimeAxis,
    /// The force; its `dof` is the hit point.
    pub force: Channel,
    /// Responses, in file order.
    pub responses: Vec<Channel>,
    /// Where it came from (file and record), for messages.
    pub origin: String,
}
