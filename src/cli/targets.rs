//! The output files of a verb are checked: none overwrites an input, and no two have one name.

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::io::resolved_target;
use crate::scene::{Scene, TestSource};

use super::args::CorrelateArgs;

/// Files that would be written, each with the argument that names it.
pub type Targets = Vec<(&'static str, PathBuf)>;

/// The targets of arguments that were given.
pub fn targets<const N: usize>(given: [(&'static str, Option<&PathBuf>); N]) -> Targets {
    let given = given.into_iter();
    given
        .filter_map(|(argument, path)| Some((argument, path?.clone())))
        .collect()
}

/// Checks that no target is an input, by its canonical path, and that no two targets are one file.
pub fn check_targets(targets: &Targets, inputs: &[PathBuf]) -> Result<(), Error> {
    let canonical = |path: &PathBuf| path.canonicalize().ok();
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(canonical).collect();
    let refused = |argument, path: &Path, what: &str, expected: &str| {
        Err(Error::Argument {
            argument,
            got: format!("{}, which {what}", path.display()),
            expected: expected.to_owned(),
        })
    };
    for (number, (argument, path)) in targets.iter().enumerate() {
        if canonical(path).is_some_and(|target| inputs.contains(&target)) {
            return refused(
                *argument,
                path,
                "is read",
                "a name that is none of the inputs",
            );
        }
        let file = resolved_target(path);
        let is_same = |other: &Path| other == path || resolved_target(other) == file;
        if targets[..number].iter().any(|(_, other)| is_same(other)) {
            let expected = "another name";
            return refused(*argument, path, "gets another result", expected);
        }
    }
    Ok(())
}

/// The files behind a path that is read: those of a scene, else the path.
pub fn input_files(path: &Path) -> Vec<PathBuf> {
    match Scene::is_path(path).then(|| Scene::load(path)) {
        Some(Ok(scene)) => scene_files(&scene),
        // The verb reports a scene that cannot be loaded.
        _ => vec![path.to_owned()],
    }
}

/// The files that a scene names.
pub fn scene_files(scene: &Scene) -> Vec<PathBuf> {
    let mut all = vec![
        scene.file.clone(),
        scene.folder.join("expected.toml"),
        scene.folder.join("SOURCE.md"),
    ];
    let model = scene.model.as_ref().and_then(|table| table.file.as_ref());
    let others = scene.configurations.iter();
    let models = others.filter_map(|table| table.model.as_ref()).chain(model);
    all.extend(models.map(|file| scene.folder.join(file)));
    for test in &scene.tests {
        match &test.source {
            TestSource::Files { files, .. } => {
                all.extend(files.iter().map(|file| file.path.clone()))
            }
            TestSource::Synth(path) | TestSource::Modes(path) => all.push(path.clone()),
        }
    }
    all
}

/// `x-1.csv` of `x.csv`.
pub fn numbered_path(path: &Path, number: usize) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}."));
    name.push(path.extension().unwrap_or_default());
    path.with_file_name(name)
}

/// Checks the targets of `correlate`; `several`: the tables of several tests are a CSV file each.
pub fn check_correlate_targets(args: &CorrelateArgs, several: bool) -> Result<(), Error> {
    let mut all = targets([
        ("--expand", args.expand.as_ref()),
        ("--lines", args.lines.as_ref()),
    ]);
    if let Some(path) = &args.output {
        let csv = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
        match args.test.len() {
            count if csv && several && count > 1 => {
                all.extend((1..=count).map(|number| ("-o", numbered_path(path, number))));
            }
            _ => all.push(("-o", path.clone())),
        }
    }
    let read = args
        .test
        .iter()
        .chain(&args.theory)
        .flat_map(|input| input_files(input));
    let lists = args.dof_map.iter().chain(args.align.iter().flatten());
    let inputs: Vec<PathBuf> = read.chain(lists.cloned()).collect();
    check_targets(&all, &inputs)
}
