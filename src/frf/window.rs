//! The window of the records that a function came from, as far as a file says it.

/// Window of the records of a function, as dataset 1858 of universal files numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// None (rectangular), as a user or a file states it. Dataset 1858 cannot: its 0 is none or
    /// unknown.
    Rectangular,
    /// 1, Hann, narrow band.
    HannNarrow,
    /// 2, Hann, broad band.
    HannBroad,
    /// 3, flat top.
    FlatTop,
    /// 4, exponential.
    Exponential,
    /// 5, impact (force).
    Force,
    /// 6, impact and exponential.
    ForceAndExponential,
}

/// Other names of windows. The two Hann windows differ by their scaling alone.
const ALIASES: [(&str, Window); 3] = [
    ("rectangular", Window::Rectangular),
    ("uniform", Window::Rectangular),
    ("hann", Window::HannBroad),
];

/// Windows by their number, with their names in files.
const WINDOWS: [(Window, &str); 7] = [
    (Window::Rectangular, "none"),
    (Window::HannNarrow, "hann-narrow"),
    (Window::HannBroad, "hann-broad"),
    (Window::FlatTop, "flat-top"),
    (Window::Exponential, "exponential"),
    (Window::Force, "force"),
    (Window::ForceAndExponential, "force-and-exponential"),
];

impl Window {
    /// The name in files.
    pub fn name(self) -> &'static str {
        WINDOWS[self as usize].1
    }

    /// The window of this name, an alias (`rectangular`, `uniform`, `hann`) included.
    pub fn from_name(name: &str) -> Option<Self> {
        let names = WINDOWS.iter().map(|(window, name)| (*name, *window));
        let mut names = names.chain(ALIASES);
        names.find(|row| row.0 == name).map(|row| row.1)
    }

    /// Whether it is one for the records of hits.
    pub fn is_for_hits(self) -> bool {
        matches!(
            self,
            Self::Exponential | Self::Force | Self::ForceAndExponential
        )
    }

    /// Whether it adds damping to all modes.
    pub fn is_exponential(self) -> bool {
        matches!(self, Self::Exponential | Self::ForceAndExponential)
    }

    /// The names that [`Self::from_name`] takes, for messages.
    pub fn names() -> String {
        let aliases = ALIASES.iter().map(|row| row.0);
        let names: Vec<&str> = aliases.chain(WINDOWS.iter().map(|row| row.1)).collect();
        names.join(", ")
    }

    /// The number in dataset 1858.
    pub fn code(self) -> i64 {
        self as i64
    }

    /// The window of this number in dataset 1858; `None` for 0, which is none or unknown.
    pub fn from_code(code: i64) -> Option<Self> {
        let index = usize::try_from(code).ok().filter(|index| *index > 0)?;
        WINDOWS.get(index).map(|row| row.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_have_a_number_and_a_name() {
        for (code, (window, name)) in (0..).zip(WINDOWS) {
            // 0 is none or unknown.
            assert_eq!(Window::from_code(code), (code > 0).then_some(window));
            assert_eq!(window.code(), code);
            assert_eq!(Window::from_name(name), Some(window));
            assert!(Window::names().contains(name));
            assert_eq!(window.name(), name);
        }
        for (alias, window) in ALIASES {
            assert_eq!(Window::from_name(alias), Some(window));
        }
        assert_eq!(Window::from_name("hamming"), None);
        for code in [i64::MIN, -1, 0, 7] {
            assert_eq!(Window::from_code(code), None);
        }
    }
}
