//! First steps of a new user: models by name, lists of frequencies, folders in the place of files,
//! and the next step that a screen advises.

use std::path::Path;

use crate::command::{modalign_in, root, write};

/// Standard output and error of the program in a folder, and its exit code.
pub fn said(folder: &Path, line: &str) -> (String, String, Option<i32>) {
    let output = modalign_in(folder, line.split_whitespace());
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        text(output.stdout),
        text(output.stderr),
        output.status.code(),
    )
}

pub fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Bending modes of a free beam of 1 m at five points, in one direction.
pub fn beam_modes(axis: &str) -> String {
    let points = ["1", "2", "3", "4", "5"];
    let heads: Vec<String> = points
        .iter()
        .map(|point| format!("{point}:+{axis}"))
        .collect();
    format!(
        "frequency_hz,damping_ratio,{}\n\
         53.1,0.004,2.0,-0.2,-1.2,-0.2,2.0\n\
         146.3,0.004,2.0,-1.2,0.0,1.2,-2.0\n\
         286.9,0.004,2.0,-1.0,1.4,-1.0,2.0\n",
        heads.join(",")
    )
}

/// Positions of the points on a line along z.
pub const POINTS: &str = "point,x,y,z\n1,0,0,0\n2,0,0,0.25\n3,0,0,0.5\n4,0,0,0.75\n5,0,0,1\n";

#[test]
fn a_draft_is_asked_for_by_its_word_and_its_values_are_said_to_be_an_example() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for kind in ["beam", "lumped"] {
        std::fs::create_dir(folder.join(kind)).unwrap();
    }
    let modes = beam_modes("Z");
    write(folder, &[("modes.csv", &modes), ("lumped/scene.toml", "")]);
    for (scene, kind) in [("beam", "beam"), ("other", "lumped")] {
        let (screen, findings, code) =
            said(folder, &format!("new {scene} modes.csv --model {kind}"));
        assert_eq!(code, Some(0), "{findings}");
        assert!(screen.contains("those of an example"), "{screen}");
        assert!(!findings.contains("[built-in-taken]"), "{findings}");
        assert!(read(folder, &format!("{scene}/scene.toml")).contains("file = \"model.toml\""));
        assert!(folder.join(scene).join("model.toml").is_file());
    }
    let (_, error, code) = said(folder, "new third modes.csv --model ./beam");
    assert_eq!(code, Some(2));
    assert!(!error.contains("os error"), "{error}");
    // A built-in name as the theory of a comparison, beside FRFs of that name.
    write(
        folder,
        &[(
            "cycloid-ball",
            "frequency [Hz],re 1:+Z|2:+Z [(m/s2)/N],im 1:+Z|2:+Z [(m/s2)/N]\n1,2,3\n2,3,4\n",
        )],
    );
    let (_, error, _) = said(folder, "correlate --test modes.csv --theory cycloid-ball");
    assert!(error.contains("[built-in-taken]"), "{error}");
}

#[test]
fn a_beam_is_drafted_along_the_points_and_pairs_with_its_test() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        &[("modes.csv", &beam_modes("X")), ("points.csv", POINTS)],
    );
    let (screen, error, code) = said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    assert_eq!(code, Some(0), "{error}");
    assert!(screen.contains("its length of 1 m is a guess"), "{screen}");
    let model = read(folder, "bar/model.toml");
    for line in ["to_m = [0.0, 0.0, 1.0]", "deflection = [1.0, 0.0, 0.0]"] {
        assert!(model.contains(line), "{model}");
    }
    assert!(model.contains("\nexample_values = true  "), "{model}");
    write(folder, &[("bar/model.toml", &stated_values(&model))]);
    let (screen, findings, code) = said(folder, "run bar");
    assert_eq!(code, Some(0), "{findings}");
    assert!(
        screen.contains("Pairs: 3 of 3 model modes, 3 by shape"),
        "{screen}"
    );
    assert!(screen.contains("modalign update bar"), "{screen}");
}

/// A drafted model of which a user says that the values are those of the structure.
pub fn stated_values(model: &str) -> String {
    let lines = model.lines();
    let lines = lines.filter(|line| !line.starts_with("example_values"));
    let stated: String = lines.map(|line| line.to_owned() + "\n").collect();
    // An update solves the model some hundred times, and time goes with the cube.
    stated.replace("elements = 60", "elements = 30")
}

