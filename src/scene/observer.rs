//! Progress messages of long computations.

/// Hears of the steps of long work. The library has no clock and no terminal: what is shown, and
/// when, is the caller's.
pub trait Observer: Sync {
    /// Step `number` of `count`, from 1, begins.
    fn step(&self, what: &str, number: usize, count: usize);
}

/// Ignores all messages.
impl Observer for () {
    fn step(&self, _what: &str, _number: usize, _count: usize) {}
}
