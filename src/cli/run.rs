//! `modalign run`: a scene to its tables, and with `-o` to files.

use std::path::Path;

use crate::correlate::ComparisonTable;
use crate::error::Error;
use crate::finding::Finding;
use crate::io::{Encoding, FileLabel, modes_to_json, write_frfs};
use crate::report::{
    Block, CsvText, Language, RENDERERS, Renderer, TableGroup, claims_block, comparison_blocks,
    comparison_of_all_tests, comparison_page, energies_block, json, limits_block, modes_block,
    modes_page, next_step, parameters_block, placement_blocks, published_comparison_block,
    published_roots_block, quantities_block, run_screen, states_block,
};
use crate::scene::{BASE_CONFIGURATION, Scene, SceneResult, TestResult, run_observed as run_scene};

use super::args::RunArgs;
use super::first_names::first_names;
use super::outcome::Outcome;
use super::output::Output;
use super::report::{
    RUN_VERB, before_leaving_blocks, left_out_companions, report_files, table_group,
};
use super::scene_reading::SceneReading;
use super::targets::{check_targets, scene_files};
use super::test_stem::test_stem;

/// Runs the scene; exit code 1 when a stated limit is missed, part of the input was bad, a test has
/// no modes, or no mode of any test is paired.
pub fn run(args: &RunArgs, format: Option<&str>, output: &mut Output) -> Result<Outcome, Error> {
    let partial = args.partial;
    let whole = SceneReading { format, partial }.scene(&args.scene)?;
    let scene = whole.configuration(&args.configuration)?;
    if let Some(folder) = &args.output {
        output.open_results(folder, Some(RUN_VERB))?;
    }
    let result = run_scene(&scene, output.observer())?;
    let next = next_step(&args.scene.display().to_string(), &scene, &result);
    let blocks = blocks(&scene, &result, Columns::All);
    let (mut earlier, mut left_out) = (None, None);
    if let Some(folder) = &args.output {
        let translated = |blocks| output.language().translated(blocks);
        let page = translated(self::blocks(&scene, &result, Columns::Page));
        let all = translated(blocks.clone());
        let tables = TableBlocks { all, page };
        let mut files = files(&result, next.as_deref(), &tables, output.language())?;
        files.extend(report_files(
            &scene,
            &result,
            next.as_deref(),
            folder,
            output.language(),
            args.png,
        )?);
        earlier = earlier_figures(folder, &files, |name| output.names_result(name));
        left_out = left_out_companions(folder);
        add_folder_files(RUN_VERB, folder, files, &whole, output)?;
    }
    output.add_result(|width| run_screen(&scene, &result, width), || blocks);
    let rest = match &args.output {
        Some(folder) => format!(
            "All tables, columns and notes: --full, or {}; a [code]: --explain CODE.",
            folder.join("report.html").display()
        ),
        None => {
            "All tables, columns and notes: --full; report and files: -o DIR; a [code]: --explain CODE."
                .to_owned()
        }
    };
    let lines = [
        earlier,
        left_out,
        other_configurations(&whole, &args.configuration),
        next.clone(),
    ];
    output.add_closing(lines.into_iter().flatten().collect(), Some(&rest));
    match &result.table {
        Some(table) => output.add_json(|| comparison_json(table, &result, next.as_deref())),
        None if result.tests.is_empty() => {
            output.add_json(|| modes_to_json(&result.theory.modes, None));
        }
        None => output.add_json(|| modes_of_tests(&result)),
    }
    for (test, findings) in result.findings_by_test() {
        output.add_findings_of(&test, &findings);
    }
    let without_modes = |test: &TestResult| test.modes.modes.is_empty();
    let missed =
        result.limits.iter().any(|check| !check.is_met()) || result.tests.iter().any(without_modes);
    let is_empty = result.table.as_ref().is_some_and(ComparisonTable::is_empty);
    Ok(Outcome::missed_if(
        missed || is_empty || result.partly_bad(),
    ))
}

/// A line on the configurations of a scene that a run does not show.
fn other_configurations(scene: &Scene, shown: &str) -> Option<String> {
    let names = scene.configurations.iter().map(|table| table.name.as_str());
    let names = [BASE_CONFIGURATION].into_iter().chain(names);
    let others: Vec<String> = names
        .filter(|name| *name != shown)
        .map(|name| format!("--configuration {name:?}"))
        .collect();
    let has_others = !scene.configurations.is_empty();
    has_others.then(|| format!("Not compared here: {}.", others.join(", ")))
}

