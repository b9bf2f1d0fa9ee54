//! `modalign new`: a commented scene from exported files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use crate::dof::Dof;
use crate::error::Error;
use crate::geometry::Geometry;
use crate::io::{
    Catalog, Hints, Need, NewFile, check_damage, check_stated_points, open_path, sha256_hex,
    write_all_new,
};
use crate::quantity::{FrfUnit, Quantity, Unit};
use crate::report::Block;
use crate::scene::{
    DraftFile, DraftModel, DraftPlan, ModelDraft, ModesOptions, StatedUnits, Statement,
    TableContent, UnusedStatement, built_in_name_finding, draft_scene, is_built_in_model,
    load_model, load_modes, open_lines,
};

use crate::printable::counted;

use super::args::NewArgs;
use super::left_out::{LeftOut, Reason};
use super::new_points::{TABLE_FORMAT, list_of_points, read_points};
use super::new_steps::{next_steps, shell_quoted};
use super::outcome::Outcome;
use super::output::Output;

/// The parts of a new scene other than the raw files.
const NEW_FILES: [&str; 3] = ["SOURCE.md", "expected.toml", "scene.toml"];

const EXPECTED_TEMPLATE: &str =
    "# Published results about this machine, if there are any; `run` holds the model against them.
# While all lines are remarks there are none.
# schema = \"modalign-expected/1\"
#
# [source]
# authors = \"\"
# paper = \"\"
# year = 2000
#
# [[root]]
# label = \"f1\"
# omega_rad_s = 0.0
";

/// Writes `scene.toml`, `SOURCE.md` and a skeleton of `expected.toml`; lists the entries that
/// are still to be filled in.
pub fn new(args: &NewArgs, format: Option<&str>, output: &mut Output) -> Result<Outcome, Error> {
    let TestFiles {
        opened,
        left_out,
        points: found_points,
    } = open_files(args, format, output)?;
    check_new_files(args, &opened)?;
    // A scene is no value of --model, so that a folder of that name is not meant.
    let model_name = args.model.as_deref().filter(|name| name.is_file());
    let taken = model_name.and_then(built_in_name_finding);
    let read: Vec<&Path> = opened.iter().map(|file| file.path).collect();
    let is_complete = !opened.iter().any(|file| file.is_bad)
        && !left_out.iter().any(|file| file.may_hold_data(&read));
    let units = stated_units(args)?;
    let responses = responses_of_files(
        &args.response,
        &opened,
        args.files.len(),
        units.frf.is_some(),
    )?;
    let references = dofs_of_files("--reference", &args.reference, &opened, args.files.len())?;
    for (file, (response, reference)) in opened.iter().zip(responses.iter().zip(&references)) {
        check_stated_points(&file.catalog, response.first(), reference.first())?;
    }
    let files: Vec<DraftFile> = opened
        .iter()
        .zip(responses.iter().zip(&references))
        .map(|(file, (response, reference))| DraftFile {
            path: &file.scene_path,
            catalog: &file.catalog,
            responses: response,
            reference: reference.first(),
            units,
            sampling_rate_hz: args.sampling_rate,
            partial: args.partial && file.is_bad,
        })
        .collect();
    let model = args
        .model
        .as_deref()
        .map(|path| draft_model(args, path))
        .transpose()?;
    let stated_points = args.points.as_deref().map(read_points).transpose()?;
    let points = stated_points.or(found_points);
    let title = files
        .iter()
        .find_map(|file| file.catalog.title.first().cloned());
    let folder_name = args
        .folder
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    let has_positions = points.is_some()
        || model
            .as_ref()
            .is_some_and(|model| model.has_sensors || !model.bodies.is_empty())
        || files
            .iter()
            .any(|file| !file.catalog.geometry.nodes.is_empty());
    let plan = DraftPlan {
        title: &title.unwrap_or_else(|| folder_name.into_owned()),
        geometry: points.as_ref(),
        model: model.as_ref(),
        band: args.band,
    };
    let draft = draft_scene(&files, &plan);
    if let Some(unused) = draft.unused.first() {
        return Err(unused_error(unused));
    }
    let source = source_text(&opened)?;
    let copied = opened.iter().filter(|_| args.copy);
    let mut written: Vec<(PathBuf, NewFile)> = copied
        .map(|file| (copy_path(args, file.path), NewFile::CopyOf(file.path)))
        .collect();
    for (name, text) in NEW_FILES
        .iter()
        .zip([source.as_str(), EXPECTED_TEMPLATE, &draft.scene])
    {
        written.push((args.folder.join(name), NewFile::Text(text)));
    }
    let model_draft = args.model.as_deref().and_then(ModelDraft::at);
    let model_text = model_draft.map(|model| model.text_along(draft.line.as_ref()));
    let model_path = args.folder.join(ModelDraft::FILE);
    written.extend(
        model_text
            .iter()
            .map(|text| (model_path.clone(), NewFile::Text(text))),
    );
    let writing = output.guard_writing();
    write_all_new(&written)?;
    drop(writing);
    for file in &opened {
        output.add_findings(&file.catalog.findings);
    }
    output.add_findings(taken.as_slice());
    output.add_blocks(vec![Block::Text(next_steps(
        args,
        &files,
        &draft,
        points.as_ref(),
        has_positions,
    ))]);
    output.add_json(|| {
        let open: Vec<_> = open_lines(&draft.scene)
            .into_iter()
            .map(|line| serde_json::json!({ "line": line.line, "key": line.key, "expected": line.expected }))
            .collect();
        let scene = args.folder.join("scene.toml").display().to_string();
        format!("{:#}", serde_json::json!({
            "schema": "modalign-new/1", "scene": scene, "open": open, "not_used": left_out.iter().map(LeftOut::json).collect::<Vec<_>>(),
        }))
    });
    Ok(Outcome::missed_if(!is_complete))
}

