//! Every command of README and guide and every example of `--help` runs, in a folder that holds the
//! files that they name; of studies that differ in scene and output folder alone, the first.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::command::{root, write};

/// The verbs that the program lists.
fn verbs() -> Vec<String> {
    let general = String::from_utf8(run(root(), &["--help".to_owned()]).stdout).unwrap();
    let listed = general.split("Commands:").nth(1).unwrap();
    let listed = listed.split("Options:").next().unwrap().lines();
    let words = listed.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let verbs: Vec<String> = words
        .filter(|word| !word.is_empty() && *word != "help")
        .map(str::to_owned)
        .collect();
    assert!(verbs.len() >= 12, "{verbs:?}");
    verbs
}

/// The program with these words in a folder.
fn run(folder: &Path, words: &[String]) -> Output {
    let mut command = Command::new(crate::command::program());
    command.current_dir(folder).args(words).output().unwrap()
}

fn help(verb: &str) -> String {
    let output = run(root(), &[verb.to_owned(), "--help".to_owned()]);
    String::from_utf8(output.stdout).unwrap()
}

/// The command of a line of the README or of an example: `modalign ...` or `cp ...`, perhaps as a
/// step of a workflow, without its remark.
fn command_of(line: &str) -> Option<&str> {
    let line = line.trim();
    let line = line.strip_prefix("- run: ").unwrap_or(line);
    let line = line.split("  #").next().unwrap_or(line).trim();
    let is_known = line.starts_with("modalign ") || line.starts_with("cp ");
    is_known.then_some(line)
}

/// The README and the pages of the guide.
fn pages() -> Vec<(String, String)> {
    let guide = std::fs::read_dir(root().join("src/guide")).unwrap();
    let mut paths: Vec<PathBuf> = guide.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|kind| kind == "md"));
    paths.sort();
    paths.insert(0, root().join("README.md"));
    let page = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path.display().to_string(), text)
    };
    paths.into_iter().map(page).collect()
}

/// Commands in the blocks of a page, which are indented or fenced; not those of fences of plain
/// text.
fn commands(page: &str) -> Vec<String> {
    let mut fence: Option<&str> = None;
    let mut found = Vec::new();
    for line in page.lines() {
        let text = line.trim_start();
        if let Some(language) = text.strip_prefix("```") {
            fence = if fence.is_some() {
                None
            } else {
                Some(language)
            };
            continue;
        }
        let is_code = match fence {
            Some(language) => language != "text",
            None => line.starts_with("    "),
        };
        found.extend(command_of(line).filter(|_| is_code).map(str::to_owned));
    }
    found
}

/// Words of a line as a shell parts them, quotes taken off, and the file that standard output goes
/// to.
fn words(line: &str) -> (Vec<String>, Option<String>) {
    let mut words: Vec<String> = Vec::new();
    let (mut quote, mut word) = (None, String::new());
    for c in line.chars() {
        match quote {
            Some(open) if open == c => quote = None,
            None if c == '"' || c == '\'' => quote = Some(c),
            None if c == ' ' => {
                words.extend(Some(std::mem::take(&mut word)).filter(|whole| !whole.is_empty()))
            }
            _ => word.push(c),
        }
    }
    words.extend(Some(word).filter(|whole| !whole.is_empty()));
    let target = words.iter().position(|word| word == ">");
    let file = target.map(|at| words.split_off(at)[1].clone());
    (words.split_off(1), file)
}

/// As short as studies can be, one slice with a few draws at its corners, one draw at one level:
/// those of a scene take minutes.
const STUDY: &str = "schema = \"modalign-study/1\"\n[speed_accuracy]\nestimators = []\nrecord_shares = []\n\
    orders = []\nsnr_db = [60.0]\ndraws = 1\nrepeats = 1\n[breakdown]\ndraws = 2\nrefine = 0\nmethods = [\"circle\"]\n\
    stability = { highest_order = 4 }\n[[breakdown.slice]]\n\
    x = { factor = \"damping\", lo = 0.002, hi = 0.02, count = 2 }\n\
    y = { factor = \"separation\", lo = 2, hi = 8, count = 2 }\n";