#[test]
fn sensors_that_the_model_cannot_move_are_said_before_an_update() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        &[("modes.csv", &beam_modes("X")), ("points.csv", POINTS)],
    );
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    let model = stated_values(&read(folder, "bar/model.toml"));
    let model = model.replace(
        "deflection = [1.0, 0.0, 0.0]",
        "deflection = [0.0, 1.0, 0.0]",
    );
    write(folder, &[("bar/model.toml", &model)]);
    let (screen, findings, _) = said(folder, "run bar");
    assert!(screen.contains("Pairs: 0 of 3"), "{screen}");
    assert!(!screen.contains("modalign update"), "{screen}");
    assert!(
        screen.contains("Next, as no mode is paired: the model does not move at"),
        "{screen}"
    );
    assert!(findings.contains("[sensor-unmoved]"), "{findings}");
    let (_, error, code) = said(folder, "update bar");
    assert_eq!(code, Some(2));
    assert!(
        error.contains("the model does not move") && error.contains("1:+X"),
        "{error}"
    );
    // Frequencies without shapes, far from those of the model.
    write(folder, &[("bar/far.csv", "frequency_hz\n3100.5\n9000.5\n")]);
    let scene = read(folder, "bar/scene.toml").replace("../modes.csv", "far.csv");
    let scene = scene.replace("[model]", "[pair]\nmax_frequency_error = 0.01\n[model]");
    let model = model.replace(
        "deflection = [0.0, 1.0, 0.0]",
        "deflection = [1.0, 0.0, 0.0]",
    );
    let model = model.replace("elements = 30", "elements = 2");
    write(
        folder,
        &[("bar/scene.toml", &scene), ("bar/model.toml", &model)],
    );
    let (_, error, code) = said(folder, "update bar");
    assert_eq!(code, Some(2), "{error}");
    assert!(
        error.contains("pairs with a mode of the model") && !error.contains("gates"),
        "{error}"
    );
}

#[test]
fn sensors_and_points_of_one_position_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let points = POINTS
        .replace("0,0,0.5", "0,0,0.25")
        .replace("0,0,0.75", "0,0,0.25");
    write(
        folder,
        &[("modes.csv", &beam_modes("X")), ("points.csv", &points)],
    );
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    let (_, findings, _) = said(folder, "run bar --full");
    let expected =
        "(3); 2:+X, 3:+X, 4:+X: body \"beam\", at_m = [0, 0, 0.25] [sensors-at-one-position]";
    assert!(findings.contains(expected), "{findings}");
    said(folder, "new alone modes.csv --points points.csv");
    let (_, findings, _) = said(folder, "run alone --full");
    assert!(
        findings.contains("points 2, 3, 4: at_m = [0, 0, 0.25]"),
        "{findings}"
    );
}

#[test]
fn a_list_of_frequencies_is_a_model_and_other_columns_are_refused_in_the_draft() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &[("modes.csv", &beam_modes("Z"))]);
    let lists = [
        "frequency_hz\n53\n146.5\n",
        "53\n146.5\n",
        "f_hz\n53\n146.5\n",
        "f (Hz)\n53\n146,5\n",
        "Mode,frequency_hz\nf1,53\nf2,146.5\n",
        "#;f [Hz]\n1;53\n2;146,5\n",
        "frequency [Hz]\n53\n146.5\n",
        "frequency_hz,frequency_std_hz\n53,0.1\n146.5,0.1\n",
    ];
    for (number, list) in lists.iter().enumerate() {
        let (name, scene) = (format!("list{number}.csv"), format!("scene{number}"));
        write(folder, &[(name.as_str(), list)]);
        let (_, error, code) = said(folder, &format!("new {scene} modes.csv --model {name}"));
        assert_eq!(code, Some(0), "{list}: {error}");
        let (screen, findings, code) = said(folder, &format!("run {scene}"));
        assert_eq!(code, Some(0), "{list}: {findings}");
        assert!(screen.contains("Pairs: 2 of 2"), "{list}: {screen}");
    }
    for list in [
        "mode,f\n1,53\n2,146.5\n",
        "frequency_hz,1:+Z\n53,1\n146.5,1\n",
        "speed\nslow\n",
    ] {
        write(folder, &[("wrong.csv", list)]);
        let (_, error, code) = said(folder, "new wrong modes.csv --model wrong.csv");
        assert_eq!(code, Some(2), "{list}");
        assert!(!error.contains("modalign new"), "{error}");
        assert!(!folder.join("wrong").exists());
    }
    write(
        folder,
        &[("wrong.csv", "frequency_hz,1:+Z\n53,1\n146.5,1\n")],
    );
    let (_, error, _) = said(folder, "new wrong modes.csv --model wrong.csv");
    assert!(
        error.contains("cells of `damping_ratio` may be empty"),
        "{error}"
    );
}

