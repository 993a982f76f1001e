//! Light of distributed volumes. For each axis and order of sweeps, every rank sweeps one slab alone, which gives what the slab does to rays.
//! These maps are composed in the order of the light, and each rank sweeps again from the rays that arrive. The values then go to the ranks
//! whose layers of the view look them up.
//!
//! In the studio, each rank sums some layers of blocks. The first one scatters light between all of them, and sends the light field to all.

use super::{Renderer, Source, slab};
use crate::distributed::exchange::swap_boxes;
use crate::distributed::partition;
use crate::error::Error;
use crate::layers::Axis;
use crate::renderer::{
    Exchanged, HostField, LatticeView, LightOfParts, PartRenderer, SweepGroup, Target, UploadedVolume, Wanted, WantedField,
    behind,
};
use crate::volume::VoxelBox;
use std::ops::Range;

impl Renderer<'_> {
    /// Ensures that every rank has the light that its layers of a view look up. Returns the traffic of voxels and light. Collective.
    pub(super) fn hold_light(&mut self, view: &LatticeView) -> Result<Exchanged, Error> {
        let (wanted, field) = self.group.agree(view.wanted_light(self.description()))?;
        let (dims, axis) = (self.description().grid().dims(), view.axis());
        let partition = self.partitions[axis.index()].as_ref().expect("`hold` has set it");
        let held = |layers: &Range<usize>| {
            let voxels = slab(dims, axis, layers, view.settings());
            voxels.first[axis.index()]..voxels.end(axis.index())
        };
        let held: Vec<Range<usize>> = partition.ranges.iter().map(held).collect();
        let mut kept = self.partitions.iter().flatten().filter_map(|partition| partition.light.as_ref()?.take_field());
        let (field, mut exchanged) = match field {
            None => (None, Exchanged::default()),
            Some(of) => match kept.find(|kept| kept.wanted == of) {
                Some(kept) => (Some(kept), Exchanged::default()),
                None => self.scatter_together(view, &wanted, of).map(|(field, exchanged)| (Some(field), exchanged))?,
            },
        };
        let kept = self.partitions[axis.index()].as_mut().and_then(|partition| partition.light.take());
        let (light, swept) = self.light_around(view, &wanted, (axis, &held), kept)?;
        exchanged += swept;
        let partition = self.partitions[axis.index()].as_mut().expect("`hold` has set it");
        partition.light = Some(light.with_field(field));
        Ok(exchanged)
    }

    /// The wanted light around the layers of voxels that each rank holds along an axis: that of `kept` and what is missing. Collective.
    fn light_around(
        &mut self,
        view: &LatticeView,
        wanted: &[Wanted],
        (axis, held): (Axis, &[Range<usize>]),
        kept: Option<LightOfParts>,
    ) -> Result<(LightOfParts, Exchanged), Error> {
        let own: Vec<Wanted> = wanted.iter().map(|of| of.around_part(axis, &held[self.group.rank()])).collect();
        let (light, groups) = self.group.agree(view.light(self.description(), kept, &own))?;
        let mut exchanged = Exchanged::default();
        let is_complete = groups.is_empty();
        for group in groups {
            let needed = |target: Target, rank: usize| target.needed(wanted, axis, &held[rank]);
            exchanged += self.sweep_together(view, &light, group, &needed)?;
        }
        if !is_complete {
            let partition = self.partitions[view.axis().index()].as_mut().expect("`hold` has set it");
            let finished = partition.renderer().finish_light(view, &light);
            self.group.agree(finished)?;
        }
        Ok((light, exchanged))
    }

    /// The light field of a view, from the blocks that each rank sums. Collective.
    fn scatter_together(
        &mut self,
        view: &LatticeView,
        wanted: &[Wanted],
        field: WantedField,
    ) -> Result<(HostField, Exchanged), Error> {
        if matches!(self.source, Source::Device(_)) && self.group.size() > 1 {
            let problem = "bricks that stay on the devices do not scatter light between them: choose the plain look";
            return Err(Error::Settings { field: "look", problem: problem.into() });
        }
        let mut blocks = view.blocks(self.description(), &field);
        let ranges = self.slabs_of_light(Axis::Z, blocks.voxels_per_layer(), blocks.layers())?;
        // A renderer cannot hold an empty box.
        let held: Vec<Range<usize>> = ranges.iter().map(not_empty).collect();
        let voxels = held.iter().map(|layers| blocks.voxels(layers)).collect();
        let own_layers: Vec<Range<usize>> = held.iter().map(|layers| blocks.own_layers(layers)).collect();
        let (light, mut exchanged) = self.light_around(view, wanted, (Axis::Z, &own_layers), None)?;
        let (mut renderer, received) = self.renderer_of_slab(Axis::Z, voxels)?;
        exchanged += received;
        let (group, rank) = (self.group.clone(), self.group.rank());
        let light = light.with_field(Some(group.agree(HostField::new(&field))?));
        blocks.slabs = vec![ranges[rank].clone()];
        let summed = if ranges[rank].is_empty() { Ok(()) } else { renderer.sum_blocks(view, &light, &blocks) };
        group.agree(summed)?;
        if group.leads() {
            for (from, layers) in ranges.iter().enumerate().skip(1) {
                let sums = group.receive(from);
                exchanged.received_bytes += sums.len() as u64;
                light.receive_sums(layers, &floats(&sums));
            }
        } else {
            let sums = light.sums(&ranges[rank]);
            group.send(0, bytemuck::cast_slice(&sums));
            exchanged.sent_bytes += size_of_val(&sums[..]) as u64;
        }
        let scattered = if group.leads() { renderer.scatter(view, &light) } else { Ok(()) };
        group.agree(scattered)?;
        let mut field = light.take_field().expect("it was set");
        let mut bytes = if group.leads() { field.bytes().to_vec() } else { Vec::new() };
        group.broadcast(0, &mut bytes);
        field.complete(&bytes);
        let (others, bytes) = (group.size() as u64 - 1, bytes.len() as u64);
        let (sent, received) = if group.leads() { (others * bytes, 0) } else { (0, bytes) };
        (exchanged.sent_bytes, exchanged.received_bytes) = (exchanged.sent_bytes + sent, exchanged.received_bytes + received);
        Ok((field, exchanged))
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
        let ranges = self.slabs_of_light(sweeps.axis, sweeps.voxels_per_value(), sweeps.layers())?;
        let mut order: Vec<usize> = (0..group.size()).filter(|&rank| !ranges[rank].is_empty()).collect();
        if sweeps.descends() {
            order.reverse();
        }
        // A renderer cannot hold an empty box.
        let voxels = ranges.iter().map(|layers| sweeps.voxels(&not_empty(layers))).collect();
        let (mut renderer, mut exchanged) = self.renderer_of_slab(sweeps.axis, voxels)?;
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

    /// The layers of values, or of blocks, of this many voxels that each rank computes: equally many, or those of bricks that stay where they
    /// are.
    fn slabs_of_light(&self, axis: Axis, voxels: usize, layers: usize) -> Result<Vec<Range<usize>>, Error> {
        if let Source::Host(_) = self.source {
            return Ok(partition::even(layers, self.group.size()));
        }
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

    /// A renderer of the voxels that this rank's slab along an axis needs, of the box of each rank. Collective.
    fn renderer_of_slab(&self, axis: Axis, wanted: Vec<VoxelBox>) -> Result<(PartRenderer, Exchanged), Error> {
        let (uploaded, exchanged) = match &self.source {
            Source::Host(volume) => {
                let (part, exchanged) = self.boxes.redistribute(&self.group, volume, &wanted)?;
                (self.group.agree(UploadedVolume::part(&self.device, &part))?, exchanged)
            }
            Source::Device(uploaded) => {
                let own = |rank: usize| self.boxes.own[rank].count() > 0;
                let lacks = |rank: &usize| own(*rank) && !self.boxes.held[*rank].holds(&wanted[*rank]);
                if let Some(rank) = (0..self.group.size()).find(lacks) {
                    let (held, wanted) = (self.boxes.held[rank], wanted[rank]);
                    let problem = format!(
                        "the brick of rank {rank} on its device, {held:?}, lacks voxels of {wanted:?}, which light along {axis:?} needs: \
                         provide more ghost layers"
                    );
                    return Err(Error::Settings { field: "lights", problem });
                }
                ((**uploaded).clone(), Exchanged::default())
            }
        };
        let mut renderer = PartRenderer::from_uploaded(&uploaded, &self.transfer);
        renderer.limit(self.longest);
        renderer.set_cancel(self.cancel.clone());
        Ok((renderer, exchanged))
    }
}

/// These layers, or the first one if they are none.
fn not_empty(layers: &Range<usize>) -> Range<usize> {
    if layers.is_empty() { 0..1 } else { layers.clone() }
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
