//! The type of a function states its quantity: time history, FRF, coherence or another spectrum.

/// The type of an entry; the numbers are those of universal file dataset 58.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FunctionType {
    /// 1, a time history.
    Time,
    /// 4, a frequency response function.
    Frf,
    /// 6, ordinary coherence.
    Coherence,
    /// Variance of a frequency response function, E|H − E H|²; no universal file number.
    Variance,
    /// Any other number (0 general, 2 auto spectrum, 3 cross spectrum, ...).
    Other(i32),
}

/// Names of the function types of dataset 58, by number.
const FUNCTION_NAMES: [&str; 28] = [
    "general",
    "time",
    "auto-spectrum",
    "cross-spectrum",
    "frf",
    "transmissibility",
    "coherence",
    "auto-correlation",
    "cross-correlation",
    "power-spectral-density",
    "energy-spectral-density",
    "probability-density",
    "spectrum",
    "cumulative-frequency-distribution",
    "peaks-valley",
    "stress-cycles",
    "strain-cycles",
    "orbit",
    "mode-indicator",
    "force-pattern",
    "partial-power",
    "partial-coherence",
    "eigenvalue",
    "eigenvector",
    "shock-response-spectrum",
    "finite-impulse-response-filter",
    "multiple-coherence",
    "order-function",
];

impl FunctionType {
    /// From the dataset-58 number.
    pub fn from_code(code: i32) -> Self {
        match code {
            1 => FunctionType::Time,
            4 => FunctionType::Frf,
            6 => FunctionType::Coherence,
            other => FunctionType::Other(other),
        }
    }

    /// The dataset-58 number; `None` for what the format has no number for.
    pub fn code(self) -> Option<i32> {
        match self {
            FunctionType::Time => Some(1),
            FunctionType::Frf => Some(4),
            FunctionType::Coherence => Some(6),
            FunctionType::Variance => None,
            FunctionType::Other(code) => Some(code),
        }
    }

    /// The name, such as `time`, `frf` or `auto-spectrum`; `type-99` for a number without one.
    ///
    /// ```
    /// use modalign::io::FunctionType;
    /// assert_eq!(FunctionType::from_code(9).name(), "power-spectral-density");
    /// assert_eq!(FunctionType::from_name("frf"), Some(FunctionType::Frf));
    /// ```
    pub fn name(self) -> String {
        let Some(code) = self.code() else {
            return "variance".to_owned();
        };
        let known = usize::try_from(code)
            .ok()
            .and_then(|i| FUNCTION_NAMES.get(i));
        known.map_or_else(|| format!("type-{code}"), |name| (*name).to_owned())
    }

    /// The type of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        if name == "variance" {
            return Some(FunctionType::Variance);
        }
        let known = FUNCTION_NAMES.iter().position(|listed| *listed == name);
        let code = known
            .and_then(|index| i32::try_from(index).ok())
            .or_else(|| name.strip_prefix("type-")?.parse().ok())?;
        Some(FunctionType::from_code(code))
    }
}
