//! Kernel arguments of several fields.

use super::super::classification::VisibleBlocks;
use super::super::field::Layout;
use super::super::region::Region;
use super::super::scene::GradientVoxels;
use crate::device::launch::layered::{Channels, ShadedChannels};
use crate::device::launch::structs::{ChannelParams, FieldPlacement, Float4, RayEnds, SampleParams};
use crate::device::launch::{ChannelColors, ChannelFields, LightBuffers, Output, PerChannel, Rendering, ShadedField, VoxelKind};
use crate::device::{Buffer, Device};
use crate::error::Error;
use std::sync::Arc;

/// What a field is sampled from, and the programs that it needs.
pub(in crate::renderer) struct FieldInputs {
    pub layout: Layout,
    pub gradients: GradientVoxels,
    pub visible: Arc<VisibleBlocks>,
    pub sample: SampleParams,
    pub region: Region,
    /// Where the voxels lie in the frame.
    pub place: FieldPlacement,
    /// A length of all fields, in unit distances of this one.
    pub length: f64,
    pub colors: Option<VoxelColors>,
}

/// Colours of voxels.
pub(in crate::renderer) struct VoxelColors {
    pub bytes: Arc<Buffer<u8>>,
    /// Bytes from a voxel to the next along the axes of the layout, and the numbers of voxels.
    pub strides: [i32; 3],
    pub dims: [i32; 3],
}

impl FieldInputs {
    /// Kernel arguments.
    pub fn shaded<'a>(&'a self, light: LightBuffers<'a>) -> ShadedField<'a> {
        let Self { layout, gradients: GradientVoxels { layout: gradients, .. }, .. } = self;
        let (view, gradient_view) = (layout.view, gradients.view);
        ShadedField { voxels: &layout.voxels, view, gradient_voxels: &gradients.voxels, gradient_view, light }
    }

    /// Kernel permutation flags.
    pub fn rendering(&self) -> Rendering {
        self.region.rendering_from(&self.gradients)
    }
}

/// The arguments of fields that are drawn together.
pub(in crate::renderer) struct MergedInputs<'a> {
    fields: Vec<&'a FieldInputs>,
    pub kind: VoxelKind,
    pub rendering: Rendering,
    pub region: Region,
}

impl<'a> MergedInputs<'a> {
    /// Merges the inputs of at least one field.
    ///
    /// # Errors
    /// If no program serves all of them.
    pub fn new(fields: Vec<&'a FieldInputs>) -> Result<Self, Error> {
        let region = Region::intersection(fields.iter().map(|field| &field.region));
        let all: Vec<Rendering> = fields.iter().map(|field| field.rendering()).collect();
        if all.iter().any(|rendering| rendering.blend != all[0].blend) {
            let problem =
                "the values of one channel fall where its stored numbers rise, and those of another do not: convert one";
            return Err(Error::Settings { field: "channels", problem: problem.into() });
        }
        let thinned = all.iter().find(|rendering| rendering.gradient_opacity);
        let rendering = Rendering {
            clipped: region.rendering.clipped,
            gradient_opacity: thinned.is_some(),
            // Without lights, only fields with gradient opacity have gradients.
            gradients: thinned.unwrap_or(&all[0]).gradients,
            ..all[0]
        };
        Ok(Self { kind: fields[0].layout.voxels.kind(), fields, rendering, region })
    }

    /// Kernel arguments. `channel_params`: [`params`](Self::params).
    pub fn arguments(&self, channel_params: &'a Buffer<ChannelParams>) -> ChannelFields<'a> {
        ChannelFields {
            voxels: self.each(|field| &*field.layout.voxels),
            gradient_voxels: self.each(|field| &*field.gradients.layout.voxels),
            channel_params,
            count: self.fields.len() as i32,
        }
    }

    /// Stands for volumes that programs do not read.
    pub fn unused(&self) -> &'a Buffer<u8> {
        &self.fields[0].visible.flags
    }

    /// Kernel arguments of fields that are drawn along the axes of `ray_ends`.
    pub fn shaded(
        &self,
        channel_params: &'a Buffer<ChannelParams>,
        tables: &[&'a Buffer<Float4>],
        light: LightBuffers<'a>,
        ray_ends: RayEnds,
        output: Output<'a>,
    ) -> ShadedChannels<'a> {
        ShadedChannels {
            fields: self.arguments(channel_params),
            light,
            visible: self.visible(),
            tables: PerChannel::new(tables),
            ray_ends,
            output,
        }
    }

    /// Kernel arguments, if voxels of any field have colours.
    pub fn colors(&self) -> Option<ChannelColors<'a>> {
        let any = self.fields.iter().find_map(|field| Some(&*field.colors.as_ref()?.bytes))?;
        Some(ChannelColors { colors: self.each(|field| field.colors.as_ref().map_or(any, |colors| &colors.bytes)) })
    }

    pub fn visible(&self) -> PerChannel<&'a Buffer<u8>> {
        self.each(|field| &field.visible.flags)
    }

    pub fn shown_slabs(&self) -> PerChannel<&'a Buffer<i32>> {
        self.each(|field| &field.visible.shown)
    }

    /// Numbers of min-max blocks along u and v.
    pub fn blocks(&self) -> [i32; 2] {
        self.fields[0].visible.blocks
    }

    /// Room in programs.
    pub fn channels(&self) -> Channels {
        Channels::new(self.fields.len())
    }

    /// Parameters, with lengths in unit distances of the first field.
    pub fn params(&self, device: &Device, name: &str) -> Result<Buffer<ChannelParams>, Error> {
        let params = |field: &&FieldInputs| {
            let &FieldInputs { ref layout, ref gradients, mut sample, place, length, ref colors, .. } = *field;
            sample.classification.table_unit *= (length / self.fields[0].length) as f32;
            sample.light = place.lighting(sample.light);
            let (color_stride, color_dims) = colors.as_ref().map_or(([0; 3], [1; 3]), |colors| (colors.strides, colors.dims));
            let (view, gradient_view) = (layout.view, gradients.layout.view);
            ChannelParams { view, gradient_view, sample, place, color_stride, color_dims, padding: [0.0; 2] }
        };
        Buffer::from_slice(device, &self.fields.iter().map(params).collect::<Vec<_>>(), name)
    }

    fn each<T: Copy>(&self, argument: impl Fn(&'a FieldInputs) -> T) -> PerChannel<T> {
        PerChannel::new(&self.fields.iter().map(|field| argument(field)).collect::<Vec<_>>())
    }
}
