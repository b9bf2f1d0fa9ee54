//! A pole selection holds the poles that the user chose.

/// A pole that a person chose, by what a table or a stabilisation diagram shows of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectedPole {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio, a fraction; tells poles of one frequency apart.
    pub damping_ratio: Option<f64>,
    /// Model order at which the pole is to be taken; any without it.
    pub order: Option<usize>,
}

/// The poles that a person chose.
#[derive(Clone, Debug, PartialEq)]
pub struct PoleSelection {
    /// The poles, in the order of the file.
    pub poles: Vec<SelectedPole>,
    /// Farthest that the pole of a method may lie from a chosen frequency, Hz.
    pub tolerance_hz: Option<f64>,
}

impl PoleSelection {
    /// Tolerance as a share of the frequency where none is stated.
    pub const TOLERANCE: f64 = 0.01;

    /// Farthest that a pole may lie from one that was chosen, Hz.
    pub fn tolerance_of(&self, pole: &SelectedPole) -> f64 {
        self.tolerance_hz
            .unwrap_or(Self::TOLERANCE * pole.frequency_hz)
    }
}