/// A line on the figures in the folder that are of an earlier run and that no manifest names.
fn earlier_figures(
    folder: &Path,
    files: &[(String, Vec<u8>)],
    is_named: impl Fn(&str) -> bool,
) -> Option<String> {
    let is_written = |name: &str| files.iter().any(|(written, _)| written == name);
    let figures = std::fs::read_dir(folder.join("figures")).ok()?;
    let names = figures.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names
        .filter(|name| name.ends_with(".svg") || name.ends_with(".png"))
        .map(|name| format!("figures/{name}"))
        .filter(|name| !is_written(name) && !is_named(name))
        .collect();
    names.sort();
    let first = first_names(&names);
    (!names.is_empty()).then(|| format!("Left from an earlier run: {first}."))
}

/// Adds files of the folder of the results, none of which the scene reads.
pub(super) fn add_folder_files(
    verb: &'static str,
    folder: &Path,
    files: Vec<(String, Vec<u8>)>,
    scene: &Scene,
    output: &mut Output,
) -> Result<(), Error> {
    let names = files.iter();
    let names = names.map(|(name, _)| ("-o", folder.join(name))).collect();
    check_targets(&names, &scene_files(scene))?;
    output.add_results(verb, files);
    Ok(())
}

/// `comparison.json` with the placements and limits of the scene.
fn comparison_json(table: &ComparisonTable, result: &SceneResult, next: Option<&str>) -> String {
    let more = json::ExtraResults {
        placements: &result.placements,
        limits: &result.limits,
        states: Some(result),
        next,
        ..json::ExtraResults::default()
    };
    json::comparison_with(table, &more)
}

/// The modes of one test as they are, those of several as an array.
fn modes_of_tests(result: &SceneResult) -> String {
    let all: Vec<String> = result.tests.iter().map(TestResult::modes_json).collect();
    if let [only] = all.as_slice() {
        only.clone()
    } else {
        format!("[{}]", all.join(", "))
    }
}

/// The columns of a table.
#[derive(Clone, Copy)]
enum Columns {
    All,
    /// The essential ones, as a page of a paper has them.
    Page,
}

/// The tables of a scene.
struct TableBlocks {
    all: Vec<Block>,
    /// Their essential columns.
    page: Vec<Block>,
}

fn blocks(scene: &Scene, result: &SceneResult, columns: Columns) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(scene.title.clone())];
    let expected = result.expected.as_ref();
    blocks.extend(
        expected.and_then(|e| published_roots_block(e, &result.theory, Some(scene.first_root))),
    );
    if scene.energies.is_some() {
        let (caption, roots) = ("Energy of the model's roots", &result.theory.roots);
        blocks.extend(energies_block(
            caption,
            roots,
            scene.first_root,
            scene.energies,
        ));
    }
    for table in expected.iter().flat_map(|expected| &expected.quantities) {
        let model = table.model.as_deref().unwrap_or("the scene's model");
        blocks.extend(quantities_block(model, &table.quantities));
    }
    blocks.extend(result.tests.iter().flat_map(|test| match columns {
        Columns::All => vec![modes_block(&test.name, &test.modes)],
        Columns::Page => modes_page(&test.name, &test.modes),
    }));
    if result.tests.is_empty() {
        blocks.extend(parameters_block(&result.theory.parameters));
    }
    if matches!(columns, Columns::All) {
        blocks.extend(result.tests.iter().flat_map(before_leaving_blocks));
    }
    if let Some(table) = &result.table {
        let groups: Vec<TableGroup<'_>> = scene.tables.iter().map(table_group).collect();
        blocks.extend(match columns {
            Columns::All => comparison_blocks(table, &groups, &result.theory),
            Columns::Page => comparison_page(table, &groups, &result.theory),
        });
    }
    for placed in &result.placements {
        blocks.extend(placement_blocks(placed, result.table.as_ref()));
    }
    blocks.extend(expected.and_then(published_comparison_block));
    blocks.extend(expected.and_then(claims_block));
    blocks.extend(limits_block(&result.limits));
    blocks.extend(states_block(&result.tests, &result.theory));
    blocks
}

