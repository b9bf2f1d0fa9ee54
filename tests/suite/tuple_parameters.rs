//! Parameters of functions: none is a tuple of unlike types, for which named fields or
//! separate parameters stand.

use std::fs;
use std::path::Path;

/// Functions with such a parameter, below `src`. The number may only fall.
const MAX_FUNCTIONS: usize = 2;

/// Parts of a list between the commas outside all brackets.
fn parts(list: &str) -> Vec<String> {
    let (mut depth, mut last, mut found) = (0, ' ', vec![String::new()]);
    for letter in list.chars() {
        match letter {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            '>' if last != '-' => depth -= 1,
            ',' if depth == 0 => found.push(String::new()),
            _ => {}
        }
        if letter != ',' || depth > 0 {
            found.last_mut().unwrap().push(letter);
        }
        last = letter;
    }
    let trimmed = found.iter().map(|part| part.trim().to_owned());
    trimmed.filter(|part| !part.is_empty()).collect()
}

/// The text between the first opening bracket and its closing one, and the text after it.
fn bracketed(text: &str) -> Option<(&str, &str)> {
    let open = text.chars().next()?;
    let close = if open == '(' { ')' } else { '>' };
    let (mut depth, mut last) = (0, ' ');
    for (at, letter) in text.char_indices() {
        if letter == open {
            depth += 1;
        } else if letter == close && !(close == '>' && last == '-') {
            depth -= 1;
            if depth == 0 {
                return Some((&text[1..at], &text[at + 1..]));
            }
        }
        last = letter;
    }
    None
}

/// Whether the type of a parameter, behind references, is a tuple of unlike types.
fn is_unlike_tuple(parameter: &str) -> bool {
    // The colon between pattern and type stands outside all brackets and is no path's.
    let mut depth = 0;
    let marked = parameter.replace("::", "  ");
    let colon = marked.char_indices().find(|(_, letter)| {
        match letter {
            '(' | '[' | '<' => depth += 1,
            ')' | ']' | '>' => depth -= 1,
            _ => {}
        }
        *letter == ':' && depth == 0
    });
    let Some((colon, _)) = colon else {
        return false;
    };
    let mut kind = parameter[colon + 1..].trim();
    while let Some(inner) = kind.strip_prefix('&') {
        let lifetime = inner.starts_with('\'');
        kind = if lifetime {
            inner.split_once(' ').map_or("", |(_, kind)| kind)
        } else {
            inner
        };
        kind = kind.strip_prefix("mut ").unwrap_or(kind).trim();
    }
    let Some((members, _)) = kind.starts_with('(').then(|| bracketed(kind)).flatten() else {
        return false;
    };
    let members = parts(members);
    members.iter().any(|member| *member != members[0])
}

/// Names of the functions of a file with a tuple of unlike types as parameter.
fn functions(code: &str) -> Vec<String> {
    let code = code.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let lines = code
        .lines()
        .map(|line| line.split("//").next().unwrap().trim());
    let code = lines.collect::<Vec<_>>().join(" ");
    let mut found = Vec::new();
    for after in code.split(" fn ").skip(1) {
        let end = after.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
        let (name, mut rest) = after.split_at(end.unwrap_or(after.len()));
        if rest.starts_with('<') {
            rest = bracketed(rest).map_or("", |(_, after)| after);
        }
        let Some((list, _)) = rest.starts_with('(').then(|| bracketed(rest)).flatten() else {
            continue;
        };
        if parts(list)
            .iter()
            .any(|parameter| is_unlike_tuple(parameter))
        {
            found.push(name.to_owned());
        }
    }
    found
}

#[test]
fn a_tuple_of_unlike_types_is_found() {
    let code = "
pub fn one(a: (f64, usize)) {}
fn two<T: Fn(u8) -> u8>(
    (a, b): &mut (Vec<(f64, u8)>, &'a str), // a comment
) {}
fn pair(range: (f64, f64), names: &[(String, f64)]) -> (f64, u8) {}
fn closure(f: &dyn Fn((f64, u8)) -> f64) {}
";
    assert_eq!(functions(code), ["one", "two"]);
}

#[test]
fn few_functions_bundle_unlike_things_in_a_tuple() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut found) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let file = path.strip_prefix(&root).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if file.ends_with(".rs") && !file.contains("tests") {
                let names = functions(&fs::read_to_string(&path).unwrap());
                found.extend(names.into_iter().map(|name| format!("{file}: {name}")));
            }
        }
    }
    let names = found.join("\n");
    assert_eq!(
        found.len(),
        MAX_FUNCTIONS,
        "the number may only fall\n{names}"
    );
}
