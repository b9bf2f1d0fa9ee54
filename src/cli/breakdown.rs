//! `modalign study breakdown`: failure boundaries of methods, slice by slice; finished slices are
//! stored and reused.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::error::Error;
use crate::io::write_all_whole;
use crate::report::json::{self, BreakdownFile};
use crate::report::{
    Block, CsvText, Renderer, breakdown_blocks, breakdown_cells, breakdown_rates, breakdown_screen,
    breakdown_svg, breakdown_times, breakdown_user_modes, figure_files, stability_cells,
    stability_svg,
};
use crate::scene::{ModesOptions, load_modes, lost_part_findings, read_text, run_observed};
use crate::study::breakdown::{
    BreakdownResults, BreakdownTable, CellStore, Part, Plan, SliceResult, UserMode, compute, merge,
    user_modes,
};
use crate::study::{StudyError, parse_study};

use super::meter::ProcessMeter;
use super::outcome::Outcome;
use super::output::Output;
use super::scene_reading::SceneReading;
use super::study_args::BreakdownArgs;

/// The verb in a manifest.
const VERB: &str = "study breakdown";

/// Where the rest of the result is.
const REST: &str = "Ranges with intervals, failure modes, numerical stability: --full.";
/// The option that writes files.
const FILES: &str = "Maps: -o DIR.";

/// Computes the slices, or merges finished ones, and writes their maps and tables. Exit code 1 when
/// a file of the modes that are marked in the maps was partly bad.
pub fn breakdown(
    args: &BreakdownArgs,
    reading: SceneReading,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let mut spec = Spec::load(&args.input)?;
    spec.table.draws = args.draws.or(spec.table.draws);
    let plan = spec.table.plan().map_err(StudyError::from)?;
    let part = args.cells.unwrap_or(Part::WHOLE);
    // Parts may be computed in one folder at once; their slices are different.
    if let Some(folder) = args.output.as_ref().filter(|_| part.count == 1) {
        output.open_results(folder, Some(VERB))?;
    }
    // The slices take minutes: a fault of the scene or its files is reported before. Only whole
    // results mark modes.
    let marked = match part.count {
        1 => spec.marked_modes(reading, output)?,
        _ => MarkedModes::default(),
    };
    let finished = compute_slices(args, &plan, part, output)?;
    let kept = kept_slices(&finished);
    if part.count > 1 {
        let names = finished
            .slices
            .iter()
            .map(|result| result.slice.name.as_str());
        let names: Vec<&str> = names.collect();
        let done = format!(
            "part {} of {}: {}; --merge joins the parts",
            part.number,
            part.count,
            names.join(", ")
        );
        let blocks = kept.into_iter().chain([Block::Text(done)]);
        output.add_blocks(blocks.chain(breakdown_rates(&finished)).collect());
        return Ok(Outcome::Done);
    }
    let MarkedModes {
        title,
        modes: user_modes,
        is_bad,
    } = marked;
    let rates = breakdown_rates(&finished);
    let file = BreakdownFile {
        schema: json::BREAKDOWN_SCHEMA.to_owned(),
        title,
        slices: finished.slices,
        user_modes,
        stability: finished.stability,
    };
    if args.output.is_some() {
        let measured = !finished.times.is_empty();
        let times = measured.then(|| breakdown_times(&finished.times));
        output.add_results(VERB, files(&file, times, args.png));
    }
    output.add_result(
        |width| {
            let mut blocks = breakdown_screen(&file, width);
            blocks.extend(kept.clone());
            blocks
        },
        || {
            let blocks = breakdown_blocks(&file).into_iter();
            blocks.chain(rates).chain(kept.clone()).collect()
        },
    );
    output.add_rest_of_study(REST, Some(FILES).filter(|_| args.output.is_none()));
    output.add_json(|| json::breakdown_to_json(&file));
    Ok(Outcome::missed_if(is_bad))
}

/// The slices that were found finished in the folder, and those whose cells there are of another
/// spec.
fn kept_slices(finished: &BreakdownResults) -> Option<Block> {
    let reused = finished.reused.iter();
    let reused = reused.map(|name| format!("{name}: found finished"));
    let outdated = finished.outdated.iter();
    let outdated =
        outdated.map(|name| format!("{name}: the kept cells are of another spec; computed again"));
    let lines: Vec<String> = reused.chain(outdated).collect();
    (!lines.is_empty()).then(|| Block::Text(lines.join("\n")))
}

fn compute_slices(
    args: &BreakdownArgs,
    plan: &Plan,
    part: Part,
    output: &Output,
) -> Result<BreakdownResults, Error> {
    let cells: Box<dyn CellStore + '_> = match &args.output {
        Some(folder) => Box::new(FolderStore {
            path: folder.join(CELLS_FOLDER),
            output: Some(output),
        }),
        None => Box::new(MemoryStore::default()),
    };
    if args.merge.is_empty() {
        let computed = compute(plan, part, &*cells, output.observer(), &ProcessMeter);
        return Ok(computed.map_err(StudyError::from)?);
    }
    let folder = |path: &PathBuf| FolderStore {
        path: path.join(CELLS_FOLDER),
        output: None,
    };
    let parts: Vec<FolderStore> = args.merge.iter().map(folder).collect();
    let parts: Vec<&dyn CellStore> = parts.iter().map(|cells| cells as &dyn CellStore).collect();
    Ok(merge(plan, &parts, &*cells).map_err(StudyError::from)?)
}

/// A spec with its folder.
struct Spec {
    table: BreakdownTable,
    folder: PathBuf,
    /// The scene whose modes are shown.
    scene: Option<PathBuf>,
}

