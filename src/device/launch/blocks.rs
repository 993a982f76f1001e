//! Layout of the min-max blocks.

use super::VoxelBuffer;
use crate::device::Device;
use crate::error::Error;
use crate::volume::VoxelType;

/// Minimum and maximum of each block for one layer axis: of all voxels in the kernel support of its cells, within a layer.
pub(crate) struct MinMaxBlocks {
    /// [`BlockNumbers::limits`] values.
    pub limits: VoxelBuffer,
    pub numbers: BlockNumbers,
}

impl MinMaxBlocks {
    /// Uninitialised blocks.
    pub fn new(device: &Device, numbers: BlockNumbers, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self { limits: VoxelBuffer::new(device, numbers.limits(), voxel_type, "the min-max blocks")?, numbers })
    }
}

/// Numbers of blocks for one layer axis.
#[derive(Clone, Copy)]
pub(crate) struct BlockNumbers {
    /// Blocks along u and v, including a margin of one on each side.
    pub blocks: [i32; 2],
    /// Voxels along the layer axis.
    pub layers: i32,
}

impl BlockNumbers {
    /// Voxels per block along u and v: `BLOCK_U` and `BLOCK_V` in kernels/shared/volume.cl.
    const BLOCK: [usize; 2] = [8, 4];

    /// For a volume of `dims` voxels along u, v, a.
    pub fn new(dims: [usize; 3]) -> Self {
        let blocks = [0, 1].map(|i| dims[i].div_ceil(Self::BLOCK[i]) + 2);
        Self { blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 }
    }

    /// Number of values that [`FillMinMaxBlocks`](super::volume::FillMinMaxBlocks) writes: two per block and layer.
    pub fn limits(&self) -> usize {
        2 * self.per_layer() * self.layers as usize
    }

    /// Bytes that [`SlabVisibility`](super::volume::SlabVisibility) writes: one bit per block and slab, and seven bytes of
    /// padding, since kernels read eight blocks at once.
    pub fn slab_bytes(&self, radius: i32) -> usize {
        self.per_layer() * self.chunks(radius) + 7
    }

    /// Blocks per layer.
    pub fn per_layer(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize
    }

    /// Number of slabs between layers to which a kernel of this radius contributes.
    pub fn slabs(&self, radius: i32) -> i32 {
        self.layers + 2 * radius - 1
    }

    /// Number of groups of eight slabs.
    pub fn chunks(&self, radius: i32) -> usize {
        self.slabs(radius).unsigned_abs().div_ceil(8) as usize
    }
}
