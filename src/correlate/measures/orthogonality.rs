//! Orthogonality checks compare shapes through a mass matrix reduced to the sensors.

use num_complex::Complex64;
use serde::Serialize;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::{RealMatrix, real_matrix};
use crate::modal::{ModalModel, ModeShape};
use crate::theory::{SystemMatrices, guyan, serep_expansion};

use super::super::model_roots::{elastic_modes, highest_rigid_hz};
use super::super::shapes::without_rounding;
use super::super::subspace::subspace_mac;
use super::super::{CorrelateError, DofMap};
use super::mac_matrix::ModeName;
use super::serep_modes::SerepModes;

/// Maximum fraction of a test shape outside the modes of a SEREP reduction; more is a finding.
const MAX_OUTSIDE_FRACTION: f64 = 0.05;

/// Method that reduces a mass matrix to the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reduction {
    /// Static: the other coordinates follow without inertia (Guyan 1965). Each sensor must read one
    /// coordinate.
    Guyan,
    /// Through modes of the model (SEREP, O'Callahan, Avitabile and Riemer 1989), for sensors of
    /// any direction.
    Serep,
}

impl Reduction {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Reduction::Guyan => "guyan",
            Reduction::Serep => "serep",
        }
    }

    /// The reduction of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let all = [Reduction::Guyan, Reduction::Serep];
        all.into_iter().find(|reduction| reduction.name() == name)
    }
}

/// A sensor as a row of the model: reading = `row` · coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorRow {
    /// As the theory names it, with the sign that the row has.
    pub dof: Dof,
    /// One number for each coordinate.
    pub row: Vec<f64>,
}

/// A model's mass matrix reduced to sensors, with the expansion of readings to all coordinates.
#[derive(Clone, Debug)]
pub struct ReducedMass {
    /// Method of the reduction.
    pub reduction: Reduction,
    /// The sensors, as the theory names them.
    pub dofs: Vec<Dof>,
    /// `T^T M T`.
    pub mass: RealMatrix,
    /// `T`: coordinates (rows) from readings (columns).
    pub expansion: RealMatrix,
    /// Modes of a SEREP reduction.
    pub modes: Option<usize>,
}

/// The mass matrix of a model at sensors: `T^T M T`, the test-analysis model.
///
/// `modes` are those that SEREP keeps, one in each column, mass-normalised or not; Guyan ignores
/// them.
///
/// # Errors
/// [`CorrelateError::NotACoordinate`] for Guyan where a sensor reads more than one coordinate, or
/// two read the same; [`CorrelateError::Reduction`] with the model's reason.
///
/// # Reference
/// Guyan (1965), AIAA Journal 3, 380; O'Callahan, Avitabile and Riemer (1989), IMAC 7, 29.
pub fn reduced_mass(
    matrices: &SystemMatrices,
    sensors: &[SensorRow],
    reduction: Reduction,
    modes: &RealMatrix,
) -> Result<ReducedMass, CorrelateError> {
    let reason = |source| CorrelateError::Reduction(Box::new(source));
    let expansion = match reduction {
        Reduction::Guyan => {
            let kept = sensor_coordinates(sensors)?;
            let at: Vec<usize> = kept.iter().map(|entry| entry.0).collect();
            let static_expansion = guyan(matrices, &at).map_err(reason)?.expansion;
            real_matrix(static_expansion.nrows(), kept.len(), |i, a| {
                static_expansion[(i, a)] / kept[a].1
            })
        }
        Reduction::Serep => {
            let rows: Vec<Vec<f64>> = sensors.iter().map(|sensor| sensor.row.clone()).collect();
            serep_expansion(modes, &rows).map_err(reason)?
        }
    };
    Ok(ReducedMass {
        reduction,
        dofs: sensors.iter().map(|sensor| sensor.dof.clone()).collect(),
        mass: expansion.transpose() * (&matrices.mass * &expansion),
        expansion,
        modes: (reduction == Reduction::Serep).then_some(modes.ncols()),
    })
}

