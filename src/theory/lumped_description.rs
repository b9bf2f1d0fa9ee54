//! The typed contents of a lumped `model.toml`: rigid bodies, points on them, springs between
//! points.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::dof::Axis;

use super::description::Value;
use super::{ParameterSpec, Support};

/// `kind = "lumped"`, which is what a model without a `kind` is: rigid bodies on massless springs.
///
/// ```
/// # use modalign::theory::{LumpedFile, LumpedModel, TheoreticalModel};
/// let text = r#"
/// title = "Disc on a flexible support"
///
/// [[parameter]]
/// name = "support"
/// unit = "N/m"
/// nominal = 2e6
/// lower = 1e6
/// upper = 4e6
/// status = "assumed"
///
/// [[body]]
/// name = "disc"
/// mass_kg = 1.5
/// inertia_kg_m2 = 2e-3
/// free = ["x", "y", "rz"]
///
/// [[point]]
/// name = "rim"
/// body = "disc"
/// at_m = [0.05, 0.0, 0.0]
///
/// [[spring]]
/// name = "support"
/// from = "rim"
/// to = "ground"
/// direction = [0.0, 1.0, 0.0]
/// parameter = "support"
/// "#;
/// let model = LumpedModel::new(toml::from_str::<LumpedFile>(text).unwrap()).unwrap();
/// let matrices = model.assemble(&[2e6]).unwrap();
/// assert_eq!(matrices.coordinates[2].name, "disc.rz");
/// assert!((matrices.stiffness[(1, 2)] - 2e6 * 0.05).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LumpedFile {
    /// [`super::SCHEMA`], where it is stated.
    pub schema: Option<String>,
    /// `lumped`, where it is stated.
    pub kind: Option<String>,
    /// Title of the model.
    #[serde(default = "untitled")]
    pub title: String,
    /// How the structure is held; shown by the matrices where not stated.
    pub support: Option<Support>,
    /// Whether the values are those of an example; read by the stage that loads the model.
    #[serde(default)]
    pub example_values: bool,
    /// Parameters that values may name.
    #[serde(default, rename = "parameter")]
    pub parameters: Vec<ParameterSpec>,
    /// The bodies.
    #[serde(rename = "body")]
    pub bodies: Vec<BodyDescription>,
    /// Points on bodies, at which springs end.
    #[serde(default, rename = "point")]
    pub points: Vec<PointDescription>,
    /// The springs.
    #[serde(default, rename = "spring")]
    pub springs: Vec<LinkDescription>,
    /// Positions of the sensors of a test; read by the stage that solves the model at them.
    #[serde(default, rename = "sensor")]
    pub sensors: IgnoredAny,
}

fn untitled() -> String {
    "lumped model".to_owned()
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyDescription {
    /// Name, by which points and sensors find it.
    pub name: String,
    /// Centre of mass, m, in the model's frame; the origin when not stated.
    #[serde(default)]
    pub at_m: [f64; 3],
    /// Mass, kg; needed when the body may be displaced.
    pub mass_kg: Option<Value>,
    /// Moment of inertia about its centre, kg m²: one number for every axis about which it may
    /// turn, or three.
    pub inertia_kg_m2: Option<Inertia>,
    /// How it may move: `x`, `y`, `z`, `rx`, `ry`, `rz`. A body with an empty list is held.
    pub free: Vec<Free>,
}

impl BodyDescription {
    /// Name in messages.
    pub(super) fn label(&self) -> String {
        format!("body `{}`", self.name)
    }
}

/// Moments of inertia about axes of the model's frame, which are taken for the principal ones.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, the name of a parameter, or three of them"
)]
pub enum Inertia {
    /// The same about every axis.
    One(Value),
    /// About x, y and z.
    Three([Value; 3]),
}

/// One way in which a body may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Free {
    /// Displacement along x.
    X,
    /// Displacement along y.
    Y,
    /// Displacement along z.
    Z,
    /// Rotation about x.
    Rx,
    /// Rotation about y.
    Ry,
    /// Rotation about z.
    Rz,
}

impl Free {
    /// The axis of a degree of freedom.
    pub(super) fn axis(self) -> Axis {
        match self {
            Free::X => Axis::X,
            Free::Y => Axis::Y,
            Free::Z => Axis::Z,
            Free::Rx => Axis::RX,
            Free::Ry => Axis::RY,
            Free::Rz => Axis::RZ,
        }
    }

    /// As written in the file.
    pub(super) fn name(self) -> &'static str {
        match self {
            Free::X => "x",
            Free::Y => "y",
            Free::Z => "z",
            Free::Rx => "rx",
            Free::Ry => "ry",
            Free::Rz => "rz",
        }
    }
}

/// A point of a body.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointDescription {
    /// Name, by which springs find it.
    pub name: String,
    /// The body.
    pub body: String,
    /// Where, m, in the model's frame.
    pub at_m: [f64; 3],
}

/// A massless spring between two points, or from a point to ground.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkDescription {
    /// Name.
    pub name: String,
    /// A point.
    pub from: String,
    /// A point, or `ground`.
    pub to: String,
    /// Direction in which it acts, or the axis against rotation about which it acts; of any length.
    /// The line between the two points when not stated.
    pub direction: Option<[f64; 3]>,
    /// Stiffness along the direction, N/m.
    pub stiffness_n_per_m: Option<Value>,
    /// Stiffness against rotation about the direction, N m/rad.
    pub stiffness_nm_per_rad: Option<Value>,
    /// The parameter that is its stiffness along the direction, N/m.
    pub parameter: Option<String>,
}

impl LinkDescription {
    /// Name in messages.
    pub(super) fn label(&self) -> String {
        format!("spring `{}`", self.name)
    }
}
