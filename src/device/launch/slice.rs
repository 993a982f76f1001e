//! The kernel that draws slices.

use super::structs::{Float4, SampleParams, ScreenParams, SliceParams, VolumeView};
use super::{BlendMode, Defines, Gradients, Items, Launch, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::{GradientEstimator, Kernel};

kernel! {
    /// Samples the field reconstructed with a kernel on a plane, and colours it.
    Slice = "slice/slice.cl", slice, "slice";
    SliceArguments<'a> {
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

impl Launch for Slice {
    type Variant = (VoxelKind, Kernel);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel): Self::Variant) -> String {
        // Values are not composited: the field continues at its edges, as for averages.
        let rendering = Rendering {
            blend: BlendMode::Average,
            clipped: false,
            gradient_opacity: false,
            several_lights: false,
            colored_lights: false,
            depth_cue: false,
            light_volume: false,
            gradients: Gradients { estimate: GradientEstimator::for_kernel(kernel).into(), voxels: None },
            depths: false,
            pixel_rays: false,
        };
        let defines = Defines::new(tuning.vector_width).with_voxels(voxels).with_rendering(rendering);
        defines.with("TILE_ROWS", tuning.screen_tile_rows).with_kernel(kernel).0
    }

    fn items(a: &SliceArguments, _: &Tuning) -> usize {
        tiles(a.s.tiles)
    }
}
