//! `new`: a scene from exported files that runs when they state everything, and else names the line
//! to fill in.

use std::path::Path;

use crate::command::{fail, json, modalign, root, succeed, write};
use crate::matrix_models::matrix_market;

/// A folder with the beam's model and a short recording of it.
pub fn recorded() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(beam.join(name)).unwrap();
    let spec = text("synth.toml").replace("samples = 32768", "samples = 4096");
    write(
        folder.path(),
        &[("model.toml", &text("model.toml")), ("synth.toml", &spec)],
    );
    succeed([
        "synth",
        &at(folder.path(), "synth.toml"),
        "-o",
        &at(folder.path(), "hits.uff"),
    ]);
    folder
}

pub fn at(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

/// Writes `frfs.h5` and `modes.json` of the recording.
pub fn estimate_and_identify(folder: &Path) {
    let path = |name: &str| at(folder, name);
    succeed(["frf", &path("hits.uff"), "-o", &path("frfs.h5")]);
    succeed([
        "identify",
        &path("frfs.h5"),
        "--band",
        "60:3200",
        "--method",
        "circle",
        "-o",
        &path("modes.json"),
    ]);
}

#[test]
fn a_scene_of_files_that_state_everything_runs_as_it_is() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    estimate_and_identify(folder.path());
    for (scene, file, copied) in [
        ("a", "hits.uff", false),
        ("b", "frfs.h5", true),
        ("c", "modes.json", true),
    ] {
        let mut arguments = vec!["new".to_owned(), path(scene), path(file)];
        arguments.extend(copied.then(|| "--copy".to_owned()));
        let printed = succeed(&arguments);
        assert!(printed.contains("nothing is left to fill in"), "{printed}");
        assert_eq!(
            folder.path().join(scene).join("raw").join(file).exists(),
            copied
        );
        let run = succeed(["run", &path(scene), "-o", &path(&format!("{scene}/out"))]);
        assert!(
            run.contains("143.") && run.contains("394."),
            "{scene}: {run}"
        );
        for name in ["SOURCE.md", "expected.toml", "scene.toml"] {
            assert!(folder.path().join(scene).join(name).exists());
        }
    }
    let source = std::fs::read_to_string(path("a/SOURCE.md")).unwrap();
    let sha = modalign::io::sha256_hex(Path::new(&path("hits.uff"))).unwrap();
    assert!(
        source.contains(&sha) && source.contains("../hits.uff"),
        "{source}"
    );
}

#[test]
fn a_scene_with_a_model_lists_lines_to_fill_in_and_then_compares() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    let printed = succeed([
        "new",
        &path("beam"),
        &path("hits.uff"),
        "--model",
        &path("model.toml"),
    ]);
    assert!(
        printed.contains("11 lines to be filled in"),
        "a place for each point: {printed}"
    );
    assert_eq!(printed.matches(": at_m: [x, y, z] in metres").count(), 1);
    let scene = std::fs::read_to_string(path("beam/scene.toml")).unwrap();
    let line = 1 + scene
        .lines()
        .position(|line| line.contains("FILL IN") && !line.starts_with('#'))
        .unwrap();
    let error = fail(["run", &path("beam")]);
    assert!(
        error.contains(&format!(
            "scene.toml:{line}: at_m is to be filled in: 1:+Z: [x, y, z] in metres"
        )),
        "{error}"
    );
    let mut filled = String::new();
    let mut number = 0;
    for line in scene.lines() {
        if let Some(dof) = line.strip_prefix("dof = \"") {
            number = dof.split(':').next().unwrap().parse().unwrap();
        }
        if line.starts_with("at_m = ") {
            filled += &format!("at_m = [{:.2}, 0.0, 0.0]\n", 0.06 * f64::from(number - 1));
        } else {
            filled += &format!("{line}\n");
        }
    }
    write(folder.path(), &[("beam/scene.toml", &filled)]);
    succeed(["run", &path("beam"), "-o", &path("out")]);
    let table = json(&folder.path().join("out/comparison.json"));
    assert_eq!(
        table["summary"]["tests"][0]["paired"], 6,
        "{}",
        table["summary"]
    );
}

