//! An embedding application. Its context is not shared with anything else, so that references to it can be counted.

use crate::device::{Device, DeviceChoice};
use opencl3::command_queue::{CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::device::Device as ClDevice;
use opencl3::event::Event;
use opencl3::memory::{Buffer, CL_MEM_READ_WRITE};
use opencl3::types::CL_BLOCKING;
use std::time::Duration;

/// Maximum number of attempts at counting references.
const PATIENCE: usize = 100;

pub struct Host {
    pub context: Context,
    pub queue: CommandQueue,
}

impl Host {
    pub fn new(out_of_order: bool) -> Self {
        let own = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let context = Context::from_device(&ClDevice::new(own.id())).unwrap();
        let properties = if out_of_order { CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE } else { 0 };
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&context, properties).unwrap();
        Self { context, queue }
    }

    pub fn device(&self) -> Device {
        Device::from_queue(&self.queue).unwrap()
    }

    pub fn buffer(&self, bytes: usize) -> Buffer<u8> {
        // SAFETY: no host pointer is given.
        unsafe { Buffer::create(&self.context, CL_MEM_READ_WRITE, bytes, std::ptr::null_mut()) }.unwrap()
    }

    pub fn read(&self, buffer: &Buffer<u8>, bytes: usize, after: &Event) -> Vec<u8> {
        let mut values = vec![0; bytes];
        // SAFETY: the read blocks, and there are as many values.
        unsafe { self.queue.enqueue_read_buffer(buffer, CL_BLOCKING, 0, &mut values, &[after.get()]) }.unwrap();
        values
    }

    /// Reference counts of the context and the queue, as soon as they are `expected`, or at the latest after some time. PoCL's
    /// threads release a command a moment after they report it as complete.
    pub fn references(&self, expected: Option<[u32; 2]>) -> [u32; 2] {
        self.queue.finish().unwrap();
        let mut found = [0; 2];
        for _ in 0..PATIENCE {
            found = [self.context.reference_count().unwrap(), self.queue.reference_count().unwrap()];
            if expected == Some(found) {
                break;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        found
    }
}
