//! `modalign man`: manual pages of the program and of each verb.

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use crate::error::Error;

use super::args::{Cli, ManArgs};
use super::outcome::Outcome;
use super::output::Output;

/// Prints the page of the program, or writes those of the program and of all verbs.
pub fn man(args: &ManArgs, output: &mut Output) -> Result<Outcome, Error> {
    let program = Cli::command();
    let Some(folder) = &args.output else {
        output.add_text(&String::from_utf8_lossy(&page(program)?));
        return Ok(Outcome::Done);
    };
    for verb in program.get_subcommands() {
        let name = format!("modalign-{}", verb.get_name());
        let command = verb.clone().display_name(&name);
        let command = command.bin_name(format!("modalign {}", verb.get_name()));
        output.add_file(folder.join(format!("{name}.1")), page(command)?);
    }
    output.add_file(folder.join("modalign.1"), page(program)?);
    Ok(Outcome::Done)
}

fn page(command: Command) -> Result<Vec<u8>, Error> {
    let mut text = Vec::new();
    Man::new(command).render(&mut text).map_err(Error::Output)?;
    Ok(text)
}
