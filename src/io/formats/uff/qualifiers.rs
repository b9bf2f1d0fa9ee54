//! Qualifiers (dataset 1858) belong to the function before or behind them.

use crate::io::Window;

/// Qualifiers beside functions: whether they stand before or behind them is what the first of a
/// file shows.
#[derive(Debug, Default)]
pub(super) struct Qualifiers {
    /// Whether they stand before their function; unknown before the first.
    pub lead: Option<bool>,
    /// Of the function that is to come, and of the one that is being read.
    pub next: Option<Window>,
    pub current: Option<Window>,
    /// Number of the last function that began, and of the last one that became an entry.
    pub begun: usize,
    pub read: usize,
}

impl Qualifiers {
    /// A function begins; the qualifiers that stood before it belong to it.
    pub fn begin(&mut self) {
        self.begun += 1;
        self.current = self.next.take();
    }
}
