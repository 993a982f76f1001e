//! Scattered light of volumes of which the device holds a part at a time: blocks of voxels are summed slab by slab, then light is scattered
//! between all of them, as in the whole volume.

use super::super::frame::{Declaring, Resources};
use super::super::scene::Scene;
use super::cells::ScatterGrids;
use super::scatter::{self, CELLS, LIGHT_FIELD, packed_bytes};
use super::slabs::{AROUND_GRADIENTS, LightOfParts};
use super::sources::{LightSources, StudioLight};
use super::{ABSORBERS, KERNEL, Medium, extinction_estimator};
use crate::device::Buffer;
use crate::device::launch::scatter::MEDIUM_PLANES;
use crate::device::launch::structs::Float4;
use crate::error::Error;
use crate::layers::Axis;
use crate::settings::{LightGrid, Settings};
use crate::volume::{Grid, MappedBytes, VoxelBox};
use std::ops::Range;
use std::sync::Arc;

/// The light field that a view looks up, and all that it depends on besides the field and the transfer function.
#[derive(Clone, PartialEq)]
pub(crate) struct WantedField {
    light: StudioLight,
    grids: ScatterGrids,
    medium: Medium,
}

impl WantedField {
    /// That of a view; `None` in the plain look.
    ///
    /// # Errors
    /// If the light field is too fine for volumes in parts, which have its memory as a whole.
    pub(in crate::renderer) fn new(sources: &LightSources, settings: &Settings) -> Result<Option<Self>, Error> {
        let Some((light, grids)) = sources.studio() else { return Ok(None) };
        if light.grid != LightGrid::Quarter {
            let problem = "volumes in parts, or on several processes, have scattered light of a quarter of the resolution only: set \
                           light_grid to quarter, give one process memory for the whole volume, or choose the plain look";
            return Err(Error::Settings { field: "light_grid", problem: problem.into() });
        }
        Ok(Some(Self { light: light.clone(), grids: *grids, medium: Medium::new(settings) }))
    }

    pub(in crate::renderer) fn grids(&self) -> ScatterGrids {
        self.grids
    }
}

/// Layers of blocks along z, whose voxels are on the device slab by slab.
pub(crate) struct BlockSlabs {
    pub(super) grids: ScatterGrids,
    voxel_dims: [usize; 3],
    /// Layers of voxels that are needed around a slab.
    around: usize,
    /// Layers of blocks of each slab.
    pub slabs: Vec<Range<usize>>,
}

impl BlockSlabs {
    /// All blocks of a light field, without slabs.
    pub fn new(wanted: &WantedField, grid: &Grid, settings: &Settings) -> Self {
        let of_gradients = extinction_estimator(settings).map_or(0, |estimator| AROUND_GRADIENTS + estimator.smoothing_radius());
        // Surfaces look at the next voxels.
        Self { grids: wanted.grids, voxel_dims: grid.dims(), around: of_gradients.max(1), slabs: Vec::new() }
    }

    /// Number of layers of blocks.
    pub fn layers(&self) -> usize {
        self.grids.blocks[2]
    }

    /// Layers of blocks of the largest slab.
    pub fn most_layers(&self) -> usize {
        self.slabs.iter().map(Range::len).max().unwrap_or(0)
    }

    /// Divides the layers into this many slabs.
    pub fn divide(&mut self, slabs: usize) {
        let all = self.layers();
        self.slabs = (0..slabs).map(|n| n * all / slabs..(n + 1) * all / slabs).collect();
    }

    /// The layers of voxels of a slab.
    pub fn own_layers(&self, slab: &Range<usize>) -> Range<usize> {
        let per_block = self.grids.per_block[2];
        slab.start * per_block..(slab.end * per_block).min(self.voxel_dims[2])
    }

    /// Number of layers of voxels of a slab of this many layers, at most.
    pub fn most_own_layers(&self, layers: usize) -> usize {
        (layers * self.grids.per_block[2]).min(self.voxel_dims[2])
    }

    /// The voxels that a slab needs.
    pub fn voxels(&self, slab: &Range<usize>) -> VoxelBox {
        let own = self.own_layers(slab);
        let needed = own.start.saturating_sub(self.around)..(own.end + self.around).min(self.voxel_dims[2]);
        VoxelBox::layers(self.voxel_dims, Axis::Z.index(), &needed)
    }

