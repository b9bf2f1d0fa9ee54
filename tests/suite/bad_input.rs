//! Bad input: exit 2 with file, line or byte, got and expected, and no output left behind.

use std::path::Path;

use crate::command::{fail, json, modalign, root, succeed, write};

/// A copy of the main scene with its recording made beforehand, so that the file can be damaged.
pub fn recorded_scene(folder: &Path) {
    let source = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
    let spec = text("synth.toml").replace("samples = 32768", "samples = 4096");
    write(
        folder,
        &[("model.toml", &text("model.toml")), ("synth.toml", &spec)],
    );
    let scene = text("scene.toml").replace("synth = \"synth.toml\"", "files = [\"hits.uff\"]");
    write(folder, &[("scene.toml", &scene)]);
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    succeed(["synth", &path("synth.toml"), "-o", &path("hits.uff")]);
}

/// Runs the scene, which must fail, and sees that the output folder does not come to be.
fn fails_without_output(folder: &Path) -> String {
    let out = folder.join("out");
    let error = fail(["run", folder.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    assert!(!out.exists(), "nothing is left behind");
    error
}

#[test]
fn a_truncated_recording_is_placed_by_its_byte_and_its_good_part_can_be_had() {
    let folder = tempfile::tempdir().unwrap();
    recorded_scene(folder.path());
    let file = folder.path().join("hits.uff");
    let bytes = std::fs::read(&file).unwrap();
    let cut = bytes.len() - 5000;
    std::fs::write(&file, &bytes[..cut]).unwrap();
    let error = fails_without_output(folder.path());
    assert!(
        error.contains("hits.uff at byte ")
            && error.contains("got ")
            && error.contains("expected "),
        "{error}"
    );
    let inspected = modalign(["inspect", file.to_str().unwrap(), "--json"]);
    assert_eq!(inspected.status.code(), Some(1));
    let catalog: serde_json::Value = serde_json::from_slice(&inspected.stdout).unwrap();
    assert_eq!(
        catalog["files"][0]["entries"].as_array().unwrap().len(),
        65,
        "11 points x 3 hits x 2 records, less one"
    );
}

#[test]
fn a_partly_bad_recording_runs_on_its_good_part_on_request() {
    let folder = tempfile::tempdir().unwrap();
    recorded_scene(folder.path());
    let file = folder.path().join("hits.uff");
    let bytes = std::fs::read(&file).unwrap();
    // The last hit is lost whole: its force and its response.
    let last = bytes
        .windows(14)
        .rposition(|window| window == b"    -1\n    58b")
        .unwrap();
    let force = bytes[..last]
        .windows(14)
        .rposition(|window| window == b"    -1\n    58b")
        .unwrap();
    std::fs::write(&file, &bytes[..force + 900]).unwrap();
    let out = folder.path().join("out");
    let output = modalign([
        "run",
        folder.path().to_str().unwrap(),
        "--partial",
        "-o",
        out.to_str().unwrap(),
    ]);
    assert_eq!(
        output.status.code(),
        Some(1),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(String::from_utf8_lossy(&output.stderr).contains("bad-dataset"));
    assert_eq!(
        json(&out.join("comparison.json"))["summary"]["tests"][0]["paired"],
        6
    );
}

/// A scene of a table whose columns it describes.
pub const TABLE_SCENE: &str = r#"schema = "modalign-scene/1"
title = "a table"
[[test]]
name = "table"
files = ["hits.csv"]
sampling_rate_hz = 1000
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
"#;

#[test]
fn errors_of_scenes_and_tables_are_reported_with_their_line() {
    let cases = [
        (
            "force,accel\n1,2\n",
            "",
            "",
            "hits.csv:1: got columns force, accel, expected a column \"acceleration\"",
        ),
        (
            "force,acceleration\n1,2\n3,oops\n",
            "",
            "",
            "hits.csv:3: number: got \"oops\", expected a finite number in column 2",
        ),
        (
            "force,acceleration\n1,2\n3\n",
            "",
            "",
            "hits.csv:3: number: got \"1 column\", expected",
        ),
        (
            "force,acceleration\n1,2\n",
            "unit = \"m/s2\"\n",
            "",
            "unit: got nothing, expected a unit of acceleration",
        ),
        (
            "force,acceleration\n1,2\n",
            "sampling_rate_hz",
            "samplng_rate_hz",
            "scene.toml:6:1: got unknown key `samplng_rate_hz`",
        ),
        (
            "force,acceleration\n1,2\n",
            "sampling_rate_hz = 1000\n",
            "",
            "the sampling rate is not stated: expected",
        ),
        (
            "force,acceleration\n1,2\n",
            "unit = \"N\"",
            "unit = \"furlong\"",
            "unit: got \"furlong\", expected",
        ),
        (
            "force,acceleration\n1,2\n",
            "dof = \"1:+Z\"",
            "dof = \"1:+Q\"",
            "scene.toml:10:7: got degree of freedom `1:+Q`, expected a point with a direction",
        ),
        (
            "force,acceleration\n1,2\n",
            "hits.csv",
            "none.csv",
            "none.csv: cannot open",
        ),
    ];
    for (table, from, to, expected) in cases {
        let folder = tempfile::tempdir().unwrap();
        let scene = if from.is_empty() {
            TABLE_SCENE.to_owned()
        } else {
            TABLE_SCENE.replace(from, to)
        };
        write(
            folder.path(),
            &[("scene.toml", &scene), ("hits.csv", table)],
        );
        let error = fails_without_output(folder.path());
        assert!(
            error.contains(expected),
            "expected {expected:?} in\n{error}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[(
            "scene.toml",
            &TABLE_SCENE.replace("sampling_rate_hz", "samplng_rate_hz"),
        )],
    );
    assert!(fails_without_output(folder.path()).contains("did you mean `sampling_rate_hz`?"));
}

#[test]
fn a_model_with_a_misspelt_key_or_unknown_parameter_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        std::fs::read_to_string(root().join("measurements/free-free-beam/model.toml")).unwrap();
    write(
        folder.path(),
        &[("model.toml", &text.replace("area_m2", "aera_m2"))],
    );
    let path = folder.path().join("model.toml");
    let line = text
        .lines()
        .position(|line| line.starts_with("area_m2"))
        .unwrap()
        + 1;
    let error = fail(["theory", path.to_str().unwrap()]);
    assert!(
        error.contains(&format!("model.toml:{line}:1: got unknown key `aera_m2`")),
        "{error}"
    );
    assert!(error.contains("did you mean `area_m2`?"), "{error}");
    let error = fail([
        "theory",
        "measurements/free-free-beam/model.toml",
        "--set",
        "youngs_modulos=2e11",
    ]);
    assert!(
        error.contains("youngs_modulos") && error.contains("youngs_modulus"),
        "{error}"
    );
}

#[test]
fn files_of_unknown_content_and_formats_of_unknown_name_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noise.bin");
    std::fs::write(&path, [0u8, 1, 2, 250, 3]).unwrap();
    let error = fail(["inspect", path.to_str().unwrap()]);
    assert!(
        error.contains("unknown format") && error.contains("uff"),
        "{error}"
    );
    let error = fail(["inspect", path.to_str().unwrap(), "--format", "lvm"]);
    assert!(error.contains("--format lvm"), "{error}");
}

