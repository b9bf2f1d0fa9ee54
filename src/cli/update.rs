//! `modalign update`: the model of a scene brought to its test.

use std::path::PathBuf;

use crate::correlate::ComparisonTable;
use crate::error::Error;
use crate::report::{
    RENDERERS, json, step_after_update, step_to_check, update_blocks, update_page, update_screen,
};
use crate::scene::{TestResult, update_scene};

use super::args::UpdateArgs;
use super::outcome::Outcome;
use super::output::Output;
use super::report::{RUN_VERB, UPDATE_VERB, rebuild_page, update_figures};
use super::run::add_folder_files;
use super::scene_reading::SceneReading;
use super::test_stem::file_stem;

/// Updates the scene's model; exit code 1 when it did not converge or part of the input was bad.
pub fn update(
    args: &UpdateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let partial = args.partial;
    let scene = SceneReading { format, partial }.scene(&args.scene)?;
    if let Some(folder) = &args.output {
        output.open_results(folder, Some(UPDATE_VERB))?;
    }
    let outcome = update_scene(&scene)?;
    let blocks = update_blocks(&scene.title, &outcome);
    if let Some(folder) = &args.output {
        let updated = json::update_file(&outcome);
        let mut files = vec![
            ("update.json".to_owned(), json::update_to_json(&outcome)),
            ("model.toml".to_owned(), outcome.model_toml.clone()),
        ];
        files.extend(comparison_files("", &outcome.before, &outcome.after));
        for (number, other) in outcome.configurations.iter().enumerate() {
            let stem = file_stem(&other.name);
            let mut before = outcome.configurations[..number].iter();
            let stem = match before.any(|before| file_stem(&before.name) == stem) {
                true => format!("{stem}-{}.", number + 1),
                false => stem + ".",
            };
            files.extend(comparison_files(&stem, &other.before, &other.after));
            let model = other.model_toml.clone();
            files.extend(model.map(|text| (format!("{stem}model.toml"), text)));
        }
        // A reader of CSV expects one table; update.json has them all.
        for renderer in RENDERERS.iter().filter(|renderer| renderer.name() != "csv") {
            let blocks = match renderer.name() {
                "latex" => update_page(&scene.title, &outcome),
                _ => blocks.clone(),
            };
            files.push((
                format!("update.{}", renderer.extension()),
                renderer.render(&output.language().translated(blocks)),
            ));
        }
        let mut files: Vec<(String, Vec<u8>)> = files
            .into_iter()
            .map(|(name, text)| (name, text.into_bytes()))
            .collect();
        let updated_json = serde_json::json!(updated);
        let language = output.language();
        let page = rebuild_page(folder, &updated_json, language, args.png)?;
        add_folder_files(RUN_VERB, folder, page, &scene, output)?;
        let synthetic = outcome.all_tests().any(TestResult::is_synthetic);
        files.extend(update_figures(&updated, synthetic, args.png));
        add_folder_files(UPDATE_VERB, folder, files, &scene, output)?;
    }
    output.add_result(
        |width| update_screen(&scene.title, &outcome, width),
        || blocks,
    );
    let rest = match &args.output {
        Some(_) => "All tables, columns and notes: --full, or update.txt in the folder.",
        None => "All tables and columns: --full; updated model and tables: -o DIR.",
    };
    let to_check = |folder: &PathBuf| {
        let path = args.scene.display().to_string();
        step_to_check(&folder.display().to_string(), &path, &scene)
    };
    let next = step_after_update(&outcome).or_else(|| args.output.as_ref().map(to_check));
    output.add_closing(next.into_iter().collect(), Some(rest));
    output.add_json(|| json::update_to_json(&outcome));
    let findings = match output.wants_all() {
        true => outcome.findings.clone(),
        false => outcome.findings_on_update(),
    };
    for (test, finding) in &findings {
        output.add_findings_of(test, std::slice::from_ref(finding));
    }
    let partly_bad = outcome.all_tests().any(|test| test.partly_bad);
    Ok(Outcome::missed_if(
        partly_bad || !outcome.result.stop_reason.converged(),
    ))
}

/// The comparisons of a configuration before and after.
fn comparison_files(
    stem: &str,
    before: &ComparisonTable,
    after: &ComparisonTable,
) -> [(String, String); 2] {
    [("before", before), ("after", after)].map(|(name, table)| {
        let text = json::comparison_to_json(table);
        (format!("{stem}comparison-{name}.json"), text)
    })
}
