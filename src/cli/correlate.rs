//! `modalign correlate`: two sets of modes to the comparison table.

use std::path::Path;

use crate::correlate::measures::{
    AutoMac, DuplicateLimits, Measures, Orthogonality, ReducedMass, Reduction, ReversedSensor,
    auto_mac, expansion_modes, measures, orthogonality, orthogonality_dofs, reverse_sensors,
    reversed_findings, reversed_sensors, serep_modes,
};
use crate::correlate::{
    CorrelateError, DofNames, ErrorReference, PairOptions, Pairing, Reading, expand_shapes,
};
use crate::dof::Dof;
use crate::error::Error;
use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::{Geometry, Sensor};
use crate::io::modes_to_json;
use crate::modal::ModalModel;
use crate::report::{
    abridged, alignment_block, auto_mac_blocks, comparison_of_all_tests,
    comparison_page_of_all_tests, comparison_screen, counts_block, json, measures_blocks,
    orthogonality_blocks, reversed_sensors_block, tables_with_values,
};
use crate::scene::{
    LoadedModel, ModelKind, ModesOptions, NamedTest, SceneError, Theory, built_in_name_finding,
    compare_tests, contradicted_support, first_root, has_functions_only, load_model, load_modes,
    model_kind, table_model, theory,
};
use crate::theory::ModeOptions;

use super::args::CorrelateArgs;
use super::correlate_dofs::{MatchedTheory, check_common_dofs, has_no_common_dof, match_dofs};
use super::correlate_frfs::correlate_frfs;
use super::correlation_output::{CorrelationOutput, print};
use super::outcome::Outcome;
use super::output::{MODES_EXTENSIONS, Output, check_extension};
use super::scene_reading::SceneReading;
use super::targets::check_correlate_targets;

/// Prints the table; writes it with `-o` in the format of the file's extension. FRFs are
/// compared with FRFs, a test without a theory with itself.
pub fn correlate(
    args: &CorrelateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(
        args.output.as_deref(),
        &["md", "csv", "tex", "txt", "html", "json"],
    )?;
    let Some(theory) = &args.theory else {
        return compare_with_itself(args, format, output);
    };
    if model_kind(theory) != ModelKind::BuiltIn && has_functions_only(theory, format) {
        return correlate_frfs(args, theory, format, output);
    }
    if args.band.is_some() || args.lines.is_some() {
        return Err(Error::Argument {
            argument: "--band, --lines",
            got: format!("{}, which holds modes or is a model", theory.display()),
            expected: "FRFs on both sides".to_owned(),
        });
    }
    compare_with_theory(args, theory, format, output)
}

