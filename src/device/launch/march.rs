//! Launchers of march.cl, with raycast.cl, slicing.cl or cast_stretches.cl, and of preintegrated_table.cl.

use super::params::{Float4, MarchParams, SampleParams, ScreenParams, VolumeView};
use super::points::{Stretches, cut_define};
use super::{Argument, VoxelBuffer, launch, screen_defines, voxel_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use crate::layers::Interpolation;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel;

fn march_defines(device: &Device, voxel_type: VoxelType) -> String {
    format!("{} {}", voxel_defines(voxel_type, device.tuning().vector_width), screen_defines(device))
}

/// The table that a way of marching reads.
pub(crate) enum MarchTable<'a> {
    /// Of ray casting, (r, g, b, τ) per value; of slicing, that of [`PreintegratedTableKernel`].
    Entries(&'a Buffer<Float4>),
    /// Of pre-integrated stretches.
    Integrals(&'a Buffer<[i32; 4]>),
}

impl Argument for MarchTable<'_> {
    fn set(&self, kernel: &Kernel, index: u32) -> opencl3::Result<()> {
        match self {
            MarchTable::Entries(table) => table.set(kernel, index),
            MarchTable::Integrals(table) => table.set(kernel, index),
        }
    }
}

/// Marches along the rays of screen pixels: by ray casting, by slicing, or from stretch to stretch.
pub(crate) struct MarchKernel(Kernel);

/// What [`MarchKernel`] reads and writes.
pub(crate) struct MarchArguments<'a> {
    /// In the layout of layer axis z.
    pub voxels: &'a VoxelBuffer,
    pub view: VolumeView,
    /// A bit per block and slab.
    pub visible: &'a Buffer<u8>,
    pub table: MarchTable<'a>,
    pub screen: ScreenParams,
    pub params: MarchParams,
    pub sample: SampleParams,
    pub frame: &'a Buffer<Float4>,
    /// One count per tile.
    pub active_samples: &'a Buffer<u32>,
}

impl MarchKernel {
    /// Casts rays through the field of a kernel.
    pub fn raycast(device: &Device, voxel_type: VoxelType, interpolation: Interpolation) -> Result<Self, Error> {
        let field = match interpolation {
            Interpolation::Trilinear => "",
            Interpolation::Tricubic => "-DTRICUBIC",
            Interpolation::Gaussian => "-DGAUSSIAN",
        };
        let defines = format!("{} -DPER_RAY_STEP {field} -DRADIUS={}", march_defines(device, voxel_type), interpolation.radius());
        let source = source!(
            "march",
            "elementary",
            "volume",
            "table_entries",
            "shading",
            "sample",
            "screen",
            "field",
            "marching",
            "raycast"
        );
        Ok(Self(device.kernel(&source, &defines)?))
    }

    /// Slices the trilinear field. `cut`: values can lie beyond the table.
    pub fn slicing(device: &Device, voxel_type: VoxelType, cut: bool) -> Result<Self, Error> {
        let source = source!(
            "march",
            "elementary",
            "volume",
            "table_entries",
            "shading",
            "screen",
            "field",
            "marching",
            "slabs",
            "slicing"
        );
        Ok(Self(device.kernel(&source, &format!("{} {}", march_defines(device, voxel_type), cut_define(cut)))?))
    }

    /// Casts rays through the cubic's field, with pre-integrated stretches.
    pub fn stretches(device: &Device, voxel_type: VoxelType, stretches: Stretches) -> Result<Self, Error> {
        let source = source!(
            "march",
            "elementary",
            "volume",
            "table_entries",
            "shading",
            "screen",
            "field",
            "preintegration",
            "dimmed_stretch",
            "marching",
            "slabs",
            "cast_stretches"
        );
        Ok(Self(device.kernel(&source, &format!("{} {}", march_defines(device, voxel_type), stretches.defines()))?))
    }

    pub fn launch(&self, device: &Device, stage: &'static str, a: &MarchArguments) -> Result<(), Error> {
        launch(
            device,
            stage,
            &self.0,
            a.screen.tiles.iter().map(|&n| n as usize).product(),
            device.tuning().tile_group,
            &[a.voxels, &a.view, a.visible, &a.table, &a.screen, &a.params, &a.sample, a.frame, a.active_samples],
        )
    }
}

/// Makes the table of slicing.
pub(crate) struct PreintegratedTableKernel(Kernel);

/// What [`PreintegratedTableKernel`] reads and writes.
pub(crate) struct PreintegratedTableArguments<'a> {
    pub integrals: &'a Buffer<[i32; 4]>,
    /// Extinction of one unit of `integrals`.
    pub unit: f32,
    /// Of a slab, in unit distances.
    pub thickness: f32,
    pub linear: bool,
    /// Values in front and behind.
    pub size: usize,
    /// `size`² entries.
    pub table: &'a Buffer<Float4>,
}

impl PreintegratedTableKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self(device.kernel(&source!("preintegrated_table", "elementary"), "-DVW=1")?))
    }

    pub fn launch(&self, device: &Device, a: &PreintegratedTableArguments) -> Result<(), Error> {
        let nodes = a.integrals.len() as i32 / 2;
        let nodes_per_entry = (nodes - 1) as f32 / (a.size - 1) as f32;
        let (linear, size) = (i32::from(a.linear), a.size as i32);
        launch(
            device,
            "table",
            &self.0,
            a.size * a.size,
            device.tuning().pixel_group,
            &[a.integrals, &nodes, &nodes_per_entry, &a.unit, &a.thickness, &linear, &size, a.table],
        )
    }
}
