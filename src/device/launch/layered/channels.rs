//! Kernels that draw several fields together.

use super::super::structs::{FieldPlacement, Float4, RayEnds, RayLatticeParams};
use super::super::{
    ChannelColors, ChannelFields, Defines, Items, LightBuffers, Output, PerChannel, Rendering, VoxelKind, arguments, kernel,
    tiles,
};
use super::{PointLattice, Segments};
use crate::device::Buffer;
use crate::layers::Kernel;

/// Fields for which a program has room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Channels(u8);

impl Channels {
    /// Room for at least `count` fields. Few sizes, so that showing or hiding a field seldom needs another program.
    pub fn new(count: usize) -> Self {
        Self(count.next_power_of_two() as u8)
    }

    /// Whether there is room for more than one. Extinctions of several add before they become opacities.
    pub(in super::super) fn are_several(self) -> bool {
        self.0 > 1
    }
}

impl Defines {
    /// For kernels that draw the fields of a scene.
    pub(in super::super) fn with_channels(self, channels: Channels) -> Self {
        self.with("CHANNELS", channels.0)
            .with("ON_FRAME", FieldPlacement::ON_FRAME)
            .with("SHIFTED", FieldPlacement::SHIFTED)
            .with("APART", FieldPlacement::APART)
    }
}

arguments! {
    /// Several fields, and what their samples are classified and shaded by.
    ShadedChannels<'a> {
        fields: ChannelFields<'a>,
        light: LightBuffers<'a>,
        visible: PerChannel<&'a Buffer<u8>>,
        /// (r, g, b, τ) per value.
        tables: PerChannel<&'a Buffer<Float4>>,
        ray_ends: RayEnds,
        output: Output<'a>,
    }
}

kernel! {
    /// [`PointLattice`] for several fields.
    ChannelLattice = "layered/channel_lattice.cl", channel_lattice, "lattice", Items::Tiles;
    defines |tuning, (voxels, kernel, segments, rendering, channels): (VoxelKind, Kernel, Segments, Rendering, Channels)| {
        PointLattice::defines(tuning, (voxels, kernel, segments, rendering)).with_channels(channels)
    };
    items |a, _| tiles(a.p.tiles);
    arguments ChannelLatticeArguments<'a> {
        /// Tables are for gathered values.
        channels: ShadedChannels<'a>,
        /// Tables of integrals, for compositing.
        integrals: PerChannel<&'a Buffer<[i32; 4]>>,
        shown_slabs: PerChannel<&'a Buffer<i32>>,
        p: RayLatticeParams,
        colors: Option<ChannelColors<'a>>,
    }
}
