//! The inputs in TOML, JSON and matrix files, and what the program does with each.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use modalign::axis::Band;
use modalign::io::{check_results, modes_from_json, read_matrix, selection_from_json};
use modalign::report::json::{
    REPORT_SCHEMA, RunReport, breakdown_from_json, comparison_from_json, order_from_json,
    report_from_json, speed_accuracy_from_json, update_from_json,
};
use modalign::report::{CompanionResults, Language, report_page};
use modalign::scene::{
    Figures, LimitedResult, LimitsUse, Provenance, Scene, check_confined, hammer_test,
    limits_from_toml, load_expected, load_model, load_synth, record,
};
use modalign::study::parse_study;
use modalign::theory::ModeOptions;

/// Models with more coordinates are read and not solved: they take time and nothing else.
const MAX_SOLVED_COORDINATES: usize = 60;

/// Recordings of more samples are not computed, for the same reason.
const MAX_RECORDED_SAMPLES: usize = 1 << 14;

/// A kind of input.
pub struct TextInput {
    /// Its name in messages.
    pub name: &'static str,
    /// How the names of its files end.
    pub file: &'static str,
    /// A whole input of this kind; empty where the files of [`write_inputs`] have all that it can
    /// hold.
    pub text: &'static str,
    /// Reads and uses an input in a folder where the files lie that it names.
    pub used: fn(&str, &Path),
}

/// Every kind, a line each.
#[rustfmt::skip]
pub const TEXT_INPUTS: &[TextInput] = &[
    TextInput { name: "model", file: "model.toml", text: LUMPED, used: use_model },
    TextInput { name: "synth", file: "synth.toml", text: "", used: use_spec },
    TextInput { name: "scene", file: "scene.toml", text: "", used: use_scene },
    TextInput { name: "expected", file: "expected.toml", text: "", used: use_expected },
    TextInput { name: "study", file: "study.toml", text: "", used: use_study },
    TextInput { name: "limits", file: "limits.toml", text: LIMITS, used: use_limits },
    TextInput { name: "modes-json", file: ".modes.json", text: "", used: use_modes },
    TextInput { name: "comparison", file: "comparison.json", text: "", used: use_comparison },
    TextInput { name: "update", file: "update.json", text: "", used: use_update },
    TextInput { name: "report", file: "report.json", text: "", used: use_report },
    TextInput { name: "manifest", file: "manifest.json", text: "", used: use_manifest },
    TextInput { name: "selection", file: "selection.json", text: SELECTION, used: use_selection },
    TextInput { name: "speed-accuracy", file: "speed-accuracy.json", text: "", used: use_speed_accuracy },
    TextInput { name: "order", file: "order.json", text: "", used: use_order },
    TextInput { name: "breakdown", file: "breakdown.json", text: "", used: use_breakdown },
    TextInput { name: "matrix", file: ".mtx", text: MATRIX, used: use_matrix },
];

impl TextInput {
    /// Whole inputs of this kind: its text, and files of [`write_inputs`] that are at most so long.
    pub fn seeds(&self, folder: &Path, max_bytes: u64) -> Vec<String> {
        let text = Some(self.text).filter(|text| !text.is_empty());
        let mut files: Vec<PathBuf> = [folder, &folder.join(RESULTS)]
            .into_iter()
            .flat_map(|folder| std::fs::read_dir(folder).unwrap())
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.to_str().is_some_and(|path| path.ends_with(self.file)))
            .filter(|path| path.metadata().unwrap().len() <= max_bytes)
            .collect();
        files.sort();
        let files = files
            .iter()
            .map(|file| std::fs::read_to_string(file).unwrap());
        text.map(str::to_owned).into_iter().chain(files).collect()
    }
}

