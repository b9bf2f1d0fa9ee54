//! The outcome of a verb gives the exit code.

/// How a verb that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done: exit code 0.
    Done,
    /// Done, but a stated limit is missed or part of the input was bad: exit code 1.
    Missed,
}

impl Outcome {
    /// `Missed` when something was.
    pub fn missed_if(missed: bool) -> Self {
        if missed {
            Outcome::Missed
        } else {
            Outcome::Done
        }
    }
}
