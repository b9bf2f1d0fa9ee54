//! What work costs, as the caller measures it: the library reads no clock.

/// What a piece of work cost; `None` where nobody knows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Processor time of all threads, s.
    pub cpu_s: Option<f64>,
    /// Most memory taken at once beyond what was taken before, bytes.
    pub peak_bytes: Option<u64>,
}

/// Measures work; while it does, no other work runs.
pub trait Meter: Sync {
    /// Whether it knows anything; work is not repeated for one that does not.
    fn measures(&self) -> bool {
        true
    }

    /// Does the work once and tells what it cost.
    fn measure(&self, work: &mut dyn FnMut()) -> Cost;
}

/// Nobody measures.
impl Meter for () {
    fn measures(&self) -> bool {
        false
    }

    fn measure(&self, work: &mut dyn FnMut()) -> Cost {
        work();
        Cost::default()
    }
}
