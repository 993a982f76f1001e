//! Kernels that march along pixel rays: ray casting, slicing and pre-integrated segments.

use super::layered::{Channels, Segments};
use super::structs::{ChannelParams, Clipping, Float4, MarchParams, SampleParams, ScreenParams, VolumeView};
use super::{Defines, Items, Launch, PerChannel, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

/// A kernel based on march.cl. Its file defines how a row of rays is marched, and the table it reads.
macro_rules! march {
    ($(#[$doc:meta])* $kernel:ident = $file:literal, $stage:literal; $arguments:ident, $(#[$table_doc:meta])* $table:ty) => {
        kernel! {
            $(#[$doc])*
            $kernel = $file, march, $stage;
            $arguments<'a> {
                /// In the layout of layer axis z.
                voxels: &'a VoxelBuffer,
                view: VolumeView,
                /// The voxels that gradients are estimated from: `voxels`, unless [`Gradients::voxels`](super::Gradients) is set.
                gradient_voxels: &'a VoxelBuffer,
                gradient_view: VolumeView,
                /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
                light: &'a Buffer<u8>,
                sky: &'a Buffer<u8>,
                /// One bit per block and slab.
                visible: &'a Buffer<u8>,
                $(#[$table_doc])*
                table: &'a Buffer<$table>,
                s: ScreenParams,
                p: MarchParams,
                sample: SampleParams,
                clip: Clipping,
                frame: &'a Buffer<Float4>,
                /// One count per tile.
                active_samples: &'a Buffer<u32>,
            }
        }
    };
}

march! {
    /// Casts rays through the field reconstructed with a kernel, with post-classified samples.
    Raycast = "rays/raycast.cl", "raycast";
    RaycastArguments,
    /// (r, g, b, τ) per value.
    Float4
}

march! {
    /// Slices the trilinear field, with pre-integrated slabs.
    Slicing = "rays/slicing.cl", "slicing";
    SlicingArguments,
    /// See [`PreintegratedTable`].
    Float4
}

march! {
    /// Casts rays through the field reconstructed with a kernel, with pre-integrated segments.
    CastSegments = "rays/cast_segments.cl", "raycast";
    CastSegmentsArguments,
    /// Table of integrals.
    [i32; 4]
}

march! {
    /// Gathers values along rays, or intersects an iso-surface, in the field reconstructed with a kernel.
    CastValues = "rays/cast_values.cl", "raycast";
    CastValuesArguments,
    /// (r, g, b, τ) per value.
    Float4
}

kernel! {
    /// [`Raycast`] for several fields on one grid, whose voxels have one type: compositing alone.
    ChannelRaycast = "rays/channel_raycast.cl", channel_raycast, "raycast";
    ChannelRaycastArguments<'a> {
        voxels: PerChannel<&'a VoxelBuffer>,
        /// As for [`Raycast`].
        gradient_voxels: PerChannel<&'a VoxelBuffer>,
        visible: PerChannel<&'a Buffer<u8>>,
        /// (r, g, b, τ) per value.
        tables: PerChannel<&'a Buffer<Float4>>,
        /// `count` of them.
        channel_params: &'a Buffer<ChannelParams>,
        count: i32,
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        s: ScreenParams,
        p: MarchParams,
        clip: Clipping,
        frame: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for ChannelRaycast {
    type Variant = (VoxelKind, Kernel, Rendering, Channels);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, rendering, channels): Self::Variant) -> String {
        march_defines(tuning, voxels, rendering).with_kernel(kernel).with_channels(channels).0
    }

    fn items(a: &ChannelRaycastArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

kernel! {
    /// [`Raycast`] for extinction times colour and extinction, four fields of floats.
    ColorRaycast = "rays/color_raycast.cl", color_raycast, "raycast";
    ColorRaycastArguments<'a> {
        red: &'a VoxelBuffer,
        green: &'a VoxelBuffer,
        blue: &'a VoxelBuffer,
        extinction: &'a VoxelBuffer,
        /// Of all four.
        view: VolumeView,
        /// As for [`Raycast`], of the extinction.
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// Of the extinction.
        visible: &'a Buffer<u8>,
        s: ScreenParams,
        p: MarchParams,
        sample: SampleParams,
        clip: Clipping,
        frame: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for ColorRaycast {
    type Variant = (VoxelKind, Kernel, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, rendering): Self::Variant) -> String {
        march_defines(tuning, voxels, rendering).with_kernel(kernel).0
    }

    fn items(a: &ColorRaycastArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

fn march_defines(tuning: &Tuning, voxels: VoxelKind, rendering: Rendering) -> Defines {
    let defines = Defines::new(tuning.vector_width).with_voxels(voxels);
    defines.with_rendering(rendering).with("TILE_ROWS", tuning.screen_tile_rows)
}

impl Launch for Raycast {
    type Variant = (VoxelKind, Kernel, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, rendering): Self::Variant) -> String {
        let defines = march_defines(tuning, voxels, rendering);
        defines.with_if(true, "PER_RAY_STEP").with_kernel(kernel).0
    }

    fn items(a: &RaycastArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

impl Launch for Slicing {
    type Variant = (VoxelKind, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, rendering): Self::Variant) -> String {
        march_defines(tuning, voxels, rendering).with_kernel(Kernel::Linear).0
    }

    fn items(a: &SlicingArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

impl Launch for CastSegments {
    type Variant = (VoxelKind, Kernel, Segments, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, segments, rendering): Self::Variant) -> String {
        march_defines(tuning, voxels, rendering).with_kernel(kernel).with_segments(segments).0
    }

    fn items(a: &CastSegmentsArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

impl Launch for CastValues {
    /// Rays are always clipped.
    type Variant = (VoxelKind, Kernel, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, rendering): Self::Variant) -> String {
        march_defines(tuning, voxels, Rendering { clipped: true, ..rendering }).with_kernel(kernel).0
    }

    fn items(a: &CastValuesArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}

kernel! {
    /// Computes the pre-integrated table of slicing.
    PreintegratedTable = "rays/preintegrated_table.cl", preintegrated_table, "table";
    PreintegratedTableArguments<'a> {
        integrals: &'a Buffer<[i32; 4]>,
        /// Index of the first node in `integrals`.
        first: i32,
        /// Number of nodes in `integrals`.
        nodes: i32,
        /// Nodes per table entry.
        nodes_per_entry: f32,
        /// Extinction of one unit of `integrals`.
        unit: f32,
        /// Slab thickness in unit distances.
        thickness: f32,
        linear: i32,
        /// Number of front values, and of back values.
        size: i32,
        /// `size`² entries.
        out: &'a Buffer<Float4>,
    }
}

impl Launch for PreintegratedTable {
    type Variant = ();
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, (): ()) -> String {
        Defines::new(1).0
    }

    fn items(a: &PreintegratedTableArguments, _: &Tuning) -> usize {
        a.size as usize * a.size as usize
    }
}