const LIMITS: &str = "[limits]\nmax_extra = 0\n";

/// Three masses in a row with a sensor each.
fn housing() -> String {
    let mut text = "schema = \"modalign-model/1\"\ntitle = \"Three masses\"\n".to_owned();
    let names = ["a", "b", "c"];
    for (number, name) in names.iter().enumerate() {
        let place = format!("at_m = [0.{number}, 0.0, 0.0]");
        text += &format!(
            "[[body]]\nname = \"{name}\"\n{place}\nmass_kg = 1.{number}\nfree = [\"z\"]\n\
             [[point]]\nname = \"p{name}\"\nbody = \"{name}\"\n{place}\n\
             [[sensor]]\ndof = \"{}:+Z\"\nbody = \"{name}\"\n{place}\n",
            number + 1
        );
    }
    for (from, to) in [("pa", "ground"), ("pa", "pb"), ("pb", "pc")] {
        text += &format!(
            "[[spring]]\nname = \"{from}-{to}\"\nfrom = \"{from}\"\nto = \"{to}\"\n\
             direction = [0.0, 0.0, 1.0]\nstiffness_n_per_m = 1.0e6\n"
        );
    }
    text
}

/// The files that the commands name: a short recording of the beam and what verbs make of it.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(beam.join(name)).unwrap();
    // Three of the six modes: the studies of the methods take less than half of the time.
    let scene = text("scene.toml")
        .replace("band_hz = [60.0, 3200.0]", "band_hz = [60.0, 1100.0]")
        .replace("min_paired = 6", "min_paired = 3");
    assert!(scene.contains("1100.0") && scene.contains("min_paired = 3"));
    let spec = text("synth.toml").replace("samples = 32768", "samples = 4096");
    let sensors = &scene[scene.find("[[sensor]]").unwrap()..];
    // Half of the elements: an update solves the model some hundred times, and time goes with the
    // cube.
    let model = text("model.toml").replace("elements = 60", "elements = 30") + "\n" + sensors;
    let files = [
        ("spec.toml", spec.as_str()),
        ("model.toml", &model),
        ("housing.toml", &housing()),
        ("limits.toml", LIMITS),
        ("study.toml", STUDY),
    ];
    write(folder.path(), &files);
    // The cycloid ball transmission takes long and has separate tests: the beam replaces it here.
    for name in ["cycloid-ball", "free-free-beam"] {
        let scene_folder = folder.path().join("measurements").join(name);
        std::fs::create_dir_all(&scene_folder).unwrap();
        let files = [
            ("scene.toml", scene.as_str()),
            ("model.toml", &model),
            ("synth.toml", &spec),
            ("study.toml", STUDY),
        ];
        write(&scene_folder, &files);
    }
    let export = folder.path().join("measurements/testlab-bar");
    std::fs::create_dir_all(&export).unwrap();
    for name in ["bar.unv", "model.toml"] {
        let from = root().join("measurements/testlab-bar").join(name);
        std::fs::copy(from, export.join(name)).unwrap();
    }
    let machine = folder.path().join("measurements/machine");
    std::fs::create_dir_all(&machine).unwrap();
    write(
        &machine,
        &[
            ("scene.toml", scene.as_str()),
            ("model.toml", &model),
            ("synth.toml", &spec),
        ],
    );
    for line in [
        "modalign synth spec.toml -o hits.uff",
        "modalign frf hits.uff --force-window 0.02 -o hammer.h5",
        "modalign identify hammer.h5 --band 60:3200 --method circle -o modes.json",
        "modalign theory model.toml --band 0:3200 -o wing.unv",
        "modalign convert wing.unv -o wing-model.unv",
        "modalign convert wing.unv -o model.unv",
        "modalign theory housing.toml -o housing.json",
        "modalign convert hammer.h5 -o model.uff",
        "modalign convert hammer.h5 -o model-frfs.uff",
        "modalign convert hammer.h5 -o frfs.h5",
    ] {
        let (words, _) = words(line);
        let output = run(folder.path(), &words);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{line}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    folder
}

