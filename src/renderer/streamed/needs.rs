//! What a lattice takes on the device, by how many layers are held there.

use super::super::layered::SplatLayers;
use super::super::prepared::{integrals_bytes, table_bytes, table_entries};
use super::super::tiles::Tiles;
use crate::device::Tuning;
use crate::device::launch::structs::Float4;
use crate::device::launch::volume::BlockNumbers;
use crate::layers::{Axis, Kernel, Lattice, PREFILTER_RADIUS};
use crate::settings::{Classification, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Description, VoxelType};

/// Bytes of buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bytes {
    /// Of all together.
    pub sum: u64,
    /// Of the largest one.
    pub largest: u64,
}

impl Bytes {
    fn and(self, buffers: &[usize]) -> Self {
        // An empty buffer has a byte or more.
        let buffers = buffers.iter().map(|&bytes| bytes.max(1) as u64);
        buffers.fold(self, |all, bytes| Self { sum: all.sum + bytes, largest: all.largest.max(bytes) })
    }

    /// Whether a device has room for them.
    pub fn fit(self, room: Room) -> bool {
        self.sum <= room.free() && self.largest <= room.largest
    }
}

/// What a device has room for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// Bytes that buffers may have together.
    pub budget: u64,
    /// Bytes that others have of these.
    pub taken: u64,
    /// Bytes that one buffer may have.
    pub largest: u64,
}

impl Room {
    /// Bytes that are left.
    pub fn free(self) -> u64 {
        self.budget.saturating_sub(self.taken)
    }
}

/// What a lattice needs.
pub(super) struct Needs {
    axis: Axis,
    /// Voxels along u, v, a of the whole volume.
    dims: [usize; 3],
    voxel_type: VoxelType,
    kernel: Kernel,
    /// Whatever is held.
    fixed: Bytes,
}

impl Needs {
    /// Of a lattice that is drawn and warped with these settings.
    pub fn new(
        lattice: &Lattice,
        classification: Classification,
        settings: &Settings,
        viewport: Viewport,
        tuning: &Tuning,
        description: &Description,
        transfer: &TransferFunction,
    ) -> Self {
        let numbers = transfer.of_stored(description.rescale());
        let entries = |kernel| table_entries(&numbers, &description.stored(), settings.extinction, kernel);
        let (kernel, own) = match classification {
            Classification::Preintegrated { kernel, .. } => {
                let entries = entries(kernel);
                let taps = if kernel == Kernel::BSpline { (PREFILTER_RADIUS + 1) * size_of::<f32>() } else { 0 };
                let own = [&table_bytes(entries)[..], &[integrals_bytes(entries), taps]].concat();
                (kernel, own)
            }
            Classification::Post(correction) => {
                let entries = entries(Kernel::Cubic);
                let scratch = SplatLayers::scratch(lattice, correction, entries, tuning.lattice_schedule);
                let own = [&table_bytes(entries)[..], &scratch].concat();
                (Kernel::Cubic, own)
            }
        };
        let (samples, frame) = (lattice.samples() * size_of::<Float4>(), viewport.pixels() * size_of::<Float4>());
        let tiles = Tiles::of_lattice(lattice, classification, tuning);
        let drawn = [samples, tiles.all_counts() * size_of::<u32>(), frame];
        let fixed = Bytes::default().and(&own).and(&drawn);
        let axis = lattice.frame.layer_axis();
        Self { axis, dims: lattice.dims, voxel_type: description.voxel_type(), kernel, fixed }
    }

    /// While so many layers are held.
    pub fn holding(&self, layers: usize) -> Bytes {
        let [u, v, _] = self.dims;
        let (count, held) = (u * v * layers, [u, v, layers]);
        let stored = count * self.voxel_type.bytes();
        let coefficients = self.kernel == Kernel::BSpline;
        let weighted = if coefficients { VoxelType::Float32.bytes() } else { self.voxel_type.bytes() };
        // And which slabs show anything.
        let mut buffers = vec![stored, 2 * size_of::<i32>()];
        buffers.extend(coefficients.then_some(count * weighted));
        buffers.extend((self.axis == Axis::X).then_some(count * weighted));
        let (numbers, radius) = (BlockNumbers::of(held), self.kernel.radius());
        buffers.extend([numbers.limits() * weighted, numbers.slab_bytes(radius), numbers.chunks(radius)]);
        self.fixed.and(&buffers)
    }

    /// Bytes of a layer's voxels.
    pub fn layer(&self) -> u64 {
        (self.dims[0] * self.dims[1] * self.voxel_type.bytes()) as u64
    }

    /// Layers of the whole volume.
    pub fn layers(&self) -> usize {
        self.dims[2]
    }
}
