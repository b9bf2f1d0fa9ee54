//! Completions, colours, progress, explanations, and the nearest name to what was typed.

use std::process::{Command, Stdio};

use modalign::finding::Code;

use crate::command::{fail, modalign, root, short_beam, succeed, write};

#[test]
fn completion_scripts_of_every_shell_have_every_verb() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = succeed(["completions", shell]);
        for verb in ["run", "identify", "check", "new", "completions"] {
            assert!(script.contains(verb), "{shell}: {verb}");
        }
    }
    let script = succeed(["completions", "bash"]);
    // The shell itself completes a verb from its beginning.
    let typed = format!(
        "{script}\nCOMP_WORDS=(modalign iden); COMP_CWORD=1; _modalign modalign iden modalign; echo \"${{COMPREPLY[@]}}\""
    );
    let Ok(output) = Command::new("bash").args(["-c", &typed]).output() else {
        return;
    };
    assert_eq!(
        String::from_utf8_lossy(&output.stdout).trim(),
        "identify",
        "{output:?}"
    );
}

#[test]
fn manual_pages_of_the_program_and_of_every_verb_are_written() {
    let folder = tempfile::tempdir().unwrap();
    succeed(["man", "-o", folder.path().to_str().unwrap()]);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    // Every page that a page refers to is there.
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        let lines = text.lines().filter_map(|line| line.strip_suffix("(1)"));
        for name in lines.filter(|line| line.starts_with("modalign")) {
            let name = format!("{}.1", name.replace('\\', ""));
            assert!(folder.path().join(&name).exists(), "{name}");
        }
    }
    assert_eq!(page("modalign.1"), succeed(["man"]));
    for (name, parts) in [
        ("modalign.1", ["modalign\\-run(1)", ".SH SYNOPSIS"]),
        (
            "modalign-run.1",
            ["Write report.html, tables", "measurements/cycloid\\-ball"],
        ),
        (
            "modalign-study-order.1",
            [".TH modalign-study-order", "number of modes, model order"],
        ),
    ] {
        for part in parts {
            assert!(page(name).contains(part), "{name}: {part}\n{}", page(name));
        }
    }
}

#[test]
fn colours_are_printed_on_request_and_never_in_json() {
    let painted = "\u{1b}[";
    let missed = [
        "check",
        "measurements/free-free-beam/scene.toml",
        "--against",
        "nothing.json",
    ];
    assert!(!fail(missed).contains(painted), "no terminal");
    assert!(
        fail(missed.iter().chain(&["--color", "always"]))
            .starts_with("\u{1b}[1;31merror\u{1b}[0m: ")
    );
    let folder = tempfile::tempdir().unwrap();
    let beam = short_beam(folder.path());
    let out = folder.path().join("out");
    let out_name = out.to_str().unwrap();
    let run = succeed(["run", &beam, "-o", out_name, "--color", "always"]);
    assert!(run.contains("\u{1b}[1;32mmet\u{1b}[0m"), "{run}");
    let plain = succeed(["run", &beam, "-o", out_name]);
    assert_eq!(
        run.replace("\u{1b}[1;32m", "").replace("\u{1b}[0m", ""),
        plain
    );
    let json = succeed(["run", &beam, "--json", "--color", "always"]);
    assert!(!json.contains(painted));
    for name in [
        "comparison.md",
        "comparison.txt",
        "comparison.csv",
        "comparison.json",
    ] {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        assert!(!text.contains(painted), "no colours in {name}");
    }
}

