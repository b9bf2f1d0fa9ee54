//! Parts of files that an answer does not need: their damage is a finding with place, got and
//! expected, and the answer is given.

mod build;
mod verbs;

use serde_json::Value;

use crate::command::{modalign, succeed, write};

use build::{
    FORCE, Function, NODES, RESPONSE, accelerance, coherence, dataset, frfs, hit_values, hits,
    points, record,
};

/// Exit code, modes and standard error of `identify` of a text.
fn identified(text: &str, more: &[&str]) -> (Option<i32>, Value, String) {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("frfs.uff", text)]);
    let path = folder.path().join("frfs.uff").display().to_string();
    let arguments = ["identify", &path, "--json", "--full"];
    let output = modalign(arguments.iter().chain(more));
    let modes = serde_json::from_slice::<Value>(&output.stdout).unwrap_or_default();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), modes["modes"].clone(), said)
}

/// One mode of 20 Hz and 1 %.
fn assert_right(modes: &Value, what: &str) {
    let modes = modes
        .as_array()
        .unwrap_or_else(|| panic!("{what}: no modes"));
    assert_eq!(modes.len(), 1, "{what}");
    let number = |key: &str| modes[0][key].as_f64().unwrap();
    assert!((number("frequency_hz") - 20.0).abs() < 0.01, "{what}");
    assert!((number("damping_ratio") - 0.01).abs() < 1e-4, "{what}");
}

#[test]
fn padded_trace_lines_are_read() {
    // 98 entries stated: rows of 7 filled up with a zero, one row of zeros at the end, zeros that
    // are not counted.
    let head = "         1        98         8";
    let row =
        |labels: &[i64]| -> String { labels.iter().map(|label| format!("{label:>10}")).collect() };
    let sevens = vec![row(&[1, 2, 3, 1, 2, 3, 1, 0]); 14];
    let mut full = vec![row(&[1, 2, 3, 1, 2, 3, 1, 2]); 12];
    full.push(row(&[1, 2, 0, 0, 0, 0, 0, 0]));
    full.push(row(&[0; 8]));
    let lifted = vec![row(&[1, 2, 3, 0, 2, 3, 1, 2]); 14];
    for rows in [sevens, full, lifted] {
        let mut lines = vec!["    82", head, "Frame"];
        lines.extend(rows.iter().map(String::as_str));
        let text = dataset(&NODES) + &dataset(&lines) + &frfs();
        let (code, modes, said) = identified(&text, &[]);
        assert_eq!(code, Some(0), "{said}");
        // The name of a temporary folder may have any digits.
        let mut words = said.split_whitespace().filter(|word| !word.contains('/'));
        assert!(
            !words.any(|word| word.contains("82") || word.contains("trace")),
            "{said}"
        );
        assert_right(&modes, &said);
    }
    // More entries than stated: a finding.
    let more = vec![row(&[1, 2, 3, 1, 2, 3, 1, 2]); 14];
    let mut lines = vec!["    82", head, "Frame"];
    lines.extend(more.iter().map(String::as_str));
    let (code, modes, said) = identified(&(dataset(&lines) + &frfs()), &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("(112, expected 98) [trace-line-count]"),
        "{said}"
    );
    assert_right(&modes, &said);
}

/// Damaged parts, each with a word of the reported value.
fn damaged_parts() -> Vec<(&'static str, String, &'static str)> {
    let good = coherence(1, |_| 0.9);
    let damaged = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1)
    };
    let spectrum = good.replacen("    6         0", "    2         0", 1);
    vec![
        (
            "nodes",
            dataset(&["    15", "         1  no node"]),
            "no node",
        ),
        ("nodes", dataset(&["  2411", "  nothing"]), "nothing"),
        ("systems", dataset(&["    18", "  nothing"]), "nothing"),
        (
            "trace line",
            dataset(&["    82", "  nothing", "NONE"]),
            "nothing",
        ),
        (
            "trace line",
            dataset(&[
                "    82",
                "         1         2         8",
                "NONE",
                "  1 two",
            ]),
            "1 two",
        ),
        ("elements", dataset(&["  2412", "  nothing"]), "nothing"),
        ("groups", dataset(&["  2467", "  nothing"]), "nothing"),
        ("units", dataset(&["   164", "  nothing"]), "nothing"),
        ("window", dataset(&["  1858", "  nothing"]), "1858"),
        (
            "coherence header",
            damaged("         2       141", "        99       141"),
            "99",
        ),
        (
            "coherence values",
            damaged("9.00000e-1", "no number "),
            "got \"no\"",
        ),
        (
            "coherence count",
            damaged("       141", "      9141"),
            "9141",
        ),
        (
            "spectrum",
            spectrum.replacen("         2       141", "        99       141", 1),
            "99",
        ),
        ("mode", dataset(&["    55", "NONE", "  nothing"]), "55"),
        (
            "unread dataset without end",
            "    -1\n  9999\nsomething\n".to_owned(),
            "end of the file",
        ),
        (
            "trace line without end",
            "    -1\n    82\n         1         2         8\n".to_owned(),
            "end of the file",
        ),
    ]
}