#[test]
fn an_invalid_model_of_bodies_and_springs_is_reported_with_its_file() {
    let text = "[[parameter]]\nname = \"k\"\nunit = \"N/mm\"\nnominal = 100.0\nstatus = \"printed\"\n\
                [[body]]\nname = \"mass\"\nmass_kg = 1.0\nfree = [\"x\"]\n\
                [[point]]\nname = \"end\"\nbody = \"mass\"\nat_m = [0, 0, 0]\n\
                [[spring]]\nname = \"s\"\nfrom = \"end\"\nto = \"ground\"\ndirection = [1, 0, 0]\nparameter = \"k\"\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let error = |from: &str, to: &str| {
        write(
            folder.path(),
            &[("model.toml", &text.replacen(from, to, 1))],
        );
        fail(["theory", path.to_str().unwrap()])
    };
    for (from, to, parts) in [
        ("", "", ["model.toml", "in N/mm", "expected N/m"]),
        ("free", "fre", ["model.toml:9", "fre", "`free`"]),
        (
            "N/mm",
            "N/m\"\nlowest = \"1",
            ["model.toml:4", "lowest", "`lower`"],
        ),
        (
            "from = \"end\"",
            "from = \"endd\"",
            ["model.toml", "`endd`", "did you mean `end`"],
        ),
        (
            "direction = [1, 0, 0]",
            "",
            ["model.toml", "no direction", "ground"],
        ),
    ] {
        let error = error(from, to);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}

