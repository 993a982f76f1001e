//! Volumes in buffers of the caller's own.

use crate::border::{Failure, Out, borrowed, guard};
use crate::opencl::{_cl_event, _cl_mem, WaitList};
use crate::{Device, Grid, Renderer, Status, Transfer, VoxelType};
use layersplat::device::DeviceMemory;
use layersplat::renderer::{DeviceVoxels, UploadedVolume};
use layersplat::volume::{self, Description};

/// Voxels in a buffer of the caller's on the device: they stay where they are.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Voxels {
    /// The cl_mem, in the device's context. It is retained as long as a renderer uses it.
    pub memory: *mut _cl_mem,
    /// A layersplat_voxel_type.
    pub voxel_type: i32,
    /// Whether some voxels may be NaN, infinite or beyond ±1e30, which then count as the smallest value: 1 or 0.
    pub invalid_voxels: i32,
    /// Byte of the first voxel: a multiple of a voxel's, as the pitches are.
    pub first: usize,
    /// Bytes from row to row; 0 with slice_pitch 0 is without gaps.
    pub row_pitch: usize,
    /// Bytes from slice to slice.
    pub slice_pitch: usize,
    /// Where the voxels lie in the world.
    pub grid: Grid,
    /// The smallest value that voxels will have. It is a promise: values beyond show as the range's ends do.
    pub smallest: f64,
    /// The largest value that voxels will have.
    pub largest: f64,
}

impl Voxels {
    fn voxel_type(&self) -> Result<volume::VoxelType, Failure> {
        Ok(VoxelType::chosen(self.voxel_type)?.into())
    }

    unsafe fn placed(&self) -> Result<DeviceVoxels, Failure> {
        // SAFETY: the caller's promise: the memory is alive.
        let memory = unsafe { DeviceMemory::from_raw(self.memory.cast()) }?;
        let voxels = DeviceVoxels::new(&memory, self.voxel_type()?).with_first(self.first);
        match (self.row_pitch, self.slice_pitch) {
            (0, 0) => Ok(voxels),
            (0, _) | (_, 0) => Err(Failure::invalid("row_pitch and slice_pitch: give both, or neither")),
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

/// Finds the smallest and the largest value of voxels, and whether some are invalid, by looking at all of them on the device, after
/// `wait_count` events; sets `smallest`, `largest` and `invalid_voxels`. It returns when they are found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_voxels_find_range(
    device: *const Device,
    voxels: *mut Voxels,
    wait_count: u32,
    wait_list: *const *mut _cl_event,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let device = unsafe { borrowed(device, "device") }?;
        let given = *unsafe { borrowed(voxels, "voxels") }?;
        let wait = unsafe { WaitList::new(wait_count, wait_list) }?;
        let found = unsafe { given.placed() }?.describe(&device.0, NAME, given.grid.checked()?, &wait.events())?;
        let (smallest, largest) = found.range();
        let invalid_voxels = i32::from(found.has_invalid_voxels());
        unsafe { Out::new(voxels, "voxels") }?.set(Voxels { smallest, largest, invalid_voxels, ..given });
        Ok(())
    })
}

/// A renderer of voxels that stay where they are. They may change from frame to frame, in the order of the queue and its events, if the
/// renderer is told so: layersplat_renderer_volume_changed().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_in_place(
    device: *const Device,
    voxels: *const Voxels,
    transfer: *const Transfer,
    renderer: *mut *mut Renderer,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(renderer, "renderer") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let voxels = unsafe { borrowed(voxels, "voxels") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        let placed = unsafe { voxels.placed() }?;
        let there = UploadedVolume::in_place(&device.0, &voxels.description()?, &placed)?;
        out.give(Renderer::new(Box::new(layersplat::Renderer::from_uploaded(&there, &transfer.0)?)));
        Ok(())
    })
}
