//! `modalign theory`: natural frequencies and shapes of a model.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::Error;
use crate::finding::{Code, Finding, Location, Severity};
use crate::io::modes_to_json;
use crate::report::json::{
    TheoryResults, details_to_json, response_to_json, sweeps_to_json, with_theory,
};
use crate::report::{
    Block, abridged, details_blocks, details_svg, energies_block, energies_svg, parameters_block,
    quantities_block, response_blocks, response_svg, roots_block, roots_screen,
    sensitivities_block, signal_details_svg, simplest_details_block, sweep_blocks, sweeps_svg,
    theory_block, without_whole_shares,
};
use crate::scene::{
    BeforeChanges, LoadedModel, ModelKind, ModesOptions, Scene, SceneError, Theory,
    built_in_name_finding, contradicted_support, first_root, load_model, load_modes, model_kind,
    table_model, theory as scene_theory,
};
use crate::theory::{ModeOptions, ModelQuantity};

use super::args::TheoryArgs;
use super::outcome::Outcome;
use super::output::{MODES_EXTENSIONS, Output, check_extension};
use super::scene_reading::SceneReading;
use super::targets::{check_targets, input_files, targets};
use super::what_if::what_if;

/// Prints the modes; writes them with `-o`.
pub fn theory(
    args: &TheoryArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let draws = is_figure(args.output.as_deref());
    check_output(args)?;
    check_targets(
        &targets([("-o", args.output.as_ref())]),
        &input_files(&args.model),
    )?;
    let (named, before) = ModelInput::load(args, format)?.modified(args)?;
    let mut result = match &named {
        ModelInput::Model { model, .. } => model.solve(&model.sensors, &options(args))?,
        ModelInput::Finished(theory) => {
            check_effect(args)?;
            modes_in_band(args, theory)
        }
    };
    if let (ModelInput::Model { model, .. }, true) = (&named, args.damped) {
        let undamped = std::mem::take(&mut result.modes.findings);
        result.modes = model.solve_damped(&model.sensors, args.band)?;
        result.modes.findings = undamped;
    }
    let json = modes_to_json(&result.modes, None);
    if let Some(path) = args.output.as_ref().filter(|_| !draws) {
        output.add_modes(path, &result.modes, &result.geometry, &json)?;
    }
    let mut blocks: Vec<Block> = parameters_block(&result.parameters).into_iter().collect();
    let name = args.model.display();
    blocks.push(if result.roots.is_empty() {
        theory_block(&format!("Modes of {name}"), &result.modes)
    } else {
        let caption = format!("Roots of {name}");
        roots_block(&caption, &result.roots, named.first_root(), args.band)
    });
    if args.damped {
        blocks.push(theory_block(
            &format!("Damped modes of {name}"),
            &result.modes,
        ));
    }
    let basic_count = blocks.len();
    let mut is_missed = false;
    let mut figure = None;
    let json = match &named {
        ModelInput::Model {
            model,
            first_root,
            scene,
        } => {
            let part = details(args, model, *first_root, &result, &mut blocks, output)?;
            let what_if = what_if(args, model, &before, scene, *first_root)?;
            let what_if = what_if.map(|found| {
                blocks.extend(found.blocks);
                is_missed = found.is_missed;
                found.json
            });
            let separate = separate_results(args, model, *first_root, &mut blocks)?;
            let (separate, drawn) =
                separate.map_or((None, None), |found| (Some(found.json), found.figure));
            if draws {
                let energies = || energies_svg(&result.roots, args.band);
                figure = drawn.or_else(|| energies().filter(|_| args.energies));
            }
            let special = what_if.or(separate).unwrap_or(json);
            if part.is_empty() {
                special
            } else {
                with_theory(&special, &part)
            }
        }
        ModelInput::Finished(_) => json,
    };
    if let Some(path) = args.output.as_ref().filter(|_| draws) {
        let figure = figure.ok_or_else(|| Error::Argument {
            argument: "-o",
            got: "nothing to draw".to_owned(),
            expected: "roots above 0 in the band, signals of a response, or a simpler model"
                .to_owned(),
        })?;
        output.add_file(path, figure);
    }
    let requested = blocks[basic_count..].to_vec();
    output.add_result(
        |width| match (requested.is_empty(), result.roots.is_empty(), args.damped) {
            (false, ..) => {
                let requested = requested.into_iter().map(without_whole_shares);
                abridged(requested.collect(), width)
            }
            (true, false, false) => {
                let caption = format!("Roots of {name}");
                roots_screen(
                    &caption,
                    &result.roots,
                    named.first_root(),
                    args.band,
                    width,
                )
            }
            (true, _, true) => {
                let caption = format!("Damped modes of {name}");
                abridged(vec![theory_block(&caption, &result.modes)], width)
            }
            (true, true, false) => {
                let caption = format!("Modes of {name}");
                abridged(vec![theory_block(&caption, &result.modes)], width)
            }
        },
        || blocks,
    );
    output.add_rest_note(match args.output {
        Some(_) => "Parameters and all columns: --full.",
        None => "Parameters and all columns: --full; modes with shapes to a file: -o FILE.",
    });
    output.add_json(|| json);
    output.add_findings(&result.modes.findings);
    output.add_findings(contradicted_support(&result, None).as_slice());
    output.add_findings(
        &built_in_name_finding(&args.model)
            .into_iter()
            .collect::<Vec<_>>(),
    );
    Ok(Outcome::missed_if(result.partly_bad || is_missed))
}

