//! Min-max blocks: how many there are, and what they reach.

use super::VoxelBuffer;
use crate::device::Device;
use crate::error::Error;
use crate::volume::VoxelType;

/// Blocks of voxels, and how far samples reach for voxels around theirs, within a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Reach {
    pub below: i32,
    pub above: i32,
    /// Rows of a block.
    pub rows: i32,
}

impl Reach {
    /// Splat sums of three layers, |s| ≤ 1: 1 + |s| around their crossings, |s| to either side.
    pub const SPLATS: Reach = Reach { below: 3, above: 4, rows: 8 };

    /// Point samples at either end of a slab, |s| ≤ 1, of a kernel of a radius.
    pub const fn points(radius: i32) -> Reach {
        Reach { below: radius, above: radius + 1, rows: 4 }
    }
}

/// Smallest and largest value in reach of each block of a layer axis.
pub(crate) struct MinMaxBlocks {
    /// As many as [`BlockNumbers::limits`].
    pub limits: VoxelBuffer,
    pub numbers: BlockNumbers,
}

impl MinMaxBlocks {
    /// Uninitialised ones for a volume of `dims` voxels along u, v, a.
    pub fn new(device: &Device, dims: [usize; 3], voxel_type: VoxelType, reach: Reach) -> Result<Self, Error> {
        let numbers = BlockNumbers::of(dims, reach);
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
    /// Voxels per block and in-layer axis: `BLOCK` in kernels/shared/volume.cl.
    const BLOCK: usize = 8;

    /// Of a volume of `dims` voxels along u, v, a.
    pub fn of(dims: [usize; 3], reach: Reach) -> Self {
        let blocks = [dims[0].div_ceil(Self::BLOCK) + 2, dims[1].div_ceil(reach.rows as usize) + 2];
        Self { blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 }
    }

    /// Voxels that [`FillMinMaxBlocks`](super::volume::FillMinMaxBlocks) writes, two per block and layer.
    pub fn limits(&self) -> usize {
        2 * self.per_layer() * self.layers as usize
    }

    /// Flags that [`Visibility`](super::volume::Visibility) writes: one per block and layer −1 … n.
    pub fn flags(&self) -> usize {
        self.per_layer() * (self.layers as usize + 2)
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