/// The one coordinate of each sensor and its factor.
fn sensor_coordinates(sensors: &[SensorRow]) -> Result<Vec<(usize, f64)>, CorrelateError> {
    let mut kept: Vec<(usize, f64)> = Vec::new();
    for sensor in sensors {
        let mut read = sensor
            .row
            .iter()
            .enumerate()
            .filter(|entry| *entry.1 != 0.0);
        match (read.next(), read.next()) {
            (Some((at, factor)), None) if kept.iter().all(|entry| entry.0 != at) => {
                kept.push((at, *factor));
            }
            _ => {
                let dof = sensor.dof.clone();
                return Err(CorrelateError::NotACoordinate { dof });
            }
        }
    }
    Ok(kept)
}

/// Orthogonality of shapes with a mass matrix `M` at the sensors. Values are magnitudes of `φ_i^H M
/// φ_j`, each shape scaled so that `φ^H M φ = 1`, so that the matrices of one set have a diagonal
/// of 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Orthogonality {
    /// Method of the reduction of the mass matrix.
    pub reduction: Reduction,
    /// Modes of a SEREP reduction.
    pub reduction_modes: Option<usize>,
    /// Test modes above 0 Hz with a value at every sensor.
    pub test: Vec<ModeName>,
    /// Requested theory modes with a value at every sensor.
    pub theory: Vec<ModeName>,
    /// Test with test; `None` for a shape without modal mass.
    pub self_test: Vec<Vec<Option<f64>>>,
    /// Theory with theory.
    pub self_theory: Vec<Vec<Option<f64>>>,
    /// Test (rows) with theory (columns).
    pub cross: Vec<Vec<Option<f64>>>,
    /// Of a SEREP reduction, for each test mode: the part of its shape `ψ` outside the kept modes
    /// `Φ` at the sensors, `|ψ − Φ Φ^+ ψ|²/|ψ|²`, 0 to 1. The reduced mass excludes it. `None`
    /// for a static one, and for a shape of zeros.
    pub outside: Vec<Option<f64>>,
    /// Degrees of freedom used.
    pub dofs: usize,
    /// Selection of the modes of a SEREP reduction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub selection: Option<SerepModes>,
}

impl Orthogonality {
    /// This orthogonality with the selection of the modes of its reduction.
    pub fn with_selection(self, selection: SerepModes) -> Self {
        Self {
            selection: Some(selection),
            ..self
        }
    }

    /// The paired modes that the reduction leaves out, and each test shape of which more than 5 %
    /// lies outside the modes of a SEREP reduction, as findings.
    pub fn findings(&self) -> Vec<Finding> {
        let parts = self.test.iter().zip(&self.outside);
        let large = parts.filter_map(|(name, part)| {
            Some((name, part.filter(|part| *part > MAX_OUTSIDE_FRACTION)?))
        });
        let finding = |(name, part): (&ModeName, f64)| {
            Finding::new(
                Severity::Warning,
                Code::OutsideReduction,
                Location::Mode(name.hz),
            )
            .value(part, "")
            .limit(MAX_OUTSIDE_FRACTION)
        };
        let left_out = self.selection.iter().filter_map(SerepModes::finding);
        left_out.chain(large.map(finding)).collect()
    }
}

/// Degrees of freedom of a map at which every shape of both models has a value, as the theory names
/// them: a mass matrix can be reduced to them.
pub fn orthogonality_dofs(test: &ModalModel, theory: &ModalModel, map: &DofMap) -> Vec<Dof> {
    fn everywhere(model: &ModalModel, dof: &Dof) -> bool {
        let shapes = model.modes.iter().map(|mode| &mode.shape);
        let mut with_shape = shapes.filter(|shape| !shape.is_empty());
        with_shape.all(|shape| shape.get(dof).is_some())
    }
    let both = map
        .pairs
        .iter()
        .filter(|pair| everywhere(test, &pair.test) && everywhere(theory, &pair.theory));
    both.map(|pair| pair.theory.clone()).collect()
}