/// Extension of a figure.
const FIGURE_EXTENSION: &str = "svg";

fn is_figure(path: Option<&Path>) -> bool {
    let extension = path.and_then(Path::extension);
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case(FIGURE_EXTENSION))
}

/// Checks that the file can hold what was requested.
fn check_output(args: &TheoryArgs) -> Result<(), Error> {
    let path = args.output.as_deref();
    if !is_figure(path) {
        let mut extensions = MODES_EXTENSIONS.to_vec();
        extensions.push(FIGURE_EXTENSION);
        return check_extension(path, &extensions);
    }
    let drawn = [
        args.energies,
        args.response,
        args.compare.is_some(),
        !args.sweep.is_empty(),
    ];
    if drawn.into_iter().filter(|asked| *asked).count() == 1 {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "-o",
        got: path.unwrap_or(Path::new("")).display().to_string(),
        expected: "one of --sweep, --response, --compare and --energies beside a figure".to_owned(),
    })
}

/// The meaning of MODEL.
enum ModelInput {
    /// A model that can be solved; its sensors are those of the scene, too.
    Model {
        model: LoadedModel,
        /// Number of its first elastic root in tables.
        first_root: usize,
        /// The scene that names it.
        scene: Option<Box<Scene>>,
    },
    /// Finished modes.
    Finished(Box<Theory>),
}

impl ModelInput {
    fn load(args: &TheoryArgs, format: Option<&str>) -> Result<Self, SceneError> {
        let partial = args.partial;
        let settings: BTreeMap<String, f64> = args.settings.iter().cloned().collect();
        match model_kind(&args.model) {
            ModelKind::Scene => {}
            ModelKind::Modes if args.model.exists() => {
                let options = ModesOptions {
                    format,
                    partial,
                    ..ModesOptions::default()
                };
                let loaded = load_modes(&args.model, &options)?;
                return Ok(ModelInput::Finished(Box::new(loaded.into())));
            }
            _ => {
                let model = load_model(&args.model, &settings)?;
                return Ok(ModelInput::Model {
                    model,
                    first_root: first_root(&args.model),
                    scene: None,
                });
            }
        }
        let scene = SceneReading { format, partial }.scene(&args.model)?;
        let scene = scene.configuration(&args.configuration)?;
        let mut table = scene.model.clone().unwrap_or_default();
        table.parameters.extend(settings);
        let (folder, path) = (&scene.folder, &scene.path);
        let Some(mut model) = table_model(&table, folder, path)? else {
            let options = ModeOptions::default();
            let theory = scene_theory(&table, folder, path, &scene.sensors, &options)?;
            return Ok(ModelInput::Finished(Box::new(theory)));
        };
        model.sensors = model.sensors_with(&scene.sensors);
        Ok(ModelInput::Model {
            model,
            first_root: scene.first_root,
            scene: Some(Box::new(scene)),
        })
    }

    /// The model with the stated changes, and its values before them.
    fn modified(self, args: &TheoryArgs) -> Result<(Self, BeforeChanges), SceneError> {
        match self {
            ModelInput::Model {
                model,
                first_root,
                scene,
            } => {
                let modified = model.modified(&args.modify)?;
                let named = ModelInput::Model {
                    model: modified.model,
                    first_root,
                    scene,
                };
                Ok((named, modified.before))
            }
            finished => Ok((finished, BeforeChanges::default())),
        }
    }

    /// Number of the first elastic root in tables.
    fn first_root(&self) -> usize {
        match self {
            ModelInput::Model { first_root, .. } => *first_root,
            ModelInput::Finished(_) => 1,
        }
    }
}

fn options(args: &TheoryArgs) -> ModeOptions {
    ModeOptions {
        band: args.band,
        ..ModeOptions::default()
    }
}