#[test]
fn damage_of_what_modes_do_not_need_is_a_finding() {
    for (what, part, got) in damaged_parts() {
        let (code, modes, said) = identified(&(frfs() + &part), &[]);
        assert_eq!(code, Some(1), "{what}: {said}");
        assert!(said.contains("[bad-dataset]"), "{what}: {said}");
        assert!(said.contains(got), "{what}: {said}");
        assert!(said.contains("expected"), "{what}: {said}");
        assert_right(&modes, what);
    }
}

#[test]
fn damage_of_a_needed_frf_stops_unless_partial() {
    let text = frfs();
    for damaged in [
        text.replacen("         5       141", "        99       141", 1),
        text.replacen("    4         0", "    q         0", 1),
        text.replacen("0.00000E+00\n        18", "0.00000E+00\n        xx", 1),
    ] {
        assert_ne!(text, damaged);
        let (code, _, said) = identified(&damaged, &[]);
        assert_eq!(code, Some(2), "{said}");
        let (code, modes, said) = identified(&damaged, &["--partial"]);
        assert_eq!(code, Some(1), "{said}");
        assert_right(&modes, "partial");
        assert_eq!(modes[0]["shape"].as_object().unwrap().len(), 2);
    }
}

#[test]
fn coherence_outside_0_to_1_is_ignored_at_its_lines() {
    let wrong = |line: usize| match line {
        0 => 1.246,
        60 => f64::NAN,
        61 => -0.5,
        _ => 0.99,
    };
    let text = frfs() + &[1, 2, 3].map(|node| coherence(node, wrong)).concat();
    let (code, modes, said) = identified(&text, &["--averages", "5"]);
    assert_eq!(code, Some(0), "{said}");
    let detail = "(1.246); 3 of 141 lines, from 5 to 20.25 Hz [coherence-invalid]";
    assert!(said.contains(detail), "{said}");
    assert_right(&modes, "coherence");
    let sound = frfs() + &[1, 2, 3].map(|node| coherence(node, |_| 0.99)).concat();
    let (_, expected, _) = identified(&sound, &["--averages", "5"]);
    assert_eq!(modes, expected, "the same variances");
}

#[test]
fn functions_of_other_quantities_are_left_out() {
    let function = |points: &str, numerator: &str, denominator: &str| {
        let of_quantity = Function {
            kind: 4,
            points,
            numerator,
            denominator,
            values: accelerance(0.5),
        };
        of_quantity.text()
    };
    let pressure = "        15    0    0    0 Sound Pressure       Pa                  ";
    let rotation = "        12    0    0    0 Rot. acc.            rad/s^2             ";
    let moment = "        13    0    0    0 Moment               Nm                  ";
    for (other, unit) in [
        (
            function(
                "Mic                9   0 NONE               1   3",
                pressure,
                FORCE,
            ),
            "Pa",
        ),
        (
            function(
                "VP1                4   5 NONE               1   3",
                rotation,
                FORCE,
            ),
            "rad/s^2",
        ),
        (
            function(
                "NONE               2   3 VP1                4   4",
                RESPONSE,
                moment,
            ),
            "Nm",
        ),
    ] {
        let (code, modes, said) = identified(&(frfs() + &other), &[]);
        assert_eq!(code, Some(0), "{said}");
        assert!(
            said.contains("[function-left-out]") && said.contains(unit),
            "{said}"
        );
        assert_right(&modes, unit);
        // Nothing else: the reason is the error.
        let (code, _, said) = identified(&other, &[]);
        assert_eq!(code, Some(2), "{said}");
    }
    // An accelerance of unknown unit is needed, and so is an FRF whose unit cannot be read.
    for (unit, got) in [
        (
            "        12    0    0    0 Acceleration         furlong             ",
            "furlong",
        ),
        (
            "         0    0    0    0 Response             fathom              ",
            "fathom",
        ),
    ] {
        let text = frfs() + &function(&points(4), unit, FORCE);
        let (code, _, said) = identified(&text, &[]);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(got), "{said}");
        let (code, modes, said) = identified(&text, &["--partial"]);
        assert_eq!(code, Some(1), "{said}");
        assert!(
            said.contains("error: ") && said.contains("[function-left-out]"),
            "{said}"
        );
        assert_right(&modes, "partial");
    }
}

#[test]
fn a_tacho_beside_hits_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[("a.uff", &hits(false)), ("b.uff", &hits(true))],
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let expected = succeed(["frf", &path("a.uff"), "--json"]);
    let output = modalign(["frf", &path("b.uff"), "--json"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("unit \"V\" [function-left-out]"), "{said}");
    let functions = |text: &[u8]| {
        let all: Value = serde_json::from_slice(text).unwrap();
        all["functions"].clone()
    };
    assert_eq!(functions(&output.stdout), functions(expected.as_bytes()));
}

#[test]
fn frfs_beside_time_records_are_identified() {
    for (records, count) in [
        (record(1, RESPONSE, 1, hit_values(false, 1)), 1),
        (hits(false), 6),
    ] {
        let (code, modes, said) = identified(&(frfs() + &records), &[]);
        assert_eq!(code, Some(0), "{said}");
        let finding = format!("({count} records) [records-passed-over]");
        assert!(said.contains(&finding), "{said}");
        assert_right(&modes, &said);
    }
}
