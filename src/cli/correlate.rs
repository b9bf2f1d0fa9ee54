//! `modalign correlate`: two sets of modes to the comparison table.

use std::path::Path;

use crate::correlate::{ErrorReference, PairOptions};
use crate::error::Error;
use crate::io::{modes_from_json, write_whole};
use crate::report::{Block, json, renderer_for_extension, whole_comparison};
use crate::scene::{NamedTest, SceneError, Theory, compare_tests, load_model, read_text};
use crate::theory::ModeOptions;

use super::Outcome;
use super::args::CorrelateArgs;
use super::output::{Output, check_extension};

/// Prints the table; writes it with `-o` in the format of the file's extension.
pub fn correlate(args: &CorrelateArgs, output: &mut Output) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), &["md", "csv", "tex", "txt", "json"])?;
    let options = pair_options(args)?;
    let tests = args
        .test
        .iter()
        .map(|path| Ok((path.display().to_string(), load(path)?.modes)))
        .collect::<Result<Vec<_>, Error>>()?;
    let theory = load(&args.theory)?;
    let named: Vec<_> = tests
        .iter()
        .map(|(name, modes)| NamedTest {
            name,
            modes,
            frfs: &[],
        })
        .collect();
    let comparison = compare_tests(&theory.modes, &named, &options)?;
    let blocks = whole_comparison(&comparison.table, &theory);
    let json = json::comparison_to_json(&comparison.table);
    if let Some(path) = &args.output {
        let text = rendered(path, &blocks, &json);
        write_whole(path, text)?;
    }
    output.blocks(&blocks);
    output.json(&json);
    for model in tests.iter().map(|(_, modes)| modes).chain([&theory.modes]) {
        output.findings(&model.findings);
    }
    for (test, findings) in &comparison.findings {
        output.findings_of(test, findings);
    }
    Ok(Outcome::Done)
}

fn pair_options(args: &CorrelateArgs) -> Result<PairOptions, Error> {
    let mut options = PairOptions::default();
    if let Some(name) = &args.error_reference {
        options.error_reference =
            ErrorReference::from_name(name).ok_or_else(|| Error::Argument {
                argument: "--error-reference",
                got: name.clone(),
                expected: "theory or test".to_owned(),
            })?;
    }
    options.max_frequency_error = args
        .max_frequency_error
        .unwrap_or(options.max_frequency_error);
    options.min_mac = args.min_mac.unwrap_or(options.min_mac);
    Ok(options)
}

/// Modes from a `modes.json`, or a model solved at the sensors that its own file names, else at its coordinates.
fn load(path: &Path) -> Result<Theory, SceneError> {
    if path.extension().is_none_or(|extension| extension != "json") {
        let model = load_model(path, &Default::default())?;
        return model.solve(&model.sensors, &ModeOptions::default());
    }
    let modes = modes_from_json(&read_text(path)?, &path.display().to_string())?;
    Ok(Theory {
        modes,
        ..Theory::default()
    })
}

fn rendered(path: &Path, blocks: &[Block], json: &str) -> String {
    let extension = path
        .extension()
        .and_then(|extension| extension.to_str())
        .unwrap_or("")
        .to_lowercase();
    match renderer_for_extension(&extension) {
        // A reader of CSV expects one table.
        Some(renderer) if renderer.name() == "csv" => renderer.render(&blocks[..1]),
        Some(renderer) => renderer.render(blocks),
        None => json.to_owned(),
    }
}