/// The stated responses of each file: those of its columns where it is a table of several, else as
/// [`dofs_of_files`] has them. Unnamed columns with a stated unit of FRFs are one FRF.
fn responses_of_files<'a>(
    stated: &'a [Dof],
    files: &[NamedFile],
    all: usize,
    has_frf_unit: bool,
) -> Result<Vec<&'a [Dof]>, Error> {
    let columns = |file: &NamedFile| match TableContent::of(&file.catalog) {
        Some(table) if table.responses > 1 => Some(table.responses),
        _ => None,
    };
    let Some((file, count)) = files.iter().find_map(|file| Some((file, columns(file)?))) else {
        return match !has_frf_unit && responses_of_unnamed_columns(stated, files)? {
            true => Ok(vec![stated; files.len()]),
            false => dofs_of_files("--response", stated, files, all),
        };
    };
    let tests = files.iter().filter(|file| file.has_test_data());
    let is_alike = tests.into_iter().all(|file| columns(file) == Some(count));
    if stated.is_empty() || (is_alike && stated.len() == count) {
        return Ok(vec![stated; files.len()]);
    }
    let path = file.path.display();
    let got = format!(
        "{} for {count} responses of {path}",
        counted(stated.len(), "DOF")
    );
    let expected = match is_alike {
        true => "one for each response in the order of the columns, or none",
        false => "files with the same number of responses, or none: the scene states them",
    };
    Err(argument_error("--response", got, expected))
}

/// Whether stated responses are those of the columns of each file, whose headings do not say what
/// they hold; they are those of the files otherwise.
///
/// # Errors
/// For a number of responses that fits the files and the columns, or neither.
fn responses_of_unnamed_columns(stated: &[Dof], files: &[NamedFile]) -> Result<bool, Error> {
    let tables = files.iter().map(|file| TableContent::of(&file.catalog));
    let tables: Option<Vec<TableContent>> = tables.collect();
    let Some(tables) = tables.filter(|_| stated.len() > 1) else {
        return Ok(false);
    };
    let count = stated.len();
    let fits_columns = tables.iter().all(|table| table.may_hold_responses(count));
    // Each channel of an array but the force is a response, so that a file has no single one.
    let may_be_files = |table: &TableContent| !table.has_channel_axis || table.unknown_columns < 3;
    let fits_files = count == files.len() && tables.iter().all(may_be_files);
    let first = tables.first().filter(|table| table.unknown_columns > 0);
    let Some(table) = first.filter(|_| fits_columns == fits_files) else {
        return Ok(fits_columns);
    };
    let got = format!(
        "{} for {} of {}",
        counted(count, "DOF"),
        counted(files.len(), "file"),
        counted(table.unknown_columns, "unnamed column")
    );
    let expected = match fits_files {
        true => {
            "none, as these may be one for each file or one for each response of a file: `dof` of \
             [[test.channel]] or `response` of [[test.file]] in the scene states them; or a \
             heading such as `force,acceleration` in the files"
        }
        false => {
            "one for all files, one for each file, or one for each response of a file (all columns \
             but force and time)"
        }
    };
    Err(argument_error("--response", got, expected))
}

