//! The typed contents of a `model.toml`: what the user wrote, before it is a model.
//!
//! The `kind` key says which model it is; each kind has a struct, and a key that the kind
//! does not know is an error. Text is parsed elsewhere; nothing here is assembled.

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::faults::Faults;
use super::parameter::index_of;
use super::{ParameterSpec, ParameterStatus, Support, TheoryError};

/// The schema that this version reads.
pub const SCHEMA: &str = "modalign-model/1";

/// `kind = "beam"`, or a model with `[[beam]]`: one or more Euler-Bernoulli beams with point masses
/// and springs to ground. They do not touch one another.
///
/// ```
/// # use modalign::theory::{BeamFile, BeamModel, TheoreticalModel};
/// let text = r#"
/// schema = "modalign-model/1"
/// kind = "beam"
/// title = "Steel bar in soft slings"
///
/// [[parameter]]
/// name = "youngs_modulus"
/// unit = "Pa"
/// nominal = 2.1e11
/// lower = 1.9e11
/// upper = 2.2e11
/// status = "assumed"
///
/// [[beam]]
/// name = "bar"
/// from_m = [0.0, 0.0, 0.0]
/// to_m = [0.8, 0.0, 0.0]
/// deflection = [0.0, 0.0, 1.0]
/// elements = 16
/// start = "free"
/// end = "free"
/// youngs_modulus_pa = "youngs_modulus"
/// density_kg_per_m3 = 7850
/// area_m2 = 4e-4
/// second_moment_m4 = 1.333e-8
///
/// [[point_mass]]
/// name = "accelerometer"
/// beam = "bar"
/// at_m = [0.1, 0.0, 0.0]
/// mass_kg = 0.005
///
/// [[spring]]
/// name = "sling"
/// beam = "bar"
/// at_m = [0.2, 0.0, 0.0]
/// stiffness_n_per_m = 150.0
/// "#;
/// let model = BeamModel::new(toml::from_str::<BeamFile>(text).unwrap()).unwrap();
/// assert_eq!(model.name(), "Steel bar in soft slings");
/// assert_eq!(model.parameters().len(), 1);
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamFile {
    /// [`SCHEMA`].
    pub schema: String,
    /// `beam`, where it is stated.
    pub kind: Option<String>,
    /// Title of the model.
    pub title: String,
    /// How the structure is held; shown by the matrices where not stated.
    pub support: Option<Support>,
    /// Whether the values are those of an example; read by the stage that loads the model.
    #[serde(default)]
    pub example_values: bool,
    /// Parameters that values may name.
    #[serde(default, rename = "parameter")]
    pub parameters: Vec<ParameterSpec>,
    /// The beams.
    #[serde(rename = "beam")]
    pub beams: Vec<BeamDescription>,
    /// Masses fixed to beams.
    #[serde(default, rename = "point_mass")]
    pub point_masses: Vec<PointMassDescription>,
    /// Springs from beams to ground.
    #[serde(default, rename = "spring")]
    pub springs: Vec<SpringDescription>,
    /// Positions of the sensors of a test; read by the stage that solves the model at them.
    #[serde(default, rename = "sensor")]
    pub sensors: IgnoredAny,
}

/// A number, or the name of a parameter that holds it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "expected a number or the name of a parameter")]
pub enum Value {
    /// A fixed number.
    Number(f64),
    /// The name of a parameter.
    Parameter(String),
}

impl Value {
    /// The number itself, from the values of the parameters where it names one.
    pub(super) fn resolve(
        &self,
        used_by: &str,
        specs: &[ParameterSpec],
        values: &[f64],
    ) -> Result<f64, TheoryError> {
        match self {
            Value::Number(number) => Ok(*number),
            Value::Parameter(name) => Ok(values[index_of(used_by, specs, name)?]),
        }
    }
}

/// How an end of a beam is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// Not at all.
    Free,
    /// It may turn but not move.
    Pinned,
    /// It may neither turn nor move.
    Clamped,
}

