//! The command line: arguments as typed, one file per verb, standard output and exit codes.

mod args;
mod breakdown;
mod check;
mod check_update;
mod color;
mod completions;
mod convert;
mod correlate;
mod correlate_dofs;
mod correlate_frfs;
mod correlation_output;
mod finding_lines;
mod first_names;
mod frf;
mod hint;
mod identify;
mod inspect;
mod interrupt;
mod junit;
mod left_out;
mod man;
mod memory_limit;
mod meter;
mod new;
mod new_points;
mod new_steps;
mod not_compared;
#[cfg(test)]
mod option_names_tests;
mod order;
mod outcome;
mod output;
mod progress;
mod report;
mod run;
mod scene_reading;
mod speed_accuracy;
mod study;
mod study_args;
mod synth;
mod targets;
mod test_stem;
mod theory;
mod update;
mod watch;
mod what_if;
mod wrapping;

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{ArgMatches, CommandFactory, FromArgMatches};

use crate::error::Error;
use crate::printable::printable_message;
use crate::scene::check_confined;

use args::{Cli, Verb};
use hint::hint;
use interrupt::report_files_that_are_too_long;
use outcome::Outcome;
use output::Output;
use wrapping::{DEFAULT_WIDTH, error_width, output_width, wrapped};

/// Runs the program on the process's arguments; the exit code is 0 done, 1 a limit missed or input
/// partly bad, 2 error. `limit_memory` sets the most bytes that the program may hold, and returns
/// whether it could.
pub fn main(limit_memory: impl FnOnce(usize) -> bool) -> ExitCode {
    report_files_that_are_too_long();
    let matches = match Cli::command().try_get_matches_from(arguments()) {
        Ok(matches) => matches,
        Err(text) => return print_clap(&text),
    };
    let cli = match Cli::from_arg_matches(&matches) {
        Ok(cli) => cli,
        Err(error) => return print_clap(&error),
    };
    let mut output = Output::new(&cli.global, matches.subcommand_name().unwrap_or_default());
    let result = check_features(&matches)
        .and_then(|()| check_output_names(&matches))
        .and_then(|()| memory_limit::set(cli.global.max_memory.as_deref(), limit_memory))
        .and_then(|()| start_threads(&cli))
        .and_then(|()| dispatch(&cli, &mut output));
    output.end_progress();
    let result = result.and_then(|outcome| match output.finish() {
        // The reader of standard output has gone away: the outcome stays.
        Err(error) if !error.is_broken_pipe() => Err(error),
        _ => Ok(outcome),
    });
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Missed) => ExitCode::from(1),
        // The reader of a verb that watches, which has no outcome before its end.
        Err(error) if error.is_broken_pipe() => ExitCode::SUCCESS,
        Err(error) => {
            let line = format!("error: {error}{}", hint(&error));
            let line = printable_message(&line).into_owned();
            let stderr = std::io::stderr();
            // A program reads lines as they are.
            let line = match error_width() {
                Some(width) => wrapped(&line, width),
                None => line,
            };
            let paints = cli.global.color.is_enabled_on(&stderr);
            let line = if paints {
                color::color_message(&line)
            } else {
                line
            };
            let _ = writeln!(&stderr, "{line}");
            ExitCode::from(2)
        }
    }
}

/// Prints the help, the version or an error of the arguments.
fn print_clap(text: &clap::Error) -> ExitCode {
    let printed = text.print().and_then(|()| std::io::stdout().flush());
    match printed {
        Err(error) if !text.use_stderr() && error.kind() != ErrorKind::BrokenPipe => {
            let _ = writeln!(std::io::stderr(), "error: {}", Error::Output(error));
            ExitCode::from(2)
        }
        _ => ExitCode::from(u8::try_from(text.exit_code()).unwrap_or(2)),
    }
}

/// Options that name an output, as the parser and as the user name them.
const OUTPUT_OPTIONS: [(&str, &str); 6] = [
    ("output", "-o"),
    ("junit", "--junit"),
    ("expand", "--expand"),
    ("lines", "--lines"),
    ("indicators", "--indicators"),
    ("stabilization", "--stabilization"),
];

/// An error for an output of the name that other programs give to standard output.
fn check_output_names(matches: &ArgMatches) -> Result<(), Error> {
    for (name, argument) in OUTPUT_OPTIONS {
        let path = matches.try_get_one::<PathBuf>(name).ok().flatten();
        if path.is_some_and(|path| path == Path::new("-")) {
            return Err(Error::Argument {
                argument,
                got: "-".to_owned(),
                expected: "the name of a file or folder; standard output is /dev/stdout".to_owned(),
            });
        }
    }
    match matches.subcommand() {
        Some((_, arguments)) => check_output_names(arguments),
        None => Ok(()),
    }
}

