//! Theory: a parameterised model, its matrices, its modes at the sensors of a test, and its
//! residues.
//!
//! A [`TheoreticalModel`] turns parameter values into [`SystemMatrices`]; [`modes`] turns those
//! into the same [`ModalModel`](crate::modal::ModalModel) in which a test ends. This module must
//! not know what a test measured, read a file or compare anything.

mod beam;
mod beam_line;
mod boundary;
#[cfg(test)]
mod boundary_tests;
mod compare;
mod condensation;
#[cfg(test)]
mod condensation_tests;
#[cfg(test)]
mod condensation_uses_tests;
mod condensed_modes;
mod damped;
mod description;
mod direct_frf;
mod dual;
mod eigen;
mod energy;
mod error;
mod external;
#[cfg(test)]
mod external_tests;
mod faults;
mod few_masses;
#[cfg(test)]
mod few_masses_tests;
mod gear;
mod hermite;
mod integrate;
mod lumped;
mod lumped_description;
mod mass_error;
mod massless;
mod mode_changes;
mod model_roots;
mod modification;
mod nearest_name;
mod parameter;
mod parameter_effect;
mod property;
mod quantity;
mod reduction;
#[cfg(test)]
mod reduction_tests;
mod repeated_root_basis;
mod residues;
mod response;
mod rigid;
mod sensitivity;
mod sensor_modes;
mod sparse;
mod spring_assembly;
mod support;
mod sweep;
mod sweep_events;
mod sweep_track;
mod system;

#[cfg(test)]
mod beam_modes_tests;
#[cfg(test)]
mod beam_parts_tests;
#[cfg(test)]
mod damped_tests;
#[cfg(test)]
mod eigen_tests;
#[cfg(test)]
mod lumped_tests;
#[cfg(test)]
mod mode_changes_tests;
#[cfg(test)]
mod sensitivity_tests;
#[cfg(test)]
mod sweep_sparse_tests;
#[cfg(test)]
mod sweep_tests;

use crate::geometry::Target;
use crate::linalg::{RealMatrix, SparseMatrix};

pub use beam::BeamModel;
pub use beam_line::BeamPlacement;
pub use boundary::{ModelSupport, ReleasedMode, model_support, released_modes};
pub use compare::{DetailComparison, SimplerModel, compare_details, simplest_detail};
pub use condensation::Condensation;
pub use damped::{DampedModes, damped_model, damped_modes};
pub use description::{
    BeamDescription, BeamFile, End, PointMassDescription, SCHEMA, SpringDescription, Value,
};
pub use direct_frf::direct_receptance;
pub use eigen::{ModeOptions, TheoryModes, modes_of_matrices};
pub use energy::StrainShares;
pub use error::TheoryError;
pub use external::{ExternalMatrices, ExternalModel, MatrixSet, StatedDamping};
pub(crate) use faults::{Fault, Faults};
pub use gear::{
    BUILT_IN, BuiltIn, CycloidBall, HelicalPlanetary, SpiderReducer, TorsionalPlanetary, built_in,
};
pub use lumped::LumpedModel;
pub use lumped_description::{
    BodyDescription, Free, Inertia, LinkDescription, LumpedFile, PointDescription,
};
pub use mass_error::MassError;
pub use mode_changes::{
    ModeChange, ModeChanges, RootState, TrackedModes, frequency_slopes, mode_changes,
};
pub use model_roots::{ModelRoot, model_roots};
pub use modification::{AddedKind, Addition, MODIFICATION, ModifiedModel};
pub use parameter::{
    ParameterSpec, ParameterStatus, check_values, nominal_values, override_values,
};
pub use parameter_effect::is_stiffness;
pub use quantity::ModelQuantity;
pub use reduction::{ReducedModel, guyan, serep, serep_expansion};
pub use residues::{PairResidues, residues};
pub use response::{DetailResponse, Nonlinear, ResponseSignal, ResponseSpan, TimeResponse};
pub use rigid::coordinate_sensors;
pub use sensitivity::{
    ModeDerivatives, RootSensitivity, mode_derivatives, model_sensitivities, sensitivities,
    system_derivatives,
};
pub use sensor_modes::modes;
pub use sparse::{SparseDerivative, SparseSystem, modes_of_sparse};
pub use support::Support;
pub use sweep::{Locus, Sweep, SweepRange, sweep};
pub use sweep_events::{EventKind, LocusEvent};

