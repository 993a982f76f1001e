//! Messages about the compilation of kernels, on standard error even if it is no terminal: the first picture waits for it.

use crate::progress;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Shorter waits are not reported.
const REPORTED_AFTER: Duration = Duration::from_secs(1);
/// Builds that take less use kernels from the driver's cache.
const UNCACHED_BUILD: Duration = Duration::from_millis(300);

/// Whether this command has announced the compilation.
static ANNOUNCED: AtomicBool = AtomicBool::new(false);

/// Runs work that may compile kernels in this process, such as rendering.
pub(super) fn while_rendering<T>(render: impl FnOnce() -> T) -> T {
    let before = progress::building();
    report(move || progress::is_building() || progress::building() - before >= UNCACHED_BUILD, render)
}

/// Runs a device check, which compiles kernels in a child process. Its pictures themselves take milliseconds.
pub(super) fn while_checking<T>(check: impl FnOnce() -> T) -> T {
    report(|| true, check)
}

/// Runs `work`. If it takes longer than [`REPORTED_AFTER`] and `compiles`, prints that kernels are compiled, once per command, and finally
/// how long it took.
fn report<T>(compiles: impl Fn() -> bool + Sync, work: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let done = thread::scope(|scope| {
        let (ended, end) = channel::<()>();
        let compiles = &compiles;
        scope.spawn(move || {
            let is_long = end.recv_timeout(REPORTED_AFTER) == Err(RecvTimeoutError::Timeout);
            if is_long && compiles() && !ANNOUNCED.swap(true, Ordering::Relaxed) {
                eprintln!("compiling kernels, once per set of options");
            }
        });
        let done = work();
        drop(ended);
        done
    });
    if started.elapsed() >= REPORTED_AFTER && compiles() {
        eprintln!("compiled kernels in {:.0} s", started.elapsed().as_secs_f64());
    }
    done
}
