//! Standard output carries only the result, standard error the findings.

use std::collections::BTreeSet;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::MutexGuard;

use crate::error::Error;
use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::Geometry;
use crate::io::{
    IoError, ResultFile, ResultsFolder, WriteOptions, bytes_for_path, forget_result, modes_source,
    open_file_number, resolved_target, write_all_whole,
};
use crate::modal::ModalModel;
use crate::printable::{printable_json, printable_message};
use crate::report::{Block, Language, Renderer, Terminal, abridged, png_lacks_letters, wrapping};
use crate::scene::Observer;

use super::args::Global;
use super::color::{self, ColorChoice};
use super::finding_lines::{all_lines, screen_lines};
use super::interrupt::Writing;
use super::progress::Progress;
use super::wrapping::{DEFAULT_WIDTH, error_width, output_width};

/// Extensions of the formats that hold modes.
pub const MODES_EXTENSIONS: &[&str] = &[
    "json", "csv", "uff", "unv", "ufb", "h5", "hdf5", "mat", "npz",
];

/// Extensions of the formats that hold FRFs.
pub const FRF_EXTENSIONS: &[&str] = &["uff", "unv", "ufb", "h5", "hdf5", "mat", "npz", "csv"];

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

/// Checks that the extension of an output file is one of the expected ones.
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

/// Number of standard output among the open files of a program.
const STANDARD_OUTPUT: u32 = 1;
/// Number of standard error.
const STANDARD_ERROR: u32 = 2;

/// Characters in a line of the screen.
fn screen_width() -> usize {
    output_width().unwrap_or(DEFAULT_WIDTH)
}

/// Collects the texts and files of a verb, which are printed and written only when it has
/// succeeded.
pub struct Output {
    quiet: bool,
    json: bool,
    full: bool,
    language: Language,
    color: ColorChoice,
    progress: Option<Progress>,
    writing: Writing,
    result: String,
    files: Vec<(PathBuf, Vec<u8>)>,
    results: Option<Results>,
    findings: Vec<(String, Finding)>,
}

/// The files of a folder of results.
struct Results {
    folder: ResultsFolder,
    files: Vec<ResultFile>,
    /// The verb whose earlier files go.
    replaced_verb: Option<&'static str>,
}

impl Output {
    /// An empty output; the progress of the verb is shown until it ends.
    pub fn new(global: &Global, verb: &str) -> Self {
        Self {
            quiet: global.quiet,
            json: global.json,
            full: global.full,
            language: global.lang,
            color: global.color,
            progress: Some(Progress::new(verb, global.quiet)),
            writing: Writing::guarded(),
            result: String::new(),
            files: Vec::new(),
            results: None,
            findings: Vec::new(),
        }
    }

    /// The language of tables.
    pub fn language(&self) -> Language {
        self.language
    }

    /// Adds blocks to the result, as many as a screen has room for, or all with `--full`; none
    /// where JSON is wanted.
    pub fn add_blocks(&mut self, blocks: Vec<Block>) {
        if !self.json {
            let shown = match self.full {
                true => blocks,
                false => abridged(blocks, screen_width()),
            };
            self.print(self.language.translated(shown));
        }
    }

    /// Adds blocks that are in the wanted language.
    fn print(&mut self, blocks: Vec<Block>) {
        if !blocks.is_empty() {
            let width = (!self.full).then(screen_width);
            let text = Terminal { width }.render(&blocks);
            if self.color.is_enabled_on(&std::io::stdout()) {
                self.add_text(&color::color_result(&text));
            } else {
                self.add_text(&text);
            }
        }
    }

    /// Adds the blocks of the screen, which depend on its width, or with `--full` all blocks; none
    /// where JSON is wanted.
    pub fn add_result(
        &mut self,
        screen: impl FnOnce(usize) -> Vec<Block>,
        full: impl FnOnce() -> Vec<Block>,
    ) {
        self.add_formatted_result(screen, full, |blocks| blocks);
    }

    /// As [`Output::add_result`], with a format that applies to the translated blocks.
    pub fn add_formatted_result(
        &mut self,
        screen: impl FnOnce(usize) -> Vec<Block>,
        full: impl FnOnce() -> Vec<Block>,
        format: impl FnOnce(Vec<Block>) -> Vec<Block>,
    ) {
        if self.json {
            return;
        }
        let blocks = match self.full {
            true => full(),
            false => screen(screen_width()),
        };
        self.print(format(self.language.translated(blocks)));
    }

    /// Says on the screen where the rest of the result is.
    pub fn add_rest_note(&mut self, note: &str) {
        self.add_closing(Vec::new(), Some(note));
    }

