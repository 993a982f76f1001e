//! Kernels of volumes of colours.

use super::layered::{PointLattice, Segments};
use super::structs::{Clipping, ColorVoxelParams, Float4, LabelVoxelParams, RayLatticeParams, SampleParams, VolumeView};
use super::{Defines, Floats, Items, Launch, Rendering, VoxelBuffer, VoxelKind, kernel, large_grid, tiles};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

kernel! {
    /// [`PointLattice`] for extinction times colour and extinction, four fields of floats.
    ColorLattice = "layered/color_lattice.cl", color_lattice, "lattice";
    ColorLatticeArguments<'a> {
        red: &'a VoxelBuffer,
        green: &'a VoxelBuffer,
        blue: &'a VoxelBuffer,
        extinction: &'a VoxelBuffer,
        /// Of all four.
        view: VolumeView,
        /// As for [`PointLattice`], of the extinction.
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// Of the extinction.
        visible: &'a Buffer<u8>,
        shown_slabs: &'a Buffer<i32>,
        p: RayLatticeParams,
        sample: SampleParams,
        clip: Clipping,
        /// Width x height RGBA samples.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for ColorLattice {
    type Variant = (VoxelKind, Kernel, Segments, Rendering);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, variant: Self::Variant) -> String {
        PointLattice::defines(tuning, variant)
    }

    fn items(a: &ColorLatticeArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }
}

kernel! {
    /// Makes the four fields of colours with three or four components.
    ColorVoxels = "volume/color_voxels.cl", color_voxels, "colors";
    ColorVoxelsArguments<'a> {
        red: &'a VoxelBuffer,
        green: &'a VoxelBuffer,
        blue: &'a VoxelBuffer,
        /// Read where opacities are alpha.
        alpha: &'a VoxelBuffer,
        /// Two at least.
        opacities: &'a Buffer<f32>,
        p: ColorVoxelParams,
        out_red: Floats<'a>,
        out_green: Floats<'a>,
        out_blue: Floats<'a>,
        out_extinction: Floats<'a>,
    }
}

impl Launch for ColorVoxels {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Pixels;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        Defines::new(tuning.vector_width).with_values(voxels).0
    }

    fn items(a: &ColorVoxelsArguments, _: &Tuning) -> usize {
        large_grid(a.p.count as usize)
    }
}

kernel! {
    /// Makes the four fields of labels.
    LabelVoxels = "volume/label_voxels.cl", label_voxels, "colors";
    LabelVoxelsArguments<'a> {
        labels: &'a VoxelBuffer,
        /// Extinction times red, green, blue, and extinction, per label.
        entries: &'a Buffer<Float4>,
        p: LabelVoxelParams,
        out_red: Floats<'a>,
        out_green: Floats<'a>,
        out_blue: Floats<'a>,
        out_extinction: Floats<'a>,
    }
}

impl Launch for LabelVoxels {
    type Variant = VoxelKind;
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, voxels: VoxelKind) -> String {
        Defines::new(tuning.vector_width).with_values(voxels).0
    }

    fn items(a: &LabelVoxelsArguments, _: &Tuning) -> usize {
        a.p.dims[1..].iter().map(|&n| n as usize).product()
    }
}
