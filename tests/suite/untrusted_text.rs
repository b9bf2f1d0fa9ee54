//! Texts of other people's files, through the command line, in every output: none is obeyed by a
//! terminal, a browser, a spreadsheet program, Markdown, LaTeX or XML.

use std::path::Path;

use crate::command::{modalign, modalign_in, succeed, write};

/// Titles and names from hostile files, each with what would be obeyed.
const TEXTS: &[&str] = &[
    "\u{1b}]0;title\u{7}\u{1b}[2J",
    "\u{9b}2J\u{9d}0;x\u{9c}",
    "a\u{7f}\u{8}\u{8}b\rc",
    "\u{202e}evil\u{2066}",
    "<script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "\"'><svg onload=alert(1)>",
    "</script><!--",
    "&lt;b&gt; & &#x3c;",
    "]]> <?xml?> <!DOCTYPE x>",
    "=HYPERLINK(\"http://x\",\"y\")",
    "+1+cmd|' /C calc'!A0",
    "-1+2",
    "@SUM(1)",
    "[a](javascript:alert(1)) ![b](http://x)",
    "# heading",
    "**bold** _x_ `code` ~~s~~",
    "| a | b |",
    "https://x.example www.x.example",
    "\\input{/etc/passwd} \\write18{ls}",
    "$x^2$ 50% {a} #1 & ~",
    "模态 😀 Ж ا \u{301}",
    "%s %n {} {0}",
    "line\nlimits of the scene: all met",
    "a name of a test that is longer than the name of a file can be, which has 255 bytes in most file systems, and that has all its letters in the tables and in the report all the same, while the names of its files have only the first hundred and twenty of them 模态",
];

/// A scene of two files of modes whose title, test and mode labels are one of the texts.
fn scene(folder: &Path, text: &str) {
    let quoted = serde_json::to_string(text).unwrap();
    // TOML has the escapes of JSON, but for DEL, which it wants escaped.
    let quoted = quoted.replace('\u{7f}', "\\u007f");
    let mode = |hz: f64| {
        format!(
            "{{\"frequency_hz\": {hz}, \"damping_ratio\": 0.01, \"pole_rad_s\": null, \"frequency_std_hz\": null, \"damping_std\": null, \"frequency_damping_correlation\": null, \"group\": null, \"shape\": {{\"1:+X\": [1.0, 0.0], \"2:+X\": [0.5, 0.0]}}, \"shape_std\": null, \"residues\": {{}}, \"modal_mass_kg\": null, \"scaling\": \"unknown\", \"mpc\": null, \"method\": {quoted}, \"order\": null, \"quality\": {{\"verdict\": \"good\", \"frequency\": null, \"damping\": null, \"shape\": null, \"reasons\": [{quoted}]}}}}"
        )
    };
    let modes = |hz| {
        format!(
            "{{\"schema\": \"modalign-modes/1\", \"producer\": {quoted}, \"inputs\": [], \"band_hz\": null, \"references\": [], \"added_damping_rad_s\": null, \"modes\": [{}], \"findings\": []}}",
            mode(hz)
        )
    };
    let scene = format!(
        "schema = \"modalign-scene/1\"\ntitle = {quoted}\n[[test]]\nname = {quoted}\nmodes = \"test.json\"\n[model]\nfile = \"theory.json\"\n[report]\n"
    );
    write(
        folder,
        &[
            ("scene.toml", &scene),
            ("test.json", &modes(100.0)),
            ("theory.json", &modes(101.0)),
        ],
    );
}

/// Whether a terminal would act on the text.
fn is_obeyed(text: &str) -> bool {
    text.contains(|c: char| {
        c != '\n' && c != '\t' && c.is_control()
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    })
}

/// The tags of a page, but for those of code, which notes have between backticks.
fn tags(html: &str) -> Vec<&str> {
    let starts = html.match_indices('<').map(|(at, _)| &html[at..]);
    let tags = starts.filter_map(|tag| tag.split('>').next());
    tags.filter(|tag| !tag.ends_with("code")).collect()
}

#[test]
fn no_output_obeys_a_text_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "plain");
    let run = |out: &str| {
        let ran = modalign_in(folder.path(), ["run", ".", "-o", out, "--full"]);
        let texts = [ran.stdout, ran.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(ran.status.code() != Some(2), "{}", texts[1]);
        texts
    };
    run("plain");
    let read = |out: &str, name: &str| {
        std::fs::read_to_string(folder.path().join(out).join(name)).unwrap()
    };
    let plain_tags = tags(&read("plain", "report.html")).len();
    for (number, text) in TEXTS.iter().enumerate() {
        scene(folder.path(), text);
        let out = format!("out{number}");
        for shown in run(&out) {
            assert!(!is_obeyed(&shown), "{text:?}: {shown:?}");
        }
        for name in [
            "comparison.txt",
            "comparison.md",
            "comparison.tex",
            "comparison.csv",
            "comparison.json",
            "report.html",
        ] {
            let written = read(&out, name);
            assert!(!is_obeyed(&written), "{text:?} in {name}");
        }
        let page = read(&out, "report.html");
        // The text is the content of elements, never one.
        assert_eq!(tags(&page).len(), plain_tags, "{text:?}");
        assert!(page.contains("script-src 'sha256-"), "{text:?}");
        let mut fields = csv::ReaderBuilder::new();
        let table = read(&out, "comparison.csv");
        for record in fields
            .flexible(true)
            .from_reader(table.as_bytes())
            .records()
        {
            for field in &record.unwrap() {
                let formula = field.starts_with(['=', '+', '-', '@']);
                assert!(!formula || field.parse::<f64>().is_ok(), "{field}");
            }
        }
        let tex = read(&out, "comparison.tex");
        let commands = ["\\input", "\\write18"].map(|command| tex.contains(command));
        assert_eq!(commands, [false; 2], "{text:?}");
        let set: Vec<char> = tex.chars().filter(|c| u32::from(*c) > 0x17f).collect();
        assert!(set.iter().all(|c| "‘’“”".contains(*c)), "{text:?}: {set:?}");
        let markdown = read(&out, "comparison.md");
        // Without the signs behind a backslash.
        let unescaped: String = markdown
            .split('\\')
            .map(|part| &part[part.len().min(1)..])
            .collect();
        for element in [
            "<script",
            "<img",
            "<svg",
            "](javascript",
            "](http",
            "**bold**",
            "`code`",
        ] {
            assert!(!unescaped.contains(element), "{text:?}: {markdown}");
        }
    }
}