/// The stated DOF of each file: one for all, one for each file with data of a test, or one for each
/// file.
fn dofs_of_files<'a>(
    option: &'static str,
    stated: &'a [Dof],
    files: &[NamedFile],
    all: usize,
) -> Result<Vec<&'a [Dof]>, Error> {
    let tests = files.iter().filter(|file| file.has_test_data()).count();
    if ![0, 1, tests, all].contains(&stated.len()) {
        let with_data = match tests == all {
            true => String::new(),
            false => format!(" with data of a test ({all} in all)"),
        };
        let got = format!("{} DOFs for {tests} files{with_data}", stated.len());
        return Err(argument_error(
            option,
            got,
            "one for all files, or one for each",
        ));
    }
    let mut of_tests = stated.chunks(1);
    let of_file = |file: &NamedFile| match stated.len() {
        0 | 1 => stated,
        count if count != tests => &stated[file.number..=file.number],
        _ if file.has_test_data() => of_tests.next().unwrap_or_default(),
        _ => &[],
    };
    Ok(files.iter().map(of_file).collect())
}

/// The stated units by what they are of.
fn stated_units(args: &NewArgs) -> Result<StatedUnits<'_>, Error> {
    let mut units = StatedUnits::default();
    for text in &args.unit {
        let place = match (text.parse::<FrfUnit>(), text.parse::<Unit>()) {
            (Ok(_), _) => &mut units.frf,
            (_, Ok(unit)) if unit.quantity == Quantity::Force => &mut units.force,
            (_, Ok(_)) => &mut units.response,
            (Err(_), Err(error)) => {
                let message = error.to_string();
                let expected = message.split_once("expected ").map_or("a unit", |(_, e)| e);
                return Err(argument_error("--unit", text.clone(), expected));
            }
        };
        if let Some(first) = place.replace(text) {
            let got = format!("{first} and {text}");
            let expected = "one unit of forces, one of responses and one of FRFs";
            return Err(argument_error("--unit", got, expected));
        }
    }
    Ok(units)
}

/// The error of an option that the draft does not use.
fn unused_error(unused: &UnusedStatement) -> Error {
    let option = match unused.statement {
        Statement::Unit => "--unit",
        Statement::Response => "--response",
        Statement::Reference => "--reference",
        Statement::SamplingRate => "--sampling-rate",
    };
    argument_error(option, unused.got.clone(), &unused.expected)
}

/// Checks that no file to be written exists.
fn check_new_files(args: &NewArgs, opened: &[NamedFile]) -> Result<(), Error> {
    let mut raws = BTreeSet::new();
    for path in opened.iter().filter(|_| args.copy).map(|file| file.path) {
        if !raws.insert(copy_path(args, path)) {
            return Err(argument_error(
                "FILE",
                format!("two files named {}", copy_path(args, path).display()),
                "files of different names with --copy",
            ));
        }
    }
    let model = args.model.as_deref().and_then(ModelDraft::at);
    let names = NEW_FILES.into_iter().chain(model.map(|_| ModelDraft::FILE));
    let drafted = names.map(|name| args.folder.join(name));
    let existing: Vec<PathBuf> = drafted.chain(raws).filter(|path| path.exists()).collect();
    let Some((first, others)) = existing.split_first() else {
        return Ok(());
    };
    let folder_name = args.folder.file_name().unwrap_or_default();
    let again = format!("{}-2", folder_name.to_string_lossy());
    let again = args.folder.with_file_name(again);
    let removed: Vec<String> = existing.iter().map(|path| shell_quoted(path)).collect();
    let expected = format!(
        "a folder without files of a scene: nothing is written over. Name another folder (modalign new {} ...), or remove an unedited draft first (rm {})",
        shell_quoted(&again),
        removed.join(" ")
    );
    let more = match others.len() {
        0 => "which exists".to_owned(),
        _ => format!("which exists, and {} more", counted(others.len(), "file")),
    };
    let got = format!("{}, {more}", first.display());
    Err(argument_error("DIR", got, &expected))
}

fn argument_error(argument: &'static str, got: String, expected: &str) -> Error {
    Error::Argument {
        argument,
        got,
        expected: expected.to_owned(),
    }
}

/// An exported file that the scene names.
struct NamedFile<'a> {
    path: &'a Path,
    /// Its number from 0 in the arguments.
    number: usize,
    /// Its path in the scene.
    scene_path: String,
    catalog: Catalog,
    /// Whether part of it is bad.
    is_bad: bool,
}

