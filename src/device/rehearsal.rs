//! Frames that are not drawn: they tell which kernels a frame starts, by the very code that starts them.

use super::Device;
use super::launch::KernelRequest;
use std::sync::{Arc, Mutex, PoisonError};

/// The kernels that were launched through a handle on which nothing starts.
#[derive(Default)]
pub(crate) struct Rehearsal(Mutex<Launched>);

/// Kernels, in the order of their launches.
#[derive(Default)]
pub(crate) struct Launched {
    /// Those that frames are drawn by.
    pub best: Vec<KernelRequest>,
    /// And those that they can be drawn by meanwhile.
    pub general: Vec<KernelRequest>,
}

impl Rehearsal {
    fn kernels(&self) -> std::sync::MutexGuard<'_, Launched> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes down a launch.
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
    /// A handle on which no kernel starts, buffers hold nothing, and what is read stays as it is; and where the kernels are taken down
    /// that would have started.
    pub(crate) fn rehearsing(&self) -> (Self, Arc<Rehearsal>) {
        let rehearsal = Arc::new(Rehearsal::default());
        (Self { rehearsal: Some(rehearsal.clone()), scratch: None, stopwatch: None, begun: None, ..self.clone() }, rehearsal)
    }

    /// Where launches are taken down instead.
    pub(super) fn rehearsal(&self) -> Option<&Rehearsal> {
        self.rehearsal.as_deref()
    }
}
