//! Every verb that reads files: `--partial`, needs of positions and units, and names of models.

use std::path::Path;

use serde_json::Value;

use super::build::{NODES, dataset, frfs, modes};
use super::{assert_right, identified};
use crate::command::{fail, json, modalign, modalign_in, succeed, write};
use crate::updating::frame;

/// Exit code with and without `--partial` and standard error without it.
fn codes(arguments: &[&str]) -> (Option<i32>, Option<i32>, String) {
    let without = modalign(arguments);
    let with = modalign(arguments.iter().chain(&["--partial"]));
    let said = String::from_utf8_lossy(&without.stderr).into_owned();
    (without.status.code(), with.status.code(), said)
}

#[test]
fn every_verb_that_reads_files_takes_the_good_part_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let damaged_frfs = frfs().replacen("         5       141", "        99       141", 1);
    write(
        folder.path(),
        &[
            ("good.uff", &modes(false)),
            ("modes.uff", &modes(true)),
            ("frfs.uff", &damaged_frfs),
            ("sound.uff", &frfs()),
        ],
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (good, bad, functions, sound) = (
        path("good.uff"),
        path("modes.uff"),
        path("frfs.uff"),
        path("sound.uff"),
    );
    for arguments in [
        vec!["correlate", "--test", &bad, "--theory", &good],
        vec!["correlate", "--test", &good, "--theory", &bad],
        vec!["correlate", "--test", &bad],
        vec!["correlate", "--test", &functions, "--theory", &sound],
        vec!["theory", &bad],
        vec!["identify", &functions],
    ] {
        let (without, with, said) = codes(&arguments);
        assert_eq!((without, with), (Some(2), Some(1)), "{arguments:?}: {said}");
        assert!(said.contains("got") && said.contains(".uff:"), "{said}");
    }
    // These two deliver the good part of any file.
    let out = path("out.uff");
    for arguments in [vec!["inspect", &bad], vec!["convert", &bad, "-o", &out]] {
        let (without, with, said) = codes(&arguments);
        assert_eq!((without, with), (Some(1), Some(1)), "{arguments:?}: {said}");
    }
}

#[test]
fn a_drafted_scene_takes_the_good_part_and_runs() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("modes.uff", &modes(true))]);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (scene, file) = (path("scene"), path("modes.uff"));
    let error = fail(["new", &scene, &file]);
    assert!(error.contains("modes.uff:"), "{error}");
    let output = modalign(["new", &scene, &file, "--partial"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    let text = std::fs::read_to_string(Path::new(&scene).join("scene.toml")).unwrap();
    assert!(text.contains("partial = true"), "{text}");
    let run = modalign(["run", &scene, "--json"]);
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(1), "{said}");
    let modes: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(modes["modes"].as_array().unwrap().len(), 2);
    // A scene that does not say so needs the option, and a study takes it too.
    std::fs::write(
        Path::new(&scene).join("scene.toml"),
        text.replace("partial = true", "#"),
    )
    .unwrap();
    let (without, with, said) = codes(&["run", &scene]);
    assert_eq!((without, with), (Some(2), Some(1)), "{said}");
}