    /// Says on the screen of a study where the rest of its result is. `files`: the option that
    /// writes files, where it was not given.
    pub fn add_rest_of_study(&mut self, rest: &str, files: Option<&str>) {
        match files {
            None => self.add_rest_note(rest),
            Some(files) => self.add_rest_note(&format!("{rest} {files}")),
        }
    }

    /// Ends the result with the next step, and where the screen does not show all of it, with where
    /// the rest is.
    pub fn add_closing(&mut self, mut next: Vec<String>, rest: Option<&str>) {
        next.extend(rest.filter(|_| !self.full).map(str::to_owned));
        if !next.is_empty() && !self.json {
            let lines = vec![Block::Text(next.join("\n"))];
            self.print(self.language.translated(lines));
        }
    }

    /// The receiver of the progress of the work.
    pub fn observer(&self) -> &dyn Observer {
        self.progress.as_ref().map_or(&(), |progress| progress)
    }

    /// A guard that delays an interrupt while files are written.
    pub fn guard_writing(&self) -> MutexGuard<'static, ()> {
        self.writing.begin()
    }

    /// Ends the progress line.
    pub fn end_progress(&mut self) {
        self.progress = None;
    }

    /// Whether everything is wanted on the screen.
    pub fn wants_all(&self) -> bool {
        self.full
    }

    /// Whether the result is wanted as JSON.
    pub fn wants_json(&self) -> bool {
        self.json
    }

    /// Adds JSON to the result, when it is wanted.
    pub fn add_json(&mut self, text: impl FnOnce() -> String) {
        if self.json {
            self.add_text(&printable_json(text()));
        }
    }

    /// Adds text to the result.
    pub fn add_text(&mut self, text: &str) {
        if !self.result.is_empty() {
            self.result.push('\n');
        }
        self.result.push_str(text);
        if !text.ends_with('\n') {
            self.result.push('\n');
        }
    }

    /// Adds a file: all of them are written at the end, or none.
    pub fn add_file(&mut self, path: impl Into<PathBuf>, content: impl Into<Vec<u8>>) {
        self.files.push((path.into(), content.into()));
    }

    /// Opens the folder of the results, which no other command may write into until the end. Files
    /// of an earlier run of `replaced_verb` are removed if they are not written again.
    ///
    /// # Errors
    /// As [`ResultsFolder::open`].
    pub fn open_results(
        &mut self,
        folder: &Path,
        replaced_verb: Option<&'static str>,
    ) -> Result<(), IoError> {
        self.results = Some(Results {
            folder: ResultsFolder::open(folder)?,
            files: Vec::new(),
            replaced_verb,
        });
        Ok(())
    }

    /// Whether the folder of the results has a manifest.
    pub fn has_manifest(&self) -> bool {
        let results = self.results.as_ref();
        results.is_some_and(|results| results.folder.has_manifest())
    }

    /// Whether the manifest of the results names this file.
    pub fn names_result(&self, name: &str) -> bool {
        let results = self.results.as_ref();
        results.is_some_and(|results| results.folder.names(name))
    }

    /// Adds files of the folder of the results that `verb` makes.
    pub fn add_results(&mut self, verb: &'static str, files: Vec<(String, Vec<u8>)>) {
        let file = |(name, bytes)| ResultFile { name, bytes, verb };
        if let Some(results) = &mut self.results {
            results.files.extend(files.into_iter().map(file));
        }
    }

    /// Adds modes in the format of the path's extension, with findings on lost content.
    ///
    /// # Errors
    /// As [`modes_file`].
    pub fn add_modes(
        &mut self,
        path: &Path,
        model: &ModalModel,
        geometry: &Geometry,
        json: &str,
    ) -> Result<(), IoError> {
        let (bytes, lost) = modes_file(path, model, geometry, json)?;
        self.add_findings(&lost);
        self.add_file(path, bytes);
        Ok(())
    }

    /// Adds findings for standard error.
    pub fn add_findings(&mut self, findings: &[Finding]) {
        self.add_findings_of("", findings);
    }

    /// Adds findings that belong to one of several tests, by name.
    pub fn add_findings_of(&mut self, test: &str, findings: &[Finding]) {
        let named = findings
            .iter()
            .map(|finding| (test.to_owned(), finding.clone()));
        self.findings.extend(named);
    }

    /// Makes an interrupt the regular end of a verb that watches.
    pub fn end_regularly_at_interrupt(&self) {
        self.writing.end_regularly();
    }

    /// Prints the result so far at once and forgets it; on a terminal in place of what was there.
    ///
    /// # Errors
    /// [`Error::Output`] when standard output cannot be written.
    pub fn show(&mut self) -> Result<(), Error> {
        let mut stdout = std::io::stdout().lock();
        let clear = match stdout.is_terminal() && !color::is_dumb() && !self.json {
            true => "\u{1b}[2J\u{1b}[H",
            false => "",
        };
        let text = std::mem::take(&mut self.result);
        let end = if self.json { "" } else { "\n" };
        write!(stdout, "{clear}{text}{end}")
            .and_then(|()| stdout.flush())
            .map_err(Error::Output)
    }

    /// Writes the files, prints the result, then the findings, these also where standard output
    /// cannot be written.
    ///
    /// # Errors
    /// [`Error::Io`] when a file cannot be written, [`Error::Output`] when standard output cannot.
    pub fn finish(mut self) -> Result<(), Error> {
        self.end_progress();
        let boxed = letters_lacking_findings(&self.written_files());
        self.add_findings(&boxed);
        let streams: Vec<(PathBuf, Vec<u8>)>;
        {
            let _writing = self.guard_writing();
            let mut files = std::mem::take(&mut self.files);
            (streams, files) = files
                .into_iter()
                .partition(|(path, _)| is_standard_stream(path));
            write_all_whole(&files)?;
            for (path, _) in &files {
                forget_result(&resolved_target(path))?;
            }
            if let Some(results) = self.results.take().filter(|one| !one.files.is_empty()) {
                results
                    .folder
                    .write(&results.files, results.replaced_verb)?;
            }
        }
        let mut stdout = std::io::stdout().lock();
        let written = streams
            .iter()
            .try_for_each(|(path, bytes)| match open_file_number(path) {
                Some(STANDARD_ERROR) => std::io::stderr().write_all(bytes),
                _ => stdout.write_all(bytes),
            });
        let printed = written
            .and_then(|()| stdout.write_all(self.result.as_bytes()))
            .and_then(|()| stdout.flush());
        if !self.quiet {
            let stderr = std::io::stderr();
            let paints = self.color.is_enabled_on(&stderr);
            let width = error_width();
            let lines = if self.full {
                all_lines(&self.findings, self.language)
            } else {
                screen_lines(&self.findings, self.language)
            };
            for line in lines {
                let line = printable_message(&line).into_owned();
                let line = if paints {
                    color::color_message(&line)
                } else {
                    line
                };
                // A terminal breaks long lines within words.
                let line = match width {
                    Some(width) => textwrap::fill(&line, wrapping(width).subsequent_indent("  ")),
                    None => line,
                };
                // A closed standard error is no failure.
                let _ = writeln!(std::io::stderr(), "{line}");
            }
        }
        printed.map_err(Error::Output)
    }
}

