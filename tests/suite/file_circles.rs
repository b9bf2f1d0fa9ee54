//! Imports between files: no file of a stage imports itself by way of others, and the rooms of
//! `identify` use only what the table in the head of `src/identify/mod.rs` allows.
//!
//! A file is a module; a name that a module re-exports counts as imported from the file that
//! defines it, so that the face of a folder is no detour. Tests are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Path of a module below the crate.
type Module = Vec<String>;

/// Imports of the files of a crate.
#[derive(Default)]
struct Imports {
    code: BTreeMap<Module, String>,
    /// Names that a module re-exports, with the path they stand for; `*` with the module.
    exports: BTreeMap<Module, Vec<(String, Module)>>,
    /// Paths that a module uses.
    paths: BTreeMap<Module, Vec<Module>>,
}

fn segments(path: &str) -> Module {
    let parts = path.split("::").map(|part| part.trim().to_owned());
    parts.filter(|part| !part.is_empty()).collect()
}

/// The code of a file without tests, comments and the content of strings.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let mut code = String::new();
    let mut skipped = false;
    for line in text.lines() {
        let line = line.split("//").next().unwrap();
        let import = ["use ", "pub use ", "mod ", "pub mod ", "pub(super) use "];
        if skipped
            && import
                .iter()
                .any(|word| line.trim_start().starts_with(word))
        {
            skipped = !line.contains(';');
            continue;
        }
        skipped = line.trim() == "#[cfg(test)]";
        for (index, part) in line.replace("\\\"", "").split('"').enumerate() {
            code.push_str(if index % 2 == 0 { part } else { "\"\"" });
        }
        code.push('\n');
    }
    code
}

/// The paths of a `use` tree, each with the name it gets.
fn paths_of_use(tree: &str) -> Vec<(Module, String)> {
    let tree = tree.trim();
    let Some((prefix, group)) = tree.split_once('{') else {
        let (path, name) = tree.split_once(" as ").unwrap_or((tree, ""));
        let path = segments(path);
        let name = match name.trim() {
            "" => path.last().cloned().unwrap_or_default(),
            name => name.to_owned(),
        };
        return vec![(path, name)];
    };
    let group = group.trim_end().strip_suffix('}').unwrap_or(group);
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&group[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&group[start..]);
    let mut found = Vec::new();
    for part in parts.into_iter().filter(|part| !part.trim().is_empty()) {
        for (path, name) in paths_of_use(part) {
            let mut whole = segments(prefix);
            let name = if path == ["self"] {
                whole.last().cloned().unwrap_or_default()
            } else {
                whole.extend(path);
                name
            };
            found.push((whole, name));
        }
    }
    found
}

impl Imports {
    fn new(files: &[(Module, String)]) -> Self {
        let mut imports = Self::default();
        for (module, text) in files {
            imports.code.insert(module.clone(), code(text));
        }
        for module in imports.code.keys().cloned().collect::<Vec<_>>() {
            imports.read(&module);
        }
        imports
    }

    /// Reads the imports and the paths in the code of one module.
    fn read(&mut self, module: &Module) {
        let code = &self.code[module];
        let (mut local, mut exports, mut paths) = (BTreeMap::new(), Vec::new(), Vec::new());
        let mut body = String::new();
        let mut left = code.as_str();
        while let Some(at) = left.find("use ") {
            let starts = left[..at].ends_with(['\n', ' ', ')']) || at == 0;
            let end = left[at..].find(';').map_or(left.len(), |end| at + end);
            let line = left[..at].rsplit('\n').next().unwrap_or("").trim();
            if !starts || !(line.is_empty() || line.starts_with("pub")) {
                body.push_str(&left[..at + 4]);
                left = &left[at + 4..];
                continue;
            }
            body.push_str(&left[..at]);
            for (path, name) in paths_of_use(&left[at + 4..end]) {
                let Some(path) = self.absolute(module, &path) else {
                    continue;
                };
                if line.starts_with("pub") {
                    exports.push((name.clone(), path.clone()));
                } else {
                    paths.push(path.clone());
                }
                local.insert(name, path);
            }
            left = &left[end..];
        }
        body.push_str(left);
        let word = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
        for path in body.split(|letter| !word(letter)) {
            let path = segments(path);
            if path.len() < 2 {
                continue;
            }
            if let Some(path) = self.absolute(module, &path) {
                paths.push(path);
            } else if let Some(first) = local.get(&path[0]).filter(|path| self.is_module(path)) {
                paths.push([&first[..], &path[1..]].concat());
            }
        }
        self.exports.insert(module.clone(), exports);
        self.paths.insert(module.clone(), paths);
    }

    fn is_module(&self, path: &[String]) -> bool {
        self.code.contains_key(path)
    }