#[test]
fn a_folder_or_a_scene_in_the_place_of_a_file_has_a_hint() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &[("modes.csv", &beam_modes("Z"))]);
    said(folder, "new bar modes.csv");
    std::fs::create_dir(folder.join("empty")).unwrap();
    for (line, hint) in [
        ("identify bar", "`modalign run bar`"),
        ("identify bar/scene.toml", "is a scene or a model"),
        ("inspect bar", "`modalign run bar`"),
        ("inspect empty", "name the files in it"),
        ("inspect bar/scene.toml", "is a scene or a model"),
        ("new other empty", "name the files in it"),
        ("run empty", "`modalign new DIR FILE...`"),
        ("theory empty", "`modalign new DIR FILE...`"),
        ("theory beam", "--model beam"),
        ("report empty", "`modalign run SCENE -o DIR` makes one"),
        ("report bar", "`modalign run bar -o bar/out` makes one"),
        (
            "report nowhere",
            "`modalign run SCENE -o nowhere` makes a report",
        ),
        ("check bar", "modalign run bar -o DIR"),
        ("check bar/scene.toml", "--against bar/scene.toml"),
        (
            "check modes.json",
            "modalign check modes.json --against SCENE",
        ),
    ] {
        let (_, error, code) = said(folder, line);
        assert_eq!(code, Some(2), "{line}");
        assert!(
            error.contains(hint) && !error.contains("os error"),
            "{line}: {error}"
        );
    }
    // Time records of unknown meaning.
    write(
        folder,
        &[(
            "hit.csv",
            "time,force,acceleration\n0,1,2\n0.1,2,3\n0.2,2,1\n",
        )],
    );
    let (_, error, _) = said(folder, "frf hit.csv");
    for said in [
        "the column of the force",
        "sampling rate",
        "modalign new DIR FILE...",
    ] {
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn limits_are_named_by_kind_and_asked_for_where_there_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        &[
            ("modes.csv", &beam_modes("Z")),
            ("list.csv", "f_hz\n53\n146.5\n286\n"),
        ],
    );
    said(folder, "new bar modes.csv --model list.csv");
    let (_, error, _) = said(folder, "run bar -o out");
    assert_eq!(error, "", "{error}");
    for result in ["out", "out/comparison.json"] {
        let (_, error, code) = said(folder, &format!("check {result}"));
        assert_eq!(code, Some(2));
        let baseline = "`modalign check out/comparison.json --against EARLIER.json`";
        assert!(error.contains(baseline), "{error}");
        assert!(error.contains("in bar/scene.toml"), "{error}");
        assert!(!error.contains("--against bar"), "{error}");
    }
    let (_, error, code) = said(folder, "check out/comparison.json --against bar");
    assert_eq!(code, Some(2));
    assert!(
        error.contains("bar/scene.toml: [limits]: got a table that is commented out"),
        "{error}"
    );
    let scene = read(folder, "bar/scene.toml");
    write(
        folder,
        &[(
            "bar/scene.toml",
            &scene.replace("# [limits]", "[limits]\nmax_extra = 0"),
        )],
    );
    let (screen, _, _) = said(folder, "run bar");
    assert!(
        screen.contains(
            "Limits of the scene: 1 of 1 met, on unmatched test modes; none is on errors or MAC."
        ),
        "{screen}"
    );
    let (screen, _, code) = said(folder, "check out/comparison.json --against bar");
    assert_eq!(code, Some(0));
    assert!(
        screen.contains("1 of 1 row met, 1 check in all: unmatched test modes."),
        "{screen}"
    );
}

#[test]
fn a_model_without_sensors_is_named_where_no_mac_exists() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        &[("modes.csv", &beam_modes("Z")), ("points.csv", POINTS)],
    );
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    let (_, findings, code) = said(folder, "correlate --test modes.csv --theory bar/model.toml");
    assert_eq!(code, Some(0), "{findings}");
    assert!(findings.contains("[model-without-sensors]"), "{findings}");
    let (_, findings, _) = said(folder, "correlate --test modes.csv --theory bar");
    assert!(!findings.contains("[model-without-sensors]"), "{findings}");
}

