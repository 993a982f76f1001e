//! The thread that draws frames, one after the other.

use crate::handle::Handle;
use crate::painter::Painter;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{JoinHandle, ThreadId};

/// Draws with the painter. What it returns runs afterwards, when the painter is free.
pub type Job = Box<dyn FnOnce(&mut Painter) -> Box<dyn FnOnce()> + Send>;

/// The thread, which starts with the first frame.
#[derive(Default)]
pub struct Worker {
    running: Mutex<Option<Running>>,
    shared: Arc<Shared>,
}

struct Running {
    queue: Sender<Job>,
    thread: JoinHandle<()>,
}

#[derive(Default)]
struct Shared {
    painter: Mutex<Painter>,
    /// Number of frames that are not drawn yet.
    pending: Mutex<usize>,
    drawn: Condvar,
    /// Fields that are gone, whose voxels are still on the device.
    gone: Mutex<Vec<Handle>>,
}

/// The value of a lock, also after a panic: what is locked here stays consistent.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Worker {
    /// Queues a frame.
    pub fn push(&self, job: Job) {
        let mut running = locked(&self.running);
        let running = running.get_or_insert_with(|| {
            let (queue, jobs) = channel::<Job>();
            let shared = self.shared.clone();
            let thread = std::thread::spawn(move || jobs.into_iter().for_each(|job| shared.run(job)));
            Running { queue, thread }
        });
        *locked(&self.shared.pending) += 1;
        // The thread ends only after the queue.
        let _ = running.queue.send(job);
    }

    /// Whether the caller is a callback of a frame.
    pub fn is_current(&self) -> bool {
        let own = |running: &Running| running.thread.thread().id();
        locked(&self.running).as_ref().map(own) == Some(std::thread::current().id() as ThreadId)
    }

    /// Waits until all frames are drawn. Callbacks of frames do not wait: their own frame is drawn, and later ones could not be.
    pub fn wait(&self) {
        if self.is_current() {
            return;
        }
        let mut pending = locked(&self.shared.pending);
        while *pending > 0 {
            pending = self.shared.drawn.wait(pending).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The painter, when no frame is being drawn.
    pub fn painter(&self) -> MutexGuard<'_, Painter> {
        locked(&self.shared.painter)
    }

    /// Frees the voxels of a field that is gone: at once, or after the frame that is being drawn.
    pub fn forget_field(&self, field: Handle) {
        locked(&self.shared.gone).push(field);
        if let Ok(mut painter) = self.shared.painter.try_lock() {
            self.shared.forget(&mut painter);
        }
    }

    /// Ends the thread after the frames in the queue.
    pub fn end(&self) {
        let is_current = self.is_current();
        let Some(Running { queue, thread }) = locked(&self.running).take() else { return };
        drop(queue);
        if !is_current {
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn forget(&self, painter: &mut Painter) {
        painter.forget_fields(&std::mem::take(&mut *locked(&self.gone)));
    }

    fn run(&self, job: Job) {
        let mut painter = locked(&self.painter);
        let after = job(&mut painter);
        self.forget(&mut painter);
        drop(painter);
        *locked(&self.pending) -= 1;
        self.drawn.notify_all();
        after();
    }
}