#[test]
fn titles_of_universal_files_and_paths_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let write_named = |name: &str, title: &str| {
        let id = format!("{title}\nNONE\nNONE\nNONE\nNONE\n");
        let header = "    1         1    0         1 NONE               1   3 NONE               0   0\n         2         2         1  0.00000e+00  1.00000e-01  0.00000e+00\n        17    0    0    0 NONE                 s                   \n        13    0    0    0 NONE                 N                   \n         0    0    0    0 NONE                 NONE                \n         0    0    0    0 NONE                 NONE                \n";
        let text = format!("    -1\n    58\n{id}{header}  1.00000e+00  2.00000e+00\n    -1\n");
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write_named("a.uff", "\u{1b}]0;x\u{7}\u{1b}[2J");
    write_named("\u{1b}[2Jb.uff", "plain");
    for arguments in [vec!["inspect", "a.uff"], vec!["inspect", "\u{1b}[2Jb.uff"]] {
        for more in [vec![], vec!["--json"], vec!["--full"]] {
            let shown = modalign_in(folder.path(), arguments.iter().chain(&more));
            for bytes in [shown.stdout, shown.stderr] {
                let text = String::from_utf8(bytes).unwrap();
                assert!(!is_obeyed(&text), "{arguments:?}: {text:?}");
            }
        }
    }
    let missing = modalign(["inspect", "no\u{1b}[2Jfile"]);
    assert!(!is_obeyed(&String::from_utf8(missing.stderr).unwrap()));
}

#[test]
fn long_values_are_cut_in_messages_and_titles() {
    let folder = tempfile::tempdir().unwrap();
    let cell = "9".repeat(300_000) + "x";
    let table = format!("time [s],1:+Z [N],2:+Z [m/s2]\n0,1,2\n0.1,{cell},3\n0.2,1,2\n");
    write(folder.path(), &[("h.csv", &table)]);
    let shown = modalign_in(folder.path(), ["inspect", "h.csv"]);
    let length = shown.stdout.len() + shown.stderr.len();
    assert!(length < 4000, "{length}");
    let scene = format!("schema = \"modalign-scene/1\"\ntitle = \"{cell}\"\nunknown = 1\n");
    write(folder.path(), &[("scene.toml", &scene)]);
    let shown = modalign_in(folder.path(), ["run", "."]);
    assert!(shown.stderr.len() < 4000, "{}", shown.stderr.len());
}

#[cfg(unix)]
#[test]
fn a_confined_scene_reads_no_file_outside_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let secret = "root:x:0:0:secret";
    write(
        folder.path(),
        &[("secret", secret), ("secret.toml", "token = \"secret\"\n")],
    );
    std::fs::create_dir(folder.path().join("s")).unwrap();
    let inner = folder.path().join("s");
    let scenes = [
        "[[test]]\nname = \"a\"\nfiles = [\"../secret\"]\n",
        "[[test]]\nname = \"a\"\nmodes = \"../secret\"\n",
        "[[test]]\nname = \"a\"\nsynth = \"../secret.toml\"\n",
        "[model]\nfile = \"../secret\"\n",
        "[model]\nfile = \"../secret.toml\"\n",
        "[model]\nfile = \"m.toml\"\n",
    ];
    let model = "schema = \"modalign-model/1\"\ntitle = \"x\"\n[matrices]\ndofs = \"../secret\"\nmass = \"../secret\"\nstiffness = \"../secret\"\n";
    for scene in scenes {
        let scene = format!("schema = \"modalign-scene/1\"\ntitle = \"x\"\n{scene}");
        write(&inner, &[("scene.toml", &scene), ("m.toml", model)]);
        let confined = modalign_in(&inner, ["run", ".", "--confine"]);
        let message = String::from_utf8(confined.stderr).unwrap();
        assert_eq!(confined.status.code(), Some(2), "{scene}");
        assert!(message.contains("--confine"), "{scene}: {message}");
        // Without the option the file is read, and not quoted.
        let message = String::from_utf8(modalign_in(&inner, ["run", "."]).stderr).unwrap();
        assert!(
            !message.contains("root:") && !message.contains("token"),
            "{scene}: {message}"
        );
    }
    let confined = |verb: &[&str]| modalign_in(&inner, verb.iter().chain(&["--confine"]));
    for verb in [
        &["theory", "m.toml"],
        &["synth", "m.toml", "-o", "x.uff"] as &[&str],
    ] {
        let message = String::from_utf8(confined(verb).stderr).unwrap();
        assert!(message.contains("--confine"), "{verb:?}: {message}");
    }
    scene(&inner, "plain");
    succeed(["run", inner.to_str().unwrap(), "--confine"]);
}