#[test]
fn unknown_meanings_of_columns_are_requested_line_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    let rows: String = (0..64).map(|i| format!("{},{}\n", i % 7, i % 5)).collect();
    for name in ["hit1.csv", "hit2.csv"] {
        write(
            folder.path(),
            &[(name, &format!("force,acceleration\n{rows}"))],
        );
    }
    let printed = succeed(["new", &path("plate"), &path("hit1.csv"), &path("hit2.csv")]);
    let scene = std::fs::read_to_string(path("plate/scene.toml")).unwrap();
    for wanted in ["sampling_rate_hz", "unit", "dof"] {
        assert!(printed.contains(&format!(": {wanted}: ")), "{printed}");
    }
    assert!(
        scene.contains("hits = \"files\"") && scene.contains("role = \"force\""),
        "{scene}"
    );
    let error = fail(["run", &path("plate")]);
    let line = 1 + scene
        .lines()
        .position(|line| line.starts_with("sampling_rate_hz"))
        .unwrap();
    assert!(
        error.contains(&format!(
            "scene.toml:{line}: sampling_rate_hz is to be filled in"
        )),
        "{error}"
    );
    let filled = scene
        .replace("sampling_rate_hz = \"FILL IN\"", "sampling_rate_hz = 1000")
        .replacen("unit = \"FILL IN\"", "unit = \"N\"", 1)
        .replacen("dof = \"FILL IN\"", "dof = \"1:+Z\"", 1)
        .replacen("unit = \"FILL IN\"", "unit = \"g\"", 1)
        .replacen("dof = \"FILL IN\"", "dof = \"2:+Z\"", 1);
    write(folder.path(), &[("plate/scene.toml", &filled)]);
    // These rows are no hammer test, but the scene is understood.
    let table = succeed(["inspect", &path("hit1.csv")]);
    assert!(table.contains("force"), "{table}");
    let output = modalign(["frf", &path("plate"), "-o", &path("frf.uff")]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        !error.contains("filled in") && !error.contains("scene.toml"),
        "{error}"
    );
}

#[test]
fn inspect_says_what_new_reads_from_the_headings_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let inspect = |headings: &str| {
        write_columns(folder.path(), "a.csv", headings);
        let text = succeed(["inspect", &path("a.csv")]);
        let next = text.lines().rfind(|line| line.starts_with("Next: "));
        let next = next.unwrap_or_default().to_owned();
        (text, next)
    };
    let (text, next) = inspect("time [ms],force [kN],acceleration (g)");
    for content in ["time axis", "force, kN", "response, g"] {
        assert!(text.contains(content), "{content}: {text}");
    }
    assert!(
        text.contains("Not stated: the response of functions or records, the excitation point.\n"),
        "{text}"
    );
    assert_eq!(
        next,
        "Next: modalign new DIR FILE... --response DOF --reference DOF"
    );
    assert!(
        text.contains("DOF: point and direction, such as 1:+Z."),
        "{text}"
    );
    succeed(["new", &path("scene"), &path("a.csv")]);
    let scene = std::fs::read_to_string(folder.path().join("scene/scene.toml")).unwrap();
    for line in [
        "unit = \"kN\"   # by its name",
        "unit = \"g\"   # by its name",
        "the names state what they hold",
    ] {
        assert!(scene.contains(line), "{line}: {scene}");
    }
    // A unit of another quantity is none of the column; the sampling rate has no column.
    let (text, next) = inspect("hammer [m/s2],acc");
    assert!(text.contains("force, unit not stated"), "{text}");
    assert!(next.ends_with("--unit UNIT --sampling-rate HZ"), "{next}");
    let (text, next) = inspect("frequency,real,imag");
    assert!(!text.contains("sampling"), "{text}");
    assert!(next.ends_with("--reference DOF --unit UNIT"), "{next}");
    let (text, _) = inspect("a,force");
    assert!(
        text.contains("The names of 1 column do not state the contents"),
        "{text}"
    );
    let json = succeed(["inspect", &path("a.csv"), "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let arrays = &json["files"][0]["arrays"];
    assert!(arrays[0]["columns"][0].is_null(), "{arrays}");
    assert_eq!(arrays[1]["columns"][0]["role"], "force");
}

/// Writes a table of 64 rows of numbers under the headings.
pub fn write_columns(folder: &Path, file: &str, headings: &str) {
    let row = |i: usize| {
        let values = headings.split(',').enumerate();
        let values: Vec<String> = values
            .map(|(j, heading)| match heading {
                "frequency" => i.to_string(),
                _ => (i % (7 - j)).to_string(),
            })
            .collect();
        values.join(",") + "\n"
    };
    let rows: String = (0..64).map(row).collect();
    write(folder, &[(file, &format!("{headings}\n{rows}"))]);
}

/// The lines of the scene in a folder that begin with `dof = `.
fn dof_lines(folder: &Path, scene: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join(scene).join("scene.toml")).unwrap();
    let (tests, _sensors) = text.split_once("[[sensor]]").unwrap_or((&text, ""));
    let dofs = tests.lines().filter(|line| line.starts_with("dof = "));
    dofs.map(str::to_owned).collect()
}

