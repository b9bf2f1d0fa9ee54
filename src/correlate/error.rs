//! Errors of correlation state the value got, the accepted ones, and the location.

use crate::dof::Dof;
use crate::linalg::LinalgError;
use crate::theory::TheoryError;

/// Minimum ratio of the extents of two geometries that is a matter of their units of length.
/// Larger, at 2000: millimetres against metres are no unit. Smaller, at 10: a test of a part of a
/// machine counts as one in another unit. Test
/// `test_without_a_near_node_is_an_error_with_its_distances`.
const MIN_EXTENT_RATIO_OF_UNITS: f64 = 100.0;

/// Root mean square distances of the points of both geometries from their centres, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// Of the test, in the frame of the theory.
    pub test_m: f64,
    /// Of the theory.
    pub theory_m: f64,
}

impl Extents {
    /// Whether they differ as units of length do.
    pub fn differ_in_unit(&self) -> bool {
        let larger = self.test_m.max(self.theory_m);
        let smaller = self.test_m.min(self.theory_m);
        smaller > 0.0 && larger > MIN_EXTENT_RATIO_OF_UNITS * smaller
    }
}

impl std::fmt::Display for Extents {
    /// The probable cause of distances and the remedy.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { test_m, theory_m } = self;
        let remedy = "--align fits rotation, translation and scale";
        match self.differ_in_unit() {
            true => write!(
                f,
                "the test extends over {test_m:.3e} m, the model over {theory_m:.3e} m: one is probably in millimetres; {remedy}"
            ),
            false => write!(
                f,
                "check frame and unit of both geometries, or state a larger --nearest-node; {remedy}"
            ),
        }
    }
}

