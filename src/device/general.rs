//! More general programs, used by frames while the specialised ones are being built.

use super::Device;
use super::launch::KernelRequest;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a frame that may use general programs has used one.
#[derive(Default)]
pub(super) struct GeneralPrograms(AtomicBool);

impl Device {
    /// A handle for a frame. If `allowed`, it may use general programs where the specialised ones are not built yet.
    pub(crate) fn with_general_programs(self, allowed: bool) -> Self {
        Self { general_programs: allowed.then(Arc::default), ..self }
    }

    /// Whether a kernel of a general program was launched through this handle.
    pub(crate) fn used_general_program(&self) -> bool {
        self.general_programs.as_ref().is_some_and(|used| used.0.load(Ordering::Relaxed))
    }

    pub(super) fn may_use_general_programs(&self) -> bool {
        self.general_programs.is_some()
    }

    /// Records the use of a general program. If `first`, requests the build of the specialised one in the background.
    pub(super) fn use_general_program(&self, best: KernelRequest, first: bool) {
        if let Some(used) = &self.general_programs {
            used.0.store(true, Ordering::Relaxed);
        }
        if first {
            self.build_ahead(move || Ok(vec![best]), |_| {});
        }
    }
}