/// Compares the modes of tests with those of a theory.
fn compare_with_theory(
    args: &CorrelateArgs,
    theory: &Path,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_correlate_targets(args, false)?;
    let options = pair_options(args)?;
    let reduction = args
        .orthogonality
        .as_deref()
        .map(parse_reduction)
        .transpose()?;
    check_extension(args.expand.as_deref(), MODES_EXTENSIONS)?;
    if args.expand.is_some() && args.test.len() > 1 {
        return Err(Error::Argument {
            argument: "--expand",
            got: format!("{} tests", args.test.len()),
            expected: "one".to_owned(),
        });
    }
    let mut tests = args
        .test
        .iter()
        .map(|path| Ok((path.display().to_string(), load(path, args, format)?.theory)))
        .collect::<Result<Vec<_>, Error>>()?;
    let Loaded {
        theory,
        model,
        first_root,
    } = load(theory, args, format)?;
    let loaded = tests.iter().map(|(_, test)| test).chain([&theory]);
    let partly_bad = loaded.into_iter().any(|loaded| loaded.partly_bad);
    let MatchedTheory {
        theory,
        names,
        alignment,
    } = match_dofs(args, &mut tests, theory, &options)?;
    let states_no_sensors = model.as_ref().is_some_and(|model| model.sensors.is_empty());
    let mut without_sensors = false;
    let mut reversed = Vec::new();
    for (name, test) in &mut tests {
        if states_no_sensors && has_no_common_dof(&test.modes, &theory.modes) {
            let code = Code::ModelWithoutSensors;
            let finding = Finding::new(Severity::Warning, code, Location::Whole);
            test.modes.findings.push(finding);
            without_sensors = true;
            reversed.push((name.clone(), Vec::new()));
            continue;
        }
        check_common_dofs(name, &test.modes, &theory.modes)?;
        let sensors = correct_reversed_sensors(args, &mut test.modes, &theory.modes, &options)?;
        reversed.push((name.clone(), sensors));
    }
    let named: Vec<_> = tests
        .iter()
        .map(|(name, test)| NamedTest {
            name,
            modes: &test.modes,
            frfs: &[],
        })
        .collect();
    let mut comparison = compare_tests(&theory.modes, &named, &options)?;
    comparison.table = comparison.table.labelled_from(first_root);
    let requested = RequestedResults {
        args,
        reduction,
        options: &options,
        theory: &theory.modes,
        model: model.as_ref(),
        names: names.as_ref(),
    };
    let mut all = Vec::new();
    for ((name, test), pairing) in tests.iter().zip(&comparison.pairings) {
        let measures = requested.measures(&test.modes, pairing, output)?;
        all.extend(measures.map(|measures| (name.clone(), measures)));
    }
    let mut blocks = comparison_of_all_tests(&comparison.table, &theory);
    let comparison_count = blocks.len();
    for (name, measures) in &all {
        blocks.extend(if args.measures {
            measures_blocks(name, measures)
        } else {
            orthogonality_blocks(name, measures)
        });
    }
    blocks.extend(alignment.as_ref().map(alignment_block));
    blocks.extend(reversed_sensors_block(&reversed, args.turn_reversed));
    let json = json::comparison_with(
        &comparison.table,
        &json::ExtraResults {
            measures: &all,
            reversed: &reversed,
            alignment: alignment.as_ref(),
            ..json::ExtraResults::default()
        },
    );
    let further = blocks[comparison_count..].to_vec();
    let screen = |width: usize| {
        if further.is_empty() {
            return comparison_screen(&comparison.table, width);
        }
        // The requested measures have the room of the modes.
        let mut table = vec![counts_block(&comparison.table, width)];
        table.extend(tables_with_values(further.clone()));
        abridged(table, width)
    };
    let mut page = comparison_page_of_all_tests(&comparison.table, &theory);
    page.extend(further.clone());
    let has_pairs = comparison.table.summary.iter().any(|test| test.paired > 0);
    let next = (without_sensors && has_pairs).then(|| next_with_sensors(args));
    let printed = CorrelationOutput::of_blocks(blocks, json)
        .with_page(page)
        .with_next(next);
    print(args, printed, Some(&screen), output);
    let named_models = args.test.iter().chain(&args.theory);
    let taken: Vec<Finding> = named_models
        .filter_map(|path| built_in_name_finding(path))
        .collect();
    output.add_findings(&taken);
    let models = tests.iter().map(|(_, test)| &test.modes);
    for model in models.chain([&theory.modes]) {
        output.add_findings(&model.findings);
    }
    for (name, measures) in &all {
        let orthogonality = measures.orthogonality.as_ref();
        output.add_findings_of(
            name,
            &orthogonality.map_or_else(Vec::new, Orthogonality::findings),
        );
    }
    for (test, findings) in &comparison.findings {
        output.add_findings_of(test, findings);
    }
    output.add_findings(contradicted_support(&theory, Some(&comparison.table)).as_slice());
    Ok(Outcome::missed_if(
        partly_bad || comparison.table.is_empty(),
    ))
}

/// The step after a comparison with a model without sensors.
fn next_with_sensors(args: &CorrelateArgs) -> String {
    let model = args.theory.as_ref();
    let model = model.map_or(String::new(), |path| path.display().to_string());
    format!(
        "Next, as {model} states no sensors and pairs are by frequency alone: --theory FOLDER of the scene with its [[sensor]], or [[sensor]] in the model file."
    )
}

