//! Records the kernels launched on a device, in tests only. scripts/gpu-static builds them with other compilers.

use super::{Device, program};
use serde::Serialize;
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// A launched kernel.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(crate) struct Started {
    pub kernel: &'static str,
    /// File in kernels/.
    pub file: &'static str,
    /// All compiler options of its program.
    pub options: String,
    /// Work-group size, unless the kernel allows less.
    pub group: usize,
}

impl Started {
    /// Source text of its program.
    pub fn source(&self) -> String {
        program::source(self.file)
    }
}

/// All launched kernels of a device.
#[derive(Default)]
pub(super) struct AllStarted(Mutex<BTreeSet<Started>>);

impl Device {
    /// Records a launched kernel. `defines`: the options passed to [`Device::kernel`].
    pub(super) fn record_started(&self, (file, kernel): (&'static str, &'static str), defines: &str, group: usize) {
        let mut all = self.shared.started.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(Started { kernel, file, options: program::options(defines), group });
    }

    /// All kernels launched so far.
    pub(crate) fn started(&self) -> BTreeSet<Started> {
        self.shared.started.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