#[test]
fn stated_sensors_are_those_of_the_columns_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write_columns(folder.path(), "one.csv", "force,acceleration");
    write_columns(folder.path(), "two.csv", "force,acceleration,velocity");
    write_columns(
        folder.path(),
        "frfs.csv",
        "frequency,real,imaginary,real 2,imaginary 2",
    );
    for (scene, sensors, hit, wanted) in [
        ("one", "2:+Z", "1:+Z", vec!["1:+Z", "2:+Z"]),
        ("two", "2:+Z,3:-X", "1:+Z", vec!["1:+Z", "2:+Z", "3:-X"]),
        (
            "frfs",
            "2:+Z,3:-X",
            "1:+Z",
            vec!["2:+Z", "2:+Z", "3:-X", "3:-X"],
        ),
    ] {
        let file = path(&format!("{scene}.csv"));
        let stated = ["--response", sensors, "--reference", hit];
        succeed(["new", &path(scene), &file].into_iter().chain(stated));
        let wanted: Vec<String> = wanted
            .iter()
            .map(|dof| format!("dof = \"{dof}\""))
            .collect();
        assert_eq!(dof_lines(folder.path(), scene), wanted, "{scene}");
    }
    let error = fail(["new", &path("x"), &path("two.csv"), "--response", "2:+Z"]);
    assert!(
        error.contains("1 DOF for 2 responses of") && error.contains("two.csv"),
        "{error}"
    );
}

#[test]
fn tables_with_frfs_of_one_pair_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    for file in ["a.csv", "b.csv"] {
        write_columns(folder.path(), file, "frequency,real,imaginary");
    }
    for (scene, hits, is_named) in [("same", "1:+Z", true), ("roving", "1:+Z,2:+Z", false)] {
        let files = [path("a.csv"), path("b.csv")];
        let stated = ["--response", "3:+Z", "--reference", hits];
        let arguments = ["new", &path(scene), &files[0], &files[1]];
        let printed = succeed(arguments.into_iter().chain(stated));
        let warning = "2 files have the same response and reference";
        assert_eq!(printed.contains(warning), is_named, "{printed}");
    }
}

#[test]
fn files_without_test_data_are_left_out_and_lost_ones_fail() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write_columns(folder.path(), "a.csv", "frequency,real,imaginary");
    write(
        folder.path(),
        &[
            ("notes.txt", "Plate of 26 November\n"),
            ("cut.csv", "frequency,real,imaginary\n"),
            ("empty.txt", ""),
        ],
    );
    for (file, code) in [("notes.txt", 0), ("cut.csv", 1), ("empty.txt", 1)] {
        let scene = path(&format!("scene-{file}"));
        let output = modalign(["new", &scene, &path("a.csv"), &path(file), "--json"]);
        assert_eq!(output.status.code(), Some(code), "{file}");
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(result["not_used"][0]["path"], path(file), "{result}");
        assert!(Path::new(&scene).join("scene.toml").exists());
        let inspected = modalign(["inspect", &path("a.csv"), &path(file)]);
        assert_eq!(inspected.status.code(), Some(code), "{file}");
    }
}

