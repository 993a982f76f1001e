//! Kernel arguments of several fields.

use super::super::classification::VisibleBlocks;
use super::super::field::Layout;
use super::super::region::Region;
use super::super::scene::GradientVoxels;
use crate::device::launch::layered::Channels;
use crate::device::launch::structs::{ChannelParams, SampleParams};
use crate::device::launch::{PerChannel, Rendering, VoxelBuffer, VoxelKind};
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
    /// A length of all fields, in unit distances of this one.
    pub length: f64,
}

/// The arguments of fields that are drawn together.
pub(in crate::renderer) struct Together<'a> {
    fields: Vec<&'a FieldInputs>,
    pub kind: VoxelKind,
    pub rendering: Rendering,
    pub region: Region,
}

impl<'a> Together<'a> {
    /// Merges the inputs of at least one field.
    ///
    /// # Errors
    /// If no program serves all of them.
    pub fn new(fields: Vec<&'a FieldInputs>) -> Result<Self, Error> {
        let region = Region::intersection(fields.iter().map(|field| &field.region));
        let all: Vec<Rendering> = fields.iter().map(|field| field.region.rendering_from(&field.gradients)).collect();
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

    /// Number of fields.
    pub fn count(&self) -> usize {
        self.fields.len()
    }

    pub fn voxels(&self) -> PerChannel<&'a VoxelBuffer> {
        self.each(|field| &*field.layout.voxels)
    }

    pub fn gradient_voxels(&self) -> PerChannel<&'a VoxelBuffer> {
        self.each(|field| &*field.gradients.layout.voxels)
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
        Channels::new(self.count())
    }

    /// Stands for volumes that programs do not read.
    pub fn unused(&self) -> &'a Buffer<u8> {
        &self.fields[0].visible.flags
    }

    /// Parameters, with lengths in unit distances of the first field.
    pub fn params(&self, device: &Device, name: &str) -> Result<Buffer<ChannelParams>, Error> {
        let params = |field: &&FieldInputs| {
            let FieldInputs { layout, gradients, sample, length, .. } = field;
            let mut sample = *sample;
            sample.classification.table_unit *= (length / self.fields[0].length) as f32;
            ChannelParams { view: layout.view, gradient_view: gradients.layout.view, sample }
        };
        Buffer::from_slice(device, &self.fields.iter().map(params).collect::<Vec<_>>(), name)
    }

    fn each<T: Copy>(&self, argument: impl Fn(&'a FieldInputs) -> T) -> PerChannel<T> {
        PerChannel::new(&self.fields.iter().map(|field| argument(field)).collect::<Vec<_>>())
    }
}
