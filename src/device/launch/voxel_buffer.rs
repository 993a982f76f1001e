//! Voxel buffers.

use super::{Argument, Extras, Parameter};
use crate::device::{Buffer, Device, DeviceMemory};
use crate::error::Error;
use crate::progress;
use crate::volume::{Held, VoxelType};
use opencl3::kernel::Kernel as ClKernel;
use std::path::Path;

/// Voxels of any type on the device. Kernels that read them are built for the type.
pub(crate) struct VoxelBuffer {
    bytes: Buffer<u8>,
    voxel_type: VoxelType,
    /// The values were not validated: floats may be NaN or infinite.
    unchecked: bool,
}

impl VoxelBuffer {
    /// An uninitialised buffer of `len` voxels.
    pub fn new(device: &Device, len: usize, voxel_type: VoxelType, what: &str) -> Result<Self, Error> {
        Ok(Self { bytes: Buffer::new(device, len * voxel_type.bytes(), what)?, voxel_type, unchecked: false })
    }

    /// An uninitialised buffer of `len` voxels with the type of `others`, for another layout of the same data.
    pub fn like(device: &Device, len: usize, others: &VoxelBuffer, what: &str) -> Result<Self, Error> {
        Ok(Self { unchecked: others.unchecked, ..Self::new(device, len, others.voxel_type, what)? })
    }

    /// Wraps the first `bytes` bytes of the caller's buffer.
    pub fn from_memory(device: &Device, memory: &DeviceMemory, bytes: usize, voxel_type: VoxelType) -> Result<Self, Error> {
        let bytes = Buffer::from_memory(device, memory, bytes)?;
        Ok(Self { bytes, voxel_type, unchecked: voxel_type == VoxelType::Float32 })
    }

    /// Fails if a buffer of `capacity` voxels is larger than the device supports.
    pub fn check_capacity(device: &Device, capacity: usize, voxel_type: VoxelType, what: &str) -> Result<(), Error> {
        Buffer::<u8>::check_size(device, capacity * voxel_type.bytes(), what)
    }

    /// Uploads voxels, with the background in place of invalid ones, to a buffer of `capacity` voxels.
    pub fn upload_with_capacity(device: &Device, held: &Held, capacity: usize) -> Result<Self, Error> {
        let description = held.description;
        let mut voxels = Self::new(device, capacity, description.voxel_type(), description.name())?;
        voxels.refill(device, held)?;
        Ok(voxels)
    }

    /// Uploads other voxels, which must fit into this buffer.
    pub fn refill(&mut self, device: &Device, held: &Held) -> Result<(), Error> {
        /// Bytes that are written at once: frames of other renderers are drawn between.
        const PIECE: usize = 16 << 20;
        held.for_each_piece(|first, bytes| {
            let mut pieces = bytes.chunks(PIECE).enumerate();
            pieces.try_for_each(|(n, piece)| {
                progress::check().map_err(|e| Error::read(Path::new(held.description.name()), e))?;
                self.bytes.write_at(device, first + n * PIECE, piece)
            })
        })
    }

    /// Uploads layers of bytes, `stride` bytes apart.
    #[cfg(test)]
    pub fn with_gaps<'a>(device: &Device, layers: impl ExactSizeIterator<Item = &'a [u8]>, stride: usize) -> Result<Self, Error> {
        let mut voxels = Self::new(device, layers.len() * stride, VoxelType::Uint8, "a volume with gaps")?;
        layers.enumerate().try_for_each(|(n, layer)| voxels.bytes.write_at(device, n * stride, layer))?;
        Ok(voxels)
    }

    /// Whether the buffer was allocated here, rather than by the caller.
    pub fn is_owned(&self) -> bool {
        self.bytes.is_owned()
    }

    /// Voxel type.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes.bytes()
    }

    /// Program permutation of kernels that read these voxels.
    pub fn kind(&self) -> VoxelKind {
        VoxelKind { voxel_type: self.voxel_type, far: is_far(self.bytes()), unchecked: self.unchecked }
    }
}

/// Float voxels, for kernels that support no other type.
#[derive(Clone, Copy)]
pub(crate) struct Floats<'a>(pub &'a VoxelBuffer);

impl Argument for Floats<'_> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        debug_assert_eq!(self.0.voxel_type(), VoxelType::Float32);
        self.0.set(kernel, index)
    }

    fn parameters(name: &str, _: Extras) -> Vec<Parameter> {
        Parameter::buffer(name, "float")
    }
}

/// Program permutation of kernels that read voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct VoxelKind {
    pub voxel_type: VoxelType,
    /// Byte offsets between voxels may exceed an int.
    pub far: bool,
    /// Floats may be NaN or infinite.
    pub unchecked: bool,
}

/// Whether byte offsets within a buffer of this size may exceed an int. The margin covers reads of four voxels at once.
fn is_far(bytes: usize) -> bool {
    bytes > i32::MAX as usize - 64
}

impl Argument for &VoxelBuffer {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        (&self.bytes).set(kernel, index)
    }

    fn parameters(name: &str, _: Extras) -> Vec<Parameter> {
        Parameter::buffer(name, "VOXEL")
    }
}
