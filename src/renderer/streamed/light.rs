//! Light of streamed views: swept slab by slab before the first part, unless it is kept from an earlier frame.

use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::super::frame::{Bytes, DeclaredLight, Declaring, PartOfLight, Resources, Stage, Step};
use super::super::light::{
    BlockSlabs, HostField, HostVolumes, LightOfParts, SweepGroup, Wanted, WantedField, extinction_estimator,
};
use super::super::lighting::Lighting;
use super::needs::MemoryLimits;
use super::plan::out_of_memory;
use super::{Engine, StreamedRenderer};
use crate::error::Error;
use crate::layers::{Axis, Rays};
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::VoxelBox;

/// The light that a streamed view looks up.
pub(super) struct PlannedLight {
    wanted: Vec<Wanted>,
    /// What must be swept for it, in slabs.
    groups: Vec<SweepGroup>,
    /// The light field of the studio, and the blocks that must be summed for it.
    field: Option<WantedField>,
    blocks: Option<BlockSlabs>,
    /// Memory on the device for that.
    pub bytes: Bytes,
    /// Bytes of voxels that are read for it.
    pub read: u64,
}

impl PlannedLight {
    /// What a part of a view needs of it.
    pub fn declared(&self, settings: &Settings) -> DeclaredLight {
        let volumes = |sky: bool| self.wanted.iter().filter(|of| of.is_sky() == sky).map(Wanted::volumes).sum::<usize>();
        DeclaredLight {
            volumes: volumes(false),
            sky: volumes(true) > 0,
            studio: self.field.as_ref().map(WantedField::grids),
            of_colors: false,
            grid: settings.swept_grid(),
            part: None,
        }
    }

    /// The voxels with which it begins, if anything is missing, and the room for others of the same stage.
    pub fn first_voxels(&self) -> Option<(VoxelBox, usize)> {
        let count = |dims: [usize; 3]| dims.iter().product();
        match (self.groups.first(), &self.blocks) {
            (Some(group), _) => Some((group.voxels(&group.slabs[0]), count(group.most_voxels(group.most_layers())))),
            (None, Some(blocks)) => Some((blocks.voxels(&blocks.slabs[0]), count(blocks.most_voxels(blocks.most_layers())))),
            (None, None) => None,
        }
    }
}

/// The largest number of slab layers, of `all`, for which `needed` fits into the limits.
fn most_layers(all: usize, limits: MemoryLimits, needed: impl Fn(usize) -> Bytes) -> usize {
    let numbers: Vec<usize> = (1..=all).collect();
    numbers.partition_point(|&layers| limits.fits(needed(layers)))
}

