//! Command ordering: commands of one handle run in order, also on an out-of-order queue.

use super::Device;
use crate::error::Error;
use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::{CL_COMPLETE, Event, retain_event};
use opencl3::types::cl_event;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A queue and the commands that one renderer enqueues there, each after the previous one. On an out-of-order queue, events
/// enforce that.
pub(super) struct Sequence {
    pub queue: Arc<CommandQueue>,
    pub in_order: bool,
    /// Unique among all sequences.
    pub id: u64,
    state: Mutex<State>,
}

static NEXT_ID: AtomicU64 = AtomicU64::new(0);

#[derive(Default)]
pub(super) struct State {
    /// The next command waits for these events.
    pub wait: Vec<Event>,
    /// The caller's events that the current frame waits for, directly or because an earlier frame does.
    pub awaited: Vec<Event>,
    /// Number of the current frame.
    pub frame: u64,
    /// The last command, and the one before it.
    pub last: Option<Event>,
    before_last: Option<Event>,
    /// Commands that had not finished at the last sweep. PoCL 3.1 releases a failed event before unlocking it, so another
    /// reference must keep it alive.
    pending: Vec<Event>,
}

/// Number of pending events at which finished ones are first swept.
const SWEEP_THRESHOLD: usize = 256;

impl State {
    /// Releases the events of finished commands.
    fn sweep(&mut self) {
        self.pending.retain(|event| status(event) > CL_COMPLETE);
        self.before_last.take_if(|event| status(event) <= CL_COMPLETE);
    }
}

/// Another reference to an event.
pub(super) fn retained(event: &Event) -> Result<Event, ClError> {
    // SAFETY: the event is alive, and the new `Event` owns this reference.
    unsafe { retain_event(event.get()) }.map_err(ClError)?;
    Ok(Event::new(event.get()))
}

/// Execution status: `CL_COMPLETE` (0), positive while pending, negative after an error.
pub(super) fn status(event: &Event) -> i32 {
    event.command_execution_status().map_or_else(|e| e.0, |status| status.0)
}

impl Sequence {
    pub fn new(queue: CommandQueue, in_order: bool) -> Self {
        Self::with_shared_queue(Arc::new(queue), in_order)
    }

    fn with_shared_queue(queue: Arc<CommandQueue>, in_order: bool) -> Self {
        Self { queue, in_order, id: NEXT_ID.fetch_add(1, Ordering::Relaxed), state: Mutex::default() }
    }

    pub fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Device {
    /// The same device with a new sequence. Its commands do not wait for those of other sequences, except on an in-order queue.
    pub(crate) fn with_own_sequence(&self) -> Self {
        let Sequence { queue, in_order, .. } = &*self.sequence;
        let sequence = Sequence::with_shared_queue(queue.clone(), *in_order);
        Self { sequence: Arc::new(sequence), ..self.clone() }
    }

    /// Begins a frame or another group of commands, which run after `wait` and all earlier commands.
    pub(crate) fn begin(&self, wait: &[&Event]) -> Result<(), Error> {
        let retain_all = || wait.iter().map(|event| retained(event)).collect::<Result<Vec<_>, _>>();
        let [awaited, wait] = [retain_all(), retain_all()].map(|events| events.map_err(|e| self.error("clRetainEvent", e)));
        let mut state = self.sequence.state();
        state.awaited.retain(|event| status(event) > CL_COMPLETE);
        state.awaited.extend(awaited?);
        state.wait = wait?;
        state.frame += 1;
        state.sweep();
        // Later commands must not depend on one that failed.
        if state.last.as_ref().is_some_and(|last| status(last) < CL_COMPLETE) {
            (state.last, state.before_last) = (None, None);
        }
        Ok(())
    }

    /// Releases the events of finished commands; called after a blocking command.
    pub(super) fn release_finished(&self) {
        self.sequence.state().sweep();
    }

    /// An event that completes after all enqueued commands.
    pub(crate) fn end(&self) -> Result<Event, Error> {
        let needs_marker = {
            let state = self.sequence.state();
            state.last.is_none() || !state.wait.is_empty()
        };
        if needs_marker {
            // SAFETY: the events in the list are alive.
            self.command("clEnqueueMarkerWithWaitList", |queue, wait| unsafe { queue.enqueue_marker_with_wait_list(wait) })?;
        }
        self.flush()?;
        let state = self.sequence.state();
        let last = state.last.as_ref().expect("at least the marker was enqueued");
        retained(last).map_err(|e| self.error("clRetainEvent", e))
    }

    /// Enqueues a command after the previous ones.
    pub(super) fn command(
        &self,
        call: &'static str,
        enqueue: impl FnOnce(&CommandQueue, &[cl_event]) -> opencl3::Result<Event>,
    ) -> Result<Event, Error> {
        let Sequence { queue, in_order, .. } = &*self.sequence;
        let mut state = self.sequence.state();
        let previous = state.last.iter().filter(|_| !in_order);
        let wait: Vec<cl_event> = state.wait.iter().chain(previous).map(Event::get).collect();
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error(call, e))?;
        let event = enqueue(queue, &wait).map_err(|e| self.error(call, e))?;
        state.wait.clear();
        let retain = || retained(&event).map_err(|e| self.error("clRetainEvent", e));
        state.before_last = state.last.replace(retain()?);
        state.pending.push(retain()?);
        if state.pending.len() >= SWEEP_THRESHOLD && state.pending.len().is_power_of_two() {
            state.sweep();
        }
        Ok(event)
    }

    /// Submits the enqueued commands to the device.
    fn flush(&self) -> Result<(), Error> {
        #[cfg(test)]
        self.shared.programs.faults.at(super::Call::Command).map_err(|e| self.error("clFlush", e))?;
        self.sequence.queue.flush().map_err(|e| self.error("clFlush", e))
    }

    /// Waits for all commands enqueued through this handle.
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
