//! Kernels of volumes of colours.

use super::layered::{PointLattice, Segments};
use super::rays::march_defines;
use super::structs::{
    ColorVoxelParams, Float4, LabelParams, LabelVoxelParams, MarchParams, PackedColorParams, RayEnds, RayLatticeParams,
    SampleParams, ScreenParams,
};
use super::{
    Defines, Floats, Items, Output, Rendering, ShadedField, VoxelBuffer, VoxelKind, arguments, kernel, large_grid, tiles,
};
use crate::device::Buffer;
use crate::layers::Kernel;

arguments! {
    /// Extinction times colour and extinction, four fields of floats; of labels with smooth surfaces, opacity instead of extinction.
    ColorArguments<'a> {
        others: OtherColors<'a>,
        /// The extinction, with the view of all fields.
        shaded: ShadedField<'a>,
        /// Of that field.
        visible: &'a Buffer<u8>,
        sample: SampleParams,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

arguments! {
    /// The fields beside the extinction.
    OtherColors<'a> {
        red: &'a VoxelBuffer,
        green: &'a VoxelBuffer,
        blue: &'a VoxelBuffer,
        /// Squared and cubed opacity. Read of [`ColorFieldsOf::VariedLabels`] alone.
        second: &'a VoxelBuffer,
        third: &'a VoxelBuffer,
        /// Read of labels alone.
        labels: LabelParams,
    }
}

/// What the fields of colours are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ColorFieldsOf {
    Colors,
    /// Labels with smooth surfaces, all of one opacity.
    Labels,
    /// Labels with smooth surfaces.
    VariedLabels,
}

impl Defines {
    fn with_fields_of(self, fields: ColorFieldsOf) -> Self {
        let labels = self.with_if(fields != ColorFieldsOf::Colors, "LABELS");
        labels.with_if(fields == ColorFieldsOf::VariedLabels, "VARIED_OPACITIES")
    }
}

kernel! {
    /// [`PointLattice`] for colours.
    ColorLattice = "layered/color_lattice.cl", color_lattice, "lattice", Items::Tiles;
    defines |tuning, (variant, fields): ((VoxelKind, Kernel, Segments, Rendering), ColorFieldsOf)| {
        PointLattice::defines(tuning, variant).with_fields_of(fields)
    };
    items |a, _| tiles(a.p.tiles);
    arguments ColorLatticeArguments<'a> {
        colors: ColorArguments<'a>,
        shown_slabs: &'a Buffer<i32>,
        p: RayLatticeParams,
    }
}

kernel! {
    /// [`Raycast`](super::rays::Raycast) for colours.
    ColorRaycast = "rays/color_raycast.cl", color_raycast, "raycast", Items::Tiles;
    defines |tuning, (voxels, kernel, rendering, fields): (VoxelKind, Kernel, Rendering, ColorFieldsOf)| {
        march_defines(tuning, voxels, rendering).with_kernel(kernel).with_fields_of(fields)
    };
    items |a, _| tiles(a.s.tiles);
    arguments ColorRaycastArguments<'a> {
        colors: ColorArguments<'a>,
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
    /// Packs the four fields of colours into bytes, for fields that are drawn together.
    PackColors = "volume/pack_colors.cl", pack_colors, "colors", Items::Tiles;
    defines |tuning, voxels: VoxelKind| Defines::new(tuning.vector_width).with_values(voxels);
    items |a, _| a.p.dims[1..].iter().map(|&n| n as usize).product();
    arguments PackColorsArguments<'a> {
        red: &'a VoxelBuffer,
        green: &'a VoxelBuffer,
        blue: &'a VoxelBuffer,
        extinction: &'a VoxelBuffer,
        p: PackedColorParams,
        out: &'a Buffer<u8>,
    }
}

kernel! {
    /// Makes the four fields of labels whose voxels are drawn as they are.
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

arguments! {
    /// Labels of one layer, or of several that overlap.
    LabelFields<'a> {
        labels: &'a VoxelBuffer,
        /// As of [`LabelVoxelsArguments`].
        entries: &'a Buffer<Float4>,
        /// Read of several layers, instead of both: the fields of [`LabelVoxels`].
        red: Floats<'a>,
        green: Floats<'a>,
        blue: Floats<'a>,
        extinction: Floats<'a>,
        p: LabelVoxelParams,
    }
}

kernel! {
    /// Distances within rows of thick slices.
    LabelRuns = "volume/label_runs.cl", label_runs, "colors", Items::Tiles;
    defines |tuning, (voxels, is_layered): (VoxelKind, bool)| {
        Defines::new(tuning.vector_width).with_values(voxels).with_if(is_layered, "LAYERED")
    };
    items |a, _| {
        let [x, y, z] = a.labels.p.dims.map(|n| n as usize);
        [y * z, x * z, x * y][if a.labels.p.thick == 0 { 1 } else { 0 }]
    };
    arguments LabelRunsArguments<'a> {
        labels: LabelFields<'a>,
        out: Floats<'a>,
    }
}

kernel! {
    /// Makes the fields of labels with smooth surfaces.
    LabelMoments = "volume/label_moments.cl", label_moments, "colors", Items::Tiles;
    defines |tuning, (voxels, is_layered, is_thick): (VoxelKind, bool, bool)| {
        LabelRuns::defines(tuning, (voxels, is_layered)).with_if(is_thick, "THICK")
    };
    items |a, _| a.labels.p.dims[1..].iter().map(|&n| n as usize).product();
    arguments LabelMomentsArguments<'a> {
        labels: LabelFields<'a>,
        /// Of [`LabelRuns`], read of thick slices.
        runs: Floats<'a>,
        out_red: Floats<'a>,
        out_green: Floats<'a>,
        out_blue: Floats<'a>,
        out_first: Floats<'a>,
        /// Written if opacities differ.
        out_second: Floats<'a>,
        out_third: Floats<'a>,
    }
}
