//! `modalign theory` on built-in models, models of matrices and finished modes, as a user types it.

use serde_json::Value;

use crate::command::{fail, succeed, write};

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_number_of_balls_is_swept_in_whole_numbers_and_has_no_sensitivity() {
    let text = succeed(["theory", "cycloid-ball", "--sweep", "ball_count=8:14:4"]);
    for part in [
        "root 1, 9 11 13 15 modes (Hz)",
        "root 6, 4 modes (Hz)",
        "root 12, 6 8 10 12 modes (Hz)",
        // 13920.975 rad/s of the reference at 8 balls, 13765.426 at 10.
        "2215.59",
        "2190.83",
        "the values are whole",
    ] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
    assert!(!text.contains("Crossings and veerings"), "{text}");
    let sweep = "ball_count=8:14:4";
    let json = parsed(&succeed([
        "theory",
        "cycloid-ball",
        "--sweep",
        sweep,
        "--json",
    ]));
    let own = &json["sweeps"][0];
    assert_eq!(own["followed"], false);
    assert_eq!(own["loci"][0]["multiplicities"][3], 15);
    assert_eq!(own["loci"][1]["multiplicities"], Value::Null);
    for (sweep, expected) in [
        (
            "ball_count=8:14:5",
            "expected whole numbers in equal steps, such as 8:14:7",
        ),
        ("ball_count=8:50:2", "expected a finite value from 4 to 40"),
    ] {
        let error = fail(["theory", "cycloid-ball", "--sweep", sweep]);
        assert!(error.contains(expected), "{error}");
    }
    let error = fail(["theory", "cycloid-ball", "--set", "ball_count=9.5"]);
    assert!(
        error.contains("got 9.5, expected a whole number"),
        "{error}"
    );
    let text = succeed(["theory", "cycloid-ball", "--sensitivities"]);
    let rows: Vec<&str> = text
        .lines()
        .filter(|line| line.trim_start().starts_with("ball_count "))
        .collect();
    assert_eq!(rows.len(), 2, "{rows:?}");
    assert!(!rows[1].contains('0'), "{rows:?}");
    assert!(
        text.contains("a number of parts, which has no derivative"),
        "{text}"
    );
}

#[test]
fn the_number_of_balls_cannot_be_updated() {
    let folder = tempfile::tempdir().unwrap();
    let modes = folder.path().join("modes.json");
    succeed([
        "theory".as_ref(),
        "cycloid-ball".as_ref(),
        "-o".as_ref(),
        modes.as_os_str(),
    ]);
    let scene = r#"
        schema = "modalign-scene/1"
        title = "balls"
        [model]
        name = "cycloid-ball"
        [[test]]
        name = "itself"
        modes = "modes.json"
        [update]
        parameters = ["k_5y", "ball_count"]
    "#;
    write(folder.path(), &[("scene.toml", scene)]);
    let error = fail(["update".as_ref(), folder.path().as_os_str()]);
    let expected = "\"ball_count\": a number of parts, which is not updated";
    assert!(error.contains(expected), "{error}");
}
