//! Kernels of splatted layers of several fields.

use super::super::structs::{ChannelParams, Clipping, Float4, LayerOffset, RayLatticeParams, SplatLatticeParams};
use super::super::{Defines, Items, Launch, PerChannel, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use super::Channels;
use super::splats::splat_defines;
use crate::device::{Buffer, Tuning};

kernel! {
    /// [`SplatLattice`](super::SplatLattice) for several fields on one grid, whose voxels have one type.
    ChannelSplatLattice = "layered/channel_splat_lattice.cl", channel_splat_lattice, "lattice";
    ChannelSplatLatticeArguments<'a> {
        voxels: PerChannel<&'a VoxelBuffer>,
        /// As for [`PointLattice`](super::PointLattice).
        gradient_voxels: PerChannel<&'a VoxelBuffer>,
        visible: PerChannel<&'a Buffer<u8>>,
        /// (r, g, b, τ) per value.
        tables: PerChannel<&'a Buffer<Float4>>,
        /// `count` of them.
        channel_params: &'a Buffer<ChannelParams>,
        count: i32,
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        offsets_u: &'a Buffer<LayerOffset>,
        offsets_v: &'a Buffer<LayerOffset>,
        weights: &'a Buffer<f32>,
        slabs: &'a Buffer<Float4>,
        p: SplatLatticeParams,
        clip: Clipping,
        /// RGBA samples of the whole lattice, row by row.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for ChannelSplatLattice {
    type Variant = (VoxelKind, Rendering, Channels);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, variant: Self::Variant) -> String {
        channel_defines(tuning, variant).0
    }

    fn items(a: &ChannelSplatLatticeArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }
}

kernel! {
    /// [`SplatPerspective`](super::SplatPerspective) for several fields on one grid, whose voxels have one type.
    ChannelSplatPerspective = "layered/channel_splat_perspective.cl", channel_splat_perspective, "lattice";
    ChannelSplatPerspectiveArguments<'a> {
        voxels: PerChannel<&'a VoxelBuffer>,
        /// As for [`PointLattice`](super::PointLattice).
        gradient_voxels: PerChannel<&'a VoxelBuffer>,
        visible: PerChannel<&'a Buffer<u8>>,
        /// (r, g, b, τ) per value.
        tables: PerChannel<&'a Buffer<Float4>>,
        /// `count` of them.
        channel_params: &'a Buffer<ChannelParams>,
        count: i32,
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        /// (z, weight) of the eight quadrature nodes.
        nodes: &'a Buffer<[f32; 2]>,
        slabs: &'a Buffer<Float4>,
        p: RayLatticeParams,
        clip: Clipping,
        /// Width x height RGBA samples.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

impl Launch for ChannelSplatPerspective {
    type Variant = (VoxelKind, Rendering, Channels);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, variant: Self::Variant) -> String {
        channel_defines(tuning, variant).0
    }

    fn items(a: &ChannelSplatPerspectiveArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }
}

/// Extinctions add before they become opacities, so step lengths are not in tables.
fn channel_defines(tuning: &Tuning, (voxels, rendering, channels): (VoxelKind, Rendering, Channels)) -> Defines {
    splat_defines(tuning, voxels, rendering).with_if(true, "PER_RAY_STEP").with_channels(channels)
}
