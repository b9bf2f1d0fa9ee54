//! The HTML report of a run: written with it, and built again by `modalign report`.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::Error;
use crate::io::{IoError, check_result, check_results};
use crate::report::json::{
    REPORT_FILE, REPORT_SCHEMA, RunReport, Section, UpdateFile, breakdown_from_json,
    order_from_json, report_from_json, report_to_json, speed_accuracy_from_json, update_from_json,
};
use crate::report::{
    Block, CompanionResults, Language, Table, TableGroup, before_you_leave_blocks, claims_block,
    comparison_blocks, energies_block, figure_files, figures_svg, hits_block, limits_block,
    modes_block, parameters_block, placement_blocks, published_comparison_block,
    published_roots_block, quantities_block, report_page, states_block, update_figures_svg,
};
use crate::scene::{ReportTableTable, Scene, SceneResult, TestResult, figures, read_text};

use super::args::ReportArgs;
use super::first_names::first_names;
use super::outcome::Outcome;
use super::output::Output;
use super::test_stem::test_stem;

/// The page.
const PAGE_FILE: &str = "report.html";
/// The result of `update -o`.
const UPDATE_FILE: &str = "update.json";
/// The results of `study … -o`.
const SPEED_ACCURACY_FILE: &str = "speed-accuracy.json";
const BREAKDOWN_FILE: &str = "breakdown.json";
const ORDER_FILE: &str = "order.json";

/// The verb of a manifest whose files are the results of a run, with page and figures.
pub(super) const RUN_VERB: &str = "run";
/// The verb of a manifest whose files are an updated model, with the figures of the update.
pub(super) const UPDATE_VERB: &str = "update";

/// Builds page and figures of a finished run again.
pub fn report(args: &ReportArgs, output: &mut Output) -> Result<Outcome, Error> {
    let folder = &args.folder;
    if folder.is_dir() {
        output.open_results(folder, None)?;
    }
    let companions = read_companions(folder, OtherRun::IsRefused)?;
    let run = read_report(folder)?;
    check_results(folder)?;
    let page = page_files(&run, &companions, output.language(), args.png);
    // The page shows an incomplete update as far as possible.
    let updated = companions.updated;
    let whole = updated.and_then(|update| update_from_json(&update.to_string()).ok());
    let synthetic = run.figures.tests.iter().any(|test| test.synthetic);
    let updated = whole.map(|whole| update_figures(&whole, synthetic, args.png));
    for (verb, files) in [(RUN_VERB, page), (UPDATE_VERB, updated.unwrap_or_default())] {
        // A folder of results without manifest stays one.
        if output.has_manifest() {
            output.add_results(verb, files);
        } else {
            for (name, bytes) in files {
                output.add_file(folder.join(name), bytes);
            }
        }
    }
    output.add_text(&folder.join(PAGE_FILE).display().to_string());
    Ok(Outcome::Done)
}

/// The report of a run that a folder holds.
fn read_report(folder: &Path) -> Result<RunReport, Error> {
    let path = folder.join(REPORT_FILE);
    let name = path.display().to_string();
    let text = read_text(&path)?;
    let report = report_from_json(&text, &name)?;
    check_result(&path, text.as_bytes())?;
    Ok(report)
}

/// The treatment of a file that is not of the run that the manifest of the folder names.
#[derive(Clone, Copy)]
enum OtherRun {
    IsRefused,
    /// The results are written again, without it.
    IsLeftOut,
}

/// The value of a file; `None` for one of another run that is left out.
fn unless_left_out<T>(read: Result<T, Error>, other_run: OtherRun) -> Result<Option<T>, Error> {
    match (read, other_run) {
        (Err(Error::Io(IoError::OtherRun { .. })), OtherRun::IsLeftOut) => Ok(None),
        (read, _) => read.map(Some),
    }
}

/// A line on the results of other verbs that are not in the report of a run.
pub(super) fn left_out_companions(folder: &Path) -> Option<String> {
    let files = [UPDATE_FILE, SPEED_ACCURACY_FILE, BREAKDOWN_FILE, ORDER_FILE];
    let is_of_other_run = |name: &&str| {
        let path = folder.join(name);
        let text = read_text(&path).ok();
        let checked = text.map(|text| check_result(&path, text.as_bytes()));
        matches!(checked, Some(Err(IoError::OtherRun { .. })))
    };
    let names: Vec<String> = files
        .iter()
        .filter(|name| is_of_other_run(name))
        .map(ToString::to_string)
        .collect();
    let first = first_names(&names);
    (!names.is_empty()).then(|| format!("Unfinished or changed, and not in report.html: {first}."))
}

