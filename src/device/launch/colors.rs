//! Kernels of volumes of colours.

use super::layered::{PointLattice, Segments};
use super::rays::march_defines;
use super::structs::{
    ColorVoxelParams, Float4, LabelVoxelParams, MarchParams, RayEnds, RayLatticeParams, SampleParams, ScreenParams,
};
use super::{
    Defines, Floats, Items, Output, Rendering, ShadedField, VoxelBuffer, VoxelKind, arguments, kernel, large_grid, tiles,
};
use crate::device::Buffer;
use crate::layers::Kernel;

arguments! {
    /// Extinction times colour and extinction, four fields of floats.
    ColorFields<'a> {
        red: &'a VoxelBuffer,
        green: &'a VoxelBuffer,
        blue: &'a VoxelBuffer,
        /// With the view of all four.
        extinction: ShadedField<'a>,
        /// Of the extinction.
        visible: &'a Buffer<u8>,
        sample: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

kernel! {
    /// [`PointLattice`] for colours.
    ColorLattice = "layered/color_lattice.cl", color_lattice, "lattice", Items::Tiles;
    defines |tuning, variant: (VoxelKind, Kernel, Segments, Rendering)| PointLattice::defines(tuning, variant);
    items |a, _| tiles(a.p.tiles);
    arguments ColorLatticeArguments<'a> {
        colors: ColorFields<'a>,
        shown_slabs: &'a Buffer<i32>,
        p: RayLatticeParams,
    }
}

kernel! {
    /// [`Raycast`](super::rays::Raycast) for colours.
    ColorRaycast = "rays/color_raycast.cl", color_raycast, "raycast", Items::Tiles;
    defines |tuning, (voxels, kernel, rendering): (VoxelKind, Kernel, Rendering)| {
        march_defines(tuning, voxels, rendering).with_kernel(kernel)
    };
    items |a, _| tiles(a.s.tiles);
    arguments ColorRaycastArguments<'a> {
        colors: ColorFields<'a>,
        s: ScreenParams,
        p: MarchParams,
    }
}

kernel! {
    /// Makes the four fields of colours with three or four components.
    ColorVoxels = "volume/color_voxels.cl", color_voxels, "colors", Items::Pixels;
    defines |tuning, voxels: VoxelKind| Defines::new(tuning.vector_width).with_values(voxels);
    items |a, _| large_grid(a.p.count as usize);
    arguments ColorVoxelsArguments<'a> {
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

kernel! {
    /// Makes the four fields of labels.
    LabelVoxels = "volume/label_voxels.cl", label_voxels, "colors", Items::Tiles;
    defines |tuning, voxels: VoxelKind| Defines::new(tuning.vector_width).with_values(voxels);
    items |a, _| a.p.dims[1..].iter().map(|&n| n as usize).product();
    arguments LabelVoxelsArguments<'a> {
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
