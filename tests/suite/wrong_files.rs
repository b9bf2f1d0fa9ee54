//! Wrong scenes, models and tables: one run names every fault with its place, what was got and
//! expected, and the nearest right name.

use std::path::Path;

use crate::bad_input::TABLE_SCENE;
use crate::command::{modalign_in, write};

const HITS: &str = "force,acceleration\n1,2\n3,4\n";

const MODEL: &str = r#"schema = "modalign-model/1"
title = "two masses"
[[parameter]]
name = "mount"
unit = "N/m"
nominal = 1.0e6
lower = 5.0e5
upper = 2.0e6
status = "assumed"
[[body]]
name = "a"
mass_kg = 1.0
at_m = [0.0, 0.0, 0.0]
free = ["z"]
[[body]]
name = "b"
mass_kg = 2.0
at_m = [0.1, 0.0, 0.0]
free = ["z"]
[[point]]
name = "pa"
body = "a"
at_m = [0.0, 0.0, 0.0]
[[point]]
name = "pb"
body = "b"
at_m = [0.1, 0.0, 0.0]
[[spring]]
name = "s1"
from = "pa"
to = "ground"
direction = [0.0, 0.0, 1.0]
parameter = "mount"
[[spring]]
name = "s2"
from = "pa"
to = "pb"
direction = [0.0, 0.0, 1.0]
stiffness_n_per_m = 1.0e6
"#;

const MODES: &str = "frequency_hz,damping_ratio,1:+Z,2:+Z\n12.25,0.004,1,0.62\n31.5,,0.3,-0.8\n";

/// A file that is made wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrong {
    Scene,
    Hits,
    Model,
    Modes,
}

use Wrong::{Hits, Model, Modes, Scene};

/// The file, its replacements, and what the message says.
type Case = (
    Wrong,
    &'static [(&'static str, &'static str)],
    &'static [&'static str],
);