impl NamedFile<'_> {
    /// Whether it holds more than a geometry.
    fn has_test_data(&self) -> bool {
        let catalog = &self.catalog;
        !(catalog.entries.is_empty() && catalog.modes.is_empty() && catalog.arrays.is_empty())
    }
}

/// The exported files: those with data of a test, and the others.
struct TestFiles<'a> {
    opened: Vec<NamedFile<'a>>,
    left_out: Vec<LeftOut<'a>>,
    /// The points of a list beside them.
    points: Option<Geometry>,
}

/// The files with data of a test; the others are named on the screen.
///
/// # Errors
/// Of the first file that cannot be read, or of the first one where none has such data.
fn open_files<'a>(
    args: &'a NewArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<TestFiles<'a>, Error> {
    let (mut opened, mut left_out) = (Vec::new(), Vec::new());
    for (number, path) in args.files.iter().enumerate() {
        let hints = Hints {
            path: path.display().to_string(),
            ..Hints::default()
        };
        let mut source = match open_path(path, &hints, format) {
            Ok(source) => source,
            Err(error) if error.is_no_measurement() => {
                let reason = Reason::Error(error);
                left_out.push(LeftOut { path, reason });
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        let needs = [Need::Records, Need::Frfs, Need::Modes];
        let is_bad = check_damage(source.as_mut(), &needs, args.partial)?;
        opened.push(NamedFile {
            path,
            number,
            scene_path: scene_path(args, path),
            catalog: std::mem::take(source.catalog_mut()),
            is_bad,
        });
    }
    if opened.is_empty()
        && let Some(Reason::Error(error)) = left_out.drain(..).next().map(|file| file.reason)
    {
        return Err(error.into());
    }
    let points = take_list_of_points(&mut opened, args)?;
    let states_contents = |file: &NamedFile| match TableContent::of(&file.catalog) {
        Some(table) => table.has_known_column,
        None => file.has_test_data(),
    };
    if opened.iter().any(states_contents) {
        let is_table = |file: &NamedFile| file.catalog.format == TABLE_FORMAT;
        let is_unnamed = |file: &mut NamedFile| is_table(file) && !states_contents(file);
        left_out.extend(opened.extract_if(.., is_unnamed).map(|file| LeftOut {
            path: file.path,
            reason: Reason::Unnamed(file.catalog.arrays.len()),
        }));
    }
    let read: Vec<&Path> = opened.iter().map(|file| file.path).collect();
    let lines = left_out.iter().map(|file| Block::Text(file.text(&read)));
    output.add_blocks(lines.collect());
    output.add_blocks(points.iter().map(FoundPoints::text).collect());
    Ok(TestFiles {
        points: points.map(|found| found.points),
        opened,
        left_out,
    })
}

/// A list of points among the files.
struct FoundPoints<'a> {
    path: &'a Path,
    points: Geometry,
}

impl FoundPoints<'_> {
    /// The line for the screen.
    fn text(&self) -> Block {
        let (path, count) = (self.path.display(), self.points.nodes.len());
        Block::Text(format!(
            "{path}: {}, as by --points.",
            counted(count, "point")
        ))
    }
}

/// Takes the list of points out of the files, where there is one.
///
/// # Errors
/// With the option that takes such a list, for lists without recordings, for several lists, and for
/// one beside that option.
fn take_list_of_points<'a>(
    files: &mut Vec<NamedFile<'a>>,
    args: &NewArgs,
) -> Result<Option<FoundPoints<'a>>, Error> {
    let mut lists = Vec::new();
    let list_of = |file: &NamedFile<'a>| {
        let points = list_of_points(file.path, &file.catalog)?;
        let path = file.path;
        Some(FoundPoints { path, points })
    };
    files.retain(|file| {
        let list = list_of(file);
        let is_recording = list.is_none();
        lists.extend(list);
        is_recording
    });
    let more = match lists.len() {
        0 => return Ok(None),
        1 => String::new(),
        count => format!(", and {} more", counted(count - 1, "such list")),
    };
    let of_first = {
        let FoundPoints { path, points } = &lists[0];
        let count = counted(points.nodes.len(), "point");
        format!("{count} in {}{more}", path.display())
    };
    let beside = match (files.is_empty(), &args.points) {
        (true, _) => ", without recordings".to_owned(),
        (false, Some(stated)) => format!(", and --points {}", stated.display()),
        (false, None) if lists.len() > 1 => String::new(),
        (false, None) => return Ok(lists.pop()),
    };
    let expected = "recordings, FRFs or modes, and one list of points as --points FILE";
    Err(argument_error("FILE", of_first + &beside, expected))
}

