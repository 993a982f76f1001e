//! Device memory of a lattice by the number of layers held, from the resource declarations of its frame.

use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::super::frame::{Bytes, DeclaredLight, Declaring, PartOfLight, Stage, Step};
use super::super::picture::Share;
use super::super::range::LayerRange;
use super::super::surfaces::SurfaceSizes;
use crate::device::Tuning;
use crate::layers::{GradientEstimator, Lattice};
use crate::settings::{Layered, Settings};
use crate::viewport::Viewport;
use crate::volume::Description;

/// Memory limits of a device.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemoryLimits {
    /// Total bytes of all buffers.
    pub budget: u64,
    /// Bytes of the budget that other objects hold.
    pub taken: u64,
    /// Bytes of the largest possible buffer.
    pub largest: u64,
}

impl MemoryLimits {
    /// Available bytes.
    pub fn free(self) -> u64 {
        self.budget.saturating_sub(self.taken)
    }

    /// Whether buffers fit into the limits.
    pub fn fits(self, needed: Bytes) -> bool {
        needed.sum <= self.free() && needed.largest <= self.largest
    }
}

/// Inputs of the resource declarations of a lattice and its warp.
pub(super) struct Needs<'a> {
    lattice: &'a Lattice,
    layered: Layered,
    gradient: Option<GradientEstimator>,
    light: Option<DeclaredLight>,
    viewport: Viewport,
    surfaces: Option<SurfaceSizes>,
    tuning: &'a Tuning,
    description: &'a Description,
    tables: &'a TableSizes<'a>,
}

impl<'a> Needs<'a> {
    pub fn new(
        lattice: &'a Lattice,
        (layered, settings, light): (Layered, &Settings, Option<DeclaredLight>),
        (viewport, surfaces): (Viewport, Option<SurfaceSizes>),
        tuning: &'a Tuning,
        description: &'a Description,
        tables: &'a TableSizes<'a>,
    ) -> Self {
        let gradient = settings.needed_gradient();
        Self { lattice, layered, gradient, light, viewport, surfaces, tuning, description, tables }
    }

    /// Device memory with this number of layers held.
    pub fn bytes(&self, layers: usize) -> Bytes {
        let Self { lattice, layered, gradient, light, viewport, surfaces, tuning, description, tables } = *self;
        let whole = description.grid().dims();
        let mut dims = whole;
        dims[lattice.frame.a] = layers;
        // Fragments of surfaces may be anywhere.
        let lit = if surfaces.is_some() { whole[lattice.frame.a] } else { layers };
        let part = Some(PartOfLight { whole, axis: lattice.frame.layer_axis(), layers: lit });
        let light = light.map(|light| DeclaredLight { part, ..light });
        let shape = FieldShape::new(description, dims);
        let declaring = Declaring { gradient, light, ..Declaring::new(shape, tables, tuning, viewport) };
        let steps = vec![
            Step::Layers { lattice, layered, range: LayerRange::whole(lattice) },
            Step::Warp { lattice, share: Share::WHOLE },
        ];
        let steps = match surfaces {
            Some(surfaces) => vec![Step::Surfaces(steps, surfaces)],
            None => steps,
        };
        Stage::new(steps, false, &declaring).resources.bytes()
    }

    /// Bytes of the voxels of one layer.
    pub fn layer_bytes(&self) -> u64 {
        let [u, v, _] = self.lattice.dims;
        (u * v * self.description.voxel_type().bytes()) as u64
    }

    /// Number of layers of the whole volume.
    pub fn layer_count(&self) -> usize {
        self.lattice.dims[2]
    }
}
