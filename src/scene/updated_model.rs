//! The model with its updated parameters as text: a `model.toml` with nominal values replaced and
//! all other text kept, or the `[model]` table of a scene for a built-in one.

use std::fmt::Write as _;
use std::ops::Range;

use crate::theory::ParameterSpec;

/// The `model.toml` with new nominal values, with status `inferred` where the update changed them
/// from `start`; `None` where a parameter's table was not found.
pub(super) fn replace_nominal_values(
    text: &str,
    specs: &[ParameterSpec],
    start: &[f64],
    values: &[f64],
) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for ((spec, start), value) in specs.iter().zip(start).zip(values) {
        if spec.nominal.to_bits() == value.to_bits() {
            continue;
        }
        let (status, comment) = if start.to_bits() == value.to_bits() {
            let comment = format!("stated by the scene; {:?} before", spec.nominal);
            ("assumed", comment)
        } else {
            ("inferred", format!("updated from {start:?}"))
        };
        let table_range = parameter_table(&lines, &spec.name)?;
        let nominal = key_line(&lines, &table_range, "nominal")?;
        replace_text(
            &mut lines[nominal],
            &format!("nominal = {value:?}    # {comment}"),
        );
        let status_line = key_line(&lines, &table_range, "status")?;
        replace_text(&mut lines[status_line], &format!("status = \"{status}\""));
    }
    Some(lines.join("\n") + "\n")
}

/// Lines before an updated `model.toml`: which values of the scene would hide those of the file.
/// Empty where there are none.
pub(super) fn overrides_note<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<&str> = names.map(String::as_str).collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        "# Values of the scene's [model.parameters] are in this file. Delete them there, or they hide it: {}.\n",
        names.join(", ")
    )
}

/// Replaces the text of a line, not its indent.
fn replace_text(line: &mut String, text: &str) {
    let indent = line.len() - line.trim_start().len();
    line.truncate(indent);
    line.push_str(text);
}

/// The value of a key on a line, with the comment behind it.
fn key_value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let (line_key, value) = line.split_once('=')?;
    (line_key.trim() == key).then(|| value.trim())
}

fn key_line(lines: &[String], table: &Range<usize>, key: &str) -> Option<usize> {
    table.clone().find(|&i| key_value(&lines[i], key).is_some())
}

/// The lines of the `[[parameter]]` table of this name.
fn parameter_table(lines: &[String], name: &str) -> Option<Range<usize>> {
    let header = |line: &String| line.trim_start().starts_with('[');
    let starts = (0..lines.len()).filter(|&i| lines[i].trim_start().starts_with("[[parameter]]"));
    let quoted = [format!("\"{name}\""), format!("'{name}'")];
    let table = |start: usize| {
        let end = (start + 1..lines.len()).find(|&i| header(&lines[i]));
        start + 1..end.unwrap_or(lines.len())
    };
    let named = |table: &Range<usize>| {
        table.clone().any(|i| {
            let table_name = key_value(&lines[i], "name");
            table_name
                .is_some_and(|table_name| quoted.iter().any(|q| table_name.starts_with(q.as_str())))
        })
    };
    starts.map(table).find(named)
}

/// The `[model]` table of a scene that gives a model these values.
pub(super) fn model_table_text(
    key: &str,
    model: &str,
    specs: &[ParameterSpec],
    values: &[f64],
) -> String {
    let mut text = format!(
        "# The [model] table of a scene.toml with the updated parameters.\n[model]\n{key} = {model:?}\n\n[model.parameters]\n"
    );
    for (spec, value) in specs.iter().zip(values) {
        if spec.nominal.to_bits() != value.to_bits() {
            let (name, nominal, unit) = (&spec.name, spec.nominal, &spec.unit);
            writeln!(
                text,
                "{name} = {value:?}    # {unit}; {nominal:?} in the model"
            )
            .expect("text takes every line");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::ParameterStatus;

    fn spec(name: &str, nominal: f64) -> ParameterSpec {
        ParameterSpec {
            name: name.to_owned(),
            unit: "N/m".to_owned(),
            nominal,
            lower: None,
            upper: None,
            status: ParameterStatus::Assumed,
            whole: false,
        }
    }

    #[test]
    fn nominal_values_are_replaced_in_the_table_of_their_parameter_alone() {
        let text = "kind = \"lumped\"\n[[parameter]]\nnominal = 1.0 # start\nname = \"a\"\nstatus = \"printed\"\n[[parameter]]\nname = 'ab'\n  nominal = 2.0\n status = 'printed'\n[[body]]\nname = \"a\"\n";
        let specs = [spec("a", 1.0), spec("ab", 2.0)];
        // The scene states 3 for the second one, which updating leaves.
        let new = replace_nominal_values(text, &specs, &[1.0, 3.0], &[1.5, 3.0]).unwrap();
        let expected = "kind = \"lumped\"\n[[parameter]]\nnominal = 1.5    # updated from 1.0\nname = \"a\"\nstatus = \"inferred\"\n[[parameter]]\nname = 'ab'\n  nominal = 3.0    # stated by the scene; 2.0 before\n status = \"assumed\"\n[[body]]\nname = \"a\"\n";
        assert_eq!(new, expected);
        let same = [1.0, 2.0];
        assert_eq!(
            replace_nominal_values(text, &specs, &same, &same).unwrap(),
            text
        );
        assert_eq!(
            replace_nominal_values(text, &[spec("c", 1.0)], &[1.0], &[2.0]),
            None
        );
    }

    #[test]
    fn the_values_of_the_scene_that_would_hide_the_file_are_named() {
        let names = ["k1".to_owned(), "k2".to_owned()];
        let note = overrides_note(names.iter());
        assert!(
            note.starts_with("# ") && note.ends_with("hide it: k1, k2.\n"),
            "{note}"
        );
        assert_eq!(overrides_note(std::iter::empty()), "");
    }

    #[test]
    fn the_table_of_a_scene_has_what_changed() {
        let text = model_table_text(
            "name",
            "gear/A",
            &[spec("a", 1.0), spec("b", 2.0)],
            &[1.0, 3.0],
        );
        assert!(text.contains("name = \"gear/A\"\n"), "{text}");
        assert!(
            text.contains("b = 3.0") && !text.contains("a = 1.0"),
            "{text}"
        );
    }
}