#[test]
fn invalid_changes_of_modes_tables_and_claims_are_reported() {
    let source = root().join("measurements/cycloid-ball");
    let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (name, from, to, parts) in [
        (
            "large-cylinder.toml",
            "root = 1\n",
            "root = 99\n",
            ["[[truth.mode]] root 99", "1 to 16"],
        ),
        (
            "large-cylinder.toml",
            "root = 2\n",
            "root = 1\n",
            ["[[truth.mode]] root 1", "each one once"],
        ),
        (
            "scene.toml",
            "tests = [\"virtual, discs\"]",
            "tests = [\"virtual\"]",
            ["[[report.table]]", "virtual"],
        ),
        (
            "scene.toml",
            "name = \"cycloid-ball\" ",
            "name = \"cycloid\" ",
            ["[model] name", "cycloid-ball"],
        ),
        (
            "expected.toml",
            "value = 7.3\n",
            "value = 7.34\n",
            ["7.34", "`decimals`"],
        ),
        (
            "expected.toml",
            "decimals = 1\n",
            "decimals = 70000\n",
            ["decimals", "0 to 15"],
        ),
    ] {
        for file in ["scene.toml", "expected.toml", "large-cylinder.toml"] {
            write(folder.path(), &[(file, &text(file))]);
        }
        assert!(text(name).contains(from), "{from}");
        write(folder.path(), &[(name, &text(name).replacen(from, to, 1))]);
        let error = fails_without_output(folder.path());
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}

/// Three accelerances of one mode at 50 Hz as text; one sample of the second function is no number.
fn functions_with_a_gap(line: i32) -> String {
    let mut text = String::new();
    let natural = std::f64::consts::TAU * 50.0;
    for (point, shape) in [(1, 1.0), (2, 0.7), (3, -0.4)] {
        text += "    -1\n    58\nmade\nNONE\nNONE\nNONE\nNONE\n";
        text += &format!(
            "    4         0    0         0       NONE{point:10}   3       NONE         1   3\n"
        );
        text += "         6       400         1  0.00000e+00  2.50000e-01  0.00000e+00\n";
        text += "        18    0    0    0 NONE                 NONE                \n";
        text += "        12    0    0    0 NONE                 m/s^2               \n";
        text += "        13    0    0    0 NONE                 N                   \n";
        text += "         0    0    0    0 NONE                 NONE                \n";
        for pair in 0..200 {
            for k in [2 * pair, 2 * pair + 1] {
                let hz = 0.25 * f64::from(k);
                let omega = std::f64::consts::TAU * hz;
                let (a, b) = (natural * natural - omega * omega, 0.02 * natural * omega);
                let scale = -omega * omega * shape / (a * a + b * b);
                let (re, im) = (scale * a, -scale * b);
                let gap = point == 2 && k == line;
                text += &if gap {
                    format!("{:>20}{im:20.11e}", "NaN")
                } else {
                    format!("{re:20.11e}{im:20.11e}")
                };
            }
            text.push('\n');
        }
        text += "    -1\n";
    }
    text
}

#[test]
fn a_function_with_a_gap_in_the_band_is_left_out_where_the_good_part_will_do() {
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[
            ("gap.uff", &functions_with_a_gap(4 * 48)),
            ("below.uff", &functions_with_a_gap(4 * 10)),
        ],
    );
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (gap, below, out) = (path("gap.uff"), path("below.uff"), path("modes.json"));
    let band = ["--band", "30:70", "-o", &out];
    let identify = |first: &[&str]| modalign([first, &band].concat());
    let whole = identify(&["identify", &gap]);
    assert_eq!(whole.status.code(), Some(2));
    let error = String::from_utf8_lossy(&whole.stderr).into_owned();
    assert!(error.contains("2:+Z|1:+Z at 48 Hz: got NaN"), "{error}");
    assert!(!Path::new(&out).exists());

    let partial = identify(&["identify", &gap, "--partial"]);
    let said = String::from_utf8_lossy(&partial.stderr).into_owned();
    assert_eq!(partial.status.code(), Some(1), "{said}");
    let expected = "2:+Z|1:+Z: A function has a value or a variance in the band that is no finite number. \
        It was left out (48 Hz)";
    assert!(said.contains(expected), "{said}");
    let modes = json(Path::new(&out));
    assert_eq!(modes["modes"].as_array().unwrap().len(), 1);
    let hz = modes["modes"][0]["frequency_hz"].as_f64().unwrap();
    assert!((hz - 50.0).abs() < 1e-3, "{hz}");

    // A chain says it as well.
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"a gap\"\n[[test]]\nname = \"gap\"\nfiles = [\"gap.uff\"]\n\
        band_hz = [30.0, 70.0]\n";
    write(folder.path(), &[("scene.toml", scene)]);
    let run = modalign(["run", &path("."), "--partial", "-o", &path("out")]);
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(1), "{said}");
    assert!(said.contains(expected), "{said}");

    // Values outside the band may be bad.
    let outside = identify(&["identify", &below]);
    assert_eq!(outside.status.code(), Some(0));
}

