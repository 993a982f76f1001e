//! Coarse transmittances: the medium through which light of a lower resolution is swept.

use super::super::channels::{FieldInputs, MergedInputs};
use super::super::classification::VisibleBlocks;
use super::super::field::Layout;
use super::super::scene::Scene;
use super::grid::ValueGrid;
use super::{ABSORBERS, KERNEL};
use crate::device::Buffer;
use crate::device::launch::light::{CoarseTransmittanceArguments, LightTableArguments};
use crate::device::launch::structs::VolumeView;
use crate::device::launch::volume::TransposeArguments;
use crate::device::launch::{Floats, PerChannel, VoxelBuffer};
use crate::error::Error;
use crate::layers::Axis;
use crate::transfer::Extinction;
use crate::volume::{VoxelBox, VoxelType};
use std::sync::Arc;

pub(super) const COARSE: &str = "the coarse transmittances";
pub(super) const TRANSMITTANCE: &str = "the transmittance of table entries";

/// Mean transmittances of blocks of voxels, through all fields of a scene.
pub(super) struct Coarse {
    /// x fastest.
    upright: Arc<VoxelBuffer>,
    /// z fastest: the layout of layer axis x.
    transposed: Arc<VoxelBuffer>,
    /// The blocks, of all.
    held: VoxelBox,
    all: [usize; 3],
    /// Length that they are for, in unit distances of the first field.
    pub length: f64,
    /// They are few, and not culled.
    pub unculled: Arc<VisibleBlocks>,
}

impl Coarse {
    /// The layout of a layer axis.
    pub fn layout(&self, axis: Axis) -> Layout {
        let frame = axis.frame();
        let [x, y, z] = self.held.dims.map(|n| n as i64);
        let (voxels, stride) = match axis {
            Axis::X => (&self.transposed, [1, z, y * z]),
            Axis::Y => (&self.upright, [1, x * y, x]),
            Axis::Z => (&self.upright, [1, x, x * y]),
        };
        let dims = [frame.u, frame.v, frame.a].map(|i| self.all[i] as i32);
        // Beside the volume all is clear.
        let first_a = self.held.first[frame.a] as i32;
        let view = VolumeView { stride, first: 0, dims, background: 1.0, offset: 0.0, first_a };
        Layout { voxels: voxels.clone(), view }
    }
}

/// Bytes of the buffers behind this many coarse transmittances, in two layouts.
pub(super) fn buffers(blocks: usize) -> [(&'static str, usize); 2] {
    let bytes = size_of::<f32>() * blocks;
    [(COARSE, bytes), (COARSE, bytes)]
}

/// Bytes of the transmittances of a field's table of this many entries.
pub(super) fn table(entries: usize) -> (&'static str, usize) {
    (TRANSMITTANCE, size_of::<f32>() * entries)
}

/// A field from which coarse transmittances are made.
struct Source {
    field: FieldInputs,
    transmittance: Buffer<f32>,
}

impl Scene<'_> {
    /// The coarse transmittances of these blocks for a grid of values; `None` at full resolution.
    pub(super) fn coarse(&mut self, values: ValueGrid, held: VoxelBox) -> Result<Option<Coarse>, Error> {
        if values.voxels() == 1 {
            return Ok(None);
        }
        let [first_x, first_y, first_z] = held.first.map(|n| n as i32);
        let [dims_x, dims_y, dims_z] = held.dims.map(|n| n as i32);
        let unculled = Arc::new(VisibleBlocks::unculled(self.device)?);
        let sources = self.for_each_absorber(|scene| scene.coarse_source(values.voxels()))?;
        let merged = MergedInputs::new(sources.iter().map(|source| &source.field).collect())?;
        let transmittance: Vec<_> = sources.iter().map(|source| &source.transmittance).collect();
        let count = held.count();
        let float = VoxelType::Float32;
        let upright = VoxelBuffer::new(self.device, count, float, COARSE)?;
        let fields = merged.params(self.device, ABSORBERS.name)?;
        let arguments = CoarseTransmittanceArguments {
            fields: merged.arguments(&fields),
            entries: PerChannel::new(&transmittance),
            ray_ends: merged.region.for_kernels(Axis::Z.frame()),
            first_x,
            first_y,
            first_z,
            dims_x,
            dims_y,
            dims_z,
            coarse: Floats(&upright),
        };
        let variant = (merged.kind, merged.rendering, values.voxels(), merged.channels());
        self.light.coarse.launch(self.device, variant, &arguments)?;
        let transposed = VoxelBuffer::new(self.device, count, float, COARSE)?;
        let (pitch_y, pitch_z) = (i64::from(dims_x), i64::from(dims_x) * i64::from(dims_y));
        let arguments =
            TransposeArguments { voxels: &upright, first: 0, pitch_y, pitch_z, dims_x, dims_y, dims_z, transposed: &transposed };
        self.light.transpose.launch(self.device, upright.kind(), &arguments)?;
        let length = sources[0].field.length;
        let (upright, transposed) = (Arc::new(upright), Arc::new(transposed));
        Ok(Some(Coarse { upright, transposed, held, all: values.inner(), length, unculled }))
    }

    /// The field of this scene, for blocks of this many voxels along each axis.
    fn coarse_source(&mut self, voxels: usize) -> Result<Source, Error> {
        let length = voxels as f64 * self.steps(1).shortest();
        let transmittance = self.transmittances(length)?;
        Ok(Source { field: self.absorbing_blocks(length)?, transmittance })
    }

    /// The transmittance of a length in unit distances, for each table entry.
    fn transmittances(&mut self, length: f64) -> Result<Buffer<f32>, Error> {
        let table = self.table(KERNEL)?;
        let count = table.entries.len();
        let transmittance = Buffer::new(self.device, count, TRANSMITTANCE)?;
        let arguments = LightTableArguments {
            table: &table.entries,
            count: count as i32,
            thickness: length as f32,
            linear: i32::from(self.settings.extinction == Extinction::Linear),
            transmittance: &transmittance,
        };
        self.light.table.launch(self.device, (), &arguments)?;
        Ok(transmittance)
    }
}
