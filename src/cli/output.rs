//! Standard output carries the result alone, standard error the findings.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::MutexGuard;

use crate::error::Error;
use crate::finding::{Code, Finding, Place, Severity};
use crate::geometry::Geometry;
use crate::io::{IoError, WriteOptions, bytes_for_path, modes_source, write_all_whole};
use crate::modal::ModalModel;
use crate::report::{Block, Language, Renderer, Terminal, png_lacks_letters};
use crate::scene::Observer;

use super::args::Global;
use super::color::{self, ColorChoice};
use super::interrupt::Writing;
use super::progress::Progress;

/// More findings of one code than this are counted instead of listed.
const LISTED_PER_CODE: usize = 5;

/// Extensions of the formats that hold modes.
pub const MODES: &[&str] = &[
    "json", "csv", "uff", "unv", "ufb", "h5", "hdf5", "mat", "npz",
];

/// Extensions of the formats that hold FRFs.
pub const FUNCTIONS: &[&str] = &["uff", "unv", "ufb", "h5", "hdf5", "mat", "npz", "csv"];

/// The file of modes in the format of the path's extension: `modes.json` as given, any other from
/// the model.
///
/// # Errors
/// As [`bytes_for_path`].
pub fn modes_file(
    path: &Path,
    model: &ModalModel,
    geometry: &Geometry,
    json: &str,
) -> Result<(Vec<u8>, Vec<Finding>), IoError> {
    if path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
    {
        return Ok((json.as_bytes().to_vec(), Vec::new()));
    }
    let mut source = modes_source(model, &model.producer);
    source.catalog.geometry = geometry.clone();
    bytes_for_path(path, &mut source, WriteOptions::default())
}

/// An output file's extension must be that of what will be written.
pub fn check_extension(path: Option<&Path>, expected: &[&str]) -> Result<(), Error> {
    let Some(path) = path else { return Ok(()) };
    let extension = path
        .extension()
        .and_then(|extension| extension.to_str())
        .unwrap_or("");
    if expected.contains(&extension.to_lowercase().as_str()) {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "-o",
        got: path.display().to_string(),
        expected: format!("a file name ending in .{}", expected.join(" or .")),
    })
}

/// Collects what a verb prints and writes, so that nothing is printed and no file comes before it
/// has succeeded.
pub struct Output {
    quiet: bool,
    json: bool,
    language: Language,
    color: ColorChoice,
    progress: Option<Progress>,
    writing: Writing,
    result: String,
    files: Vec<(PathBuf, Vec<u8>)>,
    findings: Vec<(String, Finding)>,
}

impl Output {
    /// Nothing printed yet; the progress of the verb is shown until it ends.
    pub fn new(global: &Global, verb: &str) -> Self {
        Self {
            quiet: global.quiet,
            json: global.json,
            language: global.lang,
            color: global.color,
            progress: Some(Progress::new(verb, global.quiet)),
            writing: Writing::guarded(),
            result: String::new(),
            files: Vec::new(),
            findings: Vec::new(),
        }
    }

    /// The language of tables.
    pub fn language(&self) -> Language {
        self.language
    }

    /// Adds blocks to the result in the wanted language, unless JSON is wanted.
    pub fn blocks(&mut self, blocks: &[Block]) {
        self.translated(&self.language.translated(blocks.to_vec()));
    }

    /// Adds blocks that are in the wanted language already.
    pub fn translated(&mut self, blocks: &[Block]) {
        if !self.json {
            let text = Terminal.render(blocks);
            if self.color.paints(&std::io::stdout()) {
                self.text(&color::result(&text));
            } else {
                self.text(&text);
            }
        }
    }

    /// The receiver of the progress of the work.
    pub fn observer(&self) -> &dyn Observer {
        self.progress.as_ref().map_or(&(), |progress| progress)
    }