#[test]
fn a_scene_without_a_test_has_no_recordings_to_convert() {
    let folder = tempfile::tempdir().unwrap();
    let model = root().join("measurements/free-free-beam/model.toml");
    let scene =
        "schema = \"modalign-scene/1\"\ntitle = \"A model\"\n[model]\nfile = \"model.toml\"\n";
    let model = std::fs::read_to_string(model).unwrap();
    write(
        folder.path(),
        &[("model.toml", &model), ("scene.toml", scene)],
    );
    let path = folder.path().to_str().unwrap();
    let out = folder.path().join("out.uff");
    for verb in ["frf", "convert"] {
        let error = fail([verb, path, "-o", out.to_str().unwrap()]);
        assert!(
            error.contains("a scene whose first test has `files`"),
            "{error}"
        );
        assert!(!out.exists());
    }
}

#[test]
fn undeclared_parameters_are_reported_with_other_faults_at_their_keys() {
    let model = "schema = \"modalign-model/1\"\nkind = \"beam\"\ntitle = \"b\"\n\
        [[beam]]\nname = \"bar\"\nfrom_m = [0, 0, 0]\nto_m = [1, 0, 0]\ndeflection = [0, 0, 1]\n\
        elements = 4\nstart = \"fre\"\nend = \"free\"\nyoungs_modulus_pa = \"youngs\"\n\
        density_kg_per_m3 = 7850\narea_m2 = -1\nsecond_moment_m4 = \"inertia\"\n\
        [[point_mass]]\nname = \"head\"\nbeam = \"bar\"\nat_m = [0.5, 0, 0]\nmass_kg = \"mass\"\n";
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("model.toml", model)]);
    let path = folder.path().join("model.toml");
    let error = fail(["theory", path.to_str().unwrap()]);
    assert!(error.contains("5 faults"), "{error}");
    for part in [
        "model.toml:10:9: got `fre`",
        "model.toml:12:21: beam `bar`: got parameter `youngs`",
        "model.toml:14:11: beam `bar`: got area_m2 -1",
        "model.toml:15:20: beam `bar`: got parameter `inertia`",
        "model.toml:20:11: point mass `head`: got parameter `mass`",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    // A parameter whose name has a fault may be any of them.
    let unnamed = model.replace("\"fre\"", "\"free\"")
        + "[[parameter]]\nnam = \"youngs\"\nunit = \"Pa\"\nnominal = 1e11\nstatus = \"assumed\"\n";
    write(folder.path(), &[("model.toml", &unnamed)]);
    let error = fail(["theory", path.to_str().unwrap()]);
    assert!(error.contains("got unknown key `nam`"), "{error}");
    assert!(!error.contains("got parameter `youngs`"), "{error}");
}