/// Writes a short scene of the example `free-free-beam` of the project at `root` into a folder,
/// with all results that the program has of it.
pub fn write_inputs(root: &Path, program: &Path, folder: &Path) {
    let bar = root.join("measurements/free-free-beam");
    for name in ["scene.toml", "model.toml", "synth.toml", "expected.toml"] {
        let text = std::fs::read_to_string(bar.join(name)).unwrap();
        let text = text
            .replace("[60.0, 3200.0]", "[60.0, 900.0]")
            .replace("samples = 32768", "samples = 512");
        std::fs::write(folder.join(name), text).unwrap();
    }
    std::fs::write(folder.join("study.toml"), STUDY).unwrap();
    let verbs: [&[&str]; 5] = [
        &["run"],
        &["update"],
        &["study", "speed-accuracy"],
        &["study", "order"],
        &["study", "breakdown"],
    ];
    for verb in verbs {
        let mut command = Command::new(program);
        let command = command
            .args(verb)
            .arg(folder)
            .arg("-o")
            .arg(folder.join(RESULTS));
        let ran = command.output().unwrap();
        // A short recording misses limits.
        assert_ne!(ran.status.code(), Some(2), "{verb:?}: {ran:?}");
    }
}

const STUDY: &str = "schema = \"modalign-study/1\"\n[speed_accuracy]\nestimators = [\"h1\"]\nrecord_shares = [0.5]\norders = []\nsnr_db = [30.0, 55.0]\ndraws = 1\nrepeats = 1\n[breakdown]\nmethods = [\"peak\", \"line\"]\ndraws = 2\nrefine = 0\nstability = { highest_order = 4 }\ncase = { lines = 120 }\n[[breakdown.slice]]\nx = { factor = \"separation\", lo = 0.5, hi = 8.0, count = 2, scale = \"log\" }\ny = { factor = \"damping\", lo = 0.005, hi = 0.05, count = 2, scale = \"log\" }\n";

/// The folder of results in that of the scene.
const RESULTS: &str = "out";

/// A body on springs, with every kind of property.
const LUMPED: &str = "schema = \"modalign-model/1\"\ntitle = \"x\"\n[[parameter]]\nname = \"k\"\nunit = \"N/m\"\nnominal = 2e6\nlower = 1e6\nupper = 4e6\nstatus = \"assumed\"\n[[body]]\nname = \"a\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = 2.0\ninertia_kg_m2 = [0.01, 0.01, 0.02]\nfree = [\"x\", \"y\", \"rz\"]\n[[body]]\nname = \"b\"\nat_m = [0.3, 0.0, 0.0]\nmass_kg = 1.0\ninertia_kg_m2 = [0.01, 0.01, 0.02]\nfree = [\"x\", \"z\"]\n[[point]]\nname = \"p\"\nbody = \"a\"\nat_m = [0.1, 0.05, 0.0]\n[[point]]\nname = \"q\"\nbody = \"b\"\nat_m = [0.2, 0.0, 0.0]\n[[spring]]\nname = \"s\"\nfrom = \"p\"\nto = \"q\"\ndirection = [1.0, 0.0, 0.0]\nparameter = \"k\"\n[[spring]]\nname = \"g\"\nfrom = \"q\"\nto = \"ground\"\ndirection = [0.0, 0.0, 1.0]\nstiffness_n_per_m = 1e5\n";

const LIMITS: &str = "[limits]\nmin_mac = 0.9\nmax_missed = 0\nmax_frequency_error_percent = 5.0\n[[limits.mode]]\nname = \"f1\"\nhz = 100.0\nmax_error_percent = 1.0\n";

const SELECTION: &str = "{\"schema\": \"modalign-selection/1\", \"poles\": [{\"frequency_hz\": 100.0, \"damping_ratio\": 0.01, \"order\": 8}]}";

const MATRIX: &str = "%%MatrixMarket matrix coordinate real symmetric\n% stiffness\n3 3 4\n1 1 2.0\n2 1 -1.0\n2 2 2e0\n3 3 1\n";

fn use_model(text: &str, folder: &Path) {
    let path = folder.join("read-model.toml");
    std::fs::write(&path, text).unwrap();
    if check_confined(&path).is_err() {
        return;
    }
    let Ok(model) = load_model(&path, &BTreeMap::new()) else {
        return;
    };
    let system = model.model.assemble(&model.values);
    if system.is_ok_and(|system| system.mass.nrows() <= MAX_SOLVED_COORDINATES) {
        let options = ModeOptions {
            band: Band::new(0.0, 3000.0).ok(),
            ..ModeOptions::default()
        };
        let _ = model.solve(&[], &options);
        let _ = model.quantities();
        let _ = model.sensitivities(options.band);
        let _ = model.released_modes();
    }
}

