//! Light of distributed volumes. For each axis and order of sweeps, every rank sweeps one slab alone, which gives what the slab does to rays.
//! These maps are composed in the order of the light, and each rank sweeps again from the rays that arrive. The values then go to the ranks
//! whose layers of the view look them up.

use super::{Renderer, Source, slab};
use crate::distributed::exchange::swap_boxes;
use crate::distributed::partition;
use crate::error::Error;
use crate::renderer::{Exchanged, LatticeView, LightOfParts, PartRenderer, SweepGroup, Target, UploadedVolume, Wanted, behind};
use crate::volume::VoxelBox;
use std::ops::Range;

impl Renderer<'_> {
    /// Ensures that every rank has the light that its layers of a view look up. Returns the traffic of voxels and light. Collective.
    pub(super) fn hold_light(&mut self, view: &LatticeView) -> Result<Exchanged, Error> {
        let wanted = view.wanted_light(self.description());
        let (dims, axis) = (self.description().grid().dims(), view.axis());
        let partition = self.partitions[axis.index()].as_mut().expect("`hold` has set it");
        let held = |layers: &Range<usize>| {
            let voxels = slab(dims, axis, layers, view.settings());
            voxels.first[axis.index()]..voxels.end(axis.index())
        };
        let held: Vec<Range<usize>> = partition.ranges.iter().map(held).collect();
        let own: Vec<Wanted> = wanted.iter().map(|of| of.around_part(axis, &held[self.group.rank()])).collect();
        let kept = partition.light.take();
        let (light, groups) = self.group.agree(view.light(self.description(), kept, &own))?;
        let mut exchanged = Exchanged::default();
        let is_complete = groups.is_empty();
        for group in groups {
            let needed = |target: Target, rank: usize| target.needed(&wanted, axis, &held[rank]);
            exchanged += self.sweep_together(view, &light, group, &needed)?;
        }
        let partition = self.partitions[axis.index()].as_mut().expect("`hold` has set it");
        if !is_complete {
            let finished = partition.renderer().finish_light(view, &light);
            self.group.agree(finished)?;
        }
        partition.light = Some(light);
        Ok(exchanged)
    }

    /// Sweeps a group of sweeps and adds its values to `light`. `needed`: the values of a target that a rank needs. Collective.
    fn sweep_together(
        &self,
        view: &LatticeView,
        light: &LightOfParts,
        mut sweeps: SweepGroup,
        needed: &dyn Fn(Target, usize) -> VoxelBox,
    ) -> Result<Exchanged, Error> {
        let (group, rank) = (&self.group, self.group.rank());
        let ranges = self.slabs_of_light(&sweeps)?;
        let mut order: Vec<usize> = (0..group.size()).filter(|&rank| !ranges[rank].is_empty()).collect();
        if sweeps.descends() {
            order.reverse();
        }
        let (mut renderer, mut exchanged) = self.renderer_of_slab(&sweeps, &ranges)?;
        renderer.limit(self.longest);
        renderer.set_cancel(self.cancel.clone());
        let states = sweeps.all_states(renderer.tuning()) as u64;
        if group.min(states) != group.max(states) {
            let problem =
                "the ranks' devices have vectors of different widths, so they cannot pass rays from light to each other".into();
            return Err(Error::Settings { field: "device", problem });
        }
        let values = group.agree(light.of_slab(&sweeps, &ranges[rank]))?;
        sweeps.slabs = vec![ranges[rank].clone()];
        let place = order.iter().position(|&of| of == rank);
        let (is_first, is_last) = (place == Some(0), place == Some(order.len() - 1));
        // The first rank's rays begin undimmed; nobody needs what the last one does to them.
        let map = match place {
            Some(0) => renderer.sweep(view, &values, &sweeps).map(|()| None),
            Some(_) if !is_last => map_of_slab(&mut renderer, view, &sweeps).map(Some),
            _ => Ok(None),
        };
        let map = group.agree(map)?;
        if let Some(place) = place {
            let before = if is_first { Vec::new() } else { floats(&group.receive(order[place - 1])) };
            if !is_last {
                let after = match &map {
                    Some((a, b)) => behind(a.as_deref(), b, &before),
                    None => sweeps.take_rays().concat(),
                };
                group.send(order[place + 1], bytemuck::cast_slice(&after));
            }
            if !is_first {
                sweeps.set_rays(sweeps.split_states(&before, renderer.tuning()));
            }
        }
        let swept = if place.is_some() && !is_first { renderer.sweep(view, &values, &sweeps) } else { Ok(()) };
        group.agree(swept)?;
        for target in sweeps.targets() {
            let held = |rank: usize| (!ranges[rank].is_empty()).then(|| sweeps.values_of_slab(&ranges[rank]));
            let common = |from: usize, to: usize| held(from).and_then(|held| held.common(&needed(target, to)));
            let pack = |wanted: VoxelBox| values.values_of(target, wanted);
            exchanged += swap_boxes(group, target.bytes(), &common, &pack, &|from, bytes| light.receive(target, from, bytes));
        }
        Ok(exchanged)
    }

    /// The layers of values that each rank sweeps: equally many, or those of bricks that stay where they are.
    fn slabs_of_light(&self, sweeps: &SweepGroup) -> Result<Vec<Range<usize>>, Error> {
        if let Source::Host(_) = self.source {
            return Ok(partition::even(sweeps.layers(), self.group.size()));
        }
        let (axis, voxels) = (sweeps.axis, sweeps.voxels_per_value());
        let error = |problem: String| Err(Error::Settings { field: "lights", problem });
        let Some(bricks) = self.boxes.slabs(axis, self.description().grid().dims()) else {
            return error(format!(
                "light is swept along {axis:?}, but the bricks on the devices are no slabs along it: choose other lights"
            ));
        };
        let last = self.description().grid().dims()[axis.index()];
        if bricks.iter().any(|layers| layers.start % voxels > 0 || layers.end % voxels > 0 && layers.end < last) {
            return error(format!(
                "bricks on the devices do not begin at multiples of {voxels} layers along {axis:?}: set light_grid to full"
            ));
        }
        Ok(bricks.into_iter().map(|layers| layers.start / voxels..layers.end.div_ceil(voxels)).collect())
    }

    /// A renderer of the voxels that this rank's slab needs. Collective.
    fn renderer_of_slab(&self, sweeps: &SweepGroup, ranges: &[Range<usize>]) -> Result<(PartRenderer, Exchanged), Error> {
        // A renderer cannot hold an empty box.
        let needed = |layers: &Range<usize>| sweeps.voxels(if layers.is_empty() { &(0..1) } else { layers });
        let wanted: Vec<VoxelBox> = ranges.iter().map(needed).collect();
        match &self.source {
            Source::Host(volume) => {
                let (part, exchanged) = self.boxes.redistribute(&self.group, volume, &wanted)?;
                let uploaded = self.group.agree(UploadedVolume::part(&self.device, &part))?;
                Ok((PartRenderer::from_uploaded(&uploaded, &self.transfer), exchanged))
            }
            Source::Device(uploaded) => {
                let lacks = |rank: &usize| !ranges[*rank].is_empty() && !self.boxes.held[*rank].holds(&wanted[*rank]);
                if let Some(rank) = (0..self.group.size()).find(lacks) {
                    let (held, wanted) = (self.boxes.held[rank], wanted[rank]);
                    let problem = format!(
                        "the brick of rank {rank} on its device, {held:?}, lacks voxels of {wanted:?}, which light along {:?} needs: \
                         provide more ghost layers",
                        sweeps.axis
                    );
                    return Err(Error::Settings { field: "lights", problem });
                }
                Ok((PartRenderer::from_uploaded(uploaded, &self.transfer), Exchanged::default()))
            }
        }
    }
}

/// What a slab does to rays that begin dark, if it adds light to them, and to rays that begin undimmed.
type Map = (Option<Vec<f32>>, Vec<f32>);

fn map_of_slab(renderer: &mut PartRenderer, view: &LatticeView, sweeps: &SweepGroup) -> Result<Map, Error> {
    let ignored = LightOfParts::new(Vec::new(), None);
    let mut after = |transmittance: f32| -> Result<Vec<f32>, Error> {
        sweeps.begin_with(transmittance, renderer.tuning());
        renderer.sweep(view, &ignored, sweeps)?;
        Ok(sweeps.take_rays().concat())
    };
    Ok((if sweeps.recovers() { Some(after(0.0)?) } else { None }, after(1.0)?))
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytemuck::pod_collect_to_vec(bytes)
}
