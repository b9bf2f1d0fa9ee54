//! Errors of a model, of its parameter values and of requests to it.

use crate::dof::Dof;
use crate::linalg::LinalgError;

use super::MassError;
use super::faults::Fault;
use super::nearest_name::{expected_bounds, expected_name, expected_nearest, nearest_name};

/// Reason why a model cannot be built, assembled, observed or solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TheoryError {
    /// Faults of a model file.
    #[error("{} faults: {}", faults.len(), joined(faults))]
    Several {
        /// The faults, two or more.
        faults: Vec<TheoryError>,
    },
    /// A model file of another schema.
    #[error("model file: got schema `{got}`, expected `{expected}`")]
    Schema {
        /// As written.
        got: String,
        /// Schema that this version reads.
        expected: &'static str,
    },
    /// A parameter name that the model does not declare.
    #[error("{used_by}: got parameter `{got}`, expected {}", expected_name(.nearest.as_deref(), .known))]
    UnknownParameter {
        /// The name as given.
        got: String,
        /// Part of the model or request that names it.
        used_by: String,
        /// The declared name most like it.
        nearest: Option<String>,
        /// Every declared name.
        known: Vec<String>,
    },
    /// A vector of values of the wrong length.
    #[error("model `{model}`: got {got} parameter values, expected {expected}")]
    ValueCount {
        /// The model, or the list of parameters.
        model: String,
        /// Got.
        got: usize,
        /// Expected.
        expected: usize,
    },
    /// A value outside its parameter's bounds, or not finite.
    #[error("parameter `{name}`: got {got} {unit}, expected a finite value{}", expected_bounds(*.lower, *.upper, .unit))]
    OutOfBounds {
        /// Parameter.
        name: String,
        /// Value.
        got: f64,
        /// Lower bound, included.
        lower: Option<f64>,
        /// Upper bound, included.
        upper: Option<f64>,
        /// Unit of all three.
        unit: String,
    },
    /// A lower bound above the upper one.
    #[error(
        "parameter `{name}`: got lower = {lower} above upper = {upper} {unit}, expected lower <= upper"
    )]
    ReversedBounds {
        /// Parameter.
        name: String,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
        /// Unit of both.
        unit: String,
    },
    /// A part of a number of parts.
    #[error("parameter `{name}`: got {got}, expected a whole number")]
    NotWhole {
        /// Parameter.
        name: String,
        /// Value.
        got: f64,
    },
    /// A derivative by a number of parts.
    #[error("parameter `{name}`: an integer parameter has no derivative")]
    NoDerivative {
        /// Parameter.
        name: String,
    },
    /// Two items of one kind with the same name.
    #[error("got {what} `{name}` twice, expected a distinct name for every {what}")]
    Duplicate {
        /// Kind of item.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A property outside its admissible range.
    #[error("{part}: got {property} {got}, expected {expected}")]
    PropertyOutOfRange {
        /// Part of the model.
        part: String,
        /// The property, with its unit in its name.
        property: &'static str,
        /// Value.
        got: f64,
        /// Accepted values.
        expected: &'static str,
    },
    /// A part that needs one of several properties and has none.
    #[error("{part}: got no stiffness or several, expected {expected}")]
    NoStiffness {
        /// Part of the model.
        part: String,
        /// Accepted values.
        expected: &'static str,
    },
    /// A model that is not built in.
    #[error("got model `{got}`, expected a built-in one: {}", .known.join(", "))]
    UnknownModel {
        /// The name as given.
        got: String,
        /// Every name with every parameter set.
        known: Vec<String>,
    },
    /// A part without a property that it needs.
    #[error(
        "{part}: got no {property}, expected one because it may move along or about `{needed_for}`"
    )]
    MissingProperty {
        /// Part of the model.
        part: String,
        /// The property, with its unit in its name.
        property: &'static str,
        /// Freedom that needs it.
        needed_for: &'static str,
    },
    /// A spring to ground without a direction.
    #[error(
        "{part}: got no direction, expected one, because ground has no place that would give it a line"
    )]
    NoDirection {
        /// Part of the model.
        part: String,
    },
    /// A parameter whose unit is not that of the property it stands for.
    #[error("{part}: got parameter `{parameter}` in {got} for {property}, expected {expected}")]
    ParameterUnit {
        /// Part of the model.
        part: String,
        /// The parameter.
        parameter: String,
        /// The property.
        property: &'static str,
        /// Its unit as stated.
        got: String,
        /// The unit of the property.
        expected: &'static str,
    },
    /// A spring that no coordinate stretches.
    #[error(
        "{part}: neither end of the spring moves along its direction, expected a coordinate that moves at least one"
    )]
    NothingMoves {
        /// Part of the model.
        part: String,
    },
    /// A point that the model does not have.
    #[error("{used_by}: got point `{got}`, expected the name of a [[point]] or `ground`{}", expected_nearest(.nearest.as_deref()))]
    UnknownPoint {
        /// The name as given.
        got: String,
        /// Part of the model or request that names it.
        used_by: String,
        /// The point most like it.
        nearest: Option<String>,
    },
    /// A body that the model does not have.
    #[error("{used_by}: got body `{got}`, expected {}", expected_name(.nearest.as_deref(), .known))]
    UnknownBody {
        /// The name as given.
        got: String,
        /// Part of the model or request that names it.
        used_by: String,
        /// The body most like it.
        nearest: Option<String>,
        /// Every body.
        known: Vec<String>,
    },
    /// A coordinate that the model does not have (held ones are not coordinates).
    #[error("got coordinate `{got}`, expected one of the model's {count}{}", expected_nearest(.nearest.as_deref()))]
    UnknownCoordinate {
        /// The name as given.
        got: String,
        /// The coordinate most like it.
        nearest: Option<String>,
        /// Number of coordinates of the model.
        count: usize,
    },
    /// A point or an angle of a body whose coordinate is a radius times an angle, the radius not
    /// known.
    #[error(
        "{used_by}: `{body}` moves by `{coordinate}`, a radius times an angle; expected the coordinate instead of a point"
    )]
    NoRadius {
        /// Part of the model or request that names it.
        used_by: String,
        /// The body.
        body: String,
        /// Its coordinate.
        coordinate: String,
    },
    /// A point of a model without geometry.
    #[error(
        "sensor: got a point of `{body}`, expected the name of a coordinate: matrices do not say where their coordinates are"
    )]
    NoPositions {
        /// The body as given.
        body: String,
    },
    /// A model too large for full matrices.
    #[error(
        "got {got} coordinates for an analysis with full matrices, expected at most {most}: modes, energies and sensitivities alone are computed from sparse ones"
    )]
    TooLarge {
        /// Coordinates.
        got: usize,
        /// The most.
        most: usize,
    },
    /// Coordinates to keep that are none, or not there, or there twice.
    #[error(
        "got the coordinates {got:?} to keep (from 0), expected one or more of {size}, each once"
    )]
    KeptCoordinates {
        /// As given.
        got: Vec<usize>,
        /// Number of coordinates of the model.
        size: usize,
    },
    /// Readings at which modes are linearly dependent.
    #[error(
        "expansion: got {readings} readings that do not separate {modes} modes (least over largest singular value {got:.1e}), expected above {expected:.0e}: more sensors or fewer modes"
    )]
    IndistinctModes {
        /// Modes.
        modes: usize,
        /// Readings.
        readings: usize,
        /// Least over largest singular value.
        got: f64,
        /// The least.
        expected: f64,
    },
    /// A point beyond the ends of a body.
    #[error("{used_by}: got a point {got_m} m along `{body}`, expected 0 to {length_m} m")]
    PointOutside {
        /// Part of the model or request that names it.
        used_by: String,
        /// The body.
        body: String,
        /// Position along its axis, m.
        got_m: f64,
        /// Its length, m.
        length_m: f64,
    },
    /// A direction that is zero or not finite.
    #[error(
        "{used_by}: got direction {got:?}, expected three finite numbers that are not all zero"
    )]
    ZeroDirection {
        /// Part of the model that states it.
        used_by: String,
        /// As given.
        got: [f64; 3],
    },
    /// A deflection that is not perpendicular to the beam.
    #[error("beam `{beam}`: got a deflection {got_deg:.4} degrees from its axis, expected 90")]
    DeflectionNotAcross {
        /// The beam.
        beam: String,
        /// Angle between deflection and axis, degrees.
        got_deg: f64,
    },
    /// A sensor of a rotation given as a point and a direction.
    #[error(
        "sensor {dof}: got a point and a direction for a rotation, expected the name of a coordinate"
    )]
    RotationAtPoint {
        /// The degree of freedom.
        dof: Dof,
    },
    /// Matrices whose sizes disagree.
    #[error(
        "{matrix} matrix: got {got_rows} x {got_columns}, expected {expected} x {expected} (the coordinates, at least 1)"
    )]
    MatrixSize {
        /// Mass, damping or stiffness.
        matrix: &'static str,
        /// Rows.
        got_rows: usize,
        /// Columns.
        got_columns: usize,
        /// Number of coordinates.
        expected: usize,
    },
    /// An observation row that does not belong to the matrices.
    #[error(
        "observation row of {what} {index} (from 0): got {got} entries, expected {expected} (one for each coordinate)"
    )]
    RowLength {
        /// Response or hit.
        what: &'static str,
        /// Index, from 0.
        index: usize,
        /// Entries.
        got: usize,
        /// Number of coordinates.
        expected: usize,
    },
    /// Matrices of a model without coordinates.
    #[error("model `{model}`: got no degree of freedom, expected one for each row of its matrices")]
    NoCoordinates {
        /// The model.
        model: String,
    },
    /// A matrix entry that is not a number, or not that of its mirror image.
    #[error(
        "{matrix} matrix at {row}, {column} (from 0): got {got}, expected a finite value equal to its mirror image"
    )]
    MatrixEntry {
        /// Mass, damping or stiffness.
        matrix: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The entry.
        got: f64,
    },
    /// A stiffness matrix that is not positive semidefinite.
    #[error(
        "got an eigenvalue {got_rad2_s2:.6e} (rad/s)^2, expected none below -{limit_rad2_s2:.3e}: the stiffness is not positive semidefinite"
    )]
    NegativeStiffness {
        /// Rayleigh quotient of the mode, (rad/s)².
        got_rad2_s2: f64,
        /// Its rounding bound, (rad/s)².
        limit_rad2_s2: f64,
    },
    /// A damping ratio outside `[0, 1)`.
    #[error("got damping ratio {got}, expected a fraction from 0 to below 1")]
    DampingRatio {
        /// As given.
        got: f64,
    },
    /// Damping ratios that are not one for each elastic mode.
    #[error("got {got} damping ratios, expected {expected} (one for each elastic mode)")]
    DampingCount {
        /// Got.
        got: usize,
        /// Expected.
        expected: usize,
    },
    /// A degree of freedom at which the modes were not observed.
    #[error("got degree of freedom {got}, expected one at which the modes were computed: {}", .known.join(", "))]
    NotObserved {
        /// As asked.
        got: Dof,
        /// Those there are.
        known: Vec<String>,
    },
    /// A model that is not held where only held ones have an answer.
    #[error("damped modes: got {got} rigid-body modes, expected none (a held model)")]
    RigidBody {
        /// How many.
        got: usize,
    },
    /// Damped modes of a model that has no damping matrix.
    #[error(
        "damped modes: got a model without a damping matrix, expected one (ratios stated mode by mode leave the modes as they are)"
    )]
    Undamped,
    /// An overdamped motion.
    #[error(
        "damped modes: got the real root {got_rad_s:.6e} rad/s, expected complex roots only (less damping)"
    )]
    Overdamped {
        /// The root nearest to the origin, rad/s.
        got_rad_s: f64,
    },
    /// Two roots that meet in one shape: the response is no sum of exponentials.
    #[error(
        "damped modes: got a repeated root at {frequency_hz} Hz with fewer shapes than roots (independence {got:.3e}), expected at least {expected:.0e}"
    )]
    DefectiveRoot {
        /// Natural frequency of the root, Hz.
        frequency_hz: f64,
        /// `|phi^T (2 lambda M + C) phi|` of the best vector over what it is without damping.
        got: f64,
        /// The least.
        expected: f64,
    },
    /// Values of a parameter that are no range.
    #[error(
        "parameter `{parameter}`: got a sweep from {lower} to {upper} in {count} values, expected ascending finite ends and 2 to {most} values"
    )]
    SweepRange {
        /// The parameter.
        parameter: String,
        /// The first value.
        lower: f64,
        /// The last value.
        upper: f64,
        /// Number of values.
        count: usize,
        /// The largest number that is taken, for a model of this size.
        most: usize,
    },
    /// Values of a number of parts that are not whole.
    #[error(
        "parameter `{parameter}`: got a sweep from {lower} to {upper} in {count} values, expected whole numbers in equal steps, such as {lower}:{upper}:{}",
        .upper - .lower + 1.0
    )]
    SweepNotWhole {
        /// The parameter.
        parameter: String,
        /// The first value.
        lower: f64,
        /// The last value.
        upper: f64,
        /// Number of values.
        count: usize,
    },
    /// A model of which no simpler one is known.
    #[error(
        "model `{model}`: got no simpler model to compare, expected small bodies or a response over time"
    )]
    NoSimplerModel {
        /// The model.
        model: String,
    },
    /// A response without recorded periods or without a time step.
    #[error(
        "response: got {periods} recorded periods in steps of {step_radians} rad of the highest frequency, expected at least 1 and a step above 0"
    )]
    NoPeriods {
        /// Recorded periods.
        periods: usize,
        /// Step times the highest angular frequency.
        step_radians: f64,
    },
    /// Modes whose shapes change too much between two values of a parameter to be tracked.
    #[error(
        "parameter `{parameter}` between {lower} and {upper}: mode shapes cannot be tracked between these values; use smaller steps"
    )]
    NotFollowed {
        /// The parameter.
        parameter: String,
        /// One value.
        lower: f64,
        /// The next.
        upper: f64,
    },
    /// A mass matrix, or motions without mass, for which natural frequencies are not defined.
    #[error(transparent)]
    Mass(#[from] MassError),
    /// A matrix problem without an answer.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
}

