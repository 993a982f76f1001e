//! Kernels of layered volume splatting: point-sampled layers, splatted ones in `splats.rs`, and several fields in `channels.rs` and
//! `channel_splats.rs`.

mod channel_splats;
mod channels;
mod splats;

pub(crate) use channel_splats::*;
pub(crate) use channels::*;
pub(crate) use splats::*;

use super::structs::{Clipping, DirectParams, Float4, RayLatticeParams, SampleParams, VolumeView};
use super::{Declared, Defines, Items, Launch, Rendering, VoxelBuffer, VoxelKind, kernel, large_grid, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

/// Permutation of kernels with pre-integrated segments. The default serves blend modes that gather values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Segments {
    /// Attenuation within thick segments changes their colour.
    pub dimmed: bool,
    /// All segments extend from layer to layer.
    pub whole: bool,
}

impl Segments {
    /// A permutation that also works for other numbers of segments per layer.
    fn general(self) -> Self {
        Self { whole: false, ..self }
    }
}

impl Defines {
    pub(super) fn with_segments(self, segments: Segments) -> Self {
        let Segments { dimmed, whole } = segments;
        let options = [(dimmed, "DIMMED"), (whole, "WHOLE_LAYERS")];
        options.into_iter().fold(self, |defines, (condition, name)| defines.with_if(condition, name))
    }

    /// For kernels with a work-item per sample.
    fn with_sample_tile(self, tuning: &Tuning) -> Self {
        let [columns, rows] = tuning.sample_tile;
        self.with("SAMPLE_COLUMNS", columns).with("SAMPLE_ROWS", rows)
    }
}

kernel! {
    /// Composites a lattice of point-sampled layers, with pre-integrated classification.
    PointLattice = "layered/point_lattice.cl", point_lattice, "lattice";
    PointLatticeArguments<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// The voxels that gradients are estimated from: `voxels`, unless [`Gradients::voxels`](super::Gradients) is set.
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// One bit per block and slab, for the shears of this lattice.
        visible: &'a Buffer<u8>,
        /// First and last slab with visible blocks, relative to the first layer in the buffer.
        shown_slabs: &'a Buffer<i32>,
        /// Table of integrals, for compositing.
        integrals: &'a Buffer<[i32; 4]>,
        /// (r, g, b, τ) per value, for gathered values.
        table: &'a Buffer<Float4>,
        p: RayLatticeParams,
        sample: SampleParams,
        clip: Clipping,
        /// Width x height RGBA samples.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for PointLattice {
    type Variant = (VoxelKind, Kernel, Segments, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, segments, rendering): Self::Variant) -> String {
        let defines = Defines::new(tuning.vector_width).with_voxels(voxels).with_kernel(kernel);
        defines.with_segments(segments).with_rendering(rendering).with_tile_rows(tuning.point_tile_rows, rendering.pixel_rays).0
    }

    fn items(a: &PointLatticeArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }

    fn general(variant: Self::Variant) -> Option<Self::Variant> {
        PointSamples::general(variant)
    }
}

/// [`PointLattice`] with a work-item per sample.
pub(crate) struct PointSamples;

impl Declared for PointSamples {
    const FILE: &'static str = "layered/point_samples.cl";
    const NAME: &'static str = "point_samples";
    const STAGE: &'static str = PointLattice::STAGE;
    type Arguments<'a> = PointLatticeArguments<'a>;
}

impl Launch for PointSamples {
    type Variant = (VoxelKind, Kernel, Segments, Rendering);
    const ITEMS: Items = Items::Samples;

    fn defines(tuning: &Tuning, (voxels, kernel, segments, rendering): Self::Variant) -> String {
        let defines = Defines::new(1).with_voxels(voxels).with_kernel(kernel).with_segments(segments).with_rendering(rendering);
        defines.with_sample_tile(tuning).0
    }

    fn items(a: &PointLatticeArguments, tuning: &Tuning) -> usize {
        tiles(a.p.tiles) * tuning.sample_group()
    }

    fn general((voxels, kernel, segments, rendering): Self::Variant) -> Option<Self::Variant> {
        Some((voxels, kernel, segments.general(), rendering.general()?))
    }
}

kernel! {
    /// [`PointLattice`] without a lattice, per screen pixel.
    PointDirect = "layered/point_direct.cl", point_direct, "direct";
    PointDirectArguments<'a> {
        voxels: &'a VoxelBuffer,
        /// As for [`PointLattice`]; the view is that of layer axis z.
        gradient_voxels: &'a VoxelBuffer,
        gradient_view_of_z: VolumeView,
        /// Light volumes of the lights and of the sky: [`Rendering::light_volume`].
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// One bit per block and slab, for any shear. Only the buffers that `p.axis` needs are read.
        visible_x: &'a Buffer<u8>,
        visible_y: &'a Buffer<u8>,
        visible_z: &'a Buffer<u8>,
        /// Table of integrals, for compositing.
        integrals: &'a Buffer<[i32; 4]>,
        /// (r, g, b, τ) per value, for gathered values.
        table: &'a Buffer<Float4>,
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

impl Launch for PointDirect {
    type Variant = (VoxelKind, Kernel, Segments, Rendering);
    const ITEMS: Items = Items::Pixels;

    fn defines(_: &Tuning, (voxels, kernel, segments, rendering): Self::Variant) -> String {
        Defines::new(1).with_voxels(voxels).with_kernel(kernel).with_segments(segments).with_rendering(rendering).0
    }

    fn items(a: &PointDirectArguments, _: &Tuning) -> usize {
        large_grid(a.width as usize * a.height as usize)
    }
}