#[test]
fn a_stated_sensor_is_that_of_the_record_that_names_none() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    succeed([
        "convert",
        &path("hits.uff"),
        "--text",
        "-o",
        &path("text.uff"),
    ]);
    // Node and direction of the response, before those of the hit, of which a force has none.
    let sensor = "NONE               1   3 NONE";
    let unnamed = |line: &str| match line.ends_with("0   0") {
        true => line.to_owned() + "\n",
        false => line.replacen(sensor, "NONE               0   0 NONE", 1) + "\n",
    };
    let text = std::fs::read_to_string(path("text.uff")).unwrap();
    let text: String = text.lines().map(unnamed).collect();
    write(folder.path(), &[("open.uff", &text)]);
    let asked = succeed(["new", &path("asked"), &path("open.uff")]);
    assert!(asked.contains("1 line to be filled in"), "{asked}");
    let printed = succeed([
        "new",
        &path("said"),
        &path("open.uff"),
        "--response",
        "1:+Z",
    ]);
    assert!(printed.contains("nothing is left to fill in"), "{printed}");
    succeed(["frf", &path("said"), "-o", &path("frfs.uff")]);
}

#[test]
fn nothing_is_written_over() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    for name in ["SOURCE.md", "expected.toml", "scene.toml", "raw/hits.uff"] {
        let scene = format!("of-{}", name.replace('/', "-"));
        std::fs::create_dir_all(folder.path().join(&scene).join("raw")).unwrap();
        write(
            folder.path(),
            &[(&format!("{scene}/{name}"), "of an earlier day")],
        );
        let error = fail(["new", &path(&scene), &path("hits.uff"), "--copy"]);
        assert!(
            error.contains(name)
                && error.contains("nothing is written over")
                && error.contains(&format!("modalign new {}-2 ...", path(&scene))),
            "{error}"
        );
        let files = std::fs::read_dir(folder.path().join(&scene))
            .unwrap()
            .count();
        assert_eq!(
            files,
            if name.starts_with("raw") { 1 } else { 2 },
            "nothing came beside {name}"
        );
        assert_eq!(
            std::fs::read(folder.path().join(&scene).join(name)).unwrap(),
            b"of an earlier day"
        );
    }
}

#[test]
fn options_fill_in_what_the_files_do_not_state() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    let head = "Units: Ratio\r\nRef Chan:Resp Chan\t0-Z:0-Z\r\nChannel Name\t : \r\n\r\nFrequency\tReal\tImaginary\r\n\r\nUnits:\r\nHz\t(m/s^2)(N)\t \r\n";
    let rows: String = (0..64)
        .map(|i| format!("{}\t{}\t0.5\r\n", f64::from(i) * 0.5, i % 7))
        .collect();
    write(
        folder.path(),
        &[
            ("a.txt", &format!("{head}{rows}")),
            ("b.txt", &format!("{head}{rows}")),
            (
                "points.csv",
                "point,x,y,z\n1,0.1,0,0\n2,0.2,0,0\n# the sensor\n3,0.3,0,0\n",
            ),
            (
                "model.toml",
                &std::fs::read_to_string(root().join("measurements/free-free-beam/model.toml"))
                    .unwrap(),
            ),
        ],
    );
    let (a, b) = (path("a.txt"), path("b.txt"));
    let asked = succeed(["new", &path("asked"), &a, &b]);
    for key in ["reference", "response"] {
        let line = asked
            .lines()
            .find(|line| line.contains(&format!(": {key}: ")));
        let line = line.unwrap_or_else(|| panic!("{key}: {asked}"));
        assert!(
            line.trim_start().starts_with("lines ") && line.contains(", "),
            "{line}"
        );
        assert!(asked.contains(&format!("--{key} DOF")), "{asked}");
    }
    assert!(asked.contains("in a row (--points FILE with"), "{asked}");
    let (said, model, points) = (path("said"), path("model.toml"), path("points.csv"));
    let stated = [
        "--response",
        "3:-Z",
        "--reference",
        "1:+Z,2:+Z",
        "--band",
        "2:20",
    ];
    let more = ["--points", points.as_str(), "--model", model.as_str()];
    let printed = succeed(["new", &said, &a, &b].into_iter().chain(stated).chain(more));
    assert!(printed.contains("nothing is left to fill in"), "{printed}");
    let scene = std::fs::read_to_string(path("said/scene.toml")).unwrap();
    for wanted in [
        "reference = \"2:+Z\"",
        "at_m = [0.3, 0.0, 0.0]",
        "band_hz = [2.0, 20.0]",
        "body = \"bar\"",
        "file = \"../model.toml\"",
    ] {
        assert!(scene.contains(wanted), "{wanted}: {scene}");
    }
    assert_eq!(scene.matches("[[sensor]]").count(), 3);
    let error = fail(["new", &path("x"), &a, &b, &a, "--reference", "1:+Z,2:+Z"]);
    assert!(error.contains("2 DOFs for 3 files"), "{error}");
    write(folder.path(), &[("points.csv", "1,0.1,0,0\n2,here,0,0\n")]);
    let error = fail(["new", &path("x"), &a, "--points", &points]);
    assert!(
        error.contains("line 2") && !Path::new(&path("x")).exists(),
        "{error}"
    );
}

