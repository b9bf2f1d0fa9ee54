//! A meter of the caller measures processor time and memory: the library reads no clock.

/// Processor time and memory of a computation; `None` where not measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Processor time of all threads, s.
    pub cpu_s: Option<f64>,
    /// Peak memory beyond the memory in use before, bytes.
    pub peak_bytes: Option<u64>,
}

/// Measures work; while it does, no other work runs.
pub trait Meter: Sync {
    /// Whether it measures anything; without a measurement no computation is repeated for timing.
    fn measures(&self) -> bool {
        true
    }

    /// Runs the computation once and returns its cost.
    fn measure(&self, work: &mut dyn FnMut()) -> Cost;
}

/// A meter that measures nothing.
impl Meter for () {
    fn measures(&self) -> bool {
        false
    }

    fn measure(&self, work: &mut dyn FnMut()) -> Cost {
        work();
        Cost::default()
    }
}