const CASES: &[Case] = &[
    // Several faults.
    (
        Scene,
        &[
            ("title = \"a table\"\n", ""),
            ("sampling_rate_hz", "samplng_rate_hz"),
            ("files = [\"hits.csv\"]", "files = \"hits.csv\""),
        ],
        &[
            "3 faults",
            "scene.toml:1:1: got no key `title`",
            "scene.toml:4:9: got the text \"hits.csv\", expected an array, [...]",
            "scene.toml:5:1: got unknown key `samplng_rate_hz`",
            "did you mean `sampling_rate_hz`?",
        ],
    ),
    (
        Scene,
        &[
            ("name = \"table\"\n", ""),
            ("dof = \"1:+Z\"", "dof = \"1:+Q\""),
            ("unit = \"N\"", "unit = 3"),
        ],
        &[
            "3 faults",
            "scene.toml:3:1: got no key `name`",
            "scene.toml:9:7: got degree of freedom `1:+Q`, expected a point with a direction",
            "scene.toml:10:8: got the number 3, expected a text in quotes",
        ],
    ),
    (
        Scene,
        &[(
            "title = \"a table\"",
            "title = \"a table\"\n[identify]\nmetod = \"ml\"\n[pair]\nmin_mca = 0.5\n[limits]\nmax_mised = 0",
        )],
        &[
            "3 faults",
            ":4:1: got unknown key `metod`",
            "did you mean `method`?",
            ":6:1: got unknown key `min_mca`",
            "did you mean `min_mac`?",
            ":8:1: got unknown key `max_mised`",
            "did you mean `max_missed`?",
        ],
    ),
    // The list of files has faults, and so have files of it.
    (
        Scene,
        &[
            (
                "title = \"a table\"",
                "title = \"a table\"\n[frf]\nforce_window_s = -0.1\nnoise_ratio = 0.0\nblock_length_s = nan",
            ),
            (
                "files = [\"hits.csv\"]",
                "files = [\"hits.csv\", \"missing.csv\", \"none*.csv\"]\nband_hz = [300.0, 20.0]\nhits = \"recods\"\ntrigger.level_n = -1.0",
            ),
            ("column = \"acceleration\"", "column = \"accel\""),
        ],
        &[
            "9 faults",
            ":4:18: [frf] force_window_s: got -0.1, expected a finite time of 0 s or more",
            ":5:15: [frf] noise_ratio: got 0, expected a finite number above 0",
            ":6:18: [frf] block_length_s: got NaN, expected a finite time above 0 s",
            "[[test]] files: got \"none*.csv\", which matches no file",
            "band_hz: got [300.0, 20.0], expected",
            "[[test]] hits: got \"recods\", expected",
            "[test.trigger] level_n: got -1, expected a positive",
            "missing.csv: cannot open: there is no such file",
            "hits.csv:1: got columns force, acceleration, expected a column \"accel\"",
        ],
    ),
    (
        Model,
        &[
            ("nominal = 1.0e6\n", ""),
            ("status = \"assumed\"", "status = \"guessed\""),
            ("mass_kg = 1.0", "mass = 1.0"),
            ("to = \"ground\"\n", ""),
        ],
        &[
            "4 faults",
            "model.toml:3:1: got no key `nominal`",
            "model.toml:8:10: got `guessed`, expected one of `printed`",
            "model.toml:11:1: got unknown key `mass`",
            "\n    hint: did you mean `mass_kg`?",
            "model.toml:27:1: got no key `to`",
        ],
    ),
    (
        Model,
        &[
            ("unit = \"N/m\"\n", ""),
            ("nominal = 1.0e6\n", ""),
            ("status = \"assumed\"\n", ""),
            ("from = \"pa\"\nto = \"pb\"\n", ""),
        ],
        &[
            "5 faults",
            "model.toml:3:1: got no key `unit`",
            "model.toml:3:1: got no key `nominal`",
            "model.toml:3:1: got no key `status`",
            "got no key `from`",
            "got no key `to`",
        ],
    ),
    (
        Model,
        &[
            ("mass_kg = 2.0", "mass_kg = true"),
            ("at_m = [0.1, 0.0, 0.0]\nfree", "at_m = [0.1, 0.0]\nfree"),
            (
                "direction = [0.0, 0.0, 1.0]\nparameter",
                "direction = 3\nparameter",
            ),
        ],
        &[
            "3 faults",
            "model.toml:17:11: ",
            "model.toml:18:8: got 2 values, expected an array of 3 values",
            "model.toml:32:13: got the number 3, expected an array of 3 values",
        ],
    ),
    (
        Scene,
        &[(
            "title = \"a table\"",
            "title = \"a table\"\n[[identify]]\nmethod = \"ml\"\n[pair]\nmin_mac = \"high\"",
        )],
        &[
            "2 faults",
            ":3:1: got an array, expected a table",
            ":6:11: got the text \"high\", expected a number",
        ],
    ),
    // Scenes.
    (
        Scene,
        &[("[[test]]", "[[tests]]")],
        &[":3:3: got unknown key `tests`", "did you mean `test`?"],
    ),
    (
        Scene,
        &[("title = \"a table\"", "title = \"a table")],
        &["scene.toml:2:17: invalid basic string, expected `\"`"],
    ),
    (
        Scene,
        &[("modalign-scene/1", "modalign-scene/2")],
        &["schema: got \"modalign-scene/2\", expected \"modalign-scene/1\""],
    ),
    (
        Scene,
        &[("hits.csv", "hit.csv")],
        &["hit.csv: cannot open", "did you mean `./hits.csv`?"],
    ),
    (
        Scene,
        &[("role = \"force\"", "role = \"forse\"")],
        &[
            "[[test.channel]] \"force\" of \"table\", role: got \"forse\", expected time, frequency, force",
        ],
    ),
    (
        Scene,
        &[("unit = \"N\"", "unit = \"furlong\"")],
        &[
            "[[test.channel]] \"force\" of \"table\", unit: got \"furlong\", expected a unit of force (N",
        ],
    ),
    (
        Scene,
        &[("unit = \"m/s2\"\n", "")],
        &["\"acceleration\" of \"table\", unit: got nothing, expected a unit of acceleration"],
    ),
    (
        Scene,
        &[("sampling_rate_hz = 1000\n", "")],
        &["hits.csv: the sampling rate is not stated: expected a column with role = \"time\""],
    ),
    (
        Scene,
        &[("sampling_rate_hz = 1000", "sampling_rate_hz = -5")],
        &["[[test]] \"table\" sampling_rate_hz: got -5, expected a positive number"],
    ),
    (
        Scene,
        &[("dof = \"2:+Z\"\n", "")],
        &[
            "the response point of record 2 is not stated: expected",
            "`dof` in [[test.channel]]",
        ],
    ),
    (
        Scene,
        &[("column = \"acceleration\"", "column = \"acc\"")],
        &["hits.csv:1: got columns force, acceleration, expected a column \"acc\""],
    ),
    (
        Scene,
        &[(
            "files = [\"hits.csv\"]",
            "files = [\"hits.csv\"]\nband_hz = [400, 20]",
        )],
        &["[[test]] \"table\" band_hz: got [400.0, 20.0], expected 0 <= lower edge < upper edge"],
    ),
    (
        Scene,
        &[("files = [\"hits.csv\"]", "files = []")],
        &["[[test]] \"table\": got none or several of files, synth, modes, expected exactly one"],
    ),
    (
        Scene,
        &[(
            "[[test.channel]]\ncolumn = \"force\"",
            "[model]\nname = \"cycloid-bal\"\n[[test.channel]]\ncolumn = \"force\"",
        )],
        &["[model] name: got \"cycloid-bal\", expected cycloid-ball, torsional-planetary"],
    ),
    (
        Scene,
        &[(
            "title = \"a table\"",
            "title = \"a table\"\n[identify]\nmethod = \"mle\"",
        )],
        &["[identify] method: got \"mle\", expected one of auto peak circle"],
    ),
    (
        Scene,
        &[(
            "title = \"a table\"",
            "title = \"a table\"\n[identify]\norder = 2",
        )],
        &["[identify] order: got 2, expected 4 to 500"],
    ),
    (
        Scene,
        &[(
            "title = \"a table\"",
            "title = \"a table\"\n[pair]\nmin_mac = 1.5",
        )],
        &["[pair] min_mac: got 1.5, expected 0 to below 1"],
    ),
    // Tables of numbers.
    (
        Hits,
        &[("3,4", "3,oops")],
        &["hits.csv:3: number: got \"oops\", expected a finite number"],
    ),
    (
        Hits,
        &[("3,4", "3")],
        &["hits.csv:3: number: got \"1 column\", expected"],
    ),
    (
        Hits,
        &[("force,acceleration", "force,accel")],
        &["hits.csv:1: got columns force, accel, expected a column \"acceleration\""],
    ),
    (
        Hits,
        &[("1,2\n3,4\n", "")],
        &["hits.csv:1: got text without rows of numbers, expected rows"],
    ),
    // Models.
    (
        Model,
        &[("mass_kg = 2.0", "mass_kg = -2.0")],
        &["body `b`: got mass_kg -2, expected a finite number of 0 or more"],
    ),
    (
        Model,
        &[("from = \"pa\"\nto = \"pb\"", "from = \"px\"\nto = \"pb\"")],
        &["spring `s2`: got point `px`, expected the name of a [[point]] or `ground`"],
    ),
    (
        Model,
        &[("parameter = \"mount\"", "parameter = \"mont\"")],
        &["spring `s1`: got parameter `mont`", "did you mean `mount`?"],
    ),
    (
        Model,
        &[("lower = 5.0e5", "lower = 5.0e6")],
        &[
            "model.toml:7:9: parameter `mount`: got lower = 5000000 above upper = 2000000 N/m, expected lower <= upper",
        ],
    ),
    (
        Model,
        &[("unit = \"N/m\"", "unit = \"N m\"")],
        &["spring `s1`: got parameter `mount` in N m for stiffness_n_per_m, expected N/m"],
    ),
    (
        Model,
        &[("[0.0, 0.0, 1.0]\nparameter", "[0.0, 0.0, 0.0]\nparameter")],
        &["spring `s1`: got direction [0.0, 0.0, 0.0], expected three finite numbers"],
    ),
    (
        Model,
        &[("free = [\"z\"]\n[[body]]", "free = [\"w\"]\n[[body]]")],
        &["model.toml:14:9: got `w`, expected one of `x`, `y`, `z`"],
    ),
    (
        Model,
        &[("body = \"b\"", "body = \"c\"")],
        &["point `pb`: got body `c`, expected one of a, b"],
    ),
    (
        Model,
        &[("name = \"b\"", "name = \"a\"")],
        &["got body `a` twice, expected a distinct name"],
    ),
    (
        Model,
        &[("stiffness_n_per_m = 1.0e6\n", "")],
        &["spring `s2`: got no stiffness or several, expected one of stiffness_n_per_m"],
    ),
    (
        Model,
        &[("modalign-model/1", "modalign-study/1")],
        &["got schema `modalign-study/1`, expected `modalign-model/1`"],
    ),
    // A file is what its schema says.
    (
        Model,
        &[("modalign-model/1", "modalign-scene/1")],
        &["got unknown key `spring`, expected one of `schema`, `title`, `test`"],
    ),
    (
        Model,
        &[("[[spring]]\nname = \"s2\"", "[[sprng]]\nname = \"s2\"")],
        &["got unknown key `sprng`", "did you mean `spring`?"],
    ),
    (
        Model,
        &[("nominal = 1.0e6", "nominal = 1.0e5")],
        &["parameter `mount`: got 100000 N/m, expected a finite value from 500000 to 2000000 N/m"],
    ),
    // Tables of modes.
    (
        Modes,
        &[("frequency_hz", "frequency")],
        &[
            "the file holds the columns frequency, damping_ratio, 1:+Z, 2:+Z",
            "headings `frequency_hz`",
        ],
    ),
    (
        Modes,
        &[("12.25,0.004", "12.25,-")],
        &["modes.csv:2: damping_ratio: got \"-\", expected"],
    ),
    (
        Modes,
        &[("31.5,,", "31.5,")],
        &["modes.csv:3: row: got \"3 cells\", expected 4 as in the heading"],
    ),
    (
        Modes,
        &[("1:+Z", "1:+Q")],
        &["modes.csv:1: column: got \"1:+Q\", expected frequency_hz"],
    ),
    (
        Modes,
        &[("12.25", "-12.25")],
        &["modes.csv:2: frequency_hz: got \"-12.25\", expected"],
    ),
    (
        Modes,
        &[("2:+Z", "1:+Z")],
        &["modes.csv:1: column: got \"1:+Z\", expected each column once"],
    ),
];