/// The arguments of the process. `--explain CODE` needs no other one, so that of a verb's arguments
/// only the options of the explanation remain.
fn arguments() -> Vec<OsString> {
    let all: Vec<OsString> = std::env::args_os().collect();
    let is_option = |argument: &OsString, name: &str| {
        let text = argument.to_string_lossy();
        text == name || text.starts_with(&format!("{name}="))
    };
    let end = all.iter().position(|argument| argument == "--");
    let options = &all[..end.unwrap_or(all.len())];
    if !options
        .iter()
        .any(|argument| is_option(argument, "--explain"))
    {
        return all;
    }
    let mut kept: Vec<OsString> = options.first().cloned().into_iter().collect();
    for (index, argument) in options.iter().enumerate().skip(1) {
        let names = ["--explain", "--lang", "--color"];
        if let Some(name) = names.iter().find(|name| is_option(argument, name)) {
            kept.push(argument.clone());
            let value = options.get(index + 1).filter(|_| argument == *name);
            kept.extend(value.cloned());
        }
    }
    kept
}

/// An error for an option whose feature this program was built without.
fn check_features(matches: &ArgMatches) -> Result<(), Error> {
    if cfg!(feature = "png") || !wants_png(matches) {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "--png",
        got: "a program that was built without PNG".to_owned(),
        expected: "one that was built with it: `cargo install --path . --features png`, or \
                   `cargo run --release --features png -- ...`. SVG figures are written without"
            .to_owned(),
    })
}

fn wants_png(matches: &ArgMatches) -> bool {
    let flag = matches.try_get_one::<bool>("png").ok().flatten();
    let verb = matches.subcommand();
    flag == Some(&true) || verb.is_some_and(|(_, arguments)| wants_png(arguments))
}

/// Maximum number of threads where the machine has fewer cores. Larger: starting them takes seconds
/// and much memory before the first result. Smaller: it refuses machines of today.
const MAX_THREADS: usize = 1024;
/// Maximum number of threads for each core of a larger machine.
const MAX_THREADS_PER_CORE: usize = 4;
/// The number of threads where `--threads` is not given.
const THREADS_VARIABLE: &str = "RAYON_NUM_THREADS";

/// Starts the wanted number of threads; verbs that compute nothing need none.
fn start_threads(cli: &Cli) -> Result<(), Error> {
    let variable = std::env::var_os(THREADS_VARIABLE).filter(|text| !text.is_empty());
    let (argument, stated) = match (cli.global.threads, variable) {
        (None, Some(text)) => (THREADS_VARIABLE, Some(text.to_string_lossy().into_owned())),
        (threads, _) => ("--threads", threads.map(|threads| threads.to_string())),
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = stated
        .as_ref()
        .map_or(Ok(cores), |text| text.trim().parse());
    let error = |expected: String| Error::Argument {
        argument,
        got: stated.clone().unwrap_or(cores.to_string()),
        expected,
    };
    let most = MAX_THREADS.max(MAX_THREADS_PER_CORE * cores);
    let threads = threads.ok().filter(|threads| (1..=most).contains(threads));
    let threads = threads.ok_or_else(|| error(format!("a number of threads from 1 to {most}")))?;
    let needs_none = matches!(
        cli.verb,
        None | Some(Verb::Inspect(_) | Verb::Check(_) | Verb::Completions(_) | Verb::Man(_))
    );
    if needs_none || cli.global.explain.is_some() {
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let started = pool.build_global();
    started.map_err(|_| error("as many threads as the system can start".to_owned()))
}

fn dispatch(cli: &Cli, output: &mut Output) -> Result<Outcome, Error> {
    if let Some(code) = cli.global.explain {
        let language = output.language();
        let sentence = format!("{}: {}", code.name(), language.sentence(code));
        let explanation = language.explanation(code);
        let width = output_width().unwrap_or(DEFAULT_WIDTH);
        output.add_text(&wrapped(&format!("{sentence}\n\n{explanation}"), width));
        return Ok(Outcome::Done);
    }
    if cli.global.confine {
        for path in cli.verb.iter().flat_map(Verb::scenes_and_models) {
            check_confined(path)?;
        }
    }
    let format = cli.global.format.as_deref();
    match &cli.verb {
        Some(Verb::Run(args)) => run::run(args, format, output),
        Some(Verb::Inspect(args)) => inspect::inspect(args, format, output),
        Some(Verb::Convert(args)) => convert::convert(args, format, output),
        Some(Verb::Frf(args)) => match &args.watch {
            Some(folder) => watch::watch(args, folder, format, output),
            None => frf::frf(args, format, output),
        },
        Some(Verb::Identify(args)) => identify::identify(args, format, output),
        Some(Verb::Theory(args)) => theory::theory(args, format, output),
        Some(Verb::Correlate(args)) => correlate::correlate(args, format, output),
        Some(Verb::Update(args)) => update::update(args, format, output),
        Some(Verb::Synth(args)) => synth::synth(args, output),
        Some(Verb::Study(args)) => study::study(args, format, output),
        Some(Verb::Report(args)) => report::report(args, output),
        Some(Verb::Check(args)) => check::check(args, output),
        Some(Verb::New(args)) => new::new(args, format, output),
        Some(Verb::Completions(args)) => Ok(completions::completions(args, output)),
        Some(Verb::Man(args)) => man::man(args, output),
        None => {
            output.add_text(&Cli::command().render_help().to_string());
            Ok(Outcome::Done)
        }
    }
}
