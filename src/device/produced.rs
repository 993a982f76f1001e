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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Buffer, DeviceChoice};
    use opencl3::command_queue::{CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CommandQueue};
    use opencl3::context::Context;
    use opencl3::device::Device as ClDevice;
    use opencl3::event::{create_user_event, set_user_event_status};

    /// Status of an event whose command failed.
    const FAILED: i32 = -5;

    /// A device in a context of its own, and that context.
    fn device(properties: u64) -> (Device, Context) {
        let own = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let context = Context::from_device(&ClDevice::new(own.id())).unwrap();
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&context, properties).unwrap();
        (Device::from_queue(&queue).unwrap(), context)
    }

    /// Enqueues a command that depends on an event of the caller, sets the status of that event, and returns how this and the next frame,
    /// and one of another sequence, may use the value that the command writes: before and after the status is set.
    fn usabilities(properties: u64, event_status: i32) -> [[Usability; 2]; 3] {
        let (device, context) = device(properties);
        let event = Event::new(create_user_event(context.get()).unwrap());
        device.begin(&[&event]).unwrap();
        device.end().unwrap();
        let mut produced = device.produced().unwrap();
        let other = device.with_own_sequence();
        other.begin(&[]).unwrap();
        let own = device.usability(&mut produced).unwrap();
        device.begin(&[]).unwrap();
        let before = [own, device.usability(&mut produced).unwrap(), other.usability(&mut produced).unwrap()];
        set_user_event_status(event.get(), event_status).unwrap();
        // The command runs, or fails, shortly afterwards.
        if let Some(written) = &produced.event {
            let _ = written.wait();
        }
        let after = [(); 3].map(|()| device.usability(&mut produced).unwrap());
        std::array::from_fn(|n| [before[n], after[n]])
    }

    #[test]
    fn values_that_wait_for_events_of_the_caller_are_used_by_their_own_frame_only() {
        use Usability::{Failed, Uncertain, Usable};
        for properties in [0, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE] {
            for (event_status, after) in [(CL_COMPLETE, Usable), (FAILED, Failed)] {
                let expected = [[Usable, after], [Uncertain, after], [Uncertain, after]];
                assert_eq!(usabilities(properties, event_status), expected, "{properties}, {event_status}");
            }
        }
    }

    #[test]
    fn another_sequence_waits_for_the_commands_that_write_a_value() {
        let (device, context) = device(0);
        device.begin(&[]).unwrap();
        let event = Event::new(create_user_event(context.get()).unwrap());
        // A command of the sequence itself that is pending, without an event that the frame was told to wait for.
        let mut buffer = Buffer::<u8>::new(&device, 1, "a value").unwrap();
        device.sequence.state().wait = vec![retained(&event).unwrap()];
        let marker = device.end().unwrap();
        let mut produced = device.produced().unwrap();
        let other = device.with_own_sequence();
        other.begin(&[]).unwrap();
        assert_eq!(other.usability(&mut produced).unwrap(), Usability::Usable);
        assert_eq!(other.sequence.state().wait.len(), 1, "its next command waits");
        set_user_event_status(event.get(), CL_COMPLETE).unwrap();
        marker.wait().unwrap();
        buffer.write_at(&other, 0, &[1]).unwrap();
        assert!(other.sequence.state().wait.is_empty());
    }
}
