//! At Ctrl-C the program finishes the files that it is writing, then ends; at a panic it removes
//! them.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use crate::io::TEMPORARY_PREFIX;

use super::color::is_dumb;

/// The longest time that an interrupt waits for files that are being written, in hundredths of a
/// second.
const MAX_WAIT_HUNDREDTHS_S: u32 = 500;

/// The exit code of a panic, as the standard library has it.
const PANIC_EXIT_CODE: i32 = 101;

/// Held while files are written.
#[derive(Clone, Copy)]
pub struct Writing(&'static Shared);

/// The state that writer and handler share.
#[derive(Default)]
struct Shared {
    lock: Mutex<()>,
    folders_in_use: Mutex<OpenFolders>,
    /// Whether an interrupt is the regular end of the program.
    is_regular_end: AtomicBool,
}

/// Folders that are written into, each with the temporary files that were there before.
type OpenFolders = BTreeMap<PathBuf, BTreeSet<PathBuf>>;

impl Writing {
    /// Ends the program with exit code 2 at an interrupt or a request to end, though not within a
    /// stretch of writing, and with exit code 101 at a panic.
    pub fn guarded() -> Self {
        let shared: &'static Shared = Box::leak(Box::default());
        // A signal that is ignored, as `nohup` has it, stays so. Without a handler the system ends
        // the program at once.
        let _ = ctrlc::try_set_handler(move || end_program(shared));
        let print_message = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            print_message(panic);
            // The thread that panicked may hold the list itself; then no file has been begun.
            if let Ok(folders) = shared.folders_in_use.try_lock() {
                remove_unfinished(&folders);
            }
            std::process::exit(PANIC_EXIT_CODE);
        }));
        Self(shared)
    }

    /// Ends the program with exit code 0 at an interrupt, as a verb that would never end otherwise.
    pub fn end_regularly(self) {
        self.0.is_regular_end.store(true, Ordering::Relaxed);
    }

    /// Until the guard is dropped no interrupt ends the program, but one that has waited too long
    /// for these files.
    pub fn begin<'a>(self, targets: impl IntoIterator<Item = &'a Path>) -> MutexGuard<'static, ()> {
        let guard = self.0.lock.lock();
        let folders: BTreeSet<PathBuf> = targets.into_iter().map(folder_of).collect();
        let folders_in_use = folders
            .into_iter()
            .map(|folder| (temporary_files(&folder), folder));
        *self.0.folders_in_use() = folders_in_use
            .map(|(before, folder)| (folder, before))
            .collect();
        guard.unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shared {
    fn folders_in_use(&self) -> MutexGuard<'_, OpenFolders> {
        self.folders_in_use
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

fn folder_of(target: &Path) -> PathBuf {
    let folder = target.parent();
    let named = folder.filter(|parent| !parent.as_os_str().is_empty());
    named.unwrap_or(Path::new(".")).to_owned()
}

/// The files in a folder that are not whole yet.
fn temporary_files(folder: &Path) -> BTreeSet<PathBuf> {
    let is_temporary = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(TEMPORARY_PREFIX)
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.path())
        .filter(is_temporary)
        .collect()
}

/// Removes the temporary files that the writer will not finish.
fn remove_unfinished(folders_in_use: &OpenFolders) {
    for (folder, before) in folders_in_use {
        for path in temporary_files(folder).difference(before) {
            // The program ends: an error has no reader.
            let _ = std::fs::remove_file(path);
        }
    }
}

fn end_program(shared: &'static Shared) {
    let mut waited = 0;
    // Held to the end, so that no new file is begun.
    let guard = loop {
        match shared.lock.try_lock() {
            Err(TryLockError::WouldBlock) if waited < MAX_WAIT_HUNDREDTHS_S => {
                waited += 1;
                std::thread::sleep(Duration::from_millis(10));
            }
            other => break other,
        }
    };
    if shared.is_regular_end.load(Ordering::Relaxed) {
        std::process::exit(0);
    }
    let stderr = std::io::stderr();
    // In place of the progress that may stand there.
    let clear = if stderr.is_terminal() && !is_dumb() {
        "\r\u{1b}[2K"
    } else {
        ""
    };
    let word = "error: interrupted; every file that is there is whole";
    let _ = writeln!(&stderr, "{clear}{word}");
    if matches!(guard, Err(TryLockError::WouldBlock)) {
        remove_unfinished(&shared.folders_in_use());
    }
    std::process::exit(2);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names the folder to the process that panics.
    const PANICS_IN: &str = "MODALIGN_TEST_PANICS_IN";

    /// Runs alone in a separate process: the test below starts it.
    #[test]
    fn a_process_that_panics() {
        let Some(folder) = std::env::var_os(PANICS_IN) else {
            return;
        };
        let target = Path::new(&folder).join("result.json");
        let _guard = Writing::guarded().begin([target.as_path()]);
        std::fs::write(Path::new(&folder).join(".modalign-1"), "x").expect("the folder is there");
        panic!("on purpose");
    }

    #[test]
    fn a_panic_removes_what_is_unfinished_and_ends_the_program() {
        let place = tempfile::tempdir().expect("a folder of the test can be written");
        std::fs::write(place.path().join(".modalign-0"), "x").expect("the folder is there");
        let test = "cli::interrupt::tests::a_process_that_panics";
        let program = std::env::current_exe().expect("the test has a program");
        let ended = std::process::Command::new(program)
            .args(["--exact", test, "--nocapture"])
            .env(PANICS_IN, place.path())
            .output()
            .expect("the test can start itself");
        assert_eq!(ended.status.code(), Some(PANIC_EXIT_CODE));
        assert!(String::from_utf8_lossy(&ended.stderr).contains("on purpose"));
        let left = temporary_files(place.path());
        assert_eq!(left, BTreeSet::from([place.path().join(".modalign-0")]));
    }

    #[test]
    fn only_unfinished_files_are_removed() {
        let place = tempfile::tempdir().expect("a folder of the test can be written");
        let path = |name: &str| place.path().join(name);
        let name = |suffix: &str| format!("{TEMPORARY_PREFIX}{suffix}");
        std::fs::create_dir(path("out")).expect("a folder of the test can be written");
        for file in [name("another"), "result.json".to_owned()] {
            std::fs::write(path("out").join(file), "x")
                .expect("a folder of the test can be written");
        }
        let writing = Writing(Box::leak(Box::default()));
        let targets = [path("out/result.json"), path("new/figure.svg")];
        let _guard = writing.begin(targets.iter().map(PathBuf::as_path));
        std::fs::create_dir(path("new")).expect("a folder of the test can be written");
        for target in [
            "out/.modalign-1",
            "new/.modalign-2",
            "new/figure.svg",
            ".modalign-3",
        ] {
            std::fs::write(path(target), "x").expect("a folder of the test can be written");
        }
        remove_unfinished(&writing.0.folders_in_use());
        let left: Vec<bool> = ["out/.modalign-1", "new/.modalign-2"]
            .map(|temporary| path(temporary).exists())
            .into();
        assert_eq!(left, [false, false]);
        for kept in ["out/result.json", "new/figure.svg", ".modalign-3"] {
            assert!(path(kept).exists(), "{kept}");
        }
        assert!(path("out").join(name("another")).exists());
        assert_eq!(folder_of(Path::new("result.json")), Path::new("."));
    }
}
