//! Light of distributed volumes: each rank sweeps one slab of a group, first to find what it does to rays, then from the state in which they
//! arrive. For `distributed`.

use super::blocks::{BlockSlabs, HostField};
use super::host::{HostVolumes, Wanted};
use super::slabs::{LightOfParts, SweepGroup, Target};
use crate::device::Tuning;
use crate::error::Error;
use crate::layers::Axis;
use crate::settings::Settings;
use crate::volume::{Grid, VoxelBox};
use std::ops::Range;

/// Transmittances of the rays of each sweep of a group, tile by tile.
pub(crate) type RayStates = Vec<Vec<f32>>;

impl LightOfParts {
    /// The wanted volumes: those of `kept` that are among them, and others without light yet.
    pub fn continued(kept: Option<Self>, wanted: &[Wanted], grid: &Grid) -> Result<Self, Error> {
        let mut kept = kept.map_or(Vec::new(), Self::into_volumes);
        let volumes = wanted.iter().map(|of| match kept.iter().position(|kept| kept.wanted == *of && kept.is_complete) {
            Some(n) => Ok(kept.swap_remove(n)),
            None => HostVolumes::new(of, grid.spacing()),
        });
        Ok(Self::new(volumes.collect::<Result<_, _>>()?, None))
    }

    /// What must be swept to complete the volumes.
    pub fn missing(&self, grid: &Grid, settings: &Settings) -> Vec<SweepGroup> {
        let volumes = self.volumes();
        let wanted: Vec<_> = volumes.iter().map(|volumes| volumes.wanted.clone()).collect();
        let is_missing = |of: &Wanted| volumes.iter().any(|volumes| volumes.wanted == *of && !volumes.is_complete);
        SweepGroup::all(&wanted, is_missing, (grid.dims(), grid.spacing()), settings)
    }

    /// Volumes for the values of a slab of a group.
    pub fn of_slab(&self, group: &SweepGroup, slab: &Range<usize>) -> Result<Self, Error> {
        let values = group.values(slab);
        let volumes = self.volumes();
        let own = volumes.iter().map(|volumes| {
            let of = &volumes.wanted;
            let contributes = group.grid.voxels() == of.grid.voxels();
            // Volumes of another resolution have other groups.
            let grid = if contributes { values } else { of.grid.with_layers(Axis::X, &(0..0)) };
            HostVolumes::new(&of.with_grid(grid), group.spacing)
        });
        Ok(Self::new(own.collect::<Result<_, _>>()?, None))
    }

    /// The same with a light field.
    pub fn with_field(self, field: Option<HostField>) -> Self {
        *self.field() = field;
        self
    }

    /// The sums of some layers of blocks.
    pub fn sums(&self, layers: &Range<usize>) -> Vec<f32> {
        self.field().as_ref().map_or(Vec::new(), |field| field.sums(layers))
    }

    /// Stores the sums of some layers of blocks.
    pub fn receive_sums(&self, layers: &Range<usize>, sums: &[f32]) {
        self.field().iter_mut().for_each(|field| field.receive(layers, sums));
    }

    /// The values of a box in the volume of a target.
    pub fn values_of(&self, target: Target, wanted: VoxelBox) -> Vec<u8> {
        self.volumes()[target.wanted].values_of(target.volume, wanted)
    }

    /// Stores the values of a box, as those of [`values_of`](Self::values_of).
    pub fn receive(&self, target: Target, from: VoxelBox, bytes: Vec<u8>) {
        self.merge([(target, from, bytes)]);
    }
}

impl Target {
    /// Bytes per value: those of sums or of light.
    pub fn bytes(self) -> usize {
        if self.several { size_of::<u16>() } else { 1 }
    }

    /// The values of the target's volume that a part of a view needs, which holds these layers of voxels along an axis.
    pub fn needed(self, wanted: &[Wanted], axis: Axis, voxels: &Range<usize>) -> VoxelBox {
        wanted[self.wanted].grid.around_part(axis, voxels).held()
    }
}

impl SweepGroup {
    /// The volumes that the group contributes to.
    pub fn targets(&self) -> Vec<Target> {
        let mut targets: Vec<Target> = self.sweeps.iter().map(|&(target, _)| target).collect();
        targets.dedup();
        targets
    }

    /// Whether the light shines towards lower layers.
    pub fn descends(&self) -> bool {
        self.descends
    }

    /// Voxels per value and axis.
    pub fn voxels_per_value(&self) -> usize {
        self.grid.voxels()
    }

    /// The values of a slab, counted from the first of the margin.
    pub fn values_of_slab(&self, slab: &Range<usize>) -> VoxelBox {
        self.values(slab).held()
    }

    /// Number of states of the rays of all sweeps on this device.
    pub fn all_states(&self, tuning: &Tuning) -> usize {
        self.sweeps.iter().map(|(_, sweep)| self.states(sweep, tuning)).sum()
    }

    /// Whether light comes back behind what absorbs it: then a slab adds light to rays, too.
    pub fn recovers(&self) -> bool {
        self.sweeps.iter().any(|(target, _)| target.reach.is_some())
    }

    /// Sets the rays before a slab: all of one value.
    pub fn begin_with(&self, transmittance: f32, tuning: &Tuning) {
        *self.rays() = self.sweeps.iter().map(|(_, sweep)| vec![transmittance; self.states(sweep, tuning)]).collect();
    }

    /// Sets the rays before a slab.
    pub fn set_rays(&self, states: RayStates) {
        *self.rays() = states;
    }

    /// The rays behind a slab.
    pub fn take_rays(&self) -> RayStates {
        std::mem::take(&mut *self.rays())
    }

