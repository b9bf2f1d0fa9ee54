//! Test geometry: nodes, trace lines, and sensors or hits on bodies of a model.

use std::collections::BTreeSet;

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
    /// Label of the coordinate system in which displacements at the node are given; `None` for the
    /// global frame.
    pub displacement_system: Option<i64>,
}

impl Node {
    /// A point whose displacements are in the global frame.
    pub fn new(point: impl Into<String>, at_m: Vector3) -> Self {
        Self {
            point: point.into(),
            at_m,
            displacement_system: None,
        }
    }
}

/// How coordinates of a local system are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SystemKind {
    /// x, y, z.
    Cartesian,
    /// r, θ, z.
    Cylindrical,
    /// r, θ (from the local z axis), φ (about it).
    Spherical,
}

impl SystemKind {
    /// Coordinates x, y, z of a point in the local axes; lengths in m, angles in rad.
    ///
    /// Cylindrical: (r cos θ, r sin θ, z). Spherical: (r sin θ cos φ, r sin θ sin φ, r cos θ).
    fn cartesian(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self {
            SystemKind::Cartesian => [a, b, c],
            SystemKind::Cylindrical => [a * b.cos(), a * b.sin(), c],
            SystemKind::Spherical => {
                let rho = a * b.sin();
                [rho * c.cos(), rho * c.sin(), a * b.cos()]
            }
        }
    }
}

/// A local coordinate system.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinateSystem {
    /// Its number.
    pub label: i64,
    /// Its name, may be empty.
    pub name: String,
    /// How its coordinates are counted.
    pub kind: SystemKind,
    /// Its origin in the global frame, m.
    pub origin_m: Vector3,
    /// Unit vectors of its x, y and z axes in the global frame.
    pub axes: [Vector3; 3],
}

/// A point that is nearer to the axis of its system than this part of its coordinates is on the
/// axis.
const ON_AXIS: f64 = 1e-12;

impl CoordinateSystem {
    /// Position in the global frame, m, of a point given in this system: x, y, z or r, θ, z or r,
    /// θ, φ with lengths in m and angles in rad.
    ///
    /// ```
    /// use modalign::geometry::{CoordinateSystem, SystemKind};
    /// use modalign::linalg::Vector3;
    /// let system = CoordinateSystem {
    ///     label: 7,
    ///     name: String::new(),
    ///     kind: SystemKind::Cylindrical,
    ///     origin_m: Vector3::new(1.0, 0.0, 0.0),
    ///     axes: [Vector3::x(), Vector3::y(), Vector3::z()],
    /// };
    /// let at_m = system.global_position([2.0, std::f64::consts::FRAC_PI_2, 3.0]);
    /// assert!((at_m - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
    /// ```
    pub fn global_position(&self, local: [f64; 3]) -> Vector3 {
        let [x, y, z] = self.kind.cartesian(local);
        let [along_x, along_y, along_z] = &self.axes;
        self.origin_m + along_x * x + along_y * y + along_z * z
    }

    /// Unit vectors, in the global frame, of the directions in which displacements at a point are
    /// counted: the axes of a Cartesian system, e_r, e_θ, e_z of a cylindrical and e_r, e_θ, e_φ of
    /// a spherical one. On the axis, where θ (or φ) is not defined, it is 0.
    pub fn unit_vectors_at(&self, point_m: Vector3) -> [Vector3; 3] {
        let [along_x, along_y, along_z] = self.axes;
        let from_origin = point_m - self.origin_m;
        let (x, y) = (from_origin.dot(&along_x), from_origin.dot(&along_y));
        let (z, rho) = (from_origin.dot(&along_z), x.hypot(y));
        let (cosine, sine) = if rho > ON_AXIS * (from_origin.norm() + self.origin_m.norm()) {
            (x / rho, y / rho)
        } else {
            (1.0, 0.0)
        };
        let outward = along_x * cosine + along_y * sine;
        let around = along_y * cosine - along_x * sine;
        match self.kind {
            SystemKind::Cartesian => self.axes,
            SystemKind::Cylindrical => [outward, around, along_z],
            SystemKind::Spherical => {
                let polar = rho.atan2(z);
                let (sine, cosine) = polar.sin_cos();
                [
                    outward * sine + along_z * cosine,
                    outward * cosine - along_z * sine,
                    around,
                ]
            }
        }
    }

    /// Whether displacements in this system are displacements in the global frame: Cartesian along
    /// the global axes.
    pub fn is_aligned(&self) -> bool {
        let global = [Vector3::x(), Vector3::y(), Vector3::z()];
        self.kind == SystemKind::Cartesian && self.axes == global
    }
}

/// A finite element, for drawing and for what is written again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    /// Its number.
    pub label: i64,
    /// Descriptor of universal file dataset 2412 (11 rod, 21 beam, 41 triangle, 44 quadrilateral,
    /// 111 tetrahedron, ...).
    pub descriptor: i64,
    /// Points.
    pub points: Vec<String>,
}

/// A named set of points or elements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Its number.
    pub label: i64,
    /// Its name.
    pub name: String,
    /// Entity type of universal file dataset 2467 (7 node, 8 element, ...) and label of each
    /// member.
    pub members: Vec<(i64, i64)>,
}

/// Lines between points, for drawing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct TraceLine {
    /// Name, may be empty.
    pub name: String,
    /// Points in drawing order; `None` lifts the pen.
    pub points: Vec<Option<String>>,
}