    /// Dimensions of the voxels that a slab of this many layers needs at most.
    pub fn most_voxels(&self, layers: usize) -> [usize; 3] {
        let [x, y, z] = self.voxel_dims;
        [x, y, (self.most_own_layers(layers) + 2 * self.around).min(z)]
    }

    /// Declares what slabs of at most this many layers and scattering need besides the voxels.
    pub(in crate::renderer) fn declare(&self, declaring: &Declaring, layers: usize, resources: &mut Resources) {
        super::declare(declaring, resources);
        declaring.gradients(Axis::Z, KERNEL, resources);
        declaring.table(KERNEL, resources);
        resources.host(&ABSORBERS, 1);
        let [x, y, _] = self.grids.blocks;
        let entries = size_of::<Float4>() * declaring.tables.entries(KERNEL);
        let sums = size_of::<f32>() * MEDIUM_PLANES * x * y * layers;
        resources.kept(("slabs", None, None, 0), [(CELLS, entries), (CELLS, sums)]);
        resources.kept((LIGHT_FIELD, None, None, 0), scatter::declared(&self.grids, LightGrid::Quarter, declaring.tuning));
    }
}

/// A light field on the host and, until all blocks are in, their sums.
pub(crate) struct HostField {
    pub wanted: WantedField,
    pub(super) bytes: MappedBytes,
    pub(super) sums: Option<MappedBytes>,
}

impl HostField {
    /// One without light, in temporary files.
    pub fn new(wanted: &WantedField) -> Result<Self, Error> {
        let grids = &wanted.grids;
        let sums = size_of::<f32>() * MEDIUM_PLANES * grids.blocks.iter().product::<usize>();
        let bytes = MappedBytes::zeroed(packed_bytes(wanted.light.cells(grids)))?;
        Ok(Self { wanted: wanted.clone(), bytes, sums: Some(MappedBytes::zeroed(sums)?) })
    }

    /// Whether all light is in.
    pub fn is_complete(&self) -> bool {
        self.sums.is_none()
    }

    /// Stores the sums of some layers of blocks.
    pub(super) fn receive(&mut self, layers: &Range<usize>, found: &[f32]) {
        let [x, y, z] = self.wanted.grids.blocks;
        let sums: &mut [f32] = bytemuck::cast_slice_mut(self.sums.as_mut().expect("not all blocks are in"));
        for (plane, found) in sums.chunks_exact_mut(x * y * z).zip(found.chunks_exact(x * y * layers.len())) {
            plane[x * y * layers.start..x * y * layers.end].copy_from_slice(found);
        }
    }

    /// The light field on the device.
    pub(super) fn upload(&self, device: &crate::device::Device) -> Result<Arc<Buffer<u8>>, Error> {
        Ok(Arc::new(Buffer::from_slice(device, &self.bytes, LIGHT_FIELD)?))
    }
}

impl Scene<'_> {
    /// Sums the blocks of a slab, whose voxels and light are on the device.
    pub fn sum_blocks(&mut self, light: &LightOfParts, layers: &Range<usize>) -> Result<(), Error> {
        let mut sources = self.light_sources().expect("the studio has lights");
        let given = self.light.given.as_ref().expect("the light of the slab is there");
        let lights = given.illumination.lights.clone();
        sources.set_grids(given.grids);
        let (of, grids) = sources.studio().expect("the look is the studio");
        let on_device = self.scatter_blocks(of, grids, &sources, lights.as_deref(), layers.clone())?;
        let mut found = vec![0.0; on_device.len()];
        on_device.read(self.device, &mut found)?;
        light.field().as_mut().expect("the studio has a light field").receive(layers, &found);
        Ok(())
    }

    /// Scatters light between all blocks, whose sums are in.
    pub fn scatter_light(&mut self, light: &LightOfParts) -> Result<(), Error> {
        // Free its memory first. It holds no light field yet.
        self.light.given = None;
        let mut field = light.field();
        let HostField { wanted, bytes, sums } = field.as_mut().expect("the studio has a light field");
        let blocks = sums.as_ref().expect("not all blocks were in");
        let blocks = Buffer::from_slice(self.device, bytemuck::cast_slice(blocks), CELLS)?;
        let packed = Buffer::new(self.device, bytes.len(), LIGHT_FIELD)?;
        self.solve(&wanted.light, wanted.grids, &blocks, &packed)?;
        packed.read(self.device, bytes)?;
        *sums = None;
        Ok(())
    }
}
