//! How well sensors fit the motion of a rigid body, with its limit.

/// Sum of squares of what does not fit the motion of a rigid body, over its degrees of freedom.
/// Errors of half a percent, as calibrations and positions have, count as noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// The sum over its degrees of freedom; 1 of noise.
    pub value: f64,
    /// Largest value of sensors that move as one rigid body.
    pub limit: f64,
}

/// Largest misfit of sensors that move as one rigid body. Smaller, at 1.5: sound tests are reported
/// (`sound_sensors_are_not_named`). Larger, at 60: of 40 tests with two reversed sensors ten have a
/// single one repaired, and one passes (`several_wrong_sensors_are_no_rigid_body`).
const MAX_MISFIT: f64 = 4.0;
/// Deviations of the misfit from 1 up to which it is noise where few sensors are compared. Smaller,
/// at 2: with two degrees of freedom noise exceeds 3 in 5 % of the tests. Larger, at 60: of 40
/// tests with three reversed sensors two have a single one repaired
/// (`several_wrong_sensors_are_no_rigid_body`).
const MAX_MISFIT_DEVIATIONS: f64 = 5.0;

impl Misfit {
    pub(super) fn new(sum_of_squares: f64, freedom: f64) -> Self {
        Self {
            value: sum_of_squares / freedom,
            limit: MAX_MISFIT.max(1.0 + MAX_MISFIT_DEVIATIONS * (2.0 / freedom).sqrt()),
        }
    }

    /// Whether it is at most its limit.
    pub fn is_small(&self) -> bool {
        self.value <= self.limit
    }
}
