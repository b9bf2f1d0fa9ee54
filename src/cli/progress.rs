//! A line on the terminal shows the current step, its share of the work and the time left.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::printable::printable_line;
use crate::scene::Observer;

use super::color::is_dumb;

const REDRAW_INTERVAL: Duration = Duration::from_millis(200);

/// The line before the first step is known, during it, and after it.
const TEMPLATES: [&str; 3] = [
    "{prefix}  {elapsed}",
    "{prefix}  [{pos}/{len}] {percent} %  {msg}  {elapsed}",
    "{prefix}  [{pos}/{len}] {percent} %  {msg}  {elapsed}, {eta} left",
];

/// Minimum number of steps whose mean time tells that of the others. Larger, at 50: a study of many
/// draws shows no time left. Smaller, at 3: a run of one test, whose last steps take no time, shows
/// a time that does not come. Test `time_left_is_shown_only_for_many_steps`.
const MIN_STEPS_OF_AN_ESTIMATE: usize = 10;
/// Finished steps from which the time left is shown.
const MIN_FINISHED_STEPS: usize = 3;

/// Shows steps on standard error while it lives; nothing where that is no terminal, or one that
/// cannot draw in place.
pub struct Progress {
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Begins with the name of the verb, unless the output is quiet.
    pub fn new(verb: &str, quiet: bool) -> Self {
        let wanted = !quiet && std::io::stderr().is_terminal() && !is_dumb();
        let bar = wanted.then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.set_style(style(TEMPLATES[0]));
            bar.set_prefix(verb.to_owned());
            bar.enable_steady_tick(REDRAW_INTERVAL);
            bar
        });
        Self { bar }
    }
}

impl Observer for Progress {
    fn step(&self, what: &str, number: usize, count: usize) {
        let Some(bar) = &self.bar else { return };
        // Before the length: a shorter one would be drawn with the position of the last step.
        bar.set_position(number.saturating_sub(1) as u64);
        if bar.length() != Some(count as u64) {
            bar.set_length(count as u64);
            bar.reset_eta();
        }
        bar.set_style(style(
            TEMPLATES[usize::from(shows_time_left(number, count)) + 1],
        ));
        bar.set_message(printable_line(what).into_owned());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Whether the finished steps tell the time left: steps of different work, as test and comparison
/// of a scene, tell none; of many alike the first ones do.
fn shows_time_left(number: usize, count: usize) -> bool {
    count >= MIN_STEPS_OF_AN_ESTIMATE && number > MIN_FINISHED_STEPS
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_is_shown_only_for_many_steps() {
        assert!(!shows_time_left(2, 3));
        assert!(!shows_time_left(7, 7));
        assert!(!shows_time_left(2, 40));
        assert!(shows_time_left(5, 40));
    }

    #[test]
    fn templates_are_valid() {
        for template in TEMPLATES {
            assert!(ProgressStyle::with_template(template).is_ok(), "{template}");
        }
    }
}
