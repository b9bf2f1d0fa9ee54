//! Options of `new` are written into the scene, or refused with the reason.

use std::path::Path;

use crate::command::{fail, modalign, succeed, write};
use crate::new_command::{at, estimate_and_identify, recorded, write_columns};

/// An FRF of one mode as an analyser writes it whose header states this unit.
fn pulse_export(unit: &str, factor: f64) -> String {
    let mut text = format!(
        "Header Size:\t 12\t \t \r\nPulse Version:\t 80\t \t \r\nDecimal Symbol:\t.\t \t \r\n\
         Data Type:\tComplex\t \t \r\nX-Axis type:\tLinear\t \t \r\nX-Axis size:\t200\t \t \r\n\
         X-Axis unit:\tHz\t \t \r\nX-Axis first value:\t 1.0\t \t \r\nX-Axis delta:\t 0.5\t \t \r\n\
         \t \t \t \r\nAmplitudeUnit:\t{unit}\t \t \r\nFunction:\tFrequency Response\t \t \r\n\
         Z-index:\t \t1\t \r\nDate:\t \t01/02/2020\t \r\nTime:\t \t10:00:00:000\t \r\n"
    );
    for line in 0..200 {
        let hz = 1.0 + 0.5 * f64::from(line);
        let (real, imaginary) = (1.0 - (hz / 50.0).powi(2), 2.0 * 0.01 * hz / 50.0);
        let amplitude = -factor * hz * hz / (real * real + imaginary * imaginary);
        let (real, imaginary) = (amplitude * real, -amplitude * imaginary);
        text += &format!("{}\t{hz}\t{real:.9e}\t{imaginary:.9e}\r\n", line + 1);
    }
    text
}