#[test]
fn an_update_and_a_study_of_a_scene_take_the_good_part() {
    let folder = tempfile::tempdir().unwrap();
    // Node 1 of the test is the upper storey, where its first mode is larger.
    let model = frame(1.0, &[1.1e4, 1.1e4], (0.5, 2.0))
        .replace("[1.0, 0.0, 0.0]", "[0.0, 0.0, 1.0]")
        .replace("[\"x\"]", "[\"z\"]")
        .replace(
            "\"1:+X\"\ncoordinate = \"b1.x\"",
            "\"2:+Z\"\ncoordinate = \"b1.z\"",
        )
        .replace(
            "\"2:+X\"\ncoordinate = \"b2.x\"",
            "\"1:+Z\"\ncoordinate = \"b2.z\"",
        );
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nfile = \"model.toml\"\n[[test]]\nname = \"t\"\nmodes = \"modes.uff\"\n[update]\n";
    let study = "schema = \"modalign-study/1\"\n[breakdown]\ndraws = 1\nmethods = [\"peak\"]\nmodes = \"modes.uff\"\ncase = { lines = 60 }\n[[breakdown.slice]]\nx = { factor = \"separation\", lo = 0.5, hi = 8.0, count = 2 }\ny = { factor = \"damping\", lo = 0.005, hi = 0.05, count = 2 }\n";
    let damaged_frfs = frfs().replacen("         5       141", "        99       141", 1);
    let of_frfs = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"t\"\nfiles = [\"../frfs.uff\"]\nband_hz = [10.0, 30.0]\n";
    let files = [
        ("scene.toml", scene),
        ("study.toml", study),
        ("model.toml", &model),
        ("modes.uff", &modes(true)),
        ("frfs.uff", &damaged_frfs),
        ("frfs/scene.toml", of_frfs),
    ];
    std::fs::create_dir(folder.path().join("frfs")).unwrap();
    write(folder.path(), &files);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (scene, spec, out) = (path(""), path("study.toml"), path("out"));
    let (of_frfs, fast) = (path("frfs"), ["--draws", "1"]);
    for arguments in [
        vec!["update", &scene, "-o", &out],
        vec!["study", "order", &scene, "-o", &out],
        vec!["study", "breakdown", &spec, "-o", &out],
        [&["study", "speed-accuracy", &of_frfs], fast.as_slice()].concat(),
    ] {
        let (without, with, said) = codes(&arguments);
        assert_eq!((without, with), (Some(2), Some(1)), "{arguments:?}: {said}");
        assert!(said.contains(".uff:"), "{said}");
        // With the option the part that is left out is listed with its place.
        let output = modalign(arguments.iter().chain(&["--partial"]));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let mut lines = said.lines();
        let is_listed = |line: &str| line.contains(".uff:") && line.contains("[bad-dataset]");
        assert!(lines.any(is_listed), "{arguments:?}: {said}");
    }
}

