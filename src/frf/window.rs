//! The window of the records that a function came from, as far as a file says it.

/// Window of the records of a function, as dataset 1858 of universal files numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
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

/// Windows by their number less one, with their names in files.
const WINDOWS: [(Window, &str); 6] = [
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

    /// The window of this name; `hann` is that for broad bands, which differs from the other by its scaling alone.
    pub fn from_name(name: &str) -> Option<Self> {
        if name == "hann" {
            return Some(Self::HannBroad);
        }
        WINDOWS.iter().find(|row| row.1 == name).map(|row| row.0)
    }

    /// The names that [`Self::from_name`] takes, for messages.
    pub fn names() -> String {
        let names: Vec<&str> = WINDOWS.iter().map(|row| row.1).collect();
        format!("hann, {}", names.join(", "))
    }

    /// The number in dataset 1858.
    pub fn code(self) -> i64 {
        self as i64 + 1
    }

    /// The window of this number in dataset 1858; `None` for 0, which is none or unknown.
    pub fn from_code(code: i64) -> Option<Self> {
        let index = usize::try_from(code.checked_sub(1)?).ok()?;
        WINDOWS.get(index).map(|row| row.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_have_a_number_and_a_name() {
        for (code, (window, name)) in (1..).zip(WINDOWS) {
            assert_eq!(Window::from_code(code), Some(window));
            assert_eq!(window.code(), code);
            assert_eq!(Window::from_name(name), Some(window));
            assert!(Window::names().contains(name));
            assert_eq!(window.name(), name);
        }
        assert_eq!(Window::from_name("hann"), Some(Window::HannBroad));
        for code in [i64::MIN, -1, 0, 7] {
            assert_eq!(Window::from_code(code), None);
        }
    }
}
