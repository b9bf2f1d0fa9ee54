//! `modalign man`: manual pages of the program and of each verb.

use std::path::Path;

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use crate::error::Error;

use super::args::{Cli, ManArgs};
use super::outcome::Outcome;
use super::output::Output;

/// Prints the page of the program, or writes those of the program, of all verbs and studies.
pub fn man(args: &ManArgs, output: &mut Output) -> Result<Outcome, Error> {
    let program = Cli::command().disable_help_subcommand(true);
    match &args.output {
        None => output.add_text(&String::from_utf8_lossy(&page(&program, &["modalign"])?)),
        Some(folder) => add_pages(&program, &["modalign"], folder, output)?,
    }
    Ok(Outcome::Done)
}

/// Adds the page of a command, which is typed as these words, and those of its subcommands.
fn add_pages(
    command: &Command,
    words: &[&str],
    folder: &Path,
    output: &mut Output,
) -> Result<(), Error> {
    for verb in command.get_subcommands() {
        let words = [words, &[verb.get_name()]].concat();
        add_pages(verb, &words, folder, output)?;
    }
    let file = folder.join(format!("{}.1", words.join("-")));
    output.add_file(file, page(command, words)?);
    Ok(())
}

fn page(command: &Command, words: &[&str]) -> Result<Vec<u8>, Error> {
    let command = command.clone().disable_help_subcommand(true);
    let command = command.display_name(words.join("-"));
    let mut text = Vec::new();
    Man::new(command.bin_name(words.join(" ")))
        .render(&mut text)
        .map_err(Error::Output)?;
    Ok(text)
}