impl Output {
    /// All files that will be written.
    fn written_files(&self) -> Vec<(PathBuf, &[u8])> {
        let single = self.files.iter();
        let single = single.map(|(path, bytes)| (path.clone(), bytes.as_slice()));
        let results = self.results.iter().flat_map(|results| {
            let path = |file: &ResultFile| results.folder.path().join(&file.name);
            let files = results.files.iter();
            files.map(move |file| (path(file), file.bytes.as_slice()))
        });
        single.chain(results).collect()
    }
}

/// Whether a file is standard output or standard error, which have a position that other outputs
/// of the program move.
fn is_standard_stream(path: &Path) -> bool {
    let number = open_file_number(path);
    matches!(number, Some(STANDARD_OUTPUT | STANDARD_ERROR))
}

/// Findings on PNG figures that lack letters, as their SVG shows.
fn letters_lacking_findings(files: &[(PathBuf, &[u8])]) -> Vec<Finding> {
    let is = |path: &Path, kind: &str| path.extension().is_some_and(|extension| extension == kind);
    let pngs = files.iter().filter(|(path, _)| is(path, "png"));
    let pngs: BTreeSet<PathBuf> = pngs.map(|(path, _)| path.with_extension("svg")).collect();
    let drawn = files.iter().filter(|(path, _)| pngs.contains(path));
    let lacks = |bytes: &[u8]| std::str::from_utf8(bytes).is_ok_and(png_lacks_letters);
    let finding = |path: &Path| {
        let path = path.with_extension("png").display().to_string();
        let (line, byte) = (None, None);
        let location = Location::File { path, line, byte };
        Finding::new(Severity::Warning, Code::LettersLacking, location)
    };
    drawn
        .filter(|(_, bytes)| lacks(bytes))
        .map(|(path, _)| finding(path))
        .collect()
}