fn copy_path(args: &NewArgs, path: &Path) -> PathBuf {
    args.folder
        .join("raw")
        .join(path.file_name().unwrap_or_default())
}

/// The path by which the scene names a file: that of its copy, else relative to the scene where
/// they share a folder.
fn scene_path(args: &NewArgs, path: &Path) -> String {
    if args.copy {
        return format!(
            "raw/{}",
            path.file_name().unwrap_or_default().to_string_lossy()
        );
    }
    relative_path(&args.folder, path).unwrap_or_else(|| path.display().to_string())
}

/// `path` relative to `folder`; absolute where they have only the root in common.
fn relative_path(folder: &Path, path: &Path) -> Option<String> {
    let (from, to) = (resolve_links(folder)?, resolve_links(path)?);
    let parts = |path: &Path| -> Vec<String> {
        let names = path
            .components()
            .filter(|part| matches!(part, Component::Normal(_)));
        names
            .map(|part| part.as_os_str().to_string_lossy().into_owned())
            .collect()
    };
    let (from, names) = (parts(&from), parts(&to));
    let common = from.iter().zip(&names).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return Some(to.display().to_string());
    }
    let up = std::iter::repeat_n("..".to_owned(), from.len() - common);
    let all: Vec<String> = up.chain(names[common..].iter().cloned()).collect();
    Some(all.join("/"))
}

/// The absolute path with links followed, as far as it exists.
fn resolve_links(path: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(path).ok()?;
    let known = absolute
        .ancestors()
        .find_map(|ancestor| Some((ancestor, ancestor.canonicalize().ok()?)));
    let (existing, resolved) = known?;
    let rest = absolute.strip_prefix(existing).ok()?;
    // Joining nothing would add a slash.
    let is_whole = rest.as_os_str().is_empty();
    Some(if is_whole {
        resolved
    } else {
        resolved.join(rest)
    })
}

/// The `[model]` of the scene; its bodies are where sensors can sit.
fn draft_model(args: &NewArgs, path: &Path) -> Result<DraftModel, Error> {
    let text =
        |key: &str, value: &str| format!("{key} = {}", toml::Value::String(value.to_owned()));
    let draft = ModelDraft::at(path);
    let is_built_in = draft.is_some() || is_built_in_model(path);
    let is_file = !is_built_in && path.exists();
    let is_toml = path
        .extension()
        .is_some_and(|extension| extension == "toml");
    if is_file && !is_toml {
        // What `run` could not read is not drafted.
        let options = ModesOptions {
            partial: args.partial,
            ..ModesOptions::default()
        };
        load_modes(path, &options)?;
        return Ok(DraftModel {
            line: text(
                "file",
                &relative_path(&args.folder, path).unwrap_or_default(),
            ),
            bodies: Vec::new(),
            has_sensors: false,
            is_drafted_beam: false,
        });
    }
    let loaded = match draft {
        Some(draft) => draft.load()?,
        None => load_model(path, &BTreeMap::new())?,
    };
    let bodies = match loaded.model.assemble(&loaded.values) {
        Ok(system) => system
            .coordinates
            .iter()
            .map(|coordinate| coordinate.body.clone())
            .collect(),
        // Sparse matrices have no bodies.
        Err(_) => BTreeSet::new(),
    };
    Ok(DraftModel {
        line: if draft.is_some() {
            text("file", ModelDraft::FILE)
        } else if is_file {
            text(
                "file",
                &relative_path(&args.folder, path).unwrap_or_default(),
            )
        } else {
            text("name", &path.display().to_string())
        },
        bodies: bodies.into_iter().collect(),
        has_sensors: !loaded.sensors.is_empty(),
        is_drafted_beam: draft.is_some_and(|draft| draft.kind == "beam"),
    })
}

fn source_text(files: &[NamedFile]) -> Result<String, Error> {
    let mut text = "# Where the numbers of this scene come from\n\n\
        Who measured, when, on what, with which instruments, and under which licence:\n\n\
        | file | format | SHA-256 | measured, computed or published by |\n|---|---|---|---|\n"
        .to_owned();
    for file in files {
        text += &format!(
            "| `{}` | {} | `{}` | |\n",
            file.scene_path,
            file.catalog.format,
            sha256_hex(file.path)?
        );
    }
    Ok(text)
}
