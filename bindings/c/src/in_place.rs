//! Volumes in the caller's OpenCL buffers.

use crate::boundary::{Failure, Out, borrowed, guard};
use crate::opencl::{_cl_event, _cl_mem, WaitList};
use crate::{Device, Grid, Renderer, Status, Transfer, VoxelType};
use layersplat::device::DeviceMemory;
use layersplat::renderer::{DeviceVoxels, UploadedVolume};
use layersplat::volume::{self, Description};

/// Voxels in a buffer of the caller on the device. They are rendered in place, without a copy.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Voxels {
    /// The cl_mem, in the device's context. It is retained as long as a renderer uses it.
    pub memory: *mut _cl_mem,
    /// A layersplat_voxel_type.
    pub voxel_type: i32,
    /// Whether voxels may be NaN, infinite or beyond ±1e30: 1 or 0. Such voxels count as the smallest value.
    pub invalid_voxels: i32,
    /// Byte offset of the first voxel. Offset and pitches are multiples of the voxel size.
    pub first: usize,
    /// Bytes from row to row. If this and slice_pitch are 0, the voxels are contiguous.
    pub row_pitch: usize,
    /// Bytes from slice to slice.
    pub slice_pitch: usize,
    /// The grid of the voxels.
    pub grid: Grid,
    /// The smallest value that voxels will have. It is not checked: values outside the range are clamped to it.
    pub smallest: f64,
    /// The largest value that voxels will have.
    pub largest: f64,
}

impl Voxels {
    fn voxel_type(&self) -> Result<volume::VoxelType, Failure> {
        Ok(VoxelType::from_number(self.voxel_type)?.into())
    }

    unsafe fn device_voxels(&self) -> Result<DeviceVoxels, Failure> {
        // SAFETY: upheld by the caller: the memory is alive.
        let memory = unsafe { DeviceMemory::from_raw(self.memory.cast()) }?;
        let voxels = DeviceVoxels::new(&memory, self.voxel_type()?).with_first(self.first);
        match (self.row_pitch, self.slice_pitch) {
            (0, 0) => Ok(voxels),
            (0, _) | (_, 0) => Err(Failure::invalid("row_pitch and slice_pitch: set both or neither")),
            (row, slice) => Ok(voxels.with_pitches(row, slice)),
        }
    }

    fn description(&self) -> Result<Description, Failure> {
        let grid = self.grid.checked()?;
        let description = Description::new(NAME, grid, self.voxel_type()?, (self.smallest, self.largest))?;
        match self.invalid_voxels {
            0 => Ok(description),
            1 => Ok(description.with_invalid_voxels()),
            n => Err(Failure::invalid(format!("invalid_voxels is {n}: expected 0 or 1"))),
        }
    }
}

const NAME: &str = "voxels on the device";

/// Determines the range of the voxels on the device, after `wait_count` events. Sets `smallest`, `largest` and `invalid_voxels`.
/// The call blocks until they are known.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_voxels_find_range(
    device: *const Device,
    voxels: *mut Voxels,
    wait_count: u32,
    wait_list: *const *mut _cl_event,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let device = unsafe { borrowed(device, "device") }?;
        let described = *unsafe { borrowed(voxels, "voxels") }?;
        let wait = unsafe { WaitList::new(wait_count, wait_list) }?;
        let found = unsafe { described.device_voxels() }?.describe(&device.0, NAME, described.grid.checked()?, &wait.events())?;
        let (smallest, largest) = found.range();
        let invalid_voxels = i32::from(found.has_invalid_voxels());
        unsafe { Out::new(voxels, "voxels") }?.set(Voxels { smallest, largest, invalid_voxels, ..described });
        Ok(())
    })
}

/// Creates a renderer of voxels in a buffer of the caller, without copying them. The voxels may change between frames, ordered by
/// the queue and events. Call layersplat_renderer_volume_changed() after each change. To be freed by layersplat_renderer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_in_place(
    device: *const Device,
    voxels: *const Voxels,
    transfer: *const Transfer,
    renderer: *mut *mut Renderer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(renderer, "renderer") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let voxels = unsafe { borrowed(voxels, "voxels") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        let device_voxels = unsafe { voxels.device_voxels() }?;
        let uploaded = UploadedVolume::in_place(&device.0, &voxels.description()?, &device_voxels)?;
        out.set_handle(Renderer::new(Box::new(layersplat::Renderer::from_uploaded(&uploaded, &transfer.0)?)));
        Ok(())
    })
}
