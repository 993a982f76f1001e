//! Kernels that march along pixel rays: ray casting and pre-integrated segments.

use super::layered::{Channels, Segments, ShadedChannels};
use super::structs::{Float4, MarchParams, RayEnds, SampleParams, ScreenParams};
use super::{ChannelColors, Defines, Items, Output, Rendering, ShadedField, Tint, VoxelKind, arguments, kernel, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

arguments! {
    /// A field through which rays are marched.
    MarchedField<'a> {
        /// In the layout of layer axis z.
        field: ShadedField<'a>,
        /// One bit per block and slab.
        visible: &'a Buffer<u8>,
        s: ScreenParams,
        p: MarchParams,
        sample: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

kernel! {
    /// Casts rays through the field reconstructed with a kernel, with post-classified samples.
    Raycast = "rays/raycast.cl", march, "raycast", Items::Tiles;
    defines |tuning, (voxels, kernel, rendering): (VoxelKind, Kernel, Rendering)| {
        march_defines(tuning, voxels, rendering).with_if(true, "PER_RAY_STEP").with_kernel(kernel)
    };
    items |a, _| tiles(a.march.s.tiles);
    arguments TableMarchArguments<'a> {
        march: MarchedField<'a>,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        tint: Option<Tint<'a>>,
    }
}

kernel! {
    /// Casts rays through the field reconstructed with a kernel, with pre-integrated segments.
    CastSegments = "rays/cast_segments.cl", march, "raycast", Items::Tiles;
    defines |tuning, (voxels, kernel, segments, rendering): (VoxelKind, Kernel, Segments, Rendering)| {
        march_defines(tuning, voxels, rendering).with_kernel(kernel).with_segments(segments)
    };
    items |a, _| tiles(a.march.s.tiles);
    arguments CastSegmentsArguments<'a> {
        march: MarchedField<'a>,
        /// Table of integrals.
        table: &'a Buffer<[i32; 4]>,
        tint: Option<Tint<'a>>,
    }
}

kernel! {
    /// Gathers values along rays, or intersects an iso-surface, in the field reconstructed with a kernel.
    CastValues = "rays/cast_values.cl", march, "raycast", Items::Tiles;
    // Rays are always clipped.
    defines |tuning, (voxels, kernel, rendering): (VoxelKind, Kernel, Rendering)| {
        march_defines(tuning, voxels, Rendering { clipped: true, ..rendering }).with_kernel(kernel)
    };
    items |a, _| tiles(a.march.s.tiles);
    arguments TableMarchArguments
}

kernel! {
    /// [`Raycast`] for several fields: compositing alone.
    ChannelRaycast = "rays/channel_raycast.cl", channel_raycast, "raycast", Items::Tiles;
    defines |tuning, (voxels, kernel, rendering, channels): (VoxelKind, Kernel, Rendering, Channels)| {
        march_defines(tuning, voxels, rendering).with_kernel(kernel).with_channels(channels)
    };
    items |a, _| tiles(a.s.tiles);
    arguments ChannelRaycastArguments<'a> {
        channels: ShadedChannels<'a>,
        s: ScreenParams,
        p: MarchParams,
        colors: Option<ChannelColors<'a>>,
    }
}

pub(super) fn march_defines(tuning: &Tuning, voxels: VoxelKind, rendering: Rendering) -> Defines {
    let defines = Defines::new(tuning.vector_width).with_voxels(voxels);
    defines.with_rendering(rendering).with("TILE_ROWS", tuning.screen_tile_rows)
}