/// The findings, under the name of their test where there are several.
fn findings_blocks(result: &SceneResult, language: Language) -> Vec<Block> {
    let named = |(test, findings): (String, Vec<Finding>)| {
        let head = (!test.is_empty()).then(|| Block::Text(format!("{test}:")));
        let blocks: Vec<Block> = head
            .into_iter()
            .chain([Block::Findings { findings, language }])
            .collect();
        blocks
    };
    let by_test = result.findings_by_test().into_iter();
    by_test
        .filter(|(_, findings)| !findings.is_empty())
        .flat_map(named)
        .collect()
}

/// The files of the folder other than the report.
fn files(
    result: &SceneResult,
    next: Option<&str>,
    blocks: &TableBlocks,
    language: Language,
) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for (index, test) in result.tests.iter().enumerate() {
        let stem = test_stem(result, index);
        files.push((format!("{stem}.modes.json"), test.modes_json().into_bytes()));
        if !test.hits.is_empty() {
            let text = format!("{:#}\n", json::hits_value(&test.hits));
            files.push((format!("{stem}.hits.json"), text.into_bytes()));
        }
        for (number, set) in test.frfs.iter().enumerate() {
            let name = match number {
                0 => format!("{stem}.frf.uff"),
                _ => format!("{stem}.frf-{}.uff", number + 1),
            };
            let mut bytes = Vec::new();
            write_frfs(
                &mut bytes,
                &FileLabel {
                    path: &name,
                    title: &test.name,
                },
                set,
                Encoding::Binary,
            )?;
            files.push((name, bytes));
        }
        if let Some(recording) = &test.recording {
            files.push((format!("{stem}.recording.uff"), recording.uff.clone()));
            files.push((
                format!("{stem}.truth.modes.json"),
                recording.truth_json.clone().into_bytes(),
            ));
        }
    }
    files.extend(published_tables(result));
    if let Some(table) = &result.table {
        files.push((
            "comparison.json".to_owned(),
            comparison_json(table, result, next).into_bytes(),
        ));
        // A program that reads CSV expects one table, with its heads as they always are.
        let comparison = comparison_of_all_tests(table, &result.theory);
        let text = CsvText.render(&comparison[..1]);
        files.push(("comparison.csv".to_owned(), text.into_bytes()));
    }
    let stem = match result.table {
        Some(_) => "comparison",
        None => "tables",
    };
    let findings = findings_blocks(result, language);
    for renderer in RENDERERS.iter().filter(|renderer| renderer.name() != "csv") {
        let tables = match renderer.name() {
            "latex" => &blocks.page,
            _ => &blocks.all,
        };
        let with_findings = [tables.as_slice(), findings.as_slice()].concat();
        files.push((
            format!("{stem}.{}", renderer.extension()),
            renderer.render(&with_findings).into_bytes(),
        ));
    }
    Ok(files)
}

/// A CSV file for each table of published results: a reader of CSV expects one table.
fn published_tables(result: &SceneResult) -> Vec<(String, Vec<u8>)> {
    let Some(expected) = &result.expected else {
        return Vec::new();
    };
    let tables = [
        (
            "published-roots.csv",
            published_roots_block(expected, &result.theory, None),
        ),
        (
            "published-comparison.csv",
            published_comparison_block(expected),
        ),
        ("published-claims.csv", claims_block(expected)),
    ];
    let file = |(name, block): (&str, Option<Block>)| {
        let text = CsvText.render(&[block?]);
        Some((name.to_owned(), text.into_bytes()))
    };
    tables.into_iter().filter_map(file).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_an_earlier_run_are_named() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(earlier_figures(folder.path(), &[], |_| false), None);
        std::fs::create_dir(folder.path().join("figures")).unwrap();
        for name in ["a.svg", "b.svg", "notes.txt"] {
            std::fs::write(folder.path().join("figures").join(name), "").unwrap();
        }
        let written = [("figures/a.svg".to_owned(), Vec::new())];
        let line = earlier_figures(folder.path(), &written, |_| false).unwrap();
        assert_eq!(line, "Left from an earlier run: figures/b.svg.");
        let both = [("figures/b.svg".to_owned(), Vec::new()), written[0].clone()];
        assert_eq!(earlier_figures(folder.path(), &both, |_| false), None);
        let removed = earlier_figures(folder.path(), &written, |name| name == "figures/b.svg");
        assert_eq!(removed, None);
    }
}