#[test]
fn a_stated_unit_is_that_of_every_file_with_those_without_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    for (file, unit, factor) in [
        ("a.txt", "V/N", 1e-3),
        ("b.txt", "(m/s2)/N", 2e-3),
        ("c.txt", "(m/s2)/N", 3e-3),
    ] {
        write(folder.path(), &[(file, &pulse_export(unit, factor))]);
    }
    let files = ["a.txt", "b.txt", "c.txt"].map(path);
    let scene = path("scene");
    let stated = ["--response", "9:+Z", "--reference", "1:+Z,2:+Z,3:+Z"];
    let unit = ["--unit", "(m/s2)/N"];
    let arguments = ["new", &scene].into_iter();
    let arguments = arguments.chain(files.iter().map(String::as_str));
    let printed = succeed(arguments.chain(stated).chain(unit));
    assert!(printed.contains("nothing is left to fill in"), "{printed}");
    let output = modalign(["run", &scene, "--json"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let shape = result["modes"][0]["shape"].as_object().unwrap();
    assert_eq!(shape.len(), 3, "three hits: {shape:?}");
    assert!(said.contains("unit-contradicts-file"), "{said}");
    assert!(!said.contains("function-left-out"), "{said}");
    // Without the option the scene has a line for it.
    let (open, calibrated) = (path("open"), path("calibrated"));
    let printed = succeed(
        ["new", &open, &files[0]]
            .into_iter()
            .chain(stated[..2].iter().copied()),
    );
    assert!(printed.contains(": unit: of the FRFs"), "{printed}");
    succeed(["new", &calibrated, &files[1]].into_iter().chain(unit));
    let text = std::fs::read_to_string(path("calibrated/scene.toml")).unwrap();
    assert!(!text.contains("\nunit = "), "the header has it: {text}");
}

#[test]
fn an_option_that_the_draft_cannot_use_is_refused_with_the_reason() {
    let folder = recorded();
    let path = |name: &str| at(folder.path(), name);
    estimate_and_identify(folder.path());
    write_columns(folder.path(), "hits.csv", "force,acceleration");
    write_columns(folder.path(), "frfs.csv", "frequency,real,imaginary");
    for (file, option, value, reason) in [
        ("frfs.csv", "--unit", "kN", "the files hold FRFs"),
        ("frfs.csv", "--unit", "m/s2", "the files hold FRFs"),
        (
            "frfs.csv",
            "--sampling-rate",
            "100",
            "no file holds time records",
        ),
        ("frfs.h5", "--unit", "(m/s)/N", "the headers state"),
        ("frfs.h5", "--response", "77:+Z", "the headers state 1:+Z"),
        ("hits.csv", "--unit", "m/N", "the files hold time records"),
        ("hits.uff", "--unit", "lbf", "the headers state"),
        ("hits.uff", "--reference", "77:+Z", "the headers state 1:+Z"),
        ("hits.uff", "--sampling-rate", "1", "the headers state"),
        ("modes.json", "--unit", "N", "neither time records nor FRFs"),
        ("modes.json", "--reference", "1:+Z", "finished modes"),
    ] {
        let error = fail(["new", &path("x"), &path(file), option, value]);
        let wanted = format!("{option}: got {value}, expected ");
        assert!(
            error.contains(&wanted) && error.contains(reason),
            "{file}: {error}"
        );
        assert!(!folder.path().join("x").exists());
    }
    // A statement that agrees with the header is no contradiction.
    succeed(["new", &path("same"), &path("frfs.h5"), "--unit", "(m/s2)/N"]);
}

#[test]
fn options_for_columns_without_headings_stand_in_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    let row = |hz: i32| {
        let (real, imaginary) = (
            1.0 - (f64::from(hz) / 30.0).powi(2),
            0.04 * f64::from(hz) / 30.0,
        );
        let power = real * real + imaginary * imaginary;
        format!("{hz} {:.9} {:.9}\n", real / power, -imaginary / power)
    };
    let rows: String = (0..100).map(row).collect();
    write(folder.path(), &[("a.txt", &rows), ("b.txt", &rows)]);
    let (a, b, scene) = (path("a.txt"), path("b.txt"), path("scene"));
    let stated = [
        "--response",
        "9:+X",
        "--reference",
        "1:+X,2:+X",
        "--unit",
        "m/N",
    ];
    let printed = succeed(["new", &scene, &a, &b].into_iter().chain(stated));
    assert!(printed.contains("3 lines to be filled in"), "{printed}");
    let text = std::fs::read_to_string(path("scene/scene.toml")).unwrap();
    assert!(!text.contains("sampling_rate_hz"), "FRFs have none: {text}");
    let mut filled = text;
    for role in ["frequency", "real", "imaginary"] {
        filled = filled.replacen("role = \"FILL IN\"", &format!("role = \"{role}\""), 1);
    }
    write(folder.path(), &[("scene/scene.toml", &filled)]);
    let modes = succeed(["run", &scene, "--json"]);
    let modes: serde_json::Value = serde_json::from_str(&modes).unwrap();
    let shape = modes["modes"][0]["shape"].as_object().unwrap();
    assert_eq!(shape.keys().collect::<Vec<_>>(), ["1:+X", "2:+X"]);
    // Without a unit the columns may be records or FRFs: the roles alone are requested.
    let open = succeed(["new", &path("open"), &a]);
    assert!(open.contains("3 lines to be filled in"), "{open}");
}

