//! Min-max blocks: how many there are, and which voxels are in them.

use super::VoxelBuffer;
use crate::device::Device;
use crate::error::Error;
use crate::volume::VoxelType;

/// Smallest and largest value of each block of a layer axis: what a kernel of a radius mixes in its cells, within a layer.
pub(crate) struct MinMaxBlocks {
    /// As many as [`BlockNumbers::limits`].
    pub limits: VoxelBuffer,
    pub numbers: BlockNumbers,
}

impl MinMaxBlocks {
    /// Uninitialised blocks.
    pub fn new(device: &Device, numbers: BlockNumbers, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self { limits: VoxelBuffer::new(device, numbers.limits(), voxel_type, "the min-max blocks")?, numbers })
    }
}

/// How many blocks a layer axis has.
#[derive(Clone, Copy)]
pub(crate) struct BlockNumbers {
    /// Blocks along u and v, a margin of one on each side included.
    pub blocks: [i32; 2],
    /// Voxels along the layer axis.
    pub layers: i32,
}

impl BlockNumbers {
    /// Voxels of a block along u and v: `BLOCK_U` and `BLOCK_V` in kernels/shared/volume.cl.
    const BLOCK: [usize; 2] = [8, 4];

    /// Of a volume of `dims` voxels along u, v, a.
    pub fn of(dims: [usize; 3]) -> Self {
        let blocks = [0, 1].map(|i| dims[i].div_ceil(Self::BLOCK[i]) + 2);
        Self { blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 }
    }

    /// Voxels that [`FillMinMaxBlocks`](super::volume::FillMinMaxBlocks) writes, two per block and layer.
    pub fn limits(&self) -> usize {
        2 * self.per_layer() * self.layers as usize
    }

    /// Bytes that [`SlabVisibility`](super::volume::SlabVisibility) writes, a bit per block and slab, and seven more: kernels read eight blocks at once.
    pub fn slab_bytes(&self, radius: i32) -> usize {
        self.per_layer() * self.chunks(radius) + 7
    }

    /// Blocks of a layer.
    pub fn per_layer(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize
    }

    /// The spaces between layers that a kernel of a radius fills.
    pub fn slabs(&self, radius: i32) -> i32 {
        self.layers + 2 * radius - 1
    }

    /// Groups of eight slabs.
    pub fn chunks(&self, radius: i32) -> usize {
        self.slabs(radius).unsigned_abs().div_ceil(8) as usize
    }
}