fn joined(faults: &[TheoryError]) -> String {
    let texts: Vec<String> = faults.iter().map(TheoryError::to_string).collect();
    texts.join("; ")
}

impl Fault for TheoryError {
    fn split(self) -> Vec<Self> {
        match self {
            TheoryError::Several { faults } => faults.into_iter().flat_map(Fault::split).collect(),
            single => vec![single],
        }
    }

    fn several(faults: Vec<Self>) -> Self {
        TheoryError::Several { faults }
    }
}

impl TheoryError {
    /// Whether it is of a sensor on a part that the model does not have.
    pub(crate) fn is_of_unknown_part(&self) -> bool {
        use TheoryError::{PointOutside, UnknownBody, UnknownCoordinate};
        matches!(
            self,
            UnknownBody { .. } | UnknownCoordinate { .. } | PointOutside { .. }
        )
    }

    /// The error of a body that is none of the known ones.
    pub(crate) fn unknown_body(used_by: &str, got: &str, known: Vec<String>) -> Self {
        TheoryError::UnknownBody {
            got: got.to_owned(),
            used_by: used_by.to_owned(),
            nearest: nearest_name(got, known.iter().map(String::as_str)),
            known,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::nearest_name::nearest_name;

    #[test]
    fn an_unknown_parameter_is_reported_with_the_expected_names_and_the_nearest() {
        let known = vec!["youngs_modulus".to_owned(), "density".to_owned()];
        let error = TheoryError::UnknownParameter {
            got: "youngs_modulos".to_owned(),
            used_by: "beam `shaft`".to_owned(),
            nearest: nearest_name("youngs_modulos", known.iter().map(String::as_str)),
            known,
        };
        assert_eq!(
            error.to_string(),
            "beam `shaft`: got parameter `youngs_modulos`, expected one of youngs_modulus, density; did you mean `youngs_modulus`?"
        );
        assert_eq!(nearest_name("zzz", ["density"]), None);
    }

    #[test]
    fn bounds_are_stated_as_far_as_they_are_specified() {
        let error = TheoryError::OutOfBounds {
            name: "k".to_owned(),
            got: 5.0,
            lower: Some(1.0),
            upper: Some(2.5),
            unit: "N/m".to_owned(),
        };
        assert_eq!(
            error.to_string(),
            "parameter `k`: got 5 N/m, expected a finite value from 1 to 2.5 N/m (its bounds `lower` and `upper`)"
        );
    }
}