impl StreamedRenderer<'_> {
    /// Plans the light of a view: in as few slabs as the limits allow. `None` if it has no shadows and no ambient occlusion.
    ///
    /// # Errors
    /// If not even a single layer fits, or if the light field is too fine.
    pub(super) fn plan_light(
        &self,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
        limits: MemoryLimits,
    ) -> Result<Option<PlannedLight>, Error> {
        let Some(sources) = Lighting::sources_in(settings, &self.grid, rays) else { return Ok(None) };
        let (wanted, field) = (Wanted::all(&sources, settings), WantedField::new(&sources, settings)?);
        let is_missing = |of: &Wanted| !self.light.iter().any(|kept| kept.wanted == *of);
        let mut groups = SweepGroup::all(&wanted, is_missing, (self.grid.dims(), self.grid.spacing()), settings);
        let (mut bytes, mut read) = (Bytes::default(), 0);
        for group in &mut groups {
            let needed = |layers: usize| self.needs_of_sweeps(group, layers, viewport, settings);
            let most = most_layers(group.layers(), limits, needed);
            if most == 0 {
                let what = "the light of this view of the volume, one layer at a time,";
                return Err(out_of_memory(&self.device, settings, what, needed(1), limits));
            }
            group.divide(group.layers().div_ceil(most));
            bytes = bytes.max(self.needs_of_sweeps(group, group.most_layers(), viewport, settings));
            read += group.slabs.iter().map(|slab| group.voxels(slab).count()).sum::<usize>();
        }
        let mut light = PlannedLight { wanted, groups, field, blocks: None, bytes, read: 0 };
        if let Some(field) =
            light.field.as_ref().filter(|field| self.light_field.as_ref().is_none_or(|kept| kept.wanted != **field))
        {
            let mut blocks = BlockSlabs::new(field, &self.grid, settings);
            let needed = |layers: usize| self.needs_of_blocks(&light, &blocks, layers, viewport, settings);
            let most = most_layers(blocks.layers(), limits, needed);
            if most == 0 {
                let what = "the scattered light of this volume";
                return Err(out_of_memory(&self.device, settings, what, needed(1), limits));
            }
            blocks.divide(blocks.layers().div_ceil(most));
            light.bytes = light.bytes.max(self.needs_of_blocks(&light, &blocks, blocks.most_layers(), viewport, settings));
            read += blocks.slabs.iter().map(|slab| blocks.voxels(slab).count()).sum::<usize>();
            light.blocks = Some(blocks);
        }
        light.read = (read * self.volume.voxel_type().bytes()) as u64;
        Ok(Some(light))
    }

    /// Memory on the device for sweeps through slabs of at most this many layers.
    fn needs_of_sweeps(&self, group: &SweepGroup, layers: usize, viewport: Viewport, settings: &Settings) -> Bytes {
        let description = self.volume.description();
        let shape = FieldShape::new(description, group.most_voxels(layers));
        let tables = &TableSizes::new(&self.transfer, description);
        let gradient = extinction_estimator(settings);
        let declaring = Declaring { gradient, ..Declaring::new(shape, tables, self.device.tuning(), viewport) };
        let mut resources = Resources::default();
        resources.field(&declaring.shape);
        group.declare(&declaring, layers, &mut resources);
        resources.bytes()
    }

    /// Memory on the device for slabs of at most this many layers of blocks, and for scattering.
    fn needs_of_blocks(
        &self,
        light: &PlannedLight,
        blocks: &BlockSlabs,
        layers: usize,
        viewport: Viewport,
        settings: &Settings,
    ) -> Bytes {
        let tables = &TableSizes::new(&self.transfer, self.volume.description());
        let declaring = Declaring::new(self.shape_of_blocks(blocks, layers), tables, self.device.tuning(), viewport);
        let (gradient, light) = (extinction_estimator(settings), Some(self.light_of_blocks(light, blocks, layers, settings)));
        let mut resources = Resources::default();
        resources.field(&declaring.shape);
        blocks.declare(&Declaring { gradient, light, ..declaring }, layers, &mut resources);
        resources.bytes()
    }

    fn shape_of_blocks(&self, blocks: &BlockSlabs, layers: usize) -> FieldShape {
        FieldShape::new(self.volume.description(), blocks.most_voxels(layers))
    }

    /// The light that slabs of blocks look up: that of the lights.
    fn light_of_blocks(&self, light: &PlannedLight, blocks: &BlockSlabs, layers: usize, settings: &Settings) -> DeclaredLight {
        let part = PartOfLight { whole: self.grid.dims(), axis: Axis::Z, layers: blocks.most_own_layers(layers) };
        DeclaredLight { studio: None, part: Some(part), ..light.declared(settings) }
    }

    /// The light volumes of a view: those that are kept, and others without light yet.
    pub(super) fn take_light(&mut self, planned: &PlannedLight) -> Result<LightOfParts, Error> {
        let spacing = self.grid.spacing();
        let volumes = planned.wanted.iter().map(|of| match self.light.iter().position(|kept| kept.wanted == *of) {
            Some(n) => Ok(self.light.remove(n)),
            None => {
                // One of each kind is kept.
                self.light.retain(|kept| kept.wanted.is_sky() != of.is_sky());
                HostVolumes::new(of, spacing)
            }
        });
        let volumes = volumes.collect::<Result<_, _>>()?;
        let field = planned.field.as_ref().map(|of| match self.light_field.take().filter(|kept| kept.wanted == *of) {
            Some(kept) => Ok(kept),
            None => HostField::new(of),
        });
        Ok(LightOfParts::new(volumes, field.transpose()?))
    }

    /// The steps that sweep and scatter the light of a view.
    pub(super) fn light_stages<'a>(
        &self,
        engine: &Engine,
        planned: &'a PlannedLight,
        light: &'a LightOfParts,
        (viewport, settings): (Viewport, &Settings),
    ) -> Vec<Stage<'a>> {
        let stage = |(n, group): (usize, &'a SweepGroup)| {
            let dims = group.most_voxels(group.most_layers());
            let mut steps = Vec::new();
            for (slab, layers) in group.slabs.iter().enumerate() {
                steps.push(Step::Hold { voxels: group.voxels(layers), capacity: dims.iter().product() });
                steps.push(Step::Sweep { light, group, slab });
            }
            if n + 1 == planned.groups.len() {
                steps.push(Step::FinishLight(light));
            }
            let (shape, gradient) = (FieldShape::new(self.volume.description(), dims), extinction_estimator(settings));
            engine.declaring(viewport, settings, |declaring| {
                Stage::new(steps, false, &Declaring { shape, gradient, light: None, ..*declaring })
            })
        };
        let sweeps = planned.groups.iter().enumerate().map(stage);
        sweeps
            .chain(
                planned.blocks.as_ref().map(|blocks| self.blocks_stage(engine, (planned, blocks), light, (viewport, settings))),
            )
            .collect()
    }

    /// The steps that sum the blocks of a light field and scatter light between them.
    fn blocks_stage<'a>(
        &self,
        engine: &Engine,
        (planned, slabs): (&'a PlannedLight, &'a BlockSlabs),
        light: &'a LightOfParts,
        (viewport, settings): (Viewport, &Settings),
    ) -> Stage<'a> {
        let most = slabs.most_layers();
        let mut steps = Vec::new();
        for (slab, layers) in slabs.slabs.iter().enumerate() {
            steps.push(Step::Hold { voxels: slabs.voxels(layers), capacity: slabs.most_voxels(most).iter().product() });
            steps.push(Step::HoldLight { light, axis: Axis::Z, voxels: slabs.own_layers(layers) });
            steps.push(Step::SumBlocks { light, slabs, slab });
        }
        steps.push(Step::Scatter(light));
        let (shape, gradient) = (self.shape_of_blocks(slabs, most), extinction_estimator(settings));
        let light = Some(self.light_of_blocks(planned, slabs, most, settings));
        engine.declaring(viewport, settings, |declaring| {
            Stage::new(steps, false, &Declaring { shape, gradient, light, ..*declaring })
        })
    }
}
