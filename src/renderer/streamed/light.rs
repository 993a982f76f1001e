//! Light of streamed views: swept slab by slab before the first part, unless it is kept from an earlier frame.

use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::super::frame::{Bytes, DeclaredLight, Declaring, Resources, Stage, Step};
use super::super::light::{HostVolumes, LightOfParts, SweepGroup, Wanted, extinction_estimator};
use super::super::lighting::Lighting;
use super::needs::MemoryLimits;
use super::plan::out_of_memory;
use super::{Engine, StreamedRenderer};
use crate::error::Error;
use crate::layers::Rays;
use crate::settings::Settings;
use crate::viewport::Viewport;

/// The light that a streamed view looks up.
pub(super) struct PlannedLight {
    wanted: Vec<Wanted>,
    /// What must be swept for it, in slabs.
    pub groups: Vec<SweepGroup>,
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
            studio: None,
            of_colors: false,
            grid: settings.swept_grid(),
            part: None,
        }
    }
}

impl StreamedRenderer<'_> {
    /// Plans the light of a view: in as few slabs as the limits allow. `None` if it has no shadows and no ambient occlusion.
    ///
    /// # Errors
    /// If not even a single layer fits.
    pub(super) fn plan_light(
        &self,
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
        limits: MemoryLimits,
    ) -> Result<Option<PlannedLight>, Error> {
        if settings.studio.is_some() {
            let problem =
                "light scatters through the whole volume, which does not fit: allow more memory, or choose the plain look";
            return Err(Error::Settings { field: "look", problem: problem.into() });
        }
        let Some(sources) = Lighting::sources_in(settings, &self.grid, rays) else { return Ok(None) };
        let wanted = Wanted::all(&sources, settings);
        let is_missing = |of: &Wanted| !self.light.iter().any(|kept| kept.wanted == *of);
        let mut groups = SweepGroup::all(&wanted, is_missing, (self.grid.dims(), self.grid.spacing()), settings);
        let (mut bytes, mut read) = (Bytes::default(), 0);
        for group in &mut groups {
            let needed = |layers: usize| self.needs_of_sweeps(group, layers, viewport, settings);
            let all: Vec<usize> = (1..=group.layers()).collect();
            let most = all.partition_point(|&layers| limits.fits(needed(layers)));
            if most == 0 {
                let what = "the light of this view of the volume, one layer at a time,";
                return Err(out_of_memory(&self.device, settings, what, needed(1), limits));
            }
            group.divide(group.layers().div_ceil(most));
            let own = self.needs_of_sweeps(group, group.most_layers(), viewport, settings);
            bytes = Bytes { sum: bytes.sum.max(own.sum), largest: bytes.largest.max(own.largest) };
            let voxels: usize = group.slabs.iter().map(|slab| group.voxels(slab).count()).sum();
            read += (voxels * self.volume.voxel_type().bytes()) as u64;
        }
        Ok(Some(PlannedLight { wanted, groups, bytes, read }))
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
        Ok(LightOfParts::new(volumes.collect::<Result<_, _>>()?))
    }

    /// The steps that sweep the light of a view. The voxels of the first slab are already on the device.
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
                if (n, slab) != (0, 0) {
                    steps.push(Step::Hold { voxels: group.voxels(layers), capacity: dims.iter().product() });
                }
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
        planned.groups.iter().enumerate().map(stage).collect()
    }
}