/// What describes the points of a test.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Geometry {
    /// Nodes in file order.
    pub nodes: Vec<Node>,
    /// Trace lines in file order.
    pub lines: Vec<TraceLine>,
    /// Local coordinate systems in file order.
    pub systems: Vec<CoordinateSystem>,
    /// Elements in file order.
    pub elements: Vec<Element>,
    /// Groups in file order.
    pub groups: Vec<Group>,
}

impl Geometry {
    /// The node of a point.
    pub fn node(&self, point: &str) -> Option<&Node> {
        self.nodes.iter().find(|node| node.point == point)
    }

    /// Adds another geometry. A node, coordinate system, element or group that is there already (by
    /// its name or number), or an equal trace line, is not repeated.
    pub fn add(&mut self, other: &Geometry) {
        add_new(&mut self.nodes, &other.nodes, |node| node.point.clone());
        add_new(&mut self.systems, &other.systems, |system| system.label);
        add_new(&mut self.elements, &other.elements, |element| element.label);
        add_new(&mut self.groups, &other.groups, |group| group.label);
        add_new(&mut self.lines, &other.lines, TraceLine::clone);
    }

    /// Number of nodes, trace lines, coordinate systems, elements and groups together.
    pub fn len(&self) -> usize {
        let drawn = self.nodes.len() + self.lines.len() + self.elements.len();
        drawn + self.systems.len() + self.groups.len()
    }

    /// Whether nothing is described.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The local coordinate system of this label.
    pub fn system(&self, label: i64) -> Option<&CoordinateSystem> {
        self.systems.iter().find(|system| system.label == label)
    }
}

fn add_new<T: Clone, K: Ord>(all: &mut Vec<T>, other: &[T], key: impl Fn(&T) -> K) {
    let known: BTreeSet<K> = all.iter().map(&key).collect();
    let new = other.iter().filter(|item| !known.contains(&key(item)));
    all.extend(new.cloned());
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

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4, FRAC_PI_6};

    use super::*;

    /// Local x is global y, local y is global z, local z is global x.
    fn system(kind: SystemKind) -> CoordinateSystem {
        CoordinateSystem {
            label: 5,
            name: "turned".to_owned(),
            kind,
            origin_m: Vector3::new(10.0, 20.0, 30.0),
            axes: [Vector3::y(), Vector3::z(), Vector3::x()],
        }
    }

    fn near(got: Vector3, expected: [f64; 3]) {
        let distance = (got - Vector3::from(expected)).norm();
        assert!(distance < 1e-14, "{got:?} instead of {expected:?}");
    }

    #[test]
    fn positions_follow_the_kind_of_the_system() {
        near(
            system(SystemKind::Cartesian).global_position([1.0, 2.0, 3.0]),
            [13.0, 21.0, 32.0],
        );
        near(
            system(SystemKind::Cylindrical).global_position([2.0, FRAC_PI_6, 3.0]),
            [13.0, 20.0 + 3f64.sqrt(), 31.0],
        );
        near(
            system(SystemKind::Spherical).global_position([4.0, FRAC_PI_3, FRAC_PI_4]),
            [12.0, 20.0 + 6f64.sqrt(), 30.0 + 6f64.sqrt()],
        );
    }

    #[test]
    fn unit_vectors_are_the_derivatives_of_the_position() {
        let local = [2.0, 0.8, 0.6];
        for kind in [
            SystemKind::Cartesian,
            SystemKind::Cylindrical,
            SystemKind::Spherical,
        ] {
            let system = system(kind);
            let at = system.global_position(local);
            for (i, unit) in system.unit_vectors_at(at).into_iter().enumerate() {
                let step = 1e-6;
                let (mut behind, mut before) = (local, local);
                behind[i] -= step;
                before[i] += step;
                let change = system.global_position(before) - system.global_position(behind);
                assert!((unit - change.normalize()).norm() < 1e-9, "{kind:?} {i}");
                assert!((unit.norm() - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn on_the_axis_the_angle_is_zero() {
        let on_axis = Vector3::new(13.0, 20.0, 30.0);
        let [r, theta, z] = system(SystemKind::Cylindrical).unit_vectors_at(on_axis);
        near(r, [0.0, 1.0, 0.0]);
        near(theta, [0.0, 0.0, 1.0]);
        near(z, [1.0, 0.0, 0.0]);
        let [r, theta, phi] = system(SystemKind::Spherical).unit_vectors_at(on_axis);
        near(r, [1.0, 0.0, 0.0]);
        near(theta, [0.0, 1.0, 0.0]);
        near(phi, [0.0, 0.0, 1.0]);
        let below = system(SystemKind::Spherical).global_position([
            1.0,
            std::f64::consts::PI - 1e-3,
            FRAC_PI_2,
        ]);
        let [r, _, phi] = system(SystemKind::Spherical).unit_vectors_at(below);
        assert!(r.x < -0.99 && (phi - Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn only_a_cartesian_system_along_the_global_axes_is_aligned() {
        let mut plain = system(SystemKind::Cartesian);
        assert!(!plain.is_aligned());
        plain.axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        assert!(plain.is_aligned());
        plain.kind = SystemKind::Cylindrical;
        assert!(!plain.is_aligned());
    }
}
