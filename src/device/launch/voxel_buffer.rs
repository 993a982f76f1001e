//! Voxels on the device, in any type.

use super::{Argument, Typed};
use crate::device::{Buffer, Device, DeviceMemory};
use crate::error::Error;
use crate::volume::{Held, VoxelType};
use opencl3::kernel::Kernel as ClKernel;

/// Voxels on the device, in any type. Kernels that read them are built for it.
pub(crate) struct VoxelBuffer {
    bytes: Buffer<u8>,
    voxel_type: VoxelType,
    /// Nobody has looked at the voxels: floats may be anything.
    unchecked: bool,
}

impl VoxelBuffer {
    /// An uninitialised buffer of `len` voxels.
    pub fn new(device: &Device, len: usize, voxel_type: VoxelType, what: &str) -> Result<Self, Error> {
        Ok(Self { bytes: Buffer::new(device, len * voxel_type.bytes(), what)?, voxel_type, unchecked: false })
    }

    /// Uninitialised voxels as many and as `others` of another layout are.
    pub fn like(device: &Device, len: usize, others: &VoxelBuffer, what: &str) -> Result<Self, Error> {
        Ok(Self { unchecked: others.unchecked, ..Self::new(device, len, others.voxel_type, what)? })
    }

    /// All that a buffer of the caller's own holds.
    pub fn of_memory(device: &Device, memory: &DeviceMemory, bytes: usize, voxel_type: VoxelType) -> Result<Self, Error> {
        let bytes = Buffer::of_memory(device, memory, bytes)?;
        Ok(Self { bytes, voxel_type, unchecked: voxel_type == VoxelType::Float32 })
    }

    /// A copy of voxels, the background in place of invalid ones, in a buffer with room for so many.
    pub fn upload_with_room(device: &Device, held: &Held, room: usize) -> Result<Self, Error> {
        let description = held.description;
        let mut voxels = Self::new(device, room, description.voxel_type(), description.name())?;
        voxels.refill(device, held)?;
        Ok(voxels)
    }

    /// Copies other voxels into this buffer, no more than there is room for.
    pub fn refill(&mut self, device: &Device, held: &Held) -> Result<(), Error> {
        held.for_each_piece(|first, bytes| self.bytes.write_at(device, first, bytes))
    }

    /// Layers of bytes, `stride` bytes apart.
    #[cfg(test)]
    pub fn with_gaps<'a>(device: &Device, layers: impl ExactSizeIterator<Item = &'a [u8]>, stride: usize) -> Result<Self, Error> {
        let mut voxels = Self::new(device, layers.len() * stride, VoxelType::Uint8, "a volume with gaps")?;
        layers.enumerate().try_for_each(|(n, layer)| voxels.bytes.write_at(device, n * stride, layer))?;
        Ok(voxels)
    }

    /// Whether the buffer was made here, and is no memory of the caller.
    pub fn is_owned(&self) -> bool {
        self.bytes.is_owned()
    }

    /// Their type.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// How many bytes they take.
    pub fn bytes(&self) -> usize {
        self.bytes.bytes()
    }

    /// What kernels that read them are built for.
    pub fn kind(&self) -> VoxelKind {
        VoxelKind { voxel_type: self.voxel_type, far: is_far(self.bytes()), unchecked: self.unchecked }
    }
}

/// Voxels of floats, for kernels that take nothing else.
pub(crate) struct Floats<'a>(pub &'a VoxelBuffer);

impl Argument for Floats<'_> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        debug_assert_eq!(self.0.voxel_type(), VoxelType::Float32);
        self.0.set(kernel, index)
    }
}

impl Typed for Floats<'_> {
    const BYTES: usize = 0;

    fn name() -> String {
        "float*".into()
    }
}

/// What kernels that read voxels are built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct VoxelKind {
    pub voxel_type: VoxelType,
    /// Two voxels can lie farther apart than an int counts in bytes.
    pub far: bool,
    /// Floats may be anything.
    pub unchecked: bool,
}

/// Whether voxels of so many bytes are far apart. A row of four is read at once.
fn is_far(bytes: usize) -> bool {
    bytes > i32::MAX as usize - 64
}

impl Argument for &VoxelBuffer {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        (&self.bytes).set(kernel, index)
    }
}

impl Typed for &VoxelBuffer {
    const BYTES: usize = 0;

    fn name() -> String {
        "VOXEL*".into()
    }
}
