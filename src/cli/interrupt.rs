//! At Ctrl-C the program finishes the files that it is writing, then ends; at a panic it removes
//! them.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use crate::io::remove_unfinished;

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
    /// Whether an interrupt is the regular end of the program.
    is_regular_end: AtomicBool,
}

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
            remove_unfinished();
            std::process::exit(PANIC_EXIT_CODE);
        }));
        Self(shared)
    }

    /// Ends the program with exit code 0 at an interrupt, as a verb that would never end otherwise.
    pub fn end_regularly(self) {
        self.0.is_regular_end.store(true, Ordering::Relaxed);
    }

    /// Until the guard is dropped no interrupt ends the program, but one that has waited too long
    /// for the files.
    pub fn begin(self) -> MutexGuard<'static, ()> {
        self.0.lock.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Makes a file that exceeds the limit of its length (`ulimit -f`) an error of writing; without a
/// handler the system ends the program.
pub fn report_files_that_are_too_long() {
    // Where the signal cannot be handled, the program ends as any other does.
    #[cfg(unix)]
    let _ = {
        let is_received = std::sync::Arc::new(AtomicBool::default());
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, is_received)
    };
}

fn end_program(shared: &'static Shared) {
    let mut waited = 0;
    // Held to the end, so that no new file is begun.
    let _guard = loop {
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
    let word = "error: interrupted; the result is not written, and files that were written before are whole";
    let _ = writeln!(&stderr, "{clear}{word}");
    remove_unfinished();
    std::process::exit(2);
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::io::write_atomically;

    /// Names the folder to the process that panics.
    const PANICS_IN: &str = "MODALIGN_TEST_PANICS_IN";

    /// Runs alone in a separate process: the test below starts it.
    #[test]
    fn a_process_that_panics() {
        let Some(folder) = std::env::var_os(PANICS_IN) else {
            return;
        };
        let _guard = Writing::guarded().begin();
        let target = Path::new(&folder).join("new/result.json");
        let _ = write_atomically(&target, |out| {
            out.write_all(b"x").expect("the file can be written");
            panic!("on purpose");
        });
    }

    #[test]
    fn a_panic_removes_what_is_unfinished_and_ends_the_program() {
        let place = tempfile::tempdir().expect("a folder of the test can be written");
        let test = "cli::interrupt::tests::a_process_that_panics";
        let program = std::env::current_exe().expect("the test has a program");
        let ended = std::process::Command::new(program)
            .args(["--exact", test, "--nocapture"])
            .env(PANICS_IN, place.path())
            .output()
            .expect("the test can start itself");
        assert_eq!(ended.status.code(), Some(PANIC_EXIT_CODE));
        assert!(String::from_utf8_lossy(&ended.stderr).contains("on purpose"));
        let left = std::fs::read_dir(place.path()).expect("the folder is there");
        assert_eq!(left.count(), 0);
    }
}