/// Standard error of the command that reads the wrong file.
fn message(folder: &Path, wrong: Wrong, replacements: &[(&str, &str)]) -> String {
    let text = |file: Wrong, right: &str| {
        let mut text = right.to_owned();
        for (from, to) in replacements.iter().filter(|_| file == wrong) {
            assert!(text.contains(from), "{from} is in the right file");
            text = text.replacen(from, to, 1);
        }
        text
    };
    let files = [
        ("scene.toml", text(Scene, TABLE_SCENE)),
        ("hits.csv", text(Hits, HITS)),
        ("model.toml", text(Model, MODEL)),
        ("modes.csv", text(Modes, MODES)),
    ];
    let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
    write(folder, &files);
    let arguments = match wrong {
        Scene | Hits => ["run", "."],
        Model => ["theory", "model.toml"],
        Modes => ["theory", "modes.csv"],
    };
    let output = modalign_in(folder, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{replacements:?}: {message}");
    assert!(output.stdout.is_empty(), "an error prints no result");
    message
}

#[test]
fn every_fault_of_a_wrong_file_is_named_with_place_and_expectation() {
    assert!(CASES.len() >= 40, "{}", CASES.len());
    let several = CASES
        .iter()
        .filter(|(_, _, said)| said[0].ends_with(" faults"));
    assert!(several.count() >= 5);
    for (wrong, replacements, expected) in CASES {
        let folder = tempfile::tempdir().unwrap();
        let message = message(folder.path(), *wrong, replacements);
        for part in *expected {
            assert!(
                message.contains(part),
                "{replacements:?}: {part} is missing in\n{message}"
            );
        }
        assert!(
            message.contains("expected") || message.contains("cannot open"),
            "{message}"
        );
    }
}

#[test]
fn headings_that_are_not_understood_are_listed_with_those_that_are() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = "f [Hz],H real,H imag\n1,10.2,0.01\n2,1,1\n3,2,1\n";
    let modes = "mode,freq,zeta\n1,10.2,0.01\n2,20.1,0.02\n";
    write(folder.path(), &[("frfs.csv", frfs), ("modes.csv", modes)]);
    for (arguments, parts) in [
        (
            ["identify", "frfs.csv"],
            [
                "the columns f [Hz], H real, H imag",
                "`frequency [Hz]`, then `re 1:+Z|2:+Z",
            ],
        ),
        (
            ["theory", "modes.csv"],
            [
                "the columns mode, freq, zeta",
                "`frequency_hz`, `damping_ratio`, then `1:+Z`",
            ],
        ),
    ] {
        let output = modalign_in(folder.path(), arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        for part in parts {
            assert!(message.contains(part), "{part} is missing in\n{message}");
        }
        // The remedy stands on a separate line; no scene states what a table of modes lacks.
        let has_hint = message.contains("\nhint: a scene states it");
        assert_eq!(has_hint, arguments[0] == "identify", "{message}");
    }
}

#[test]
fn a_parameter_that_nothing_uses_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let unused = MODEL.replace("parameter = \"mount\"", "stiffness_n_per_m = 1.0e6");
    for (model, warned) in [(MODEL, false), (unused.as_str(), true)] {
        write(folder.path(), &[("model.toml", model)]);
        let output = modalign_in(folder.path(), ["theory", "model.toml"]);
        let findings = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{findings}");
        assert_eq!(
            findings.contains("[parameter-unused]"),
            warned,
            "{findings}"
        );
    }
}
