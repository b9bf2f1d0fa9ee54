//! The model with its updated parameters as text: a `model.toml` with its nominal values replaced and everything else as it
//! was, or the `[model]` table of a scene for a built-in one.

use std::fmt::Write as _;

use crate::theory::ParameterSpec;

/// The `model.toml` with other nominal values; `None` where a parameter's table was not found.
pub(super) fn replaced(text: &str, specs: &[ParameterSpec], values: &[f64]) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for (spec, value) in specs.iter().zip(values) {
        if spec.nominal.to_bits() == value.to_bits() {
            continue;
        }
        let line = nominal_line(&lines, &spec.name)?;
        let indent: String = lines[line]
            .chars()
            .take_while(|c| c.is_whitespace())
            .collect();
        lines[line] = format!(
            "{indent}nominal = {value:?}    # updated from {:?}",
            spec.nominal
        );
    }
    Some(lines.join("\n") + "\n")
}

/// The line of `nominal` in the `[[parameter]]` table of this name.
fn nominal_line(lines: &[String], name: &str) -> Option<usize> {
    let header = |line: &String| line.trim_start().starts_with('[');
    let value = |line: &String, key: &str| -> Option<String> {
        let (own, value) = line.split_once('=')?;
        (own.trim() == key).then(|| value.trim().to_owned())
    };
    let starts = (0..lines.len()).filter(|&i| lines[i].trim_start().starts_with("[[parameter]]"));
    for start in starts {
        let end = (start + 1..lines.len()).find(|&i| header(&lines[i]));
        let table = start + 1..end.unwrap_or(lines.len());
        let quoted = [format!("\"{name}\""), format!("'{name}'")];
        let named = |i: usize| {
            let own = value(&lines[i], "name");
            own.is_some_and(|own| quoted.iter().any(|q| own.starts_with(q.as_str())))
        };
        if table.clone().any(named) {
            return table
                .clone()
                .find(|&i| value(&lines[i], "nominal").is_some());
        }
    }
    None
}

/// The `[model]` table of a scene that gives a model these values.
pub(super) fn table(key: &str, model: &str, specs: &[ParameterSpec], values: &[f64]) -> String {
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
        }
    }

    #[test]
    fn nominal_values_are_replaced_in_their_own_tables_alone() {
        let text = "kind = \"lumped\"\n[[parameter]]\nnominal = 1.0 # start\nname = \"a\"\n[[parameter]]\nname = 'ab'\n  nominal = 2.0\n[[body]]\nname = \"a\"\n";
        let specs = [spec("a", 1.0), spec("ab", 2.0)];
        let new = replaced(text, &specs, &[1.5, 2.5]).unwrap();
        let expected = "kind = \"lumped\"\n[[parameter]]\nnominal = 1.5    # updated from 1.0\nname = \"a\"\n[[parameter]]\nname = 'ab'\n  nominal = 2.5    # updated from 2.0\n[[body]]\nname = \"a\"\n";
        assert_eq!(new, expected);
        assert_eq!(replaced(text, &specs, &[1.0, 2.0]).unwrap(), text);
        assert_eq!(replaced(text, &[spec("c", 1.0)], &[2.0]), None);
    }

    #[test]
    fn the_table_of_a_scene_has_what_changed() {
        let text = table(
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