/// Asserts that an error names a number of faults and has all these parts.
pub fn assert_faults(error: &str, count: usize, parts: &[&str]) {
    assert!(
        error.contains(&format!("{count} faults")),
        "{count}: {error}"
    );
    for part in parts {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn all_faults_of_a_scene_and_its_files_are_named_in_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let model = "schema = \"modalign-model/1\"\ntitle = \"m\"\n\
        [[body]]\nname = \"a\"\nat_m = [0, 0, 0]\nmass_kg = -1\nfree = [\"z\"]\n\
        [[body]]\nname = \"b\"\nat_m = [0, 0, 1]\nmass_kg = -2\nfree = [\"z\"]\n\
        [[point]]\nname = \"p\"\nbody = \"c\"\nat_m = [0, 0, 0]\n\
        [[spring]]\nname = \"s\"\nfrom = \"p\"\nto = \"q\"\ndirection = [0, 0, 1]\nstiffness_n_per_m = -5\n";
    write(folder, &[("model.toml", model)]);
    let (_, error, code) = said(folder, "theory model.toml");
    assert_eq!(code, Some(2));
    let of_model = [
        "model.toml:6:11: body `a`: got mass_kg -1",
        "model.toml:11:11: body `b`: got mass_kg -2",
        "point `p`: got body `c`",
        "spring `s`: got point `q`",
        "model.toml:22:21: spring `s`: got stiffness_n_per_m -5",
    ];
    assert_faults(&error, 5, &of_model);
    let synth = "schema = \"modalign-synth/1\"\ntitle = \"s\"\nseed = 1\naverages = 0\nhit = []\n\
        [truth]\nname = \"cycloid-ball\"\ndamping_ratio = -0.1\n\
        [record]\nsampling_rate_hz = -1\nsamples = 1\npretrigger_s = 0.1\nresponse = \"sound\"\n\
        [pulse]\nduration_s = 0.001\npeak_n = 100\n";
    let scene = "title = \"t\"\n[model]\nfile = \"model.toml\"\n\
        [[test]]\nname = \"a\"\nfiles = [\"one.uff\", \"two.uff\"]\nband_hz = [200, 100]\n\
        [[test]]\nname = \"b\"\nsynth = \"synth.toml\"\ncolour = \"red\"\n\
        [pair]\nmin_mac = 95\n\
        [limits]\nmax_frequency_error_percent = -5\nmin_mac = 95\n";
    write(folder, &[("scene.toml", scene), ("synth.toml", synth)]);
    let (_, error, code) = said(folder, "run scene.toml");
    assert_eq!(code, Some(2));
    let mut parts = vec![
        "scene.toml:1:1: got no key `schema`",
        "scene.toml:7:11: [[test]] \"a\" band_hz",
        "scene.toml:11:1: got unknown key `colour`",
        "scene.toml:13:11: [pair] min_mac: got 95",
        "scene.toml:15:31: [limits] max_frequency_error_percent: got -5",
        "scene.toml:16:11: [limits] min_mac: got 95",
        "one.uff: cannot open: there is no such file",
        "two.uff: cannot open: there is no such file",
        "synth.toml:4:12: averages: got 0",
        "synth.toml:10:20: [record] sampling_rate_hz: got -1",
        "synth.toml:11:11: [record] samples: got 1",
        "synth.toml:13:12: [record] response: got \"sound\"",
        "synth.toml:8:17: [truth] damping_ratio: got -0.1",
    ];
    parts.extend(of_model);
    assert_faults(&error, 18, &parts);
    // Without a fault of the scene those of its files alone.
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nfile = \"model.toml\"\n\
        [[test]]\nname = \"a\"\nfiles = [\"one.uff\", \"two.uff\"]\n\
        [[test]]\nname = \"b\"\nmodes = \"three.csv\"\n";
    write(folder, &[("scene.toml", scene)]);
    let (_, error, _) = said(folder, "run scene.toml");
    assert_faults(&error, 8, &["one.uff", "two.uff", "three.csv"]);
}

#[test]
fn faults_of_a_table_are_named_with_those_of_its_scene() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let rows = "t,F,a\n0,1,2\n1,2,3\n2,1,1\n";
    let scene = "schema = \"modalign-scene/2\"\ntitle = \"t\"\n[[test]]\nname = \"a\"\n\
        files = [\"hit.csv\"]\nsampling_rate_hz = -5\n\
        [[test.channel]]\ncolumn = \"F\"\nrole = \"force\"\nunit = \"kN/s\"\ndof = \"1:+Z\"\n\
        [[test.channel]]\ncolumn = \"a\"\nrole = \"response\"\nunit = \"furlong\"\n\
        [frf]\nestimatr = \"h1\"\nexcitation = \"kick\"\n";
    write(folder, &[("hit.csv", rows), ("scene.toml", scene)]);
    let (_, error, _) = said(folder, "run scene.toml");
    let parts = [
        "scene.toml:1:10: schema: got \"modalign-scene/2\"",
        "scene.toml:6:20: [[test]] \"a\" sampling_rate_hz: got -5",
        "scene.toml:10:8: [[test.channel]] \"F\" of \"a\", unit",
        "scene.toml:15:8: [[test.channel]] \"a\" of \"a\", unit",
        "scene.toml:17:1: got unknown key `estimatr`",
        "scene.toml:18:14: [frf] excitation: got \"kick\"",
    ];
    assert_faults(&error, 6, &parts);
    // A faulty DOF and an unknown column.
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"a\"\n\
        files = [\"hit.csv\"]\nsampling_rate_hz = 5\n\
        [[test.channel]]\ncolumn = \"force\"\nrole = \"force\"\nunit = \"N\"\ndof = \"1:+Z\"\n\
        [[test.channel]]\ncolumn = \"a\"\nrole = \"response\"\nunit = \"g\"\ndof = \"1;Z\"\n";
    write(folder, &[("scene.toml", scene)]);
    let (_, error, _) = said(folder, "run scene.toml");
    assert_faults(
        &error,
        2,
        &["scene.toml:16:7: ", "expected a column \"force\""],
    );
}

