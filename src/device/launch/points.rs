//! Launcher of point_lattice.cl.

use super::params::{Float4, RayLatticeParams, SampleParams, VolumeView};
use super::{VoxelBuffer, launch, voxel_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel;

/// How pre-integrated stretches are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stretches {
    /// Values can lie beyond the table of integrals.
    pub cut: bool,
    /// Their ends have weights of their own.
    pub curved: bool,
    /// Light lost inside deep ones changes their colour.
    pub dimmed: bool,
}

impl Stretches {
    pub(super) fn defines(self) -> String {
        let [curved, dimmed] =
            [(self.curved, "-DCURVED"), (self.dimmed, "-DDIMMED")].map(|(on, define)| if on { define } else { "" });
        format!("-DTRICUBIC {} {curved} {dimmed}", cut_define(self.cut))
    }
}

/// `-D` option for tables of integrals that values can lie beyond.
pub(super) fn cut_define(cut: bool) -> &'static str {
    if cut { "-DTABLE_CUT" } else { "" }
}

/// Renders a lattice with point-sampled layers and pre-integrated classification.
pub(crate) struct PointLatticeKernel(Kernel);

/// What [`PointLatticeKernel`] reads and writes.
pub(crate) struct PointLatticeArguments<'a> {
    pub voxels: &'a VoxelBuffer,
    pub view: VolumeView,
    /// (crossing, shear) of each column, padded to whole tiles, and of each row.
    pub crossings: [&'a Buffer<[f32; 2]>; 2],
    /// Bits for rays that lean as these do.
    pub visible: &'a Buffer<u8>,
    pub integrals: &'a Buffer<[i32; 4]>,
    pub params: RayLatticeParams,
    pub sample: SampleParams,
    /// RGBA of width by height samples.
    pub lattice: &'a Buffer<Float4>,
    /// One count per tile.
    pub active_samples: &'a Buffer<u32>,
}

impl PointLatticeKernel {
    pub fn new(device: &Device, voxel_type: VoxelType, stretches: Stretches) -> Result<Self, Error> {
        let source = source!(
            "point_lattice",
            "volume",
            "ray_lattice",
            "elementary",
            "table_entries",
            "shading",
            "field",
            "preintegration",
            "dimmed_stretch",
            "point_layer"
        );
        let tuning = device.tuning();
        let voxels = voxel_defines(voxel_type, tuning.vector_width);
        Ok(Self(device.kernel(&source, &format!("{voxels} {} -DTILE_ROWS={}", stretches.defines(), tuning.point_tile_rows))?))
    }

    pub fn launch(&self, device: &Device, a: &PointLatticeArguments) -> Result<(), Error> {
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
                a.visible,
                a.integrals,
                &a.params,
                &a.sample,
                a.lattice,
                a.active_samples,
            ],
        )
    }
}