/// Kind of motion of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A displacement, m.
    Translation,
    /// A rotation, rad.
    Rotation,
    /// A rotation times a radius that the model does not name, m: the displacement along a circle
    /// of a torsional model; or a displacement without a direction.
    Arc,
}

/// One generalised coordinate of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Unique name, by which [`Target::Coordinate`] reads it.
    pub name: String,
    /// The body it belongs to.
    pub body: String,
    /// Displacement or rotation.
    pub motion: Motion,
    /// Unit vector of the displacement, or of the rotation by the right-hand rule (that of an arc,
    /// too), in the model's frame.
    pub axis: [f64; 3],
    /// Position on the body, m, in the model's frame.
    pub at_m: [f64; 3],
}

/// A spring of a model: `K = sum k b b^T` over them where the model has no other elasticity.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// The name that its share of the strain energy goes by; springs of one name are counted
    /// together.
    pub name: String,
    /// Stretch (or twist) per unit of each coordinate, `b`.
    pub row: Vec<f64>,
    /// Stiffness, N/m; N m/rad against rotation.
    pub stiffness: f64,
}

/// A term `theta K_j` of a stiffness matrix.
#[derive(Clone, Debug)]
pub struct StiffnessPart<'a> {
    /// The name that its share of the strain energy goes by; parts of one name are counted
    /// together.
    pub name: &'a str,
    /// `theta`, in the unit of its parameter.
    pub factor: f64,
    /// `K_j`, N/m per unit of the factor.
    pub matrix: &'a SparseMatrix,
}

/// Matrices of `M x'' + C x' + K x = f` over the model's coordinates, all `n` by `n` and symmetric.
#[derive(Clone, Debug)]
pub struct SystemMatrices {
    /// Mass, kg (kg m, kg m² where rotations are involved); positive semidefinite.
    /// Motions without mass are condensed statically, which is exact ([`Condensation`]).
    pub mass: RealMatrix,
    /// Viscous damping, N s/m; `None` for an undamped model.
    pub damping: Option<RealMatrix>,
    /// Stiffness, N/m; positive semidefinite.
    pub stiffness: RealMatrix,
    /// The coordinates, in the order of rows and columns.
    pub coordinates: Vec<Coordinate>,
    /// The springs, where they are all of the elasticity; none for a model with elasticity of
    /// another kind.
    pub springs: Vec<Spring>,
}

/// Derivative of the matrices by one parameter, in their units per unit of the parameter.
#[derive(Clone, Debug)]
pub struct SystemDerivative {
    /// dM/dp.
    pub mass: RealMatrix,
    /// dC/dp; `None` where the model has no damping matrix.
    pub damping: Option<RealMatrix>,
    /// dK/dp.
    pub stiffness: RealMatrix,
}

/// Something that a model takes for granted, to be printed beside its results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assumption {
    /// The part of the model it is about.
    pub about: String,
    /// The assumption, as a clause without a full stop.
    pub statement: &'static str,
    /// Whether it is a value that the user has yet to state, not a limit of the theory.
    pub is_guess: bool,
}

impl Assumption {
    /// Several about one part.
    fn all<const N: usize>(about: &str, statements: [&'static str; N]) -> Vec<Self> {
        let assumption = |statement| Self {
            about: about.to_owned(),
            statement,
            is_guess: false,
        };
        statements.map(assumption).into()
    }
}

/// A parameterised linear model of a machine.
///
/// Values are always in the order of [`parameters`](TheoreticalModel::parameters). The observation
/// of a sensor depends on the nominal geometry, and of the values on the numbers of parts alone.
pub trait TheoreticalModel: std::fmt::Debug + Send + Sync {
    /// Title of the model.
    fn name(&self) -> &str;

    /// The parameters, in the order of their values.
    fn parameters(&self) -> &[ParameterSpec];