#[test]
fn a_missing_key_of_a_channel_is_named_with_its_test_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let row = |k: i32| {
        let seconds = f64::from(k - 20) / 1000.0;
        let force = if (20..23).contains(&k) { 10.0 } else { 0.0 };
        let decay = (-6.0 * seconds).exp() * (314.0 * seconds).sin();
        format!("{force},{}\n", if k > 20 { decay } else { 0.0 })
    };
    let rows: String = (0..2048).map(row).collect();
    let table = |force: &str, response: &str| {
        format!(
            "[[test.channel]]\ncolumn = 1\nrole = \"force\"\n{force}\n\
             [[test.channel]]\ncolumn = 2\nrole = \"response\"\n{response}\n"
        )
    };
    let test = |name: &str, key: &str, channels: &str| {
        format!("[[test]]\nname = \"{name}\"\nfiles = [\"hit.csv\"]\n{key}\n{channels}")
    };
    let (force, response) = (
        "unit = \"N\"\ndof = \"1:+Z\"",
        "unit = \"g\"\ndof = \"2:+Z\"",
    );
    let (rate, whole) = ("sampling_rate_hz = 1000", table(force, response));
    let head = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n";
    write(folder, &[("hit.csv", &format!("F,a\n{rows}"))]);
    let said_of = |tests: &str| {
        write(folder, &[("scene.toml", &format!("{head}{tests}"))]);
        said(folder, "run scene.toml").1
    };
    for (key, channels, line, wanted) in [
        ("", whole.clone(), 3, "sampling_rate_hz in [[test]]"),
        (
            rate,
            table("unit = \"N\"", response),
            7,
            "`dof` of the force in [[test.channel]]",
        ),
        (
            rate,
            table(force, "unit = \"g\""),
            12,
            "`dof` in [[test.channel]]",
        ),
    ] {
        let error = said_of(&test("a", key, &channels));
        let place = format!("scene.toml:{line}:1: test \"a\": ");
        assert!(error.contains(&place) && error.contains(wanted), "{error}");
        for wrong in ["drafts one", "--reference"] {
            assert!(!error.contains(wrong), "the scene exists: {error}");
        }
    }
    // Of several tests each, in one run.
    let tests = [
        test("a", rate, &whole),
        test("b", rate, &table("dof = \"1:+Z\"", response)),
        test(
            "c",
            rate,
            &table(force, "unit = \"furlong\"\ndof = \"2:+Z\""),
        ),
    ];
    let parts = [
        "scene.toml:21:1: [[test.channel]] 1 of \"b\", unit: got nothing",
        "scene.toml:42:8: [[test.channel]] 2 of \"c\", unit: got \"furlong\"",
    ];
    assert_faults(&said_of(&tests.concat()), 2, &parts);
}

