//! Progress messages of long computations.

/// Receives the steps of long work. The library has no clock and no terminal: the caller decides
/// what is shown, and when.
pub trait Observer: Sync {
    /// Step `number` of `count`, from 1, begins.
    fn step(&self, what: &str, number: usize, count: usize);
}

/// Ignores all messages.
impl Observer for () {
    fn step(&self, _what: &str, _number: usize, _count: usize) {}
}
