//! Dry runs (rehearsals) of frames: the code that renders a frame runs, but its kernels are recorded instead of launched.

use super::Device;
use super::launch::KernelRequest;
use std::sync::{Arc, Mutex, PoisonError};

/// Records the kernels of a dry run.
#[derive(Default)]
pub(crate) struct Rehearsal(Mutex<Launched>);

/// Recorded kernels, in launch order.
#[derive(Default)]
pub(crate) struct Launched {
    /// The most specialised kernels, which frames use once they are built.
    pub best: Vec<KernelRequest>,
    /// More general kernels, which frames can use until then.
    pub general: Vec<KernelRequest>,
}

impl Rehearsal {
    fn kernels(&self) -> std::sync::MutexGuard<'_, Launched> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records a launch.
    pub(super) fn add(&self, best: KernelRequest, general: Option<KernelRequest>) {
        let mut kernels = self.kernels();
        kernels.best.push(best);
        kernels.general.extend(general);
    }

    /// All launches since the last call.
    pub fn take(&self) -> Launched {
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
