//! A host program with its own OpenCL context.

use crate::common::{self, random_volume, smooth_transfer};
use glam::DVec3;
use layersplat::device::DeviceMemory;
use layersplat::renderer::{PictureFormat, PictureMemory, UploadedVolume};
use layersplat::{Camera, Device, Frame, Renderer, Settings, TransferFunction, Viewport, Volume};
use opencl3::command_queue::{CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::device::Device as ClDevice;
use opencl3::event::{Event, create_user_event, set_user_event_status};
use opencl3::memory::{Buffer, CL_MEM_READ_WRITE};
use opencl3::types::{CL_BLOCKING, cl_command_queue_properties};

pub const SIZE: Viewport = Viewport { width: 45, height: 38 };
pub const OUT_OF_ORDER: cl_command_queue_properties = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE;

pub struct Host {
    pub context: Context,
    pub queue: CommandQueue,
}

/// Hosts with an in-order and with an out-of-order queue.
pub fn hosts() -> [Host; 2] {
    [Host::new(0), Host::new(OUT_OF_ORDER)]
}

impl Host {
    /// A host on the device under test, with a queue of some properties.
    pub fn new(properties: cl_command_queue_properties) -> Self {
        let context = Context::from_device(&ClDevice::new(common::device().id())).unwrap();
        let queue = new_queue(&context, properties);
        Self { context, queue }
    }

    pub fn another_queue(&self, properties: cl_command_queue_properties) -> CommandQueue {
        new_queue(&self.context, properties)
    }

    pub fn device(&self) -> Device {
        Device::from_queue(&self.queue).unwrap()
    }

    /// A buffer with a copy of values.
    pub fn filled<T: Copy>(&self, values: &[T]) -> Buffer<T> {
        let mut buffer = self.room(values.len());
        // SAFETY: the write blocks, and the values fit.
        unsafe { self.queue.enqueue_write_buffer(&mut buffer, CL_BLOCKING, 0, values, &[]) }.unwrap();
        buffer
    }

    /// An uninitialised buffer.
    pub fn room<T>(&self, len: usize) -> Buffer<T> {
        // SAFETY: no host pointer is passed.
        unsafe { Buffer::create(&self.context, CL_MEM_READ_WRITE, len, std::ptr::null_mut()) }.unwrap()
    }

    /// Content of a buffer after some events.
    pub fn read<T: Copy + Default>(&self, buffer: &Buffer<T>, len: usize, after: &[&Event]) -> Vec<T> {
        let mut values = vec![T::default(); len];
        let after: Vec<_> = after.iter().map(|event| event.get()).collect();
        // SAFETY: the read blocks, and the buffer has as many values.
        unsafe { self.queue.enqueue_read_buffer(buffer, CL_BLOCKING, 0, &mut values, &after) }.unwrap();
        values
    }

    /// An event that the test completes.
    pub fn promise(&self) -> Event {
        Event::new(create_user_event(self.context.get()).unwrap())
    }

    /// A float picture, through the caller's buffer.
    pub fn floats(&self, renderer: &mut Renderer, camera: &Camera, settings: &Settings) -> Frame {
        let picture = self.room::<f32>(4 * SIZE.pixels());
        let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Floats);
        let event = renderer.enqueue(camera, SIZE, settings, &onto, &[]).unwrap();
        frame(&self.read(&picture, 4 * SIZE.pixels(), &[&event]))
    }
}

pub fn new_queue(context: &Context, properties: cl_command_queue_properties) -> CommandQueue {
    #[allow(deprecated)] // The replacement requires OpenCL 2.0.
    CommandQueue::create_default(context, properties).unwrap()
}

pub fn keep(promise: &Event) {
    set_user_event_status(promise.get(), 0).unwrap();
}

pub fn frame(floats: &[f32]) -> Frame {
    Frame::new(SIZE, floats.as_chunks::<4>().0.to_vec())
}

/// A volume, its view, and its transfer function.
pub fn scene() -> (Volume<'static>, TransferFunction, Camera) {
    let volume = random_volume([21, 18, 24], DVec3::new(1.0, 0.8, 1.1), 5);
    let camera = common::parallel(&volume, SIZE, 25.0, 15.0);
    (volume, smooth_transfer(), camera)
}

pub fn renderer(device: &Device, volume: &Volume, transfer: &TransferFunction) -> Renderer {
    Renderer::from_uploaded(&UploadedVolume::new(device, volume).unwrap(), transfer).unwrap()
}
