//! Real recordings through the command line, where the private data folder is present.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use modalign::frf::FrfSet;
use modalign::io::{Hints, HitFile, frf_sets, open_path};

use serde_json::Value;

use crate::command::{json, shared_data, shared_folder, succeed, write};

/// Reads a FRF file that the program wrote.
fn read_frfs(path: &Path) -> FrfSet {
    let hints = Hints {
        path: path.display().to_string(),
        table: None,
    };
    let source = open_path(path, &hints, None).unwrap();
    let mut files = [HitFile::new(source)];
    frf_sets(&mut files).unwrap().remove(0)
}

fn plate_scene(data: &Path, estimator: &str) -> String {
    format!(
        r#"schema = "modalign-scene/1"
title = "Five single hits on a plate"
[[test]]
name = "plate"
files = ["{}/tonewood-plate1/*.csv"]
hits = "files"
sampling_rate_hz = 48000
[[test.channel]]
column = "force"
role = "force"
dof = "1:+Z"
unit = "N"
[[test.channel]]
column = "acceleration"
role = "response"
dof = "2:+Z"
unit = "m/s2"
[frf]
estimator = "{estimator}"
"#,
        data.display()
    )
}

#[test]
fn five_single_hits_of_a_plate_give_the_expected_h1_h2_and_coherence() {
    let Some(data) = shared_data() else { return };
    let data = data.canonicalize().unwrap();
    let expected =
        json(&data.join("expected.json"))["tonewood-plate1"]["rect_window_full_record"].clone();
    for estimator in ["h1", "h2"] {
        let folder = tempfile::tempdir().unwrap();
        write(
            folder.path(),
            &[("scene.toml", &plate_scene(&data, estimator))],
        );
        let out = folder.path().join("plate.uff");
        let scene = folder.path().to_str().unwrap();
        succeed([
            "frf",
            scene,
            "--estimator",
            estimator,
            "-o",
            out.to_str().unwrap(),
        ]);
        assert_listed(&read_frfs(&out), estimator, &expected);
    }
}

/// The only function of a set against the listed lines of a recording.
fn assert_listed(set: &FrfSet, estimator: &str, expected: &Value) {
    for line in expected.as_array().unwrap() {
        let index = line["index"].as_u64().unwrap() as usize;
        let wanted = &line[estimator.to_uppercase()];
        let (re, im) = (wanted[0].as_f64().unwrap(), wanted[1].as_f64().unwrap());
        let got = set.values(0)[index];
        let error = ((got.re - re).powi(2) + (got.im - im).powi(2)).sqrt() / re.hypot(im);
        assert!(
            error < 1e-6,
            "{estimator} line {index}: {got} differs by {error}"
        );
        let coherence = set.coherence(0).unwrap()[index];
        assert!(
            (coherence - line["coh"].as_f64().unwrap()).abs() < 1e-6,
            "{coherence}"
        );
    }
}

#[test]
fn three_hits_in_an_array_are_all_kept_and_give_the_expected_h1_h2_and_coherence() {
    let Some(data) = shared_data() else { return };
    let data = data.canonicalize().unwrap();
    let expected = json(&data.join("expected.json"));
    for name in ["F1", "F2", "F3"] {
        let listed = &expected[&format!("dewesoft-hammer/{name}.npy")];
        for estimator in ["h1", "h2"] {
            let folder = tempfile::tempdir().unwrap();
            let scene = format!(
                "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"t\"\n\
                 files = [\"{}/dewesoft-hammer/{name}.npy\"]\ndimensions = [\"hit\", \"channel\", \"sample\"]\n\
                 sampling_rate_hz = {}\n\
                 [[test.channel]]\ncolumn = 1\nrole = \"force\"\ndof = \"1:+Z\"\nunit = \"N\"\n\
                 [[test.channel]]\ncolumn = 4\nrole = \"response\"\ndof = \"2:+Z\"\nunit = \"m/s2\"\n",
                data.display(),
                listed["fs_hz"]
            );
            write(folder.path(), &[("scene.toml", &scene)]);
            let out = folder.path().join("frf.uff");
            let (scene, out_text) = (folder.path().to_str().unwrap(), out.to_str().unwrap());
            let options = ["--json", "frf", scene, "--estimator", estimator];
            let summary = succeed(options.into_iter().chain(["-o", out_text]));
            let summary: Value = serde_json::from_str(&summary).unwrap();
            let hits = summary["hits"].as_array().unwrap();
            assert!(hits.len() == 3 && hits.iter().all(|hit| hit["used"] == true));
            assert_listed(&read_frfs(&out), estimator, &listed["ch3"]);
        }
    }
}

/// Positions of the nine hits along the beam, m, with the origin shifted by 10 mm as fitted.
const HITS_M: [f64; 9] = [0.1, 0.25, 0.375, 0.5, 0.65, 0.8, 0.925, 1.05, 1.2];
const SHIFT_M: f64 = -0.01;
const LENGTH_M: f64 = 1.285;

