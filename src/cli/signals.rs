//! Signals that end the command. Files appear whole or not at all, then too.

use crate::files::between_files;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::exit;
use std::thread;

/// From now on, a signal that ends the process waits until the file at hand is written; a second one does not. The exit code is 128
/// and the signal's number, as shells have it: 130 for Ctrl-C.
pub(super) fn let_files_be_finished() {
    let ignored = ignored_signals();
    let ends = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let Ok(mut signals) = Signals::new(ends) else {
        return tracing::debug!("signals end the command at once");
    };
    thread::spawn(move || {
        let mut signals = signals.forever();
        if let Some(first) = signals.next() {
            thread::spawn(move || between_files(|| exit(128 + first)));
        }
        if let Some(second) = signals.next() {
            exit(128 + second);
        }
    });
}

/// Bits of the signals that whoever started the process wants ignored, as `nohup` does and shells do in the background. Where the
/// system does not tell, nohup's.
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let bits = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    bits.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(1 << (SIGHUP - 1))
}