#[test]
fn faults_of_one_cause_are_one_line_with_their_number_and_first_lines() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let head = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nfile = \"model.toml\"\n";
    let sensor = |point: usize| {
        format!("[[sensor]]\ndof = \"{point}:+Y\"\nbody = \"Beam\"\nat_m = [0, 0, 0.{point}]\n")
    };
    let sensors: String = (1..=9).map(sensor).collect();
    let model = read(&root().join("measurements/free-free-beam"), "model.toml");
    let scene = format!("{head}{sensors}");
    write(folder, &[("scene.toml", &scene), ("model.toml", &model)]);
    let error = said(folder, "run scene.toml").1;
    assert!(error.contains("9 faults"), "{error}");
    assert_eq!(error.matches("got body `Beam`").count(), 1, "{error}");
    assert!(error.contains("(and 8 more like it: lines "), "{error}");
    // Also while the model has a fault.
    let faulty = model
        + "\n[[point_mass]]\nname = \"lump\"\nbeam = \"bar\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = -1.0\n";
    write(folder, &[("model.toml", &faulty)]);
    let error = said(folder, "run scene.toml").1;
    for wanted in [
        "10 faults",
        "lump",
        "got body `Beam`",
        "(and 8 more like it: lines ",
    ] {
        assert!(error.contains(wanted), "{wanted}: {error}");
    }
    // Files of a misspelt folder, with the folder that exists.
    std::fs::create_dir(folder.join("raw")).unwrap();
    let files: Vec<String> = (1..=5).map(|k| format!("\"rwa/{k}.uff\"")).collect();
    let files = files.join(", ");
    let scene = format!(
        "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"a\"\nfiles = [{files}]\n"
    );
    write(folder, &[("scene.toml", &scene)]);
    let error = said(folder, "run scene.toml").1;
    assert_eq!(error.matches("there is no such file").count(), 1, "{error}");
    for wanted in [
        "5 faults",
        "(and 4 more like it)",
        "did you mean `raw/1.uff`",
    ] {
        assert!(error.contains(wanted), "{wanted}: {error}");
    }
}

#[test]
fn a_band_without_excitation_is_named_by_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let beam = root().join("measurements/free-free-beam");
    let scene = read(&beam, "scene.toml").replace("[60.0, 3200.0]", "[40000.0, 50000.0]");
    let (model, synth) = (read(&beam, "model.toml"), read(&beam, "synth.toml"));
    let files = [
        ("scene.toml", scene.as_str()),
        ("model.toml", &model),
        ("synth.toml", &synth),
    ];
    write(folder, &files);
    let error = said(folder, "run scene.toml").1;
    for wanted in [
        "roving hammer",
        "`band_hz`",
        "40000 to 50000 Hz",
        "expected one with lines",
    ] {
        assert!(error.contains(wanted), "{wanted}: {error}");
    }
}

#[test]
fn inspect_counts_records_and_says_what_takes_modes_and_channels_further() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &[("modes.csv", &beam_modes("Y"))]);
    let (screen, ..) = said(folder, "inspect modes.csv");
    assert!(
        screen.contains("Next: modalign correlate --test FILE"),
        "{screen}"
    );
    assert!(!screen.contains("\n\n\n"), "{screen}");
    let beam = root().join("measurements/free-free-beam");
    let synth = read(&beam, "synth.toml").replace("samples = 32768", "samples = 4096");
    write(
        folder,
        &[
            ("synth.toml", &synth),
            ("model.toml", &read(&beam, "model.toml")),
        ],
    );
    said(folder, "synth synth.toml -o hits.uff");
    let (screen, ..) = said(folder, "inspect hits.uff");
    let head = screen.lines().find(|line| line.contains(" responses "));
    assert!(
        head.is_some_and(|head| head.trim_start().starts_with("count")),
        "{screen}"
    );
}

