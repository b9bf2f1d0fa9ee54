//! `modalign correlate`: two sets of modes to the comparison table.

use std::path::Path;

use crate::correlate::measures::{
    DuplicateLimits, Orthogonality, Reduction, auto_mac, measures, orthogonality,
    orthogonality_dofs,
};
use crate::correlate::{CorrelateError, DofMap, DofNames, ErrorReference, PairOptions, Pairing};
use crate::dof::Dof;
use crate::error::Error;
use crate::geometry::{Geometry, Sensor};
use crate::io::write_whole;
use crate::modal::ModalModel;
use crate::report::{
    Block, auto_mac_blocks, json, measures_blocks, orthogonality_blocks, renderer_for_extension,
    whole_comparison,
};
use crate::scene::{
    LoadedModel, NamedTest, Scene, SceneError, Theory, compare_tests, holds_functions,
    is_modes_file, load_model, load_modes, read_text, table_model, theory,
};
use crate::theory::ModeOptions;

use super::Outcome;
use super::args::CorrelateArgs;
use super::correlate_frfs::correlate_frfs;
use super::output::{Output, check_extension};

/// Prints the table; writes it with `-o` in the format of the file's extension. FRFs are held against FRFs, a test without
/// a theory against itself.
pub fn correlate(
    args: &CorrelateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), &["md", "csv", "tex", "txt", "json"])?;
    let Some(theory) = &args.theory else {
        return itself(args, format, output);
    };
    if holds_functions(theory, format) {
        return correlate_frfs(args, theory, format, output);
    }
    if args.band.is_some() || args.lines.is_some() {
        return Err(Error::Argument {
            argument: "--band, --lines",
            got: format!("{}, which holds modes or is a model", theory.display()),
            expected: "FRFs on both sides".to_owned(),
        });
    }
    compared(args, theory, format, output)
}

/// Modes of tests against those of a theory.
fn compared(
    args: &CorrelateArgs,
    theory: &Path,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let options = pair_options(args)?;
    let reduction = args.orthogonality.as_deref().map(reduction).transpose()?;
    let mut tests = args
        .test
        .iter()
        .map(|path| Ok((path.display().to_string(), load(path, format)?.theory)))
        .collect::<Result<Vec<_>, Error>>()?;
    let Loaded { theory, model } = load(theory, format)?;
    let (theory, names) = tied(args, &mut tests, theory)?;
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
    let mut all = Vec::new();
    if args.measures || reduction.is_some() {
        for ((name, test), pairing) in tests.iter().zip(&comparison.pairings) {
            let mut own = measures(&test.modes, &theory.modes, pairing, &options)?;
            if let Some(reduction) = reduction {
                let sides = (&test.modes, &theory.modes);
                own.orthogonality = Some(through_mass(
                    model.as_ref(),
                    sides,
                    pairing,
                    (&names, reduction),
                )?);
            }
            all.push((name.clone(), own));
        }
    }
    let mut blocks = whole_comparison(&comparison.table, &theory);
    for (name, own) in &all {
        blocks.extend(if args.measures {
            measures_blocks(name, own)
        } else {
            orthogonality_blocks(name, own)
        });
    }
    let json = json::comparison_with_measures(&comparison.table, &all);
    print(args, (&blocks, json), output)?;
    let models = tests.iter().map(|(_, test)| &test.modes);
    for model in models.chain([&theory.modes]) {
        output.findings(&model.findings);
    }
    for (test, findings) in &comparison.findings {
        output.findings_of(test, findings);
    }
    Ok(Outcome::Done)
}

/// Every test against itself.
fn itself(
    args: &CorrelateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let options = pair_options(args)?;
    let mut all = Vec::new();
    for path in &args.test {
        let name = path.display().to_string();
        if holds_functions(path, format) {
            return Err(Error::Argument {
                argument: "--test",
                got: format!("{name}, which holds functions and no modes"),
                expected: "modes; or --theory with other FRFs".to_owned(),
            });
        }
        let test = load(path, format)?.theory.modes;
        let own = auto_mac(&test, DuplicateLimits::default(), &options)?;
        output.findings(&test.findings);
        output.findings_of(&name, &own.findings());
        all.push((name, own));
    }
    let blocks = all
        .iter()
        .flat_map(|(name, own)| auto_mac_blocks(name, own));
    let blocks: Vec<Block> = blocks.collect();
    print(args, (&blocks, json::auto_macs_to_json(&all)), output)?;
    Ok(Outcome::Done)
}

