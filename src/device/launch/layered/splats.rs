//! Kernels of splatted layers, and their footprints and tables.

use super::super::structs::{Float4, LayerOffset, RayEnds, RayLatticeParams, SampleParams, SplatLatticeParams};
use super::super::{Defines, Items, Output, Rendering, ShadedField, VoxelKind, kernel, tiles};
use super::{Channels, PixelField, ShadedChannels};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

/// Footprints are integrals of the cubic.
fn splats(defines: Defines, voxels: VoxelKind, rendering: Rendering) -> Defines {
    defines.with_voxels(voxels).with_kernel(Kernel::Cubic).with_rendering(rendering)
}

fn splat_defines(tuning: &Tuning, voxels: VoxelKind, rendering: Rendering, channels: Channels) -> Defines {
    splats(Defines::new(tuning.vector_width), voxels, rendering).with("TILE_ROWS", tuning.tile_rows).with_channels(channels)
}

kernel! {
    /// Composites the lattice of a parallel view with splatted layers of one or several fields.
    SplatLattice = "layered/splat_lattice.cl", splat_lattice, "lattice", Items::Tiles;
    defines |tuning, (voxels, rendering, channels): (VoxelKind, Rendering, Channels)| {
        // Clipped step lengths differ between rays, and those of several fields are not in their tables.
        let per_ray = rendering.clipped || channels.are_several();
        splat_defines(tuning, voxels, rendering, channels).with_if(per_ray, "PER_RAY_STEP")
    };
    items |a, _| tiles(a.p.tiles);
    arguments SplatLatticeArguments<'a> {
        /// Tables of one field have (r, g, b, opacity of a sample), unless rays are clipped or values are gathered.
        channels: ShadedChannels<'a>,
        offsets_u: &'a Buffer<LayerOffset>,
        offsets_v: &'a Buffer<LayerOffset>,
        weights: &'a Buffer<f32>,
        slabs: &'a Buffer<Float4>,
        p: SplatLatticeParams,
    }
}

kernel! {
    /// Composites the lattice of a perspective view with splatted layers of one or several fields.
    SplatPerspective = "layered/splat_perspective.cl", splat_perspective, "lattice", Items::Tiles;
    defines |tuning, (voxels, rendering, channels): (VoxelKind, Rendering, Channels)| {
        splat_defines(tuning, voxels, rendering, channels).with_if(true, "PER_RAY_STEP")
    };
    items |a, _| tiles(a.p.tiles);
    arguments SplatPerspectiveArguments<'a> {
        channels: ShadedChannels<'a>,
        /// (z, weight) of the eight quadrature nodes.
        nodes: &'a Buffer<[f32; 2]>,
        slabs: &'a Buffer<Float4>,
        p: RayLatticeParams,
    }
}

kernel! {
    /// Composites any lattice of splatted layers, with a work-item per sample.
    SplatSamples = "layered/splat_samples.cl", splat_samples, "lattice", Items::Samples;
    defines |tuning, (voxels, rendering): (VoxelKind, Rendering)| {
        splats(Defines::new(1), voxels, rendering).with_if(true, "PER_RAY_STEP").with_sample_tile(tuning)
    };
    items |a, tuning| tiles(a.p.tiles) * tuning.sample_group();
    arguments SplatSamplesArguments<'a> {
        field: ShadedField<'a>,
        visible: &'a Buffer<u8>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        slabs: &'a Buffer<Float4>,
        p: RayLatticeParams,
        sample: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

kernel! {
    /// Composites splatted layers per screen pixel, in either projection.
    SplatDirect = "layered/splat_direct.cl", splat_direct, "direct", Items::Pixels;
    // The flag: footprints come from the set of oriented footprint images.
    defines |_, (voxels, set, rendering): (VoxelKind, bool, Rendering)| {
        splats(Defines::new(1), voxels, rendering).with_if(true, "PER_RAY_STEP").with_if(set, "FOOTPRINT_SET")
    };
    items |a, _| a.pixels.pixels();
    arguments SplatDirectArguments<'a> {
        pixels: PixelField<'a>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        slabs: &'a Buffer<Float4>,
        /// Footprint images and their shears; read only by kernels with `FOOTPRINT_SET`.
        images: &'a Buffer<u8>,
        shears: &'a Buffer<[f32; 2]>,
    }
}

kernel! {
    /// Computes the footprint weights of a lattice in phases.
    Footprints = "layered/footprints.cl", footprints, "footprints", Items::Pixels;
    defines |_, (): ()| Defines::new(1);
    items |a, _| a.per_voxel_u as usize * a.per_voxel_v as usize * a.layers as usize;
    arguments FootprintsArguments<'a> {
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

kernel! {
    /// Computes the set of oriented footprint images.
    FootprintSet = "layered/footprint_set.cl", footprint_set, "footprint set", Items::Pixels;
    defines |_, (): ()| Defines::new(1);
    items |a, _| a.count as usize;
    arguments FootprintSetArguments<'a> {
        shears: &'a Buffer<[f32; 2]>,
        /// Number of texels of all images.
        count: i32,
        /// 64² bytes per entry of `shears`.
        images: &'a Buffer<u8>,
    }
}

kernel! {
    /// Converts extinction to opacity for one step length.
    OpacityTable = "layered/table.cl", table, "table", Items::Pixels;
    defines |_, (): ()| Defines::new(1);
    items |a, _| a.count as usize;
    arguments OpacityTableArguments<'a> {
        base: &'a Buffer<Float4>,
        /// Step length of a sample in unit distances.
        dt: f32,
        linear: i32,
        count: i32,
        entries: &'a Buffer<Float4>,
    }
}