/// A line of shell with a terminal as its standard output and error. Signals end the program though
/// the suite may run under `nohup`.
#[cfg(target_os = "linux")]
pub fn on_a_terminal(line: &str, environment: &[(&str, &str)]) -> String {
    let program = crate::command::program();
    let program = format!("env --default-signal {}", program.display());
    let line = line.replace("modalign", &program);
    let mut script = Command::new("script");
    script
        .current_dir(root())
        .args(["-qec", &line, "/dev/null"])
        .env_remove("NO_COLOR")
        .env_remove("COLUMNS")
        .env("TERM", "xterm")
        .stdin(Stdio::null());
    let output = script.envs(environment.iter().copied()).output();
    let output =
        output.expect("`script` of util-linux (Debian: bsdutils, essential) makes the terminal");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_has_colours_unless_no_color_is_set_and_sees_the_progress_of_long_work() {
    let beam = tempfile::tempdir().unwrap();
    let verdicts = format!("modalign run {}", short_beam(beam.path()));
    let shown = on_a_terminal(&verdicts, &[]);
    assert!(shown.contains("\u{1b}[1;32mmet\u{1b}[0m"), "{shown}");
    let plain = on_a_terminal(&verdicts, &[("NO_COLOR", "1")]);
    assert!(!plain.contains("\u{1b}[1;"), "{plain}");
    let empty = on_a_terminal(&verdicts, &[("NO_COLOR", "")]);
    assert!(
        empty.contains("\u{1b}[1;"),
        "an empty NO_COLOR says nothing"
    );
    let steps = on_a_terminal("modalign run measurements/spider-reducer", &[]);
    assert!(
        steps.contains("[1/") && steps.contains(" %  ") && !steps.contains(" left"),
        "stage and share; few unlike steps tell no time left"
    );
    // The program waits for a pipe without a writer until an interrupt.
    let waiting = "mkfifo $D/pipe.uff; sleep 2.5 > $D/pipe.uff & timeout --foreground -s INT 2 modalign identify $D/pipe.uff";
    let folder = tempfile::tempdir().unwrap();
    let place = [("D", folder.path().to_str().unwrap())];
    let shown = on_a_terminal(waiting, &place);
    assert!(
        shown.contains("identify  0s") && shown.contains("identify  1s"),
        "{shown:?}"
    );
    assert!(shown.contains("\u{1b}[2Kerror: interrupted"), "{shown:?}");
    std::fs::remove_file(folder.path().join("pipe.uff")).unwrap();
    let quiet = on_a_terminal(&format!("{waiting} --quiet"), &place);
    assert!(!quiet.contains("identify  "), "{quiet:?}");
    std::fs::remove_file(folder.path().join("pipe.uff")).unwrap();
    let dumb = on_a_terminal(waiting, &[place[0], ("TERM", "dumb")]);
    assert!(
        !dumb.contains('\u{1b}') && dumb.contains("error: interrupted"),
        "{dumb:?}"
    );
}

#[test]
fn every_code_is_explained_and_an_unknown_one_names_the_nearest() {
    for code in Code::ALL {
        let name = code.name();
        assert!(name.len() > 2 && code.sentence().len() > 10, "{name}");
        assert!(
            code.explanation().len() > 40 && code.explanation().ends_with(['.', '?']),
            "{name}: {}",
            code.explanation()
        );
    }
    let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for code in [Code::ALL[0], Code::ALL[Code::ALL.len() - 1]] {
        let printed = one_line(&succeed(["--explain", &code.name()]));
        assert!(printed.contains(code.explanation()), "{printed}");
    }
    for verb in ["run", "identify", "frf", "correlate", "check", "study"] {
        let printed = one_line(&succeed([verb, "--explain", "few-lines", "--lang=zh"]));
        assert!(
            printed.contains(&one_line(Code::FewLines.chinese_explanation())),
            "{verb}: {printed}"
        );
    }
    let error = fail(["--explain", "double-hti"]);
    assert!(error.contains("did you mean `double-hit`?"), "{error}");
}

#[test]
fn errors_name_the_nearest_key_file_and_verb() {
    assert!(fail(["identfy", "x.uff"]).contains("'identify'"));
    assert!(fail(["run", "measurements/free-free-beam", "--ouput", "x"]).contains("'--output'"));
    let error = fail(["run", "measurements/free-fre-beam"]);
    assert!(
        error.contains("did you mean `measurements/free-free-beam`?"),
        "{error}"
    );
    assert!(fail(["theory", "cycloid-bal"]).contains("did you mean `cycloid-ball`?"));
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[(
            "scene.toml",
            "schema = \"modalign-scene/1\"\ntitel = \"x\"\n",
        )],
    );
    let error = fail(["run", folder.path().to_str().unwrap()]);
    assert!(
        error.contains("scene.toml:2:1") && error.contains("did you mean `title`?"),
        "{error}"
    );
    let unknown = modalign(["inspect", "no-such-folder/x.uff"]);
    assert!(!String::from_utf8_lossy(&unknown.stderr).contains("did you mean"));
}

#[test]
fn a_number_of_threads_that_cannot_be_meant_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let modes = folder.path().join("modes.json");
    let modes = modes.to_str().unwrap();
    succeed(["theory", "cycloid-ball", "--threads", "2", "-o", modes]);
    for threads in ["0", "100000", "4000000000"] {
        for verb in [["inspect", modes], ["theory", "cycloid-ball"]] {
            let error = fail(verb.iter().chain(&["--threads", threads]));
            assert!(
                error.contains("--threads") && error.contains(threads),
                "{error}"
            );
        }
    }
    for (threads, code) in [("100000", 2), ("many", 2), ("-1", 2), ("2", 0), ("", 0)] {
        let mut program = Command::new(crate::command::program());
        program.env("RAYON_NUM_THREADS", threads);
        let output = program.args(["theory", "cycloid-ball"]).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{threads}: {error}");
        assert!(
            code == 0 || error.contains("RAYON_NUM_THREADS: got"),
            "{error}"
        );
    }
}
