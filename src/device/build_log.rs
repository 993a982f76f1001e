//! A log of the kernels that processes build, from which scripts/test tells where its time goes.

use std::fs::File;
use std::io::Write;
use std::sync::LazyLock;
use std::time::Duration;

/// Environment variable with the path of the log.
const VARIABLE: &str = "LAYERSPLAT_KERNEL_LOG";

static LOG: LazyLock<Option<File>> = LazyLock::new(|| {
    let path = std::env::var_os(VARIABLE)?;
    File::options().append(true).create(true).open(path).ok()
});

/// Appends a line: seconds, kernel, work-group size, and the options of its program. `took`: until its first launch had begun, since PoCL
/// compiles most of a kernel then.
pub(super) fn record(kernel: &str, options: &str, group: usize, took: Duration) {
    if let Some(mut log) = LOG.as_ref() {
        // One write, so that lines of several processes do not mix. A log that cannot be written is not worth an error.
        let _ = log.write_all(format!("{:.3} {kernel} {group} {options}\n", took.as_secs_f64()).as_bytes());
    }
}
