use crate::correlate::published::Statement;

use super::SceneError;
use super::expected::{Expected, load_expected, published_results};
use super::published_claims::KINDS;

const HEAD: &str = r#"
schema = "modalign-expected/1"
[source]
authors = "A"
paper = "B"
year = 2000
[[root]]
label = "w1"
omega_rad_s = 10.0
[comparison]
tests = ["t"]
[[comparison.row]]
label = "f1"
root = "w1"
theory_hz = 1.6
tests = { "t" = 1.5 }
"#;

fn load(text: &str) -> Result<Expected, SceneError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("expected.toml");
    std::fs::write(&path, text).expect("it is writable");
    load_expected(&path)
}

fn message(text: &str) -> String {
    load(text).unwrap_err().to_string()
}

/// Every kind with the keys that it needs.
fn claim_of(kind: &str) -> String {
    let row = if kind.ends_with("multiplicity") || *kind == *"frequency-hz" {
        "w1"
    } else {
        "f1"
    };
    let needed = KINDS
        .iter()
        .find(|(name, _)| *name == kind)
        .expect("a kind of the list")
        .1;
    let keys = needed.iter().map(|key| match *key {
        "test" => "test = \"t\"\n".to_owned(),
        "row" => format!("row = \"{row}\"\n"),
        "rows" => "rows = [\"f1\"]\n".to_owned(),
        "support" => "support = \"suspended\"\n".to_owned(),
        "quantity" | "remark" => format!("{key} = \"q\"\n"),
        _ => "value = 1\n".to_owned(),
    });
    format!(
        "[[claim]]\ntext = \"c\"\nkind = \"{kind}\"\n{}",
        keys.collect::<String>()
    )
}

#[test]
fn each_kind_of_claim_is_read_with_its_keys_as_one_statement() {
    let mut seen: Vec<Statement> = Vec::new();
    for (kind, needed) in KINDS {
        let expected =
            load(&format!("{HEAD}{}", claim_of(kind))).expect("a claim with all it needs");
        let statement = expected.claims[0].statement.clone();
        assert!(!seen.contains(&statement), "{kind} {statement:?}");
        seen.push(statement);
        for key in *needed {
            let without: Vec<String> = claim_of(kind)
                .lines()
                .filter(|line| !line.starts_with(&format!("{key} =")))
                .map(str::to_owned)
                .collect();
            let error = message(&format!("{HEAD}{}", without.join("\n")));
            assert!(
                error.contains(&format!("[[claim]] \"c\" {key}: got none")),
                "{error}"
            );
        }
    }
}

#[test]
fn a_key_that_a_kind_does_not_need_is_an_error() {
    let error = message(&format!(
        "{HEAD}{}test = \"t\"\n",
        claim_of("theory-column")
    ));
    assert!(
        error.contains("[[claim]] \"c\" test: got a value"),
        "{error}"
    );
}

#[test]
fn a_misspelt_key_names_the_nearest() {
    let error = message(&format!("{HEAD}{}decimal = 1\n", claim_of("theory-column")));
    assert!(error.contains("unknown key `decimal`"), "{error}");
    assert!(error.ends_with("did you mean `decimals`?"), "{error}");
    let error = message(&HEAD.replace("omega_rad_s", "omega_rads"));
    assert!(error.ends_with("did you mean `omega_rad_s`?"), "{error}");
    let error = message(&HEAD.replace("theory_hz", "theoryhz"));
    assert!(error.ends_with("did you mean `theory_hz`?"), "{error}");
}

#[test]
fn names_and_numbers_that_cannot_be_meant_are_named() {
    let missed = claim_of("missed");
    for (text, part) in [
        (HEAD.replace("expected/1", "expected/2"), "schema: got"),
        (HEAD.replace("10.0", "-1.0"), "omega_rad_s: got -1"),
        (HEAD.replace("10.0", "nan"), "omega_rad_s: got NaN"),
        (
            HEAD.replace("10.0", "1.0\nmultiplicity = 0"),
            "multiplicity: got 0",
        ),
        (
            HEAD.replace("theory_hz = 1.6", "theory_hz = 0.0"),
            "theory_hz: got 0",
        ),
        (
            HEAD.replace("\"t\" = 1.5", "\"t\" = 0.0"),
            "tests \"t\": got 0",
        ),
        (
            HEAD.replace("\"t\" = 1.5", "\"u\" = 1.5"),
            "tests: got \"u\"",
        ),
        (
            HEAD.replace("root = \"w1\"", "root = \"w2\""),
            "root: got \"w2\"",
        ),
        (HEAD.replace("[\"t\"]", "[\"t\", \"t\"]"), "twice"),
        (
            format!("{HEAD}[[root]]\nlabel = \"w1\"\nomega_rad_s = 1.0\n"),
            "twice",
        ),
        (
            format!("{HEAD}[[comparison.row]]\nlabel = \"f1\"\ntheory_hz = 1.0\n"),
            "twice",
        ),
        (
            format!("max_frequency_error = 0.0\n{HEAD}"),
            "max_frequency_error: got 0",
        ),
        (
            format!("{HEAD}{}", missed.replace("\"t\"", "\"u\"")),
            "test: got \"u\"",
        ),
        (
            format!("{HEAD}{}", missed.replace("f1", "f2")),
            "row: got \"f2\"",
        ),
        (
            format!("{HEAD}{}", missed.replace("\"missed\"", "\"mist\"")),
            "kind: got \"mist\"",
        ),
        (
            format!("{HEAD}{}", claim_of("multiplicity").replace("w1", "f1")),
            "row: got \"f1\"",
        ),
    ] {
        let error = message(&text);
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn a_scene_without_published_results_has_none() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(
        published_results(folder.path()).expect("no file is no error"),
        None
    );
    std::fs::write(folder.path().join("expected.toml"), HEAD).expect("it is writable");
    let found = published_results(folder.path())
        .expect("a sound file")
        .expect("a file");
    assert_eq!((found.roots.len(), found.roots[0].multiplicity), (1, 1));
}

#[test]
fn without_a_model_the_print_is_still_recomputed() {
    let expected =
        load(&format!("{HEAD}{}", claim_of("error-hz"))).expect("a claim with all it needs");
    let result = expected.compare(None, Vec::new(), None);
    assert!(result.roots.is_none());
    assert!(
        result.comparison.expect("a print").rows[0]
            .root_hz
            .is_some()
    );
    assert_eq!(result.verdicts[0].confirmed, Some(false));
}
