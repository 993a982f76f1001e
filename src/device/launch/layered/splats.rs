//! Kernels of splatted layers, and their footprints and tables.

use super::super::structs::{
    Clipping, DirectParams, Float4, LayerOffset, RayLatticeParams, SampleParams, SplatLatticeParams, VolumeView,
};
use super::super::{Defines, Items, Launch, Rendering, VoxelBuffer, VoxelKind, kernel, large_grid, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

/// Footprints are integrals of the cubic.
fn splats(defines: Defines, voxels: VoxelKind, rendering: Rendering) -> Defines {
    defines.with_voxels(voxels).with_kernel(Kernel::Cubic).with_rendering(rendering)
}

pub(super) fn splat_defines(tuning: &Tuning, voxels: VoxelKind, rendering: Rendering) -> Defines {
    splats(Defines::new(tuning.vector_width), voxels, rendering).with("TILE_ROWS", tuning.tile_rows)
}

kernel! {
    /// Composites the lattice of a parallel view with splatted layers.
    SplatLattice = "layered/splat_lattice.cl", splat_lattice, "lattice";
    SplatLatticeArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// As for [`PointLattice`](super::PointLattice).
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        offsets_u: &'a Buffer<LayerOffset>,
        offsets_v: &'a Buffer<LayerOffset>,
        weights: &'a Buffer<f32>,
        visible: &'a Buffer<u8>,
        /// (r, g, b, opacity of a sample) per value; (r, g, b, τ) if rays are clipped or values are gathered.
        table: &'a Buffer<Float4>,
        slabs: &'a Buffer<Float4>,
        p: SplatLatticeParams,
        sample: SampleParams,
        clip: Clipping,
        /// RGBA samples of the whole lattice, row by row.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for SplatLattice {
    type Variant = (VoxelKind, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, rendering): Self::Variant) -> String {
        // Clipped step lengths differ between rays.
        splat_defines(tuning, voxels, rendering).with_if(rendering.clipped, "PER_RAY_STEP").0
    }

    fn items(a: &SplatLatticeArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }
}

kernel! {
    /// Composites the lattice of a perspective view with splatted layers.
    SplatPerspective = "layered/splat_perspective.cl", splat_perspective, "lattice";
    SplatPerspectiveArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// As for [`PointLattice`](super::PointLattice).
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// (z, weight) of the eight quadrature nodes.
        nodes: &'a Buffer<[f32; 2]>,
        visible: &'a Buffer<u8>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        slabs: &'a Buffer<Float4>,
        p: RayLatticeParams,
        sample: SampleParams,
        clip: Clipping,
        /// Width x height RGBA samples.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for SplatPerspective {
    type Variant = (VoxelKind, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, rendering): Self::Variant) -> String {
        splat_defines(tuning, voxels, rendering).with_if(true, "PER_RAY_STEP").0
    }

    fn items(a: &SplatPerspectiveArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }
}

kernel! {
    /// Composites any lattice of splatted layers, with a work-item per sample.
    SplatSamples = "layered/splat_samples.cl", splat_samples, "lattice";
    SplatSamplesArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// As for [`PointLattice`](super::PointLattice).
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        visible: &'a Buffer<u8>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        slabs: &'a Buffer<Float4>,
        p: RayLatticeParams,
        sample: SampleParams,
        clip: Clipping,
        /// Width x height RGBA samples.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for SplatSamples {
    type Variant = (VoxelKind, Rendering);
    const ITEMS: Items = Items::Samples;

    fn defines(tuning: &Tuning, (voxels, rendering): Self::Variant) -> String {
        splats(Defines::new(1), voxels, rendering).with_if(true, "PER_RAY_STEP").with_sample_tile(tuning).0
    }

    fn items(a: &SplatSamplesArguments, tuning: &Tuning) -> usize {
        tiles(a.p.tiles) * tuning.sample_group()
    }
}