/// Three hits on one mode of 50 Hz, as columns without units and without a time column.
fn hit_columns(number: usize) -> String {
    let mut text = "force,acceleration\n".to_owned();
    let scale = 1.0 + 0.1 * number as f64;
    for sample in 0..4096 {
        let seconds = (f64::from(sample) - 20.0) / 2000.0;
        let pulse = if (0.0..0.002).contains(&seconds) {
            scale
        } else {
            0.0
        };
        let decay = (-3.0 * seconds).exp() * (314.0 * seconds).sin();
        let noise = 1e-5 * f64::from((sample * 7919 + 13 * number as i32) % 101 - 50);
        let response = if seconds > 0.0 { scale * decay } else { 0.0 };
        text += &format!("{},{}\n", pulse + noise, response + noise);
    }
    text
}

#[test]
fn stated_units_and_sampling_rate_leave_nothing_to_fill_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    let files: Vec<String> = (1..=3)
        .map(|number| path(&format!("{number}.csv")))
        .collect();
    for (number, file) in (1..).zip(&files) {
        std::fs::write(file, hit_columns(number)).unwrap();
    }
    let mut arguments = vec!["new".to_owned(), path("scene")];
    arguments.extend(files);
    let stated = [
        "--sampling-rate",
        "2000",
        "--unit",
        "N,m/s2",
        "--response",
        "2:+Z",
        "--reference",
        "1:+Z",
    ];
    arguments.extend(stated.map(str::to_owned));
    let printed = succeed(&arguments);
    assert!(printed.contains("nothing is left to fill in"), "{printed}");
    let run = succeed(["run", &path("scene"), "--json"]);
    let modes: serde_json::Value = serde_json::from_str(&run).unwrap();
    let found = modes["modes"].as_array().unwrap();
    let near = |mode: &&serde_json::Value| {
        (mode["frequency_hz"].as_f64().unwrap() - 314.0 / std::f64::consts::TAU).abs() < 0.2
    };
    assert!(found.iter().any(|mode| near(&mode)), "{run}");
    let unknown = ["--unit", "furlong"].map(str::to_owned);
    let mut wrong: Vec<String> = arguments[..2].to_vec();
    wrong[1] = path("other");
    wrong.push(arguments[2].clone());
    wrong.extend(unknown);
    assert!(fail(&wrong).contains("got furlong"), "{}", fail(&wrong));
}

/// Two FRFs with coherence and their records, as arrays with the names of a two-channel analyser.
fn analyser_arrays(path: &Path) {
    let mut file = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    let mut add = |name: &str, kind: &str, numbers: usize| {
        let options = zip::write::SimpleFileOptions::default();
        file.start_file(format!("{name}.npy"), options).unwrap();
        let head = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (64, 2), }}");
        let head = format!("{head:<117}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((head.len() as u16).to_le_bytes());
        bytes.extend(head.as_bytes());
        bytes.extend((0..numbers).flat_map(|k| (0.5 * k as f64).to_le_bytes()));
        std::io::Write::write_all(&mut file, &bytes).unwrap();
    };
    for name in ["X1", "X2", "S1_1", "C1_2", "C1_3", "G1_1", "G2_2", "W1"] {
        add(name, "<f8", 128);
    }
    for name in ["S1", "H1_2", "H1_3"] {
        add(name, "<c16", 256);
    }
    file.finish().unwrap();
}