/// A NumPy file of hits, channels and samples: a force and a response of one mode.
fn write_hits(path: &Path, shape: [usize; 3]) {
    let [hits, channels, samples] = shape;
    let head = format!(
        "{{'descr': '<f8', 'fortran_order': False, 'shape': ({hits}, {channels}, {samples}), }}"
    );
    let head = format!("{head:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((head.len() as u16).to_le_bytes());
    bytes.extend(head.as_bytes());
    for hit in 0..hits {
        for channel in 0..channels {
            for sample in 0..samples {
                let seconds = (sample as f64 - 20.0) / 2000.0;
                let noise = 1e-5 * ((sample * 7919 + 13 * hit + channel) % 101) as f64;
                let value: f64 = match channel {
                    0 if (20..23).contains(&sample) => 10.0,
                    0 => 0.0,
                    _ if sample <= 20 => 0.0,
                    _ => (-5.0 * seconds).exp() * (314.0 * seconds).sin(),
                };
                bytes.extend((value + noise).to_le_bytes());
            }
        }
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn files_of_one_shape_are_one_test_with_a_column_for_each_channel() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    for file in ["F1.npy", "F2.npy"] {
        write_hits(&folder.path().join(file), [3, 2, 4096]);
    }
    let (scene, files) = (path("scene"), ["F1.npy", "F2.npy"].map(path));
    let stated = ["--reference", "1:+Z,2:+Z", "--sampling-rate", "2000"];
    succeed(
        ["new", &scene, &files[0], &files[1]]
            .into_iter()
            .chain(stated),
    );
    let text = std::fs::read_to_string(path("scene/scene.toml")).unwrap();
    assert_eq!(text.matches("[[test]]\n").count(), 1, "{text}");
    assert_eq!(text.matches("[[test.channel]]").count(), 2, "{text}");
    assert!(text.contains("column = 1\n") && text.contains("column = 2\n"));
    assert!(text.contains("of 3 x 2 x 4096, slowest first"), "{text}");
    let open = "role = \"FILL IN\"";
    let filled = text
        .replace("[\"FILL IN\"]", "[\"hit\", \"channel\", \"sample\"]")
        .replacen(open, "role = \"force\"\nunit = \"N\"", 1)
        .replacen(open, "role = \"response\"\nunit = \"g\"\ndof = \"9:+Z\"", 1);
    write(folder.path(), &[("scene/scene.toml", &filled)]);
    let set: serde_json::Value = serde_json::from_str(&succeed(["frf", &scene, "--json"])).unwrap();
    let functions = set["functions"].as_array().unwrap();
    assert_eq!(functions.len(), 2, "one for each hit point: {set}");
    // Vectors of different names are channels of different meaning.
    for file in ["force.npy", "acceleration.npy"] {
        write_hits(&folder.path().join(file), [1, 1, 4096]);
    }
    let (vectors, files) = (path("vectors"), ["force.npy", "acceleration.npy"].map(path));
    succeed(["new", &vectors, &files[0], &files[1]]);
    let text = std::fs::read_to_string(path("vectors/scene.toml")).unwrap();
    assert_eq!(text.matches("[[test]]\n").count(), 2, "{text}");
}

#[test]
fn a_list_of_coordinates_beside_test_data_is_left_out_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write_columns(folder.path(), "hits.csv", "force,acceleration");
    let points = "0.1 0.0 0.0\n0.2 0.0 0.1\n0.3 0.0 0.2\n";
    write(
        folder.path(),
        &[
            ("a.txt", &pulse_export("(m/s2)/N", 1e-3)),
            ("points.txt", points),
        ],
    );
    let coordinates = path("points.txt");
    for (scene, file) in [("of-frfs", "a.txt"), ("of-columns", "hits.csv")] {
        let printed = succeed(["new", &path(scene), &path(file), &coordinates]);
        let said = printed.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            said.contains("points.txt: 3 columns without a known heading")
                && said.contains("--points FILE"),
            "{printed}"
        );
        let text = std::fs::read_to_string(path(&format!("{scene}/scene.toml"))).unwrap();
        assert!(!text.contains("points.txt") && text.matches("[[test]]\n").count() == 1);
    }
    // Alone it may be a table of measured values.
    let printed = succeed(["new", &path("alone"), &coordinates]);
    assert!(printed.contains("3 lines to be filled in"), "{printed}");
}

#[test]
fn positions_that_may_be_millimetres_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write(folder.path(), &[("a.txt", &pulse_export("(m/s2)/N", 1e-3))]);
    for (scene, end, is_named) in [("mm", "900", true), ("bridge", "40", false)] {
        let points = format!("point,x,y,z\n1,0,0,0\n2,{end},0,0\n");
        write(folder.path(), &[("points.csv", &points)]);
        let stated = ["--response", "1:+Z", "--reference", "2:+Z", "--points"];
        let arguments = ["new", &path(scene), &path("a.txt")]
            .map(str::to_owned)
            .into_iter();
        let stated = stated.map(str::to_owned).into_iter();
        let printed = succeed(arguments.chain(stated).chain([path("points.csv")]));
        let remark = format!("The points extend over {end} m. Positions are in metres");
        assert_eq!(printed.contains(&remark), is_named, "{printed}");
    }
}

#[test]
fn a_faulty_list_of_points_is_answered_with_its_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write(
        folder.path(),
        &[
            ("a.txt", &pulse_export("(m/s2)/N", 1e-3)),
            ("points.csv", "1;0;0;0\n2;0.1;0;0\n"),
        ],
    );
    let error = fail([
        "new",
        &path("x"),
        &path("a.txt"),
        "--points",
        &path("points.csv"),
    ]);
    for wanted in [
        "line 2",
        "line 1 was taken as the heading",
        "`point,x,y,z`",
        "POINT,X,Y,Z in metres",
    ] {
        assert!(error.contains(wanted), "{wanted}: {error}");
    }
}

