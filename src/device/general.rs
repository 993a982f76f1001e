//! Frames drawn by more general programs, while the best ones are being built.

use super::Device;
use super::launch::KernelRequest;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a frame that may use general programs has used one.
#[derive(Default)]
pub(super) struct GeneralPrograms(AtomicBool);

impl Device {
    /// A handle for a frame that may be drawn by general programs where the best ones are not built yet, or may not.
    pub(crate) fn with_general_programs(self, allowed: bool) -> Self {
        Self { general_programs: allowed.then(Arc::default), ..self }
    }

    /// Whether a kernel was started through this handle in a more general program than the best one.
    pub(crate) fn used_general_program(&self) -> bool {
        self.general_programs.as_ref().is_some_and(|used| used.0.load(Ordering::Relaxed))
    }

    pub(super) fn may_use_general_programs(&self) -> bool {
        self.general_programs.is_some()
    }

    /// Notes that one is used, and the first time requests the best one in the background.
    pub(super) fn use_general_program(&self, best: KernelRequest, first: bool) {
        if let Some(used) = &self.general_programs {
            used.0.store(true, Ordering::Relaxed);
        }
        if first {
            self.build_ahead(move || Ok(vec![best]), |_| {});
        }
    }
}