/// Prints a result, and writes it with `-o`.
pub(super) fn print(
    args: &CorrelateArgs,
    (blocks, json): (&[Block], String),
    output: &mut Output,
) -> Result<(), Error> {
    if let Some(path) = &args.output {
        write_whole(path, rendered(path, blocks, &json))?;
    }
    output.blocks(blocks);
    output.json(|| json);
    Ok(())
}

fn reduction(name: &str) -> Result<Reduction, Error> {
    Reduction::from_name(name).ok_or_else(|| Error::Argument {
        argument: "--orthogonality",
        got: name.to_owned(),
        expected: "guyan or serep".to_owned(),
    })
}

/// Orthogonality of a test with the theory, whose mass matrix is reduced to the sensors of both.
fn through_mass(
    model: Option<&SolvedModel>,
    (test, theory): (&ModalModel, &ModalModel),
    pairing: &Pairing,
    (names, reduction): (&Option<DofNames>, Reduction),
) -> Result<Orthogonality, Error> {
    let model = model.ok_or_else(|| Error::Argument {
        argument: "--orthogonality",
        got: "finished modes, which have no mass matrix".to_owned(),
        expected: "a model as --theory".to_owned(),
    })?;
    let common = orthogonality_dofs(test, theory, &pairing.map);
    let own = |dof: &Dof| {
        let named = names.as_ref().and_then(|names| names.in_theory(dof));
        named.unwrap_or(dof).clone()
    };
    let dofs: Vec<Dof> = common.iter().map(own).collect();
    let kept = pairing.pairs.iter().flat_map(|pair| pair.theory.iter());
    let kept: Vec<usize> = kept.copied().collect();
    let mass = model
        .model
        .reduced_mass(&model.sensors, &dofs, reduction, &kept)?;
    let found = orthogonality((test, theory), &pairing.map, &mass, &common)?;
    Ok(found)
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
) -> Result<(Theory, Option<DofNames>), Error> {
    if let Some(path) = &args.dof_map {
        let text = read_text(path)?;
        let names = DofNames::parse(&text).map_err(|error| list_error(path, &error))?;
        return Ok((renamed(&names, theory), Some(names)));
    }
    let (Some(tolerance), Some((_, first))) = (args.nearest_node, tests.first_mut()) else {
        return Ok((theory, None));
    };
    has_nodes(&args.test[0], &first.geometry)?;
    let path = args.theory.as_deref().unwrap_or(Path::new(""));
    has_nodes(path, &theory.geometry)?;
    let (names, finding) = DofNames::nearest(
        (&first.modes, &first.geometry),
        (&theory.modes, &theory.geometry),
        tolerance,
    );
    first.modes.findings.push(finding);
    Ok((renamed(&names, theory), Some(names)))
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

/// One side of a comparison, with the model that was solved where it is one.
struct Loaded {
    theory: Theory,
    model: Option<SolvedModel>,
}

/// A model with the sensors at which it was solved.
struct SolvedModel {
    model: LoadedModel,
    sensors: Vec<Sensor>,
}

/// Modes from a file that holds them; or a model solved at the sensors that its own file names, else at its coordinates;
/// or the model of a scene at the scene's sensors.
fn load(path: &Path, format: Option<&str>) -> Result<Loaded, SceneError> {
    let finished = |modes, geometry| Loaded {
        theory: Theory {
            modes,
            geometry,
            ..Theory::default()
        },
        model: None,
    };
    if is_modes_file(path) {
        let (modes, geometry) = load_modes(path, format)?;
        return Ok(finished(modes, geometry));
    }
    let (model, sensors) = if Scene::is_path(path) {
        let scene = Scene::load(path)?;
        let table = scene.model.clone().unwrap_or_default();
        let Some(model) = table_model(&table, &scene.folder, &scene.path)? else {
            let options = ModeOptions::default();
            let own = theory(&table, &scene.folder, &scene.path, &scene.sensors, &options)?;
            return Ok(finished(own.modes, own.geometry));
        };
        let sensors = model.sensors_with(&scene.sensors);
        (model, sensors)
    } else {
        let model = load_model(path, &Default::default())?;
        let sensors = model.sensors.clone();
        (model, sensors)
    };
    Ok(Loaded {
        theory: model.solve(&sensors, &ModeOptions::default())?,
        model: Some(SolvedModel { model, sensors }),
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
