//! Bars on standard error; none where that is no terminal.

use crate::progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Nobody wants to see a bar for less.
const WORTH_SEEING: Duration = Duration::from_secs(1);

/// Shows tasks of the library's that take longer than a second.
pub(super) fn show_tasks() {
    if !std::io::stderr().is_terminal() {
        return;
    }
    let shown = Mutex::new(Shown::default());
    progress::watch(move |what, done, total| shown.lock().unwrap_or_else(PoisonError::into_inner).update(what, done, total));
}

/// Builds of programs that take less are those of kernels that the driver has kept.
const BUILT_ANEW: Duration = Duration::from_millis(300);

/// Draws something; if programs are built for it that the driver has not kept, tells how long that took, whether or not standard error is a
/// terminal. Drawing itself takes a hundredth of it.
pub(super) fn tell_compiling<T>(draw: impl FnOnce() -> T) -> T {
    let (begun, before) = (Instant::now(), progress::building());
    let drawn = draw();
    if progress::building() - before >= BUILT_ANEW {
        say_compiled(begun.elapsed());
    }
    drawn
}

/// Says how long kernels were compiled, here or in a process of its own.
pub(super) fn say_compiled(taken: Duration) {
    eprintln!("compiling kernels, once per set of options: {:.0} s", taken.as_secs_f64().max(1.0));
}

/// A bar for steps that are known, pictures for instance.
pub(super) fn steps(count: u32, what: &'static str) -> ProgressBar {
    ProgressBar::new(count.into()).with_style(style("{msg} {bar:40} {pos}/{len} {elapsed} (about {eta} left)")).with_message(what)
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is valid")
}

/// The task at hand: its name, when it began, and its bar, once there is one.
#[derive(Default)]
struct Shown {
    what: String,
    begun: Option<Instant>,
    bar: Option<ProgressBar>,
}

impl Shown {
    fn update(&mut self, what: &str, done: u64, total: u64) {
        let over = total > 0 && done >= total;
        // One that goes on beneath another is not seen; where it ends, the other is left alone.
        if over && self.what != what {
            return;
        }
        if over || self.what != what {
            (self.what, self.begun) = (what.to_owned(), None);
            if let Some(bar) = self.bar.take() {
                bar.finish_and_clear();
            }
        }
        if over {
            return;
        }
        let begun = *self.begun.get_or_insert_with(Instant::now);
        if self.bar.is_none() && begun.elapsed() >= WORTH_SEEING {
            let known = "{msg} {bar:40} {binary_bytes}/{binary_total_bytes} {elapsed} (about {eta} left)";
            let bar = match total {
                0 => ProgressBar::no_length().with_style(style("{msg} {binary_bytes} {elapsed}")),
                total => ProgressBar::new(total).with_style(style(known)),
            };
            self.bar = Some(bar.with_message(what.to_owned()).with_elapsed(begun.elapsed()));
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
        let mut shown = Shown::default();
        shown.update("reading", 1, 10);
        assert!(shown.begun.is_some() && shown.bar.is_none());
        // It has begun long ago.
        shown.begun = Instant::now().checked_sub(2 * WORTH_SEEING);
        shown.update("reading", 5, 10);
        let bar = shown.bar.clone().unwrap();
        assert_eq!((bar.position(), bar.length()), (5, Some(10)));
        shown.update("another", 10, 10);
        assert!(shown.bar.is_some());
        shown.update("reading", 10, 10);
        assert!(shown.bar.is_none() && shown.begun.is_none() && bar.is_finished());
    }
}
