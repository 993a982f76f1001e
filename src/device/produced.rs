//! Tracks which commands wrote a value on the device, and whether a frame may use it.

use super::Device;
use super::commands::{retained, status};
use crate::error::Error;
use opencl3::event::{CL_COMPLETE, Event};

/// The last command that writes a value, and its frame.
pub(crate) struct Produced {
    /// `None` if the value is complete.
    event: Option<Event>,
    /// The caller's events that the frame waits for and that were not complete.
    awaited: Vec<Event>,
    sequence: u64,
    frame: u64,
}

/// How a frame may use a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Usability {
    /// Commands of the frame run after those that write the value.
    Usable,
    /// The value depends on events of the caller that may still fail. Only the frame that waits for them can use it.
    Uncertain,
    /// A command that writes it failed.
    Failed,
}

impl Produced {
    /// For a value copied from the host when its buffer was created.
    pub fn by_host() -> Self {
        Self { event: None, awaited: Vec::new(), sequence: u64::MAX, frame: 0 }
    }

    /// Whether the value was written by the sequence of this device handle.
    pub fn is_from(&self, device: &Device) -> bool {
        self.sequence == device.sequence.id
    }
}

impl Device {
    /// The last command enqueued through this handle, as the producer of a value.
    pub(crate) fn produced(&self) -> Result<Produced, Error> {
        let state = self.sequence.state();
        let failed = |e| self.error("clRetainEvent", e);
        let event = state.last.as_ref().map(retained).transpose().map_err(failed)?;
        let unfinished = state.awaited.iter().filter(|event| status(event) != CL_COMPLETE);
        let awaited = unfinished.map(retained).collect::<Result<_, _>>().map_err(failed)?;
        Ok(Produced { event, awaited, sequence: self.sequence.id, frame: state.frame })
    }

    /// Whether the frame of this handle may use a value. If another sequence writes it, the next command waits for that on the
    /// device.
    pub(crate) fn usability(&self, produced: &mut Produced) -> Result<Usability, Error> {
        let Some(event) = &produced.event else { return Ok(Usability::Usable) };
        match status(event) {
            CL_COMPLETE => {
                (produced.event, produced.awaited) = (None, Vec::new());
                return Ok(Usability::Usable);
            }
            failed if failed < CL_COMPLETE => return Ok(Usability::Failed),
            _ => {}
        }
        let mut state = self.sequence.state();
        let own = produced.is_from(self);
        if own && produced.frame == state.frame {
            return Ok(Usability::Usable);
        }
        if produced.awaited.iter().any(|event| status(event) != CL_COMPLETE) {
            return Ok(Usability::Uncertain);
        }
        if !own {
            state.wait.push(retained(event).map_err(|e| self.error("clRetainEvent", e))?);
        }
        Ok(Usability::Usable)
    }
}
