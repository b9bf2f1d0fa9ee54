//! The command line program; everything is in [`modalign::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    modalign::cli::main()
}