    /// The matrices for these values.
    ///
    /// # Errors
    /// [`TheoryError::ValueCount`], [`TheoryError::OutOfBounds`], or
    /// [`TheoryError::PropertyOutOfRange`] when a value gives a part an impossible property.
    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError>;

    /// The row `b` that turns coordinates into the reading of a sensor, `y = b^T x`; equally the
    /// distribution of a unit force at a hit, `f = b`.
    ///
    /// # Errors
    /// [`TheoryError::UnknownBody`], [`TheoryError::UnknownCoordinate`],
    /// [`TheoryError::PointOutside`], [`TheoryError::ZeroDirection`].
    fn observation_row(&self, values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError>;

    /// Derivative of the matrices by parameter `j`, in closed form.
    ///
    /// # Errors
    /// As [`assemble`](TheoreticalModel::assemble); [`TheoryError::NoDerivative`] for a number of
    /// parts.
    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError>;

    /// The matrices without their zeros, for a model that is solved so ([`modes_of_sparse`]): the
    /// lowest modes alone. `None` for a model that is solved with full matrices.
    ///
    /// # Errors
    /// As [`assemble`](TheoreticalModel::assemble).
    fn sparse(&self, _values: &[f64]) -> Result<Option<SparseSystem>, TheoryError> {
        Ok(None)
    }

    /// Derivative of the sparse matrices by parameter `j`; `None` as for
    /// [`sparse`](TheoreticalModel::sparse).
    ///
    /// # Errors
    /// As [`assemble`](TheoreticalModel::assemble).
    fn sparse_derivative(
        &self,
        _values: &[f64],
        _j: usize,
    ) -> Result<Option<SparseDerivative>, TheoryError> {
        Ok(None)
    }

    /// The stiffness matrix as a sum of named parts, for a model whose elasticity is not springs;
    /// none for any other.
    ///
    /// # Errors
    /// As [`assemble`](TheoreticalModel::assemble).
    fn stiffness_parts(&self, _values: &[f64]) -> Result<Vec<StiffnessPart<'_>>, TheoryError> {
        Ok(Vec::new())
    }

    /// Damping ratio that the model states for an elastic mode, by its number from 0, in place of
    /// what its matrices say.
    fn stated_damping(&self, _elastic: usize) -> Option<f64> {
        None
    }

    /// What kind of motion a root is, in words that mean something for this machine, from its
    /// angular frequency and the share of the kinetic energy of each coordinate (of a repeated root
    /// the mean over its modes). `None` for a model without such words.
    fn mode_class(&self, _omega_rad_s: f64, _shares: &[f64]) -> Option<&'static str> {
        None
    }

    /// Numbers that the theory of this machine gives beside its matrices: closed forms, places of
    /// veering, static balances. None for a model without such a theory.
    ///
    /// # Errors
    /// As [`assemble`](TheoreticalModel::assemble), and those of the modes where a quantity needs
    /// them.
    fn quantities(&self, _values: &[f64]) -> Result<Vec<ModelQuantity>, TheoryError> {
        Ok(Vec::new())
    }

    /// The support that the model states; `None` where its matrices alone show it.
    fn support(&self) -> Option<Support> {
        None
    }

    /// The stiffness matrix without the springs to ground, for a model whose elasticity is not
    /// springs alone; `None` for any other, and where these springs are not known.
    ///
    /// # Errors
    /// As [`assemble`](TheoreticalModel::assemble).
    fn stiffness_without_ground(&self, _values: &[f64]) -> Result<Option<RealMatrix>, TheoryError> {
        Ok(None)
    }

    /// Kinds of bodies (`ball` of `ball-1`, `ball-2`, ...) that a simpler model may leave without
    /// mass.
    fn small_bodies(&self) -> &'static [&'static str] {
        &[]
    }

    /// How a sensor or hit lies to the beam on which it sits; `None` for one on no beam.
    fn beam_placement(&self, _target: &Target) -> Option<BeamPlacement> {
        None
    }

    /// The motion over time, for a model whose equations are more than its matrices.
    fn nonlinear(&self) -> Option<&dyn Nonlinear> {
        None
    }

    /// Assumptions of the model.
    fn assumptions(&self) -> Vec<Assumption>;
}