/// The reversed sensors of a test, corrected where that is requested; else the pairing reports
/// them.
fn correct_reversed_sensors(
    args: &CorrelateArgs,
    test: &mut ModalModel,
    theory: &ModalModel,
    options: &PairOptions,
) -> Result<Vec<ReversedSensor>, Error> {
    let found = reversed_sensors(test, theory, options)?;
    if args.turn_reversed {
        let dofs: Vec<Dof> = found.iter().map(|sensor| sensor.dof.clone()).collect();
        *test = reverse_sensors(test, &dofs);
        test.findings.extend(reversed_findings(&found, true));
    }
    Ok(found)
}

/// Compares every test with itself.
fn compare_with_itself(
    args: &CorrelateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let options = pair_options(args)?;
    check_correlate_targets(args, true)?;
    let (mut all, mut partly_bad) = (Vec::new(), false);
    for path in &args.test {
        let name = path.display().to_string();
        if has_functions_only(path, format) {
            return Err(Error::Argument {
                argument: "--test",
                got: format!("{name}, which holds functions and no modes"),
                expected: "modes; or --theory with other FRFs".to_owned(),
            });
        }
        let Theory {
            modes: test,
            partly_bad: is_bad,
            ..
        } = load(path, args, format)?.theory;
        partly_bad |= is_bad;
        let duplicates = auto_mac(&test, DuplicateLimits::default(), &options)?;
        output.add_findings(&test.findings);
        output.add_findings_of(&name, &duplicates.findings());
        all.push((name, duplicates));
    }
    let of_test = |(name, auto_mac): &(String, AutoMac)| auto_mac_blocks(name, auto_mac);
    let printed = CorrelationOutput::of_tests(
        all.iter().map(of_test).collect(),
        json::auto_macs_to_json(&all),
    );
    print(args, printed, None, output);
    Ok(Outcome::missed_if(partly_bad))
}

fn parse_reduction(name: &str) -> Result<Reduction, Error> {
    Reduction::from_name(name).ok_or_else(|| Error::Argument {
        argument: "--orthogonality",
        got: name.to_owned(),
        expected: "guyan or serep".to_owned(),
    })
}

/// Results that are requested in addition to the table.
struct RequestedResults<'a> {
    args: &'a CorrelateArgs,
    reduction: Option<Reduction>,
    options: &'a PairOptions,
    theory: &'a ModalModel,
    model: Option<&'a SolvedModel>,
    names: Option<&'a DofNames>,
}

impl RequestedResults<'_> {
    /// The measures of a test, where they are requested; its expand_shapes shapes go to their file.
    fn measures(
        &self,
        test: &ModalModel,
        pairing: &Pairing,
        output: &mut Output,
    ) -> Result<Option<Measures>, Error> {
        let (args, paired) = (self.args, paired_theory_modes(pairing));
        // A static reduction keeps no modes: orthogonality reuses the one of the expansion.
        let mut mass_of_expansion = None;
        if let Some(path) = &args.expand {
            let reduction = self.reduction.unwrap_or(Reduction::Serep);
            let dofs = orthogonality_dofs(test, self.theory, &pairing.map);
            let kept = match reduction {
                Reduction::Serep => {
                    let modes = expansion_modes(self.theory, &dofs, &paired);
                    output.add_findings(modes.finding().as_slice());
                    modes.kept
                }
                Reduction::Guyan => paired.clone(),
            };
            let (model, mass) = self.reduced_mass(dofs, reduction, &kept)?;
            let all = model.model.coordinate_dofs()?;
            let expanded_modes = expand_shapes(test, &pairing.map, &mass, &all)?;
            let json = modes_to_json(&expanded_modes, None);
            output.add_modes(path, &expanded_modes, &Geometry::default(), &json)?;
            mass_of_expansion = Some((kept, mass));
        }
        if !args.measures && self.reduction.is_none() {
            return Ok(None);
        }
        let mut measured = measures(test, self.theory, pairing, self.options)?;
        if let Some(reduction) = self.reduction {
            let dofs = orthogonality_dofs(test, self.theory, &pairing.map);
            let selection = match reduction {
                Reduction::Serep => Some(serep_modes(self.theory, &dofs, &paired)),
                Reduction::Guyan => None,
            };
            let columns = match &selection {
                Some(selection) => selection.kept.clone(),
                None => (0..self.theory.modes.len()).collect(),
            };
            let reusable =
                mass_of_expansion.filter(|(kept, _)| selection.is_none() || *kept == columns);
            let mass = match reusable {
                Some((_, mass)) => mass,
                None => self.reduced_mass(dofs, reduction, &columns)?.1,
            };
            let found = orthogonality(test, self.theory, &pairing.map, &mass, &columns)?;
            measured.orthogonality = Some(match selection {
                Some(selection) => found.with_selection(selection),
                None => found,
            });
        }
        Ok(Some(measured))
    }

    /// The model, and its mass matrix reduced to the sensors of both.
    fn reduced_mass(
        &self,
        dofs: Vec<Dof>,
        reduction: Reduction,
        kept: &[usize],
    ) -> Result<(&SolvedModel, ReducedMass), Error> {
        let model = self.model.ok_or_else(|| Error::Argument {
            argument: "--orthogonality, --expand",
            got: "finished modes, which have no mass matrix".to_owned(),
            expected: "a model as --theory".to_owned(),
        })?;
        let reading = |dof: Dof| {
            let named = self.names.and_then(|names| names.reading(&dof)).cloned();
            let reading = named.unwrap_or_else(|| vec![(dof.positive(), dof.sign())]);
            (dof, reading)
        };
        let readings: Vec<(Dof, Reading)> = dofs.into_iter().map(reading).collect();
        let (solved, sensors) = (&model.model, &model.sensors);
        let mass = solved.reduced_mass(sensors, &readings, reduction, kept)?;
        Ok((model, mass))
    }
}

