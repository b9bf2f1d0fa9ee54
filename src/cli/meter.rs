//! Processor time and memory, as studies measure work.

use cpu_time::ProcessTime;
use peak_alloc::PeakAlloc;

use crate::study::{Cost, Meter};

/// Measures by the processor's clock of the whole process and the counters of the allocator that
/// the program runs on.
pub struct ProcessMeter;

impl Meter for ProcessMeter {
    fn measure(&self, work: &mut dyn FnMut()) -> Cost {
        let before = PeakAlloc.current_usage();
        PeakAlloc.reset_peak_usage();
        let begin = ProcessTime::now();
        work();
        let cpu_s = begin.elapsed().as_secs_f64();
        let taken = PeakAlloc.peak_usage().saturating_sub(before);
        Cost {
            cpu_s: Some(cpu_s),
            // Nothing is counted where another allocator was chosen.
            peak_bytes: u64::try_from(taken).ok().filter(|_| before > 0),
        }
    }
}