fn beam_scene(data: &Path) -> String {
    let mut text = format!(
        r#"schema = "modalign-scene/1"
title = "Free-free beam, roving hammer, against the slender-beam model"
[model]
file = "model.toml"
[[test]]
name = "roving hammer"
files = ["{0}/modelab-beam/Hxysv*.txt"]
delimiter = "blank"
skip_lines = 9
band_hz = [65.0, 1000.0]
[[test.channel]]
column = 1
role = "frequency"
[[test.channel]]
column = 2
role = "real"
unit = "(m/s2)/N"
[[test.channel]]
column = 3
role = "imaginary"
unit = "(m/s2)/N"
"#,
        data.display()
    );
    for number in 1..=9 {
        text += &format!(
            "[[test.file]]\npath = \"{}/modelab-beam/Hxysv{number:05}.txt\"\nresponse = \"10:-X\"\nreference = \"{number}:+X\"\n",
            data.display()
        );
    }
    for (index, z) in HITS_M.iter().enumerate() {
        text += &sensor(index + 1, *z);
    }
    text + &sensor(10, 0.5)
}

fn sensor(point: usize, z: f64) -> String {
    format!(
        "[[sensor]]\ndof = \"{point}:+X\"\nbody = \"bar\"\nat_m = [0.0, 0.0, {}]\n",
        z + SHIFT_M
    )
}

/// A slender beam whose first frequency is 111.99 Hz: EI from f = (beta L)^2/(2 pi L^2)
/// sqrt(EI/(rho A)).
fn beam_model() -> String {
    let beta_l: f64 = 4.730_040_744_862_704;
    let (density, area) = (2700.0, 1e-3);
    let stiffness = (TAU * 111.99 * LENGTH_M.powi(2) / beta_l.powi(2)).powi(2) * density * area;
    format!(
        r#"schema = "modalign-model/1"
kind = "beam"
title = "Slender beam scaled to the first measured frequency"
[[beam]]
name = "bar"
from_m = [0.0, 0.0, 0.0]
to_m = [0.0, 0.0, {LENGTH_M}]
deflection = [1.0, 0.0, 0.0]
elements = 40
start = "free"
end = "free"
youngs_modulus_pa = 7e10
density_kg_per_m3 = {density}
area_m2 = {area}
second_moment_m4 = {}
"#,
        stiffness / 7e10
    )
}

/// What the run of the measured beam printed, and its folder of results.
pub struct BeamRun {
    screen: String,
    pub out: PathBuf,
}

/// One run of the measured beam for all tests: its identification takes long.
pub fn beam_run(data: &Path) -> &'static BeamRun {
    static RUN: OnceLock<BeamRun> = OnceLock::new();
    RUN.get_or_init(|| {
        let data = data.canonicalize().unwrap();
        let folder = shared_folder("measured-beam");
        let files = [
            ("scene.toml", beam_scene(&data)),
            ("model.toml", beam_model()),
        ];
        write(
            &folder,
            &files.each_ref().map(|(name, text)| (*name, text.as_str())),
        );
        let out = folder.join("out");
        let path = |path: &Path| path.to_str().unwrap().to_owned();
        let screen = succeed(["run", &path(&folder), "-o", &path(&out)]);
        BeamRun { screen, out }
    })
}

#[test]
fn a_measured_beam_gives_its_four_modes_and_the_slender_beam_table() {
    let Some(data) = shared_data() else { return };
    let BeamRun { screen, out } = beam_run(&data);
    let table = json(&out.join("comparison.json"));
    let reference = json(&data.join("expected.json"))["modelab-beam"].clone();
    let rows: Vec<_> = table["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["tests"][0]["status"] == "paired")
        .collect();
    assert_eq!(rows.len(), 4, "{screen}");
    assert_eq!(table["summary"]["tests"][0]["extra"], 0);
    // Errors of the slender beam scaled to the first frequency: (ratio measured / ratio slender -
    // 1), growing to 2.7 %.
    let errors = [0.0, -0.6, -1.5, -2.6];
    for (index, row) in rows.iter().enumerate() {
        let cell = &row["tests"][0];
        let (hz, wanted) = (
            cell["hz"].as_f64().unwrap(),
            reference["reference_freq_hz"][index].as_f64().unwrap(),
        );
        assert!((hz / wanted - 1.0).abs() < 2e-4, "{hz} {wanted}");
        let mac = cell["mac"].as_f64().unwrap();
        assert!(
            mac > if index == 3 { 0.96 } else { 0.98 },
            "mode {}: MAC {mac}",
            index + 1
        );
        let error = cell["error_percent"].as_f64().unwrap();
        assert!(
            (error - errors[index]).abs() < 0.15,
            "mode {}: {error} %",
            index + 1
        );
    }
}