/// Writes NumPy arrays of three hits by channels by samples, without samples of a test.
fn write_arrays(folder: &Path, names: &[&str], channels: usize) {
    for name in names {
        let shape = format!("(3, {channels}, 256)");
        let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        let head = format!("{head:<117}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(head.len()).unwrap().to_le_bytes());
        bytes.extend(head.as_bytes());
        let samples = (0..3 * channels * 256).map(|i| ((i * 7919) % 101) as f64);
        bytes.extend(samples.flat_map(f64::to_le_bytes));
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

#[test]
fn stated_responses_of_unnamed_channels_are_those_of_each_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    let names = ["a.npy", "b.npy", "c.npy"];
    write_arrays(folder.path(), &names, 4);
    let rows: String = (0..64)
        .map(|i| format!("{},{},{},{}\n", i % 7, i % 6, i % 5, i % 4))
        .collect();
    write(folder.path(), &[("one.csv", &rows), ("two.csv", &rows)]);
    let new = |scene: &str, files: &[&str], responses: &str| -> Vec<String> {
        let files: Vec<String> = files.iter().map(|name| path(name)).collect();
        let stated = ["--response", responses, "--reference", "9:+Z"].map(str::to_owned);
        [vec!["new".to_owned(), path(scene)], files, stated.to_vec()].concat()
    };
    let three = "1:+X,1:+Y,1:+Z";
    for (scene, files) in [("arrays", &names[..]), ("table", &["one.csv"][..])] {
        succeed(new(scene, files, three));
        let text = std::fs::read_to_string(path(&format!("{scene}/scene.toml"))).unwrap();
        assert!(!text.contains("\nresponse = "), "{text}");
        // The first column is the force or the first response, the last the third.
        let (tests, _) = text.split_once("[[test.file]]").unwrap();
        let columns: Vec<&str> = tests.split("[[test.channel]]").collect();
        let holds =
            |column: usize, dof: &str| columns[column].contains(&format!("# dof = \"{dof}\""));
        assert!(holds(1, "1:+X") && !holds(1, "1:+Y"), "{text}");
        assert!(
            holds(2, "1:+X") && holds(2, "1:+Y") && !holds(2, "1:+Z"),
            "{text}"
        );
        assert!(holds(4, "1:+Z") && !holds(4, "1:+Y"), "{text}");
    }
    // Two columns are a force and one response: the points are those of the files.
    write_arrays(folder.path(), &names, 2);
    succeed(new("files", &names, three));
    let text = std::fs::read_to_string(path("files/scene.toml")).unwrap();
    assert_eq!(text.matches("\nresponse = ").count(), 3, "{text}");
    // Two responses of two files of four columns fit both, four of one file neither.
    let both = fail(new("both", &["one.csv", "two.csv"], "1:+X,1:+Y"));
    assert!(
        both.contains("2 DOFs for 2 files of 4 unnamed columns"),
        "{both}"
    );
    assert!(
        both.contains("one for each file or one for each response"),
        "{both}"
    );
    let neither = fail(new("neither", &["one.csv"], "1:+X,1:+Y,1:+Z,2:+X"));
    assert!(
        neither.contains("4 DOFs for 1 file of 4 unnamed columns"),
        "{neither}"
    );
}

#[test]
fn all_that_unnamed_columns_need_is_listed_with_its_option() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    let rows: String = (0..64).map(|i| format!("{i}\t{}\t0.5\n", i % 7)).collect();
    write(folder.path(), &[("a.txt", &rows), ("b.txt", &rows)]);
    let files = [path("a.txt"), path("b.txt")];
    let printed = succeed(["new", &path("open"), &files[0], &files[1]]);
    let options = [
        "--unit '(m/s2)/N'",
        "--response DOF",
        "--reference DOF",
        "--sampling-rate HZ",
    ];
    for option in options {
        assert!(printed.contains(option), "{option}: {printed}");
    }
    let text = std::fs::read_to_string(path("open/scene.toml")).unwrap();
    assert!(!text.contains("\nhits = "), "{text}");
    let stated = [
        "--unit",
        "m/N",
        "--response",
        "1:+Z",
        "--reference",
        "1:+Z,2:+Z",
    ];
    let arguments = ["new", &path("said"), &files[0], &files[1]];
    let printed = succeed(arguments.into_iter().chain(stated));
    for option in options {
        assert!(!printed.contains(option), "{option}: {printed}");
    }
}

#[test]
fn lists_of_points_alone_are_no_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write(
        folder.path(),
        &[
            ("a.csv", "point,x,y,z\n1,0,0,0\n2,0.1,0,0\n"),
            ("b.csv", "1,0,0,0\n2,0.1,0,0\n3,0.2,0,0\n"),
        ],
    );
    let (a, b) = (path("a.csv"), path("b.csv"));
    for files in [vec![&a], vec![&a, &b], vec![&b]] {
        let scene = path("scene");
        let arguments = ["new", &scene].into_iter();
        let error = fail(arguments.chain(files.into_iter().map(String::as_str)));
        assert!(
            error.contains("without recordings") && error.contains("--points FILE"),
            "{error}"
        );
        assert!(!Path::new(&scene).exists());
    }
    // Coordinates in another arrangement are no recordings either; the option is named.
    write(
        folder.path(),
        &[
            ("setup.csv", "xHit,0,0,0\nzHit,0.1,0.2,0.4\nxSensor,0,,\n"),
            (
                "named.csv",
                "point,x,y,z,name\n1,0,0,0,left\n2,0.1,0,0,right\n",
            ),
            ("notes.csv", "steel tip, 3 hits\n"),
            ("hit.csv", "time [s],force [N]\n0,0\n0.001,1\n0.002,0\n"),
        ],
    );
    for (number, (name, is_named)) in [
        ("setup.csv", true),
        ("named.csv", true),
        ("notes.csv", false),
    ]
    .into_iter()
    .enumerate()
    {
        let error = fail(["new", &path("scene"), &path(name)]);
        assert_eq!(error.contains("--points FILE"), is_named, "{error}");
        let scene = path(&format!("beside-{number}"));
        let output = modalign(["new", &scene, &path("hit.csv"), &path(name)]);
        let text = String::from_utf8(output.stdout).unwrap().replace('\n', " ");
        let line = text.split("beside-").next().unwrap();
        assert!(line.contains("not used: "), "{text}");
        assert_eq!(line.contains("--points FILE"), is_named, "{text}");
    }
    // A list beside recordings is the one of the option; two are refused.
    let hit = path("hit.csv");
    succeed(["new", &path("stated"), &hit, "--points", &a]);
    let found = succeed(["new", &path("found"), &hit, &a]);
    assert!(found.contains("2 points, as by --points"), "{found}");
    let scene = |name: &str| std::fs::read_to_string(path(&format!("{name}/scene.toml"))).unwrap();
    assert_eq!(scene("found"), scene("stated").replace("stated", "found"));
    let twice = path("twice");
    for beside in [vec!["--points", &a], vec![&a]] {
        let arguments = ["new", &twice, &hit, &b].into_iter();
        let error = fail(arguments.chain(beside));
        assert!(error.contains("one list of points"), "{error}");
    }
    // Samples that are counted are a record.
    let rows: String = (1..=256)
        .map(|i| format!("{i},{},{},1\n", i % 7, i % 5))
        .collect();
    write(folder.path(), &[("record.csv", &rows)]);
    succeed(["new", &path("record"), &path("record.csv")]);
}

#[test]
fn the_length_of_a_drafted_beam_is_named_as_a_guess() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| at(folder.path(), name);
    write(
        folder.path(),
        &[
            ("a.txt", &pulse_export("(m/s2)/N", 1e-3)),
            ("points.csv", "1,0.1,0,0\n2,0.9,0,0\n"),
        ],
    );
    let stated = [
        "--response",
        "1:+Z",
        "--reference",
        "2:+Z",
        "--model",
        "beam",
        "--points",
    ];
    let arguments = ["new", &path("beam"), &path("a.txt")].map(str::to_owned);
    let stated = stated.map(str::to_owned).into_iter();
    let printed = succeed(
        arguments
            .into_iter()
            .chain(stated)
            .chain([path("points.csv")]),
    );
    assert!(
        printed.contains("its length of 0.8 m is a guess"),
        "{printed}"
    );
    let scene = std::fs::read_to_string(path("beam/scene.toml")).unwrap();
    assert!(scene.contains("its length is a guess"), "{scene}");
    let theory = succeed(["theory", &path("beam/model.toml"), "--full"]);
    let run = modalign(["run", &path("beam")]);
    let run = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(
        run.contains("Assumed in the model: ends and length of beam"),
        "{run}{theory}"
    );
}
