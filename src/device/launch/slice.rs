//! The kernel that draws slices.

use super::structs::{Float4, SampleParams, ScreenParams, SliceParams, VolumeView};
use super::{BlendMode, Defines, Gradients, Items, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use crate::device::Buffer;
use crate::layers::{GradientEstimator, Kernel};

kernel! {
    /// Samples the field reconstructed with a kernel on a plane, and colours it.
    Slice = "slice/slice.cl", slice, "slice", Items::Tiles;
    defines |tuning, (voxels, kernel): (VoxelKind, Kernel)| {
        // Values are not composited: the field continues at its edges, as for averages.
        let rendering = Rendering {
            blend: BlendMode::Average,
            clipped: false,
            gradient_opacity: false,
            several_lights: false,
            colored_lights: false,
            depth_cue: false,
            light_volume: false,
            studio: false,
            gradients: Gradients { estimate: GradientEstimator::for_kernel(kernel).into(), voxels: None },
            depths: false,
            pixel_rays: false,
    };
    let defines = Defines::new(tuning.vector_width).with_voxels(voxels).with_rendering(rendering);
    defines.with("TILE_ROWS", tuning.screen_tile_rows).with_kernel(kernel)
    };
    items |a, _| tiles(a.s.tiles);
    arguments SliceArguments<'a> {
        /// In the layout of layer axis z.
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// (r, g, b, τ) per value.
        table: &'a Buffer<Float4>,
        /// The origins of its rays lie on the plane.
        s: ScreenParams,
        p: SliceParams,
        sample: SampleParams,
        frame: &'a Buffer<Float4>,
    }
}
