//! Launchers of direct.cl and point_direct.cl.

use super::params::{DirectParams, Float4, SampleParams};
use super::points::Stretches;
use super::{VoxelBuffer, launch, voxel_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel;

/// Renders per screen pixel.
pub(crate) struct DirectKernel(Kernel);

/// What [`DirectKernel`] reads and writes.
pub(crate) struct DirectArguments<'a> {
    pub voxels: &'a VoxelBuffer,
    /// For layer axes x, y, z; only those that `params.axis` needs are read.
    pub visible: [&'a Buffer<u8>; 3],
    pub table: &'a Buffer<Float4>,
    pub slabs: &'a Buffer<Float4>,
    /// Footprint images and their shears; read only by a kernel built for them.
    pub images: &'a Buffer<u8>,
    pub shears: &'a Buffer<[f32; 2]>,
    pub params: DirectParams,
    pub sample: SampleParams,
    pub size: [i32; 2],
    pub frame: &'a Buffer<Float4>,
    /// One count per pixel.
    pub active_samples: &'a Buffer<u32>,
}

impl DirectKernel {
    /// With exact footprints, or with those of the set.
    pub fn new(device: &Device, voxel_type: VoxelType, footprint_set: bool) -> Result<Self, Error> {
        let set = if footprint_set { "-DFOOTPRINT_SET" } else { "" };
        let defines = format!("{} -DPER_RAY_STEP {set}", voxel_defines(voxel_type, 1));
        Ok(Self(device.kernel(
            &source!("direct", "volume", "footprint", "elementary", "table_entries", "shading", "sample", "pixel_ray"),
            &defines,
        )?))
    }

    pub fn launch(&self, device: &Device, a: &DirectArguments) -> Result<(), Error> {
        let [width, height] = a.size;
        launch(
            device,
            "direct",
            &self.0,
            width as usize * height as usize,
            device.tuning().pixel_group,
            &[
                a.voxels,
                a.visible[0],
                a.visible[1],
                a.visible[2],
                a.table,
                a.slabs,
                a.images,
                a.shears,
                &a.params,
                &a.sample,
                &width,
                &height,
                a.frame,
                a.active_samples,
            ],
        )
    }
}

/// Renders per screen pixel with point-sampled layers.
pub(crate) struct PointDirectKernel(Kernel);

/// What [`PointDirectKernel`] reads and writes.
pub(crate) struct PointDirectArguments<'a> {
    pub voxels: &'a VoxelBuffer,
    /// Bits for rays of any lean, for layer axes x, y, z; only those that `params.axis` needs are read.
    pub visible: [&'a Buffer<u8>; 3],
    pub integrals: &'a Buffer<[i32; 4]>,
    pub params: DirectParams,
    pub sample: SampleParams,
    pub size: [i32; 2],
    pub frame: &'a Buffer<Float4>,
    /// One count per pixel.
    pub active_samples: &'a Buffer<u32>,
}

impl PointDirectKernel {
    pub fn new(device: &Device, voxel_type: VoxelType, stretches: Stretches) -> Result<Self, Error> {
        let source = source!(
            "point_direct",
            "volume",
            "elementary",
            "table_entries",
            "shading",
            "field",
            "preintegration",
            "dimmed_stretch",
            "pixel_ray"
        );
        Ok(Self(device.kernel(&source, &format!("{} {}", voxel_defines(voxel_type, 1), stretches.defines()))?))
    }

    pub fn launch(&self, device: &Device, a: &PointDirectArguments) -> Result<(), Error> {
        let [width, height] = a.size;
        launch(
            device,
            "direct",
            &self.0,
            width as usize * height as usize,
            device.tuning().pixel_group,
            &[
                a.voxels,
                a.visible[0],
                a.visible[1],
                a.visible[2],
                a.integrals,
                &a.params,
                &a.sample,
                &width,
                &height,
                a.frame,
                a.active_samples,
            ],
        )
    }
}
