//! `modalign completions`: a script for a shell.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::Outcome;
use super::args::Cli;
use super::output::Output;

/// `completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  modalign completions bash > modalign.bash      # bash: to be sourced, or put among its completions"
)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: Shell,
}

/// Prints the script.
pub fn completions(args: &CompletionsArgs, output: &mut Output) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "modalign", &mut script);
    output.text(&String::from_utf8_lossy(&script));
    Outcome::Done
}
