//! Bricks in buffers of the caller's own queue.

use crate::common::*;
use crate::pictures::{DIMS, brick};
use layersplat::Device;
use layersplat::device::DeviceMemory;
use layersplat::distributed::{Brick, Group};
use layersplat::opencl3::command_queue::CommandQueue;
use layersplat::opencl3::context::Context;
use layersplat::opencl3::memory::{Buffer, CL_MEM_COPY_HOST_PTR, CL_MEM_READ_WRITE};
use layersplat::renderer::DeviceVoxels;
use layersplat::volume::{Description, Grid, VoxelType};

/// A rank's slab along z of random bytes, with two ghost layers, in a buffer of a queue of its own.
pub struct BrickOnDevice {
    pub queue: CommandQueue,
    pub device: Device,
    pub brick: Brick,
    /// Those of the whole volume, from 0 to 255: the range is invariant under inversion.
    pub all_bytes: Vec<u8>,
    pub buffer: Buffer<u8>,
    /// That of the whole volume.
    pub description: Description,
}

impl BrickOnDevice {
    pub fn new(group: &Group, grid: &Grid) -> Self {
        let context = Context::from_device(&device().id().into()).unwrap();
        let queue = CommandQueue::create_default_with_properties(&context, 0, 0).unwrap();
        let device = Device::from_queue(&queue).unwrap();
        let brick = brick(group, 2, 2);
        let mut all_bytes = random_bytes(DIMS, 5);
        (all_bytes[0], all_bytes[1]) = (0, 255);
        let mut held = held_bytes(&all_bytes, &brick).to_vec();
        // SAFETY: the buffer has as many bytes as there are voxels.
        let buffer = unsafe {
            let flags = CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR;
            Buffer::<u8>::create(&context, flags, held.len(), held.as_mut_ptr().cast()).unwrap()
        };
        let description = Description::new("on devices", grid.clone(), VoxelType::Uint8, (0.0, 255.0)).unwrap();
        let description = description.with_background(0.0).unwrap();
        Self { queue, device, brick, all_bytes, buffer, description }
    }

    pub fn voxels(&self) -> DeviceVoxels {
        DeviceVoxels::new(&DeviceMemory::from_buffer(&self.buffer).unwrap(), VoxelType::Uint8)
    }
}

/// The bytes of the layers that a brick along z holds.
pub fn held_bytes<'a>(all_bytes: &'a [u8], brick: &Brick) -> &'a [u8] {
    &all_bytes[DIMS[0] * DIMS[1] * brick.held.first[2]..][..brick.held.count()]
}