#[test]
fn all_options_of_pairing_and_all_matrices_with_faults_are_reported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nfile = \"model.toml\"\n\
        [[test]]\nname = \"a\"\nmodes = \"modes.csv\"\n\
        [pair]\nmin_mac = 95\nmax_frequency_error = -1\nambiguous_margin = 3\n\
        [update]\nparameters = [\"wal\"]\nalways = [\"wall\"]\nfrf_lines = 3\n";
    let model = "kind = \"matrices\"\n[matrices]\ndofs = [\"1:+X\", \"2:+X\"]\nmass = \"m.mtx\"\n\
        stiffness = \"k.mtx\"\n[[matrices.group]]\nparameter = \"wall\"\n\
        [[matrices.group]]\nparameter = \"floor\"\nstiffness = \"large.mtx\"\n";
    let large = "%%MatrixMarket matrix coordinate real symmetric\n3 3 1\n1 1 5\n";
    write(
        folder.path(),
        &[
            ("scene.toml", scene),
            ("model.toml", model),
            ("large.mtx", large),
            ("modes.csv", "frequency_hz\n10\n"),
        ],
    );
    let error = fails_without_output(folder.path());
    for part in [
        "9 faults",
        "scene.toml:9:11: [pair] min_mac: got 95",
        "scene.toml:10:23: [pair] max_frequency_error: got -1",
        "scene.toml:11:20: [pair] ambiguous_margin: got 3",
        "[update] always: got wall",
        "[update] frf_lines: got 3",
        "m.mtx: cannot open",
        "k.mtx: cannot open",
        "[[matrices.group]] 1 (wall): got no matrix",
        "[[matrices.group]] 2 (floor) stiffness: got 3 x 3",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn all_faults_of_published_results_are_reported_with_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nname = \"cycloid-ball\"\n";
    let expected = "schema = \"modalign-expected/2\"\nmax_frequency_error = -1\n\
        [source]\nauthors = \"a\"\npaper = \"p\"\nyear = 2000\n\
        [[root]]\nlabel = \"f1\"\nfrequency_hz = -3\n\
        [[root]]\nlabel = \"f2\"\n\
        [[root]]\nlabel = \"f3\"\nomega_rad_s = 3\nmultiplicity = 0\n\
        [[claim]]\ntext = \"a claim\"\nkind = \"frequency-hz\"\nrow = \"f9\"\nvalue = 3.0\n\
        [[claim]]\ntext = \"another\"\nkind = \"guess\"\n";
    write(
        folder.path(),
        &[("scene.toml", scene), ("expected.toml", expected)],
    );
    let error = fails_without_output(folder.path());
    for part in [
        "7 faults",
        "expected.toml:1:10: schema: got",
        "expected.toml:2:23: max_frequency_error: got -1",
        "expected.toml:9:16: [[root]] \"f1\" frequency_hz: got -3",
        "expected.toml:10:1: [[root]] \"f2\": got none or both",
        "expected.toml:15:16: [[root]] \"f3\" multiplicity: got 0",
        "expected.toml:19:7: [[claim]] \"a claim\" row: got \"f9\"",
        "expected.toml:23:8: [[claim]] \"another\" kind: got \"guess\"",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn sensors_on_unknown_bodies_are_reported_with_an_unknown_key_of_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam/model.toml");
    let model = std::fs::read_to_string(beam).unwrap();
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nfile = \"model.toml\"\n\
        [[sensor]]\ndof = \"1:+Z\"\nbody = \"baar\"\nat_m = [0, 0, 0]\n";
    for (key, wrong, is_reported) in [
        ("area_m2", "aera_m2", true),
        // The name or the list of the body itself may be misspelt.
        ("name = \"bar\"", "nmae = \"bar\"", false),
        ("[[beam]]", "[[baem]]", false),
    ] {
        let model = model.replace(key, wrong);
        write(
            folder.path(),
            &[("model.toml", &model), ("scene.toml", scene)],
        );
        let error = fail(["run", folder.path().to_str().unwrap()]);
        assert!(error.contains("got unknown key"), "{error}");
        assert_eq!(error.contains("got body `baar`"), is_reported, "{error}");
    }
}

#[test]
fn run_and_update_name_every_sensor_beside_its_beam() {
    let folder = tempfile::tempdir().unwrap();
    let source = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
    let scene = text("scene.toml")
        .replace("at_m = [0.06, ", "at_m = [0.7, ")
        .replace("at_m = [0.12, ", "at_m = [-0.1, ");
    write(
        folder.path(),
        &[
            ("model.toml", &text("model.toml")),
            ("synth.toml", &text("synth.toml")),
            ("scene.toml", &scene),
        ],
    );
    for verb in ["run", "update"] {
        let error = fail([verb, folder.path().to_str().unwrap()]);
        for part in [
            "2 faults",
            "[[sensor]] 2:+Z",
            "[[sensor]] 3:+Z",
            "scene.toml:5",
        ] {
            assert!(error.contains(part), "{verb}: {part} is missing in {error}");
        }
    }
}
