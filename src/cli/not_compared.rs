//! The numbers of a baseline that `modalign check` compares with nothing.

use serde_json::Value;

/// Keys with numbers, `a.b` for key `b` of the table or of the tables `a`, that are neither among
/// the compared keys nor below one. Tables without compared keys are one key.
pub(super) fn not_compared(baseline: &Value, compared: &[&str]) -> Vec<String> {
    let mut keys = Vec::new();
    collect(baseline, "", compared, &mut keys);
    keys
}

fn collect(value: &Value, path: &str, compared: &[&str], keys: &mut Vec<String>) {
    if compared.contains(&path) {
        return;
    }
    let is_above = |key: &&str| {
        key.strip_prefix(path)
            .is_some_and(|key| key.starts_with('.'))
    };
    if !path.is_empty() && !compared.iter().any(is_above) {
        if has_number(value) && !keys.iter().any(|key| key == path) {
            keys.push(path.to_owned());
        }
        return;
    }
    match value {
        Value::Array(values) => {
            for value in values {
                collect(value, path, compared, keys);
            }
        }
        Value::Object(values) => {
            for (key, value) in values {
                let path = match path {
                    "" => key.clone(),
                    path => format!("{path}.{key}"),
                };
                collect(value, &path, compared, keys);
            }
        }
        _ => {}
    }
}

fn has_number(value: &Value) -> bool {
    match value {
        Value::Number(_) => true,
        Value::Array(values) => values.iter().any(has_number),
        Value::Object(values) => values.values().any(has_number),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn each_number_is_below_a_compared_key_or_listed_once() {
        let baseline = json!({
            "schema": "s",
            "modes": [
                { "hz": 1.0, "mass": 2.0, "shape": { "1:+Z": [1, 0] }, "name": "a" },
                { "hz": 2.0, "mass": 3.0, "residues": { "1:+Z": [1, 0] } },
            ],
            "findings": [{ "value": 1 }, { "value": 2 }],
            "inputs": [{ "path": "a" }],
        });
        assert_eq!(
            not_compared(&baseline, &["modes.hz", "modes.shape"]),
            ["findings", "modes.mass", "modes.residues"]
        );
        let all = ["findings", "modes"];
        assert!(not_compared(&baseline, &all).is_empty());
    }
}
