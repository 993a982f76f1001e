//! Kernels of layered volume splatting: point-sampled layers, splatted ones in `splats.rs`, and several fields in `channels.rs`.

mod channels;
mod splats;

pub(crate) use channels::*;
pub(crate) use splats::*;

use super::structs::{DirectParams, Float4, RayEnds, RayLatticeParams, SampleParams, VolumeView};
use super::{
    Defines, Items, LightBuffers, Output, Rendering, ShadedField, Tint, VoxelBuffer, VoxelKind, arguments, kernel, large_grid,
    tiles,
};
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
    PointLattice = "layered/point_lattice.cl", point_lattice, "lattice", Items::Tiles;
    defines |tuning, (voxels, kernel, segments, rendering): (VoxelKind, Kernel, Segments, Rendering)| {
        let defines = Defines::new(tuning.vector_width).with_voxels(voxels).with_kernel(kernel).with_segments(segments);
        defines.with_rendering(rendering).with_tile_rows(tuning.point_tile_rows, rendering.pixel_rays)
    };
    items |a, _| tiles(a.p.tiles);
    general |variant| PointSamples::general(variant);
    arguments PointLatticeArguments<'a> {
        field: ShadedField<'a>,
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
        ray_ends: RayEnds,
        output: Output<'a>,
        tint: Option<Tint<'a>>,
    }
}

kernel! {
    /// [`PointLattice`] with a work-item per sample.
    PointSamples = "layered/point_samples.cl", point_samples, "lattice", Items::Samples;
    defines |tuning, (voxels, kernel, segments, rendering): (VoxelKind, Kernel, Segments, Rendering)| {
        let defines = Defines::new(1).with_voxels(voxels).with_kernel(kernel).with_segments(segments);
        defines.with_rendering(rendering).with_sample_tile(tuning)
    };
    items |a, tuning| tiles(a.p.tiles) * tuning.sample_group();
    general |(voxels, kernel, segments, rendering)| Some((voxels, kernel, segments.general(), rendering.general()?));
    arguments PointLatticeArguments
}

arguments! {
    /// A field that is drawn per screen pixel, in layers of any axis.
    PixelField<'a> {
        voxels: &'a VoxelBuffer,
        view_of_z: VolumeView,
        /// As of [`ShadedField`].
        gradient_voxels: &'a VoxelBuffer,
        gradient_view_of_z: VolumeView,
        light: LightBuffers<'a>,
        /// One bit per block and slab, for any shear, for layer axes x, y, z. Only the buffers that [`DirectParams::axis`] needs are read.
        visible_x: &'a Buffer<u8>,
        visible_y: &'a Buffer<u8>,
        visible_z: &'a Buffer<u8>,
        p: DirectParams,
        /// For layer axis z, whose u, v and a are x, y and z.
        sample_of_z: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

impl PixelField<'_> {
    fn pixels(&self) -> usize {
        large_grid(self.p.size.map(|n| n as usize).into_iter().product())
    }
}

kernel! {
    /// [`PointLattice`] without a lattice, per screen pixel.
    PointDirect = "layered/point_direct.cl", point_direct, "direct", Items::Pixels;
    defines |_, (voxels, kernel, segments, rendering): (VoxelKind, Kernel, Segments, Rendering)| {
        Defines::new(1).with_voxels(voxels).with_kernel(kernel).with_segments(segments).with_rendering(rendering)
    };
    items |a, _| a.pixels.pixels();
    arguments PointDirectArguments<'a> {
        pixels: PixelField<'a>,
        /// Table of integrals, for compositing.
        integrals: &'a Buffer<[i32; 4]>,
        /// (r, g, b, τ) per value, for gathered values.
        table: &'a Buffer<Float4>,
    }
}
