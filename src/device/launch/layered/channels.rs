//! Kernels that draw several fields together.

use super::super::structs::{ChannelParams, Clipping, Float4, RayLatticeParams};
use super::super::{Defines, Items, Launch, PerChannel, Rendering, VoxelBuffer, VoxelKind, kernel, tiles};
use super::{PointLattice, Segments};
use crate::device::{Buffer, Tuning};
use crate::layers::Kernel;

kernel! {
    /// [`PointLattice`] for several fields on one grid, whose voxels have one type.
    ChannelLattice = "layered/channel_lattice.cl", channel_lattice, "lattice";
    ChannelLatticeArguments<'a> {
        voxels: PerChannel<&'a VoxelBuffer>,
        /// As for [`PointLattice`].
        gradient_voxels: PerChannel<&'a VoxelBuffer>,
        visible: PerChannel<&'a Buffer<u8>>,
        shown_slabs: PerChannel<&'a Buffer<i32>>,
        /// Tables of integrals, for compositing.
        integrals: PerChannel<&'a Buffer<[i32; 4]>>,
        /// (r, g, b, τ) per value, for gathered values.
        tables: PerChannel<&'a Buffer<Float4>>,
        /// `count` of them.
        channel_params: &'a Buffer<ChannelParams>,
        count: i32,
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
        p: RayLatticeParams,
        clip: Clipping,
        /// Width x height RGBA samples.
        lattice: &'a Buffer<Float4>,
        /// One count per tile.
        active_samples: &'a Buffer<u32>,
    }
}

/// Fields for which a program has room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Channels(u8);

impl Channels {
    /// Room for at least `count` fields. Few sizes, so that showing or hiding a field seldom needs another program.
    pub fn new(count: usize) -> Self {
        Self(count.next_power_of_two() as u8)
    }
}

impl Defines {
    /// For kernels that draw the fields of a scene.
    pub(in super::super) fn with_channels(self, channels: Channels) -> Self {
        self.with("CHANNELS", channels.0)
    }
}

impl Launch for ChannelLattice {
    type Variant = (VoxelKind, Kernel, Segments, Rendering, Channels);
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (voxels, kernel, segments, rendering, channels): Self::Variant) -> String {
        let defines = PointLattice::defines(tuning, (voxels, kernel, segments, rendering));
        Defines(defines).with_channels(channels).0
    }

    fn items(a: &ChannelLatticeArguments, _: &Tuning) -> usize {
        tiles(a.p.tiles)
    }
}