/// A straight uniform beam that bends in one plane.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamDescription {
    /// Name, by which sensors, masses and springs find it.
    pub name: String,
    /// Start of its axis, m.
    pub from_m: [f64; 3],
    /// End of its axis, m.
    pub to_m: [f64; 3],
    /// Source of the two ends, and so of the length; printed where not stated.
    #[serde(default = "printed")]
    pub ends_status: ParameterStatus,
    /// Direction in which it deflects, at a right angle to the axis; of any length.
    pub deflection: [f64; 3],
    /// Number of equal elements, at least 1.
    pub elements: usize,
    /// How the start is held.
    pub start: End,
    /// How the end is held.
    pub end: End,
    /// Young's modulus, Pa.
    pub youngs_modulus_pa: Value,
    /// Density, kg/m³.
    pub density_kg_per_m3: Value,
    /// Area of the cross-section, m².
    pub area_m2: Value,
    /// Second moment of area for the plane of bending, m⁴.
    pub second_moment_m4: Value,
}

fn printed() -> ParameterStatus {
    ParameterStatus::Printed
}

impl BeamDescription {
    /// Name in messages.
    pub(super) fn label(&self) -> String {
        format!("beam `{}`", self.name)
    }
}

/// A mass on the axis of a beam.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointMassDescription {
    /// Name.
    pub name: String,
    /// The beam that carries it.
    pub beam: String,
    /// Where, m, in the model's frame; the foot of the perpendicular on the beam's axis counts.
    pub at_m: [f64; 3],
    /// Mass, kg.
    pub mass_kg: Value,
    /// Moment of inertia about its centre in the plane of bending, kg m².
    #[serde(default)]
    pub rotary_inertia_kg_m2: Option<Value>,
}

impl PointMassDescription {
    /// Name in messages.
    pub(super) fn label(&self) -> String {
        format!("point mass `{}`", self.name)
    }
}

/// A spring from the axis of a beam to ground: against deflection, against rotation, or both.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringDescription {
    /// Name.
    pub name: String,
    /// The beam that it holds.
    pub beam: String,
    /// Where, m, in the model's frame; the foot of the perpendicular on the beam's axis counts.
    pub at_m: [f64; 3],
    /// Stiffness along the deflection, N/m.
    #[serde(default)]
    pub stiffness_n_per_m: Option<Value>,
    /// Stiffness against rotation in the plane of bending, N m/rad.
    #[serde(default)]
    pub stiffness_nm_per_rad: Option<Value>,
}

impl SpringDescription {
    /// Name in messages.
    pub(super) fn label(&self) -> String {
        format!("spring `{}`", self.name)
    }
}

/// Every name once.
pub(super) fn distinct<'a>(
    what: &'static str,
    names: impl Iterator<Item = &'a String>,
) -> Result<(), TheoryError> {
    let mut seen = std::collections::BTreeSet::new();
    let mut faults = Faults::default();
    for name in names {
        if !seen.insert(name) {
            let name = name.clone();
            faults.add(TheoryError::Duplicate { what, name });
        }
    }
    faults.into_result()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::BeamModel;

    const BEAM: &str = r#"
        schema = "modalign-model/1"
        kind = "beam"
        title = "bar"
        [[beam]]
        name = "bar"
        from_m = [0, 0, 0]
        to_m = [1, 0, 0]
        deflection = [0, 0, 1]
        elements = 4
        start = "clamped"
        end = "free"
        youngs_modulus_pa = "E"
        density_kg_per_m3 = 7850
        area_m2 = 1e-4
        second_moment_m4 = 1e-9
    "#;

    #[test]
    fn whole_numbers_names_and_ends_are_read() {
        let file: BeamFile = toml::from_str(BEAM).unwrap();
        let beam = &file.beams[0];
        assert_eq!(beam.youngs_modulus_pa, Value::Parameter("E".to_owned()));
        assert_eq!(beam.density_kg_per_m3, Value::Number(7850.0));
        assert_eq!((beam.start, beam.end), (End::Clamped, End::Free));
        assert!(file.springs.is_empty());
    }

    #[test]
    fn unknown_keys_and_ends_are_refused_by_name() {
        for (from, to, name) in [
            ("area_m2", "aera_m2", "aera_m2"),
            ("title", "titel", "titel"),
            ("\"free\"", "\"loose\"", "loose"),
            ("7850", "true", "a number or the name of a parameter"),
        ] {
            let error = toml::from_str::<BeamFile>(&BEAM.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(name), "{error}");
        }
    }

    #[test]
    fn an_undeclared_parameter_is_named_with_its_user() {
        let error = BeamModel::new(toml::from_str(BEAM).unwrap()).unwrap_err();
        assert!(
            matches!(&error, TheoryError::UnknownParameter { got, used_by, .. } if got == "E" && used_by == "beam `bar`"),
            "{error}"
        );
    }
}
