//! Light of distributed volumes: each rank sweeps one slab of a group, first to find what it does to rays, then from the state in which they
//! arrive. For `distributed`.

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
        Ok(Self::new(volumes.collect::<Result<_, _>>()?))
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
        Ok(Self::new(own.collect::<Result<_, _>>()?))
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

/// The state of rays behind a slab: it maps the state T before to a + (b - a) T, where `a` are the rays that begin dark, `b` those that begin
/// undimmed.
pub(crate) fn behind(a: Option<&[f32]>, b: &[f32], before: &[f32]) -> Vec<f32> {
    match a {
        None => b.iter().zip(before).map(|(b, before)| b * before).collect(),
        Some(a) => a.iter().zip(b).zip(before).map(|((a, b), before)| a + (b - a) * before).collect(),
    }
}
