//! Arguments that many kernels have.

use super::structs::{ChannelParams, Float4, TintParams, VolumeView};
use super::{Argument, Parameter, PerChannel, VoxelBuffer, arguments};
use crate::device::Buffer;
use opencl3::kernel::Kernel as ClKernel;

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

impl<T: Argument> Argument for Option<T> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        self.as_ref().map_or(Ok(index), |colors| colors.set(kernel, index))
    }

    fn parameters(name: &str, tinted: bool) -> Vec<Parameter> {
        if tinted { T::parameters(name, tinted) } else { Vec::new() }
    }

    fn is_tinted(&self) -> bool {
        self.is_some()
    }
}
