//! Volumes in the caller's device memory.

use super::{Field, Placement, UploadedVolume};
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::{ValueRange, ValueRangeArguments};
use crate::device::launch::{Launcher, VoxelBuffer};
use crate::device::{Buffer, Device, DeviceMemory, MemoryKind};
use crate::error::Error;
use crate::volume::{Description, Grid, VoxelBox, VoxelType};
use opencl3::event::Event;

/// Number of parts of the range search: enough for the threads of any device.
const PARTS: usize = 1024;

const WHAT: &str = "the voxel buffer";

/// Voxels of one type in the caller's buffer, x fastest, with given row and slice pitches.
///
/// ```
/// use layersplat::Device;
/// use layersplat::device::DeviceMemory;
/// use layersplat::glam::DVec3;
/// use layersplat::renderer::{DeviceVoxels, UploadedVolume};
/// use layersplat::volume::{Grid, VoxelType};
/// # use layersplat::opencl3::{command_queue::CommandQueue, context::Context, memory::{Buffer, CL_MEM_READ_WRITE}};
/// # let context = Context::from_device(&layersplat::Device::open(&layersplat::DeviceChoice::Default)?.id().into()).expect("a context");
/// # let queue = CommandQueue::create_default_with_properties(&context, 0, 0).expect("a queue");
/// # let voxels = vec![7u8; 100 + 8 * 12 * 12];
/// # use layersplat::opencl3::memory::CL_MEM_COPY_HOST_PTR;
/// # let flags = CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR;
/// # let buffer = unsafe { Buffer::<u8>::create(&context, flags, voxels.len(), voxels.as_ptr().cast_mut().cast()) }.expect("a buffer");
///
/// // 8³ voxels whose rows are 12 apart, behind 100 others.
/// let device = Device::from_queue(&queue)?;
/// let voxels = DeviceVoxels::new(&DeviceMemory::from_buffer(&buffer)?, VoxelType::Uint8).with_first(100).with_pitches(12, 12 * 12);
/// let description = voxels.describe(&device, "constant", Grid::new([8; 3], DVec3::ONE)?, &[])?;
/// assert_eq!(description.range(), (7.0, 7.0));
/// let volume = UploadedVolume::in_place(&device, &description, &voxels)?;
/// assert!(volume.is_whole());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct DeviceVoxels {
    memory: DeviceMemory,
    voxel_type: VoxelType,
    first: usize,
    row_pitch: Option<usize>,
    slice_pitch: Option<usize>,
}

impl DeviceVoxels {
    /// Voxels from the beginning of a buffer, without gaps.
    pub fn new(memory: &DeviceMemory, voxel_type: VoxelType) -> Self {
        Self { memory: memory.clone(), voxel_type, first: 0, row_pitch: None, slice_pitch: None }
    }