/// Indices of the theory's modes that are paired.
fn paired_theory_modes(pairing: &Pairing) -> Vec<usize> {
    let modes = pairing.pairs.iter().flat_map(|pair| pair.theory.iter());
    modes.copied().collect()
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
    options.rotation_length_m = args.rotation_length;
    options.validate().map_err(|error| match error {
        CorrelateError::Option {
            name,
            got,
            expected,
        } => Error::Argument {
            argument: pair_flag(name),
            got: got.to_string(),
            expected: expected.to_owned(),
        },
        other => other.into(),
    })?;
    Ok(options)
}

/// The flag of a pairing option.
fn pair_flag(option: &str) -> &'static str {
    match option {
        "max_frequency_error" => "--max-frequency-error",
        "rotation_length_m" => "--rotation-length",
        _ => "--min-mac",
    }
}

/// One side of a comparison, with the model that was solved where it is one.
struct Loaded {
    theory: Theory,
    model: Option<SolvedModel>,
    /// Number of the first elastic root in the comparison.
    first_root: usize,
}

/// A model with the sensors at which it was solved.
struct SolvedModel {
    model: LoadedModel,
    sensors: Vec<Sensor>,
}

/// Modes from a file that holds them; or a model solved at the sensors that the model file names,
/// else at its coordinates; or the model of a scene at the scene's sensors.
fn load(path: &Path, args: &CorrelateArgs, format: Option<&str>) -> Result<Loaded, SceneError> {
    let partial = args.partial;
    let finished = |theory| Loaded {
        theory,
        model: None,
        first_root: 1,
    };
    let kind = model_kind(path);
    if kind == ModelKind::Modes {
        let options = ModesOptions {
            format,
            partial,
            positions: args.nearest_node.is_some(),
        };
        return Ok(finished(load_modes(path, &options)?.into()));
    }
    let (model, sensors, first_root) = if kind == ModelKind::Scene {
        let scene = SceneReading { format, partial }.scene(path)?;
        let table = scene.model.clone().unwrap_or_default();
        let Some(model) = table_model(&table, &scene.folder, &scene.path)? else {
            let options = ModeOptions::default();
            let theory = theory(&table, &scene.folder, &scene.path, &scene.sensors, &options)?;
            return Ok(Loaded {
                first_root: scene.first_root,
                ..finished(theory)
            });
        };
        let sensors = model.sensors_with(&scene.sensors);
        (model, sensors, scene.first_root)
    } else {
        let model = load_model(path, &Default::default())?;
        let sensors = model.sensors.clone();
        (model, sensors, first_root(path))
    };
    Ok(Loaded {
        theory: model.solve(&sensors, &ModeOptions::default())?,
        model: Some(SolvedModel { model, sensors }),
        first_root,
    })
}