#[test]
fn arrays_that_are_frfs_by_their_names_are_drafted_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("analyser.npz");
    analyser_arrays(&file);
    let scene = at(folder.path(), "scene");
    let arguments = [
        "new",
        &scene,
        file.to_str().unwrap(),
        "--unit",
        "g/N",
        "--reference",
        "1:+Z",
    ];
    let printed = succeed(arguments);
    assert!(printed.contains("4 lines to be filled in"), "{printed}");
    let text = std::fs::read_to_string(folder.path().join("scene/scene.toml")).unwrap();
    for (column, role) in [
        ("H1_2:1", "frequency"),
        ("H1_2:2", "complex"),
        ("C1_2:2", "coherence"),
        ("H1_3:2", "complex"),
        ("C1_3:2", "coherence"),
    ] {
        let wanted = format!("column = \"{column}\"\nrole = \"{role}\"");
        assert!(text.contains(&wanted), "{wanted}: {text}");
    }
    assert_eq!(text.matches("[[test.channel]]").count(), 5);
    // FRFs have no hits: keys of hits mean nothing there.
    assert!(!text.contains("force_window_s"), "{text}");
    assert!(
        text.contains("# Not used below: X1, X2, S1_1, G1_1"),
        "{text}"
    );
}

/// Position of a point of the beam of 0.6 m.
fn position_m(point: u8) -> f64 {
    0.06 * f64::from(point - 1)
}

/// `matrices.toml`, a chain of masses at the points, and `sensors.toml`, the beam with its sensors.
fn write_models_that_need_no_sensors(folder: &Path) {
    let number = |count: usize| (1..=count).map(|i| (i, i, 1.0)).collect::<Vec<_>>();
    let mut springs = number(11);
    springs.iter_mut().for_each(|spring| spring.2 = 2e6);
    springs.extend((2..=11).map(|i| (i, i - 1, -1e6)));
    let dofs: String = (1..=11).map(|i| format!("{i}:+Z\n")).collect();
    let matrices = "schema = \"modalign-model/1\"\ntitle = \"chain\"\n[matrices]\ndofs = \"dofs.txt\"\nmass = \"m.mtx\"\nstiffness = \"k.mtx\"\n";
    let mut beam = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    for point in 1..=11 {
        let x = position_m(point);
        beam += &format!(
            "\n[[sensor]]\ndof = \"{point}:+Z\"\nbody = \"bar\"\nat_m = [{x:.2}, 0.0, 0.0]\n"
        );
    }
    write(
        folder,
        &[
            ("m.mtx", &matrix_market(11, &number(11))),
            ("k.mtx", &matrix_market(11, &springs)),
            ("dofs.txt", &dofs),
            ("matrices.toml", matrices),
            ("sensors.toml", &beam),
        ],
    );
}

#[test]
fn stated_points_are_kept_with_every_model_and_without() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    let lines = (1..=11).map(|point| format!("{point},{:.2},0,0\n", position_m(point)));
    write(folder.path(), &[("points.csv", &lines.collect::<String>())]);
    estimate_and_identify(folder.path());
    write_models_that_need_no_sensors(folder.path());
    for (scene, model) in [
        ("none", None),
        ("finished", Some(path("modes.json"))),
        ("bodies", Some(path("model.toml"))),
        ("built-in", Some("cycloid-ball".to_owned())),
        ("matrices", Some(path("matrices.toml"))),
        ("sensors", Some(path("sensors.toml"))),
    ] {
        let mut arguments = vec!["new".to_owned(), path(scene), path("frfs.h5")];
        arguments.extend(["--points".to_owned(), path("points.csv")]);
        arguments.extend(
            model
                .into_iter()
                .flat_map(|model| ["--model".to_owned(), model]),
        );
        succeed(arguments);
        let text = std::fs::read_to_string(folder.path().join(scene).join("scene.toml")).unwrap();
        let positions = text.lines().filter(|line| line.starts_with("at_m = [0"));
        assert_eq!(positions.count(), 11, "{scene}: {text}");
        if !["bodies", "built-in"].contains(&scene) {
            let out = path(&format!("{scene}/out"));
            succeed(["run", &path(scene), "-o", &out]);
            let report = json(&folder.path().join(scene).join("out/report.json"));
            let points = &report["figures"]["tests"][0]["shapes"]["points"];
            assert_eq!(points.as_array().unwrap().len(), 11, "{scene}");
            for point in points.as_array().unwrap() {
                let name = point["name"].as_str().unwrap().parse().unwrap();
                let x = point["at_m"][0].as_f64().unwrap();
                assert!((x - position_m(name)).abs() < 1e-9, "{scene}: {point}");
            }
        }
    }
}

