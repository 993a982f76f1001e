//! What produced a value on the device, and whether a frame may use it.

use super::Device;
use super::commands::{retained, status};
use crate::error::Error;
use opencl3::event::{CL_COMPLETE, Event};

/// The last command that writes a value, and the frame it belongs to.
pub(crate) struct Produced {
    /// `None`: the value is there.
    event: Option<Event>,
    /// Events of the caller that the frame waits for, and that had not completed.
    awaited: Vec<Event>,
    sequence: u64,
    frame: u64,
}

/// How a frame may use a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Usability {
    /// Its commands come after those that write the value.
    Usable,
    /// The value depends on events of the caller that may still fail: only the frame that waits for them can use it.
    Uncertain,
    /// A command that writes it failed.
    Failed,
}

impl Produced {
    /// Of a value that was copied from the host when its buffer was made.
    pub fn by_host() -> Self {
        Self { event: None, awaited: Vec::new(), sequence: u64::MAX, frame: 0 }
    }

    /// Whether only commands of this device handle's sequence have written the value.
    pub fn is_of(&self, device: &Device) -> bool {
        self.sequence == device.sequence.id
    }
}

impl Device {
    /// What was enqueued last through this handle, as the producer of a value.
    pub(crate) fn produced(&self) -> Result<Produced, Error> {
        let state = self.sequence.state();
        let failed = |e| self.error("clRetainEvent", e);
        let event = state.last.as_ref().map(retained).transpose().map_err(failed)?;
        let unfinished = state.awaited.iter().filter(|event| status(event) != CL_COMPLETE);
        let awaited = unfinished.map(retained).collect::<Result<_, _>>().map_err(failed)?;
        Ok(Produced { event, awaited, sequence: self.sequence.id, frame: state.frame })
    }

    /// Whether the frame of this handle may use a value. Commands of another sequence are waited for on the device.
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
        let own = produced.is_of(self);
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
