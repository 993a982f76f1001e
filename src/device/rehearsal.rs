//! Dry runs (rehearsals) of frames: the code that renders a frame runs, but its kernels are recorded instead of launched.

use super::Device;
use super::launch::KernelRequest;
use std::sync::{Arc, Mutex, PoisonError};

/// Records the kernels of a dry run.
#[derive(Default)]
pub(crate) struct Rehearsal(Mutex<Vec<Rehearsed>>);

/// A launch of a dry run.
pub(crate) struct Rehearsed {
    /// The most specialised kernel, which frames use once it is built.
    pub best: KernelRequest,
    /// A more general kernel, which frames can use until then.
    pub general: Option<KernelRequest>,
}

impl Rehearsal {
    fn kernels(&self) -> std::sync::MutexGuard<'_, Vec<Rehearsed>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records a launch.
    pub(super) fn add(&self, best: KernelRequest, general: Option<KernelRequest>) {
        self.kernels().push(Rehearsed { best, general });
    }

    /// All launches since the last call, in order.
    pub fn take(&self) -> Vec<Rehearsed> {
        std::mem::take(&mut *self.kernels())
    }
}

impl Device {
    /// A handle for a dry run, and the record of the kernels that would have been launched. Buffers of this handle hold no data,
    /// and reads leave their destination unchanged.
    pub(crate) fn rehearsing(&self) -> (Self, Arc<Rehearsal>) {
        let rehearsal = Arc::new(Rehearsal::default());
        (Self { rehearsal: Some(rehearsal.clone()), scratch: None, stopwatch: None, begun: None, ..self.clone() }, rehearsal)
    }

    /// The record of launches, in a dry run.
    pub(super) fn rehearsal(&self) -> Option<&Rehearsal> {
        self.rehearsal.as_deref()
    }
}
