//! What is enqueued through a handle: in its own order, whatever the order of the queue.

use super::Device;
use crate::error::Error;
use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::{CL_COMPLETE, Event, retain_event};
use opencl3::types::cl_event;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A queue, and the commands that one renderer puts into it, each after the one before. An out-of-order queue is told so by events.
pub(super) struct Sequence {
    pub queue: Arc<CommandQueue>,
    pub in_order: bool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// What the next command has to wait for.
    wait: Vec<Event>,
    /// The last command.
    last: Option<Event>,
    /// Commands on their way that came after events of the caller's: PoCL 3.1 ends the process where one of these fails, and then a chain
    /// of commands whose events nobody holds.
    held: Vec<Event>,
}

/// Whether a command is over, well or not.
fn is_over(event: &Event) -> bool {
    event.command_execution_status().map_or(true, |status| status.0 <= CL_COMPLETE)
}

fn has_failed(event: &Event) -> bool {
    event.command_execution_status().map_or(true, |status| status.0 < CL_COMPLETE)
}

/// How long a frame may take, and when it began.
#[derive(Clone, Copy)]
pub(super) struct Limit {
    pub began: Instant,
    pub longest: Duration,
}

/// Another reference to an event.
pub(super) fn retained(event: &Event) -> Result<Event, ClError> {
    // SAFETY: the event is alive, and the reference that is counted here is the new one's.
    unsafe { retain_event(event.get()) }.map_err(ClError)?;
    Ok(Event::new(event.get()))
}

impl Sequence {
    pub fn new(queue: CommandQueue, in_order: bool) -> Self {
        Self { queue: Arc::new(queue), in_order, state: Mutex::default() }
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Device {
    /// The same device with a sequence of its own: what is enqueued through it does not wait for what others enqueue, but for what an
    /// in-order queue makes it wait for.
    pub(crate) fn with_own_sequence(&self) -> Self {
        let Sequence { queue, in_order, .. } = &*self.sequence;
        let sequence = Sequence { queue: queue.clone(), in_order: *in_order, state: Mutex::default() };
        Self { sequence: Arc::new(sequence), ..self.clone() }
    }

    /// A handle whose commands are refused once a frame that begins now has taken longer.
    pub(crate) fn limited(self, longest: Option<Duration>) -> Self {
        Self { limit: longest.map(|longest| Limit { began: Instant::now(), longest }), ..self }
    }

    /// Begins commands that come after `wait`, and after all before; and whether any of those has failed, as far as they are known to be
    /// over: what they should have made is not there.
    pub(crate) fn begin(&self, wait: &[&Event]) -> Result<bool, Error> {
        let wait: Result<Vec<_>, _> = wait.iter().map(|event| retained(event)).collect();
        let mut state = self.sequence.state();
        state.wait = wait.map_err(|e| self.error("clRetainEvent", e))?;
        let failed = state.held.iter().chain(&state.last).any(has_failed);
        state.held.retain(|event| !is_over(event));
        // What comes after does not depend on what failed.
        if state.last.as_ref().is_some_and(has_failed) {
            state.last = None;
        }
        Ok(failed)
    }

    /// The event that is complete when all that was enqueued is.
    pub(crate) fn end(&self) -> Result<Event, Error> {
        let nothing = {
            let state = self.sequence.state();
            state.last.is_none() || !state.wait.is_empty()
        };
        if nothing {
            // SAFETY: the events of the list are alive.
            self.command("clEnqueueMarkerWithWaitList", |queue, wait| unsafe { queue.enqueue_marker_with_wait_list(wait) })?;
        }
        self.flush()?;
        let state = self.sequence.state();
        let last = state.last.as_ref().expect("a marker at least");
        retained(last).map_err(|e| self.error("clRetainEvent", e))
    }

    /// Enqueues a command, after those before.
    pub(super) fn command(
        &self,
        call: &'static str,
        enqueue: impl FnOnce(&CommandQueue, &[cl_event]) -> opencl3::Result<Event>,
    ) -> Result<Event, Error> {
        let Sequence { queue, in_order, .. } = &*self.sequence;
        let mut state = self.sequence.state();
        let after = state.last.iter().filter(|_| !in_order);
        let wait: Vec<cl_event> = state.wait.iter().chain(after).map(Event::get).collect();
        let event = enqueue(queue, &wait).map_err(|e| self.error(call, e))?;
        let retained = || retained(&event).map_err(|e| self.error("clRetainEvent", e));
        if !state.wait.is_empty() || !state.held.is_empty() {
            state.held.push(retained()?);
        }
        state.wait.clear();
        state.last = Some(retained()?);
        Ok(event)
    }

    /// Lets the queue begin with what it holds.
    fn flush(&self) -> Result<(), Error> {
        self.sequence.queue.flush().map_err(|e| self.error("clFlush", e))
    }

    /// Waits for everything that was enqueued through this handle.
    pub(crate) fn finish(&self) -> Result<(), Error> {
        let last = self.sequence.state().last.as_ref().map(retained).transpose().map_err(|e| self.error("clRetainEvent", e))?;
        last.map_or(Ok(()), |last| last.wait().map_err(|e| self.error("clWaitForEvents", e)))
    }

    /// Refuses what would begin when a frame has already taken too long. Kernels on their way cannot be called back: they are waited for.
    pub(super) fn check_limit(&self, stage: &'static str) -> Result<(), Error> {
        let Some(Limit { began, longest }) = self.limit else { return Ok(()) };
        self.finish()?;
        if began.elapsed() <= longest { Ok(()) } else { Err(Error::TooLong { stage, longest }) }
    }
}
