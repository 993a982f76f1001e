//! Which kernels were started on a device, for scripts/gpu-static, which builds them with other compilers. Only tests have it.

use super::{Device, program};
use serde::Serialize;
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// A kernel that was started.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(crate) struct Started {
    pub kernel: &'static str,
    /// Its file in kernels/.
    pub file: &'static str,
    /// Of its program: all that the compiler is given.
    pub options: String,
    /// Work-items of a group, where the kernel leaves as many.
    pub group: usize,
}

impl Started {
    /// The text of its program.
    pub fn source(&self) -> String {
        program::source(self.file)
    }
}

/// All that were.
#[derive(Default)]
pub(super) struct AllStarted(Mutex<BTreeSet<Started>>);

impl Device {
    /// Takes down a kernel; `defines`: what [`Device::kernel`] was told.
    pub(super) fn note_started(&self, (file, kernel): (&'static str, &'static str), defines: &str, group: usize) {
        let mut all = self.shared.started.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(Started { kernel, file, options: program::options(defines), group });
    }

    /// All kernels that were started so far.
    pub(crate) fn started(&self) -> BTreeSet<Started> {
        self.shared.started.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
