//! Test geometry: nodes, trace lines, and sensors or hits on bodies of a model.

use serde::{Deserialize, Serialize};

use crate::dof::Dof;
use crate::linalg::Vector3;

/// A measurement point.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Point name as in [`Dof::point`].
    pub point: String,
    /// Position in the global frame, m.
    pub at_m: Vector3,
}

/// Lines between points, for drawing.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TraceLine {
    /// Name, may be empty.
    pub name: String,
    /// Points in drawing order; `None` lifts the pen.
    pub points: Vec<Option<String>>,
}

/// Nodes and trace lines of a test.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Geometry {
    /// Nodes in file order.
    pub nodes: Vec<Node>,
    /// Trace lines in file order.
    pub lines: Vec<TraceLine>,
}

impl Geometry {
    /// The node of a point.
    pub fn node(&self, point: &str) -> Option<&Node> {
        self.nodes.iter().find(|node| node.point == point)
    }
}

/// What a sensor reads or a hit drives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    /// A point of a body, along a direction that need not have unit length when given.
    BodyPoint {
        /// Name of the body in the model.
        body: String,
        /// Position in the model's frame, m.
        at_m: [f64; 3],
        /// Direction of positive reading of the axis, before the sign of the [`Dof`].
        direction: [f64; 3],
    },
    /// One generalised coordinate of the model, by name.
    Coordinate(String),
}

/// Ties a test's degree of freedom to a model: the same for sensors and for hits.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// The degree of freedom as the test names it, on its positive axis.
    pub dof: Dof,
    /// What it reads.
    pub target: Target,
}

/// Unit vector along a direction; `None` for the zero vector.
///
/// ```
/// let unit = modalign::geometry::unit([0.0, 0.0, -2.0]).unwrap();
/// assert_eq!((unit.x, unit.y, unit.z), (0.0, 0.0, -1.0));
/// ```
pub fn unit(direction: [f64; 3]) -> Option<Vector3> {
    Vector3::from(direction).try_normalize(0.0)
}