/// Self- and cross-orthogonality of a test and a theory at the sensors of a reduced mass matrix.
///
/// The sensors of the mass must be named as the map names the theory's side. `columns` are the
/// indices of the theory's modes: with SEREP those that it keeps, because the reduced mass does not
/// represent others; rigid-body modes are left out.
///
/// # Errors
/// [`CorrelateError::NotACoordinate`] for a sensor that the map does not have.
pub fn orthogonality(
    test: &ModalModel,
    theory: &ModalModel,
    map: &DofMap,
    reduced: &ReducedMass,
    columns: &[usize],
) -> Result<Orthogonality, CorrelateError> {
    let pair = |dof: &Dof| {
        let mut pairs = map.pairs.iter();
        let found = pairs.find(|pair| pair.theory == *dof);
        found.ok_or_else(|| CorrelateError::NotACoordinate { dof: dof.clone() })
    };
    let pairs: Vec<_> = reduced.dofs.iter().map(pair).collect::<Result<_, _>>()?;
    let test_value = |shape: &ModeShape| -> Option<Vec<Complex64>> {
        let values = pairs.iter();
        values
            .map(|pair| shape.get(&pair.test).map(|v| v * pair.sign))
            .collect()
    };
    let theory_value =
        |shape: &ModeShape| pairs.iter().map(|pair| shape.get(&pair.theory)).collect();
    let rows = elastic_modes(test);
    let mut columns: Vec<usize> = columns.to_vec();
    let rigid_hz = highest_rigid_hz(theory);
    columns.retain(|&j| theory.modes[j].frequency_hz > rigid_hz);
    columns.sort_unstable();
    let of_test = ShapeMomentum::all(test, &rows, &reduced.mass, test_value);
    let of_theory = ShapeMomentum::all(theory, &columns, &reduced.mass, theory_value);
    let kept: Vec<Vec<Complex64>> = of_theory.iter().map(|mode| mode.shape.clone()).collect();
    let outside = |mode: &ShapeMomentum| {
        let inside = subspace_mac(&mode.shape, &kept)?;
        (reduced.reduction == Reduction::Serep).then_some(1.0 - inside)
    };
    Ok(Orthogonality {
        reduction: reduced.reduction,
        outside: of_test.iter().map(outside).collect(),
        reduction_modes: reduced.modes,
        self_test: ShapeMomentum::products(&of_test, &of_test),
        self_theory: ShapeMomentum::products(&of_theory, &of_theory),
        cross: ShapeMomentum::products(&of_test, &of_theory),
        test: of_test.iter().map(|mode| mode.name).collect(),
        theory: of_theory.iter().map(|mode| mode.name).collect(),
        dofs: pairs.len(),
        selection: None,
    })
}

/// A shape and its product with the mass matrix.
struct ShapeMomentum {
    name: ModeName,
    shape: Vec<Complex64>,
    momentum: Vec<Complex64>,
    /// `φ^H M φ`, where that is positive.
    modal_mass: Option<f64>,
}

impl ShapeMomentum {
    fn all(
        model: &ModalModel,
        modes: &[usize],
        mass: &RealMatrix,
        value: impl Fn(&ModeShape) -> Option<Vec<Complex64>>,
    ) -> Vec<Self> {
        let names = ModeName::all(model);
        let kept: Vec<(ModeName, Vec<Complex64>)> = modes
            .iter()
            .filter_map(|&i| Some((names[i], value(&model.modes[i].shape)?)))
            .collect();
        let options = kept
            .iter()
            .map(|(_, shape)| shape.iter().copied().map(Some));
        let cleared = without_rounding(options.map(Iterator::collect).collect());
        let shapes = cleared.into_iter().map(|row| row.into_iter().flatten());
        let scaled = |(name, shape): (ModeName, Vec<Complex64>)| {
            let momentum: Vec<Complex64> = (0..shape.len())
                .map(|i| (0..shape.len()).map(|j| shape[j] * mass[(i, j)]).sum())
                .collect();
            let modal_mass = inner(&shape, &momentum).re;
            Self {
                name,
                modal_mass: (modal_mass > 0.0).then_some(modal_mass),
                momentum,
                shape,
            }
        };
        let names = kept.iter().map(|(name, _)| *name);
        names
            .zip(shapes.map(Iterator::collect))
            .map(scaled)
            .collect()
    }

    fn products(rows: &[Self], columns: &[Self]) -> Vec<Vec<Option<f64>>> {
        let product = |a: &Self, b: &Self| {
            let masses = a.modal_mass? * b.modal_mass?;
            Some(inner(&a.shape, &b.momentum).norm() / masses.sqrt())
        };
        let row = |a: &Self| columns.iter().map(|b| product(a, b)).collect();
        rows.iter().map(row).collect()
    }
}

fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(x, y)| x.conj() * y).sum()
}
