//! Launchers of lattice.cl and lattice_perspective.cl.

use super::params::{Float4, LatticeParams, LayerOffset, RayLatticeParams, SampleParams, VolumeView};
use super::{VoxelBuffer, launch, voxel_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel;

fn tile_defines(device: &Device, voxel_type: VoxelType) -> String {
    let tuning = device.tuning();
    let voxels = voxel_defines(voxel_type, tuning.vector_width);
    format!("{voxels} -DTILE_VECTORS={} -DTILE_ROWS={}", tuning.tile_vectors, tuning.tile_rows)
}

/// Renders the lattice of a parallel view.
pub(crate) struct LatticeKernel(Kernel);

/// What [`LatticeKernel`] reads and writes.
pub(crate) struct LatticeArguments<'a> {
    pub voxels: &'a VoxelBuffer,
    pub view: VolumeView,
    pub offsets: [&'a Buffer<LayerOffset>; 2],
    pub weights: &'a Buffer<f32>,
    pub visible: &'a Buffer<u8>,
    pub table: &'a Buffer<Float4>,
    pub slabs: &'a Buffer<Float4>,
    pub params: LatticeParams,
    pub sample: SampleParams,
    /// RGBA of columns·m by rows·m samples.
    pub lattice: &'a Buffer<Float4>,
    /// One count per tile.
    pub active_samples: &'a Buffer<u32>,
}

impl LatticeKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        let source = source!("lattice", "volume", "footprint", "elementary", "table_entries", "shading", "sample");
        Ok(Self(device.kernel(&source, &tile_defines(device, voxel_type))?))
    }

    /// Number of tiles of a lattice.
    pub fn tiles(params: &LatticeParams) -> usize {
        params.samples_per_voxel.iter().chain(&params.tiles).map(|&n| n as usize).product()
    }

    pub fn launch(&self, device: &Device, a: &LatticeArguments) -> Result<(), Error> {
        launch(
            device,
            "lattice",
            &self.0,
            Self::tiles(&a.params),
            device.tuning().tile_group,
            &[
                a.voxels,
                &a.view,
                a.offsets[0],
                a.offsets[1],
                a.weights,
                a.visible,
                a.table,
                a.slabs,
                &a.params,
                &a.sample,
                a.lattice,
                a.active_samples,
            ],
        )
    }
}

/// Renders the lattice of a perspective.
pub(crate) struct PerspectiveKernel(Kernel);

/// What [`PerspectiveKernel`] reads and writes.
pub(crate) struct PerspectiveArguments<'a> {
    pub voxels: &'a VoxelBuffer,
    pub view: VolumeView,
    /// (crossing, shear) of each column and each row.
    pub crossings: [&'a Buffer<[f32; 2]>; 2],
    /// (z, weight) of eight nodes.
    pub nodes: &'a Buffer<[f32; 2]>,
    pub visible: &'a Buffer<u8>,
    pub table: &'a Buffer<Float4>,
    pub slabs: &'a Buffer<Float4>,
    pub params: RayLatticeParams,
    pub sample: SampleParams,
    /// RGBA of width by height samples.
    pub lattice: &'a Buffer<Float4>,
    /// One count per tile.
    pub active_samples: &'a Buffer<u32>,
}

impl PerspectiveKernel {
    pub fn new(device: &Device, voxel_type: VoxelType) -> Result<Self, Error> {
        let source = source!("lattice_perspective", "volume", "ray_lattice", "elementary", "table_entries", "shading", "sample");
        Ok(Self(device.kernel(&source, &format!("{} -DPER_RAY_STEP", tile_defines(device, voxel_type)))?))
    }

    pub fn launch(&self, device: &Device, a: &PerspectiveArguments) -> Result<(), Error> {
        launch(
            device,
            "lattice",
            &self.0,
            a.params.tiles.iter().map(|&n| n as usize).product(),
            device.tuning().tile_group,
            &[
                a.voxels,
                &a.view,
                a.crossings[0],
                a.crossings[1],
                a.nodes,
                a.visible,
                a.table,
                a.slabs,
                &a.params,
                &a.sample,
                a.lattice,
                a.active_samples,
            ],
        )
    }
}