#[test]
fn an_unknown_parameter_of_the_update_is_seen_by_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        &[("modes.csv", &beam_modes("Z")), ("points.csv", POINTS)],
    );
    said(
        folder,
        "new bar modes.csv --model beam --points points.csv --band 20:400",
    );
    let scene = read(folder, "bar/scene.toml")
        + "\n[update]\nresiduals = \"modal\"\n[[update.parameter]]\nname = \"density\"\n";
    write(folder, &[("bar/scene.toml", &scene)]);
    let (_, error, _) = said(folder, "run bar");
    assert!(
        error.contains("[update] residuals: got \"modal\""),
        "{error}"
    );
    write(
        folder,
        &[("bar/scene.toml", &scene.replace("\"modal\"", "\"modes\""))],
    );
    let (_, error, code) = said(folder, "run bar");
    assert_eq!(code, Some(2));
    assert!(
        error.contains("[[update.parameter]] \"density\""),
        "{error}"
    );
    assert!(
        error.contains("a parameter of the model: youngs_modulus"),
        "{error}"
    );
}

#[test]
fn an_explanation_and_a_list_of_codes_fit_a_hundred_columns() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (screen, ..) = said(folder, "--explain sensor-not-rigid");
    assert!(
        screen.contains("cable, sensitivity") && screen.lines().count() > 4,
        "{screen}"
    );
    let (_, error, code) = said(folder, "--explain foo");
    assert_eq!(code, Some(2));
    assert!(error.contains("sensor-unmoved"), "{error}");
    for line in screen.lines().chain(error.lines()) {
        assert!(line.chars().count() <= 101, "{line}");
    }
}

#[test]
fn one_mode_of_one_model_has_one_number() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nname = \"cycloid-ball\"\n";
    write(
        folder,
        &[("scene.toml", scene), ("list.csv", "frequency_hz\n1400\n")],
    );
    for line in ["theory cycloid-ball", "theory scene.toml", "run scene.toml"] {
        let (screen, error, _) = said(folder, line);
        let row = screen.lines().find(|line| line.contains("1436.9"));
        assert!(
            row.is_some_and(|row| row.trim().starts_with("f2 ")),
            "{line}: {screen}{error}"
        );
    }
    for theory in ["cycloid-ball", "scene.toml"] {
        let (screen, error, _) = said(
            folder,
            &format!("correlate --test list.csv --theory {theory}"),
        );
        let row = screen.lines().find(|line| line.contains("1436.9"));
        assert!(
            row.is_some_and(|row| row.trim().starts_with("f2 ")),
            "{theory}: {screen}{error}"
        );
    }
}

#[test]
fn a_common_error_of_all_pairs_is_said_as_a_factor_on_the_stiffnesses() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        &[
            ("modes.csv", &beam_modes("Z")),
            ("model.csv", "frequency_hz\n55\n151\n296\n"),
        ],
    );
    said(folder, "new bar modes.csv --model model.csv");
    let (screen, findings, _) = said(folder, "run bar");
    let sentence = "The model is too stiff or too light: one factor 0.93";
    assert!(screen.contains(sentence), "{screen}{findings}");
    // Errors that grow with frequency have no common factor.
    write(
        folder,
        &[("bar/grow.csv", "frequency_hz\n53.6\n154\n340\n")],
    );
    let scene = read(folder, "bar/scene.toml").replace("../model.csv", "grow.csv");
    write(folder, &[("bar/scene.toml", &scene)]);
    let (screen, findings, _) = said(folder, "run bar");
    let text = screen.split_whitespace().collect::<Vec<_>>().join(" ");
    let sentence = "The model is too stiff or too light: its errors grow with frequency, from -0.93 % at f1 to \
                    -15.62 % at f3, and no single factor removes them.";
    assert!(text.contains(sentence), "{screen}{findings}");
    assert!(!text.contains("one factor"), "{screen}");
}

#[test]
fn a_scene_of_any_name_is_recognised_by_its_schema_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    for (text, is_scene) in [
        ("schema = \"modalign-scene/1\"\n", true),
        ("title = 't'\n'schema' = 'modalign-scene/2'\n", true),
        ("schema = 'modalign-scene/1'\ntitle = \n", true),
        ("schema = 'modalign-model/1'\n", false),
        (
            "schema = 'modalign-model/1'\ntitle = \"\"\"\nschema = \"modalign-scene/1\"\n\"\"\"\n",
            false,
        ),
        ("[old]\nschema = \"modalign-scene/1\"\n", false),
        ("# schema = \"modalign-scene/1\"\n", false),
    ] {
        write(folder.path(), &[("a.toml", text)]);
        assert_eq!(modalign::scene::Scene::is_path(&path), is_scene, "{text}");
    }
}