/// The page of a folder that has one, with a new update.
pub(super) fn rebuild_page(
    folder: &Path,
    updated: &Value,
    language: Language,
    png: bool,
) -> Result<Vec<(String, Vec<u8>)>, Error> {
    if !folder.join(REPORT_FILE).exists() {
        return Ok(Vec::new());
    }
    let run = unless_left_out(read_report(folder), OtherRun::IsLeftOut)?;
    let companions = CompanionResults {
        updated: Some(updated.clone()),
        ..read_studies(folder, OtherRun::IsLeftOut)?
    };
    let page = run.map(|run| page_files(&run, &companions, language, png));
    Ok(page.unwrap_or_default())
}

/// The figures of an update; `synthetic`: one of its tests was computed from a model.
pub(super) fn update_figures(
    update: &UpdateFile,
    synthetic: bool,
    png: bool,
) -> Vec<(String, Vec<u8>)> {
    files_in_figure_folder(update_figures_svg(update, synthetic), png)
}

fn files_in_figure_folder(figures: Vec<(String, String)>, png: bool) -> Vec<(String, Vec<u8>)> {
    let files = figure_files(figures, png).into_iter();
    files
        .map(|(name, bytes)| (format!("figures/{name}"), bytes))
        .collect()
}

/// The files of the report of a run that goes into a folder.
pub(super) fn report_files(
    scene: &Scene,
    result: &SceneResult,
    next: Option<&str>,
    folder: &Path,
    language: Language,
    png: bool,
) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let frf_file = |index: usize| {
        let one = result.tests[index].frfs.len() == 1;
        one.then(|| format!("{}.frf.uff", test_stem(result, index)))
    };
    let frf_files: Vec<Option<String>> = (0..result.tests.len()).map(frf_file).collect();
    let (figures, provenance) = figures(scene, result, &frf_files)?;
    let report = RunReport {
        schema: REPORT_SCHEMA.to_owned(),
        title: scene.title.clone(),
        sections: sections(scene, result),
        findings: result.findings_by_test(),
        limits: result
            .limits
            .iter()
            .map(|check| (check.what.clone(), check.is_met()))
            .collect(),
        next: next.map(str::to_owned),
        figures,
        provenance,
    };
    let mut files = vec![(REPORT_FILE.to_owned(), report_to_json(&report).into_bytes())];
    files.extend(page_files(
        &report,
        &read_companions(folder, OtherRun::IsLeftOut)?,
        language,
        png,
    ));
    Ok(files)
}

/// The page and its figures, with the results of other verbs.
fn page_files(
    report: &RunReport,
    companions: &CompanionResults,
    language: Language,
    png: bool,
) -> Vec<(String, Vec<u8>)> {
    let page = report_page(report, companions, language);
    let mut files = vec![(PAGE_FILE.to_owned(), page.into_bytes())];
    files.extend(files_in_figure_folder(figures_svg(&report.figures), png));
    files
}

/// The results of other verbs in a folder.
fn read_companions(folder: &Path, other_run: OtherRun) -> Result<CompanionResults, Error> {
    Ok(CompanionResults {
        updated: read_if_present(folder.join(UPDATE_FILE), update_from, other_run)?,
        ..read_studies(folder, other_run)?
    })
}

/// The studies in a folder.
fn read_studies(folder: &Path, other_run: OtherRun) -> Result<CompanionResults, Error> {
    Ok(CompanionResults {
        updated: None,
        speed_accuracy: read_if_present(
            folder.join(SPEED_ACCURACY_FILE),
            speed_accuracy_from_json,
            other_run,
        )?,
        breakdown: read_if_present(folder.join(BREAKDOWN_FILE), breakdown_from_json, other_run)?,
        order: read_if_present(folder.join(ORDER_FILE), order_from_json, other_run)?,
    })
}

