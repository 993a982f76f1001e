//! What a lattice needs on the device, by how many layers are held there: as its frame would declare it.

use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::super::frame::{Bytes, Declaring, Stage, Step};
use super::super::picture::Share;
use super::super::range::LayerRange;
use crate::device::Tuning;
use crate::layers::Lattice;
use crate::settings::Layered;
use crate::viewport::Viewport;
use crate::volume::Description;

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

    /// Whether buffers fit.
    pub fn fits(self, needed: Bytes) -> bool {
        needed.sum <= self.free() && needed.largest <= self.largest
    }
}

/// A lattice that is drawn and warped.
pub(super) struct Needs<'a> {
    lattice: &'a Lattice,
    layered: Layered,
    viewport: Viewport,
    tuning: &'a Tuning,
    description: &'a Description,
    tables: &'a TableSizes<'a>,
}

impl<'a> Needs<'a> {
    pub fn new(
        lattice: &'a Lattice,
        layered: Layered,
        viewport: Viewport,
        tuning: &'a Tuning,
        description: &'a Description,
        tables: &'a TableSizes<'a>,
    ) -> Self {
        Self { lattice, layered, viewport, tuning, description, tables }
    }

    /// Bytes while so many layers are held.
    pub fn holding(&self, layers: usize) -> Bytes {
        let Self { lattice, layered, viewport, tuning, description, tables } = *self;
        let mut dims = description.grid().dims();
        dims[lattice.frame.a] = layers;
        let declaring = Declaring { shape: FieldShape::new(description, dims), tables, tuning, viewport };
        let steps = vec![
            Step::Layers { lattice, layered, range: LayerRange::whole(lattice) },
            Step::Warp { lattice, share: Share::WHOLE },
        ];
        Stage::new(steps, false, &declaring).resources.bytes()
    }

    /// Bytes of the voxels of a layer.
    pub fn layer(&self) -> u64 {
        let [u, v, _] = self.lattice.dims;
        (u * v * self.description.voxel_type().bytes()) as u64
    }

    /// Layers of the whole volume.
    pub fn layers(&self) -> usize {
        self.lattice.dims[2]
    }
}
