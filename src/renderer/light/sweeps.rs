//! Sweeps of light through the layers.

use super::super::channels::{FieldInputs, MergedInputs};
use super::super::classification::{Integrals, VisibleBlocks};
use super::super::field::Layout;
use super::super::region::Region;
use super::super::scene::{GradientVoxels, Scene};
use super::coarse::Coarse;
use super::grid::ValueGrid;
use super::sources::Source;
use super::{ABSORBERS, KERNEL, extinction_estimator};
use crate::device::launch::PerChannel;
use crate::device::launch::light::{FinishLightArguments, LightRays as SweepByRays, LightSweep, LightSweepArguments, WHOLE_SUM};
use crate::device::launch::structs::{ClassificationParams, LayerOffset, LightSweepParams, SampleParams, SegmentParams};
use crate::device::{Buffer, LatticeSchedule};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, LightRays, disc_directions, sky_directions};
use glam::DVec3;
use std::sync::Arc;

const OFFSETS: &str = "the offsets of rays from a light";
pub(super) const SUMS: &str = "the sums of light";
pub(super) const RAYS: &str = "the rays from a light";

/// One sweep, and its share of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sweep {
    /// Unit vector towards the light, in grid axes (world scale).
    to_light: DVec3,
    pub axis: Axis,
    share: f64,
}

impl Sweep {
    /// Whether the light shines towards lower layers.
    pub fn descends(&self) -> bool {
        self.to_light[self.axis.index()] > 0.0
    }

    /// The rays of this sweep through a grid of values. `spacing`: of the voxels.
    pub fn rays(&self, values: &ValueGrid, spacing: DVec3) -> LightRays {
        LightRays::new(values.inner(), self.to_light / (spacing * values.voxels() as f64), self.axis)
    }
}

/// Where the light of a sweep goes.
#[derive(Clone, Copy)]
pub(super) enum Sum {
    /// Light is written to the bytes.
    None = 0,
    /// Light is written to the sums.
    Store = 1,
    /// It is added to the sums.
    Add = 2,
}

/// The sweeps of a light: one, or several of a light with an angular diameter or near 45°, where the axis of the sweep fades as that of
/// views does.
pub(super) fn of_light(source: &Source, spacing: DVec3) -> Vec<Sweep> {
    let directions = disc_directions(source.to_light, source.angle);
    let share = 1.0 / directions.len() as f64;
    let by_axis = |to_light: DVec3| Axis::shares(to_light / spacing).into_iter().map(move |(axis, part)| (to_light, axis, part));
    directions.into_iter().flat_map(by_axis).map(|(to_light, axis, part)| Sweep { to_light, axis, share: share * part }).collect()
}

/// The sweeps of the ambient light.
pub(super) fn of_sky(spacing: DVec3) -> Vec<Sweep> {
    let sweep = |(to_light, share): (DVec3, f64)| Sweep { to_light, axis: Axis::most_parallel(to_light / spacing), share };
    sky_directions().into_iter().map(sweep).collect()
}

/// Number `n` of several sweeps: where its light goes, the factor of the light, and the value of a light of 1. The factor `gain` of the sum
/// of all is left to `finish_light`.
pub(super) fn sum_of(sweep: &Sweep, several: bool, n: usize, gain: f64) -> (Sum, f64, f64) {
    match (several, n) {
        (false, _) => (Sum::None, gain, 255.0),
        (true, 0) => (Sum::Store, 1.0, f64::from(WHOLE_SUM) * sweep.share),
        (true, _) => (Sum::Add, 1.0, f64::from(WHOLE_SUM) * sweep.share),
    }
}

/// Bytes of the sums of several sweeps.
pub(super) fn sums(values: ValueGrid) -> (&'static str, usize) {
    (SUMS, size_of::<u16>() * values.values())
}

/// Upper limit of the bytes of the offsets of rays, for a volume of `dims` voxels.
pub(super) fn offsets(dims: [usize; 3]) -> (&'static str, usize) {
    (OFFSETS, 2 * size_of::<LayerOffset>() * (dims.into_iter().max().unwrap_or(0) + 2))
}

/// What is stored of the light of a volume.
#[derive(Clone, Copy)]
pub(super) struct Finish {
    /// Factor of the light before it is clamped to 1.
    pub gain: f64,
    /// Whether its codes are stored (kernels/shared/light_codes.cl), as those of lights, or itself.
    pub coded: bool,
}