impl Spec {
    /// A spec, or the `study.toml` of a scene's folder; a scene without one has the default slices.
    fn load(path: &Path) -> Result<Self, Error> {
        let file = if path.is_dir() {
            path.join("study.toml")
        } else {
            path.to_path_buf()
        };
        let folder = file.parent().unwrap_or(Path::new(".")).to_path_buf();
        let is_scene = path.file_name().is_some_and(|name| name == "scene.toml");
        if is_scene || path.is_dir() && !file.exists() {
            return Ok(Self {
                table: BreakdownTable::default(),
                scene: Some(path.to_path_buf()),
                folder,
            });
        }
        let study = parse_study(&read_text(&file)?, &file.display().to_string())?;
        // The file, because the folder of a name alone is empty.
        let beside = Some(folder.join("scene.toml")).filter(|scene| scene.exists());
        Ok(Self {
            scene: study.scene.map(|scene| folder.join(scene)).or(beside),
            table: study.breakdown,
            folder,
        })
    }

    /// The modes of `modes`, else those of the scene's tests with its title, else none.
    fn marked_modes(
        &self,
        reading: SceneReading,
        output: &mut Output,
    ) -> Result<MarkedModes, Error> {
        if let Some(path) = &self.table.modes {
            let options = ModesOptions {
                partial: reading.partial,
                ..ModesOptions::default()
            };
            let loaded = load_modes(&self.folder.join(path), &options)?;
            if loaded.partly_bad {
                output.add_findings_of("", &lost_part_findings(&loaded.modes.findings));
            }
            return Ok(MarkedModes {
                title: None,
                modes: user_modes("", &loaded.modes, None),
                is_bad: loaded.partly_bad,
            });
        }
        let Some(scene) = &self.scene else {
            return Ok(MarkedModes::default());
        };
        let scene = reading.scene(scene)?;
        let result = run_observed(&scene, output.observer())?;
        for test in result.tests.iter().filter(|test| test.partly_bad) {
            output.add_findings_of(&test.name, &lost_part_findings(&test.modes.findings));
        }
        let several = result.tests.len() > 1;
        let of_test = result.tests.iter().flat_map(|test| {
            let name = if several { test.name.as_str() } else { "" };
            user_modes(name, &test.modes, test.frfs.first())
        });
        Ok(MarkedModes {
            title: Some(scene.title),
            modes: of_test.collect(),
            is_bad: result.partly_bad(),
        })
    }
}

/// Modes that are marked in the maps.
#[derive(Default)]
struct MarkedModes {
    /// Title of the scene that they come from.
    title: Option<String>,
    modes: Vec<UserMode>,
    /// Whether part of their files was bad.
    is_bad: bool,
}

/// Folder of the finished slices in the folder of the results.
const CELLS_FOLDER: &str = "cells";

/// Finished slices as files.
struct FolderStore<'a> {
    path: PathBuf,
    /// Whose interrupts wait while a file is written.
    output: Option<&'a Output>,
}

impl FolderStore<'_> {
    fn file(&self, name: &str) -> PathBuf {
        self.path.join(format!("{name}.json"))
    }
}

impl CellStore for FolderStore<'_> {
    fn load(&self, name: &str) -> Result<Option<String>, String> {
        let file = self.file(name);
        if !file.exists() {
            return Ok(None);
        }
        read_text(&file)
            .map(Some)
            .map_err(|error| error.to_string())
    }

    fn save(&self, name: &str, text: &str) -> Result<(), String> {
        let file = self.file(name);
        let _writing = self.output.map(Output::guard_writing);
        write_all_whole(&[(file, text.as_bytes().to_vec())]).map_err(|error| error.to_string())
    }
}

/// Finished slices of a run that writes nothing.
#[derive(Default)]
struct MemoryStore(Mutex<BTreeMap<String, String>>);

impl CellStore for MemoryStore {
    fn load(&self, name: &str) -> Result<Option<String>, String> {
        let kept = self.0.lock().map_err(|error| error.to_string())?;
        Ok(kept.get(name).cloned())
    }

    fn save(&self, name: &str, text: &str) -> Result<(), String> {
        let mut kept = self.0.lock().map_err(|error| error.to_string())?;
        kept.insert(name.to_owned(), text.to_owned());
        Ok(())
    }
}

fn csv(block: Block) -> Vec<u8> {
    CsvText.render(&[block]).into_bytes()
}

/// The files of the folder other than the cells. Measured times are in a separate file.
fn files(file: &BreakdownFile, times: Option<Block>, png: bool) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![
        (
            "breakdown.json".to_owned(),
            json::breakdown_to_json(file).into_bytes(),
        ),
        (
            "breakdown.csv".to_owned(),
            csv(breakdown_cells(&file.slices)),
        ),
    ];
    if !file.user_modes.is_empty() {
        let modes = breakdown_user_modes(&file.slices, &file.user_modes);
        files.push(("own-modes.csv".to_owned(), csv(modes)));
    }
    let figure = |slice: &SliceResult| {
        let svg = breakdown_svg(slice, &slice.locate_modes(&file.user_modes));
        (slice.slice.name.clone(), svg)
    };
    let mut figures: Vec<(String, String)> = file.slices.iter().map(figure).collect();
    if let Some(maps) = &file.stability {
        files.push(("stability.csv".to_owned(), csv(stability_cells(maps))));
        figures.push(("stability".to_owned(), stability_svg(maps)));
    }
    files.extend(figure_files(figures, png));
    files.extend(times.map(|times| ("breakdown-times.csv".to_owned(), csv(times))));
    files
}