/// The contents of a file; `None` where there is none.
fn read_if_present<T>(
    path: PathBuf,
    read: fn(&str, &str) -> Result<T, IoError>,
    other_run: OtherRun,
) -> Result<Option<T>, Error> {
    if !path.exists() {
        return Ok(None);
    }
    let text = read_text(&path)?;
    let value = read(&text, &path.display().to_string())?;
    let checked = check_result(&path, text.as_bytes());
    unless_left_out(checked.map(|()| value).map_err(Error::Io), other_run)
}

fn update_from(text: &str, path: &str) -> Result<Value, IoError> {
    serde_json::from_str(text).map_err(|error| IoError::Json {
        path: path.to_owned(),
        line: error.line(),
        column: error.column(),
        got: error.to_string(),
        expected: "schema modalign-update/1",
    })
}

/// The tests of a comparison table with its caption and its notes.
pub(super) fn table_group(table: &ReportTableTable) -> TableGroup<'_> {
    TableGroup {
        caption: &table.caption,
        tests: &table.tests,
        notes: &table.notes,
    }
}

/// What to repeat before the structure of a test is gone, under the name of the test.
pub(super) fn before_leaving_blocks(test: &TestResult) -> Vec<Block> {
    let Some(list) = &test.before_you_leave else {
        return Vec::new();
    };
    let mut blocks = before_you_leave_blocks(list);
    for block in &mut blocks {
        if let Block::Table(table) = block {
            table.caption = format!("{}: {}", table.caption, test.name);
        }
    }
    blocks
}

/// The tables of the page, by tab.
fn sections(scene: &Scene, result: &SceneResult) -> Vec<Section> {
    let expected = result.expected.as_ref();
    let mut comparison = Vec::new();
    if let Some(table) = &result.table {
        let groups: Vec<TableGroup<'_>> = scene.tables.iter().map(table_group).collect();
        comparison.extend(comparison_blocks(table, &groups, &result.theory));
    }
    for placed in &result.placements {
        comparison.extend(placement_blocks(placed, result.table.as_ref()));
    }
    comparison.extend(limits_block(&result.limits));
    comparison.extend(states_block(&result.tests, &result.theory));
    let mut published: Vec<Block> = Vec::new();
    published.extend(expected.and_then(|published_values| {
        published_roots_block(published_values, &result.theory, Some(scene.first_root))
    }));
    published.extend(expected.and_then(published_comparison_block));
    published.extend(expected.and_then(claims_block));
    for table in expected.iter().flat_map(|table| &table.quantities) {
        let model = table.model.as_deref().unwrap_or("the scene's model");
        published.extend(quantities_block(model, &table.quantities));
    }
    let tests = result.tests.iter();
    let mut modes: Vec<Block> = tests
        .clone()
        .map(|test| with_quality_first(modes_block(&test.name, &test.modes)))
        .collect();
    if result.tests.is_empty() {
        modes.extend(parameters_block(&result.theory.parameters));
    }
    let mut energies = Vec::new();
    if scene.energies.is_some() {
        let caption = "Energy of the model's roots";
        energies.extend(energies_block(
            caption,
            &result.theory.roots,
            scene.first_root,
            scene.energies,
        ));
    }
    let mut hits = Vec::new();
    for test in tests.filter(|test| !test.hits.is_empty()) {
        let mut block = hits_block("Hits", &test.hits);
        if let Block::Table(table) = &mut block {
            table.caption = format!("{}: {}", table.caption, test.name);
        }
        hits.push(block);
    }
    hits.extend(result.tests.iter().flat_map(before_leaving_blocks));
    vec![
        Section::new("comparison", comparison),
        Section::new("published", published),
        Section::new("modes", modes),
        Section::new("energies", energies),
        Section::new("hits", hits),
    ]
}

/// The modes with their quality and remarks beside frequency and damping, where a page shows them.
fn with_quality_first(block: Block) -> Block {
    let Block::Table(mut table) = block else {
        return block;
    };
    let index = |table: &Table, head: &str| table.columns.iter().position(|c| c.head == head);
    let Some(mut to) = index(&table, "std damping (%)") else {
        return Block::Table(table);
    };
    for head in ["quality", "remark"] {
        let Some(from) = index(&table, head) else {
            continue;
        };
        to += 1;
        table.columns[to..=from].rotate_right(1);
        for row in &mut table.rows {
            row[to..=from].rotate_right(1);
        }
    }
    Block::Table(table)
}