kernel! {
    /// Composites splatted layers per screen pixel, in either projection.
    SplatDirect = "layered/splat_direct.cl", splat_direct, "direct";
    SplatDirectArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// As for [`PointDirect`](super::PointDirect).
        gradient_voxels: &'a VoxelBuffer,
        gradient_view_of_z: VolumeView,
        /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// For layer axes x, y, z. Only the buffers that `p.axis` needs are read.
        visible_x: &'a Buffer<u8>,
        visible_y: &'a Buffer<u8>,
        visible_z: &'a Buffer<u8>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        slabs: &'a Buffer<Float4>,
        /// Footprint images and their shears; read only by kernels with `FOOTPRINT_SET`.
        images: &'a Buffer<u8>,
        shears: &'a Buffer<[f32; 2]>,
        p: DirectParams,
        /// For layer axis z, whose u, v and a are x, y and z.
        sample_of_z: SampleParams,
        clip: Clipping,
        width: i32,
        height: i32,
        frame: &'a Buffer<Float4>,
        /// One count per pixel.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for SplatDirect {
    /// The flag: footprints come from the set of oriented footprint images.
    type Variant = (VoxelKind, bool, Rendering);
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, (voxels, set, rendering): Self::Variant) -> String {
        splats(Defines::new(1), voxels, rendering).with_if(true, "PER_RAY_STEP").with_if(set, "FOOTPRINT_SET").0
    }

    fn items(a: &SplatDirectArguments, _: &Tuning) -> usize {
        large_grid(a.width as usize * a.height as usize)
    }
}

kernel! {
    /// Computes the footprint weights of a lattice in phases.
    Footprints = "layered/footprints.cl", footprints, "footprints";
    FootprintsArguments<'a> {
        /// Per layer, including the two outer ones, and column: see [`Footprints::columns`].
        offsets_u: &'a Buffer<LayerOffset>,
        /// Per layer, including the two outer ones, and phase.
        offsets_v: &'a Buffer<LayerOffset>,
        shear_u: f32,
        shear_v: f32,
        per_voxel_u: i32,
        per_voxel_v: i32,
        columns: i32,
        /// Number of layers, including the two outer ones.
        layers: i32,
        /// [`Footprints::WEIGHTS`] weights per layer, phase along v and column.
        weights: &'a Buffer<f32>,
    }
}

impl Footprints {
    /// Weights per layer, phase along v and column.
    pub const WEIGHTS: usize = 16;

    /// Columns with offsets and weights in each layer: a vector of samples can begin with any phase.
    pub fn columns(samples_per_voxel: u32, tuning: &Tuning) -> usize {
        (samples_per_voxel + tuning.vector_width - 1) as usize
    }
}

impl Launch for Footprints {
    type Variant = ();
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, (): ()) -> String {
        Defines::new(1).0
    }

    fn items(a: &FootprintsArguments, _: &Tuning) -> usize {
        a.per_voxel_u as usize * a.per_voxel_v as usize * a.layers as usize
    }
}

kernel! {
    /// Computes the set of oriented footprint images.
    FootprintSet = "layered/footprint_set.cl", footprint_set, "footprint set";
    FootprintSetArguments<'a> {
        shears: &'a Buffer<[f32; 2]>,
        /// Number of texels of all images.
        count: i32,
        /// 64² bytes per entry of `shears`.
        images: &'a Buffer<u8>,
    }
}

impl Launch for FootprintSet {
    type Variant = ();
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, (): ()) -> String {
        Defines::new(1).0
    }

    fn items(a: &FootprintSetArguments, _: &Tuning) -> usize {
        a.count as usize
    }
}

kernel! {
    /// Converts extinction to opacity for one step length.
    OpacityTable = "layered/table.cl", table, "table";
    OpacityTableArguments<'a> {
        base: &'a Buffer<Float4>,
        /// Step length of a sample in unit distances.
        dt: f32,
        linear: i32,
        count: i32,
        entries: &'a Buffer<Float4>,
    }
}

impl Launch for OpacityTable {
    type Variant = ();
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, (): ()) -> String {
        Defines::new(1).0
    }

    fn items(a: &OpacityTableArguments, _: &Tuning) -> usize {
        a.count as usize
    }
}