impl Scene<'_> {
    /// Sweeps light into volume number `n` of a buffer. `reach`: world distance over which shadows decrease to 1/e.
    pub(super) fn sweep_all(
        &mut self,
        sweeps: &[Sweep],
        coarse: Option<&Coarse>,
        values: ValueGrid,
        (volume, n): (&Buffer<u8>, usize),
        finish: Finish,
        reach: Option<f64>,
    ) -> Result<(), Error> {
        let several = sweeps.len() > 1;
        let sums = Buffer::new(self.device, if several { values.values() } else { 1 }, SUMS)?;
        let unused = Buffer::new(self.device, 1, RAYS)?;
        for (i, sweep) in sweeps.iter().enumerate() {
            let (sum, gain, steps) = sum_of(sweep, several, i, finish.gain);
            let stored = Stored { volume, number: n as i32, sums: &sums, sum, gain, steps };
            self.sweep(sweep, coarse, values, &stored, reach, State { rays: &unused, continues: false })?;
        }
        if several { self.finish_sums(&sums, values.values(), finish, (volume, n)) } else { Ok(()) }
    }

    /// Converts the sums of several sweeps to the bytes of volume number `n` of a buffer.
    pub(super) fn finish_sums(
        &mut self,
        sums: &Buffer<u16>,
        values: usize,
        Finish { gain, coded }: Finish,
        (volume, n): (&Buffer<u8>, usize),
    ) -> Result<(), Error> {
        let arguments = FinishLightArguments {
            sums,
            values: values as i32,
            whole: WHOLE_SUM,
            gain: gain as f32,
            coded: i32::from(coded),
            volume: n as i32,
            light: volume,
        };
        self.light.finish.launch(self.device, (), &arguments)
    }

    /// Sweeps through the layers of `values`. If these are not all, the rays' state is read and written.
    pub(super) fn sweep(
        &mut self,
        sweep: &Sweep,
        coarse: Option<&Coarse>,
        values: ValueGrid,
        stored: &Stored,
        reach: Option<f64>,
        state: State,
    ) -> Result<(), Error> {
        let frame = sweep.axis.frame();
        let spacing = self.field.grid().spacing() * values.voxels() as f64;
        let dims = values.inner();
        let rays = sweep.rays(&values, self.field.grid().spacing());
        // Layers of values are counted from the margin, layers of rays from the one behind it.
        let (first, end) = (values.held().first[frame.a] as i32, values.held().end(frame.a) as i32);
        let all = values.outer()[frame.a] as i32;
        let order = if rays.layer_step > 0 { [first, end] } else { [all - end, all - first] };
        let tuning = self.device.tuning();
        // The state of rays between slabs is that of `LightSweep`'s tiles.
        let absorbers = self.absorbers(sweep.axis, coarse)?;
        let by_rays =
            tuning.lattice_schedule == LatticeSchedule::Samples && absorbers.len() == 1 && order == [0, all] && !state.continues;
        let merged = MergedInputs::new(absorbers.iter().map(|absorber| &absorber.field).collect())?;
        let integrals: Vec<_> = absorbers.iter().map(|absorber| &absorber.integrals.nodes).collect();
        // Lengths of a step from layer to layer, in world units and in unit distances.
        let world = (DVec3::new(rays.shear[0], rays.shear[1], 1.0) * frame.local(spacing)).length();
        let step = world / self.settings.unit_distance.unwrap_or(self.field.unit_distance());
        let offsets: Vec<_> = rays.offsets.iter().flatten().map(|o| LayerOffset { base: o.base, fraction: o.fraction }).collect();
        let offsets = Buffer::from_slice(self.device, &offsets, OFFSETS)?;
        let local = |i: usize| dims[i] as i32;
        let toward = f64::from(rays.layer_step);
        let p = LightSweepParams {
            tiles: if by_rays { SweepByRays::tiles(rays.size) } else { LightSweep::tiles(rays.size, tuning) },
            blocks: merged.blocks(),
            dims: [frame.u, frame.v, frame.a].map(local),
            layer_step: rays.layer_step,
            culling: i32::from(self.settings.culling && coarse.is_none()),
            centre_layer: (dims[frame.a] as f32 - 1.0) / 2.0,
            along: rays.shear.map(|shear| (shear * toward) as f32),
            order,
            continues: i32::from(state.continues),
            stride: values.strides(frame),
            first_stored: first - 1,
            volume: stored.number,
            volume_bytes: values.values() as i32,
            sum: stored.sum as i32,
            gain: stored.gain as f32,
            steps: stored.steps as f32,
            recovered: reach.map_or(1.0, |reach| (-0.5 * world / reach).exp() as f32),
            layer_length: step as f32,
            half_layer: coarse.map_or(0.0, |coarse| (0.5 * step / coarse.length) as f32),
        };
        let fields = merged.params(self.device, ABSORBERS.name)?;
        let arguments = LightSweepArguments {
            fields: merged.arguments(&fields),
            visible: merged.visible(),
            integrals: PerChannel::new(&integrals),
            offsets: &offsets,
            p,
            ray_ends: merged.region.for_kernels(frame),
            light: stored.volume,
            sums: stored.sums,
            state: state.rays,
        };
        let variant = (merged.kind, coarse.is_some(), merged.rendering, merged.channels());
        if by_rays {
            self.light.rays.launch(self.device, variant, &arguments)
        } else {
            self.light.sweep.launch(self.device, variant, &arguments)
        }
    }

    /// What absorbs light in layers of an axis: the fields of the scene, or coarse transmittances, which are made of all of them.
    fn absorbers(&mut self, axis: Axis, coarse: Option<&Coarse>) -> Result<Vec<Absorber>, Error> {
        let Some(coarse) = coarse else {
            return self.for_each_absorber(|scene| {
                let layout = scene.weighted(axis, KERNEL)?;
                let gradients = scene.extinction_gradients(axis, &layout)?;
                let visible = scene.visible_blocks(axis, KERNEL)?;
                scene.absorber(axis, layout, gradients, visible)
            });
        };
        let layout = coarse.layout(axis);
        // They are thinned already.
        let gradients = GradientVoxels { layout: layout.clone(), are_separate: false };
        Ok(vec![self.absorber(axis, layout, gradients, coarse.unculled.clone())?])
    }

    fn absorber(
        &mut self,
        axis: Axis,
        layout: Layout,
        gradients: GradientVoxels,
        visible: Arc<VisibleBlocks>,
    ) -> Result<Absorber, Error> {
        let length = self.steps(1).shortest();
        let integrals = self.integrals(KERNEL, length, 1)?;
        let sample = self.light_samples(axis.frame(), ClassificationParams::from_integrals(self, &integrals));
        let region = Region::for_light(self);
        let place = self.placement(axis.frame(), KERNEL, &region, &visible);
        Ok(Absorber { field: FieldInputs { layout, gradients, visible, sample, region, place, length, colors: None }, integrals })
    }

    /// The voxels from which gradients are estimated that change the opacity along rays from a light.
    pub(super) fn extinction_gradients(&mut self, axis: Axis, input: &Layout) -> Result<GradientVoxels, Error> {
        self.estimated_voxels(axis, (KERNEL, extinction_estimator(self.settings)), input)
    }

    /// Sample parameters of rays from a light.
    pub(super) fn light_samples(&self, frame: AxisFrame, classification: ClassificationParams) -> SampleParams {
        let segments = SegmentParams::single(self.settings, self.steps(1), frame);
        let sample = self.sample(frame, classification, segments);
        SampleParams { field: self.field.params(extinction_estimator(self.settings), frame), ..sample }
    }
}

/// A field that absorbs light.
struct Absorber {
    field: FieldInputs,
    integrals: Arc<Integrals>,
}

/// Where and how a sweep stores light.
pub(super) struct Stored<'a> {
    pub volume: &'a Buffer<u8>,
    /// Number of the volume in the buffer.
    pub number: i32,
    pub sums: &'a Buffer<u16>,
    pub sum: Sum,
    pub gain: f64,
    /// Value of a light of 1.
    pub steps: f64,
}

/// The rays of a sweep through some of the layers: their transmittances before and after it.
#[derive(Clone, Copy)]
pub(super) struct State<'a> {
    pub rays: &'a Buffer<f32>,
    /// Whether the rays are dimmed before it, as this state says.
    pub continues: bool,
}
