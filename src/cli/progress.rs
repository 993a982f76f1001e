//! Progress bars on standard error, if it is a terminal.

use crate::progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shorter tasks have no bar.
const SHOWN_AFTER: Duration = Duration::from_secs(1);

/// Shows the library's tasks that take longer than [`SHOWN_AFTER`].
pub(super) fn show_tasks() {
    if !std::io::stderr().is_terminal() {
        return;
    }
    let shown = Mutex::new(CurrentTask::default());
    progress::watch(move |what, done, total| shown.lock().unwrap_or_else(PoisonError::into_inner).update(what, done, total));
}

/// A bar for a known number of steps, such as pictures.
pub(super) fn steps(count: u32, what: &'static str) -> ProgressBar {
    ProgressBar::new(count.into()).with_style(style("{msg} {bar:40} {pos}/{len} {elapsed} (about {eta} left)")).with_message(what)
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is valid")
}

/// The current task: its name, start time, and bar if shown.
#[derive(Default)]
struct CurrentTask {
    what: String,
    started: Option<Instant>,
    bar: Option<ProgressBar>,
}

impl CurrentTask {
    fn update(&mut self, what: &str, done: u64, total: u64) {
        let finished = total > 0 && done >= total;
        // A nested task that ends leaves the bar of the outer one alone.
        if finished && self.what != what {
            return;
        }
        if finished || self.what != what {
            (self.what, self.started) = (what.to_owned(), None);
            if let Some(bar) = self.bar.take() {
                bar.finish_and_clear();
            }
        }
        if finished {
            return;
        }
        let started = *self.started.get_or_insert_with(Instant::now);
        if self.bar.is_none() && started.elapsed() >= SHOWN_AFTER {
            let known = "{msg} {bar:40} {binary_bytes}/{binary_total_bytes} {elapsed} (about {eta} left)";
            let bar = match total {
                0 => ProgressBar::no_length().with_style(style("{msg} {binary_bytes} {elapsed}")),
                total => ProgressBar::new(total).with_style(style(known)),
            };
            self.bar = Some(bar.with_message(what.to_owned()).with_elapsed(started.elapsed()));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_shown_while_they_last() {
        let mut shown = CurrentTask::default();
        shown.update("reading", 1, 10);
        assert!(shown.started.is_some() && shown.bar.is_none());
        // As if started long ago.
        shown.started = Instant::now().checked_sub(2 * SHOWN_AFTER);
        shown.update("reading", 5, 10);
        let bar = shown.bar.clone().unwrap();
        assert_eq!((bar.position(), bar.length()), (5, Some(10)));
        shown.update("another", 10, 10);
        assert!(shown.bar.is_some());
        shown.update("reading", 10, 10);
        assert!(shown.bar.is_none() && shown.started.is_none() && bar.is_finished());
    }
}
