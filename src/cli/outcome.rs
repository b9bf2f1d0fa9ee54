//! The outcome of a verb gives the exit code.

/// Outcome of a verb that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done: exit code 0.
    Done,
    /// Done, but a stated limit is missed, part of the input was bad or nothing was compared: exit
    /// code 1.
    Missed,
}

impl Outcome {
    /// `Missed` when a limit is missed, input was bad or nothing was compared.
    pub fn missed_if(missed: bool) -> Self {
        if missed {
            Outcome::Missed
        } else {
            Outcome::Done
        }
    }
}