/// Finished modes inside the band.
fn modes_in_band(args: &TheoryArgs, theory: &Theory) -> Theory {
    let mut theory = theory.clone();
    let kept = |hz: f64| args.band.is_none_or(|band| band.contains(hz));
    theory.modes.modes.retain(|mode| kept(mode.frequency_hz));
    theory
}

/// Rejects options that modes from a file cannot serve.
fn check_effect(args: &TheoryArgs) -> Result<(), Error> {
    let asked = [
        ("--set", !args.settings.is_empty()),
        ("--damped", args.damped),
        ("--energies", args.energies),
        ("--sensitivities", args.sensitivities),
        ("--quantities", args.quantities),
        ("--sweep", !args.sweep.is_empty()),
        ("--response", args.response),
        ("--compare", args.compare.is_some()),
        ("--modify", !args.modify.is_empty()),
        ("--target", !args.target.is_empty()),
    ];
    match asked.into_iter().find(|(_, asked)| *asked) {
        None => Ok(()),
        Some((argument, _)) => Err(Error::Argument {
            argument,
            got: format!("finished modes ({})", args.model.display()),
            expected: "a model with parameters: a built-in one or a model.toml".to_owned(),
        }),
    }
}

/// Energies, sensitivities and quantities.
fn details<'a>(
    args: &TheoryArgs,
    model: &LoadedModel,
    first_root: usize,
    result: &'a Theory,
    blocks: &mut Vec<Block>,
    output: &mut Output,
) -> Result<TheoryResults<'a>, Error> {
    let name = &args.model.display().to_string();
    let mut part = TheoryResults {
        parameters: &result.parameters,
        band: args.band,
        ..TheoryResults::default()
    };
    if args.energies {
        let caption = format!("Energy of the roots of {name}");
        blocks.extend(energies_block(
            &caption,
            &result.roots,
            first_root,
            args.band,
        ));
        part.energies = Some(&result.roots);
    }
    if args.sensitivities {
        let caption = format!("Sensitivities of the roots of {name}");
        let found = model.sensitivities(args.band)?;
        let block = sensitivities_block(&caption, &result.parameters, &found, args.band);
        blocks.push(block);
        part.sensitivities = Some(found);
    }
    if args.quantities {
        let found = model.quantities()?;
        if found.is_empty() {
            return Err(Error::Argument {
                argument: "--quantities",
                got: format!("a model without a theory beside its matrices ({name})"),
                expected: "a built-in model".to_owned(),
            });
        }
        let absent = found.iter().filter(|quantity| quantity.value.is_none());
        let finding = |quantity: &ModelQuantity| {
            let location = Location::Quantity(quantity.name.to_owned());
            Finding::new(Severity::Info, Code::QuantityAbsent, location)
        };
        output.add_findings(&absent.map(finding).collect::<Vec<_>>());
        blocks.extend(quantities_block(name, &found));
        part.quantities = Some(found);
    }
    Ok(part)
}

/// A result with a separate JSON, and its figure where there is something to draw.
struct SeparateResult {
    json: String,
    figure: Option<String>,
}

/// Responses, comparisons and sweeps, each with a separate JSON.
fn separate_results(
    args: &TheoryArgs,
    model: &LoadedModel,
    first_root: usize,
    blocks: &mut Vec<Block>,
) -> Result<Option<SeparateResult>, SceneError> {
    let name = &args.model.display().to_string();
    let within = args.compare.map(|percent| 0.01 * percent);
    if args.response || within.is_some() && model.model.nonlinear().is_some() {
        let found = model.response()?;
        blocks.extend(within.map(|within| simplest_details_block(name, &found, within)));
        blocks.extend(response_blocks(name, &found));
        return Ok(Some(SeparateResult {
            json: response_to_json(&found),
            figure: match within {
                Some(within) => signal_details_svg(name, &found, within),
                None => response_svg(name, &found),
            },
        }));
    }
    if let Some(within) = within {
        let found = model.compare_details()?;
        blocks.extend(details_blocks(name, &found, first_root, within));
        return Ok(Some(SeparateResult {
            json: details_to_json(&found, within),
            figure: details_svg(name, &found, args.band, within),
        }));
    }
    let mut sweeps = Vec::new();
    for (parameter, range) in &args.sweep {
        let swept = model.sweep(parameter, *range, args.band)?;
        blocks.extend(sweep_blocks(name, &swept, args.band));
        sweeps.push(swept);
    }
    Ok((!sweeps.is_empty()).then(|| SeparateResult {
        json: sweeps_to_json(&sweeps),
        figure: sweeps_svg(name, &sweeps, args.band),
    }))
}