fn use_spec(text: &str, folder: &Path) {
    let path = folder.join("read-synth.toml");
    std::fs::write(&path, text).unwrap();
    if check_confined(&path).is_err() {
        return;
    }
    let Ok(spec) = load_synth(&path) else { return };
    let is_long = spec.record.samples > MAX_RECORDED_SAMPLES || spec.averages > 10;
    if let Ok(test) = hammer_test(&spec, &path)
        && !is_long
    {
        let _ = record(&spec, &test, &path);
    }
}

fn use_scene(text: &str, folder: &Path) {
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    if check_confined(folder).is_ok() {
        let _ = Scene::load(folder);
    }
}

fn use_expected(text: &str, folder: &Path) {
    let path = folder.join("expected.toml");
    std::fs::write(&path, text).unwrap();
    let _ = load_expected(&path);
}

fn use_study(text: &str, _folder: &Path) {
    if let Ok(study) = parse_study(text, "study.toml") {
        let _ = study.breakdown.plan();
        let _ = study.order.validate();
        let _ = study.speed_accuracy.validate();
    }
}

fn use_limits(text: &str, _folder: &Path) {
    for decided_by in [LimitedResult::Comparison, LimitedResult::Modes] {
        let used = LimitsUse {
            decided_by: &[decided_by],
            result: "a result",
            expected: "limits on it",
        };
        let _ = limits_from_toml(text, "limits.toml", used);
    }
}

fn use_modes(text: &str, _folder: &Path) {
    let _ = modes_from_json(text, "modes.json");
}

fn use_comparison(text: &str, _folder: &Path) {
    if let Ok(file) = comparison_from_json(text) {
        let _ = file.check_summary();
    }
}

fn use_update(text: &str, _folder: &Path) {
    if update_from_json(text).is_ok() {
        show(CompanionResults {
            updated: serde_json::from_str(text).ok(),
            ..CompanionResults::default()
        });
    }
}

fn use_speed_accuracy(text: &str, _folder: &Path) {
    show(CompanionResults {
        speed_accuracy: speed_accuracy_from_json(text, "speed-accuracy.json").ok(),
        ..CompanionResults::default()
    });
}

fn use_order(text: &str, _folder: &Path) {
    show(CompanionResults {
        order: order_from_json(text, "order.json").ok(),
        ..CompanionResults::default()
    });
}

fn use_breakdown(text: &str, _folder: &Path) {
    show(CompanionResults {
        breakdown: breakdown_from_json(text, "breakdown.json").ok(),
        ..CompanionResults::default()
    });
}

/// The page of a run with these results.
fn show(companions: CompanionResults) {
    let breakdown = companions.breakdown.as_ref();
    let studies = [&companions.speed_accuracy, &companions.order];
    let mut titles = studies.into_iter().flatten().map(|study| &study["title"]);
    let title = titles.find_map(|title| title.as_str().map(str::to_owned));
    let title = title.or_else(|| breakdown.and_then(|study| study.title.clone()));
    let report = RunReport {
        schema: REPORT_SCHEMA.to_owned(),
        title: title.unwrap_or_default(),
        sections: Vec::new(),
        findings: Vec::new(),
        limits: Vec::new(),
        next: None,
        figures: Figures::default(),
        provenance: Provenance::default(),
    };
    let _ = report_page(&report, &companions, Language::English);
}

fn use_report(text: &str, _folder: &Path) {
    if let Ok(report) = report_from_json(text, "report.json") {
        let _ = report_page(&report, &CompanionResults::default(), Language::English);
    }
}

fn use_manifest(text: &str, folder: &Path) {
    std::fs::write(folder.join("manifest.json"), text).unwrap();
    let _ = check_results(folder);
}

fn use_selection(text: &str, _folder: &Path) {
    let _ = selection_from_json(text, "selection.json");
}

fn use_matrix(text: &str, folder: &Path) {
    let path = folder.join("read.mtx");
    std::fs::write(&path, text).unwrap();
    let _ = read_matrix(&path, None);
}
