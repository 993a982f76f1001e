//! Arguments that many kernels have.

use super::structs::{ChannelParams, Float4, TintParams, VolumeView};
use super::{Extras, Optional, PerChannel, VoxelBuffer, arguments};
use crate::device::Buffer;

arguments! {
    /// A field, and what its samples are shaded from: SHADED_FIELD of kernels/shared/field.cl.
    ShadedField<'a> {
        voxels: &'a VoxelBuffer,
        view: VolumeView,
        /// The voxels that gradients are estimated from: `voxels`, unless [`Gradients::voxels`](super::Gradients) is set.
        gradient_voxels: &'a VoxelBuffer,
        gradient_view: VolumeView,
        light: LightBuffers<'a>,
    }
}

arguments! {
    /// Light volumes of the lights and of the sky, for [`Rendering::light_volume`](super::Rendering); otherwise not read.
    LightBuffers<'a> {
        light: &'a Buffer<u8>,
        sky: &'a Buffer<u8>,
    }
}

arguments! {
    /// Several fields on one grid, whose voxels have one type: CHANNEL_FIELDS of kernels/shared/channel.cl.
    ChannelFields<'a> {
        voxels: PerChannel<&'a VoxelBuffer>,
        /// As of [`ShadedField`].
        gradient_voxels: PerChannel<&'a VoxelBuffer>,
        /// `count` of them.
        channel_params: &'a Buffer<ChannelParams>,
        count: i32,
    }
}

arguments! {
    /// What kernels that draw a picture write.
    Output<'a> {
        /// Width x height RGBA samples of a lattice, or pixels.
        target: &'a Buffer<Float4>,
        /// Number of samples with opacity in each tile.
        active_samples: &'a Buffer<u32>,
        cuts: Option<Cuts<'a>>,
    }
}

arguments! {
    /// Colours of labels, and where they lie: TINT_ARGUMENTS of kernels/shared/tint.cl. Programs with them are built with TINTED.
    Tint<'a> {
        /// Indices of colours, of one or two bytes, and three bytes more.
        label_voxels: &'a Buffer<u8>,
        /// Red, green and blue times their weight, and the weight.
        label_colors: &'a Buffer<u8>,
        tint_params: TintParams,
    }
}

arguments! {
    /// Colours of the fields' voxels: CHANNEL_COLORS of kernels/shared/channel.cl. Programs with them are built with TINTED.
    ChannelColors<'a> {
        /// Red, green, blue and weight.
        colors: PerChannel<&'a Buffer<u8>>,
    }
}

impl Optional for Tint<'_> {
    const EXTRA: Extras = Extras { tinted: true, cut: false };
}

impl Optional for ChannelColors<'_> {
    const EXTRA: Extras = Extras { tinted: true, cut: false };
}

arguments! {
    /// Parts of rays: CUT_RAYS of kernels/shared/accumulator.cl.
    Cuts<'a> {
        /// Of each pixel in ray parameters, or of each sample in layers from that of the centre.
        cuts: &'a Buffer<[f32; 2]>,
    }
}

impl Optional for Cuts<'_> {
    const EXTRA: Extras = Extras { tinted: false, cut: true };
}
