//! Launchers of transpose.cl, occupancy.cl and visibility.cl.

use super::{VoxelBuffer, launch, params::VolumeView, voxel_defines};
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
    pub fn new(device: &Device, dims: [usize; 3], voxel_type: VoxelType) -> Result<Self, Error> {
        let blocks = [dims[0], dims[1]].map(|n| n.div_ceil(Self::BLOCK) + 2);
        let limits = VoxelBuffer::new(device, 2 * blocks[0] * blocks[1] * dims[2], voxel_type, "the occupancy")?;
        Ok(Self { limits, blocks: blocks.map(|b| b as i32), layers: dims[2] as i32 })
    }

    /// Flags that [`VisibilityKernel`] writes: one per block and layer −1 … n.
    pub fn flags(&self) -> usize {
        self.blocks[0] as usize * self.blocks[1] as usize * (self.layers as usize + 2)
    }
}

/// Fills an [`Occupancy`].
pub(crate) struct OccupancyKernel(Kernel);

impl OccupancyKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("occupancy", "volume"), &voxel_defines(voxel_type, 1))?))
    }

    pub fn launch(&self, device: &Device, voxels: &VoxelBuffer, view: &VolumeView, occupancy: &Occupancy) -> Result<(), Error> {
        let [blocks_u, blocks_v] = occupancy.blocks;
        let items = blocks_u as usize * blocks_v as usize * occupancy.layers as usize;
        let group = device.tuning().pixel_group;
        launch(device, "occupancy", &self.0, items, group, &[voxels, view, &blocks_u, &blocks_v, &occupancy.limits])
    }
}

/// Finds the blocks that can show anything with a transfer table.
pub(crate) struct VisibilityKernel(Kernel);

impl VisibilityKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("visibility", "volume"), &voxel_defines(voxel_type, 1))?))
    }

    /// The first pair is (background, offset), `table` is (first, per_value, last); background and table are less the
    /// offset. `visible_before` has last + 2 counts; `visible` takes [`Occupancy::flags`] bytes.
    pub fn launch(
        &self,
        device: &Device,
        occupancy: &Occupancy,
        (background, offset): (f32, f32),
        table: (f32, f32, i32),
        visible_before: &Buffer<u32>,
        visible: &Buffer<u8>,
    ) -> Result<(), Error> {
        let [blocks_u, blocks_v] = occupancy.blocks;
        let (first, per_value, last) = table;
        launch(
            device,
            "visibility",
            &self.0,
            occupancy.flags(),
            device.tuning().pixel_group,
            &[
                &occupancy.limits,
                &blocks_u,
                &blocks_v,
                &occupancy.layers,
                &background,
                &offset,
                &first,
                &per_value,
                &last,
                visible_before,
                visible,
            ],
        )
    }
}
