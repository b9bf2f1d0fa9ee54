//! The quality of an identified mode: whether it is one, and what its values are worth.

/// A grade of a mode or of one of its values, from the best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Of use without reservation.
    Good,
    /// To be checked before it is used.
    Doubtful,
    /// Not to be used.
    Bad,
}

impl Grade {
    /// All grades, from the best.
    pub const ALL: [Self; 3] = [Self::Good, Self::Doubtful, Self::Bad];

    /// The name in `modes.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Bad => "bad",
        }
    }

    /// The grade of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|grade| grade.name() == name)
    }

    /// Good below the first limit, doubtful below the second, else bad (also for no number).
    pub fn below(value: f64, good: f64, doubtful: f64) -> Self {
        if value < good {
            Self::Good
        } else if value < doubtful {
            Self::Doubtful
        } else {
            Self::Bad
        }
    }
}

/// Quality of a mode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Whether it is a mode of the structure.
    pub verdict: Grade,
    /// What its frequency is worth; `None` where that cannot be assessed, as for the others.
    pub frequency: Option<Grade>,
    /// What its damping is worth.
    pub damping: Option<Grade>,
    /// What its shape is worth.
    pub shape: Option<Grade>,
    /// Reasons for each grade below good.
    pub reasons: Vec<String>,
}