    /// Until the guard is dropped, while these files are written, an interrupt waits.
    pub fn writing<'a>(
        &self,
        targets: impl IntoIterator<Item = &'a Path>,
    ) -> MutexGuard<'static, ()> {
        self.writing.begin(targets)
    }

    /// Ends what is shown of the progress.
    pub fn end_progress(&mut self) {
        self.progress = None;
    }

    /// Whether the result is wanted as JSON.
    pub fn wants_json(&self) -> bool {
        self.json
    }

    /// Adds JSON to the result, when it is wanted.
    pub fn json(&mut self, text: impl FnOnce() -> String) {
        if self.json {
            self.text(&text());
        }
    }

    /// Adds text to the result.
    pub fn text(&mut self, text: &str) {
        if !self.result.is_empty() {
            self.result.push('\n');
        }
        self.result.push_str(text);
        if !text.ends_with('\n') {
            self.result.push('\n');
        }
    }

    /// Adds a file: all of them are written at the end, or none.
    pub fn file(&mut self, path: impl Into<PathBuf>, content: impl Into<Vec<u8>>) {
        self.files.push((path.into(), content.into()));
    }

    /// Adds modes in the format of the path's extension, and what that cannot hold as findings.
    ///
    /// # Errors
    /// As [`modes_file`].
    pub fn modes(
        &mut self,
        path: &Path,
        model: &ModalModel,
        geometry: &Geometry,
        json: &str,
    ) -> Result<(), IoError> {
        let (bytes, lost) = modes_file(path, model, geometry, json)?;
        self.findings(&lost);
        self.file(path, bytes);
        Ok(())
    }

    /// Adds findings for standard error.
    pub fn findings(&mut self, findings: &[Finding]) {
        self.findings_of("", findings);
    }

    /// Adds findings that belong to one of several tests, by name.
    pub fn findings_of(&mut self, test: &str, findings: &[Finding]) {
        let named = findings
            .iter()
            .map(|finding| (test.to_owned(), finding.clone()));
        self.findings.extend(named);
    }

    /// Writes the files, prints the result, then the findings.
    ///
    /// # Errors
    /// [`Error::Io`] when a file cannot be written, [`Error::Output`] when standard output cannot.
    pub fn finish(mut self) -> Result<(), Error> {
        self.end_progress();
        let boxed = lacking_letters(&self.files);
        self.findings(&boxed);
        if !self.files.is_empty() {
            let _writing = self.writing(self.files.iter().map(|(path, _)| path.as_path()));
            write_all_whole(&self.files)?;
        }
        let mut stdout = std::io::stdout().lock();
        stdout
            .write_all(self.result.as_bytes())
            .and_then(|()| stdout.flush())
            .map_err(Error::Output)?;
        if !self.quiet {
            let paints = self.color.paints(&std::io::stderr());
            for line in finding_lines(&self.findings, self.language) {
                let line = if paints { color::message(&line) } else { line };
                // A closed standard error is no failure.
                let _ = writeln!(std::io::stderr(), "{line}");
            }
        }
        Ok(())
    }
}

/// The figures whose PNG shows boxes, by the SVG beside each.
fn lacking_letters(files: &[(PathBuf, Vec<u8>)]) -> Vec<Finding> {
    let is = |path: &Path, kind: &str| path.extension().is_some_and(|extension| extension == kind);
    let pngs = files.iter().filter(|(path, _)| is(path, "png"));
    let pngs: BTreeSet<PathBuf> = pngs.map(|(path, _)| path.with_extension("svg")).collect();
    let drawn = files.iter().filter(|(path, _)| pngs.contains(path));
    let lacks = |bytes: &[u8]| std::str::from_utf8(bytes).is_ok_and(png_lacks_letters);
    let finding = |path: &Path| {
        let path = path.with_extension("png").display().to_string();
        let (line, byte) = (None, None);
        let place = Place::File { path, line, byte };
        Finding::new(Severity::Warning, Code::LettersLacking, place)
    };
    drawn
        .filter(|(_, bytes)| lacks(bytes))
        .map(|(path, _)| finding(path))
        .collect()
}

/// Findings as lines, each once; of a code with many the first are listed and the rest counted.
fn finding_lines(findings: &[(String, Finding)], language: Language) -> Vec<String> {
    let mut by_code: BTreeMap<(std::cmp::Reverse<Severity>, Code), Vec<String>> = BTreeMap::new();
    let mut known = BTreeSet::new();
    for (test, finding) in findings {
        let lines = by_code
            .entry((std::cmp::Reverse(finding.severity), finding.code))
            .or_default();
        let name = if test.is_empty() {
            String::new()
        } else {
            format!("{test}: ")
        };
        let severity = language.severity(finding.severity);
        let (sentence, code) = (language.finding(finding), finding.code.name());
        let line = format!("{severity}: {name}{sentence} [{code}]");
        if known.insert(line.clone()) {
            lines.push(line);
        }
    }
    let mut lines = Vec::new();
    for ((severity, code), all) in by_code {
        let listed = if all.len() > LISTED_PER_CODE + 1 {
            LISTED_PER_CODE
        } else {
            all.len()
        };
        lines.extend_from_slice(&all[..listed]);
        if listed < all.len() {
            let (severity, code) = (language.severity(severity.0), code.name());
            let count = all.len() - listed;
            lines.push(match language {
                Language::English => format!("{severity}: {count} more like these [{code}]"),
                Language::Chinese => format!("{severity}: 另有 {count} 条同类 [{code}]"),
            });
        }
    }
    lines
}
