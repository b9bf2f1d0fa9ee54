//! The command line program; everything is in [`modalign::cli`].

use std::process::ExitCode;

use cap::Cap;
use peak_alloc::PeakAlloc;

/// The system's allocator with a count of what is taken, for `modalign study`, and a limit.
#[global_allocator]
static MEMORY: Cap<PeakAlloc> = Cap::new(PeakAlloc, usize::MAX);

fn main() -> ExitCode {
    modalign::cli::main(|bytes| MEMORY.set_limit(bytes).is_ok())
}
