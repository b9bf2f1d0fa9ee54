//! The command line program; everything is in [`modalign::cli`].

use std::process::ExitCode;

use peak_alloc::PeakAlloc;

/// The system's allocator with a count of what is taken, which `modalign study` tells.
#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fn main() -> ExitCode {
    modalign::cli::main()
}
