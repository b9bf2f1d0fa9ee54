//! `modalign correlate`: two sets of modes to the comparison table.

use std::path::Path;

use crate::correlate::{CorrelateError, DofMap, DofNames, ErrorReference, PairOptions};
use crate::error::Error;
use crate::geometry::Geometry;
use crate::io::write_whole;
use crate::modal::ModalModel;
use crate::report::{Block, json, renderer_for_extension, whole_comparison};
use crate::scene::{
    NamedTest, Scene, SceneError, Theory, compare_tests, is_modes_file, load_model, load_modes,
    read_text, theory,
};
use crate::theory::ModeOptions;

use super::Outcome;
use super::args::CorrelateArgs;
use super::output::{Output, check_extension};

/// Prints the table; writes it with `-o` in the format of the file's extension.
pub fn correlate(
    args: &CorrelateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), &["md", "csv", "tex", "txt", "json"])?;
    let options = pair_options(args)?;
    let mut tests = args
        .test
        .iter()
        .map(|path| Ok((path.display().to_string(), load(path, format)?)))
        .collect::<Result<Vec<_>, Error>>()?;
    let theory = load(&args.theory, format)?;
    let theory = tied(args, &mut tests, theory)?;
    for (name, test) in &tests {
        has_common(name, &test.modes, &theory.modes)?;
    }
    let named: Vec<_> = tests
        .iter()
        .map(|(name, test)| NamedTest {
            name,
            modes: &test.modes,
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
    output.json(|| json);
    for model in tests
        .iter()
        .map(|(_, test)| &test.modes)
        .chain([&theory.modes])
    {
        output.findings(&model.findings);
    }
    for (test, findings) in &comparison.findings {
        output.findings_of(test, findings);
    }
    Ok(Outcome::Done)
}

/// Shapes on both sides without one common degree of freedom have other names, or are of another machine.
fn has_common(name: &str, test: &ModalModel, theory: &ModalModel) -> Result<(), Error> {
    let example = |model: &ModalModel| {
        let mut shapes = model.modes.iter().flat_map(|mode| mode.shape.iter());
        shapes.next().map(|(dof, _)| dof.to_string())
    };
    let (Some(own), Some(other)) = (example(test), example(theory)) else {
        return Ok(());
    };
    if !DofMap::of_models(test, theory).is_empty() {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "--test",
        got: format!(
            "{name}, which has no degree of freedom in common with the theory ({own}, ... and {other}, ...)"
        ),
        expected: "common names; or tie them with --dof-map FILE or --nearest-node METRES"
            .to_owned(),
    })
}

/// The theory under the names of the test, where the names differ. With several tests all must have the first one's.
fn tied(
    args: &CorrelateArgs,
    tests: &mut [(String, Theory)],
    theory: Theory,
) -> Result<Theory, Error> {
    if let Some(path) = &args.dof_map {
        let text = read_text(path)?;
        let names = DofNames::parse(&text).map_err(|error| list_error(path, &error))?;
        return Ok(renamed(&names, theory));
    }
    let (Some(tolerance), Some((_, first))) = (args.nearest_node, tests.first_mut()) else {
        return Ok(theory);
    };
    has_nodes(&args.test[0], &first.geometry)?;
    has_nodes(&args.theory, &theory.geometry)?;
    let (names, finding) = DofNames::nearest(
        (&first.modes, &first.geometry),
        (&theory.modes, &theory.geometry),
        tolerance,
    );
    first.modes.findings.push(finding);
    Ok(renamed(&names, theory))
}

fn renamed(names: &DofNames, theory: Theory) -> Theory {
    Theory {
        modes: names.rename(&theory.modes),
        ..theory
    }
}

fn list_error(path: &Path, error: &CorrelateError) -> Error {
    Error::Argument {
        argument: "--dof-map",
        got: format!("{}: {error}", path.display()),
        expected: "a file with a line TEST,THEORY for each pair".to_owned(),
    }
}

fn has_nodes(path: &Path, geometry: &Geometry) -> Result<(), Error> {
    if !geometry.nodes.is_empty() {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "--nearest-node",
        got: format!("{} without a position of any point", path.display()),
        expected: "a file with nodes (universal datasets 15 or 2411), or a model with sensors at positions".to_owned(),
    })
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

/// Modes from a file that holds them; or a model solved at the sensors that its own file names, else at its coordinates;
/// or the model of a scene at the scene's sensors.
fn load(path: &Path, format: Option<&str>) -> Result<Theory, SceneError> {
    if is_modes_file(path) {
        let (modes, geometry) = load_modes(path, format)?;
        return Ok(Theory {
            modes,
            geometry,
            ..Theory::default()
        });
    }
    let options = ModeOptions::default();
    if Scene::is_path(path) {
        let scene = Scene::load(path)?;
        let table = scene.model.clone().unwrap_or_default();
        return theory(&table, &scene.folder, &scene.path, &scene.sensors, &options);
    }
    let model = load_model(path, &Default::default())?;
    model.solve(&model.sensors, &options)
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
