//! Launchers of transpose.cl, occupancy.cl, visibility.cl and slab_visibility.cl.

use super::{Argument, VoxelBuffer, launch, params::VolumeView, voxel_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel;

/// Makes the layout of layer axis x.
pub(crate) struct TransposeKernel(Kernel);

impl TransposeKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("transpose"), &voxel_defines(voxel_type, 1))?))
    }

    /// `dims` are those of `voxels` along x, y, z; `transposed` is as long.
    pub fn launch(&self, device: &Device, voxels: &VoxelBuffer, dims: [i32; 3], transposed: &VoxelBuffer) -> Result<(), Error> {
        let rows = dims[0] as usize * dims[2] as usize;
        let group = device.tuning().pixel_group;
        launch(device, "transpose", &self.0, rows, group, &[voxels, &dims[0], &dims[1], &dims[2], transposed])
    }
}

/// Blocks of an occupancy, and how far samples reach for voxels around theirs, within a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reach {
    pub below: i32,
    pub above: i32,
    /// How many layers to either side.
    pub around: i32,
    /// Rows of a block.
    pub rows: i32,
}

impl Reach {
    /// Splat sums of three layers, |s| ≤ 1: 1 + |s| around their crossings, |s| to either side.
    pub const SPLATS: Reach = Reach { below: 3, above: 4, around: 0, rows: 8 };
    /// Point samples at either end of a slab, |s| ≤ 1.
    pub const POINTS: Reach = Reach { below: 1, above: 2, around: 0, rows: 4 };
    /// Points between two layers, reconstructed with a kernel of radius 2.
    pub const GAUSSIAN: Reach = Reach { below: 1, above: 2, around: 1, rows: 4 };
}

/// Smallest and largest value in reach of each block of a layer axis.
pub(crate) struct Occupancy {
    /// Two voxels per block and layer.
    pub limits: VoxelBuffer,
    /// Blocks along u and v, a margin of one on each side included.
    pub blocks: [i32; 2],
    /// Voxels along the layer axis.
    pub layers: i32,
}

impl Occupancy {
    /// Voxels per block and in-layer axis: `BLOCK` in kernels/volume.cl.
    const BLOCK: usize = 8;

    /// An uninitialised occupancy for a volume of `dims` voxels along u, v, a.
    pub fn new(device: &Device, dims: [usize; 3], voxel_type: VoxelType, reach: Reach) -> Result<Self, Error> {
        let blocks = [dims[0].div_ceil(Self::BLOCK) + 2, dims[1].div_ceil(reach.rows as usize) + 2];
        let limits = VoxelBuffer::new(device, 2 * blocks[0] * blocks[1] * dims[2], voxel_type, "the occupancy")?;
        Ok(Self { limits, blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 })
    }

    /// Flags that [`VisibilityKernel`] writes: one per block and layer −1 … n.
    pub fn flags(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize * (self.layers as usize + 2)
    }

    /// Bytes that [`SlabVisibilityKernel`] writes, a bit per block and slab 0 … n, and seven more:
    /// kernels read eight blocks at once.
    pub fn slab_bytes(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize * (self.layers as usize / 8 + 1) + 7
    }
}

/// Fills an [`Occupancy`].
pub(crate) struct OccupancyKernel(Kernel);

impl OccupancyKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("occupancy", "volume"), &voxel_defines(voxel_type, 1))?))
    }

    pub fn launch(
        &self,
        device: &Device,
        voxels: &VoxelBuffer,
        view: &VolumeView,
        reach: Reach,
        occupancy: &Occupancy,
    ) -> Result<(), Error> {
        let [blocks_u, blocks_v] = occupancy.blocks;
        let items = blocks_u as usize * blocks_v as usize * occupancy.layers as usize;
        let group = device.tuning().pixel_group;
        launch(
            device,
            "occupancy",
            &self.0,
            items,
            group,
            &[voxels, view, &blocks_u, &blocks_v, &reach.rows, &reach.below, &reach.above, &reach.around, &occupancy.limits],
        )
    }
}

/// What decides which blocks are visible.
pub(crate) struct Visibility<'a> {
    pub occupancy: &'a Occupancy,
    /// Less the offset.
    pub background: f32,
    /// Taken from every voxel.
    pub offset: f32,
    /// Value of the first table entry less the offset, entries per value, index of the last entry.
    pub table: (f32, f32, i32),
    /// How many entries before each one are visible; last + 2 counts.
    pub visible_before: &'a Buffer<u32>,
}

impl Visibility<'_> {
    fn launch(
        &self,
        device: &Device,
        stage: &'static str,
        kernel: &Kernel,
        items: usize,
        out: &[&dyn Argument],
    ) -> Result<(), Error> {
        let Self { occupancy, background, offset, table: (first, per_value, last), visible_before } = self;
        let [blocks_u, blocks_v] = &occupancy.blocks;
        let layers = &occupancy.layers;
        let input: [&dyn Argument; 10] =
            [&occupancy.limits, blocks_u, blocks_v, layers, background, offset, first, per_value, last, *visible_before];
        launch(device, stage, kernel, items, device.tuning().pixel_group, &[&input as &[&dyn Argument], out].concat())
    }
}

/// Finds the blocks that can show anything with splatted layers.
pub(crate) struct VisibilityKernel(Kernel);

impl VisibilityKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("visibility", "volume", "elementary", "opacity_range"), &voxel_defines(voxel_type, 1))?))
    }

    /// `flags` takes [`Occupancy::flags`] bytes.
    pub fn launch(&self, device: &Device, visibility: &Visibility, flags: &Buffer<u8>) -> Result<(), Error> {
        visibility.launch(device, "visibility", &self.0, visibility.occupancy.flags(), &[flags])
    }
}

/// Finds the blocks that can show anything with point-sampled layers.
pub(crate) struct SlabVisibilityKernel(Kernel);

impl SlabVisibilityKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self(
            device.kernel(&source!("slab_visibility", "volume", "elementary", "opacity_range"), &voxel_defines(voxel_type, 1))?,
        ))
    }

    /// `around`: blocks to either side that are in reach; `slack`: by how much sums of kernels overshoot. `bits` takes
    /// [`Occupancy::slab_bytes`].
    pub fn launch(
        &self,
        device: &Device,
        visibility: &Visibility,
        around: i32,
        slack: f32,
        bits: &Buffer<u8>,
    ) -> Result<(), Error> {
        visibility.launch(device, "visibility", &self.0, visibility.occupancy.slab_bytes(), &[&around, &slack, bits])
    }
}