#[test]
fn files_without_data_of_a_test_are_named_and_left_out() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    write(
        folder.path(),
        &[
            ("notes.txt", "hammer 086C03\nsteel tip\n"),
            ("photo.png", "\u{89}PNG\r\n"),
        ],
    );
    std::fs::copy(path("hits.uff"), path("again.uff")).unwrap();
    let files = ["again.uff", "hits.uff", "notes.txt", "photo.png"].map(path);
    let names_both = |text: &str| {
        let lines = text.lines().filter(|line| line.starts_with("not used: "));
        assert_eq!(lines.count(), 2, "{text}");
    };
    let shown = succeed(
        ["inspect"]
            .into_iter()
            .chain(files.iter().map(String::as_str)),
    );
    names_both(&shown);
    assert!(shown.contains("2 files alike"), "{shown}");
    assert_eq!(shown.matches("Records and functions").count(), 1);
    assert!(
        shown.ends_with("Next: modalign new DIR FILE...\n"),
        "{shown}"
    );
    let scene = path("scene");
    let arguments = ["new", scene.as_str()].into_iter();
    names_both(&succeed(
        arguments.chain(files[1..].iter().map(String::as_str)),
    ));
    let text = std::fs::read_to_string(folder.path().join("scene/scene.toml")).unwrap();
    assert!(
        text.contains("hits.uff\"]") && !text.contains("notes"),
        "{text}"
    );
    // One DOF for each file with data, or for each file.
    for (scene, count) in [("two", 2), ("four", 4)] {
        let dofs: Vec<String> = (1..=count).map(|point| format!("{point}:+Z")).collect();
        let scene = path(scene);
        let arguments = ["new", scene.as_str(), "--reference", &dofs.join(",")].map(str::to_owned);
        succeed(arguments.iter().chain(&files));
    }
    let error = fail(
        ["new", "three", "--reference", "1:+Z,2:+Z,3:+Z"]
            .into_iter()
            .chain(files.iter().map(String::as_str)),
    );
    assert!(
        error.contains("3 DOFs for 2 files with data of a test (4 in all)"),
        "{error}"
    );
    let error = fail(["run", &files[1]]);
    assert!(
        error.contains("expected a folder with scene.toml"),
        "{error}"
    );
    let error = fail(["new", &path("other"), &files[2]]);
    assert!(error.contains("expected rows of numbers"), "{error}");
    assert!(!folder.path().join("other").exists());
}

#[test]
fn a_model_to_complete_is_written_beside_the_scene() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    for kind in ["beam", "lumped"] {
        let scene = path(kind);
        let printed = succeed(["new", &scene, &path("hits.uff"), "--model", kind]);
        assert!(printed.contains("those of an example"), "{printed}");
        let model = path(&format!("{kind}/model.toml"));
        let roots = succeed(["theory", &model, "--json"]);
        assert!(roots.contains("frequency_hz"), "{roots}");
        let text = std::fs::read_to_string(path(&format!("{kind}/scene.toml"))).unwrap();
        assert!(text.contains("file = \"model.toml\""), "{text}");
        // What is there is never written over; the suggested command removes all of it.
        std::fs::remove_file(path(&format!("{kind}/scene.toml"))).unwrap();
        let error = fail(["new", &scene, &path("hits.uff"), "--model", kind]);
        let names = ["SOURCE.md", "expected.toml", "model.toml"];
        let files = names.map(|name| path(&format!("{kind}/{name}")));
        let command = format!("(rm {})", files.join(" "));
        assert!(
            error.contains("which exists") && error.contains(&command),
            "{error}"
        );
        files
            .iter()
            .for_each(|file| std::fs::remove_file(file).unwrap());
        succeed(["new", &scene, &path("hits.uff"), "--model", kind]);
    }
}
