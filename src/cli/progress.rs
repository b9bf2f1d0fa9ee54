//! A line on the terminal shows the current step and its time.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::scene::Observer;

use super::color::is_dumb;

/// Minimum time of work that shows its progress.
const MIN_SHOWN_TIME: Duration = Duration::from_millis(500);
const REDRAW_INTERVAL: Duration = Duration::from_millis(200);

/// Shows steps on standard error while it lives; nothing where that is no terminal, or one that
/// cannot draw in place.
pub struct Progress {
    shown: Option<(Sender<String>, JoinHandle<()>)>,
}

impl Progress {
    /// Begins with the name of the verb, unless the output is quiet.
    pub fn new(what: &str, quiet: bool) -> Self {
        let wanted = !quiet && std::io::stderr().is_terminal() && !is_dumb();
        Self {
            shown: wanted.then(|| start_drawing(what.to_owned())),
        }
    }
}

impl Observer for Progress {
    fn step(&self, what: &str, number: usize, count: usize) {
        if let Some((sender, _)) = &self.shown {
            // A progress line that is already gone is no failure.
            let _ = sender.send(line(what, number, count));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.shown.take() {
            drop(sender);
            let _ = thread.join();
        }
    }
}

fn line(what: &str, number: usize, count: usize) -> String {
    format!("[{number}/{count}] {what}")
}

fn start_drawing(first: String) -> (Sender<String>, JoinHandle<()>) {
    let (sender, receiver) = channel::<String>();
    let (begin, mut what) = (Instant::now(), first);
    let thread = std::thread::spawn(move || {
        let mut drawn = false;
        loop {
            match receiver.recv_timeout(REDRAW_INTERVAL) {
                Ok(next) => what = next,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if begin.elapsed() >= MIN_SHOWN_TIME {
                draw(&format!("{what}  {} s", begin.elapsed().as_secs()));
                drawn = true;
            }
        }
        if drawn {
            draw("");
        }
    });
    (sender, thread)
}

/// Puts a text in place of the last one.
fn draw(text: &str) {
    let mut stderr = std::io::stderr().lock();
    let _ = write!(stderr, "\r\u{1b}[2K{text}").and_then(|()| stderr.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_progress_step_shows_its_number() {
        assert_eq!(line("hammer", 1, 3), "[1/3] hammer");
    }
}
