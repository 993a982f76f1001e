//! What is enqueued through a handle: in its own order, whatever the order of the queue.

use super::Device;
use crate::error::Error;
use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::{CL_COMPLETE, Event, retain_event};
use opencl3::types::cl_event;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A queue, and the commands that one renderer puts into it, each after the one before. An out-of-order queue is told so by events.
pub(super) struct Sequence {
    pub queue: Arc<CommandQueue>,
    pub in_order: bool,
    /// No other sequence has it.
    pub id: u64,
    state: Mutex<State>,
}

/// Ids of sequences.
static NEXT_ID: AtomicU64 = AtomicU64::new(0);

#[derive(Default)]
pub(super) struct State {
    /// Events that the next command waits for.
    pub wait: Vec<Event>,
    /// Events of the caller that the current frame waits for, itself or because a frame before it does.
    pub awaited: Vec<Event>,
    /// Number of the current frame.
    pub frame: u64,
    /// The last command, and the one before it.
    pub last: Option<Event>,
    before_last: Option<Event>,
    /// Those that were not over when they were last looked at. PoCL 3.1 lets go of an event that fails before it unlocks it: somebody
    /// else has to hold it.
    pending: Vec<Event>,
}

/// Commands on their way from which on it is looked at whether they still are.
const MANY: usize = 256;

impl State {
    /// Lets go of what is over.
    fn sweep(&mut self) {
        self.pending.retain(|event| status(event) > CL_COMPLETE);
        self.before_last.take_if(|event| status(event) <= CL_COMPLETE);
    }
}

/// Another reference to an event.
pub(super) fn retained(event: &Event) -> Result<Event, ClError> {
    // SAFETY: the event is alive, and the reference that is counted here is the new one's.
    unsafe { retain_event(event.get()) }.map_err(ClError)?;
    Ok(Event::new(event.get()))
}

/// `CL_COMPLETE`, more before that, and less of what failed.
pub(super) fn status(event: &Event) -> i32 {
    event.command_execution_status().map_or_else(|e| e.0, |status| status.0)
}

impl Sequence {
    pub fn new(queue: CommandQueue, in_order: bool) -> Self {
        Self::of_queue(Arc::new(queue), in_order)
    }

    fn of_queue(queue: Arc<CommandQueue>, in_order: bool) -> Self {
        Self { queue, in_order, id: NEXT_ID.fetch_add(1, Ordering::Relaxed), state: Mutex::default() }
    }

    pub fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Device {
    /// The same device with a sequence of its own: what is enqueued through it does not wait for what others enqueue, but for what an
    /// in-order queue makes it wait for.
    pub(crate) fn with_own_sequence(&self) -> Self {
        let Sequence { queue, in_order, .. } = &*self.sequence;
        let sequence = Sequence::of_queue(queue.clone(), *in_order);
        Self { sequence: Arc::new(sequence), ..self.clone() }
    }

    /// Begins a frame, or other commands, that come after `wait` and after all before.
    pub(crate) fn begin(&self, wait: &[&Event]) -> Result<(), Error> {
        let again = || wait.iter().map(|event| retained(event)).collect::<Result<Vec<_>, _>>();
        let [awaited, wait] = [again(), again()].map(|events| events.map_err(|e| self.error("clRetainEvent", e)));
        let mut state = self.sequence.state();
        state.awaited.retain(|event| status(event) > CL_COMPLETE);
        state.awaited.extend(awaited?);
        state.wait = wait?;
        state.frame += 1;
        state.sweep();
        // What failed is over: what comes after does not depend on it.
        if state.last.as_ref().is_some_and(|last| status(last) < CL_COMPLETE) {
            (state.last, state.before_last) = (None, None);
        }
        Ok(())
    }

    /// Lets go of commands that are over, after one that was waited for.
    pub(super) fn let_go(&self) {
        self.sequence.state().sweep();
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
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error(call, e))?;
        let event = enqueue(queue, &wait).map_err(|e| self.error(call, e))?;
        state.wait.clear();
        let again = || retained(&event).map_err(|e| self.error("clRetainEvent", e));
        state.before_last = state.last.replace(again()?);
        state.pending.push(again()?);
        if state.pending.len() >= MANY && state.pending.len().is_power_of_two() {
            state.sweep();
        }
        Ok(event)
    }

    /// Lets the queue begin with what it holds.
    fn flush(&self) -> Result<(), Error> {
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error("clFlush", e))?;
        self.sequence.queue.flush().map_err(|e| self.error("clFlush", e))
    }

    /// Waits for everything that was enqueued through this handle.
    pub(crate) fn finish(&self) -> Result<(), Error> {
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error("clWaitForEvents", e))?;
        let last = self.sequence.state().last.as_ref().map(retained).transpose().map_err(|e| self.error("clRetainEvent", e))?;
        last.map_or(Ok(()), |last| last.wait().map_err(|e| self.error("clWaitForEvents", e)))
    }

    /// Waits for all commands but the last one.
    pub(super) fn wait_for_all_but_last(&self) -> Result<(), Error> {
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error("clWaitForEvents", e))?;
        let before_last = self.sequence.state().before_last.as_ref().map(retained).transpose();
        let before_last = before_last.map_err(|e| self.error("clRetainEvent", e))?;
        before_last.map_or(Ok(()), |event| event.wait().map_err(|e| self.error("clWaitForEvents", e)))
    }
}
