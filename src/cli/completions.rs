//! `modalign completions`: a script for a shell.

use clap::CommandFactory;

use super::args::{Cli, CompletionsArgs};
use super::outcome::Outcome;
use super::output::Output;

/// Prints the script.
pub fn completions(args: &CompletionsArgs, output: &mut Output) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "modalign", &mut script);
    output.add_text(&String::from_utf8_lossy(&script));
    Outcome::Done
}