#[test]
fn nodes_are_needed_for_positions_and_local_directions_alone() {
    let folder = tempfile::tempdir().unwrap();
    let damaged = dataset(&["    15", "         1  no node"]);
    let turned = dataset(&[
        "    18",
        "         2         0         0         8         1",
        "Turned",
        "  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  1.00000E+00  0.00000E+00",
        "  0.00000E+00  0.00000E+00  1.00000E+00",
    ]);
    let text = modes(false) + &damaged;
    write(
        folder.path(),
        &[
            ("good.uff", &(dataset(&NODES) + &modes(false))),
            ("nodes.uff", &text),
            ("local.uff", &(turned + &text)),
        ],
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (good, nodes, local) = (path("good.uff"), path("nodes.uff"), path("local.uff"));
    let arguments = ["correlate", "--test", &nodes, "--theory", &good];
    assert_eq!(modalign(arguments).status.code(), Some(1));
    let by_node = arguments.iter().chain(&["--nearest-node", "0.1"]);
    assert_eq!(modalign(by_node).status.code(), Some(2));
    let arguments = ["correlate", "--test", &local, "--theory", &good];
    assert_eq!(modalign(arguments).status.code(), Some(2));
}

#[test]
fn shapes_whose_nodes_and_systems_are_both_damaged_are_used_only_with_partial() {
    let folder = tempfile::tempdir().unwrap();
    let nodes = dataset(&["    15", "         1  no node"]);
    let systems = dataset(&["    18", "  nothing"]);
    write(
        folder.path(),
        &[
            ("good.uff", &(dataset(&NODES) + &modes(false))),
            ("both.uff", &(nodes + &systems + &modes(false))),
            ("systems.uff", &(dataset(&NODES) + &systems + &modes(false))),
        ],
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (good, both) = (path("good.uff"), path("both.uff"));
    for arguments in [
        ["correlate", "--test", &both, "--theory", &good],
        ["correlate", "--test", &good, "--theory", &both],
    ] {
        let (without, with, said) = codes(&arguments);
        assert_eq!((without, with), (Some(2), Some(1)), "{arguments:?}: {said}");
        assert!(said.contains("both.uff:"), "{said}");
        let output = modalign(arguments.iter().chain(&["--partial"]));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains("[directions-lost]"), "{said}");
    }
    // Nodes that name no system need none.
    let (systems, good) = (path("systems.uff"), path("good.uff"));
    let (without, _, said) = codes(&["correlate", "--test", &systems, "--theory", &good]);
    assert_eq!(without, Some(1), "{said}");
    assert!(!said.contains("[directions-lost]"), "{said}");
}

#[test]
fn lost_units_are_not_those_of_another_dataset() {
    // Headers without units take them from dataset 164: the damaged one governs the functions
    // behind it.
    let silent = frfs().replace("m/s2", "    ").replace(" N  ", "    ");
    let millimetres = dataset(&["   164", "         5", "1.0D+03 1.0D+00 1.0D+00", "0.0"]);
    let damaged = dataset(&["   164", "  nothing"]);
    let (code, modes, said) = identified(&(millimetres.clone() + &silent), &[]);
    assert_eq!(code, Some(0), "{said}");
    assert_right(&modes, "units of the file");
    let (code, _, said) = identified(&(millimetres + &damaged + &silent), &[]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("unit"), "{said}");
}

#[test]
fn a_built_in_name_is_the_scene_of_that_name_and_else_the_built_in_model() {
    let folder = tempfile::tempdir().unwrap();
    let expected = succeed(["theory", "cycloid-ball", "--json"]);
    let theory = |arguments: &[&str]| {
        let all = ["theory"].iter().chain(arguments).chain(&["--json"]);
        let output = modalign_in(folder.path(), all);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), text, said)
    };
    std::fs::create_dir(folder.path().join("cycloid-ball")).unwrap();
    let (code, text, said) = theory(&["cycloid-ball"]);
    assert_eq!((code, &text), (Some(0), &expected), "{said}");
    assert!(!said.contains("built-in-taken"), "{said}");
    // A folder that holds a scene is the scene, as for the verbs that take one.
    let scene =
        "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nname = \"torsional-planetary\"\n";
    write(
        &folder.path().join("cycloid-ball"),
        &[("scene.toml", scene)],
    );
    let (code, text, said) = theory(&["cycloid-ball", "--full"]);
    assert_eq!(code, Some(0), "{said}");
    assert_ne!(text, expected);
    let used = "the scene cycloid-ball/scene.toml was used; in another folder cycloid-ball is the \
                built-in model [built-in-taken]";
    assert!(said.contains(used), "{said}");
    let (code, again, said) = theory(&["./cycloid-ball"]);
    assert_eq!((code, again), (Some(0), text), "{said}");
    assert!(!said.contains("built-in-taken"), "{said}");
    // So do the other verbs that take a model.
    let output = modalign_in(
        folder.path(),
        [
            "correlate",
            "--test",
            "cycloid-ball",
            "--theory",
            "cycloid-ball",
            "--rotation-length",
            "0.1",
        ],
    );
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let output = modalign_in(
        folder.path(),
        ["new", "scene", "m.uff", "--model", "cycloid-ball"],
    );
    assert_eq!(output.status.code(), Some(2), "there is no m.uff yet");
    write(folder.path(), &[("m.uff", &modes(false))]);
    let output = modalign_in(
        folder.path(),
        ["new", "scene", "m.uff", "--model", "cycloid-ball"],
    );
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let text = std::fs::read_to_string(folder.path().join("scene/scene.toml")).unwrap();
    assert!(text.contains("name = \"cycloid-ball\""), "{text}");
    // So is a file of that name, here one of finished modes without an extension.
    let built_in = succeed(["theory", "spider-reducer", "--json"]);
    let file = folder.path().join("spider-reducer");
    let saved = folder.path().join("modes.json");
    succeed(["theory", "cycloid-ball", "-o", saved.to_str().unwrap()]);
    std::fs::rename(&saved, &file).unwrap();
    let (code, text, said) = theory(&["spider-reducer"]);
    assert_eq!((code, &text), (Some(0), &built_in), "{said}");
    assert!(
        said.contains(
            "the built-in model was used; ./spider-reducer names the file [built-in-taken]"
        ),
        "{said}"
    );
    let (code, text, said) = theory(&["./spider-reducer"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("built-in-taken"), "{said}");
    let frequencies = |text: &str| {
        let all: Value = serde_json::from_str(text).unwrap();
        let modes = all["modes"].as_array().unwrap().clone();
        modes
            .iter()
            .map(|mode| mode["frequency_hz"].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(frequencies(&text), frequencies(&expected));
    assert_eq!(json(&file)["schema"], "modalign-modes/1");
}