/// Why modes cannot be paired or compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CorrelateError {
    /// A list of degrees of freedom that cannot be read.
    #[error("line {line} of the list of degrees of freedom: got {got:?}, expected {expected}")]
    DofList {
        /// Line from 1.
        line: usize,
        /// The line as found.
        got: String,
        /// The accepted values.
        expected: &'static str,
    },
    /// An option outside its range.
    #[error("pairing option {name}: got {got}, expected {expected}")]
    Option {
        /// The option.
        name: &'static str,
        /// The value as given.
        got: f64,
        /// The accepted values.
        expected: &'static str,
    },
    /// A mode with an invalid frequency.
    #[error("{model} mode {number}: got {got_hz} Hz, expected a finite frequency of 0 or more")]
    Frequency {
        /// Test or theory.
        model: &'static str,
        /// Number of the mode, from 1.
        number: usize,
        /// Its frequency, Hz.
        got_hz: f64,
    },
    /// Translations and rotations in one MAC without a length.
    #[error(
        "got {translations} translations and {rotations} rotations in common, expected one kind, or a length in metres that scales the rotations (--rotation-length of `correlate`, rotation_length_m in [pair] of a scene)"
    )]
    MixedUnits {
        /// Common degrees of freedom that are translations.
        translations: usize,
        /// Common degrees of freedom that are rotations.
        rotations: usize,
    },
    /// A shape value that is not a number.
    #[error(
        "{model} mode {number}: got a shape value that is not finite, expected a number at every degree of freedom"
    )]
    ShapeValue {
        /// Test or theory.
        model: &'static str,
        /// Number of the mode, from 1.
        number: usize,
    },
    /// Two tests of one name.
    #[error("got test `{name}` twice, expected every test to have a unique name")]
    DuplicateTest {
        /// The name.
        name: String,
    },
    /// A pairing that was made from other models.
    #[error(
        "test `{test}`: got a pairing of {got_test} test and {got_theory} theory modes, expected {expected_test} and {expected_theory}"
    )]
    OtherPairing {
        /// The test.
        test: String,
        /// Test modes in the pairing.
        got_test: usize,
        /// Theory modes in the pairing.
        got_theory: usize,
        /// Modes of the test.
        expected_test: usize,
        /// Modes of the theory.
        expected_theory: usize,
    },
    /// Fewer points than a frame needs.
    #[error("got {got} distinct points, expected {expected} or more to fit a frame to them")]
    FewPoints {
        /// Points, or partners for them.
        got: usize,
        /// Needed.
        expected: usize,
    },
    /// Points that no rotation, shift and scale maps to the theory's.
    #[error(
        "the best rotation, translation and scale ({scale:.4}) leaves the test points {largest_m:.3e} m off at most ({rms_m:.3e} m rms), expected {tolerance_m:.3e} m or less; give a list of partners"
    )]
    NotAligned {
        /// Root mean square distance, m.
        rms_m: f64,
        /// Largest distance, m.
        largest_m: f64,
        /// Scale of the fit.
        scale: f64,
        /// Stated tolerance, m.
        tolerance_m: f64,
    },
    /// Points that only a reflection maps to the theory's.
    #[error(
        "got test points that a reflection maps onto the model within {tolerance_m:.3e} m and no rotation, expected right-handed axes on both sides; reverse one coordinate of the test and the motions along it"
    )]
    Mirrored {
        /// Stated tolerance, m.
        tolerance_m: f64,
    },
    /// No sensor of the test near a node of the theory.
    #[error(
        "got {near} of {sensors} test sensors within {tolerance_m:.3e} m of a model node, expected more; the distances are {nearest_m:.3e} m to {farthest_m:.3e} m; {extents}"
    )]
    NoNearNode {
        /// Sensors within the tolerance.
        near: usize,
        /// Sensors with a position.
        sensors: usize,
        /// Smallest distance of a sensor from its nearest node, m.
        nearest_m: f64,
        /// Largest one, m.
        farthest_m: f64,
        /// Stated tolerance, m.
        tolerance_m: f64,
        /// Extents of both geometries, for the cause.
        extents: Extents,
    },
    /// Sensors without a position, or without a node that has their axes.
    #[error(
        "got {sensors} test sensors of which none has a position and a model node with its axis, expected nodes at the points of test and model, and motions along the same axes; name pairs with --dof-map FILE"
    )]
    NoLocatedSensor {
        /// Sensors of the test.
        sensors: usize,
    },
    /// Every fit gives several points one partner.
    #[error(
        "no rotation, translation and scale maps the {points} test points one-to-one to the {partners} model points; give a list of partners"
    )]
    NoDistinctPartners {
        /// Distinct points of the test.
        points: usize,
        /// Points of the model.
        partners: usize,
    },
    /// A sensor at which a static reduction of a mass matrix is not possible.
    #[error(
        "sensor {dof}: got a reading of several coordinates, or of one that another sensor reads, expected one coordinate for each sensor; reduce with serep"
    )]
    NotACoordinate {
        /// The sensor, as the theory names it.
        dof: Dof,
    },
    /// Names that differ in number from the coordinates.
    #[error(
        "got names of {got} coordinates, expected {expected}: the model has coordinates that are no degrees of freedom of a body"
    )]
    CoordinateNames {
        /// Names.
        got: usize,
        /// Coordinates of the model.
        expected: usize,
    },
    /// A mass matrix that cannot be reduced to the sensors.
    #[error("the mass matrix cannot be reduced to the sensors: {0}")]
    Reduction(#[source] Box<TheoryError>),
    /// Two sets of FRFs without common points.
    #[error(
        "got {got_first} and {got_second} functions without one response and reference in common, expected functions of the same points"
    )]
    NoCommonFunction {
        /// Functions of the first set.
        got_first: usize,
        /// Functions of the second set.
        got_second: usize,
    },
    /// Two sets of FRFs without common lines.
    #[error(
        "got axes with lines every {got_first_hz} Hz and {got_second_hz} Hz that have {common} lines in common, expected two or more"
    )]
    NoCommonLine {
        /// Spacing of the first set, Hz.
        got_first_hz: f64,
        /// Spacing of the second set, Hz.
        got_second_hz: f64,
        /// Lines in common inside the band.
        common: usize,
    },
    /// A matrix problem without a solution.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
}