/// Words of a study without its scene and its output folder: studies take seconds, and all scenes
/// here are the beam, so that of studies with equal words the first runs.
fn study_key(words: &[String]) -> Option<Vec<String>> {
    let is_study = words.first().is_some_and(|word| word == "study");
    let mut key = words.to_vec();
    if let Some(option) = key.iter().position(|word| word == "-o") {
        key.drain(option..option + 2);
    }
    key.retain(|word| !word.starts_with("measurements/"));
    is_study.then_some(key)
}

#[test]
fn every_command_of_readme_and_guide_and_every_example_runs() {
    let folder = prepared();
    let mut lines = Vec::new();
    for verb in verbs() {
        let text = help(&verb);
        let examples = text
            .split("Example")
            .nth(1)
            .unwrap_or_else(|| panic!("{verb} --help has no example"));
        let commands: Vec<String> = examples
            .lines()
            .filter_map(command_of)
            .map(str::to_owned)
            .collect();
        assert!(
            !commands.is_empty(),
            "{verb} --help has an example that can be typed"
        );
        assert!(
            commands
                .iter()
                .all(|line| line.split(' ').nth(1) == Some(&verb)),
            "{commands:?}"
        );
        lines.extend(commands);
    }
    for (path, text) in pages() {
        let commands = commands(&text);
        let at_least = if path.ends_with("README.md") { 8 } else { 0 };
        assert!(commands.len() >= at_least, "{path} was read: {commands:?}");
        lines.extend(commands);
    }
    let mut known = BTreeSet::new();
    lines.retain(|line| known.insert(line.clone()));
    // Names that several commands write: each begins as it was prepared.
    let model = std::fs::read(folder.path().join("model.toml")).unwrap();
    let modes = std::fs::read(folder.path().join("modes.json")).unwrap();
    let mut studies = BTreeSet::new();
    for line in lines {
        std::fs::write(folder.path().join("model.toml"), &model).unwrap();
        std::fs::write(folder.path().join("modes.json"), &modes).unwrap();
        let (words, target) = words(&line);
        if line.starts_with("cp ") {
            let [from, to] = [0, 1].map(|index| folder.path().join(&words[index]));
            std::fs::copy(from, to).unwrap();
            continue;
        }
        if study_key(&words).is_some_and(|key| !studies.insert(key)) {
            continue;
        }
        let output = run(folder.path(), &words);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}\n{error}");
        if let Some(name) = target {
            std::fs::write(folder.path().join(name), &output.stdout).unwrap();
        }
    }
}

#[test]
fn the_readme_is_short_and_its_example_is_what_is_printed() {
    let text = std::fs::read_to_string(root().join("README.md")).unwrap();
    assert!(text.len() <= 10_000, "{} bytes", text.len());
    for line in text.lines() {
        assert!(line.chars().count() <= 120, "{line}");
    }
    let (_, after) = text.split_once("```text\n").unwrap();
    let (example, _) = after.split_once("```").unwrap();
    let words = ["run", "measurements/free-free-beam"].map(str::to_owned);
    let printed = String::from_utf8(run(root(), &words).stdout).unwrap();
    assert_eq!(example, printed);
}

#[test]
fn links_between_pages_lead_to_files() {
    for (path, text) in pages() {
        let folder = Path::new(&path).parent().unwrap();
        for link in text.split("](").skip(1) {
            let target = link.split([')', '#']).next().unwrap();
            if !target.is_empty() && !target.contains("://") {
                assert!(folder.join(target).exists(), "{path}: {target}");
            }
        }
    }
}

#[test]
fn every_verb_has_its_row_in_the_readme() {
    let text = std::fs::read_to_string(root().join("README.md")).unwrap();
    for verb in verbs() {
        assert!(text.contains(&format!("| `modalign {verb}")), "{verb}");
    }
}

#[test]
fn words_part_as_in_a_shell() {
    let (arguments, file) = words("modalign theory 'a b' --set \"x=1\" > out.txt");
    assert_eq!(arguments, ["theory", "a b", "--set", "x=1"]);
    assert_eq!(file.as_deref(), Some("out.txt"));
    assert_eq!(
        command_of("    - run: modalign run x -o out   # remark"),
        Some("modalign run x -o out")
    );
    assert_eq!(command_of("    [limits]"), None);
}
