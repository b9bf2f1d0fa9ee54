//! Energies, sensitivities and further quantities of a model are added to an existing JSON object
//! under the key `theory`.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use serde::Serialize;

use crate::axis::Band;
use crate::theory::{ModelQuantity, ModelRoot, ParameterSpec, ParameterStatus, RootSensitivity};

use super::schema::json_text;

/// The requested results, without roots outside the band.
#[derive(Clone, Debug, Default)]
pub struct TheoryResults<'a> {
    /// Parameters with their values.
    pub parameters: &'a [(ParameterSpec, f64)],
    /// The band of the roots that are written.
    pub band: Option<Band>,
    /// Roots with their energies.
    pub energies: Option<&'a [ModelRoot]>,
    /// Roots with their sensitivities.
    pub sensitivities: Option<Vec<RootSensitivity>>,
    /// Further quantities of the theory.
    pub quantities: Option<Vec<ModelQuantity>>,
}

impl TheoryResults<'_> {
    /// Whether nothing was requested.
    pub fn is_empty(&self) -> bool {
        self.energies.is_none() && self.sensitivities.is_none() && self.quantities.is_none()
    }
}

#[derive(Serialize)]
struct TheoryFile<'a> {
    theory: PartFile<'a>,
}

#[derive(Serialize)]
struct PartFile<'a> {
    parameters: Vec<ParameterFile<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    energies: Option<Vec<EnergyFile<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivities: Option<Vec<SensitivityFile<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quantities: Option<Vec<QuantityFile<'a>>>,
}

#[derive(Serialize)]
struct ParameterFile<'a> {
    name: &'a str,
    unit: &'a str,
    value: f64,
    status: ParameterStatus,
}

#[derive(Serialize)]
struct EnergyFile<'a> {
    frequency_hz: f64,
    multiplicity: usize,
    class: Option<&'a str>,
    /// Share by body.
    kinetic: BTreeMap<&'a str, f64>,
    /// Share by spring, or by group of matrices.
    strain: BTreeMap<&'a str, f64>,
}

#[derive(Serialize)]
struct SensitivityFile<'a> {
    frequency_hz: f64,
    /// By parameter; null for a number of parts.
    by: BTreeMap<&'a str, Option<SlopeFile<'a>>>,
}

#[derive(Serialize)]
struct SlopeFile<'a> {
    /// `(df/f)/(dp/p)`; null for a root or a value at 0.
    relative: Option<f64>,
    /// Derivative of omega² by the parameter, (rad/s)² per unit, of each branch.
    branches_rad2_s2: &'a [f64],
}

#[derive(Serialize)]
struct QuantityFile<'a> {
    name: &'a str,
    value: Option<f64>,
    unit: &'a str,
    meaning: &'a str,
}

/// The text of a JSON object with the key `theory` appended, ending in a newline; its other keys
/// are unchanged.
pub fn with_theory(json: &str, part: &TheoryResults<'_>) -> String {
    let object = json_text(&file(part));
    let head = json.trim_end();
    let head = head.strip_suffix('}').unwrap_or(head).trim_end();
    let tail = object.strip_prefix('{').unwrap_or(&object);
    format!("{head},{tail}")
}

fn file<'a>(part: &'a TheoryResults<'_>) -> TheoryFile<'a> {
    let parameters = part.parameters.iter().map(|(spec, value)| ParameterFile {
        name: &spec.name,
        unit: &spec.unit,
        value: *value,
        status: spec.status,
    });
    let inside = |omega: f64| part.band.is_none_or(|band| band.contains(omega / TAU));
    let energies = part.energies.map(|roots| {
        let roots = roots.iter().filter(|root| inside(root.omega_rad_s));
        roots.map(energy).collect()
    });
    let sensitivities = part.sensitivities.as_ref().map(|roots| {
        let roots = roots.iter().filter(|root| inside(root.omega_rad_s));
        roots.map(|root| sensitivity(part, root)).collect()
    });
    let quantities = part.quantities.as_ref();
    TheoryFile {
        theory: PartFile {
            parameters: parameters.collect(),
            energies,
            sensitivities,
            quantities: quantities.map(|all| all.iter().map(quantity).collect()),
        },
    }
}

fn energy(root: &ModelRoot) -> EnergyFile<'_> {
    EnergyFile {
        frequency_hz: root.omega_rad_s / TAU,
        multiplicity: root.modes.len(),
        class: root.class.as_deref(),
        kinetic: by_name(&root.kinetic_energy),
        strain: by_name(&root.strain_energy),
    }
}

fn by_name(shares: &[(String, f64)]) -> BTreeMap<&str, f64> {
    let pairs = shares.iter();
    pairs.map(|(name, share)| (name.as_str(), *share)).collect()
}

fn sensitivity<'a>(part: &'a TheoryResults<'_>, root: &'a RootSensitivity) -> SensitivityFile<'a> {
    let slope = |(j, (spec, value)): (usize, &'a (ParameterSpec, f64))| {
        let derivatives = (!spec.whole).then(|| SlopeFile {
            relative: root.scaled(j, *value).filter(|_| value.abs() > 0.0),
            branches_rad2_s2: &root.branches[j],
        });
        (spec.name.as_str(), derivatives)
    };
    SensitivityFile {
        frequency_hz: root.omega_rad_s / TAU,
        by: part.parameters.iter().enumerate().map(slope).collect(),
    }
}

fn quantity(quantity: &ModelQuantity) -> QuantityFile<'_> {
    QuantityFile {
        name: quantity.name,
        value: quantity.value,
        unit: quantity.unit,
        meaning: &quantity.meaning,
    }
}