    /// A path below the crate from one as a module writes it; `None` for another crate's.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Module> {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let base = match path.first()?.as_str() {
            "crate" => return Some(path[1..].to_vec()),
            "self" => return Some([module, &path[1..]].concat()),
            "super" => &module[..module.len().saturating_sub(supers)],
            first => {
                let child = [module, &[first.to_owned()]].concat();
                self.is_module(&child).then_some(module)?
            }
        };
        Some([base, &path[supers..]].concat())
    }

    /// The file that defines the item of a path; `None` for a module itself, whose items count
    /// where they are used.
    fn definition(&self, path: &[String], seen: &mut Vec<Module>) -> Option<Module> {
        if seen.iter().any(|before| before == path) {
            return None;
        }
        seen.push(path.to_vec());
        let length = (1..=path.len()).rev();
        let length = length.into_iter().find(|n| self.is_module(&path[..*n]))?;
        let (module, item) = path.split_at(length);
        let name = item.first()?;
        for (exported, target) in self.exports.get(module).into_iter().flatten() {
            if exported == name {
                return self.definition(&[target, &item[1..]].concat(), seen);
            }
            if exported == "*" {
                let inside = &target[..target.len() - 1];
                let kinds = ["fn", "struct", "enum", "trait", "const", "type"];
                let code = self.code.get(inside);
                let defines =
                    |kind| code.is_some_and(|code| code.contains(&format!("{kind} {name}")));
                if kinds.into_iter().any(defines) {
                    return Some(inside.to_vec());
                }
            }
        }
        Some(module.to_vec())
    }

    /// The files of the same stage that each file uses.
    fn arrows(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let mut arrows = BTreeMap::new();
        for (module, paths) in &self.paths {
            let targets = paths.iter();
            let targets = targets.filter_map(|path| self.definition(path, &mut Vec::new()));
            let targets = targets.filter(|target| target[0] == module[0] && target != module);
            arrows.insert(module.clone(), targets.collect());
        }
        arrows
    }
}

/// Sets of files that reach each other.
fn circles(arrows: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<Vec<Module>> {
    let reached = |start: &Module| {
        let (mut found, mut open) = (BTreeSet::new(), vec![start]);
        while let Some(next) = open.pop() {
            for target in arrows.get(next).into_iter().flatten() {
                if found.insert(target) {
                    open.push(target);
                }
            }
        }
        found
    };
    let reach: BTreeMap<_, _> = arrows.keys().map(|file| (file, reached(file))).collect();
    let mut found: Vec<Vec<Module>> = Vec::new();
    for (file, targets) in &reach {
        let placed = found.iter().any(|circle| circle.contains(file));
        if placed || !targets.contains(file) {
            continue;
        }
        let circle = targets.iter().filter(|other| reach[*other].contains(file));
        found.push(circle.map(|file| (*file).clone()).collect());
    }
    found
}

/// Every file of `src` but the program and the crate's face, with its module.
fn sources() -> Vec<(Module, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut found) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let below = path.strip_prefix(&root).unwrap().with_extension("");
            let parts = below.iter().map(|part| part.to_string_lossy().into_owned());
            let mut module: Module = parts.collect();
            let test = module.iter().any(|part| part.ends_with("tests"));
            if path.extension().is_some_and(|kind| kind == "rs") && !test {
                module.retain(|part| part != "mod");
                found.push((module, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.retain(|(module, _)| !["lib", "main", "numerics"].contains(&module[0].as_str()));
    assert!(found.len() > 300, "the source tree was found");
    found
}

#[test]
fn files_of_a_stage_form_no_circle() {
    let found = circles(&Imports::new(&sources()).arrows());
    let names = |circle: &Vec<Module>| circle.iter().map(|file| file.join("/")).collect::<Vec<_>>();
    let names: Vec<_> = found.iter().map(|circle| names(circle).join(" ")).collect();
    assert!(names.is_empty(), "\n{}", names.join("\n"));
}

/// Rows `| room | what it holds | rooms it may use |` in the head of `identify`.
fn rooms() -> BTreeMap<String, Vec<String>> {
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/identify/mod.rs");
    let head = fs::read_to_string(head).unwrap();
    // Cells of a row: the room, what it holds, what it may use.
    let cells = |line: &str| line.split('|').map(str::trim).map(str::to_owned).collect();
    let rows = head.lines().filter(|line| line.starts_with("//! | `"));
    let rows: Vec<Vec<String>> = rows
        .map(cells)
        .filter(|row: &Vec<_>| row.len() == 5)
        .collect();
    let words = |text: &str| {
        text.replace('`', "")
            .split(' ')
            .map(str::to_owned)
            .collect()
    };
    let table: BTreeMap<_, Vec<String>> = rows
        .iter()
        .map(|row| (row[1].replace('`', ""), words(&row[3])))
        .collect();
    assert!(table.len() >= 8, "the table of rooms was read: {table:?}");
    table
}

#[test]
fn rooms_of_identify_use_only_what_the_table_allows() {
    let table = rooms();
    let mut found = Vec::new();
    for (file, targets) in Imports::new(&sources()).arrows() {
        for target in targets.iter().filter(|_| file[0] == "identify") {
            let (Some(room), Some(used)) = (file.get(1), target.get(1)) else {
                continue;
            };
            let Some(may_use) = table.get(room).filter(|_| table.contains_key(used)) else {
                continue;
            };
            if room != used && !may_use.contains(used) {
                found.push(format!(
                    "{} -> {}",
                    file[1..].join("/"),
                    target[1..].join("/")
                ));
            }
        }
    }
    assert!(found.is_empty(), "against the table: {found:?}");
}

#[test]
fn circles_are_found_through_re_exports_groups_and_bare_paths() {
    let file = |module: &str, text: &str| (segments(module), text.to_owned());
    let files = [
        file(
            "stage",
            "mod a;\nmod b;\nmod c;\npub use a::{First, Second as Other};",
        ),
        file(
            "stage::a",
            "use super::b::{self, Third};\npub struct First(Third);",
        ),
        file(
            "stage::b",
            "pub struct Third;\nfn f() { crate::stage::c::g() }",
        ),
        file("stage::c", "use crate::stage::First;\npub fn g() {}"),
        file(
            "stage::d",
            "// use super::a::First;\nfn f() { super::a::h(\"crate::stage::d::f\") }",
        ),
    ];
    let found = circles(&Imports::new(&files).arrows());
    let expected = ["stage::a", "stage::b", "stage::c"].map(segments).to_vec();
    assert_eq!(found, [expected]);
    let without = [&files[..3], &files[4..]].concat();
    assert!(circles(&Imports::new(&without).arrows()).is_empty());
}
