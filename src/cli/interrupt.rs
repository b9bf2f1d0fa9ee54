//! Ctrl-C: what is being written is finished, then the program ends.

use std::io::{IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;

use super::color::is_dumb;

/// The longest time that an interrupt waits for files that are being written, in hundredths of a second.
const PATIENCE: u32 = 500;

/// Held while files are written.
#[derive(Clone, Copy)]
pub struct Writing(&'static Mutex<()>);

impl Writing {
    /// Ends the program with exit code 2 at an interrupt or a request to end, though not within a stretch of writing.
    pub fn guarded() -> Self {
        let lock: &'static Mutex<()> = Box::leak(Box::new(Mutex::new(())));
        // A signal that is ignored, as `nohup` has it, stays so. Without a handler the system ends the program at once.
        let _ = ctrlc::try_set_handler(move || end(lock));
        Self(lock)
    }

    /// Until the guard is dropped no interrupt ends the program.
    pub fn begin(self) -> MutexGuard<'static, ()> {
        self.0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

fn end(lock: &'static Mutex<()>) {
    let mut waited = 0;
    // Held to the end: nothing new is begun.
    let _guard = loop {
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) if waited < PATIENCE => {
                waited += 1;
                std::thread::sleep(Duration::from_millis(10));
            }
            other => break other,
        }
    };
    let stderr = std::io::stderr();
    // In place of the progress that may stand there.
    let clear = if stderr.is_terminal() && !is_dumb() {
        "\r\u{1b}[2K"
    } else {
        ""
    };
    let word = "error: interrupted; every file that is there is whole";
    let _ = writeln!(&stderr, "{clear}{word}");
    std::process::exit(2);
}
