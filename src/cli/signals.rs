//! Signals that end the command. Output files are complete or absent even then.

use crate::files::between_files;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::exit;
use std::thread;

/// Makes SIGINT, SIGTERM and SIGHUP wait for the current file write before the process exits. A second signal exits at once. The
/// exit code is 128 plus the signal number, as in shells: 130 for Ctrl-C.
pub(super) fn exit_after_writes() {
    on_first(|first| {
        thread::spawn(move || between_files(|| exit(128 + first)));
    });
}

/// Makes the first of these signals call `end` instead, from another thread. A second one exits at once.
pub(super) fn on_first(end: impl FnOnce(i32) + Send + 'static) {
    let ignored = ignored_signals();
    let handled = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let Ok(mut signals) = Signals::new(handled) else {
        return tracing::debug!("cannot install signal handlers: signals end the command at once");
    };
    thread::spawn(move || {
        let mut signals = signals.forever();
        if let Some(first) = signals.next() {
            end(first);
        }
        if let Some(second) = signals.next() {
            exit(128 + second);
        }
    });
}

/// Exits at once, without the clean-up of libraries: it fails where another thread still uses a driver.
#[cfg(feature = "viewer")]
pub(super) fn exit_now(code: i32) -> ! {
    exit(code)
}

/// Bit mask of the signals that the parent set to be ignored, as `nohup` does, and shells do for background jobs. SIGHUP alone if
/// the system does not report them.
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let bits = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    bits.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(1 << (SIGHUP - 1))
}