    /// Sets the byte offset of the first voxel in the buffer.
    pub fn with_first(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// Sets the row and slice pitches in bytes.
    pub fn with_pitches(self, row: usize, slice: usize) -> Self {
        Self { row_pitch: Some(row), slice_pitch: Some(slice), ..self }
    }

    /// Describes a volume of these voxels. The range is found by reading all voxels on the device, after the events `wait`; this
    /// call waits for the result. If the range is known, pass it to [`Description::new`] instead.
    ///
    /// # Errors
    /// If the buffer is too small or of another context, and OpenCL errors.
    pub fn describe(&self, device: &Device, name: impl Into<String>, grid: Grid, wait: &[&Event]) -> Result<Description, Error> {
        let dims = grid.dims();
        let (voxels, placed) = self.placed(device, dims)?;
        let (range, invalid) = value_range(device, &voxels, placed, dims, wait)?;
        let description = Description::new(name, grid, self.voxel_type, range)?;
        description.warn_of_values(invalid);
        Ok(if invalid > 0 { description.with_invalid_voxels() } else { description })
    }

    /// The buffer, and the placement of the voxels of a grid in it.
    fn placed(&self, device: &Device, dims: [usize; 3]) -> Result<(VoxelBuffer, Placement), Error> {
        self.memory.check(device, WHAT, false)?;
        let refuse = |problem: String| Err(Error::Memory { what: WHAT, problem });
        let MemoryKind::Buffer { bytes } = self.memory.kind() else { return refuse("is an image: make it a buffer".into()) };
        let size = self.voxel_type.bytes();
        let row = self.row_pitch.unwrap_or(dims[0].saturating_mul(size));
        let slice = self.slice_pitch.unwrap_or(dims[1].saturating_mul(row));
        let [x, y, z] = dims.map(|n| n as u128);
        let end = self.first as u128 + (z - 1) * slice as u128 + (y - 1) * row as u128 + x * size as u128;
        if [self.first, row, slice].iter().any(|n| n % size != 0) {
            let problem = format!(
                "has its first voxel at byte {}, rows {row} and layers {slice} bytes apart: all must be multiples of the voxel size {size}",
                self.first
            );
            return refuse(problem);
        }
        if row < dims[0] * size || (slice as u128) < row as u128 * (y - 1) + x * size as u128 {
            return refuse(format!(
                "has rows {row} and layers {slice} bytes apart, which overlap: {dims:?} voxels of {size} bytes need more"
            ));
        }
        if end > bytes as u128 {
            return refuse(format!("has {bytes} bytes, but {dims:?} voxels of {} end at byte {end}", self.voxel_type));
        }
        let placed = Placement { first: (self.first / size) as i64, row: (row / size) as i64, slice: (slice / size) as i64 };
        Ok((VoxelBuffer::from_memory(device, &self.memory, bytes, self.voxel_type)?, placed))
    }
}

/// Smallest and largest valid voxel, 0 if none is valid, and the number of invalid ones. Waits for the result.
pub(in crate::renderer) fn value_range(
    device: &Device,
    voxels: &VoxelBuffer,
    placed: Placement,
    dims: [usize; 3],
    wait: &[&Event],
) -> Result<((f64, f64), u64), Error> {
    let parts = PARTS.min(dims[1] * dims[2]);
    let (least, largest) = (Buffer::new(device, parts, "a range")?, Buffer::new(device, parts, "a range")?);
    let invalid = Buffer::new(device, parts, "a range")?;
    let view = VolumeView {
        stride: [1, placed.row, placed.slice],
        first: placed.first,
        dims: dims.map(|n| n as i32),
        background: 0.0,
        offset: 0.0,
        first_a: 0,
    };
    let arguments =
        ValueRangeArguments { voxels, view, parts: parts as i32, least: &least, largest: &largest, invalid: &invalid };
    let device = &device.with_own_sequence();
    device.begin(wait)?;
    Launcher::<ValueRange>::default().launch(device, voxels.voxel_type(), &arguments)?;
    let (mut lo, mut hi, mut odd) = (vec![0f32; parts], vec![0f32; parts], vec![0u32; parts]);
    least.read(device, &mut lo)?;
    largest.read(device, &mut hi)?;
    invalid.read(device, &mut odd)?;
    let (lo, hi) = (lo.into_iter().fold(f32::INFINITY, f32::min), hi.into_iter().fold(f32::NEG_INFINITY, f32::max));
    let range = if lo <= hi { (f64::from(lo), f64::from(hi)) } else { (0.0, 0.0) };
    Ok((range, odd.into_iter().map(u64::from).sum()))
}

impl UploadedVolume {
    /// A volume whose voxels stay in the caller's buffer, which is retained. It must be of the device's context.
    ///
    /// The voxels may change between frames, ordered by the queue and its events, if every renderer is notified with
    /// [`volume_changed`](crate::Renderer::volume_changed). The caller guarantees the range of the description; values outside it
    /// are rendered as its ends. Floats that are NaN, infinite or beyond ±1e30 count as the background.
    ///
    /// # Errors
    /// If the buffer is too small, of another context or write-only, and if pitches overlap or are not multiples of a voxel.
    pub fn in_place(device: &Device, description: &Description, voxels: &DeviceVoxels) -> Result<Self, Error> {
        Self::part_in_place(device, description, VoxelBox::whole(description.grid().dims()), voxels)
    }

    /// Like [`in_place`](Self::in_place) for a box of the described volume, for a
    /// [`PartRenderer`](crate::renderer::PartRenderer).
    pub fn part_in_place(
        device: &Device,
        description: &Description,
        part: VoxelBox,
        voxels: &DeviceVoxels,
    ) -> Result<Self, Error> {
        if description.voxel_type() != voxels.voxel_type {
            let problem = format!("holds {}, but the description says {}", voxels.voxel_type, description.voxel_type());
            return Err(Error::Memory { what: WHAT, problem });
        }
        let all = VoxelBox::whole(description.grid().dims());
        if part.count() == 0 || !all.holds(&part) {
            return Err(Error::Memory {
                what: WHAT,
                problem: format!("holds {part:?}, which must be a non-empty part of {:?} voxels", all.dims),
            });
        }
        let (voxels, placed) = voxels.placed(device, part.dims)?;
        Ok(Self { device: device.clone(), field: Field::new(description, part, voxels, placed, true) })
    }
}