    /// Splits states of all sweeps on this device, which were joined.
    pub fn split_states(&self, joined: &[f32], tuning: &Tuning) -> RayStates {
        let mut left = joined;
        let take = |(_, sweep): &(Target, _)| {
            let (own, others) = left.split_at(self.states(sweep, tuning));
            left = others;
            own.to_vec()
        };
        self.sweeps.iter().map(take).collect()
    }
}

impl HostField {
    /// The light field, for those that have not computed it.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Takes the light field from another rank.
    pub fn complete(&mut self, bytes: &[u8]) {
        self.bytes.copy_from_slice(bytes);
        self.sums = None;
    }

    fn sums(&self, layers: &Range<usize>) -> Vec<f32> {
        let [x, y, z] = self.wanted.grids().blocks;
        let sums: &[f32] = bytemuck::cast_slice(self.sums.as_ref().expect("not all blocks are in"));
        sums.chunks_exact(x * y * z).flat_map(|plane| &plane[x * y * layers.start..x * y * layers.end]).copied().collect()
    }
}

impl BlockSlabs {
    /// Voxels along z per layer of blocks.
    pub fn voxels_per_layer(&self) -> usize {
        self.grids.per_block[2]
    }
}

/// The state of rays behind a slab: it maps the state T before to a + (b - a) T, where `a` are the rays that begin dark, `b` those that begin
/// undimmed.
pub(crate) fn behind(a: Option<&[f32]>, b: &[f32], before: &[f32]) -> Vec<f32> {
    match a {
        None => b.iter().zip(before).map(|(b, before)| b * before).collect(),
        Some(a) => a.iter().zip(b).zip(before).map(|((a, b), before)| a + (b - a) * before).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{SIZE, light_of, shadow_of, transfer, volume};
    use super::*;
    use crate::camera::{Camera, Orbit};
    use crate::device::Device;
    use crate::renderer::parts::{LatticeView, SeenVolume};
    use crate::renderer::{PartRenderer, UploadedVolume};
    use crate::settings::{AmbientOcclusion, Light};
    use crate::transfer::TransferFunction;
    use crate::volume::Volume;
    use glam::DVec3;

    const RANKS: usize = 3;

    /// The light volume that ranks sweep together. `sees_others`: whether rays continue from the slabs before.
    fn together(volume: &Volume, transfer: &TransferFunction, settings: &Settings, sees_others: bool) -> Vec<u8> {
        let (description, grid) = (volume.description(), volume.grid());
        let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth: 9.0, ..Orbit::default() });
        let (view, _) = LatticeView::all(SeenVolume { description, transfer }, &camera, SIZE, settings).unwrap().remove(0);
        let (light, groups) = view.light(description, None, &view.wanted_light(description).unwrap().0).unwrap();
        for mut group in groups {
            group.divide(RANKS);
            let (mut before, slabs) = (Vec::new(), std::mem::take(&mut group.slabs));
            for slab in slabs {
                group.slabs = vec![slab.clone()];
                let voxels = group.voxels(&slab);
                let part = volume.part(voxels.first, voxels.dims).unwrap();
                let mut renderer =
                    PartRenderer::from_uploaded(&UploadedVolume::part(&Device::shared(), &part).unwrap(), transfer);
                let ignored = LightOfParts::new(Vec::new(), None);
                let mut after = |transmittance: f32| {
                    group.begin_with(transmittance, renderer.tuning());
                    renderer.sweep(&view, &ignored, &group).unwrap();
                    group.take_rays().concat()
                };
                let (dark, undimmed) = (after(0.0), after(1.0));
                if before.is_empty() || !sees_others {
                    before = vec![1.0; undimmed.len()];
                }
                group.set_rays(group.split_states(&before, renderer.tuning()));
                renderer.sweep(&view, &light, &group).unwrap();
                before = behind(group.recovers().then_some(&dark[..]), &undimmed, &before);
            }
        }
        let part = volume.part([0; 3], grid.dims()).unwrap();
        let mut renderer = PartRenderer::from_uploaded(&UploadedVolume::part(&Device::shared(), &part).unwrap(), transfer);
        renderer.finish_light(&view, &light).unwrap();
        let volumes = light.into_volumes().remove(0);
        volumes.values_of(0, volumes.wanted.grid.held())
    }

    /// Rounding of composed maps changes a byte by 1 at most.
    #[test]
    fn light_of_ranks_is_that_of_the_whole_volume() {
        let blobs = volume([50, 41, 37], DVec3::new(1.0, 1.3, 0.8), |p| (p * 0.31).sin().element_sum() > 1.4);
        let transfer = transfer(0.05);
        let shadows = |x, y, z| shadow_of(Light::towards(DVec3::new(x, y, z)));
        let occlusion = |reach| Some(AmbientOcclusion { reach, gain: 1.0 });
        let sky = |reach| Settings { shadows: None, ambient_occlusion: occlusion(reach), ..shadow_of(Light::AT_CAMERA) };
        for settings in [shadows(0.3, 0.2, -1.0), shadows(-1.0, 0.4, 0.3), shadows(0.1, 1.0, 0.6), sky(None), sky(Some(8.0))] {
            let whole = light_of(&blobs, &transfer, &settings).bytes;
            let apart = |found: &[u8]| found.iter().zip(&whole).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            let found = apart(&together(&blobs, &transfer, &settings, true));
            assert!(found <= 1, "{settings:?}: {found} of 255");
            let alone = apart(&together(&blobs, &transfer, &settings, false));
            assert!(alone > 20, "{settings:?}: shadows of other ranks must be noticed, but change light by {alone} of 255 only");
        }
    }
}
